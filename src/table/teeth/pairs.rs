//! Tooth pairs under load beside each other: what is left to each of its approach, and their sum.

use super::coupled::Closing;
use super::linear::{SIZE, solve};
use crate::table::{COORDINATES, Potential};

/// Most tooth pairs in mesh at once.
pub const MOST: usize = SIZE;

/// One tooth pair that may carry.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pair {
    /// Number of the tooth pair.
    pub k: i32,
    /// What errors of its teeth close.
    pub closing: Closing,
    /// Approach, centre distance offset, misalignment, place, before neighbours take of it.
    pub free: [f64; COORDINATES],
    /// Likewise, after.
    pub at: [f64; COORDINATES],
    /// W1 there.
    pub found: Potential,
}

/// Tooth pairs that may carry, ascending.
pub struct Pairs {
    /// The first `count` of them.
    pub all: [Pair; MOST],
    /// How many there are.
    pub count: usize,
    /// What the force on a neighbour takes of the approach, m/N, its slope and second derivative by the misalignment.
    pub coupling: [f64; 3],
}

impl Pairs {
    /// All of them.
    pub fn all(&self) -> &[Pair] {
        &self.all[..self.count]
    }

    /// All of them.
    pub fn all_mut(&mut self) -> &mut [Pair] {
        &mut self.all[..self.count]
    }

    /// Without those that carry nothing: neighbours take of their approach, so that they carry nothing with them, either.
    pub fn drop_idle(&mut self) {
        let mut kept = 0;
        for n in 0..self.count {
            if self.all[n].found.gradient[0] != 0.0 {
                self.all[kept] = self.all[n];
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// Places of the neighbours of the pair at place `n`.
    fn beside(&self, n: usize) -> impl Iterator<Item = usize> {
        let k = self.all[n].k;
        let before = n.checked_sub(1).filter(|&m| self.all[m].k == k - 1);
        let after = Some(n + 1).filter(|&m| m < self.count && self.all[m].k == k + 1);
        before.into_iter().chain(after)
    }

    /// Force on the neighbours of the pair at place `n`, N.
    fn force_beside(&self, n: usize) -> f64 {
        let forces = self
            .beside(n)
            .map(|other| self.all[other].found.gradient[0]);
        forces.sum()
    }

    /// b - c F of each, m, and the largest distance to what they have.
    pub fn left(&self) -> ([f64; MOST], f64) {
        let mut left = [0.0; MOST];
        let mut largest = 0.0f64;
        for (n, pair) in self.all().iter().enumerate() {
            left[n] = pair.free[0] - self.coupling[0] * self.force_beside(n);
            let distance = (left[n] - pair.at[0]).abs();
            // A number that is none must not get lost.
            if distance > largest || distance.is_nan() {
                largest = distance;
            }
        }
        (left, largest)
    }

    /// 1 + c K, K the stiffnesses of neighbours.
    fn matrix(&self) -> [[f64; SIZE]; SIZE] {
        let mut matrix = [[0.0; SIZE]; SIZE];
        for n in 0..self.count {
            matrix[n][n] = 1.0;
            for other in self.beside(n) {
                matrix[n][other] = self.coupling[0] * self.all[other].found.hessian[0][0];
            }
        }
        matrix
    }

    /// Newton's step towards a = b - c F, which is `left` now, and its largest part, m.
    pub fn newton(&self, left: &[f64; MOST]) -> ([f64; MOST], f64) {
        let mut right = [[0.0; 1]; SIZE];
        for (n, pair) in self.all().iter().enumerate() {
            right[n] = [left[n] - pair.at[0]];
        }
        solve(&mut self.matrix(), &mut right, self.count);
        let step: [f64; MOST] = std::array::from_fn(|n| right[n][0]);
        (
            step,
            step.iter().fold(0.0, |largest, s| s.abs().max(largest)),
        )
    }

    /// The last `step`: energy to second order in it, loads to first, by what is known of W1.
    pub fn correct(&mut self, step: &[f64; MOST]) {
        for (pair, step) in self.all_mut().iter_mut().zip(step) {
            let w = &mut pair.found;
            if w.gradient[0] == 0.0 {
                continue;
            }
            pair.at[0] += step;
            let before = w.gradient[0];
            for (row, slope) in w.hessian.iter().zip(&mut w.gradient) {
                *slope += row[0] * step;
            }
            w.value += 0.5 * (before + w.gradient[0]) * step;
        }
    }

    /// Their sum once they have settled, added to `sum`.
    pub fn total(&self, sum: &mut Potential, want_hessian: bool) {
        let mut products = 0.0;
        for (n, pair) in self.all().iter().enumerate() {
            let w = &pair.found;
            sum.value += w.value;
            for (total, own) in sum.gradient.iter_mut().zip(&w.gradient) {
                *total += own;
            }
            sum.gradient[3] += w.gradient[0] * pair.closing.rate;
            products += 0.5 * w.gradient[0] * self.force_beside(n);
        }
        let [c, slope, curvature] = self.coupling;
        sum.value += c * products;
        sum.gradient[2] -= slope * products;
        if want_hessian {
            self.curvatures::<COORDINATES>(&mut sum.hessian);
            sum.hessian[2][2] -= curvature * products;
            for pair in self.all() {
                sum.hessian[3][3] += pair.found.gradient[0] * pair.closing.curvature;
            }
        } else {
            self.curvatures::<1>(&mut sum.hessian);
        }
    }

    /// Second derivatives of the sum by the first `R` coordinates, at fixed rates of closings and a fixed slope of the coupling.
    fn curvatures<const R: usize>(&self, hessian: &mut [[f64; COORDINATES]; COORDINATES]) {
        // Slopes of the coordinates of each pair, that of the approach at fixed loads of its neighbours.
        let mut slopes = [[[0.0; R]; COORDINATES]; MOST];
        for (n, (pair, slopes)) in self.all().iter().zip(&mut slopes).enumerate() {
            for (i, row) in slopes.iter_mut().enumerate().take(R) {
                row[i] = 1.0;
            }
            if R == COORDINATES {
                slopes[0][2] = -self.coupling[1] * self.force_beside(n);
                slopes[0][3] = pair.closing.rate;
            }
        }
        let free = slopes;
        if self.count > 1 {
            let mut right = [[0.0; R]; SIZE];
            for n in 0..self.count {
                right[n] = free[n][0];
                // What the other coordinates of neighbours change in their loads.
                for other in self.beside(n) {
                    let force = &self.all[other].found.hessian[0];
                    for j in 1..COORDINATES {
                        for x in 0..R {
                            right[n][x] -= self.coupling[0] * force[j] * free[other][j][x];
                        }
                    }
                }
            }
            solve(&mut self.matrix(), &mut right, self.count);
            for n in 0..self.count {
                slopes[n][0] = right[n];
            }
        }
        for (n, pair) in self.all().iter().enumerate() {
            let h = &pair.found.hessian;
            for i in 0..COORDINATES {
                for x in 0..R {
                    let along: f64 = (0..COORDINATES).map(|j| h[i][j] * slopes[n][j][x]).sum();
                    for (y, row) in hessian.iter_mut().enumerate().take(R) {
                        row[x] += free[n][i][y] * along;
                    }
                }
            }
        }
    }
}
