//! y'' + 2 zeta y' + k(tau) max(y, 0) = 1, k = 1 + eps cos(Omega tau), realised with the element.

use crate::pair;
use crate::plot::{Line, Plot};
use gearmesh::driver::{Method, ModulatedSpring, SingleFreedom, Spin, State};
use gearmesh::element::{LoadedFlank, Parameters};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const STIFFNESS: f64 = 4.9e8;
const INERTIA: f64 = 4.213e-4;

/// The oscillator at frequency ratio `frequency`.
pub struct Oscillator {
    pub system: SingleFreedom,
    pub speed: f64,
}

/// Elongations stay far below the pitch and in one gap: drive flank alone, no damping in the mesh.
pub fn oscillator(
    depth: f64,
    zeta: f64,
    frequency: f64,
) -> Result<Oscillator, Box<dyn std::error::Error>> {
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
        depth,
    };
    let system = SingleFreedom::new(
        &pair,
        &parameters,
        law,
        INERTIA,
        100.0,
        zeta,
        Spin::speed(speed),
        speed,
    )?;
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
fn sweep(
    depth: f64,
    zeta: f64,
    from: f64,
    to: f64,
) -> Result<Vec<(f64, f64)>, Box<dyn std::error::Error>> {
    let settle = (4.0 / (TAU * zeta)).ceil() as usize * 3;
    let count = ((to - from).abs() / 0.005).round() as usize;
    let mut motion = (1.0, 0.0);
    let mut curve = Vec::new();
    for i in 0..=count {
        let frequency = from + (to - from) * i as f64 / count as f64;
        let o = oscillator(depth, zeta, frequency)?;
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
fn growth(depth: f64, zeta: f64, frequency: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let o = oscillator(depth, zeta, frequency)?;
    let steps = 120;
    let h = TAU / frequency / o.system.omega / steps as f64;
    // Near the forced motion 1 + eps/(Omega^2 - 1) cos(Omega tau), so that contact holds while the
    // difference is watched.
    let forced = 1.0 + depth / (frequency * frequency - 1.0);
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
fn edge(
    depth: f64,
    zeta: f64,
    mut inside: f64,
    mut outside: f64,
) -> Result<f64, Box<dyn std::error::Error>> {
    for _ in 0..8 {
        let middle = 0.5 * (inside + outside);
        if growth(depth, zeta, middle)? > 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Ok(0.5 * (inside + outside))
}

/// Period of the undamped free motion with amplitude `a` about y = 1 (a > 1: with contact loss), scaled time.
fn free_period(a: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let o = oscillator(0.0, 0.0, 1e-9)?;
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

/// The chapter.
pub fn report(folder: &Path) -> crate::Outcome {
    let mut text = String::from(
        "Gear 1 turns at a constant speed, gear 2 follows under a constant torque and a damper; the element has the law \
         W = k (1 + eps cos 2 pi PMC) delta^2 / 2, so that y'' + 2 zeta y' + k(tau) max(y, 0) = 1. Sweeps in steps of 0.005.\n\n\
         | case | quantity | expected | measured |\n|---|---|---|---|\n",
    );
    let mut lines = Vec::new();
    for (depth, zeta, up, down) in [(0.2, 0.03, 0.895, 0.70), (0.1, 0.01, 0.945, 0.605)] {
        let rising = sweep(depth, zeta, up - 0.1, up + 0.05)?;
        let falling = sweep(depth, zeta, up + 0.05, down - 0.03)?;
        let case = format!("eps {depth}, zeta {zeta}");
        writeln!(text, "| {case} | jump up | {up} | {:.3} |", jump(&rising))?;
        writeln!(
            text,
            "| {case} | jump down | {down} | {:.3} |",
            jump(&falling)
        )?;
        if depth == 0.2 {
            writeln!(
                text,
                "| {case} | rms at 0.85, lower branch | 0.529 | {:.4} |",
                at(&rising, 0.85)
            )?;
            writeln!(
                text,
                "| {case} | rms at 0.85, upper branch | 1.539 | {:.4} |",
                at(&falling, 0.85)
            )?;
        }
        lines.push(Line {
            name: format!("{case}, up"),
            points: rising,
        });
        lines.push(Line {
            name: format!("{case}, down"),
            points: falling,
        });
    }
    Plot {
        title: "Softening jump from contact loss",
        x: "Omega / omega",
        y: "rms of y",
        logarithmic: false,
        lines,
    }
    .save(&folder.join("jump.svg"))?;
    let (depth, zeta) = (0.2_f64, 0.03_f64);
    let half = (depth * depth / 4.0 - 4.0 * zeta * zeta).sqrt();
    for (name, sign) in [("lower", -1.0), ("upper", 1.0)] {
        let found = edge(
            depth,
            zeta,
            2.0 + sign * 0.4 * half,
            2.0 + sign * 1.8 * half,
        )?;
        writeln!(
            text,
            "| eps {depth}, zeta {zeta} | {name} edge of the parametric tongue | {:.4} | {found:.4} |",
            2.0 + sign * half
        )?;
    }
    for a in [1.5_f64, 2.0, 4.0, 8.0] {
        let exact = 2.0 * (std::f64::consts::PI - (1.0 / a).acos()) + 2.0 * (a * a - 1.0).sqrt();
        let found = free_period(a)?;
        writeln!(
            text,
            "| free, undamped, amplitude {a} | period | {exact:.5} | {found:.5} ({:+.4} %) |",
            100.0 * (found / exact - 1.0)
        )?;
    }
    text.push_str("\n![jump](stability/jump.svg)\n");
    Ok(text)
}
