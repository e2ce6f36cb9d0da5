//! Elimination of unknowns from large dense matrices, real or Hermitian.
//!
//! With `W` = 2 matrices are complex: each column is a real one followed by an imaginary one. So nearly all the work of both kinds
//! is products of real matrices, for which `nalgebra` has fast kernels. Large products are divided between threads, which
//! does not change a digit.

use super::error::FiniteElementError;
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

/// Unknowns that are eliminated one by one: fewer make the products too thin, more take longer themselves.
const BLOCK: usize = 16;
/// Columns that are one task, and in a triangle are taken as a rectangle.
const TASK: usize = 192;

pub fn product(a: DMatrixView<'_, f64>, b: DMatrixView<'_, f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    add_product(out.as_view_mut(), a, b);
    out
}

/// Eliminates the first unknowns of the Hermitian matrix
///
/// ```text
/// [ A  B^H ]
/// [ B  C   ]     columns = [A; B], rest = C
/// ```
///
/// of which the lower triangle is read and written: `columns` become [L; B L^-H] with the Cholesky factor L of A, and
/// `rest` becomes C - B A^-1 B^H. Trailing columns of C may be left out.
///
/// # Errors
/// A is not positive definite.
pub fn eliminate<const W: usize>(
    columns: &mut DMatrix<f64>,
    rest: &mut DMatrix<f64>,
) -> Result<(), FiniteElementError> {
    let own = columns.ncols() / W;
    factor::<W>(columns.as_view_mut())?;
    subtract_gram::<W>(rest.as_view_mut(), columns.rows_range(own..));
    Ok(())
}

/// Turns `a` = [A; B] into [L; B L^-H] by halves (Gustavson, IBM J. Res. Dev. 41, 1997).
fn factor<const W: usize>(mut a: DMatrixViewMut<'_, f64>) -> Result<(), FiniteElementError> {
    let n = a.ncols() / W;
    if n <= BLOCK {
        return factor_block::<W>(a);
    }
    let half = n / 2;
    let (mut left, mut right) = a.columns_range_pair_mut(..W * half, W * half..);
    factor::<W>(left.as_view_mut())?;
    let mut right = right.rows_range_mut(half..);
    subtract_gram::<W>(right.as_view_mut(), left.rows_range(half..));
    factor::<W>(right)
}

fn factor_block<const W: usize>(mut a: DMatrixViewMut<'_, f64>) -> Result<(), FiniteElementError> {
    let n = a.ncols() / W;
    for j in 0..n {
        let pivot = a[(j, W * j)];
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(FiniteElementError::NotPositiveDefinite);
        }
        let (mut own, mut later) = a.columns_range_pair_mut(W * j..W * (j + 1), W * (j + 1)..);
        own.rows_range_mut(j..).scale_mut(pivot.sqrt().recip());
        for k in j + 1..n {
            for part in 0..W {
                let mut column = later.column_mut(W * (k - j - 1) + part);
                for of in 0..W {
                    let conjugate = match (of, part) {
                        (0, 1) => -own[(k, 1)],
                        (1, 1) => own[(k, 0)],
                        _ => own[(k, of)],
                    };
                    let mut below = column.rows_range_mut(k..);
                    below.axpy(-conjugate, &own.column(of).rows_range(k..), 1.0);
                }
            }
        }
    }
    Ok(())
}

/// Subtracts the leading columns of a a^H from `out`, of which the lower triangle counts.
fn subtract_gram<const W: usize>(mut out: DMatrixViewMut<'_, f64>, a: DMatrixView<'_, f64>) {
    let n = out.ncols() / W;
    if n <= TASK {
        let first = adjoint::<W>(a.rows_range(..n));
        return out.gemm(-1.0, &a, &first, 1.0);
    }
    let half = n / 2;
    let (left, mut right) = out.columns_range_pair_mut(..W * half, W * half..);
    let right = right.rows_range_mut(half..);
    rayon::join(
        || subtract_gram::<W>(left, a),
        || subtract_gram::<W>(right, a.rows_range(half..)),
    );
}

/// b^H, so that its product with a matrix of pairs of columns is one of pairs of columns.
fn adjoint<const W: usize>(b: DMatrixView<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(b.ncols(), W * b.nrows(), |i, j| match (i % W, j % W) {
        (0, 1) => -b[(j / W, i + 1)],
        (1, 1) => b[(j / W, i - 1)],
        _ => b[(j / W, i)],
    })
}

fn add_product(mut out: DMatrixViewMut<'_, f64>, a: DMatrixView<'_, f64>, b: DMatrixView<'_, f64>) {
    let n = out.ncols();
    if n <= TASK {
        return out.gemm(1.0, &a, &b, 1.0);
    }
    let (left, right) = out.columns_range_pair_mut(..n / 2, n / 2..);
    rayon::join(
        || add_product(left, a, b.columns_range(..n / 2)),
        || add_product(right, a, b.columns_range(n / 2..)),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearmesh::random::Random;
    use nalgebra::Complex;

    /// Eliminated unknowns, all unknowns and those whose Schur complement is asked for: no multiples of blocks and tasks.
    const SIZES: [usize; 3] = [TASK + 4 * BLOCK + 5, 2 * TASK + 150, 2 * TASK + 100];

    fn random(rows: usize, columns: usize) -> DMatrix<f64> {
        let mut random = Random::new(7);
        DMatrix::from_fn(rows, columns, |_, _| random.within([-1.0, 1.0]))
    }

    /// The complex matrix of pairs of columns.
    fn complex(a: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
        DMatrix::from_fn(a.nrows(), a.ncols() / 2, |i, j| {
            Complex::new(a[(i, 2 * j)], a[(i, 2 * j + 1)])
        })
    }

    fn pairs(a: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        DMatrix::from_fn(a.nrows(), 2 * a.ncols(), |i, j| match j % 2 {
            0 => a[(i, j / 2)].re,
            _ => a[(i, j / 2)].im,
        })
    }

    #[test]
    fn what_is_left_of_a_hermitian_matrix_is_its_schur_complement() {
        let [own, n, some] = SIZES;
        let g = complex(&random(n, 2 * n));
        let a = &g * g.adjoint() + DMatrix::identity(n, n);
        let inner = a.view((0, 0), (own, own)).clone_owned().cholesky().unwrap();
        let below = a.view((own, 0), (n - own, own));
        let schur = a.view((own, own), (n - own, n - own)) - below * inner.solve(&below.adjoint());
        let mut columns = pairs(&a.columns(0, own).clone_owned());
        let mut rest = pairs(&a.view((own, own), (n - own, some - own)).clone_owned());
        eliminate::<2>(&mut columns, &mut rest).unwrap();
        let largest = schur.iter().map(|x| x.norm()).fold(0.0, f64::max);
        let found = complex(&rest);
        for j in 0..some - own {
            for i in j..n - own {
                assert!((found[(i, j)] - schur[(i, j)]).norm() < 1e-12 * largest);
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        let n = SIZES[0];
        for at in [0, BLOCK + 1, n - 1] {
            for bad in [-1.0, f64::NAN] {
                let mut a = DMatrix::<f64>::identity(n, n);
                a[(at, at)] = bad;
                assert!(eliminate::<1>(&mut a, &mut DMatrix::zeros(0, 0)).is_err());
            }
        }
    }
}
