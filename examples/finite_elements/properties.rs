//! What any contact solution must fulfil: over the load, the misalignment and the centre distance.

use crate::cases::{Models, paper, thick_spur};
use crate::page::{Outcome, largest, line, plot, table, verdict};
use gearmesh::contact::{ContactResult, ContactSolver, PositionProblem};
use gearmesh::gear::Flank;
use rayon::prelude::*;
use std::path::Path;

const POSITIONS: usize = 16;
const TORQUE: f64 = 100.0;

/// Solutions over a range of one coordinate, at each position of the mesh cycle.
struct Sweep {
    at: Vec<f64>,
    /// By position, then by coordinate.
    results: Vec<Vec<ContactResult>>,
}

impl Sweep {
    /// Mean over the cycle at coordinate `i` of `value`.
    fn mean(&self, i: usize, value: fn(&ContactResult) -> f64) -> f64 {
        self.results.iter().map(|r| value(&r[i])).sum::<f64>() / self.results.len() as f64
    }

    fn curve(&self, scale: [f64; 2], value: fn(&ContactResult) -> f64) -> Vec<(f64, f64)> {
        let points = self.at.iter().enumerate();
        points
            .map(|(i, x)| (scale[0] * x, scale[1] * self.mean(i, value)))
            .collect()
    }

    fn swing(&self, scale: f64) -> Vec<(f64, f64)> {
        let spread = |i: usize| {
            let values = self.results.iter().map(|r| r[i].approach);
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            1e6 * (high - low)
        };
        let points = self.at.iter().enumerate();
        points.map(|(i, x)| (scale * x, spread(i))).collect()
    }

    /// Least step of `value` from one coordinate to the next, at any position.
    fn least_step(&self, value: fn(&ContactResult) -> f64) -> f64 {
        let steps = self.results.iter().flat_map(|r| r.windows(2));
        steps
            .map(|w| value(&w[1]) - value(&w[0]))
            .fold(f64::MAX, f64::min)
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
) -> Outcome<[f64; 2]> {
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

fn positions(solver: &ContactSolver, offset: f64) -> Outcome<Vec<PositionProblem>> {
    (0..POSITIONS)
        .map(|i| Ok(solver.position(Flank::Drive, i as f64 / POSITIONS as f64, offset)?))
        .collect()
}

/// Solves at all `at` of (torque, misalignment) made by `point`.
fn sweep(problems: &[PositionProblem], at: Vec<f64>, point: fn(f64) -> [f64; 2]) -> Outcome<Sweep> {
    let results = problems
        .par_iter()
        .map(|problem| {
            let mut warm: Option<ContactResult> = None;
            at.iter()
                .map(|&x| {
                    let [torque, misalignment] = point(x);
                    let result = problem
                        .solve_torque(torque, misalignment, warm.as_ref())
                        .map_err(|e| e.to_string())?;
                    warm = Some(result.clone());
                    Ok(result)
                })
                .collect()
        })
        .collect::<Result<_, String>>()?;
    Ok(Sweep { at, results })
}

fn even(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n)
        .map(|i| low + (high - low) * i as f64 / (n - 1) as f64)
        .collect()
}

/// The chapter.
pub fn report(models: &Models, plots: &Path) -> Outcome<String> {
    let mut checks: Vec<[String; 4]> = vec![];
    let mut text = String::from(
        "Three pairs at level normal, 16 mesh positions: the paper's modified pair, the same unmodified, and the spur pair \
         20/20 of the convergence tables.\n\n",
    );
    let [
        mut by_load,
        mut by_tilt,
        mut shift,
        mut by_distance,
        mut swing,
    ] = [(); 5].map(|()| Vec::new());
    let pairs = [
        ("modified", paper(true, 30.0)?),
        ("unmodified", paper(false, 30.0)?),
        ("spur", thick_spur()?),
    ];
    for (name, pair) in pairs {
        eprintln!("    {name}");
        let solver = models.solver(&pair)?;
        let problems = positions(&solver, 0.0)?;
        let rb = solver.geometry().gears[0].base_radius();
        let by_torque = |t| [t, 0.0];
        let load = sweep(&problems, even(20.0, 200.0, 73), by_torque)?;
        let step = 1e6 * load.least_step(|r| r.approach);
        check(
            &mut checks,
            name,
            "least rise of the STE over 2.5 N m, µm",
            format!("{step:.3}"),
            "> 0",
            step > 0.0,
        );
        let jumps = sharpest(&problems, &load, by_torque, |r| {
            (rb * r.tangent.force_by_approach).recip()
        })?;
        smooth(
            &mut checks,
            format!("{name}: sharpest bend of the STE over the load, 2.5 N m"),
            jumps,
        );
        by_load.push(line(name, load.curve([1.0, 1e6], |r| r.approach)));
        swing.push(line(name, load.swing(1.0)));

        let by_misalignment = |m| [TORQUE, m];
        let tilt = sweep(&problems, even(-3e-3, 3e-3, 97), by_misalignment)?;
        let step = 1e3 * tilt.least_step(|r| r.contact_z);
        check(
            &mut checks,
            name,
            "least shift of z_c towards the closing side over 0.06 mrad, mm",
            format!("{step:.3}"),
            ">= 0",
            step >= 0.0,
        );
        let jumps = sharpest(&problems, &tilt, by_misalignment, |r| {
            -r.tangent.force_by_misalignment / r.tangent.force_by_approach
        })?;
        smooth(
            &mut checks,
            format!("{name}: sharpest bend of the STE over the misalignment, 0.06 mrad"),
            jumps,
        );
        if name == "spur" {
            let [ste, z] = asymmetry(&tilt, solver.geometry().z_ref());
            check(
                &mut checks,
                name,
                "STE(M) - STE(-M), largest, µm",
                format!("{:.1e}", 1e6 * ste),
                "< 1e-3",
                ste < 1e-9,
            );
            check(
                &mut checks,
                name,
                "z_c(M) + z_c(-M) - face, largest, mm",
                format!("{:.1e}", 1e3 * z),
                "< 1e-3",
                z < 1e-6,
            );
        }
        by_tilt.push(line(name, tilt.curve([1e3, 1e6], |r| r.approach)));
        shift.push(line(name, tilt.curve([1e3, 1e3], |r| r.contact_z)));

        let worst = integrability(&problems, rb)?;
        check(
            &mut checks,
            name,
            "dSTE/dM at constant F + d(F z_c)/dF at constant M, largest, mm",
            format!("{:.1e}", 1e3 * worst),
            "< 1e-3",
            worst < 1e-6,
        );

        let (distance, error) = over_distance(&solver)?;
        check(
            &mut checks,
            name,
            "STE over the centre distance, cubics through values 12.5 µm apart, largest error over the range, %",
            format!("{:.3}", 100.0 * error),
            "smooth: < 0.1",
            error < 1e-3,
        );
        by_distance.push(line(name, distance));
    }
    text += &table(["check", "found", "bar", ""], &checks);
    text += "Integrability: central differences of fresh solutions at 48 operating points per pair (torques 20 to 200 N m, \
             misalignments ±3 mrad), z_c from mid-face. *Sharpest bend*: where the tangent of the STE changes most from one \
             solution to the next, by how much of its value, and by how much still when the step is narrowed to the 2^-24th part \
             around the change: at a kink nothing would be lost. Where a tooth pair, a strip at an end of the face or a tip edge \
             comes into contact the tangent changes quickly, like 1/ln of the load there.\n\n";
    for (name, title, axes, lines) in [
        (
            "load",
            "Mean STE over the torque",
            ["torque, N m", "mean STE, um"],
            by_load,
        ),
        (
            "load-swing",
            "Peak-to-peak STE over the torque",
            ["torque, N m", "peak-to-peak STE, um"],
            swing,
        ),
        (
            "misalignment",
            "Mean STE over the misalignment, 100 N m",
            ["misalignment, mrad", "mean STE, um"],
            by_tilt,
        ),
        (
            "shuttling",
            "Mean z_c over the misalignment, 100 N m",
            ["misalignment, mrad", "z_c, mm"],
            shift,
        ),
        (
            "centre-distance",
            "Mean STE over the centre distance, 100 N m",
            ["centre distance offset, um", "mean STE, um"],
            by_distance,
        ),
    ] {
        text += &plot(plots, name, title, axes, lines)?;
    }
    Ok(text)
}

/// Adds a row: a number against its bar.
fn check(
    rows: &mut Vec<[String; 4]>,
    pair: &str,
    claim: &str,
    found: String,
    bar: &str,
    met: bool,
) {
    rows.push([
        format!("{pair}: {claim}"),
        found,
        bar.to_owned(),
        verdict(met).to_owned(),
    ]);
}

/// Adds a row: a jump over a step, and what is left of it over a tiny one.
fn smooth(rows: &mut Vec<[String; 4]>, claim: String, [wide, narrow]: [f64; 2]) {
    rows.push([
        claim,
        format!("{:.1} %, then {:.2} %", 100.0 * wide, 100.0 * narrow),
        "falls to 1/3".into(),
        verdict(narrow < wide / 3.0).to_owned(),
    ]);
}

/// Largest STE(M) - STE(-M) and z_c(M) + z_c(-M) - 2 z_ref, m. The mesh position is mirrored, too: a spur pair's
/// is not, since both flanks are straight along z.
fn asymmetry(tilt: &Sweep, z_ref: f64) -> [f64; 2] {
    let n = tilt.at.len();
    let mut worst = [0.0f64; 2];
    for r in &tilt.results {
        for i in 0..n {
            let (a, b) = (&r[i], &r[n - 1 - i]);
            worst[0] = worst[0].max((a.approach - b.approach).abs());
            worst[1] = worst[1].max((a.contact_z + b.contact_z - 2.0 * z_ref).abs());
        }
    }
    worst
}

/// Largest violation of d STE / dM at constant F = -d (F z_c) / dF at constant M, m.
fn integrability(problems: &[PositionProblem], base_radius: f64) -> Outcome<f64> {
    let points: Vec<(usize, f64, f64)> = (0..48)
        .map(|i| {
            let s = |a: f64| (0.5 + a * f64::from(i)).fract();
            let torque = 20.0 + 180.0 * s(0.754_877_7);
            (i as usize % POSITIONS, torque, 6e-3 * s(0.569_840_3) - 3e-3)
        })
        .collect();
    let violations = points
        .par_iter()
        .map(|&(position, torque, m)| -> Result<f64, String> {
            let solve = |t: f64, m: f64| {
                problems[position]
                    .solve_torque(t, m, None)
                    .map_err(|e| e.to_string())
            };
            // Short, since the tangent changes quickly where strips come into contact.
            let (dm, dt) = (2e-8, 2e-5 * torque);
            let by_tilt =
                (solve(torque, m + dm)?.approach - solve(torque, m - dm)?.approach) / (2.0 * dm);
            let (a, b) = (solve(torque + dt, m)?, solve(torque - dt, m)?);
            let by_force = (a.moment - b.moment) / (2.0 * dt / base_radius);
            Ok((by_tilt + by_force).abs())
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(violations.into_iter().fold(0.0, f64::max))
}

/// Points of a plot.
type Curve = Vec<(f64, f64)>;

/// Mean STE over the centre distance, (um, um), and how far cubics through values 12.5 um apart are from those
/// in the middle between, at any position, over the range of the STE.
fn over_distance(solver: &ContactSolver) -> Outcome<(Curve, f64)> {
    const COUNT: usize = 8;
    let offsets = even(-100e-6, 100e-6, 33);
    let columns = offsets
        .par_iter()
        .map(|&offset| -> Result<Vec<f64>, String> {
            (0..COUNT)
                .map(|i| {
                    let result = solver
                        .position(Flank::Drive, i as f64 / COUNT as f64, offset)
                        .and_then(|at| at.solve_torque(TORQUE, 0.0, None));
                    result.map(|r| r.approach).map_err(|e| e.to_string())
                })
                .collect()
        })
        .collect::<Result<Vec<_>, _>>()?;
    let mean = |c: &Vec<f64>| 1e6 * c.iter().sum::<f64>() / c.len() as f64;
    let curve = offsets
        .iter()
        .zip(&columns)
        .map(|(o, c)| (1e6 * o, mean(c)))
        .collect();
    let all = columns.iter().flatten();
    let (low, high) = all.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    let misses = (3..offsets.len() - 3).step_by(2).flat_map(|i| {
        let at = |k: usize| columns[k].iter();
        let near = at(i - 1).zip(at(i + 1)).map(|(a, b)| a + b);
        let far = at(i - 3).zip(at(i + 3)).map(|(a, b)| a + b);
        let between = near.zip(far).map(|(near, far)| (9.0 * near - far) / 16.0);
        between.zip(at(i)).map(|(a, b)| a - b).collect::<Vec<f64>>()
    });
    Ok((curve, largest(misses).abs() / (high - low)))
}
