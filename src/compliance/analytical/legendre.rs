//! Legendre polynomials along the face.

use nalgebra::DMatrix;

/// The first Legendre polynomials over a length, with the integrals that a plate needs.
#[derive(Debug, Clone)]
pub struct Legendre {
    length: f64,
    count: usize,
    /// Gauss points and weights on -1..1.
    gauss: Vec<(f64, f64)>,
}

impl Legendre {
    /// `count` polynomials over `length`, m.
    pub fn new(length: f64, count: usize) -> Legendre {
        Legendre {
            length,
            count,
            // Cosine waves of up to four half waves per polynomial have to be integrated, too.
            gauss: gauss_points(4 * count + 8),
        }
    }

    /// Number of polynomials.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The length, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// P_j and dP_j/ds at the fraction `f` (0..1) of the length.
    pub fn at(&self, f: f64) -> Vec<(f64, f64)> {
        let t = 2.0 * f - 1.0;
        let mut all = vec![(1.0, 0.0), (t, 1.0)];
        for j in 2..self.count.max(2) {
            let m = j as f64;
            let ((p1, _), (p2, d2)) = (all[j - 1], all[j - 2]);
            // (m) P_m = (2m-1) t P_{m-1} - (m-1) P_{m-2}; P'_m = P'_{m-2} + (2m-1) P_{m-1}.
            all.push((
                ((2.0 * m - 1.0) * t * p1 - (m - 1.0) * p2) / m,
                d2 + (2.0 * m - 1.0) * p1,
            ));
        }
        all.truncate(self.count);
        all.iter()
            .map(|(p, d)| (*p, 2.0 * d / self.length))
            .collect()
    }

    /// Integrals over the length of products of the polynomials (0) and their derivatives (1).
    pub fn products(&self) -> [[DMatrix<f64>; 2]; 2] {
        let n = self.count;
        let mut all = [0, 1].map(|_| [0, 1].map(|_| DMatrix::zeros(n, n)));
        for (t, weight) in &self.gauss {
            let values = self.at(0.5 * (1.0 + t));
            let w = 0.5 * self.length * weight;
            for i in 0..n {
                for j in 0..n {
                    let (a, b) = (values[i], values[j]);
                    all[0][0][(i, j)] += w * a.0 * b.0;
                    all[0][1][(i, j)] += w * a.0 * b.1;
                    all[1][0][(i, j)] += w * a.1 * b.0;
                    all[1][1][(i, j)] += w * a.1 * b.1;
                }
            }
        }
        all
    }

    /// Coefficients by which a load along P_i, given by its work on P_i, excites the cosine of `wave` half
    /// waves of unit mean square, and that cosine moves P_i.
    pub fn cosine(&self, wave: usize) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        for (t, weight) in &self.gauss {
            let f = 0.5 * (1.0 + t);
            let cosine = (std::f64::consts::PI * wave as f64 * f).cos();
            for (sum, (p, _)) in sums.iter_mut().zip(self.at(f)) {
                *sum += 0.5 * self.length * weight * cosine * p;
            }
        }
        let norm = if wave == 0 {
            self.length
        } else {
            0.5 * self.length
        };
        for (j, sum) in sums.iter_mut().enumerate() {
            // The square of P_j integrates to length / (2j + 1).
            *sum *= (2 * j + 1) as f64 / (self.length * norm.sqrt());
        }
        sums
    }
}

/// Gauss-Legendre points and weights on -1..1, by Newton on the polynomial.
pub fn gauss_points(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 1.0;
            for _ in 0..50 {
                let (mut p0, mut p1) = (1.0, x);
                for m in 2..=n {
                    let m = m as f64;
                    (p0, p1) = (p1, ((2.0 * m - 1.0) * x * p1 - (m - 1.0) * p0) / m);
                }
                derivative = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / derivative;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn gauss_points_integrate_polynomials_exactly() {
        for n in [2, 5, 20] {
            let integral: f64 = gauss_points(n)
                .iter()
                .map(|(x, w)| w * x.powi(2 * n as i32 - 2))
                .sum();
            assert_abs_diff_eq!(integral, 2.0 / (2.0 * n as f64 - 1.0), epsilon = 1e-14);
        }
    }

    #[test]
    fn polynomials_are_orthogonal_and_cosines_complete() {
        let l = Legendre::new(3.0, 6);
        let mass = &l.products()[0][0];
        for i in 0..6 {
            for j in 0..6 {
                let exact = if i == j {
                    3.0 / (2 * i + 1) as f64
                } else {
                    0.0
                };
                assert_abs_diff_eq!(mass[(i, j)], exact, epsilon = 1e-13);
            }
        }
        // Parseval: the cosines together see all of P_2 over its norm squared.
        let seen: f64 = (0..24).map(|w| l.cosine(w)[2].powi(2)).sum();
        assert_abs_diff_eq!(seen, 5.0 / 3.0, epsilon = 1e-3);
    }
}
