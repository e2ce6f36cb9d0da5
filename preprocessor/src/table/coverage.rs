//! What a table covers: its default nodes, random operating points, and errors against static solutions there.

use super::sweep::{StaticSource, failed, sweep};
use crate::gear::Pair;
use crate::static_contact::ContactError;
use gearmesh::contact::{ContactFile, Prescribed, Warm};
use gearmesh::gear::{Flank, PairGeometry, PairTeeth};
use gearmesh::random::Random;
use gearmesh::table::{
    Axes, FlankGrid, FlankTable, Interpolation, InterpolationError, Query, TableError,
    least_distance,
};
use rayon::prelude::*;
use std::ops::Range;
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

/// Nodes over `range`, denser towards 0 the larger `grading`: with t even in [-1, 1] (or the part of it
/// that the range has), the node is sinh(grading t) scaled.
pub(super) fn graded([low, high]: [f64; 2], n: usize, grading: f64) -> Vec<f64> {
    let largest = low.abs().max(high.abs());
    let [a, b] = [low, high].map(|x| match grading {
        0.0 => x / largest,
        _ => (x / largest * grading.sinh()).asinh() / grading,
    });
    let nodes = (0..n).map(|i| {
        let t = a + (b - a) * i as f64 / (n - 1) as f64;
        match i {
            0 => low,
            _ if i + 1 == n => high,
            // An odd symmetric axis must contain 0 itself, not a rounding of it.
            _ if t.abs() < 1e-12 => 0.0,
            _ if grading == 0.0 => largest * t,
            _ => largest * ((t * grading).sinh() / grading.sinh()),
        }
    });
    nodes.collect()
}

/// Nodes over `range`, graded so that the closest are at most `apart` from each other, or by 12 at most: then the largest
/// of 25 are nearly three times as far from 0 as their neighbours.
pub(super) fn graded_to(range: [f64; 2], n: usize, apart: f64) -> Vec<f64> {
    let mut gradings = (1..=24).map(|half| graded(range, n, 0.5 * f64::from(half)));
    let found = gradings.find(|nodes| least_distance(nodes) <= apart);
    found.unwrap_or_else(|| graded(range, n, 12.0))
}

/// Displacement nodes, denser towards the onset: (i / n)^power.
pub fn displacement_nodes(n: usize, power: f64) -> Vec<f64> {
    (1..=n).map(|i| (i as f64 / n as f64).powf(power)).collect()
}

/// Mesh positions, even.
pub fn mesh_positions(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / n as f64).collect()
}

/// Default number of misalignments and how much denser they are at parallel axes; number of those that are closer there.
const MISALIGNMENTS: usize = 17;
const GRADING: f64 = 2.0;
const MISALIGNMENTS_CLOSER: usize = 25;

/// Nodes beyond a limit of the misalignment, over that limit. Without them the moment of shuttling, which the slope over the
/// misalignment makes, is least certain at the limits, and beyond them it follows no solution.
const OUTSIDE: [f64; 2] = [1.3, 1.6];

/// Part of the nominal torque under which misalignments are tried: without crowning a few microradians lift one end of the face then,
/// and over the misalignment the approach bends as sharply.
const LOW_LOAD: f64 = 0.02;

/// Largest [`low_load_error`] of misalignments that are not made closer. Measured on five shipped and ten random pairs: 0.001 to
/// 0.008 with those of [`default_axes`], but 0.0095 and 0.0099 for two random ones with little crowning and 0.10 for the pair without.
const LOW_LOAD_ERROR: f64 = 0.008;

/// Mesh positions at which misalignments are tried.
const TRIED_POSITIONS: usize = 4;

/// How much closer misalignments lie at parallel axes from try to try, and how often. The pair without crowning takes the third, a spur face of
/// 25 mm that 20 mrad tilt the fourth.
const CLOSER: f64 = 4.0;
const TIMES: i32 = 4;
/// Closer misalignments are taken if they leave at most this part of the error: they cost digits of the force, and an error between the
/// displacements does not fall with them.
const WORTH: f64 = 0.85;

impl Coverage {
    /// The operating range of `pair`, with those of centre distance and misalignment where they are wanted and wider than nothing.
    pub fn new(pair: &Pair, center_distance: bool, misalignment: bool) -> Coverage {
        let o = &pair.operating;
        let range =
            |wanted: bool, range: [f64; 2]| (wanted && range[0] < range[1]).then_some(range);
        Coverage {
            center_distance_offset: range(center_distance, o.center_distance_offset),
            misalignment: range(misalignment, o.misalignment),
            nominal_torque: o.nominal_torque,
            maximum_torque: o.maximum_torque,
        }
    }

    /// `n` even centre distance offsets, m; 0 where there is no range.
    pub fn offsets(&self, n: usize) -> Vec<f64> {
        (self.center_distance_offset).map_or(vec![0.0], |range| graded(range, n, 0.0))
    }

    /// `n` misalignments, rad, likewise, denser towards parallel axes the larger `grading`.
    pub fn graded_misalignments(&self, n: usize, grading: f64) -> Vec<f64> {
        (self.misalignment).map_or(vec![0.0], |range| graded(range, n, grading))
    }

    /// `nodes` over the range of the misalignment, and those [`OUTSIDE`] of it; not where parallel axes are an end of the range, for
    /// there approaches have their kink.
    pub(super) fn with_outside(&self, nodes: Vec<f64>) -> Vec<f64> {
        let [low, high] = self.misalignment.unwrap_or_default();
        if !(low < 0.0 && high > 0.0) {
            return nodes;
        }
        let below = OUTSIDE.iter().rev().map(|part| part * low);
        let above = OUTSIDE.iter().map(|part| part * high);
        below.chain(nodes).chain(above).collect()
    }

    /// Indices of those of the misalignments `nodes` that lie in the range.
    pub(super) fn inside_of(&self, nodes: &[f64]) -> Range<usize> {
        let Some([low, high]) = self.misalignment else {
            return 0..nodes.len();
        };
        nodes.partition_point(|&m| m < low)..nodes.partition_point(|&m| m <= high)
    }
}

/// The default grid of `coverage`, without regard to an error: 14 displacements, denser under low loads, 5 centre distances, 17
/// misalignments denser at parallel axes and two beyond either end, 36 mesh positions.
pub fn default_axes(coverage: &Coverage) -> Axes {
    Axes {
        displacement_fraction: displacement_nodes(14, 1.8),
        center_distance_offset: coverage.offsets(5),
        misalignment: coverage.with_outside(coverage.graded_misalignments(MISALIGNMENTS, GRADING)),
        mesh_position: mesh_positions(36),
    }
}

/// The spline through `grid`; `None` where it is too coarse for one.
pub(super) fn through(grid: &FlankGrid) -> Result<Option<FlankTable>, TableError> {
    match FlankTable::new(grid, Interpolation::Spline) {
        Ok(table) => Ok(Some(table)),
        Err(TableError::TooCoarse { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Misalignments for `coverage`, rad: those of [`default_axes`], or half as many again that are closer at parallel axes, where a table through
/// these is off under a low load.
///
/// # Errors
/// A solve that fails.
pub fn misalignments(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
) -> Result<Vec<f64>, TableError> {
    let mut best = default_axes(coverage).misalignment;
    let Some(range) = coverage.misalignment else {
        return Ok(best);
    };
    let mut apart = least_distance(&best);
    let mut error = low_load_error(source, geometry, coverage, &best)?;
    for _ in 0..TIMES {
        if error <= LOW_LOAD_ERROR {
            break;
        }
        apart /= CLOSER;
        let nodes = coverage.with_outside(graded_to(range, MISALIGNMENTS_CLOSER, apart));
        let found = low_load_error(source, geometry, coverage, &nodes)?;
        if found < WORTH * error {
            (error, best) = (found, nodes);
        }
    }
    Ok(best)
}

/// Error under [`LOW_LOAD`] of tables over the misalignments `nodes` (rad) at the nominal centre distance, root of the mean square over
/// the range: of the approach, over the root of the mean square of that from flanks that just touch at an end of the face, or of the place
/// of the force over half the face if that is larger. It is taken halfway between the nodes. Infinite where no table goes through them.
pub(super) fn low_load_error(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
    nodes: &[f64],
) -> Result<f64, TableError> {
    let flank = Flank::Drive;
    let half_face = 0.5 * geometry.face_overlap().1;
    let torque = Prescribed::Torque(LOW_LOAD * coverage.nominal_torque);
    let inside = &nodes[coverage.inside_of(nodes)];
    // Integrals over the misalignment of the squares of the approach, of its error and of that of the place; none without a table.
    let at_position = |p: f64| -> Result<Option<[f64; 3]>, TableError> {
        let axes = Axes {
            center_distance_offset: vec![0.0],
            misalignment: nodes.to_vec(),
            mesh_position: vec![p],
            ..default_axes(coverage)
        };
        let grid = sweep(source, flank, &axes, coverage.maximum_torque, &|_, _| ())?;
        let Some(table) = through(&grid)? else {
            return Ok(None);
        };
        let mut position =
            (source.position(flank, p, 0.0)).map_err(failed(flank, [0.0, 0.0, p]))?;
        let mut sums = [0.0; 3];
        for ends in inside.windows(2) {
            let m = 0.5 * (ends[0] + ends[1]);
            let exact = position
                .solve(torque, m)
                .map_err(failed(flank, [0.0, m, p]))?;
            let mut query = Query::from([exact.approach, 0.0, m, p]);
            query.delta = table.approach_at(exact.loa_force, &query);
            let moment = table.evaluate(&query, false).gradient[2];
            let values = [
                exact.approach + m.abs() * half_face,
                query.delta - exact.approach,
                (moment - exact.moment) / (exact.loa_force * half_face),
            ];
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += (ends[1] - ends[0]) * value * value;
            }
        }
        Ok(Some(sums))
    };
    let positions = mesh_positions(TRIED_POSITIONS).into_par_iter();
    let sums: Vec<_> = positions.map(at_position).collect::<Result<_, _>>()?;
    let Some(sums) = sums.into_iter().collect::<Option<Vec<_>>>() else {
        return Ok(f64::INFINITY);
    };
    let [squares, approach, place] =
        [0, 1, 2].map(|k| sums.iter().map(|sums| sums[k]).sum::<f64>());
    let range = inside[inside.len() - 1] - inside[0];
    let place = place / (TRIED_POSITIONS as f64 * range);
    Ok((approach / squares).max(place).sqrt())
}

pub(super) const SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// Held-out points of a table that share a mesh position and a centre distance, whose influence matrix costs as much as many
/// solves.
pub(super) const TOGETHER: usize = 8;

/// Random operating points at one mesh position and centre distance.
pub(super) struct Held {
    pub mesh_position: f64,
    /// m.
    pub center_distance_offset: f64,
    /// Torques on gear 1, N m, and misalignments, rad.
    pub loads: Vec<[f64; 2]>,
}

impl Coverage {
    /// At least `count` random operating points, `together` of them at a position: torques even in (0, maximum), mesh positions
    /// in a cycle, the other coordinates in their ranges.
    ///
    /// They are a Latin hypercube (McKay, Beckman, Conover, Technometrics 21 (1979) 239-245): each coordinate has one value in each
    /// of as many equal parts of its range as it has values, in random order. So what follows one coordinate alone leaves next to no
    /// scatter in means over the points. Measured on three shipped pairs: 1000 of them, eight at a position, scatter about the error
    /// of the table no more than 1000 independent points do (5, 7 and 14 % of the rms error of the force for 5, 8 and 15 %).
    pub(super) fn draw(&self, mut random: Random, count: usize, together: usize) -> Vec<Held> {
        let positions = count.div_ceil(together);
        let mut spread = |n: usize, range: Option<[f64; 2]>| match range {
            Some(range) => stratified(&mut random, n, range),
            None => vec![0.0; n],
        };
        let mesh_positions = spread(positions, Some([0.0, 1.0]));
        let offsets = spread(positions, self.center_distance_offset);
        let torques = spread(positions * together, Some([0.0, self.maximum_torque]));
        let misalignments = spread(positions * together, self.misalignment);
        let loads: Vec<[f64; 2]> = torques
            .into_iter()
            .zip(misalignments)
            .map(<[f64; 2]>::from)
            .collect();
        let at = mesh_positions.into_iter().zip(offsets);
        let held = at.zip(loads.chunks(together));
        held.map(|((mesh_position, center_distance_offset), loads)| Held {
            mesh_position,
            center_distance_offset,
            loads: loads.to_vec(),
        })
        .collect()
    }

    /// A random point but for its approach, its mesh position within `cycles`.
    pub(super) fn draw_query(&self, random: &mut Random, cycles: f64) -> Query {
        let [c, m] = [self.center_distance_offset, self.misalignment]
            .map(|range| range.map_or(0.0, |range| random.within(range)));
        Query::from([0.0, c, m, cycles * random.next()])
    }
}

/// `n` numbers in [low, high), one in each of `n` equal parts, in random order.
pub(super) fn stratified(random: &mut Random, n: usize, [low, high]: [f64; 2]) -> Vec<f64> {
    let part = (high - low) / n as f64;
    let mut numbers: Vec<f64> = (0..n)
        .map(|i| low + part * (i as f64 + random.next()))
        .collect();
    // Fisher and Yates.
    for i in (1..n).rev() {
        numbers.swap(i, (random.next() * (i + 1) as f64) as usize);
    }
    numbers
}

/// Force (N) and its moment at an end of the face (N m) that errors are related to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nominal {
    pub force: f64,
    pub moment: f64,
}

impl Nominal {
    pub fn new(geometry: &PairGeometry, coverage: &Coverage) -> Nominal {
        let force = coverage.nominal_torque / geometry.gears[0].base_radius();
        Nominal {
            force,
            moment: force * 0.5 * geometry.face_overlap().1,
        }
    }

    /// Errors of the derivatives `found` of a potential against force and moment, and that force, over those here.
    pub fn errors(self, found: &[f64; 4], force: f64, moment: f64) -> [f64; 3] {
        [
            (found[0] - force) / self.force,
            (found[2] - moment) / self.moment,
            force / self.force,
        ]
    }
}

/// Errors at all of `held` by what `at` says of those at one position.
pub(super) fn errors<const N: usize>(
    held: &[Held],
    at: impl Fn(&Held) -> Result<Vec<[f64; N]>, TableError> + Sync,
) -> Result<Vec<[f64; N]>, TableError> {
    let errors: Vec<Vec<[f64; N]>> = held.par_iter().map(&at).collect::<Result<_, _>>()?;
    Ok(errors.concat())
}

/// Error of the gradient that `found` gives of a potential against `source` at the points `held`.
pub(super) fn measure_at(
    source: &dyn StaticSource,
    flank: Flank,
    nominal: Nominal,
    found: impl Fn(&Query) -> Result<[f64; 4], ContactError> + Sync,
    held: &[Held],
) -> Result<InterpolationError, TableError> {
    let errors = errors(held, |held| {
        let (p, c) = (held.mesh_position, held.center_distance_offset);
        let mut position = (source.position(flank, p, c)).map_err(failed(flank, [c, 0.0, p]))?;
        let errors = held.loads.iter().map(|&[torque, m]| {
            let failed = failed(flank, [c, m, p]);
            let exact = position.solve(Prescribed::Torque(torque), m);
            let exact = exact.map_err(&failed)?;
            let found = found(&Query::from([exact.approach, c, m, p])).map_err(failed)?;
            Ok(nominal.errors(&found, exact.loa_force, exact.moment))
        });
        errors.collect()
    })?;
    Ok(InterpolationError::of(&errors))
}

/// Error of `table` against `source` at `points` random operating points: torques even in (0, maximum), the
/// other coordinates even in their ranges. They are at least as many, eight at each of their mesh positions and centre distances.
///
/// # Errors
/// A solve that fails.
pub fn measure(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    flank: Flank,
    coverage: &Coverage,
    table: &FlankTable,
    points: usize,
) -> Result<InterpolationError, TableError> {
    let nominal = Nominal::new(geometry, coverage);
    measure_at(
        source,
        flank,
        nominal,
        |q| Ok(table.evaluate(q, false).gradient),
        &coverage.draw(Random::new(SEED), points, TOGETHER),
    )
}

/// Error of `contact` at run time, its teeth taken as alike, against `source` at `points` random operating points, likewise.
///
/// # Errors
/// A solve that fails, at run time or not; a flank that `contact` does not hold.
pub fn measure_at_run_time(
    source: &dyn StaticSource,
    contact: &ContactFile,
    flank: Flank,
    coverage: &Coverage,
    points: usize,
) -> Result<InterpolationError, TableError> {
    let mut alike = contact.clone();
    Arc::make_mut(&mut alike.setup).teeth = PairTeeth::default();
    let at_run_time = alike.flank(flank).ok_or_else(no_coast_flank)?;
    let held = coverage.draw(Random::new(SEED), points, 1);
    let nominal = Nominal::new(&contact.setup.geometry, coverage);
    measure_at(
        source,
        flank,
        nominal,
        |q| {
            let found = at_run_time.potential(q.coordinates(), [0; 2], &mut Warm::default())?;
            Ok(found.gradient)
        },
        &held,
    )
}

pub(super) fn no_coast_flank() -> TableError {
    TableError::Failed("the contact at run time has no coast flank of its own".into())
}
