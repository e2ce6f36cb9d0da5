//! Products and factors of large dense matrices, real or Hermitian.
//!
//! A Hermitian matrix stands in two real parts, so that one recursion (Gustavson, IBM J. Res. Dev. 41, 1997) serves both
//! kinds and nearly all of its work is products of real matrices, for which `nalgebra` has fast kernels. Large products
//! are divided between threads, which does not change a digit.

use super::FiniteElementError;
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};
use std::array::from_fn;

/// A matrix: its real part, and its imaginary one where `P` is 2.
pub type Parts<'a, const P: usize> = [DMatrixView<'a, f64>; P];
/// The same, to be changed.
pub type PartsMut<'a, const P: usize> = [DMatrixViewMut<'a, f64>; P];

/// Columns that are factored entry by entry: with fewer of them the products get too thin, with more the entries take longer.
const BLOCK: usize = 64;
/// Columns of a triangle that are added to as a square.
const SQUARE: usize = 192;
/// Multiplications that are worth a thread of their own.
const TASK: usize = 1 << 25;

/// a b.
pub fn product(a: DMatrixView<'_, f64>, b: DMatrixView<'_, f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    add_real(out.as_view_mut(), 1.0, a, b);
    out
}

/// Adds `factor` a b^H to `out`.
pub fn add_product<const P: usize>(
    out: PartsMut<'_, P>,
    factor: f64,
    a: Parts<'_, P>,
    b: Parts<'_, P>,
) {
    let b = b.map(|part| part.transpose());
    add(out, factor, a, whole(&b));
}

/// Adds `factor` a a^H to the lower triangle of `out`; what stands above means nothing.
pub fn add_gram<const P: usize>(out: PartsMut<'_, P>, factor: f64, a: Parts<'_, P>) {
    let b = a.map(|part| part.transpose());
    add_triangle(out, factor, a, whole(&b));
}

/// Puts the Cholesky factor L of the Hermitian matrix whose lower triangle `a` holds in its place; what stands above means
/// nothing.
///
/// # Errors
/// A matrix that is not positive definite.
pub fn factor<const P: usize>(mut a: PartsMut<'_, P>) -> Result<(), FiniteElementError> {
    let n = a[0].nrows();
    if n <= BLOCK {
        return factor_block(a);
    }
    let at = half(n);
    let (mut left, mut right) = by_columns(&mut a, at);
    let (mut top, mut below) = by_rows(&mut left, at);
    factor(again(&mut top))?;
    solve(seen(&top), again(&mut below));
    let (_, mut rest) = by_rows(&mut right, at);
    add_gram(again(&mut rest), -1.0, seen(&below));
    factor(rest)
}

/// Overwrites `b` by the solution X of X L^H = B, L the lower triangle of `l`.
pub fn solve<const P: usize>(l: Parts<'_, P>, mut b: PartsMut<'_, P>) {
    let (n, rows) = (l[0].nrows(), b[0].nrows());
    if n * n * rows > 2 * TASK && rows > 2 * SQUARE {
        let (above, below) = by_rows(&mut b, rows / 2);
        rayon::join(|| solve(l, above), || solve(l, below));
    } else if n > BLOCK {
        let at = half(n);
        let corner = |row, column, shape| l.each_ref().map(|part| part.view((row, column), shape));
        let (mut left, mut right) = by_columns(&mut b, at);
        solve(corner(0, 0, (at, at)), again(&mut left));
        let beside = corner(at, 0, (n - at, at));
        add_product(again(&mut right), -1.0, seen(&left), beside);
        solve(corner(at, at, (n - at, n - at)), right);
    } else {
        // The factor of a block is as well conditioned as the block, so that its inverse serves.
        let inverse = inverse(l);
        let known = b.each_ref().map(|part| part.clone_owned());
        b.iter_mut().for_each(|part| part.fill(0.0));
        add_product(b, 1.0, whole(&known), whole(&inverse));
    }
}

/// Where `n` columns are divided.
fn half(n: usize) -> usize {
    (n / 2).next_multiple_of(BLOCK).min(n - 1)
}

fn whole<const P: usize>(parts: &[DMatrix<f64>; P]) -> Parts<'_, P> {
    parts.each_ref().map(|part| part.as_view())
}

fn seen<'a, const P: usize>(parts: &'a PartsMut<'_, P>) -> Parts<'a, P> {
    parts.each_ref().map(|part| part.as_view())
}

fn again<'a, const P: usize>(parts: &'a mut PartsMut<'_, P>) -> PartsMut<'a, P> {
    parts.each_mut().map(|part| part.as_view_mut())
}

/// The first `at` columns, and the others.
fn by_columns<'a, const P: usize>(
    parts: &'a mut PartsMut<'_, P>,
    at: usize,
) -> (PartsMut<'a, P>, PartsMut<'a, P>) {
    unzip((parts.each_mut()).map(|part| part.columns_range_pair_mut(..at, at..)))
}

/// The first `at` rows, and the others.
fn by_rows<'a, const P: usize>(
    parts: &'a mut PartsMut<'_, P>,
    at: usize,
) -> (PartsMut<'a, P>, PartsMut<'a, P>) {
    unzip((parts.each_mut()).map(|part| part.rows_range_pair_mut(..at, at..)))
}

fn unzip<T, const P: usize>(pairs: [(T, T); P]) -> ([T; P], [T; P]) {
    let mut pairs = pairs.map(|(first, second)| (Some(first), Some(second)));
    let first = pairs.each_mut().map(|pair| pair.0.take());
    (
        first.map(|part| part.expect("all parts")),
        pairs.map(|pair| pair.1.expect("all parts")),
    )
}

/// Adds `factor` a conj(b) to `out`.
fn add<const P: usize>(mut out: PartsMut<'_, P>, factor: f64, a: Parts<'_, P>, b: Parts<'_, P>) {
    for part in 0..P {
        add_real(out[0].as_view_mut(), factor, a[part], b[part]);
    }
    if P == 2 {
        add_real(out[1].as_view_mut(), factor, a[1], b[0]);
        add_real(out[1].as_view_mut(), -factor, a[0], b[1]);
    }
}

/// Adds `factor` a b to `out`.
fn add_real(
    mut out: DMatrixViewMut<'_, f64>,
    factor: f64,
    a: DMatrixView<'_, f64>,
    b: DMatrixView<'_, f64>,
) {
    let columns = out.ncols();
    if columns >= SQUARE && columns * out.nrows() * a.ncols() > 2 * TASK {
        let at = columns / 2;
        let (left, right) = out.columns_range_pair_mut(..at, at..);
        rayon::join(
            || add_real(left, factor, a, b.columns_range(..at)),
            || add_real(right, factor, a, b.columns_range(at..)),
        );
    } else {
        out.gemm(factor, &a, &b, 1.0);
    }
}

/// As [`add`], in the lower triangle.
fn add_triangle<const P: usize>(
    mut out: PartsMut<'_, P>,
    factor: f64,
    a: Parts<'_, P>,
    b: Parts<'_, P>,
) {
    let n = out[0].ncols();
    if n <= SQUARE {
        return add(out, factor, a, b);
    }
    let at = n / 2;
    let rows = |from, to| a.each_ref().map(|part| part.rows_range(from..to));
    let columns = |from, to| b.each_ref().map(|part| part.columns_range(from..to));
    let (mut left, mut right) = by_columns(&mut out, at);
    let (top, below) = by_rows(&mut left, at);
    let (_, rest) = by_rows(&mut right, at);
    rayon::join(
        || add(below, factor, rows(at, n), columns(0, at)),
        || {
            add_triangle(top, factor, rows(0, at), columns(0, at));
            add_triangle(rest, factor, rows(at, n), columns(at, n));
        },
    );
}

/// x conj(y).
fn times<const P: usize>(x: [f64; P], y: [f64; P]) -> [f64; P] {
    let mut out = [0.0; P];
    out[0] = (0..P).map(|part| x[part] * y[part]).sum();
    if P == 2 {
        out[1] = x[1] * y[0] - x[0] * y[1];
    }
    out
}

/// [`factor`] entry by entry.
fn factor_block<const P: usize>(mut a: PartsMut<'_, P>) -> Result<(), FiniteElementError> {
    let n = a[0].nrows();
    for j in 0..n {
        for k in 0..j {
            let of_row = from_fn(|part| a[part][(j, k)]);
            for i in j..n {
                let less = times::<P>(from_fn(|part| a[part][(i, k)]), of_row);
                (0..P).for_each(|part| a[part][(i, j)] -= less[part]);
            }
        }
        let pivot = a[0][(j, j)];
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(FiniteElementError::NotPositiveDefinite);
        }
        let reciprocal = pivot.sqrt().recip();
        for part in &mut a {
            part.view_mut((j, j), (n - j, 1)).scale_mut(reciprocal);
        }
    }
    Ok(())
}

/// Inverse of the lower triangle of `l`.
fn inverse<const P: usize>(l: Parts<'_, P>) -> [DMatrix<f64>; P] {
    let n = l[0].nrows();
    let mut out = from_fn(|_| DMatrix::zeros(n, n));
    for j in 0..n {
        out[0][(j, j)] = 1.0;
        for k in j..n {
            let reciprocal = l[0][(k, k)].recip();
            // Conjugate.
            let mut of_row = [0.0; P];
            for (part, sign) in [1.0, -1.0].into_iter().take(P).enumerate() {
                out[part][(k, j)] *= reciprocal;
                of_row[part] = sign * out[part][(k, j)];
            }
            for i in k + 1..n {
                let less = times(from_fn(|part| l[part][(i, k)]), of_row);
                (0..P).for_each(|part| out[part][(i, j)] -= less[part]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearmesh::random::Random;
    use nalgebra::Complex;

    /// Neither a multiple of the blocks nor one square.
    const SIZE: usize = 3 * BLOCK + SQUARE + 5;

    fn random(rows: usize, columns: usize) -> [DMatrix<f64>; 2] {
        let mut random = Random::new(7);
        from_fn(|_| DMatrix::from_fn(rows, columns, |_, _| random.within([-1.0, 1.0])))
    }

    fn complex([re, im]: &[DMatrix<f64>; 2]) -> DMatrix<Complex<f64>> {
        re.zip_map(im, Complex::new)
    }

    fn assert_near(found: &DMatrix<Complex<f64>>, expected: &DMatrix<Complex<f64>>) {
        let largest = expected.iter().map(|x| x.norm()).fold(0.0, f64::max);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).norm() < 1e-12 * largest);
        }
    }

    #[test]
    fn factor_and_solution_of_a_hermitian_matrix_are_those_of_nalgebra() {
        let g = random(SIZE, SIZE);
        let mut a = [DMatrix::identity(SIZE, SIZE), DMatrix::zeros(SIZE, SIZE)];
        add_gram(a.each_mut().map(|part| part.as_view_mut()), 1.0, whole(&g));
        let expected = (&complex(&g) * complex(&g).adjoint() + DMatrix::identity(SIZE, SIZE))
            .cholesky()
            .unwrap()
            .l();
        factor(a.each_mut().map(|part| part.as_view_mut())).unwrap();
        let lower = a.each_ref().map(|part| part.lower_triangle());
        assert_near(&complex(&lower), &expected);

        let mut x = random(500, SIZE);
        let b = complex(&x);
        solve(whole(&a), x.each_mut().map(|part| part.as_view_mut()));
        assert_near(&(complex(&x) * expected.adjoint()), &b);
    }

    #[test]
    fn factor_of_a_real_matrix_is_that_of_nalgebra() {
        let [g, _] = random(SIZE, SIZE);
        let mut a = DMatrix::identity(SIZE, SIZE) + &g * g.transpose();
        let expected = a.clone().cholesky().unwrap().l();
        factor([a.as_view_mut()]).unwrap();
        assert!((a.lower_triangle() - &expected).amax() < 1e-12 * expected.amax());
    }

    #[test]
    fn products_add_and_a_gram_fills_the_lower_triangle() {
        let (a, b) = (random(SIZE, 70), random(40, 70));
        let mut out = random(SIZE, 40);
        let expected = complex(&out) + complex(&a) * complex(&b).adjoint() * Complex::from(-2.0);
        let parts = out.each_mut().map(|part| part.as_view_mut());
        add_product(parts, -2.0, whole(&a), whole(&b));
        assert_near(&complex(&out), &expected);

        let mut gram = from_fn(|_| DMatrix::zeros(SIZE, SIZE));
        add_gram(
            gram.each_mut().map(|part| part.as_view_mut()),
            1.0,
            whole(&a),
        );
        let expected = complex(&a) * complex(&a).adjoint();
        assert_near(&complex(&gram).lower_triangle(), &expected.lower_triangle());
        assert_eq!(
            product(a[0].as_view(), b[0].transpose().as_view()).shape(),
            (SIZE, 40)
        );
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        for at in [0, BLOCK + 1, SIZE - 1] {
            let mut a = DMatrix::<f64>::identity(SIZE, SIZE);
            a[(at, at)] = -1.0;
            assert!(factor([a.as_view_mut()]).is_err());
            a[(at, at)] = f64::NAN;
            assert!(factor([a.as_view_mut()]).is_err());
        }
    }
}
