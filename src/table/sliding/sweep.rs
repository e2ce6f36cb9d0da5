//! Fills the samples of one flank with static solutions.

use super::SlidingSamples;
use crate::contact::ContactSolver;
use crate::friction::Sliding;
use crate::gear::Flank;
use crate::table::plan::{Coverage, graded, mesh_positions};
use crate::table::sweep::{Watch, point};
use crate::table::{LoadAxes, TableError};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 6 forces, 5 centre distances,
/// 9 misalignments and 48 mesh positions. Sliding changes less with load and alignment than the force does, and
/// more with the position: at the pitch point it changes its direction.
pub fn default_sliding_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    let top = coverage.maximum_torque / base_radius;
    LoadAxes {
        center_distance_offset_m: range(coverage.center_distance_offset, 5, 0.0),
        misalignment_rad: range(coverage.misalignment, 9, 2.0),
        loa_force_n: [0.03, 0.1, 0.25, 0.45, 0.7, 1.0]
            .map(|part| part * top)
            .to_vec(),
        mesh_position: mesh_positions(48),
    }
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
    let [nc, nm, nf, np] = axes.lengths();
    let rb = solver.geometry().gears[0].base_radius();
    let done = AtomicUsize::new(0);
    // Over (centre distance, mesh position): misalignments, forces.
    let columns: Vec<Vec<Sliding>> = (0..nc * np)
        .into_par_iter()
        .map(|k| {
            let c = axes.center_distance_offset_m[k / np];
            let p = axes.mesh_position[k % np];
            let failed = |m: f64, error: crate::contact::ContactError| TableError::Solve {
                point: point(flank, c, m, p),
                message: error.to_string(),
            };
            let problem = solver.position(flank, p, c).map_err(|e| failed(0.0, e))?;
            let mut column = vec![Sliding::default(); nm * nf];
            for (i, &m) in axes.misalignment_rad.iter().enumerate() {
                if watch.cancel.load(Ordering::Relaxed) {
                    return Err(TableError::Cancelled);
                }
                let mut warm = None;
                for (j, &force) in axes.loa_force_n.iter().enumerate().rev() {
                    let result = problem
                        .solve_torque(force * rb, m, warm.as_ref())
                        .map_err(|e| failed(m, e))?;
                    column[i * nf + j] = solver.sliding(&problem, &result, solver.friction());
                    warm = Some(result);
                }
                let count = done.fetch_add(nf, Ordering::Relaxed) + nf;
                (watch.progress)(count, nc * nm * nf * np);
            }
            Ok(column)
        })
        .collect::<Result<_, _>>()?;
    let mut all = Vec::with_capacity(nc * nm * nf * np);
    for row in columns.chunks(np) {
        for at in 0..nm * nf {
            all.extend(row.iter().map(|column| column[at]));
        }
    }
    Ok(SlidingSamples::new(&all, solver.friction().is_local()))
}
