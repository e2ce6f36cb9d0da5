//! y'' + 2 zeta y' + k(tau) max(y, 0) = 1, k = 1 + eps cos(Omega tau), realised with the element.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, last_that_holds, percent};
use crate::driver::{INERTIA, Spin};
use crate::setup::external_and_internal;
use crate::{Context, Result};
use gearmesh::element::{Element, FlankLaws, LoadedFlank, Parameters};
use gearmesh::table::{FlankTable, Interpolation};
use gearmesh_preprocessor::table::import;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::sync::Arc;

/// Mesh positions of the imported table, and the torque on gear 2, N m.
const POSITIONS: usize = 32;
const TORQUE: f64 = 100.0;
/// Steps in a mesh cycle.
const STEPS: usize = 160;

/// A spring with k(PMC) and the damping of gear 2.
struct Case {
    depth: f64,
    zeta: f64,
    /// The imported table; `None`: the law in closed form.
    table: Option<Arc<FlankTable>>,
}

impl Case {
    /// By way of a CSV file of static solutions, imported like those of any other program, and the law in closed form.
    fn both(depth: f64, zeta: f64) -> Result<[Self; 2]> {
        let [geometry, _] = external_and_internal();
        let z_mm = 1e3 * geometry.z_ref();
        let mut csv = import::COLUMNS.join(",");
        for torque in [0.0, 0.1, 1.0, 10.0, 100.0, 1000.0] {
            for n in 0..POSITIONS {
                let position = n as f64 / POSITIONS as f64;
                let k = STIFFNESS * (1.0 + depth * (TAU * position).cos());
                let ste_um = 1e6 * torque / geometry.gears[0].base_radius() / k;
                write!(csv, "\n{torque},{position},0,0,{ste_um},{z_mm}")?;
            }
        }
        let grid = import::import_csv(&csv, &geometry)?.grid;
        let imported = FlankTable::new(&grid, Interpolation::Spline)?;
        Ok([Some(Arc::new(imported)), None].map(|table| Self { depth, zeta, table }))
    }
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
    let mut system = system.damped(case.zeta, speed, TORQUE);
    if let Some(drive) = case.table.clone() {
        let laws = FlankLaws { drive, coast: None };
        system.scene.element = Element::with_laws(&pair, &parameters, &laws)?;
    }
    Ok((system, speed))
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
    Ok((
        rms,
        Motion {
            y: end.y,
            rate: end.rate,
        },
    ))
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
    for frequency in crate::data::even([from, to], count + 1) {
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

/// Growth of a small difference at `frequency` from an early to a late window, natural logarithm.
fn growth(case: &Case, frequency: f64) -> Result<f64> {
    let (o, speed) = oscillator(case, frequency)?;
    let steps = 120;
    let h = TAU / frequency / o.omega / steps as f64;
    // Near the forced motion 1 + eps/(Omega^2 - 1) cos(Omega tau), so that contact holds while the
    // difference is watched.
    let forced = 1.0 + case.depth / (frequency * frequency - 1.0);
    let mut pair = [forced, forced + 1e-7].map(|y| o.start(y, 0.0, speed));
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    let (window, periods) = (16, 70);
    for n in 0..periods * steps {
        let t = n as f64 * h;
        let difference = (o.deflection(t, &pair[1])?.y - o.deflection(t, &pair[0])?.y).abs();
        let cycle = n / steps;
        if (window..2 * window).contains(&cycle) {
            early = early.max(difference);
        } else if cycle >= periods - window {
            late = late.max(difference);
        }
        for y in &mut pair {
            *y = o.scene.step(t, y, h)?;
        }
    }
    Ok((late / early).ln())
}

/// Period of the undamped free motion with amplitude `a` about y = 1 (a > 1: with contact loss), scaled time.
fn free_period(case: &Case, a: f64) -> Result<f64> {
    let (o, _) = oscillator(case, 1e-9)?;
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
        let name = format!("eps {depth}, zeta {zeta}");
        let (mut rising, mut falling) = (vec![], vec![]);
        for case in Case::both(depth, zeta)? {
            rising.push(sweep(&case, up - 0.1, up + 0.05)?);
            falling.push(sweep(&case, up + 0.05, down - 0.03)?);
        }
        for (what, expected, curves) in [("jump up", up, &rising), ("jump down", down, &falling)] {
            let [imported, closed] = [0, 1].map(|i| jump(&curves[i]));
            rows.push(format!(
                "{name} | {what} | {expected} | {imported:.3} | {closed:.3}"
            ));
        }
        if depth == 0.2 {
            for (branch, expected, curves) in
                [("lower", 0.529, &rising), ("upper", 1.539, &falling)]
            {
                let [imported, closed] = [0, 1].map(|i| rms_near(&curves[i], 0.85));
                let what = format!("{name} | rms at 0.85, {branch} branch");
                rows.push(format!("{what} | {expected} | {imported:.6} | {closed:.6}"));
            }
        }
    }

    let (depth, zeta) = (0.2_f64, 0.03_f64);
    let [imported, closed] = Case::both(depth, zeta)?;
    let half = (depth * depth / 4.0 - 4.0 * zeta * zeta).sqrt();
    for (name, sign) in [("lower", -1.0), ("upper", 1.0)] {
        let edge = |case: &Case| -> Result<f64> {
            let around = [2.0 + sign * 0.4 * half, 2.0 + sign * 1.8 * half];
            let [inside, outside] = last_that_holds(around, 8, |f| Ok(growth(case, f)? > 0.0))?;
            Ok(0.5 * (inside + outside))
        };
        let what = format!("eps {depth}, zeta {zeta} | {name} edge of the parametric tongue");
        let (expected, found) = (2.0 + sign * half, [edge(&imported)?, edge(&closed)?]);
        rows.push(format!(
            "{what} | {expected:.4} | {:.4} | {:.4}",
            found[0], found[1]
        ));
    }
    let cases = Case::both(0.0, 0.0)?;
    for a in [1.5_f64, 2.0, 4.0, 8.0] {
        let exact = exact_period(a);
        let mut row = format!("free, undamped, amplitude {a} | period | {exact:.5}");
        for case in &cases {
            let t = free_period(case, a)?;
            row += &format!(" | {t:.5} ({:+.4} %)", percent(t, exact));
        }
        rows.push(row);
    }
    let head = "case | quantity | expected | imported | closed form";
    data.table("oscillator", head, &rows)
}
