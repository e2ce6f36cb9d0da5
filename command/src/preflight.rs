//! Before long work: whether the contact can be solved at the corners of the operating range.

use gearmesh::contact::{ContactError, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::table::plan::{Coverage, mesh_positions};
use rayon::prelude::*;

use crate::Error;
use crate::model::ModelArgs;
use crate::progress::Job;

/// Positions of the mesh cycle at which every corner is solved.
const POSITIONS: usize = 16;

/// Refuses what cannot be solved at a corner of `coverage`, on the coarse model, which takes seconds, where that of `pair` is
/// still to be computed.
pub fn preflight(
    pair: &Pair,
    args: &ModelArgs,
    coverage: &Coverage,
    job: &Job,
) -> Result<(), Error> {
    if pair.refinement == Refinement::Coarse || args.are_kept(pair)? {
        return Ok(());
    }
    let coarse = Pair {
        refinement: Refinement::Coarse,
        ..pair.clone()
    };
    corners(&args.solver(&coarse, job)?.solver, pair, coverage)
}

/// Solves under the largest torque at the corners of `coverage` and at its nominal state.
pub fn corners(solver: &ContactSolver, pair: &Pair, coverage: &Coverage) -> Result<(), Error> {
    let ends = |range: Option<[f64; 2]>| -> Vec<f64> {
        let mut ends = vec![0.0];
        ends.extend(range.into_iter().flatten());
        ends.dedup();
        ends
    };
    let flanks: &[Flank] = match pair.coast_mirrors_drive() {
        true => &[Flank::Drive],
        false => &[Flank::Drive, Flank::Coast],
    };
    let misalignments = ends(coverage.misalignment);
    let mut points = Vec::new();
    for &flank in flanks {
        for offset in ends(coverage.center_distance_offset) {
            points.extend(
                mesh_positions(POSITIONS)
                    .into_iter()
                    .map(|tau| (flank, offset, tau)),
            );
        }
    }
    let solved = points.par_iter().try_for_each(|&(flank, offset, tau)| {
        let at = solver.position(flank, tau, offset)?;
        for &misalignment in &misalignments {
            at.solve_torque(coverage.maximum_torque, misalignment, None)?;
        }
        Ok::<(), ContactError>(())
    });
    solved.map_err(|error| {
        format!("the operating range of the pair file cannot be covered: {error}").into()
    })
}
