//! Cholesky factorisation of small dense matrices, in place, without allocation.
//!
//! The contact solve factors matrices of 30 to 120 rows a few times per solve, where the set-up of a
//! general library costs as much as the factorisation.

use std::hint::black_box;

use crate::table::widest;

/// U of A = U' U, row by row, rows in whole groups of lanes; the rows added for that are those of a unit matrix. What is
/// below the diagonal means nothing.
#[derive(Debug, Clone, Default)]
pub struct Cholesky {
    /// Groups of a row.
    groups: usize,
    u: Vec<Lanes>,
}

/// Numbers that are combined at once, and rows that are eliminated together: each entry of the rest is read and written once
/// for all of them.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Dot product in eight independent sums, which the compiler can vectorise.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((a, a_rest), (b, b_rest)) = (a[..n].as_chunks::<8>(), b[..n].as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let mut rest = 0.0;
    for (a, b) in a_rest.iter().zip(b_rest) {
        rest += a * b;
    }
    let [low, high] = [0, 4].map(|i| [sums[i], sums[i + 1], sums[i + 2], sums[i + 3]]);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| low[i] + high[i]);
    rest + ((a + c) + (b + d))
}

/// `out` += the sum of `rows`, which are as long, times `weights`.
#[inline(always)]
fn add_rows(out: &mut [Lanes], weights: Lanes, rows: [&[Lanes]; LANES]) {
    let count = out.len();
    let [a, b, c, d] = rows;
    let (a, b, c, d) = (&a[..count], &b[..count], &c[..count], &d[..count]);
    for place in 0..count {
        // Groups one by one: left to itself the compiler takes several at once, lane by lane, with more shuffles than sums.
        let place = black_box(place).min(count - 1);
        let (out, a, b, c, d) = (&mut out[place], a[place], b[place], c[place], d[place]);
        for lane in 0..LANES {
            out[lane] += (weights[0] * a[lane] + weights[1] * b[lane])
                + (weights[2] * c[lane] + weights[3] * d[lane]);
        }
    }
}

/// Subtracts, from the group `begin` on, from each of four `rows` the sum of the rows `above` times what they hold in its
/// column, the lane of their first group.
#[inline(always)]
fn subtract_products(rows: &mut [Lanes], begin: usize, [a, b, c, d]: [&[Lanes]; LANES]) {
    let count = a.len();
    let (b, c, d) = (&b[..count], &c[..count], &d[..count]);
    let (i, rows) = rows.split_at_mut(rows.len() / LANES);
    let (j, rows) = rows.split_at_mut(i.len());
    let (k, l) = rows.split_at_mut(i.len());
    let (i, j) = (&mut i[begin..][..count], &mut j[begin..][..count]);
    let (k, l) = (&mut k[begin..][..count], &mut l[begin..][..count]);
    let (u, v, w, x) = (a[0], b[0], c[0], d[0]);
    for place in 0..count {
        let place = black_box(place).min(count - 1);
        let (a, b, c, d) = (a[place], b[place], c[place], d[place]);
        let less = |row: &mut Lanes, of: usize| {
            for lane in 0..LANES {
                row[lane] -=
                    (u[of] * a[lane] + v[of] * b[lane]) + (w[of] * c[lane] + x[of] * d[lane]);
            }
        };
        less(&mut i[place], 0);
        less(&mut j[place], 1);
        less(&mut k[place], 2);
        less(&mut l[place], 3);
    }
}

/// `out` = A `x`, A symmetric, row by row.
pub fn multiply(a: &[f64], x: &[f64], out: &mut [f64]) {
    let n = x.len();
    out.fill(0.0);
    widest(
        #[inline(always)]
        || {
            // Columns, which are rows: those that count.
            let mut counting = (0..n).filter(|&j| x[j] != 0.0);
            while let Some(first) = counting.next() {
                let (mut rows, mut weights) = ([&a[..n]; LANES], [0.0; LANES]);
                let taken = std::iter::once(first).chain(counting.by_ref());
                for (k, j) in taken.take(LANES).enumerate() {
                    rows[k] = &a[j * n..(j + 1) * n];
                    weights[k] = x[j];
                }
                let (groups, rest) = out.as_chunks_mut();
                let [i, j, k, l] = [rows[0], rows[1], rows[2], rows[3]];
                let whole = [i.as_chunks(), j.as_chunks(), k.as_chunks(), l.as_chunks()];
                add_rows(
                    groups,
                    weights,
                    [whole[0].0, whole[1].0, whole[2].0, whole[3].0],
                );
                for (place, out) in rest.iter_mut().enumerate() {
                    *out += (weights[0] * whole[0].1[place] + weights[1] * whole[1].1[place])
                        + (weights[2] * whole[2].1[place] + weights[3] * whole[3].1[place]);
                }
            }
        },
    );
}

impl Cholesky {
    /// Factors the `n` x `n` matrix whose lower triangle `entry(row, column)` gives.
    ///
    /// # Errors
    /// The index of the first pivot that is not positive.
    pub fn factor(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) -> Result<(), usize> {
        self.factor_rows(n, |i, row| {
            (i..n).zip(row).for_each(|(j, place)| *place = entry(j, i));
        })
    }

    /// Factors the symmetric `n` x `n` matrix of which `fill` writes row i from the diagonal on.
    ///
    /// # Errors
    /// The index of the first pivot that is not positive.
    pub fn factor_rows(&mut self, n: usize, fill: impl Fn(usize, &mut [f64])) -> Result<(), usize> {
        let groups = n.div_ceil(LANES);
        self.groups = groups;
        self.u.resize(groups * groups * LANES, [0.0; LANES]);
        for (i, row) in self.u.chunks_exact_mut(groups.max(1)).enumerate() {
            let places = row.as_flattened_mut();
            places[n..].fill(0.0);
            if i < n {
                fill(i, &mut places[i..n]);
            } else {
                places[i] = 1.0;
            }
        }
        widest(
            #[inline(always)]
            || self.eliminate(),
        )
    }

    #[inline(always)]
    fn eliminate(&mut self) -> Result<(), usize> {
        let groups = self.groups;
        for first in 0..groups {
            let (block, rest) = self.u[first * LANES * groups..].split_at_mut(LANES * groups);
            let (a, block) = block.split_at_mut(groups);
            let (b, block) = block.split_at_mut(groups);
            let (c, d) = block.split_at_mut(groups);
            let (a, b, c, d) = (
                &mut a[first..],
                &mut b[first..],
                &mut c[first..],
                &mut d[first..],
            );
            // The square on the diagonal, which holds the reciprocals.
            let mut square = [a[0], b[0], c[0], d[0]];
            for p in 0..LANES {
                let pivot = square[p][p];
                if pivot.is_nan() || pivot <= 0.0 {
                    return Err(first * LANES + p);
                }
                let reciprocal = pivot.sqrt().recip();
                square[p][p + 1..].iter_mut().for_each(|u| *u *= reciprocal);
                for r in p + 1..LANES {
                    for q in r..LANES {
                        square[r][q] -= square[p][r] * square[p][q];
                    }
                }
                square[p][p] = reciprocal;
            }
            let [u, v, w, x] = square;
            [a[0], b[0], c[0], d[0]] = square;
            let count = a.len();
            let (b, c, d) = (&mut b[..count], &mut c[..count], &mut d[..count]);
            for place in 1..count {
                let place = black_box(place).min(count - 1);
                let [mut p, mut q, mut r, mut s] = [a[place], b[place], c[place], d[place]];
                for lane in 0..LANES {
                    p[lane] *= u[0];
                    q[lane] = (q[lane] - u[1] * p[lane]) * v[1];
                    r[lane] = (r[lane] - u[2] * p[lane] - v[2] * q[lane]) * w[2];
                    let known = u[3] * p[lane] + v[3] * q[lane] + w[3] * r[lane];
                    s[lane] = (s[lane] - known) * x[3];
                }
                (a[place], b[place], c[place], d[place]) = (p, q, r, s);
            }
            for (below, rows) in rest.chunks_exact_mut(LANES * groups).enumerate() {
                // From the group of the diagonal on.
                let group = 1 + below;
                let above = [&a[group..], &b[group..], &c[group..], &d[group..]];
                subtract_products(rows, first + group, above);
            }
        }
        Ok(())
    }

    /// Row `i` from the group `from` on.
    #[inline(always)]
    fn row(&self, i: usize, from: usize) -> &[Lanes] {
        &self.u[i * self.groups + from..(i + 1) * self.groups]
    }

    /// Overwrites `x` with the solution of A y = x.
    pub fn solve(&self, x: &mut [f64]) {
        let mut y = vec![[0.0; LANES]; self.groups];
        let places = y.as_flattened_mut();
        places[..x.len()].copy_from_slice(x);
        widest(
            #[inline(always)]
            || self.substitute(&mut y),
        );
        x.copy_from_slice(&y.as_flattened()[..x.len()]);
    }

    #[inline(always)]
    fn substitute(&self, y: &mut [Lanes]) {
        for first in 0..self.groups {
            let i = first * LANES;
            let rows = [
                self.row(i, first),
                self.row(i + 1, first),
                self.row(i + 2, first),
                self.row(i + 3, first),
            ];
            let (now, later) = y[first..].split_at_mut(1);
            let now = &mut now[0];
            for p in 0..LANES {
                now[p] *= rows[p][0][p];
                for q in p + 1..LANES {
                    now[q] -= rows[p][0][q] * now[p];
                }
            }
            let [a, b, c, d] = rows;
            let weights = [-now[0], -now[1], -now[2], -now[3]];
            add_rows(later, weights, [&a[1..], &b[1..], &c[1..], &d[1..]]);
        }
        for first in (0..self.groups).rev() {
            let i = first * LANES;
            let (now, later) = y[first..].split_at_mut(1);
            let now = &mut now[0];
            for p in (0..LANES).rev() {
                let row = self.row(i + p, first);
                let mut sums = [0.0; LANES];
                for (u, y) in row[1..].iter().zip(&*later) {
                    for lane in 0..LANES {
                        sums[lane] += u[lane] * y[lane];
                    }
                }
                let mut known = (sums[0] + sums[2]) + (sums[1] + sums[3]);
                for q in p + 1..LANES {
                    known += row[0][q] * now[q];
                }
                now[p] = (now[p] - known) * row[0][p];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_system_of_known_solution() {
        let n = 37;
        let entry = |i: usize, j: usize| {
            (-0.1 * (i as f64 - j as f64).powi(2)).exp() + if i == j { 0.3 } else { 0.0 }
        };
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut y: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum())
            .collect();
        let mut factor = Cholesky::default();
        factor.factor(n, entry).unwrap();
        factor.solve(&mut y);
        for (a, b) in x.iter().zip(&y) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_at_its_pivot() {
        let mut factor = Cholesky::default();
        let entry = |i: usize, j: usize| {
            if i == j && i == 2 {
                -1.0
            } else {
                f64::from(i == j)
            }
        };
        assert_eq!(factor.factor(4, entry), Err(2));
        assert_eq!(factor.factor(1, |_, _| f64::NAN), Err(0));
    }
}
