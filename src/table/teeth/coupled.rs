//! The loads of all tooth pairs in mesh, from the table of one alone.
//!
//! Tooth pair k closes by b_k = delta + e_k. What the others carry takes of that: it is left a_k = b_k - sum of c_|j-k| F_j, and
//! carries F_k = dW1/da there. The compliances c depend on the misalignment M. The loads make
//!
//! W = sum of W1(a_k) + sum over every two of c_|j-k| F_j F_k
//!
//! stationary, so that slopes of W are those at fixed loads: those of the W1 at fixed a_k and, by M, -c' F_j F_k of every two: twice
//! that of what both are left, less once that of the second sum. The loads are also where the complementary energy
//!
//! sum of (a_k - b_k) F_k - W1(a_k) + sum over every two of c_|j-k| F_j F_k
//!
//! is least, which is convex in F while what a tooth pair gives way exceeds the least eigenvalue of the c, negative
//! ([`TeethRecord::check_gain`](super::TeethRecord)). Newton's iteration finds it, its steps shortened until this energy falls.

use super::compliance::Coupling;
use super::pairs::{MOST, Pair, Pairs};
use crate::table::{COORDINATES, FlankTable, Potential, Query};

/// Steps at most; nearly all points take three or four.
const MOST_STEPS: usize = 200;

/// Part of what the slope of the complementary energy promises that a step must keep, the least part of Newton's step that is
/// tried, and the part of the energies that rounding may take.
const LEAST_GAIN: f64 = 0.1;
const LEAST_PART: f64 = 1e-6;
const ROUNDING: f64 = 1e-13;

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
    /// What the force on a neighbour takes of the approach.
    coupling: Coupling,
    /// Step that is the last, m.
    last_step: f64,
}

impl TeethTable {
    /// Of a table of one tooth pair over `places` (first and length, base pitches), with the `span` (m) up to which it holds
    /// approaches at least.
    pub(super) fn new(pair: FlankTable, places: [f64; 2], coupling: Coupling, span: f64) -> Self {
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
        pairs.total(&mut sum, want_hessian);
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
            coupling: self.coupling.at(query.misalignment),
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
        let (mut left, mut energy) = pairs.left();
        for _ in 0..MOST_STEPS {
            let (step, largest, slope) = pairs.newton(&left);
            if largest <= self.last_step {
                pairs.correct(&step);
                return true;
            }
            let here: [f64; MOST] = std::array::from_fn(|n| pairs.all[n].at[0]);
            let mut part = 1.0;
            loop {
                let next = std::array::from_fn(|n| here[n] + part * step[n]);
                self.go_to(pairs, &next);
                let (left_there, energy_there) = pairs.left();
                if energy_there.is_nan() {
                    return false;
                }
                let rounding = ROUNDING * (energy.abs() + energy_there.abs());
                if energy_there <= energy + LEAST_GAIN * part * slope + rounding
                    || part < LEAST_PART
                {
                    (left, energy) = (left_there, energy_there);
                    break;
                }
                part *= 0.5;
            }
        }
        false
    }

    fn go_to(&self, pairs: &mut Pairs, to: &[f64; MOST]) {
        for (pair, to) in pairs.all_mut().iter_mut().zip(to) {
            pair.at[0] = *to;
            pair.found = self.ask(&pair.at);
        }
    }
}
