//! Numbers that are none end a solve.

use super::plain_pair;
use crate::compliance::{BeyondModel, Segment, ToothCompliance};
use crate::contact::{ContactError, ContactSettings, ContactSolver, Failure, PositionProblem};
use crate::gear::Flank;
use nalgebra::DMatrix;
use std::sync::Arc;

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
    let pair = plain_pair("palermo2013");
    let solver = ContactSolver::new(
        &pair,
        [Arc::new(Alone), Arc::new(Alone)],
        ContactSettings::default(),
    )
    .unwrap();
    let torque = pair.operating.nominal_torque;
    let damage: [fn(&mut PositionProblem, usize); 3] = [
        |problem, i| problem.candidates[i].gap = [f64::NAN; 4],
        |problem, i| problem.candidates[i].gap[2] = f64::NAN,
        |problem, i| problem.arm[i] = f64::NAN,
    ];
    let approach = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
    let approach = approach.solve_torque(torque, 0.0, None).unwrap().approach;
    for damage in damage {
        for approach in [approach, -1e-3] {
            let mut problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
            let middle = problem.candidates.len() / 2;
            damage(&mut problem, middle);
            for result in [
                problem.solve_torque(torque, 0.0, None),
                problem.solve_approach(approach, 0.0, None),
            ] {
                let failed = matches!(
                    result,
                    Err(ContactError::Unsolved {
                        failure: Failure::NotConverged { .. },
                        ..
                    })
                );
                assert!(failed, "{:?}", result.map(|r| r.loa_force));
            }
        }
    }
}
