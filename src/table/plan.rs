//! Which nodes a table needs for a stated error, and what error it has.
//!
//! The error of a tensor-product interpolant is nearly the sum of those along each axis. So each axis
//! is settled by itself, on small tables over this axis and the displacement through random points of the
//! others; the whole table is then swept once and measured at random points of all coordinates.

use super::interpolation::Interpolation;
use super::source::StaticSource;
use super::sweep::{Watch, point, sweep};
use super::{Axes, FlankGrid, FlankTable, InterpolationError, Query, TableError};
use crate::gear::{Flank, PairGeometry};

/// What a table must cover.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Range of the centre distance offset, m; `None`: nominal only.
    pub center_distance_offset: Option<[f64; 2]>,
    /// Range of the misalignment, rad; `None`: parallel axes only.
    pub misalignment: Option<[f64; 2]>,
    /// Torque on gear 1 that errors are related to, N m.
    pub nominal_torque: f64,
    /// Largest torque on gear 1, N m.
    pub maximum_torque: f64,
}

/// Random numbers in [0, 1) that are the same in every run (xorshift64, Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, range: Option<[f64; 2]>) -> f64 {
        range.map_or(0.0, |[low, high]| low + (high - low) * self.next())
    }
}

/// Nodes over `range`, denser towards 0 the larger `grading`: with t even in [-1, 1] (or the part of it
/// that the range has), the node is sinh(grading t) scaled.
fn graded([low, high]: [f64; 2], n: usize, grading: f64) -> Vec<f64> {
    let largest = low.abs().max(high.abs());
    let warp = |x: f64| {
        if grading == 0.0 {
            x
        } else {
            (x * grading.sinh()).asinh() / grading
        }
    };
    let back = |t: f64| {
        if grading == 0.0 {
            t
        } else {
            (t * grading).sinh() / grading.sinh()
        }
    };
    let (a, b) = (warp(low / largest), warp(high / largest));
    (0..n)
        .map(|i| match i {
            0 => low,
            i if i + 1 == n => high,
            i => {
                let t = a + (b - a) * i as f64 / (n - 1) as f64;
                // An odd symmetric axis must contain 0 itself, not a rounding of it.
                if t.abs() < 1e-12 {
                    0.0
                } else {
                    largest * back(t)
                }
            }
        })
        .collect()
}

/// Displacement nodes, denser towards the onset: (i / n)^power.
pub fn displacement_nodes(n: usize, power: f64) -> Vec<f64> {
    (1..=n).map(|i| (i as f64 / n as f64).powf(power)).collect()
}

/// Mesh positions, even.
pub fn mesh_positions(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / n as f64).collect()
}

/// The default grid of `coverage`, without regard to an error: 12 displacements, 9 centre distances, 17
/// misalignments denser at parallel axes, 32 mesh positions.
pub fn default_axes(coverage: &Coverage) -> Axes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    Axes {
        displacement_fraction: displacement_nodes(12, 1.6),
        center_distance_offset: range(coverage.center_distance_offset, 9, 0.0),
        misalignment: range(coverage.misalignment, 17, 2.0),
        mesh_position: mesh_positions(32),
    }
}

/// Error of `table` against `source` at `points` random operating points: torques even in (0, maximum), the
/// other coordinates even in their ranges.
///
/// # Errors
/// A solve that fails; cancellation.
pub fn measure(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    flank: Flank,
    coverage: &Coverage,
    table: &FlankTable,
    points: usize,
    watch: &Watch,
) -> Result<InterpolationError, TableError> {
    use rayon::prelude::*;
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let queries: Vec<(f64, Query)> = (0..points)
        .map(|_| {
            let torque = coverage.maximum_torque * random.next();
            let query = Query {
                delta: 0.0,
                center_distance_offset: random.within(coverage.center_distance_offset),
                misalignment: random.within(coverage.misalignment),
                mesh_position: random.next(),
            };
            (torque, query)
        })
        .collect();
    let nominal = coverage.nominal_torque / geometry.gears[0].base_radius();
    let lever = 0.5 * geometry.face_overlap().1;
    let errors: Vec<[f64; 2]> = queries
        .into_par_iter()
        .map(|(torque, mut q)| {
            if watch.cancel.load(std::sync::atomic::Ordering::Relaxed) {
                return Err(TableError::Cancelled);
            }
            let (c, m, p) = (q.center_distance_offset, q.misalignment, q.mesh_position);
            let exact = source
                .position(flank, p, c)
                .and_then(|mut at| at.at_torque(torque, m))
                .map_err(|message| TableError::Solve {
                    point: point(flank, c, m, p),
                    message,
                })?;
            q.delta = exact.approach;
            let found = table.evaluate(&q, false);
            Ok([
                (found.gradient[0] - exact.loa_force) / nominal,
                (found.gradient[2] - exact.moment) / (nominal * lever),
            ])
        })
        .collect::<Result<_, _>>()?;
    let rms = |k: usize| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / points as f64).sqrt();
    let max = |k: usize| errors.iter().map(|e| e[k].abs()).fold(0.0, f64::max);
    Ok(InterpolationError {
        points,
        force_rms: rms(0),
        force_maximum: max(0),
        moment_rms: rms(1),
        moment_maximum: max(1),
    })
}

/// An axis under trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    Displacement,
    CenterDistance,
    Misalignment,
    MeshPosition,
}

/// Settles axes so that the rms force error of the spline is about `error` of the nominal force.
struct Planner<'a> {
    source: &'a dyn StaticSource,
    geometry: &'a PairGeometry,
    coverage: &'a Coverage,
    watch: Watch<'a>,
    /// Random points through which the small tables are laid.
    lines: Vec<[f64; 3]>,
}

impl Planner<'_> {
    /// rms error over the lines of small tables with the nodes of `axes` along `axis`, the other
    /// coordinates (but the displacement) fixed.
    fn error_along(&self, axis: Axis, axes: &Axes) -> Result<f64, TableError> {
        let mut squares = 0.0;
        for &[c, m, p] in &self.lines {
            let mut line = Axes {
                displacement_fraction: axes.displacement_fraction.clone(),
                center_distance_offset: vec![c],
                misalignment: vec![m],
                mesh_position: vec![p],
            };
            // A coordinate held fixed is a range of no width.
            let mut covered = Coverage {
                center_distance_offset: Some([c, c]),
                misalignment: Some([m, m]),
                ..self.coverage.clone()
            };
            match axis {
                Axis::Displacement => {}
                Axis::CenterDistance => {
                    line.center_distance_offset = axes.center_distance_offset.clone();
                    covered.center_distance_offset = self.coverage.center_distance_offset;
                }
                Axis::Misalignment => {
                    line.misalignment = axes.misalignment.clone();
                    covered.misalignment = self.coverage.misalignment;
                }
                Axis::MeshPosition => line.mesh_position = axes.mesh_position.clone(),
            }
            let fixed = FixedPosition {
                source: self.source,
                mesh_position: (axis != Axis::MeshPosition).then_some(p),
            };
            let grid = sweep(
                &fixed,
                Flank::Drive,
                &line,
                self.coverage.maximum_torque,
                &self.watch,
            )?;
            let table = FlankTable::new(&grid, Interpolation::Spline)?;
            let e = measure(
                &fixed,
                self.geometry,
                Flank::Drive,
                &covered,
                &table,
                24,
                &self.watch,
            )?;
            squares += e.force_rms * e.force_rms;
        }
        Ok((squares / self.lines.len() as f64).sqrt())
    }

    /// The first of `trials` (nodes, ascending in number) that keeps `error`, else the best.
    fn settle(
        &self,
        axis: Axis,
        axes: &mut Axes,
        trials: impl Iterator<Item = Vec<f64>>,
        error: f64,
    ) -> Result<(), TableError> {
        let mut best = (f64::INFINITY, vec![]);
        for nodes in trials {
            let slot = match axis {
                Axis::Displacement => &mut axes.displacement_fraction,
                Axis::CenterDistance => &mut axes.center_distance_offset,
                Axis::Misalignment => &mut axes.misalignment,
                Axis::MeshPosition => &mut axes.mesh_position,
            };
            slot.clone_from(&nodes);
            let found = self.error_along(axis, axes)?;
            if found < best.0 {
                best = (found, nodes);
            }
            if best.0 <= error {
                break;
            }
        }
        match axis {
            Axis::Displacement => axes.displacement_fraction = best.1,
            Axis::CenterDistance => axes.center_distance_offset = best.1,
            Axis::Misalignment => axes.misalignment = best.1,
            Axis::MeshPosition => axes.mesh_position = best.1,
        }
        Ok(())
    }
}

/// A source held at one mesh position.
struct FixedPosition<'a> {
    source: &'a dyn StaticSource,
    mesh_position: Option<f64>,
}

impl StaticSource for FixedPosition<'_> {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn super::source::StaticPosition + '_>, String> {
        let p = self.mesh_position.unwrap_or(mesh_position);
        self.source.position(flank, p, center_distance_offset)
    }
}

/// A grid whose spline is within `error` (rms, of the nominal force) of the solver at held-out random
/// points, with the error found there; both flanks share its axes, which are settled on the drive flank.
///
/// If the largest grids on offer (40 displacements, 17 centre distances, 49 misalignments, 128
/// positions) do not reach it, the result is the best there is and says its error.
///
/// # Errors
/// A solve that fails; cancellation.
pub fn table_within(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
    error: f64,
    watch: &Watch,
) -> Result<(FlankGrid, InterpolationError), TableError> {
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let silent = |_, _| {};
    let planner = Planner {
        source,
        geometry,
        coverage,
        watch: Watch {
            progress: &silent,
            cancel: watch.cancel,
        },
        lines: (0..16)
            .map(|_| {
                let c = random.within(coverage.center_distance_offset);
                let m = random.within(coverage.misalignment);
                [c, m, random.next()]
            })
            .collect(),
    };
    let mut axes = default_axes(coverage);
    // Squares of four equal shares add up; the displacement is part of the others' trials, too.
    let mut share = 0.5 * error;
    let mut best: Option<(FlankGrid, InterpolationError)> = None;
    for _ in 0..3 {
        planner.settle(
            Axis::Displacement,
            &mut axes,
            [6, 8, 10, 12, 14, 17, 20, 24, 30, 40]
                .iter()
                .flat_map(|&n| [1.3, 1.8, 2.3].map(|power| displacement_nodes(n, power))),
            0.5 * share,
        )?;
        planner.settle(
            Axis::MeshPosition,
            &mut axes,
            [12, 16, 20, 24, 32, 40, 48, 64, 96, 128]
                .iter()
                .map(|&n| mesh_positions(n)),
            share,
        )?;
        if let Some(range) = coverage.center_distance_offset {
            let trials = [4, 5, 7, 9, 11, 13, 17]
                .iter()
                .map(|&n| graded(range, n, 0.0));
            planner.settle(Axis::CenterDistance, &mut axes, trials, share)?;
        }
        if let Some(range) = coverage.misalignment {
            let trials = [5, 7, 9, 11, 13, 17, 21, 25, 33, 41, 49]
                .iter()
                .flat_map(|&n| [0.0, 1.5, 3.0].map(|grading| graded(range, n, grading)));
            planner.settle(Axis::Misalignment, &mut axes, trials, share)?;
        }
        let grid = sweep(source, Flank::Drive, &axes, coverage.maximum_torque, watch)?;
        let table = FlankTable::new(&grid, Interpolation::Spline)?;
        let found = measure(
            source,
            geometry,
            Flank::Drive,
            coverage,
            &table,
            1000,
            watch,
        )?;
        let reached = found.force_rms <= error;
        share *= (0.8 * error / found.force_rms).min(0.8);
        if best
            .as_ref()
            .is_none_or(|b| found.force_rms < b.1.force_rms)
        {
            best = Some((grid, found));
        }
        if reached {
            break;
        }
    }
    best.ok_or_else(|| TableError::Samples("no grid was tried".into()))
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
