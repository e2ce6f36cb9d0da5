//! Fills the samples over the load with static solutions, how it slides and what stress it makes in the roots, and measures what
//! the spline through the latter misses.

use super::coverage::{Coverage, SEED, TOGETHER, errors, mesh_positions};
use super::sweep::{Progress, failed, rows_over_misalignment, sweep_columns};
use crate::contact::PositionRoots;
use crate::finite_element::RootStress;
use crate::static_contact::{ContactError, ContactResult, ContactSolver, PositionProblem};
use gearmesh::friction::Sliding;
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{
    LoadAxes, LoadSpline, RootStressError, RootStressSamples, SlidingSamples, TableError,
};
use std::sync::Arc;

/// Mesh positions at which the largest stress at nominal torque is sought.
const CYCLE: usize = 64;

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 6 forces, 5 centre distances,
/// 9 misalignments and 48 mesh positions. Sliding changes less with load and alignment than the force does, and
/// more with the position: at the pitch point it changes its direction.
pub fn default_sliding_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let forces = [0.03, 0.1, 0.25, 0.45, 0.7, 1.0];
    let misalignments = coverage.graded_misalignments(9, 2.0);
    load_axes(coverage, base_radius, misalignments, &forces)
}

/// Likewise: 9 forces from 0 on, 5 centre distances, 17 misalignments and 48 mesh positions. Small loads move along the face as
/// the misalignment changes, and with it the place of the largest stress.
pub fn default_root_stress_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let forces = [0.0, 0.03, 0.065, 0.15, 0.26, 0.45, 0.68, 0.85, 1.0];
    let misalignments = coverage.graded_misalignments(17, 1.0);
    load_axes(coverage, base_radius, misalignments, &forces)
}

fn load_axes(
    coverage: &Coverage,
    base_radius: f64,
    misalignment_rad: Vec<f64>,
    forces: &[f64],
) -> LoadAxes {
    let top = coverage.maximum_torque / base_radius;
    LoadAxes {
        center_distance_offset_m: coverage.offsets(5),
        misalignment_rad,
        loa_force_n: forces.iter().map(|part| part * top).collect(),
        mesh_position: mesh_positions(48),
    }
}

/// Solves at every node of `axes` for `flank`, with the weights of the law that `solver` has.
///
/// # Errors
/// The first solve that fails, with its operating point.
pub fn sweep_sliding(
    solver: &ContactSolver,
    flank: Flank,
    axes: &LoadAxes,
    progress: Progress,
) -> Result<SlidingSamples, TableError> {
    let law = solver.friction();
    let [c, m, force, p] = axes.nodes();
    let all = sweep_columns([c, p], progress, |c, p| {
        let column = Column::new(solver, flank, [c, p])?;
        let sliding = |result: &_| Ok(solver.sliding(&column.problem, result, &law));
        column.solve([m, force], sliding, Sliding::mirrored)
    })?;
    Ok(SlidingSamples::new(&all, law.is_local()))
}

/// Root stress of a pair under load on one flank.
pub struct RootStressSweep<'a> {
    /// Static contact.
    pub solver: &'a ContactSolver,
    /// Maps of gear 1 and gear 2 for `flank`.
    pub models: &'a [Arc<RootStress>; 2],
    /// Loaded flank of gear 1.
    pub flank: Flank,
}

impl RootStressSweep<'_> {
    /// Solves at every node of `axes`.
    ///
    /// # Errors
    /// The first solve that fails, with its operating point.
    pub fn samples(
        &self,
        axes: &LoadAxes,
        progress: Progress,
    ) -> Result<RootStressSamples, TableError> {
        let [c, m, force, p] = axes.nodes();
        let all = sweep_columns([c, p], progress, |c, p| {
            let column = Column::new(self.solver, self.flank, [c, p])?;
            let roots = PositionRoots::new(&column.problem, self.models);
            column.solve([m, force], |result| roots.largest(result), |stress| *stress)
        })?;
        Ok(RootStressSamples::new(&all))
    }

    /// Error of `table` at `points` random operating points: torques even in (0, maximum), the other coordinates even
    /// in their ranges.
    ///
    /// # Errors
    /// As [`RootStressSweep::samples`].
    pub fn measure(
        &self,
        coverage: &Coverage,
        table: &LoadSpline,
        points: usize,
    ) -> Result<RootStressError, TableError> {
        let rb = self.solver.geometry().gears[0].base_radius();
        let nominal = coverage.nominal_torque / rb;
        let stress = |query: [f64; 4]| -> [f64; 2] { table.evaluate(query).map(|jet| jet.value) };
        let cycle = (0..CYCLE).map(|i| stress([nominal, 0.0, 0.0, i as f64 / CYCLE as f64]));
        let largest = cycle.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let drawn = coverage.draw(Random::new(SEED), points, TOGETHER);
        let errors = errors(&drawn, |held| {
            let (p, c) = (held.mesh_position, held.center_distance_offset);
            let column = Column::new(self.solver, self.flank, [c, p])?;
            let roots = PositionRoots::new(&column.problem, self.models);
            let errors = held.loads.iter().map(|&[torque, m]| {
                let force = torque / rb;
                let exact = column.solve(
                    [&[m], &[force]],
                    |result| roots.largest(result),
                    |stress| *stress,
                )?[0];
                let found = stress([force, c, m, p]);
                Ok([0, 1].map(|i| (found[i] - exact[i]) / largest[i]))
            });
            errors.collect()
        })?;
        Ok(RootStressError::of(&errors))
    }
}

/// Static contact at one centre distance and mesh position.
struct Column<'a> {
    solver: &'a ContactSolver,
    flank: Flank,
    /// Centre distance offset, m, and mesh position.
    at: [f64; 2],
    problem: PositionProblem,
}

impl<'a> Column<'a> {
    fn new(solver: &'a ContactSolver, flank: Flank, at: [f64; 2]) -> Result<Self, TableError> {
        let [c, p] = at;
        let problem = solver.position(flank, p, c);
        Ok(Column {
            problem: problem.map_err(failed(flank, [c, 0.0, p]))?,
            solver,
            flank,
            at,
        })
    }

    fn failed(&self, misalignment: f64, error: ContactError) -> TableError {
        let [c, p] = self.at;
        failed(self.flank, [c, misalignment, p])(error)
    }

    /// What `sample` gives of each solution, for each of `misalignments` (rad) under each of `forces` (N on the line of
    /// action, ascending), and `mirrored` of each that mirrors another; the default without load.
    fn solve<S: Copy + Default>(
        &self,
        [misalignments, forces]: [&[f64]; 2],
        sample: impl Fn(&ContactResult) -> Result<S, ContactError>,
        mirrored: impl Fn(&S) -> S,
    ) -> Result<Vec<S>, TableError> {
        let rb = self.solver.geometry().gears[0].base_radius();
        let is_mirrored = self.solver.is_mirrored_at_mid_face();
        rows_over_misalignment(
            misalignments,
            is_mirrored,
            forces.len(),
            mirrored,
            |m, row| {
                let mut warm = None;
                // From the top down each solution starts from a near one.
                for (&force, value) in forces.iter().zip(row).rev().filter(|(f, _)| **f > 0.0) {
                    let result = self.problem.solve_torque(force * rb, m, warm.as_ref());
                    let result = result.map_err(|error| self.failed(m, error))?;
                    *value = sample(&result).map_err(|error| self.failed(m, error))?;
                    warm = Some(result);
                }
                Ok(())
            },
        )
    }
}
