//! Cholesky factorisation of small dense matrices, in place, without allocation.
//!
//! The contact solve factors matrices of 30 to 120 rows a few times per solve, where the set-up of a
//! general library costs as much as the factorisation.

use crate::table::widest;

/// U of A = U' U, row by row with the stride `n`; what is below the diagonal means nothing.
#[derive(Debug, Clone, Default)]
pub struct Cholesky {
    n: usize,
    u: Vec<f64>,
}

/// Rows that are eliminated together: each entry of the rest is read and written once for all of them.
const BLOCK: usize = 4;

/// Dot product in eight independent sums, which the compiler can vectorise.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; 8];
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca
        .remainder()
        .iter()
        .zip(cb.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in ca.zip(cb) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    tail + ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]))
}

/// `out` = A `x`, A row by row.
pub fn multiply(a: &[f64], x: &[f64], out: &mut [f64]) {
    widest(
        #[inline(always)]
        || {
            for (row, out) in a.chunks_exact(x.len().max(1)).zip(out) {
                *out = dot(row, x);
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
        self.n = n;
        if self.u.len() < n * n {
            self.u.resize(n * n, 0.0);
        }
        for (i, row) in self.u.chunks_exact_mut(n.max(1)).take(n).enumerate() {
            for (j, place) in row.iter_mut().enumerate().skip(i) {
                *place = entry(j, i);
            }
        }
        widest(
            #[inline(always)]
            || self.eliminate(),
        )
    }

    #[inline(always)]
    fn eliminate(&mut self) -> Result<(), usize> {
        let n = self.n;
        for first in (0..n).step_by(BLOCK) {
            let count = BLOCK.min(n - first);
            let (block, rest) = self.u[first * n..n * n].split_at_mut(count * n);
            for p in 0..count {
                let (row, below) = block[p * n..].split_at_mut(n);
                let row = &mut row[first + p..];
                if row[0].is_nan() || row[0] <= 0.0 {
                    return Err(first + p);
                }
                let reciprocal = row[0].sqrt().recip();
                row.iter_mut().for_each(|entry| *entry *= reciprocal);
                // The diagonal holds the reciprocals.
                row[0] = reciprocal;
                for q in 1..count - p {
                    let factor = row[q];
                    let other = &mut below[(q - 1) * n + first + p + q..q * n];
                    for (entry, u) in other.iter_mut().zip(&row[q..]) {
                        *entry -= factor * u;
                    }
                }
            }
            for (i, row) in rest.chunks_exact_mut(n).enumerate() {
                let i = first + BLOCK + i;
                let above: [&[f64]; BLOCK] = std::array::from_fn(|p| &block[p * n + i..][..n - i]);
                let factors = above.map(|row| row[0]);
                let [a, b, c, d] = above;
                let above = a.iter().zip(b).zip(c.iter().zip(d));
                for (entry, ((a, b), (c, d))) in row[i..].iter_mut().zip(above) {
                    *entry -= (factors[0] * a + factors[1] * b) + (factors[2] * c + factors[3] * d);
                }
            }
        }
        Ok(())
    }

    /// Overwrites `x` with the solution of A y = x.
    pub fn solve(&self, x: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                let n = self.n;
                let x = &mut x[..n];
                for i in 0..n {
                    let row = &self.u[i * n + i..(i + 1) * n];
                    let (xi, rest) = x[i..].split_first_mut().expect("i < n");
                    *xi *= row[0];
                    for (target, u) in rest.iter_mut().zip(&row[1..]) {
                        *target -= u * *xi;
                    }
                }
                for i in (0..n).rev() {
                    let row = &self.u[i * n + i..(i + 1) * n];
                    x[i] = (x[i] - dot(&row[1..], &x[i + 1..])) * row[0];
                }
            },
        );
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
