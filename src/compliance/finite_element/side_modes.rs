//! How loads on the flank act on the sides of their sector, in as few modes as that takes.
//!
//! The flank is some way off the sides, so that loads on neighbouring nodes act on them nearly alike (Saint-Venant):
//! of two thousand flank nodes a third are told apart to nine digits. G = Q B with orthonormal columns of Q is found
//! from products of G with random vectors (Halko, Martinsson, Tropp, SIAM Review 53, 2011, algorithm 4.2), the same
//! ones in every run.

use super::dense::product;
use crate::random::Random;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// What is left out of G over its largest product with a vector of the same random numbers.
const LEFT_OUT: f64 = 1e-8;
/// Modes that are sought at a time.
const BLOCK: usize = 64;

/// G = `modes` * `shares`.
pub(super) struct SideModes {
    /// Q: forces on both sides in each mode, as many rows as the side loads.
    pub modes: Mat<f64>,
    /// B: how much of each mode each load brings, modes by loads.
    pub shares: Mat<f64>,
}

impl SideModes {
    /// Of the side loads `g`, a column for each load.
    pub fn new(g: &Mat<f64>) -> SideModes {
        let (rows, loads) = (g.nrows(), g.ncols());
        let most = rows.min(loads);
        let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
        let mut modes = Mat::<f64>::zeros(rows, 0);
        let mut largest = 0.0;
        while modes.ncols() < most {
            let block = BLOCK.min(most - modes.ncols());
            let trial = Mat::from_fn(loads, block, |_, _| random.within([-1.0, 1.0]));
            let mut y = product(g.as_ref(), trial.as_ref(), Par::rayon(0));
            largest = longest(&y).max(largest);
            remove(&modes, &mut y);
            if longest(&y) <= LEFT_OUT * largest {
                break;
            }
            let mut new = y.qr().compute_thin_Q();
            // Once more: what rounding left of the modes before.
            remove(&modes, &mut new);
            let new = new.qr().compute_thin_Q();
            let old = modes.ncols();
            modes = Mat::from_fn(rows, old + block, |i, j| {
                if j < old {
                    modes[(i, j)]
                } else {
                    new[(i, j - old)]
                }
            });
        }
        let shares = product(modes.transpose(), g.as_ref(), Par::rayon(0));
        SideModes { modes, shares }
    }
}

/// y := y - Q Q^T y.
fn remove(modes: &Mat<f64>, y: &mut Mat<f64>) {
    if modes.ncols() == 0 {
        return;
    }
    let share = product(modes.transpose(), y.as_ref(), Par::rayon(0));
    matmul(y.as_mut(), Accum::Add, modes, &share, -1.0, Par::rayon(0));
}

/// Length of the longest column.
fn longest(y: &Mat<f64>) -> f64 {
    (0..y.ncols())
        .map(|j| y.col(j).norm_l2())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_loads_are_few_modes_and_come_back() {
        // Loads that act with a decay length of a few rows.
        let g = Mat::from_fn(300, 200, |i, j| {
            let apart = i as f64 / 300.0 - j as f64 / 200.0;
            1.0 / (1.0 + 4.0 * apart * apart)
        });
        let found = SideModes::new(&g);
        assert!(found.modes.ncols() < 100, "{}", found.modes.ncols());
        let back = product(found.modes.as_ref(), found.shares.as_ref(), Par::Seq);
        for j in 0..200 {
            for i in 0..300 {
                assert!((back[(i, j)] - g[(i, j)]).abs() < 1e-7);
            }
        }
        let unit = product(found.modes.transpose(), found.modes.as_ref(), Par::Seq);
        for j in 0..unit.ncols() {
            for i in 0..unit.nrows() {
                let expected = f64::from(u8::from(i == j));
                assert!((unit[(i, j)] - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn loads_that_are_all_different_keep_all_their_modes() {
        let g = Mat::from_fn(40, 30, |i, j| f64::from(u8::from(i == j)));
        let found = SideModes::new(&g);
        let back = product(found.modes.as_ref(), found.shares.as_ref(), Par::Seq);
        for j in 0..30 {
            for i in 0..40 {
                assert!((back[(i, j)] - g[(i, j)]).abs() < 1e-12);
            }
        }
        let none = SideModes::new(&Mat::zeros(0, 3));
        assert_eq!(none.shares.nrows(), 0);
    }
}
