//! How loads on the flank act on the sides of their sector, in as few modes as that takes.
//!
//! The flank is some way off the sides, so that loads on neighbouring nodes act on them nearly alike (Saint-Venant):
//! of two thousand flank nodes a third are told apart to nine digits. G = Q B with orthonormal columns of Q is found
//! from products of G with random vectors (Halko, Martinsson, Tropp, SIAM Review 53, 2011, algorithm 4.2), the same
//! ones in every run.

use super::dense::product;
use gearmesh::random::Random;
use nalgebra::DMatrix;

/// What is left out of G over its largest product with a vector of the same random numbers.
pub(super) const LEFT_OUT: f64 = 1e-8;
/// Modes that are sought at a time.
const BLOCK: usize = 64;

/// G = `modes` * `shares`.
pub(super) struct SideModes {
    /// Q: forces on both sides in each mode, as many rows as the side loads.
    pub modes: DMatrix<f64>,
    /// B: how much of each mode each load brings, modes by loads.
    pub shares: DMatrix<f64>,
}

impl SideModes {
    /// Of the side loads `g`, a column for each load.
    pub fn new(g: &DMatrix<f64>) -> SideModes {
        let (rows, loads) = (g.nrows(), g.ncols());
        let most = rows.min(loads);
        let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
        let mut modes = DMatrix::<f64>::zeros(rows, 0);
        let mut largest = 0.0;
        while modes.ncols() < most {
            let block = BLOCK.min(most - modes.ncols());
            let trial = DMatrix::from_fn(loads, block, |_, _| random.within([-1.0, 1.0]));
            let mut y = product(g.as_view(), trial.as_view());
            largest = longest(&y).max(largest);
            remove(&modes, &mut y);
            if longest(&y) <= LEFT_OUT * largest {
                break;
            }
            let mut new = y.qr().q();
            // Once more: what rounding left of the modes before.
            remove(&modes, &mut new);
            let new = new.qr().q();
            let old = modes.ncols();
            modes = modes.resize_horizontally(old + block, 0.0);
            modes.columns_range_mut(old..).copy_from(&new);
        }
        let shares = product(modes.transpose().as_view(), g.as_view());
        SideModes { modes, shares }
    }
}

/// y := y - Q Q^T y.
fn remove(modes: &DMatrix<f64>, y: &mut DMatrix<f64>) {
    if modes.ncols() == 0 {
        return;
    }
    let share = product(modes.transpose().as_view(), y.as_view());
    *y -= product(modes.as_view(), share.as_view());
}

/// Length of the longest column.
fn longest(y: &DMatrix<f64>) -> f64 {
    (0..y.ncols())
        .map(|j| y.column(j).norm())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_loads_are_few_modes_and_come_back() {
        // Loads that act with a decay length of a few rows.
        let g = DMatrix::from_fn(300, 200, |i, j| {
            let apart = i as f64 / 300.0 - j as f64 / 200.0;
            1.0 / (1.0 + 4.0 * apart * apart)
        });
        let found = SideModes::new(&g);
        assert!(found.modes.ncols() < 100, "{}", found.modes.ncols());
        let back = product(found.modes.as_view(), found.shares.as_view());
        for j in 0..200 {
            for i in 0..300 {
                assert!((back[(i, j)] - g[(i, j)]).abs() < 1e-7);
            }
        }
        let unit = product(found.modes.transpose().as_view(), found.modes.as_view());
        for j in 0..unit.ncols() {
            for i in 0..unit.nrows() {
                let expected = f64::from(u8::from(i == j));
                assert!((unit[(i, j)] - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn loads_that_are_all_different_keep_all_their_modes() {
        let g = DMatrix::from_fn(40, 30, |i, j| f64::from(u8::from(i == j)));
        let found = SideModes::new(&g);
        let back = product(found.modes.as_view(), found.shares.as_view());
        for j in 0..30 {
            for i in 0..40 {
                assert!((back[(i, j)] - g[(i, j)]).abs() < 1e-12);
            }
        }
        let none = SideModes::new(&DMatrix::zeros(0, 3));
        assert_eq!(none.shares.nrows(), 0);
    }
}
