//! Fills the samples of one flank with static solutions.

use crate::table::load_sweep::{LoadSweep, load_axes};
use crate::table::plan::Coverage;
use crate::table::sweep::Watch;
use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use gearmesh::table::SlidingSamples;
use gearmesh::table::{LoadAxes, TableError};

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 6 forces, 5 centre distances,
/// 9 misalignments and 48 mesh positions. Sliding changes less with load and alignment than the force does, and
/// more with the position: at the pitch point it changes its direction.
pub fn default_sliding_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let forces = [0.03, 0.1, 0.25, 0.45, 0.7, 1.0];
    load_axes(coverage, base_radius, (9, 2.0), &forces)
}

/// Solves at every node of `axes` for `flank`, with the weights of the law that `solver` has.
///
/// # Errors
/// The first solve that fails, with its operating point; cancellation.
pub fn sweep_sliding(
    solver: &ContactSolver,
    flank: Flank,
    axes: &LoadAxes,
    watch: &Watch,
) -> Result<SlidingSamples, TableError> {
    let law = solver.friction();
    let sweep = LoadSweep {
        solver,
        flank,
        watch,
    };
    let all = sweep.nodes(axes, |_, _, _| {
        Ok(|problem: &PositionProblem, result: &ContactResult| {
            Ok(solver.sliding(problem, result, law))
        })
    })?;
    Ok(SlidingSamples::new(&all, law.is_local()))
}
