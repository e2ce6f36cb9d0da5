//! Cholesky factorisation of small dense matrices, in place, without allocation.
//!
//! The contact solve factors matrices of 30 to 120 rows some ten times per solve, where the set-up of a
//! general library costs as much as the factorisation.

/// Lower triangle of a symmetric matrix, rows one after the other with the stride `n`.
#[derive(Debug, Clone, Default)]
pub struct Cholesky {
    n: usize,
    l: Vec<f64>,
}

/// Dot product in four independent sums, which the compiler can vectorise.
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

impl Cholesky {
    /// Factors the `n` x `n` matrix whose lower triangle `entry(row, column)` gives.
    ///
    /// # Errors
    /// The index of the first pivot that is not positive.
    pub fn factor(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) -> Result<(), usize> {
        self.n = n;
        self.l.clear();
        self.l.resize(n * n, 0.0);
        for i in 0..n {
            let (above, row) = self.l.split_at_mut(i * n);
            let row = &mut row[..=i];
            for j in 0..i {
                let other = &above[j * n..j * n + j];
                // The diagonal holds the reciprocals.
                row[j] = (entry(i, j) - dot(&row[..j], other)) * above[j * n + j];
            }
            let pivot = entry(i, i) - dot(&row[..i], &row[..i]);
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(i);
            }
            row[i] = pivot.sqrt().recip();
        }
        Ok(())
    }

    /// Overwrites `x` with the solution of A y = x.
    pub fn solve(&self, x: &mut [f64]) {
        let n = self.n;
        for i in 0..n {
            let row = &self.l[i * n..i * n + i];
            x[i] = (x[i] - dot(row, &x[..i])) * self.l[i * n + i];
        }
        for i in (0..n).rev() {
            x[i] *= self.l[i * n + i];
            let xi = x[i];
            let row = &self.l[i * n..i * n + i];
            for (target, l) in x[..i].iter_mut().zip(row) {
                *target -= l * xi;
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
