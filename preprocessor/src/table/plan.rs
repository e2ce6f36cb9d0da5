//! Which nodes a table needs for a stated error, and what error it has.
//!
//! The error of a tensor-product interpolant is nearly the sum of those along each axis. So nodes are put
//! along each axis by itself (`choices.rs`), the cheapest combination is swept and measured at random points of all
//! coordinates, and the next combination follows from what was found.

use super::choices::{Choices, Nominal};
use super::measure::{self, OperatingPoint, errors};
use super::source::StaticSource;
use super::sweep::{Watch, point, sweep};
use gearmesh::contact::{ContactFile, Warm};
use gearmesh::gear::{Flank, PairGeometry, PairTeeth};
use gearmesh::random::Random;
use gearmesh::table::Interpolation;
use gearmesh::table::{Axes, FlankGrid, FlankTable, InterpolationError, Query, TableError};
use std::sync::Arc;

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

/// Largest error that a table may have, as a multiple of its rms error: 1.5 % where 0.2 % is asked for.
pub const LARGEST_TO_RMS: f64 = 7.5;

/// Error of the shuttling moment over that of the force that a table may have: the moment is a derivative of what
/// is interpolated, and it acts on bearings, not on the mesh.
pub const MOMENT_TO_FORCE: f64 = 2.0;

/// Grids that are swept at most.
const ROUNDS: u64 = 4;

/// Random points on which a grid is tried, and on which the chosen one's error is reported.
const TRIAL_POINTS: usize = 600;
const REPORTED_POINTS: usize = 1000;

/// Nodes over `range`, denser towards 0 the larger `grading`: with t even in [-1, 1] (or the part of it
/// that the range has), the node is sinh(grading t) scaled.
pub(super) fn graded([low, high]: [f64; 2], n: usize, grading: f64) -> Vec<f64> {
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

/// Default number of misalignments and how much denser they are at parallel axes; of [`misalignments`] for a wide tilt.
const MISALIGNMENTS: usize = 17;
const GRADING: f64 = 2.0;
const MISALIGNMENTS_WIDE: usize = 33;

/// How far apart misalignments may lie at parallel axes in units of [`tilt`], and how far they do of a wide tilt. Measured on
/// faces of 20 to 150 mm at m = 2 mm: from 1.8 on no spline is above zero; at 0.3 force errors are 0.2 % rms.
const FARTHEST_APART: f64 = 0.5;
const APART: f64 = 0.3;

/// The misalignment that lifts one end of the face by as much as the largest torque presses the teeth together where
/// axes are parallel, rad, at the nominal centre distance. Over the misalignment the approaches bend within a few
/// times this; about it they have a kink.
///
/// # Errors
/// A solve that fails.
pub fn tilt(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
) -> Result<f64, TableError> {
    let mut least = f64::INFINITY;
    for p in mesh_positions(4) {
        let failed = |message| TableError::Solve {
            point: point(Flank::Drive, 0.0, 0.0, p),
            message,
        };
        let mut at = source.position(Flank::Drive, p, 0.0).map_err(failed)?;
        let top = at.top(coverage.maximum_torque, 0.0).map_err(failed)?;
        least = least.min(top.approach - at.no_load_approach(0.0));
    }
    Ok(least / (0.5 * geometry.face_overlap().1))
}

/// Misalignments for `coverage`: those of [`default_axes`], and where these lie too far apart at parallel axes for
/// `tilt` (rad, see [`tilt()`]), twice as many that are closer there.
pub fn misalignments(coverage: &Coverage, tilt: f64) -> Vec<f64> {
    let Some(range) = coverage.misalignment else {
        return vec![0.0];
    };
    let usual = graded(range, MISALIGNMENTS, GRADING);
    if closest(&usual) <= FARTHEST_APART * tilt {
        usual
    } else {
        graded_to(range, MISALIGNMENTS_WIDE, APART * tilt)
    }
}

/// Least distance of neighbours.
pub(super) fn closest(nodes: &[f64]) -> f64 {
    let apart = nodes.windows(2).map(|w| w[1] - w[0]);
    apart.fold(f64::INFINITY, f64::min)
}

/// Nodes over `range`, graded so that the closest are at most `apart` from each other, or by 12 at most: then the largest
/// of 33 are twice as far from 0 as their neighbours.
pub(super) fn graded_to(range: [f64; 2], n: usize, apart: f64) -> Vec<f64> {
    let mut nodes = vec![];
    for half in 1..=24 {
        nodes = graded(range, n, 0.5 * f64::from(half));
        if closest(&nodes) <= apart {
            break;
        }
    }
    nodes
}

/// The default grid of `coverage`, without regard to an error: 12 displacements, 9 centre distances, 17
/// misalignments denser at parallel axes, 32 mesh positions.
pub fn default_axes(coverage: &Coverage) -> Axes {
    let range = |r: Option<[f64; 2]>, n, grading| r.map_or(vec![0.0], |r| graded(r, n, grading));
    Axes {
        displacement_fraction: displacement_nodes(12, 1.6),
        center_distance_offset: range(coverage.center_distance_offset, 9, 0.0),
        misalignment: range(coverage.misalignment, MISALIGNMENTS, GRADING),
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
    let points = coverage.draw(Random::new(measure::SEED), points);
    let nominal = nominal(geometry, coverage);
    measure_at(source, flank, nominal, &of_table(table), points, watch)
}

/// Error of `contact` at run time, its teeth taken as alike, against `source` at `points` random operating points, likewise.
///
/// # Errors
/// A solve that fails, at run time or not; a flank that `contact` does not hold; cancellation.
pub fn measure_at_run_time(
    source: &dyn StaticSource,
    contact: &ContactFile,
    flank: Flank,
    coverage: &Coverage,
    points: usize,
    watch: &Watch,
) -> Result<InterpolationError, TableError> {
    let mut alike = contact.clone();
    Arc::make_mut(&mut alike.setup).teeth = PairTeeth::default();
    let level = alike.flank(flank).ok_or_else(|| {
        TableError::Samples("the contact at run time has no coast flank of its own".into())
    })?;
    let found = |q: &Query| {
        let at = [
            q.delta,
            q.center_distance_offset,
            q.misalignment,
            q.mesh_position,
        ];
        let found = level.potential(at, [0; 2], &mut Warm::default());
        found.map(|w| w.gradient).map_err(|e| e.to_string())
    };
    let points = coverage.draw(Random::new(measure::SEED), points);
    let nominal = nominal(&contact.setup.geometry, coverage);
    measure_at(source, flank, nominal, &found, points, watch)
}

/// Derivatives of the potential by approach, centre distance, misalignment and mesh position at an operating point.
type Gradient<'a> = dyn Fn(&Query) -> Result<[f64; 4], String> + Sync + 'a;

fn of_table(table: &FlankTable) -> impl Fn(&Query) -> Result<[f64; 4], String> + Sync {
    |q| Ok(table.evaluate(q, false).gradient)
}

fn measure_at(
    source: &dyn StaticSource,
    flank: Flank,
    nominal: Nominal,
    found: &Gradient<'_>,
    points: Vec<OperatingPoint>,
    watch: &Watch,
) -> Result<InterpolationError, TableError> {
    let errors = errors(points, watch, |(torque, mut q)| {
        let (c, m, p) = (q.center_distance_offset, q.misalignment, q.mesh_position);
        let failed = |message| TableError::Solve {
            point: point(flank, c, m, p),
            message,
        };
        let exact = source
            .position(flank, p, c)
            .and_then(|mut at| at.at_torque(torque, m))
            .map_err(failed)?;
        q.delta = exact.approach;
        let found = found(&q).map_err(failed)?;
        Ok([
            (found[0] - exact.loa_force) / nominal.force,
            (found[2] - exact.moment) / nominal.moment,
        ])
    })?;
    Ok(InterpolationError::of(&errors))
}

/// Force and moment that errors are related to.
fn nominal(geometry: &PairGeometry, coverage: &Coverage) -> Nominal {
    let force = coverage.nominal_torque / geometry.gears[0].base_radius();
    Nominal {
        force,
        moment: force * 0.5 * geometry.face_overlap().1,
    }
}

/// A grid whose spline is within `error` (rms, of the nominal force) of the solver at random points, and
/// within [`LARGEST_TO_RMS`] times that at all of them; the moment within [`MOMENT_TO_FORCE`] times as much, of
/// nominal force times half the face. Both flanks share its axes, which are chosen on the
/// drive flank, those of the misalignment closer at parallel axes where `tilt` (rad, see [`tilt()`]) is small. The error returned is measured on points that had no part in the choice.
///
/// If the finest grid on offer does not reach it, the result is the best there is and says its error.
///
/// # Errors
/// A solve that fails; cancellation.
pub fn table_within(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
    tilt: f64,
    error: f64,
    watch: &Watch,
) -> Result<(FlankGrid, InterpolationError), TableError> {
    let nominal = nominal(geometry, coverage);
    let choices = Choices::new(source, coverage, nominal, tilt, watch)?;
    let found_on = |grid: &FlankGrid, points: usize, seed: u64| {
        let table = FlankTable::new(grid, Interpolation::Spline)?;
        let points = coverage.draw(Random::new(seed), points);
        measure_at(
            source,
            Flank::Drive,
            nominal,
            &of_table(&table),
            points,
            watch,
        )
    };
    // The largest of a few hundred errors is not the largest there is: leave it a third.
    let excess = |e: &InterpolationError| {
        let rms = e.force_rms.max(e.moment_rms / MOMENT_TO_FORCE);
        let largest = e.force_maximum.max(e.moment_maximum / MOMENT_TO_FORCE);
        (rms / error).max(1.5 * largest / (LARGEST_TO_RMS * error))
    };
    let mut wanted = 0.8 * error;
    let mut best: Option<(f64, FlankGrid)> = None;
    for round in 0..ROUNDS {
        let axes = choices.cheapest(wanted);
        if best.as_ref().is_some_and(|b| b.1.axes == axes) {
            break;
        }
        let grid = sweep(source, Flank::Drive, &axes, coverage.maximum_torque, watch)?;
        // Other points in each round, so that no grid is fitted to them.
        let found = match found_on(&grid, TRIAL_POINTS, 0x2545_F491_4F6C_DD1D + round) {
            // What each axis bears alone they may not bear together.
            Err(TableError::TooCoarse { .. }) => f64::INFINITY,
            found => excess(&found?),
        };
        if best.as_ref().is_none_or(|b| found < b.0) {
            best = Some((found, grid));
        }
        if found <= 0.95 {
            break;
        }
        wanted *= (0.8 / found).clamp(0.25, 0.8);
    }
    let Some((_, grid)) = best else {
        return Err(TableError::Samples("no grid was tried".into()));
    };
    let found = found_on(&grid, REPORTED_POINTS, measure::SEED)?;
    Ok((grid, found))
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
