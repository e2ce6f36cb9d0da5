//! The loads of all tooth pairs in mesh, from the table of one alone.
//!
//! Tooth pair k closes by b_k = delta + e_k. What its neighbours carry takes c F of that: it is left
//! a_k = b_k - c (F_(k-1) + F_(k+1)), and carries F_k = dW1/da there. The loads make
//!
//! W = sum of W1(a_k) + sum over neighbours of c F_j F_k
//!
//! stationary, so that slopes of W are those of the W1 at fixed a_k. With c below half of what any tooth pair gives way
//! ([`TeethRecord::check_gain`](super::TeethRecord)) a <- b - c F is a contraction, and there is one solution. Newton's iteration finds
//! it; a step whose shorter parts do not lessen the residual, either, is replaced by one of that contraction.

use super::linear::{SIZE, solve};
use crate::table::{COORDINATES, FlankTable, Potential, Query};

/// Most tooth pairs in mesh at once.
pub const MOST: usize = SIZE;

/// Steps at most; nearly all points take three or four.
const MOST_STEPS: usize = 200;

/// Part of what a step of Newton's iteration promises of the residual that it must keep, and the least part of such a step
/// that is tried before one of the contraction.
const LEAST_GAIN: f64 = 0.25;
const LEAST_PART: f64 = 0.1;

/// A step of this part of the span of the table is the last: what it leaves of the energy is of third order in it.
const LAST_STEP: f64 = 1e-6;

/// What errors of the teeth close of the gap of a tooth pair, m along the line of action.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Closing {
    /// m.
    pub value: f64,
    /// Its slope by mesh position, m.
    pub rate: f64,
    /// Its second derivative by mesh position, m.
    pub curvature: f64,
}

/// The potential of one flank whose teeth may differ.
#[derive(Debug)]
pub struct TeethTable {
    /// Of one tooth pair alone, over its approach, centre distance, misalignment and place; the place as a fraction of its range.
    pair: FlankTable,
    /// First place of the range and its length, base pitches.
    places: [f64; 2],
    /// What the force on a neighbour takes of the approach, m/N.
    coupling: f64,
    /// Step that is the last, m.
    last_step: f64,
}

/// One tooth pair that may carry.
#[derive(Debug, Clone, Copy, Default)]
struct Pair {
    /// Number of the tooth pair.
    k: i32,
    closing: Closing,
    /// Approach, centre distance offset, misalignment, place, before neighbours take of it.
    free: [f64; COORDINATES],
    /// Likewise, after.
    at: [f64; COORDINATES],
    /// W1 there.
    found: Potential,
}

/// Tooth pairs that may carry, ascending.
struct Pairs {
    all: [Pair; MOST],
    count: usize,
}

impl TeethTable {
    /// Of a table of one tooth pair over `places` (first and length, base pitches), with the `span` (m) up to which it holds
    /// approaches at least; `coupling` in m/N.
    pub fn new(pair: FlankTable, places: [f64; 2], coupling: f64, span: f64) -> Self {
        TeethTable {
            pair,
            places,
            coupling,
            last_step: LAST_STEP * span,
        }
    }

    /// Potential at `query` with what errors of the teeth close of the gap of each tooth pair; tooth pair k is at the
    /// place mesh position + k. As [`FlankTable::evaluate`]; not a number where no loads were found.
    pub fn evaluate(
        &self,
        query: &Query,
        closing: impl Fn(i32) -> Closing,
        want_hessian: bool,
    ) -> Potential {
        let mut pairs = self.near(query, closing);
        let out_of_range = pairs.all().iter().any(|pair| pair.found.out_of_range);
        pairs.drop_idle();
        let mut sum = Potential {
            out_of_range,
            ..Potential::default()
        };
        if pairs.count == 0 {
            return sum;
        }
        if pairs.count > 1 && !self.settle(&mut pairs) {
            sum.value = f64::NAN;
            sum.gradient = [f64::NAN; COORDINATES];
            return sum;
        }
        self.total(&pairs, &mut sum, want_hessian);
        sum
    }

    /// W1 at `at` with its Hessian, slopes by the place.
    fn ask(&self, at: &[f64; COORDINATES]) -> Potential {
        let [first, length] = self.places;
        let query = Query {
            delta: at[0],
            center_distance_offset: at[1],
            misalignment: at[2],
            mesh_position: (at[3] - first) / length,
        };
        let mut w = self.pair.evaluate(&query, true);
        w.gradient[3] /= length;
        for i in 0..COORDINATES {
            w.hessian[i][3] /= length;
            w.hessian[3][i] /= length;
        }
        w
    }

    /// All tooth pairs within the table's places, each as if it were alone.
    fn near(&self, query: &Query, closing: impl Fn(i32) -> Closing) -> Pairs {
        let tau = query.mesh_position;
        let [first, length] = self.places;
        let lowest = (first - tau).ceil();
        let mut pairs = Pairs {
            all: [Pair::default(); MOST],
            count: 0,
        };
        for k in lowest as i32.. {
            let place = tau + f64::from(k);
            // Not a number ends it, too.
            if place.is_nan() || place >= first + length || pairs.count == MOST {
                break;
            }
            let closing = closing(k);
            let free = [
                query.delta + closing.value,
                query.center_distance_offset,
                query.misalignment,
                place,
            ];
            pairs.all[pairs.count] = Pair {
                k,
                closing,
                free,
                at: free,
                found: self.ask(&free),
            };
            pairs.count += 1;
        }
        pairs
    }

    /// Finds what is left to each of `pairs`; false if it does not.
    fn settle(&self, pairs: &mut Pairs) -> bool {
        let (mut left, mut residual) = self.left(pairs);
        for _ in 0..MOST_STEPS {
            let (step, largest) = self.newton(pairs, &left);
            if largest <= self.last_step {
                correct(pairs, &step);
                return true;
            }
            let here: [f64; MOST] = std::array::from_fn(|n| pairs.all[n].at[0]);
            let mut part = 1.0;
            loop {
                let next = std::array::from_fn(|n| here[n] + part * step[n]);
                self.go_to(pairs, &next);
                let (left_there, residual_there) = self.left(pairs);
                if residual_there <= (1.0 - LEAST_GAIN * part) * residual {
                    (left, residual) = (left_there, residual_there);
                    break;
                }
                part *= 0.5;
                if part < LEAST_PART || residual_there.is_nan() {
                    self.go_to(pairs, &left);
                    (left, residual) = self.left(pairs);
                    break;
                }
            }
        }
        false
    }

    /// b - c F of each of `pairs`, m, and the largest distance to what they have.
    fn left(&self, pairs: &Pairs) -> ([f64; MOST], f64) {
        let mut left = [0.0; MOST];
        let mut largest = 0.0f64;
        for (n, pair) in pairs.all().iter().enumerate() {
            let beside: f64 = pairs
                .beside(n)
                .map(|other| pairs.all[other].found.gradient[0])
                .sum();
            left[n] = pair.free[0] - self.coupling * beside;
            let distance = (left[n] - pair.at[0]).abs();
            // A number that is none must not get lost.
            if distance > largest || distance.is_nan() {
                largest = distance;
            }
        }
        (left, largest)
    }

    fn go_to(&self, pairs: &mut Pairs, to: &[f64; MOST]) {
        for (pair, to) in pairs.all_mut().iter_mut().zip(to) {
            pair.at[0] = *to;
            pair.found = self.ask(&pair.at);
        }
    }

    /// 1 + c K of `pairs`, K the stiffnesses of neighbours.
    fn matrix(&self, pairs: &Pairs) -> [[f64; SIZE]; SIZE] {
        let mut matrix = [[0.0; SIZE]; SIZE];
        for n in 0..pairs.count {
            matrix[n][n] = 1.0;
            for other in pairs.beside(n) {
                matrix[n][other] = self.coupling * pairs.all[other].found.hessian[0][0];
            }
        }
        matrix
    }

    /// Newton's step towards a = b - c F, which is `left` now, and its largest part, m.
    fn newton(&self, pairs: &Pairs, left: &[f64; MOST]) -> ([f64; MOST], f64) {
        let mut right = [[0.0; 1]; SIZE];
        for (n, pair) in pairs.all().iter().enumerate() {
            right[n] = [left[n] - pair.at[0]];
        }
        solve(&mut self.matrix(pairs), &mut right, pairs.count);
        let step: [f64; MOST] = std::array::from_fn(|n| right[n][0]);
        (
            step,
            step.iter().fold(0.0, |largest, s| s.abs().max(largest)),
        )
    }

    /// Sum over settled `pairs`.
    fn total(&self, pairs: &Pairs, sum: &mut Potential, want_hessian: bool) {
        for (n, pair) in pairs.all().iter().enumerate() {
            let w = &pair.found;
            sum.value += w.value;
            for (total, own) in sum.gradient.iter_mut().zip(&w.gradient) {
                *total += own;
            }
            sum.gradient[3] += w.gradient[0] * pair.closing.rate;
            if n + 1 < pairs.count && pairs.all[n + 1].k == pair.k + 1 {
                let next = &pairs.all[n + 1].found.gradient;
                sum.value += self.coupling * w.gradient[0] * next[0];
            }
        }
        if want_hessian {
            self.curvatures::<COORDINATES>(pairs, &mut sum.hessian);
            for pair in pairs.all() {
                sum.hessian[3][3] += pair.found.gradient[0] * pair.closing.curvature;
            }
        } else {
            self.curvatures::<1>(pairs, &mut sum.hessian);
        }
    }

    /// Second derivatives of the sum by the first `R` coordinates, at fixed rates of closings.
    fn curvatures<const R: usize>(
        &self,
        pairs: &Pairs,
        hessian: &mut [[f64; COORDINATES]; COORDINATES],
    ) {
        // Slopes of the coordinates of each pair, that of the approach before neighbours take of it.
        let mut slopes = [[[0.0; R]; COORDINATES]; MOST];
        for (pair, slopes) in pairs.all().iter().zip(&mut slopes) {
            for (i, row) in slopes.iter_mut().enumerate().take(R) {
                row[i] = 1.0;
            }
            if R == COORDINATES {
                slopes[0][3] = pair.closing.rate;
            }
        }
        let free = slopes;
        if pairs.count > 1 {
            let mut right = [[0.0; R]; SIZE];
            for n in 0..pairs.count {
                right[n] = free[n][0];
                // What the other coordinates of neighbours change in their loads.
                for other in pairs.beside(n) {
                    let force = &pairs.all[other].found.hessian[0];
                    for j in 1..COORDINATES {
                        for x in 0..R {
                            right[n][x] -= self.coupling * force[j] * free[other][j][x];
                        }
                    }
                }
            }
            solve(&mut self.matrix(pairs), &mut right, pairs.count);
            for n in 0..pairs.count {
                slopes[n][0] = right[n];
            }
        }
        for (n, pair) in pairs.all().iter().enumerate() {
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

/// The last `step`: energy to second order in it, loads to first, by what is known of W1.
fn correct(pairs: &mut Pairs, step: &[f64; MOST]) {
    for (pair, step) in pairs.all_mut().iter_mut().zip(step) {
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

impl Pairs {
    fn all(&self) -> &[Pair] {
        &self.all[..self.count]
    }

    fn all_mut(&mut self) -> &mut [Pair] {
        &mut self.all[..self.count]
    }

    /// Without those that carry nothing: neighbours take of their approach, so that they carry nothing with them, either.
    fn drop_idle(&mut self) {
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
}
