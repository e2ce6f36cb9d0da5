//! Walks the nodes of a table over the load with static solutions, in parallel over centre distance and mesh position.

use super::plan::{Coverage, graded, mesh_positions};
use super::sweep::{Watch, in_order, point};
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use gearmesh::table::{LoadAxes, TableError};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 5 centre distances, misalignments by their count and
/// grading, forces as parts of that of the largest torque, 48 mesh positions.
pub(super) fn load_axes(
    coverage: &Coverage,
    base_radius: f64,
    (misalignments, grading): (usize, f64),
    forces: &[f64],
) -> LoadAxes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    let top = coverage.maximum_torque / base_radius;
    LoadAxes {
        center_distance_offset_m: range(coverage.center_distance_offset, 5, 0.0),
        misalignment_rad: range(coverage.misalignment, misalignments, grading),
        loa_force_n: forces.iter().map(|part| part * top).collect(),
        mesh_position: mesh_positions(48),
    }
}

/// Static contact under load on one flank of gear 1.
pub(super) struct LoadSweep<'a> {
    pub solver: &'a ContactSolver,
    pub flank: Flank,
    pub watch: &'a Watch<'a>,
}

impl LoadSweep<'_> {
    /// At the centre distance offset `c` (m) and mesh position `p`, for each of `misalignments` (rad) under each of `forces` (N on
    /// the line of action, ascending), what `place` gives there of the solution; its default without load. `told` is
    /// called after each misalignment.
    pub fn column<S, K>(
        &self,
        (c, p): (f64, f64),
        [misalignments, forces]: [&[f64]; 2],
        place: impl Fn(&PositionProblem, f64, f64) -> Result<K, ContactError>,
        told: impl Fn(),
    ) -> Result<Vec<S>, TableError>
    where
        S: Copy + Default,
        K: Fn(&PositionProblem, &ContactResult) -> Result<S, ContactError>,
    {
        let failed = |m: f64, error: ContactError| TableError::Solve {
            point: point(self.flank, c, m, p),
            message: error.to_string(),
        };
        let rb = self.solver.geometry().gears[0].base_radius();
        let problem = (self.solver.position(self.flank, p, c)).map_err(|e| failed(0.0, e))?;
        let of = place(&problem, c, p).map_err(|e| failed(0.0, e))?;
        let mut column = vec![S::default(); misalignments.len() * forces.len()];
        for (&m, row) in misalignments.iter().zip(column.chunks_mut(forces.len())) {
            if self.watch.cancel.load(Ordering::Relaxed) {
                return Err(TableError::Cancelled);
            }
            let mut warm = None;
            // From the top down each solution starts from a near one.
            let loaded = forces.iter().zip(row).filter(|(force, _)| **force > 0.0);
            for (&force, sample) in loaded.rev() {
                let result = problem
                    .solve_torque(force * rb, m, warm.as_ref())
                    .map_err(|e| failed(m, e))?;
                *sample = of(&problem, &result).map_err(|e| failed(m, e))?;
                warm = Some(result);
            }
            told();
        }
        Ok(column)
    }

    /// The same at every node of `axes`, in the order of their tables.
    pub fn nodes<S, K>(
        &self,
        axes: &LoadAxes,
        place: impl Fn(&PositionProblem, f64, f64) -> Result<K, ContactError> + Sync,
    ) -> Result<Vec<S>, TableError>
    where
        S: Copy + Default + Send,
        K: Fn(&PositionProblem, &ContactResult) -> Result<S, ContactError>,
    {
        let [nc, nm, nf, np] = axes.lengths();
        let done = AtomicUsize::new(0);
        let told = || {
            let count = done.fetch_add(nf, Ordering::Relaxed) + nf;
            (self.watch.progress)(count, nc * nm * nf * np);
        };
        // Over (centre distance, mesh position): misalignments, forces.
        let columns: Vec<Vec<S>> = (0..nc * np)
            .into_par_iter()
            .map(|k| {
                let c = axes.center_distance_offset_m[k / np];
                let at = (c, axes.mesh_position[k % np]);
                let loads = [&axes.misalignment_rad[..], &axes.loa_force_n];
                self.column(at, loads, &place, told)
            })
            .collect::<Result<_, _>>()?;
        Ok(in_order(&columns, np))
    }
}
