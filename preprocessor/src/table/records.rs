//! Fills the samples over the load with static solutions, how it slides and what stress it makes in the roots, and measures what
//! the spline through the latter misses.

use super::coverage::{Coverage, SEED, errors, mesh_positions};
use super::sweep::{Watch, solve_error};
use crate::contact::PositionRoots;
use crate::finite_element::RootStress;
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{
    LoadAxes, LoadSpline, RootStressError, RootStressSamples, SlidingSamples, TableError,
    rms_and_largest,
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
    let all =
        sweep.nodes(axes, |_| {
            |problem: &PositionProblem, result: &ContactResult| {
                Ok(solver.sliding(problem, result, &law))
            }
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

impl<'a> RootStressSweep<'a> {
    /// Solves at every node of `axes`.
    ///
    /// # Errors
    /// The first solve that fails, with its operating point; cancellation.
    pub fn samples(&self, axes: &LoadAxes, watch: &Watch) -> Result<RootStressSamples, TableError> {
        let sweep = self.sweep(watch);
        let all = sweep.nodes(axes, |problem| self.largest(problem))?;
        let [gear_1, gear_2] =
            [0, 1].map(|gear| all.iter().map(|both| both[gear]).collect::<Vec<f64>>());
        Ok(RootStressSamples::new([&gear_1, &gear_2]))
    }

    fn sweep<'w>(&'w self, watch: &'w Watch<'w>) -> LoadSweep<'w> {
        LoadSweep {
            solver: self.solver,
            flank: self.flank,
            watch,
        }
    }

    /// Stress of both gears, Pa, out of a solution of `problem`.
    fn largest(
        &self,
        problem: &PositionProblem,
    ) -> impl Fn(&PositionProblem, &ContactResult) -> Result<[f64; 2], ContactError> + use<'a> {
        let roots = PositionRoots::new(problem, self.models);
        move |_: &PositionProblem, result: &ContactResult| roots.largest(result)
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
        watch: &Watch,
    ) -> Result<RootStressError, TableError> {
        let rb = self.solver.geometry().gears[0].base_radius();
        let nominal = coverage.nominal_torque / rb;
        let stress = |query: [f64; 4]| -> [f64; 2] { table.evaluate(query).map(|jet| jet.value) };
        let cycle = (0..CYCLE).map(|i| stress([nominal, 0.0, 0.0, i as f64 / CYCLE as f64]));
        let largest = cycle.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let drawn = coverage.draw(Random::new(SEED), points);
        let errors = errors(drawn, watch, |(torque, q)| {
            let (c, m, p) = (q.center_distance_offset, q.misalignment, q.mesh_position);
            let force = torque / rb;
            let roots = |problem: &PositionProblem| self.largest(problem);
            let exact = (self.sweep(watch)).column([c, p], [&[m], &[force]], roots, &|_| ())?[0];
            let found = stress([force, c, m, p]);
            Ok([0, 1].map(|i| (found[i] - exact[i]) / largest[i]))
        })?;
        let [first, second] = [0, 1].map(|i| rms_and_largest(errors.iter().map(|e| e[i])));
        Ok(RootStressError {
            points,
            rms: first[0].max(second[0]),
            maximum: first[1].max(second[1]),
        })
    }
}

struct LoadSweep<'a> {
    solver: &'a ContactSolver,
    flank: Flank,
    watch: &'a Watch<'a>,
}

impl LoadSweep<'_> {
    /// At the centre distance offset `c` (m) and mesh position `p`, for each of `misalignments` (rad) under each of `forces` (N on
    /// the line of action, ascending), what `at_position` gives there of the solution; its default without load. `report`
    /// is called after each misalignment with the number of forces.
    fn column<S, K>(
        &self,
        [c, p]: [f64; 2],
        [misalignments, forces]: [&[f64]; 2],
        at_position: impl Fn(&PositionProblem) -> K,
        report: &dyn Fn(usize),
    ) -> Result<Vec<S>, TableError>
    where
        S: Copy + Default,
        K: Fn(&PositionProblem, &ContactResult) -> Result<S, ContactError>,
    {
        let failed = |m| move |error: ContactError| solve_error(self.flank, [c, m, p], error);
        let rb = self.solver.geometry().gears[0].base_radius();
        let problem = (self.solver.position(self.flank, p, c)).map_err(failed(0.0))?;
        let evaluate = at_position(&problem);
        let mut column = vec![S::default(); misalignments.len() * forces.len()];
        for (&m, row) in misalignments.iter().zip(column.chunks_mut(forces.len())) {
            self.watch.check()?;
            let mut warm = None;
            // From the top down each solution starts from a near one.
            let loaded = forces.iter().zip(row).filter(|(force, _)| **force > 0.0);
            for (&force, sample) in loaded.rev() {
                let result = problem.solve_torque(force * rb, m, warm.as_ref());
                let result = result.map_err(failed(m))?;
                *sample = evaluate(&problem, &result).map_err(failed(m))?;
                warm = Some(result);
            }
            report(forces.len());
        }
        Ok(column)
    }

    /// The same at every node of `axes`, in the order of their tables.
    fn nodes<S, K>(
        &self,
        axes: &LoadAxes,
        at_position: impl Fn(&PositionProblem) -> K + Sync,
    ) -> Result<Vec<S>, TableError>
    where
        S: Copy + Default + Send,
        K: Fn(&PositionProblem, &ContactResult) -> Result<S, ContactError>,
    {
        let outer = [&axes.center_distance_offset_m[..], &axes.mesh_position];
        let loads = [&axes.misalignment_rad[..], &axes.loa_force_n];
        let total = axes.lengths().iter().product();
        (self.watch).sweep_columns(outer, total, |c, p, report| {
            self.column([c, p], loads, &at_position, report)
        })
    }
}
