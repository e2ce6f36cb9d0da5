//! What a force on one tooth pair takes of the approach of the next, over the misalignment.
//!
//! Under misalignment neighbours carry at the same end of the face, where a force takes more from the one beside it than a force
//! at mid-face does.

use crate::table::TableError;
use crate::table::interpolation::{Basis, Ends, Two, axis_basis, stored_from_values};

/// Part of itself by which the compliance changes at most beyond an end of the misalignments.
const BEYOND: f64 = 0.5;

/// The compliance between neighbours as a cubic spline over the misalignment: continuous up to its second derivative; beyond
/// the ends it goes on linearly and levels out, as tables do.
#[derive(Debug)]
pub struct Coupling {
    basis: Basis<4>,
    coefficients: Vec<f64>,
}

impl Coupling {
    /// Through `values` (m/N) at the `misalignments` (rad, ascending); one of each: the same everywhere.
    ///
    /// # Errors
    /// Nodes through which no spline passes.
    pub fn new(misalignments: &[f64], values: &[f64]) -> Result<Self, TableError> {
        let basis = axis_basis(misalignments, Ends::Bounded);
        let name = "teeth.axes.misalignment_rad";
        let matrix = stored_from_values(&basis, misalignments, Ends::Bounded, name)?;
        let coefficient = |row: usize| {
            let terms = values.iter().enumerate();
            terms.map(|(k, value)| matrix[(row, k)] * value).sum()
        };
        let coefficients = (0..matrix.nrows()).map(coefficient).collect();
        let ends = [0, misalignments.len() - 1];
        let mut coupling = Coupling {
            basis,
            coefficients,
        };
        for (end, node) in ends.into_iter().enumerate() {
            let [value, slope, _] = coupling.at(misalignments[node]);
            // It levels out two guards away from the end.
            let guard = 0.5 * BEYOND * (value / slope).abs();
            let guards = &mut coupling.basis.guard;
            guards[end] = guards[end].min(guard);
        }
        Ok(coupling)
    }

    /// The same at all misalignments, as with parallel axes.
    pub fn aligned(&self) -> Self {
        Coupling {
            basis: Basis::new(&[], Ends::Bounded),
            coefficients: vec![self.at(0.0)[0]],
        }
    }

    /// At the misalignment `m` (rad): m/N, its slope and its second derivative by the misalignment.
    pub fn at(&self, m: f64) -> [f64; 3] {
        let (w, _) = self.basis.weights(Two, m, 2);
        let stored = &self.coefficients[w.first..w.first + w.count];
        [w.value, w.slope, w.curvature].map(|weights| {
            let terms = stored.iter().zip(weights);
            terms
                .map(|(coefficient, weight)| coefficient * weight)
                .sum()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f64; 6] = [-3e-3, -1e-3, -4e-4, 5e-4, 1.2e-3, 3e-3];
    const VALUES: [f64; 6] = [1.1e-9, 9.7e-10, 9e-10, 9.2e-10, 1e-9, 1.2e-9];

    #[test]
    fn it_passes_through_its_nodes_with_the_slopes_it_tells() {
        let coupling = Coupling::new(&NODES, &VALUES).unwrap();
        for (node, value) in NODES.iter().zip(VALUES) {
            assert!((coupling.at(*node)[0] / value - 1.0).abs() < 1e-12);
        }
        // Across the nodes, the ends and where it levels out; the second derivative jumps at the last two.
        let step = 1e-7;
        for i in -900..=900 {
            let m = 1e-5 * f64::from(i) + 1e-8;
            let [below, here, above] = [m - step, m, m + step].map(|m| coupling.at(m));
            let by_differences = |k: usize| (above[k] - below[k]) / (2.0 * step);
            assert!((by_differences(0) - here[1]).abs() < 1e-10, "{m} {here:?}");
            let inside = m.abs() < NODES[5] - step;
            if inside {
                assert!((by_differences(1) - here[2]).abs() < 1e-5, "{m} {here:?}");
            }
        }
        for (far, end) in [(-1.0, 1.1e-9), (1.0, 1.2e-9)] {
            let [value, slope, _] = coupling.at(far);
            assert!(
                (value / end - 1.0).abs() < 1.001 * BEYOND && slope == 0.0,
                "{value}"
            );
        }
    }

    #[test]
    fn parallel_axes_and_a_single_value_are_the_same_everywhere() {
        let coupling = Coupling::new(&NODES, &VALUES).unwrap();
        let aligned = coupling.at(0.0)[0];
        for same in [
            coupling.aligned(),
            Coupling::new(&[0.0], &[aligned]).unwrap(),
        ] {
            assert_eq!(same.at(2e-3), [aligned, 0.0, 0.0]);
        }
    }
}
