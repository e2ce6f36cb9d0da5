//! Claims about what solutions do not show; those about solutions stand in tests/contact.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::{ContactSolver, PositionProblem};
use crate::compliance::{BeyondModel, ToothCompliance};
use gearmesh::contact::{ContactSettings, Segment};
use gearmesh::gear::Flank;

const PAPER: &str = include_str!("../../../resources/pairs/palermo2013.json");

/// Segments that do not know of each other.
struct Alone;

impl ToothCompliance for Alone {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        Ok(DMatrix::identity(segments.len(), segments.len()) * 1e-8)
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        vec![1e-3; segments.len()]
    }
}

#[test]
fn a_segment_whose_gap_or_arm_is_not_a_number_fails_the_solve() {
    let pair = crate::pair::from_json(PAPER).unwrap();
    let alone: [Arc<dyn ToothCompliance>; 2] = [Arc::new(Alone), Arc::new(Alone)];
    let solver = ContactSolver::new(&pair, alone, ContactSettings::default()).unwrap();
    let torque = pair.operating.nominal_torque;
    let damage: [fn(&mut PositionProblem, usize); 3] = [
        |problem, i| problem.contact.candidates[i].gap = [f64::NAN; 4],
        |problem, i| problem.contact.candidates[i].gap[2] = f64::NAN,
        |problem, i| problem.contact.arm[i] = f64::NAN,
    ];
    for damage in damage {
        let mut problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
        let approach = problem.solve_torque(torque, 0.0, None).unwrap().approach;
        let middle = problem.candidates().len() / 2;
        damage(&mut problem, middle);
        for result in [
            problem.solve_torque(torque, 0.0, None),
            problem.solve_approach(approach, 0.0, None),
            problem.solve_approach(-1e-3, 0.0, None),
        ] {
            let error = result.unwrap_err();
            let failure = "the contact solve stopped at a residual of NaN";
            assert!(error.to_string().contains(failure), "{error}");
        }
    }
}
