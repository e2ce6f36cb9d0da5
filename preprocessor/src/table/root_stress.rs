//! Fills the samples of one flank with static solutions, and measures what the spline through them misses.

use crate::contact::PositionRoots;
use crate::finite_element::RootStress;
use crate::table::load_sweep::{LoadSweep, load_axes};
use crate::table::plan::{Coverage, drawn};
use crate::table::sweep::Watch;
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{LoadAxes, TableError};
use gearmesh::table::{RootStressError, RootStressSamples, RootStressTable};
use rayon::prelude::*;
use std::sync::Arc;

const MEASURE_SEED: u64 = 0x9E37_79B9_7F4A_7C15;

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
        table: &RootStressTable,
        points: usize,
        watch: &Watch,
    ) -> Result<RootStressError, TableError> {
        let mut random = Random::new(MEASURE_SEED);
        let rb = self.solver.geometry().gears[0].base_radius();
        let queries: Vec<[f64; 4]> = (0..points)
            .map(|_| {
                let force = coverage.maximum_torque * random.next() / rb;
                let c = drawn(&mut random, coverage.center_distance_offset);
                let m = drawn(&mut random, coverage.misalignment);
                [force, c, m, random.next()]
            })
            .collect();
        let nominal = coverage.nominal_torque / rb;
        let stress = |query: [f64; 4]| table.evaluate(query).map(|jet| jet.value);
        let cycle = (0..CYCLE).map(|i| stress([nominal, 0.0, 0.0, i as f64 / CYCLE as f64]));
        let largest = cycle.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let errors: Vec<[f64; 2]> = queries
            .into_par_iter()
            .map(|query| {
                let [force, c, m, p] = query;
                let of = |problem: &PositionProblem, c, p| self.largest(problem, c, p);
                let exact = self.on(watch).column((c, p), [&[m], &[force]], of, || ())?[0];
                let found = stress(query);
                Ok([0, 1].map(|i| (found[i] - exact[i]) / largest[i]))
            })
            .collect::<Result<_, TableError>>()?;
        let of_gear = |gear: usize| {
            let squares: f64 = errors.iter().map(|e| e[gear] * e[gear]).sum();
            let largest = errors.iter().map(|e| e[gear].abs()).fold(0.0, f64::max);
            RootStressError {
                points,
                rms: (squares / points as f64).sqrt(),
                maximum: largest,
            }
        };
        let both = of_gear(0).with(of_gear(1));
        Ok(RootStressError { points, ..both })
    }
}
