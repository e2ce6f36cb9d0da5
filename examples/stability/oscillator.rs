//! y'' + 2 zeta y' + k(tau) max(y, 0) = 1, k = 1 + eps cos(Omega tau), realised with the element.

use crate::driver::{Method, Spin, State};
use crate::experiment::{ModulatedSpring, SingleFreedom};
use crate::pair;
use crate::plot::{Line, Plot};
use crate::tables;
use gearmesh::element::{Element, FlankLaws, LoadedFlank, Parameters};
use gearmesh::table::FlankTable;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

const STIFFNESS: f64 = 4.9e8;
const INERTIA: f64 = 4.213e-4;

/// Mesh positions of the imported table.
const POSITIONS: usize = 32;

/// A spring with k(PMC) and the damping of gear 2.
struct Case {
    depth: f64,
    zeta: f64,
    /// The imported table; `None`: the law in closed form.
    table: Option<Arc<FlankTable>>,
}

impl Case {
    fn imported(depth: f64, zeta: f64) -> Result<Self, Box<dyn std::error::Error>> {
        let table = Some(tables::imported_spring(STIFFNESS, depth, POSITIONS)?);
        Ok(Self { depth, zeta, table })
    }

    fn closed_form(depth: f64, zeta: f64) -> Self {
        Self {
            depth,
            zeta,
            table: None,
        }
    }
}

/// The oscillator at frequency ratio `frequency`.
struct Oscillator {
    system: SingleFreedom,
    speed: f64,
}

/// Elongations stay far below the pitch and in one gap: drive flank alone, no damping in the mesh.
fn oscillator(case: &Case, frequency: f64) -> Result<Oscillator, Box<dyn std::error::Error>> {
    let pair = pair::external();
    let rb = pair.gears[1].base_radius();
    let omega = (STIFFNESS * rb * rb / INERTIA).sqrt();
    // One mesh cycle per period of the stiffness.
    let speed = frequency * omega / pair.gears[0].z();
    let parameters = Parameters {
        loaded_flank: LoadedFlank::Drive,
        damping: 0.0,
        ..Parameters::default()
    };
    let law = ModulatedSpring {
        stiffness: STIFFNESS,
        depth: case.depth,
    };
    let mut system = SingleFreedom::new(
        &pair,
        &parameters,
        law,
        INERTIA,
        100.0,
        case.zeta,
        Spin::speed(speed),
        speed,
    )?;
    if let Some(table) = &case.table {
        let laws = FlankLaws {
            drive: table.clone(),
            coast: None,
        };
        system.scene.element = Element::with_laws(&pair, &parameters, &laws)?;
    }
    Ok(Oscillator { system, speed })
}

/// State carried from one frequency to the next: y and its rate at the start of a mesh cycle.
type Motion = (f64, f64);

/// Settle for `settle` periods, then rms of y about its mean over `measure` periods, and the motion there.
fn run(
    o: &Oscillator,
    frequency: f64,
    start: Motion,
    settle: usize,
    measure: usize,
) -> Result<(f64, Motion), Box<dyn std::error::Error>> {
    let steps = 160;
    let period = TAU / frequency / o.system.omega;
    let h = period / steps as f64;
    let mut y: State = o.system.start(start.0, start.1, o.speed);
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut before = start.0;
    for n in 0..(settle + measure) * steps {
        let t = n as f64 * h;
        if n >= settle * steps {
            let value = o.system.elongation(t, &y)?;
            sum += value;
            squares += value * value;
        }
        if n + 1 == (settle + measure) * steps {
            before = o.system.elongation(t, &y)?;
        }
        y = Method::RungeKutta4.step(&o.system.scene, t, &y, h)?;
    }
    let end = o
        .system
        .elongation((settle + measure) as f64 * period, &y)?;
    let count = (measure * steps) as f64;
    let mean = sum / count;
    Ok((
        (squares / count - mean * mean).max(0.0).sqrt(),
        (end, (end - before) / (h * o.system.omega)),
    ))
}

/// rms over frequency along a sweep.
fn sweep(case: &Case, from: f64, to: f64) -> Result<Vec<(f64, f64)>, Box<dyn std::error::Error>> {
    let settle = (4.0 / (TAU * case.zeta)).ceil() as usize * 3;
    let count = ((to - from).abs() / 0.005).round() as usize;
    let mut motion = (1.0, 0.0);
    let mut curve = Vec::new();
    for i in 0..=count {
        let frequency = from + (to - from) * i as f64 / count as f64;
        let o = oscillator(case, frequency)?;
        let (rms, next) = run(&o, frequency, motion, settle, 20)?;
        motion = next;
        curve.push((frequency, rms));
    }
    Ok(curve)
}

/// Frequency of the last point of a sweep before its largest step.
fn jump(curve: &[(f64, f64)]) -> f64 {
    curve
        .windows(2)
        .max_by(|a, b| (a[1].1 - a[0].1).abs().total_cmp(&(b[1].1 - b[0].1).abs()))
        .map_or(f64::NAN, |w| w[0].0)
}

fn at(curve: &[(f64, f64)], frequency: f64) -> f64 {
    curve
        .iter()
        .min_by(|a, b| (a.0 - frequency).abs().total_cmp(&(b.0 - frequency).abs()))
        .map_or(f64::NAN, |p| p.1)
}

/// Growth of a small difference per period at `frequency`, natural logarithm.
fn growth(case: &Case, frequency: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let o = oscillator(case, frequency)?;
    let steps = 120;
    let h = TAU / frequency / o.system.omega / steps as f64;
    // Near the forced motion 1 + eps/(Omega^2 - 1) cos(Omega tau), so that contact holds while the
    // difference is watched.
    let forced = 1.0 + case.depth / (frequency * frequency - 1.0);
    let mut pair = [forced, forced + 1e-7].map(|y| o.system.start(y, 0.0, o.speed));
    // Peak of the difference in an early and in a late window.
    let mut peaks = [0.0_f64; 2];
    let window = 16;
    let periods = 70;
    for n in 0..periods * steps {
        let t = n as f64 * h;
        let difference =
            (o.system.elongation(t, &pair[1])? - o.system.elongation(t, &pair[0])?).abs();
        let cycle = n / steps;
        if (window..2 * window).contains(&cycle) {
            peaks[0] = peaks[0].max(difference);
        } else if cycle >= periods - window {
            peaks[1] = peaks[1].max(difference);
        }
        for y in &mut pair {
            *y = Method::RungeKutta4.step(&o.system.scene, t, y, h)?;
        }
    }
    Ok((peaks[1] / peaks[0]).ln())
}

/// Edge of the tongue at 2 by bisection between `inside` and `outside`.
fn edge(case: &Case, mut inside: f64, mut outside: f64) -> Result<f64, Box<dyn std::error::Error>> {
    for _ in 0..8 {
        let middle = 0.5 * (inside + outside);
        if growth(case, middle)? > 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Ok(0.5 * (inside + outside))
}

/// Period of the undamped free motion with amplitude `a` about y = 1 (a > 1: with contact loss), scaled time.
fn free_period(case: &Case, a: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let o = oscillator(case, 1e-9)?;
    let h = 2e-3 / o.system.omega;
    let mut y = o.system.start(1.0 + a, 0.0, 0.0);
    let mut before = o.system.elongation(0.0, &y)? - 1.0;
    let mut crossings = Vec::new();
    let mut n = 0;
    while crossings.len() < 3 {
        let t = n as f64 * h;
        y = Method::RungeKutta4.step(&o.system.scene, t, &y, h)?;
        let now = o.system.elongation(t, &y)? - 1.0;
        if before > 0.0 && now <= 0.0 {
            crossings.push((t + h * before / (before - now)) * o.system.omega);
        }
        before = now;
        n += 1;
    }
    Ok(crossings[2] - crossings[1])
}

/// The same in closed form: a part of a circle in contact, a parabola out of it.
fn exact_period(a: f64) -> f64 {
    2.0 * (std::f64::consts::PI - (1.0 / a).acos()) + 2.0 * (a * a - 1.0).sqrt()
}

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = format!(
        "Gear 1 turns at a constant speed, gear 2 follows under a constant torque and a damper; the element has a linear spring whose \
         stiffness is k (1 + eps cos 2 pi PMC), so that y'' + 2 zeta y' + k(tau) max(y, 0) = 1. `imported`: the spring comes as a CSV of \
         static solutions ({POSITIONS} mesh positions, 6 torques from 0 to 1000 N m) through `table::import::import_csv` and the spline; \
         `closed form`: the same law as a formula. Sweeps in steps of 0.005; rms of y about its mean.\n\n\
         | case | quantity | expected | imported | closed form |\n|---|---|---|---|---|\n",
    );
    let mut lines = Vec::new();
    for (depth, zeta, up, down) in [(0.2, 0.03, 0.895, 0.70), (0.1, 0.01, 0.945, 0.605)] {
        let name = format!("eps {depth}, zeta {zeta}");
        let cases = [Case::imported(depth, zeta)?, Case::closed_form(depth, zeta)];
        let mut rising = Vec::new();
        let mut falling = Vec::new();
        for case in &cases {
            rising.push(sweep(case, up - 0.1, up + 0.05)?);
            falling.push(sweep(case, up + 0.05, down - 0.03)?);
        }
        writeln!(
            text,
            "| {name} | jump up | {up} | {:.3} | {:.3} |",
            jump(&rising[0]),
            jump(&rising[1])
        )?;
        writeln!(
            text,
            "| {name} | jump down | {down} | {:.3} | {:.3} |",
            jump(&falling[0]),
            jump(&falling[1])
        )?;
        if depth == 0.2 {
            for (branch, expected, curves) in
                [("lower", 0.529, &rising), ("upper", 1.539, &falling)]
            {
                writeln!(
                    text,
                    "| {name} | rms at 0.85, {branch} branch | {expected} | {:.6} | {:.6} |",
                    at(&curves[0], 0.85),
                    at(&curves[1], 0.85)
                )?;
            }
        }
        for (direction, mut curves) in [("up", rising), ("down", falling)] {
            lines.push(Line {
                name: format!("{name}, {direction}"),
                points: curves.swap_remove(0),
            });
        }
    }
    Plot {
        title: "Softening jump from contact loss, imported table",
        x: "Omega / omega",
        y: "rms of y",
        logarithmic: false,
        lines,
    }
    .save(&folder.join("jump.svg"))?;
    let (depth, zeta) = (0.2_f64, 0.03_f64);
    let cases = [Case::imported(depth, zeta)?, Case::closed_form(depth, zeta)];
    let half = (depth * depth / 4.0 - 4.0 * zeta * zeta).sqrt();
    for (name, sign) in [("lower", -1.0), ("upper", 1.0)] {
        let [imported, closed] = [&cases[0], &cases[1]]
            .map(|c| edge(c, 2.0 + sign * 0.4 * half, 2.0 + sign * 1.8 * half));
        writeln!(
            text,
            "| eps {depth}, zeta {zeta} | {name} edge of the parametric tongue | {:.4} | {:.4} | {:.4} |",
            2.0 + sign * half,
            imported?,
            closed?
        )?;
    }
    let cases = [Case::imported(0.0, 0.0)?, Case::closed_form(0.0, 0.0)];
    for a in [1.5_f64, 2.0, 4.0, 8.0] {
        let exact = exact_period(a);
        let found = [free_period(&cases[0], a)?, free_period(&cases[1], a)?]
            .map(|t| format!("{t:.5} ({:+.4} %)", 100.0 * (t / exact - 1.0)));
        writeln!(
            text,
            "| free, undamped, amplitude {a} | period | {exact:.5} | {} | {} |",
            found[0], found[1]
        )?;
    }
    text.push_str("\n![jump](stability/jump.svg)\n");
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn imported(depth: f64, zeta: f64) -> Case {
        Case::imported(depth, zeta).unwrap()
    }

    #[test]
    fn branches_end_where_the_literature_has_the_jumps_and_are_as_high_as_there() {
        let case = imported(0.2, 0.03);
        let rising = sweep(&case, 0.85, 0.91).unwrap();
        let falling = sweep(&case, 0.92, 0.68).unwrap();
        for (curve, frequency, rms) in [(&rising, 0.895, 0.529), (&falling, 0.70, 1.539)] {
            let found = jump(curve);
            assert!(
                (found - frequency).abs() < 0.0051,
                "{found} for {frequency}"
            );
            let found = at(curve, 0.85);
            assert!((found - rms).abs() < 1e-3, "{found} for {rms}");
        }
    }

    #[test]
    fn the_parametric_tongue_is_as_wide_as_damping_and_depth_say() {
        let case = imported(0.2, 0.03);
        let half = (0.2_f64.powi(2) / 4.0 - 4.0 * 0.03_f64.powi(2)).sqrt();
        for side in [-1.0, 1.0] {
            assert!(growth(&case, 2.0 + 0.93 * side * half).unwrap() > 0.0);
            assert!(growth(&case, 2.0 + 1.07 * side * half).unwrap() < 0.0);
        }
    }

    #[test]
    fn free_motion_with_contact_loss_has_the_period_of_the_closed_form() {
        let case = imported(0.0, 0.0);
        for a in [1.5, 4.0] {
            let found = free_period(&case, a).unwrap();
            assert!((found / exact_period(a) - 1.0).abs() < 1e-6, "{a}: {found}");
        }
    }
}
