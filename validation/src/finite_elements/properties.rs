//! What any contact solution must fulfil: over the load, the misalignment and the centre distance.

use super::{paper, thick_spur};
use crate::data::{Data, even, fixed, largest, range, verdict};
use crate::{Context, Result, row};
use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use rayon::prelude::*;

const POSITIONS: usize = 16;
const TORQUE: f64 = 100.0;

/// Solutions over a range of one coordinate, at each position of the mesh cycle.
struct Sweep {
    at: Vec<f64>,
    /// By position, then by coordinate.
    results: Vec<Vec<ContactResult>>,
}

impl Sweep {
    /// Least step of `value` from one coordinate to the next, at any position.
    fn least_step(&self, value: fn(&ContactResult) -> f64) -> f64 {
        let steps = self.results.iter().flat_map(|r| r.windows(2));
        steps.map(|w| value(&w[1]) - value(&w[0])).fold(f64::MAX, f64::min)
    }
}

/// The jump of the derivative `slope` of the STE where it is largest from one coordinate of `sweep` to the next,
/// over its value: over that step, and over the 2^-24th part of it into which the jump is followed by halving. At
/// a kink both are the same.
fn sharpest(
    problems: &[PositionProblem],
    sweep: &Sweep,
    point: fn(f64) -> [f64; 2],
    slope: impl Fn(&ContactResult) -> f64,
) -> Result<[f64; 2]> {
    let jump = |a: f64, b: f64| (a - b).abs() / a.abs().max(b.abs());
    let (mut largest, mut at) = (0.0, (0, 0));
    for (position, results) in sweep.results.iter().enumerate() {
        for (i, pair) in results.windows(2).enumerate() {
            let found = (slope(&pair[0]) - slope(&pair[1])).abs();
            if found > largest {
                (largest, at) = (found, (position, i));
            }
        }
    }
    let (position, i) = at;
    let [mut low, mut high] = [i, i + 1].map(|i| (sweep.at[i], slope(&sweep.results[position][i])));
    let first = jump(low.1, high.1);
    for _ in 0..24 {
        let x = 0.5 * (low.0 + high.0);
        let [torque, misalignment] = point(x);
        let middle = slope(&problems[position].solve_torque(torque, misalignment, None)?);
        if (middle - low.1).abs() > (high.1 - middle).abs() {
            high = (x, middle);
        } else {
            low = (x, middle);
        }
    }
    Ok([first, jump(low.1, high.1)])
}

fn positions(solver: &ContactSolver, offset: f64) -> Result<Vec<PositionProblem>> {
    (0..POSITIONS).map(|i| Ok(solver.position(Flank::Drive, i as f64 / POSITIONS as f64, offset)?)).collect()
}

/// Solves at all `at` of (torque, misalignment) made by `point`.
fn sweep(problems: &[PositionProblem], at: Vec<f64>, point: fn(f64) -> [f64; 2]) -> Result<Sweep> {
    let results = problems
        .par_iter()
        .map(|problem| {
            let mut warm: Option<ContactResult> = None;
            at.iter()
                .map(|&x| {
                    let [torque, misalignment] = point(x);
                    let result = problem.solve_torque(torque, misalignment, warm.as_ref())?;
                    warm = Some(result.clone());
                    Ok(result)
                })
                .collect()
        })
        .collect::<Result<_>>()?;
    Ok(Sweep { at, results })
}

/// A number against its bar, as a row.
fn check(claim: String, found: String, bar: &str, met: bool) -> Vec<String> {
    row![claim, found, bar, verdict(met)]
}

/// A jump over a step, and what is left of it over a tiny one.
fn smooth(claim: String, [wide, narrow]: [f64; 2]) -> Vec<String> {
    let found = format!("{:.1} %, then {:.2} %", 100.0 * wide, 100.0 * narrow);
    check(claim, found, "falls to 1/3", narrow < wide / 3.0)
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let mut checks = vec![];
    let pairs = [("modified", paper(true, 30.0)?), ("unmodified", paper(false, 30.0)?), ("spur", thick_spur()?)];
    for (name, pair) in pairs.into_iter().skip(if context.quick { 2 } else { 0 }) {
        eprintln!("    {name}");
        let solver = context.models.solver(&pair)?;
        let problems = positions(&solver, 0.0)?;
        let rb = solver.geometry().gears[0].base_radius();
        let by_torque = |t| [t, 0.0];
        let load = sweep(&problems, even([20.0, 200.0], 73), by_torque)?;
        let step = 1e6 * load.least_step(|r| r.approach);
        checks.push(check(
            format!("{name}: least rise of the STE over 2.5 N m, µm"),
            fixed(step, 3),
            "> 0",
            step > 0.0,
        ));
        let claim = format!("{name}: sharpest bend of the STE over the load, 2.5 N m");
        let slope = |r: &ContactResult| (rb * r.tangent.force_by_approach).recip();
        checks.push(smooth(claim, sharpest(&problems, &load, by_torque, slope)?));

        let by_misalignment = |m| [TORQUE, m];
        let tilt = sweep(&problems, even([-3e-3, 3e-3], 97), by_misalignment)?;
        let step = 1e3 * tilt.least_step(|r| r.contact_z);
        let claim = format!("{name}: least shift of z_c towards the closing side over 0.06 mrad, mm");
        checks.push(check(claim, fixed(step, 3), ">= 0", step >= 0.0));
        let claim = format!("{name}: sharpest bend of the STE over the misalignment, 0.06 mrad");
        let slope = |r: &ContactResult| -r.tangent.force_by_misalignment / r.tangent.force_by_approach;
        checks.push(smooth(claim, sharpest(&problems, &tilt, by_misalignment, slope)?));

        let error = over_distance(&solver)?;
        let claim = format!(
            "{name}: STE over the centre distance, cubics through values 12.5 µm apart, largest error over the range, %"
        );
        checks.push(check(claim, fixed(100.0 * error, 3), "smooth: < 0.1", error < 1e-3));
    }
    data.table("properties", &["check", "found", "bar", ""], &checks)
}

/// How far cubics through values 12.5 um apart are from those
/// in the middle between, at any position, over the range of the STE.
fn over_distance(solver: &ContactSolver) -> Result<f64> {
    const COUNT: usize = 8;
    let offsets = even([-100e-6, 100e-6], 33);
    let columns = offsets
        .par_iter()
        .map(|&offset| -> Result<Vec<f64>> {
            (0..COUNT)
                .map(|i| {
                    let at = solver.position(Flank::Drive, i as f64 / COUNT as f64, offset)?;
                    Ok(at.solve_torque(TORQUE, 0.0, None)?.approach)
                })
                .collect()
        })
        .collect::<Result<Vec<_>>>()?;
    let [low, high] = range(columns.iter().flatten().copied());
    let misses = (3..offsets.len() - 3).step_by(2).flat_map(|i| {
        let at = |k: usize| columns[k].iter();
        let near = at(i - 1).zip(at(i + 1)).map(|(a, b)| a + b);
        let far = at(i - 3).zip(at(i + 3)).map(|(a, b)| a + b);
        let between = near.zip(far).map(|(near, far)| (9.0 * near - far) / 16.0);
        between.zip(at(i)).map(|(a, b)| a - b).collect::<Vec<f64>>()
    });
    Ok(largest(misses).abs() / (high - low))
}
