//! Fills the samples of one flank with static solutions, and measures what the spline through them misses.

use crate::contact::PositionRoots;
use crate::finite_element::RootStress;
use crate::table::load_sweep::{LoadSweep, load_axes};
use crate::table::measure::{self, errors};
use crate::table::plan::Coverage;
use crate::table::sweep::Watch;
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{
    LoadAxes, LoadSpline, RootStressError, RootStressSamples, TableError, rms_and_largest,
};
use std::sync::Arc;

/// Mesh positions at which the largest stress at nominal torque is sought.
const CYCLE: usize = 64;

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 9 forces from 0 on, 5 centre
/// distances, 17 misalignments and 48 mesh positions. Small loads move along the face as the misalignment changes, and with
/// it the place of the largest stress.
pub fn default_root_stress_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let forces = [0.0, 0.03, 0.065, 0.15, 0.26, 0.45, 0.68, 0.85, 1.0];
    load_axes(coverage, base_radius, (17, 1.0), &forces)
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
        let all = self
            .on(watch)
            .nodes(axes, |problem, c, p| self.largest(problem, c, p))?;
        let of_gear = |gear: usize| -> Vec<f64> { all.iter().map(|both| both[gear]).collect() };
        Ok(RootStressSamples::new([&of_gear(0), &of_gear(1)]))
    }

    fn on<'w>(&'w self, watch: &'w Watch<'w>) -> LoadSweep<'w> {
        LoadSweep {
            solver: self.solver,
            flank: self.flank,
            watch,
        }
    }

    /// Stress of both gears, Pa, out of a solution at the centre distance offset `c` and mesh position `p`.
    fn largest(
        &self,
        problem: &PositionProblem,
        c: f64,
        p: f64,
    ) -> Result<
        impl Fn(&PositionProblem, &ContactResult) -> Result<[f64; 2], ContactError> + use<'a>,
        ContactError,
    > {
        let roots = PositionRoots::new(self.solver, problem, (self.flank, p, c), self.models)?;
        Ok(move |_: &PositionProblem, result: &ContactResult| roots.largest(result))
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
        let drawn = coverage.draw(Random::new(measure::SEED), points);
        let errors = errors(drawn, watch, |(torque, q)| {
            let (force, c, m, p) = (
                torque / rb,
                q.center_distance_offset,
                q.misalignment,
                q.mesh_position,
            );
            let of = |problem: &PositionProblem, c, p| self.largest(problem, c, p);
            let exact = self.on(watch).column((c, p), [&[m], &[force]], of, || ())?[0];
            let found = stress([force, c, m, p]);
            Ok([0, 1].map(|i| (found[i] - exact[i]) / largest[i]))
        })?;
        let [[rms, maximum], second] = [0, 1].map(|i| rms_and_largest(errors.iter().map(|e| e[i])));
        Ok(RootStressError {
            points,
            rms: rms.max(second[0]),
            maximum: maximum.max(second[1]),
        })
    }
}
