//! Tooth pairs that share a load: the approach of each under the forces on the others, and the sum of their potentials.

use crate::table::{COORDINATES, Potential};
use nalgebra::SMatrix;

/// Most tooth pairs in mesh at once.
pub const MOST: usize = 8;

/// Coupling compliance of two tooth pairs by how many base pitches they are apart, m/N, with its first and second derivative by the
/// misalignment; at 0 nothing.
pub type Compliances = [[f64; 3]; MOST];

/// One tooth pair that may carry.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pair {
    /// Number of the tooth pair.
    pub k: i32,
    /// Slope by mesh position of what errors of its teeth close, m.
    pub closing_rate: f64,
    /// Approach, centre distance offset, misalignment and place, without the deflection under the forces on the others.
    pub free: [f64; COORDINATES],
    /// Likewise, with it.
    pub at: [f64; COORDINATES],
    /// W1 there.
    pub potential: Potential,
}

/// Tooth pairs that may carry, ascending.
pub struct Pairs {
    /// The first `count` of them.
    pub all: [Pair; MOST],
    /// How many there are.
    pub count: usize,
    /// How the force on one deflects the others.
    pub coupling: Compliances,
}

impl Pairs {
    /// All of them.
    pub fn all(&self) -> &[Pair] {
        &self.all[..self.count]
    }

    /// Without those that carry nothing alone: the forces on others take of their approach, so they carry nothing then, either.
    pub fn drop_idle(&mut self) {
        let carrying = self.all.into_iter().take(self.count);
        let carrying = carrying.filter(|pair| pair.potential.gradient[0] != 0.0);
        self.count = 0;
        for pair in carrying {
            self.all[self.count] = pair;
            self.count += 1;
        }
    }

    /// Between the `n`th pair and that with the index `other`, as [`Compliances`].
    fn compliance(&self, n: usize, other: usize) -> [f64; 3] {
        self.coupling[self.all[n].k.abs_diff(self.all[other].k) as usize]
    }

    /// Deflection of the `n`th pair under the forces on all others as they are, m, and its first and second derivative by the
    /// misalignment.
    fn deflection(&self, n: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (other, pair) in self.all().iter().enumerate() {
            let by = self.compliance(n, other);
            for d in 0..3 {
                sum[d] += by[d] * pair.potential.gradient[0];
            }
        }
        sum
    }

    /// Approach b - C F that remains to each, m, and the complementary energy, J, least where they have just that.
    pub fn remaining(&self) -> ([f64; MOST], f64) {
        let mut remaining = [0.0; MOST];
        let mut energy = 0.0;
        for (n, pair) in self.all().iter().enumerate() {
            let [deflection, ..] = self.deflection(n);
            remaining[n] = pair.free[0] - deflection;
            let force = pair.potential.gradient[0];
            energy += (pair.at[0] + 0.5 * deflection - pair.free[0]) * force - pair.potential.value;
        }
        (remaining, energy)
    }

    /// Solution of (1 + C K) x = `right`, K the stiffnesses of all; NaN where there is none.
    fn solved<const R: usize>(&self, right: &SMatrix<f64, MOST, R>) -> SMatrix<f64, MOST, R> {
        let mut matrix = SMatrix::<f64, MOST, MOST>::identity();
        for n in 0..self.count {
            for other in (0..self.count).filter(|other| *other != n) {
                let stiffness = self.all[other].potential.hessian[0][0];
                matrix[(n, other)] = self.compliance(n, other)[0] * stiffness;
            }
        }
        let solution = matrix.lu().solve(right);
        solution.unwrap_or_else(|| SMatrix::from_element(f64::NAN))
    }

    /// Newton's step towards a = b - C F, which is `remaining` now, its largest part, m, and the slope of the complementary energy
    /// along it, J.
    pub fn newton(&self, remaining: &[f64; MOST]) -> ([f64; MOST], f64, f64) {
        let mut distance = SMatrix::<f64, MOST, 1>::zeros();
        for (n, pair) in self.all().iter().enumerate() {
            distance[n] = remaining[n] - pair.at[0];
        }
        let step: [f64; MOST] = self.solved(&distance).into();
        let mut largest = 0.0f64;
        let mut slope = 0.0;
        for (n, pair) in self.all().iter().enumerate() {
            // A NaN must not get lost.
            if step[n].abs() > largest || step[n].is_nan() {
                largest = step[n].abs();
            }
            slope -= distance[n] * pair.potential.hessian[0][0] * step[n];
        }
        (step, largest, slope)
    }

    /// The last `step`: energy to second order in it, loads to first, by what is known of W1.
    pub fn correct(&mut self, step: &[f64; MOST]) {
        for (pair, step) in self.all[..self.count].iter_mut().zip(step) {
            let w = &mut pair.potential;
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

    /// Their sum once they have settled, added to `sum`; with second derivatives where the second derivative by mesh position
    /// of what errors close is given, m.
    pub fn total(&self, sum: &mut Potential, closing_curvature: Option<f64>) {
        let [mut energy, mut slope, mut curvature] = [0.0; 3];
        for (n, pair) in self.all().iter().enumerate() {
            let w = &pair.potential;
            sum.value += w.value;
            for (total, own) in sum.gradient.iter_mut().zip(&w.gradient) {
                *total += own;
            }
            sum.gradient[3] += w.gradient[0] * pair.closing_rate;
            let half = self.deflection(n).map(|d| 0.5 * w.gradient[0] * d);
            energy += half[0];
            slope += half[1];
            curvature += half[2];
        }
        sum.value += energy;
        sum.gradient[2] -= slope;
        let Some(closing_curvature) = closing_curvature else {
            return self.curvatures::<1>(&mut sum.hessian);
        };
        self.curvatures::<COORDINATES>(&mut sum.hessian);
        sum.hessian[2][2] -= curvature;
        for pair in self.all() {
            sum.hessian[3][3] += pair.potential.gradient[0] * closing_curvature;
        }
    }

    /// Second derivatives of the sum by the first `R` coordinates, at fixed rates of closings and a fixed slope of the coupling.
    fn curvatures<const R: usize>(&self, hessian: &mut [[f64; COORDINATES]; COORDINATES]) {
        // Slopes of the coordinates of each pair, that of the approach at fixed loads of the others.
        let mut slopes = [[[0.0; R]; COORDINATES]; MOST];
        for (n, (pair, slopes)) in self.all().iter().zip(&mut slopes).enumerate() {
            for (i, row) in slopes.iter_mut().enumerate().take(R) {
                row[i] = 1.0;
            }
            if R == COORDINATES {
                slopes[0][2] = -self.deflection(n)[1];
                slopes[0][3] = pair.closing_rate;
            }
        }
        let free = slopes;
        if self.count > 1 {
            let mut right = SMatrix::<f64, MOST, R>::zeros();
            for n in 0..self.count {
                for x in 0..R {
                    right[(n, x)] = free[n][0][x];
                }
                // What the other coordinates of others change in their loads.
                for other in 0..self.count {
                    let force = &self.all[other].potential.hessian[0];
                    let [by, ..] = self.compliance(n, other);
                    for (j, x) in (1..COORDINATES).flat_map(|j| (0..R).map(move |x| (j, x))) {
                        right[(n, x)] -= by * force[j] * free[other][j][x];
                    }
                }
            }
            let solution = self.solved(&right);
            for n in 0..self.count {
                slopes[n][0] = std::array::from_fn(|x| solution[(n, x)]);
            }
        }
        for (n, pair) in self.all().iter().enumerate() {
            let h = &pair.potential.hessian;
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
