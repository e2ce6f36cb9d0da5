//! What a force on one tooth pair takes of the approach of the others, over the misalignment.
//!
//! The next one shares tooth roots and the rim beside it, all of them the body. Under misalignment they carry at the same end of
//! the face, where a force takes more from the others than a force at mid-face does.

use super::pairs::MOST;
use crate::table::TableError;
use crate::table::interpolation::{Basis, Ends, axis};
use crate::vector::Lanes;

/// Part of itself by which the compliance changes at most beyond an end of the misalignments.
const BEYOND: f64 = 0.5;

/// By how many base pitches two tooth pairs are apart: what the force on one takes of the approach of the other, m/N, its slope and
/// its second derivative by the misalignment; at 0 nothing.
pub type Taken = [[f64; 3]; MOST];

/// The compliance between tooth pairs, each distance a cubic spline over the misalignment: continuous up to its second derivative; beyond
/// the ends it goes on linearly and levels out, as tables do.
#[derive(Debug)]
pub struct Coupling {
    basis: Basis<4>,
    /// From the distance 1 on.
    coefficients: Vec<Vec<f64>>,
}

impl Coupling {
    /// Through `rows` (m/N), from the distance 1 on, at the `misalignments` (rad, ascending); one of each: the same everywhere.
    pub fn new(misalignments: &[f64], rows: &[Vec<f64>]) -> Result<Self, TableError> {
        let name = "teeth.axes.misalignment_rad";
        let (basis, fit) = axis(misalignments, Ends::Bounded, name)?;
        let ends = [0, misalignments.len() - 1];
        let mut coupling = Coupling {
            basis,
            coefficients: rows.iter().map(|row| fit.coefficients(row)).collect(),
        };
        for (end, node) in ends.into_iter().enumerate() {
            for [value, slope, _] in coupling.at(misalignments[node]) {
                // It levels out two guards away from the end.
                let guard = 0.5 * BEYOND * (value / slope).abs();
                let guards = &mut coupling.basis.guard;
                // Not a number: nothing at this distance.
                guards[end] = guards[end].min(guard);
            }
        }
        Ok(coupling)
    }

    /// The same at all misalignments, as with parallel axes.
    pub fn aligned(&self) -> Self {
        let here = self.at(0.0);
        let distances = 1..=self.coefficients.len();
        Coupling {
            basis: Basis::new(&[], Ends::Bounded),
            coefficients: distances.map(|apart| vec![here[apart][0]]).collect(),
        }
    }

    /// At the misalignment `m`, rad.
    pub fn at(&self, m: f64) -> Taken {
        let (w, _) = self.basis.weights(Lanes::COMMON, m, 2);
        let mut taken = [[0.0; 3]; MOST];
        for (taken, coefficients) in taken[1..].iter_mut().zip(&self.coefficients) {
            let stored = &coefficients[w.first..w.first + w.count];
            *taken = [w.value, w.slope, w.curvature].map(|weights| {
                let terms = stored.iter().zip(weights);
                terms
                    .map(|(coefficient, weight)| coefficient * weight)
                    .sum()
            });
        }
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f64; 6] = [-3e-3, -1e-3, -4e-4, 5e-4, 1.2e-3, 3e-3];
    const VALUES: [f64; 6] = [1.1e-9, 9.7e-10, 9e-10, 9.2e-10, 1e-9, 1.2e-9];

    /// At one distance.
    fn single(misalignments: &[f64], values: &[f64]) -> Coupling {
        Coupling::new(misalignments, &[values.to_vec()]).unwrap()
    }

    #[test]
    fn it_passes_through_its_nodes_with_the_slopes_it_tells() {
        let coupling = single(&NODES, &VALUES);
        for (node, value) in NODES.iter().zip(VALUES) {
            assert!((coupling.at(*node)[1][0] / value - 1.0).abs() < 1e-12);
        }
        // Across the nodes, the ends and where it levels out; the second derivative jumps at the last two.
        let step = 1e-7;
        for i in -900..=900 {
            let m = 1e-5 * f64::from(i) + 1e-8;
            let [below, here, above] = [m - step, m, m + step].map(|m| coupling.at(m)[1]);
            let by_differences = |k: usize| (above[k] - below[k]) / (2.0 * step);
            assert!((by_differences(0) - here[1]).abs() < 1e-10, "{m} {here:?}");
            let inside = m.abs() < NODES[5] - step;
            if inside {
                assert!((by_differences(1) - here[2]).abs() < 1e-5, "{m} {here:?}");
            }
        }
        for (far, end) in [(-1.0, 1.1e-9), (1.0, 1.2e-9)] {
            let [value, slope, _] = coupling.at(far)[1];
            assert!(
                (value / end - 1.0).abs() < 1.001 * BEYOND && slope == 0.0,
                "{value}"
            );
        }
    }

    #[test]
    fn parallel_axes_and_a_single_value_are_the_same_everywhere() {
        let coupling = single(&NODES, &VALUES);
        let aligned = coupling.at(0.0)[1][0];
        for same in [coupling.aligned(), single(&[0.0], &[aligned])] {
            assert_eq!(same.at(2e-3)[1], [aligned, 0.0, 0.0]);
        }
    }

    #[test]
    fn every_distance_has_its_own_and_those_beyond_take_nothing() {
        let [near, far] = [1.0, 0.3].map(|share| VALUES.map(|v| share * v).to_vec());
        let both = Coupling::new(&NODES, &[near.clone(), far]).unwrap();
        let (here, alone) = (both.at(7e-4), single(&NODES, &near).at(7e-4));
        assert_eq!(here[1], alone[1]);
        for (far, near) in here[2].iter().zip(here[1]) {
            assert!((far / near - 0.3).abs() < 1e-12);
        }
        assert_eq!([here[0], here[3]], [[0.0; 3]; 2]);
    }
}
