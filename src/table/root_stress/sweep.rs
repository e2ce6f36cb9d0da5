//! Fills the samples of one flank with static solutions, and measures what the spline through them misses.

use super::{RootStressError, RootStressSamples, RootStressTable};
use crate::compliance::finite_element::RootStress;
use crate::contact::{ContactError, ContactSolver, PositionRoots};
use crate::gear::Flank;
use crate::random::Random;
use crate::table::plan::{Coverage, drawn, graded, mesh_positions};
use crate::table::sweep::{Watch, point};
use crate::table::{LoadAxes, TableError};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const MEASURE_SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// Mesh positions at which the largest stress at nominal torque is sought.
const CYCLE: usize = 64;

/// Nodes for `coverage` of a pair whose gear 1 has the base radius `base_radius` (m): 9 forces from 0 on, 5 centre
/// distances, 17 misalignments and 48 mesh positions. Small loads move along the face as the misalignment changes, and with
/// it the place of the largest stress.
pub fn default_root_stress_axes(coverage: &Coverage, base_radius: f64) -> LoadAxes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    let top = coverage.maximum_torque / base_radius;
    LoadAxes {
        center_distance_offset_m: range(coverage.center_distance_offset, 5, 0.0),
        misalignment_rad: range(coverage.misalignment, 17, 1.0),
        loa_force_n: [0.0, 0.03, 0.065, 0.15, 0.26, 0.45, 0.68, 0.85, 1.0]
            .map(|part| part * top)
            .to_vec(),
        mesh_position: mesh_positions(48),
    }
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
    /// The first solve that fails, with its operating point; cancellation.
    pub fn samples(&self, axes: &LoadAxes, watch: &Watch) -> Result<RootStressSamples, TableError> {
        let [nc, nm, nf, np] = axes.lengths();
        let done = AtomicUsize::new(0);
        // Over (centre distance, mesh position): misalignments, forces.
        let columns: Vec<Vec<[f64; 2]>> = (0..nc * np)
            .into_par_iter()
            .map(|k| {
                let c = axes.center_distance_offset_m[k / np];
                let p = axes.mesh_position[k % np];
                let forces = &axes.loa_force_n;
                let told = || {
                    let count = done.fetch_add(nf, Ordering::Relaxed) + nf;
                    (watch.progress)(count, nc * nm * nf * np);
                };
                self.column((c, p), &axes.misalignment_rad, forces, watch, &told)
            })
            .collect::<Result<_, _>>()?;
        let of_gear = |gear: usize| -> Vec<f64> {
            let rows = columns.chunks(np);
            rows.flat_map(|row| {
                (0..nm * nf).flat_map(move |at| row.iter().map(move |column| column[at][gear]))
            })
            .collect()
        };
        Ok(RootStressSamples::new([&of_gear(0), &of_gear(1)]))
    }

    /// Stress of both gears, Pa, at the centre distance offset `c` and mesh position `p`, for each of `misalignments` under
    /// each of `forces`, ascending.
    fn column(
        &self,
        (c, p): (f64, f64),
        misalignments: &[f64],
        forces: &[f64],
        watch: &Watch,
        told: &dyn Fn(),
    ) -> Result<Vec<[f64; 2]>, TableError> {
        let failed = |m: f64, error: ContactError| TableError::Solve {
            point: point(self.flank, c, m, p),
            message: error.to_string(),
        };
        let solver = self.solver;
        let rb = solver.geometry().gears[0].base_radius();
        let problem = (solver.position(self.flank, p, c)).map_err(|e| failed(0.0, e))?;
        let roots = PositionRoots::new(solver, &problem, (self.flank, p, c), self.models)
            .map_err(|e| failed(0.0, e))?;
        let mut column = vec![[0.0; 2]; misalignments.len() * forces.len()];
        for (&m, row) in misalignments.iter().zip(column.chunks_mut(forces.len())) {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(TableError::Cancelled);
            }
            let mut warm = None;
            // From the top down each solution starts from a near one.
            let loaded = forces.iter().zip(row).filter(|(force, _)| **force > 0.0);
            for (&force, sample) in loaded.rev() {
                let result = problem
                    .solve_torque(force * rb, m, warm.as_ref())
                    .map_err(|e| failed(m, e))?;
                *sample = roots.largest(&result).map_err(|e| failed(m, e))?;
                warm = Some(result);
            }
            told();
        }
        Ok(column)
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
                let exact = self.column((c, p), &[m], &[force], watch, &|| ())?[0];
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
