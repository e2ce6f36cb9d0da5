//! What any contact solution must fulfil: over the load, the misalignment and the centre distance.

use super::{paper, thick_spur};
use crate::data::{Data, even, largest, range, verdict};
use crate::{Context, Result};
use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use rayon::prelude::*;

const POSITIONS: usize = 16;
const TORQUE: f64 = 100.0;

/// Solutions over a range of one coordinate, at each position of the mesh cycle.
struct Sweep<'a> {
    problems: &'a [PositionProblem],
    /// Torque, N m, and misalignment, rad, at the coordinate.
    load: fn(f64) -> [f64; 2],
    coordinates: Vec<f64>,
    /// By position, then by coordinate.
    results: Vec<Vec<ContactResult>>,
}

impl<'a> Sweep<'a> {
    fn new(
        problems: &'a [PositionProblem],
        coordinates: Vec<f64>,
        load: fn(f64) -> [f64; 2],
    ) -> Result<Self> {
        let along = |problem: &PositionProblem| {
            let mut results: Vec<ContactResult> = vec![];
            for &x in &coordinates {
                let [torque, misalignment] = load(x);
                results.push(problem.solve_torque(torque, misalignment, results.last())?);
            }
            Ok(results)
        };
        let results = problems.par_iter().map(along).collect::<Result<_>>()?;
        Ok(Self {
            problems,
            load,
            coordinates,
            results,
        })
    }

    /// Least step of `value` from one coordinate to the next, at any position.
    fn least_step(&self, value: fn(&ContactResult) -> f64) -> f64 {
        let steps = self.results.iter().flat_map(|r| r.windows(2));
        steps
            .map(|w| value(&w[1]) - value(&w[0]))
            .fold(f64::MAX, f64::min)
    }

    /// The jump of the derivative `slope` of the STE where it is largest from one coordinate to the next, over its
    /// value: over that step, and over the 2^-24th part of it into which the jump is followed by halving. At a kink
    /// both are the same.
    fn sharpest(&self, slope: impl Fn(&ContactResult) -> f64) -> Result<[f64; 2]> {
        let jump = |a: f64, b: f64| (a - b).abs() / a.abs().max(b.abs());
        let (mut largest, mut spot) = (0.0, (0, 0));
        for (position, results) in self.results.iter().enumerate() {
            for (i, pair) in results.windows(2).enumerate() {
                let found = (slope(&pair[0]) - slope(&pair[1])).abs();
                if found > largest {
                    (largest, spot) = (found, (position, i));
                }
            }
        }
        let (position, i) = spot;
        let point = |i: usize| (self.coordinates[i], slope(&self.results[position][i]));
        let [mut low, mut high] = [point(i), point(i + 1)];
        let first = jump(low.1, high.1);
        for _ in 0..24 {
            let x = 0.5 * (low.0 + high.0);
            let [torque, misalignment] = (self.load)(x);
            let solved = self.problems[position].solve_torque(torque, misalignment, None)?;
            let middle = slope(&solved);
            let lower = (middle - low.1).abs() > (high.1 - middle).abs();
            *(if lower { &mut high } else { &mut low }) = (x, middle);
        }
        Ok([first, jump(low.1, high.1)])
    }
}

/// A jump over a step, and what is left of it over a tiny one.
fn smooth([wide, narrow]: [f64; 2]) -> String {
    let met = verdict(narrow < wide / 3.0);
    let found = format!("{:.1} %, then {:.2} %", 100.0 * wide, 100.0 * narrow);
    format!("{found} | falls to 1/3 | {met}")
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    let pairs = [
        ("modified", paper(true, 30.0)?),
        ("unmodified", paper(false, 30.0)?),
        ("spur", thick_spur()?),
    ];
    for (name, pair) in pairs.into_iter().skip(if context.quick { 2 } else { 0 }) {
        eprintln!("    {name}");
        let solver = context.models.solver(&pair)?;
        let mut problems = vec![];
        for i in 0..POSITIONS {
            let tau = i as f64 / POSITIONS as f64;
            problems.push(solver.position(Flank::Drive, tau, 0.0)?);
        }
        let mut check =
            |claim: &str, found: String| rows.push(format!("{name}: {claim} | {found}"));

        let load = Sweep::new(&problems, even([20.0, 200.0], 73), |torque| [torque, 0.0])?;
        let step = 1e6 * load.least_step(|r| r.approach);
        let found = format!("{step:.3} | > 0 | {}", verdict(step > 0.0));
        check("least rise of the STE over 2.5 N m, µm", found);
        let rb = solver.geometry().gears[0].base_radius();
        let bend = load.sharpest(|r| (rb * r.tangent.force_by_approach).recip())?;
        check(
            "sharpest bend of the STE over the load, 2.5 N m",
            smooth(bend),
        );

        let tilt = Sweep::new(&problems, even([-3e-3, 3e-3], 97), |tilt| [TORQUE, tilt])?;
        let step = 1e3 * tilt.least_step(|r| r.contact_z);
        let found = format!("{step:.3} | >= 0 | {}", verdict(step >= 0.0));
        check(
            "least shift of z_c towards the closing side over 0.06 mrad, mm",
            found,
        );
        let slope =
            |r: &ContactResult| -r.tangent.force_by_misalignment / r.tangent.force_by_approach;
        let bend = tilt.sharpest(slope)?;
        check(
            "sharpest bend of the STE over the misalignment, 0.06 mrad",
            smooth(bend),
        );

        let error = 100.0 * over_distance(&solver)?;
        let claim = "STE over the centre distance, cubics through values 12.5 µm apart, largest error over the range, %";
        check(
            claim,
            format!("{error:.3} | smooth: < 0.1 | {}", verdict(error < 0.1)),
        );
    }
    data.table("properties", "check | found | bar |", &rows)
}

/// How far cubics through values 12.5 um apart are from those
/// in the middle between, at any position, over the range of the STE.
fn over_distance(solver: &ContactSolver) -> Result<f64> {
    const COUNT: usize = 8;
    let offsets = even([-100e-6, 100e-6], 33);
    let column = |&offset: &f64| -> Result<Vec<f64>> {
        let solved = |i: usize| {
            let position = solver.position(Flank::Drive, i as f64 / COUNT as f64, offset)?;
            Ok(position.solve_torque(TORQUE, 0.0, None)?.approach)
        };
        (0..COUNT).map(solved).collect()
    };
    let columns = offsets.par_iter().map(column).collect::<Result<Vec<_>>>()?;
    let [low, high] = range(columns.iter().flatten().copied());
    let mut misses = vec![];
    for w in columns.windows(7).step_by(2) {
        let between = |i: usize| (9.0 * (w[2][i] + w[4][i]) - (w[0][i] + w[6][i])) / 16.0;
        misses.extend((0..COUNT).map(|i| between(i) - w[3][i]));
    }
    Ok(largest(misses).abs() / (high - low))
}
