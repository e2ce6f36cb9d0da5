//! y'' + 2 zeta y' + k(tau) max(y, 0) = 1, k = 1 + eps cos(Omega tau), realised with the element.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, even, percent};
use crate::driver::{INERTIA, Spin};
use crate::setup::external_and_internal;
use crate::{Context, Result};
use gearmesh::element::{LoadedFlank, Parameters};
use std::f64::consts::{PI, TAU};

/// Torque on gear 2, N m.
const TORQUE: f64 = 100.0;
/// Steps in a mesh cycle.
const STEPS: usize = 160;

/// A spring with k(PMC) and the damping of gear 2.
struct Case {
    depth: f64,
    zeta: f64,
}

/// The system of `case` at frequency ratio `frequency`, and the speed of gear 1. Deflections stay far below the pitch and
/// in one gap: drive flank alone, no damping in the mesh.
fn oscillator(case: &Case, frequency: f64) -> Result<(SingleFreedom, f64)> {
    let [pair, _] = external_and_internal();
    let omega = (STIFFNESS / INERTIA).sqrt() * pair.gears[1].base_radius();
    // One mesh cycle per period of the stiffness.
    let speed = frequency * omega / pair.gears[0].z();
    let mut parameters = Parameters::default();
    (parameters.loaded_flank, parameters.damping) = (LoadedFlank::Drive, 0.0);
    let law = ModulatedSpring::new(case.depth);
    let system = SingleFreedom::new(&pair, &parameters, law, TORQUE, Spin::speed(speed))?;
    Ok((system.damped(case.zeta, speed, TORQUE), speed))
}

/// State carried from one frequency to the next: y and its rate at the start of a mesh cycle.
#[derive(Clone, Copy)]
struct Motion {
    y: f64,
    rate: f64,
}

/// Settles for `settle` periods, then the rms of y about its mean over 20 periods, and the motion there.
fn run(case: &Case, frequency: f64, start: Motion, settle: usize) -> Result<(f64, Motion)> {
    const MEASURED: usize = 20;
    let (o, speed) = oscillator(case, frequency)?;
    let h = TAU / frequency / o.omega / STEPS as f64;
    let mut state = o.start(start.y, start.rate, speed);
    let (mut sum, mut squares) = (0.0, 0.0);
    let steps = (settle + MEASURED) * STEPS;
    for n in 0..steps {
        let t = n as f64 * h;
        if n >= settle * STEPS {
            let y = o.deflection(t, &state)?.y;
            sum += y;
            squares += y * y;
        }
        state = o.scene.step(t, &state, h)?;
    }
    let count = (MEASURED * STEPS) as f64;
    let rms = (squares / count - (sum / count).powi(2)).max(0.0).sqrt();
    let end = o.deflection(steps as f64 * h, &state)?;
    let (y, rate) = (end.y, end.rate);
    Ok((rms, Motion { y, rate }))
}

/// A point of a sweep.
struct Response {
    frequency: f64,
    rms: f64,
}

/// rms over frequency along a sweep.
fn sweep(case: &Case, from: f64, to: f64) -> Result<Vec<Response>> {
    let settle = (4.0 / (TAU * case.zeta)).ceil() as usize * 3;
    let count = ((to - from).abs() / 0.005).round() as usize;
    let mut motion = Motion { y: 1.0, rate: 0.0 };
    let mut curve = vec![];
    for frequency in even([from, to], count + 1) {
        let rms;
        (rms, motion) = run(case, frequency, motion, settle)?;
        curve.push(Response { frequency, rms });
    }
    Ok(curve)
}

/// Frequency of the last point of a sweep before its largest step.
fn jump(curve: &[Response]) -> f64 {
    let step = |w: &[Response]| (w[1].rms - w[0].rms).abs();
    let largest = curve.windows(2).max_by(|a, b| step(a).total_cmp(&step(b)));
    largest.map_or(f64::NAN, |w| w[0].frequency)
}

/// rms of the point next to `frequency`.
fn rms_near(curve: &[Response], frequency: f64) -> f64 {
    let off = |p: &Response| (p.frequency - frequency).abs();
    let nearest = curve.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.map_or(f64::NAN, |p| p.rms)
}

/// Period of the undamped free motion with amplitude `a` about y = 1 (a > 1: with contact loss), scaled time.
fn free_period(a: f64) -> Result<f64> {
    let case = Case {
        depth: 0.0,
        zeta: 0.0,
    };
    let (o, _) = oscillator(&case, 1e-9)?;
    let h = 2e-3 / o.omega;
    let mut state = o.start(1.0 + a, 0.0, 0.0);
    let (mut t, mut before) = (0.0, a);
    let mut crossings = vec![];
    while crossings.len() < 3 {
        state = o.scene.step(t, &state, h)?;
        let now = o.deflection(t, &state)?.y - 1.0;
        if before > 0.0 && now <= 0.0 {
            crossings.push((t + h * before / (before - now)) * o.omega);
        }
        before = now;
        t += h;
    }
    Ok(crossings[2] - crossings[1])
}

/// The same in closed form: a part of a circle in contact, a parabola out of it.
fn exact_period(a: f64) -> f64 {
    2.0 * (PI - (1.0 / a).acos()) + 2.0 * (a * a - 1.0).sqrt()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for (depth, zeta, up, down) in [(0.2, 0.03, 0.895, 0.70), (0.1, 0.01, 0.945, 0.605)] {
        if context.quick && depth < 0.2 {
            continue;
        }
        let case = Case { depth, zeta };
        let rising = sweep(&case, up - 0.1, up + 0.05)?;
        let falling = sweep(&case, up + 0.05, down - 0.03)?;
        let name = format!("eps {depth}, zeta {zeta}");
        for (what, expected, curve) in [("jump up", up, &rising), ("jump down", down, &falling)] {
            rows.push(format!("{name} | {what} | {expected} | {:.3}", jump(curve)));
        }
        if depth == 0.2 {
            for (branch, expected, curve) in [("lower", 0.529, &rising), ("upper", 1.539, &falling)]
            {
                let found = rms_near(curve, 0.85);
                let what = format!("{name} | rms at 0.85, {branch} branch");
                rows.push(format!("{what} | {expected} | {found:.6}"));
            }
        }
    }
    for a in [1.5_f64, 2.0, 4.0, 8.0] {
        let (exact, found) = (exact_period(a), free_period(a)?);
        let off = percent(found, exact);
        rows.push(format!(
            "free, undamped, amplitude {a} | period | {exact:.5} | {found:.5} ({off:+.4} %)"
        ));
    }
    let head = "case | quantity | expected | found";
    data.table("oscillator", head, &rows)
}
