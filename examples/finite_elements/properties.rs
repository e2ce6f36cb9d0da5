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

    /// Largest difference between the change of the STE over two steps of `stride` and the integral of its derivative
    /// `slope` by Simpson's rule, over the largest such change. A kink leaves the same share however short
    /// the steps; with a continuous derivative it falls with them.
    fn roughness(&self, stride: usize, slope: impl Fn(&ContactResult) -> f64) -> f64 {
        let (mut worst, mut largest): (f64, f64) = (0.0, 0.0);
        for r in &self.results {
            for i in (0..self.at.len() - 2 * stride).step_by(stride) {
                let (a, b, c) = (&r[i], &r[i + stride], &r[i + 2 * stride]);
                let change = c.approach - a.approach;
                let length = self.at[i + 2 * stride] - self.at[i];
                let integral = length / 6.0 * (slope(a) + 4.0 * slope(b) + slope(c));
                worst = worst.max((change - integral).abs());
                largest = largest.max(change.abs());
            }
        }
        worst / largest
    }

    /// [`Sweep::roughness`] of four steps at a time and of single ones.
    fn roughness_as_steps_shrink(&self, slope: impl Fn(&ContactResult) -> f64 + Copy) -> [f64; 2] {
        [4, 1].map(|stride| self.roughness(stride, slope))
    }
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
        let load = sweep(&problems, even(20.0, 200.0, 145), |t| [t, 0.0])?;
        let step = 1e6 * load.least_step(|r| r.approach);
        check(
            &mut checks,
            name,
            "least rise of the STE over 1.25 N m, µm",
            format!("{step:.3}"),
            "> 0",
            step > 0.0,
        );
        smooth(
            &mut checks,
            format!("{name}: STE over the load, double steps of 10 and 2.5 N m"),
            load.roughness_as_steps_shrink(|r| (rb * r.tangent.force_by_approach).recip()),
        );
        by_load.push(line(name, load.curve([1.0, 1e6], |r| r.approach)));
        swing.push(line(name, load.swing(1.0)));

        let tilt = sweep(&problems, even(-3e-3, 3e-3, 193), |m| [TORQUE, m])?;
        let step = 1e3 * tilt.least_step(|r| r.contact_z);
        check(
            &mut checks,
            name,
            "least shift of z_c towards the closing side over 0.03 mrad, mm",
            format!("{step:.3}"),
            ">= 0",
            step >= 0.0,
        );
        smooth(
            &mut checks,
            format!("{name}: STE over the misalignment, double steps of 0.25 and 0.06 mrad"),
            tilt.roughness_as_steps_shrink(|r| {
                -r.tangent.force_by_misalignment / r.tangent.force_by_approach
            }),
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

        let (distance, errors) = over_distance(&solver)?;
        smooth(
            &mut checks,
            format!(
                "{name}: STE over the centre distance, cubics through values 25 and 12.5 µm apart"
            ),
            errors,
        );
        by_distance.push(line(name, distance));
    }
    text += &table(["check", "found", "bar", ""], &checks);
    text += "Integrability: central differences of fresh solutions at 48 operating points per pair (torques 20 to 200 N m, \
             misalignments ±3 mrad), z_c from mid-face. *Smooth*: along load and misalignment the change of the STE over two \
             steps is compared with Simpson's integral of the solver's own tangent, along the centre distance values with the \
             cubic through their neighbours; the largest difference, as a share of the largest change (of the range), must fall as \
             the steps shrink, which it would not at a kink. Where a tooth pair or the end of the face comes into contact the \
             tangent changes quickly, like 1/ln of the load there, but without a jump.\n\n";
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

/// Adds a row: a difference that must fall as the steps shrink.
fn smooth(rows: &mut Vec<[String; 4]>, claim: String, [wide, narrow]: [f64; 2]) {
    rows.push([
        claim,
        format!("{:.3} %, {:.3} %", 100.0 * wide, 100.0 * narrow),
        "falls".into(),
        verdict(narrow < 0.7 * wide).to_owned(),
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

/// Mean STE over the centre distance, (um, um), and how far cubics through values 25 and 12.5 um apart are from
/// those in the middle between, at any position, over the range of the STE.
fn over_distance(solver: &ContactSolver) -> Outcome<(Curve, [f64; 2])> {
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
    let errors = [2, 1].map(|half| {
        let middles = (3 * half..offsets.len() - 3 * half).step_by(2 * half);
        let misses = middles.flat_map(|i| {
            let at = |k: usize| columns[k].iter();
            let near = at(i - half).zip(at(i + half)).map(|(a, b)| a + b);
            let far = at(i - 3 * half).zip(at(i + 3 * half)).map(|(a, b)| a + b);
            let between = near.zip(far).map(|(near, far)| (9.0 * near - far) / 16.0);
            between.zip(at(i)).map(|(a, b)| a - b).collect::<Vec<f64>>()
        });
        largest(misses).abs() / (high - low)
    });
    Ok((curve, errors))
}
