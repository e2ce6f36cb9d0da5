//! Before long work: whether the contact can be solved at the corners of the operating range.

use gearmesh::contact::ContactSolver;
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::contact::{CycleInput, LoadCase, MeshCycle};
use gearmesh_preprocessor::table::Coverage;

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
    let with_nominal =
        |range: Option<[f64; 2]>| [0.0].into_iter().chain(range.into_iter().flatten());
    let loads = with_nominal(coverage.misalignment).map(|misalignment| LoadCase {
        torque: coverage.maximum_torque,
        misalignment,
    });
    let loads: Vec<LoadCase> = loads.collect();
    let flanks: &[Flank] = match pair.coast_mirrors_drive() {
        true => &[Flank::Drive],
        false => &[Flank::Drive, Flank::Coast],
    };
    for &flank in flanks {
        for center_distance_offset in with_nominal(coverage.center_distance_offset) {
            let input = CycleInput {
                flank,
                torque: coverage.maximum_torque,
                center_distance_offset,
                misalignment: 0.0,
                positions: POSITIONS,
            };
            MeshCycle::solve_all(solver, &input, &loads, &|_| {}).map_err(|error| {
                format!("the operating range of the pair file cannot be covered: {error}")
            })?;
        }
    }
    Ok(())
}
