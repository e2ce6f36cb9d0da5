//! y'' + 2 zeta y' + k(tau) max(y, 0) = 1, k = 1 + eps cos(Omega tau), realised with the element.

use super::experiment::{ModulatedSpring, STIFFNESS, SingleFreedom};
use crate::data::{Data, fixed};
use crate::driver::{CoSimulation, INERTIA, Master, Spin, State, Way};
use crate::setup::external_and_internal;
use crate::{Context, Result, row};
use gearmesh::element::{Element, FlankLaws, LoadedFlank, Parameters};
use gearmesh::table::{FlankTable, Interpolation};
use gearmesh_preprocessor::table::import;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::sync::Arc;

/// Mesh positions of the imported table, and the torque on gear 2, N m.
const POSITIONS: usize = 32;
const TORQUE: f64 = 100.0;

/// A spring with k(PMC) and the damping of gear 2.
pub struct Case {
    depth: f64,
    zeta: f64,
    /// The imported table; `None`: the law in closed form.
    table: Option<Arc<FlankTable>>,
}

impl Case {
    pub fn closed_form(depth: f64, zeta: f64) -> Self {
        Self { depth, zeta, table: None }
    }

    /// By way of a CSV file of static solutions, imported like those of any other program.
    pub fn imported(depth: f64, zeta: f64) -> Result<Self> {
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
        let table = FlankTable::new(&grid, Interpolation::Spline)?;
        Ok(Self { depth, zeta, table: Some(Arc::new(table)) })
    }

    fn both(depth: f64, zeta: f64) -> Result<[Self; 2]> {
        Ok([Self::imported(depth, zeta)?, Self::closed_form(depth, zeta)])
    }
}

/// The system of `case` at frequency ratio `frequency`, and the speed of gear 1. Elongations stay far below the pitch and
/// in one gap: drive flank alone, no damping in the mesh.
fn oscillator(case: &Case, frequency: f64) -> Result<(SingleFreedom, f64)> {
    let [pair, _] = external_and_internal();
    let omega = (STIFFNESS / INERTIA).sqrt() * pair.gears[1].base_radius();
    // One mesh cycle per period of the stiffness.
    let speed = frequency * omega / pair.gears[0].z();
    let parameters = Parameters { loaded_flank: LoadedFlank::Drive, damping: 0.0, ..Parameters::default() };
    let law = ModulatedSpring { stiffness: STIFFNESS, depth: case.depth };
    let system = SingleFreedom::new(&pair, &parameters, law, TORQUE, Spin::speed(speed))?;
    let mut system = system.damped(case.zeta, speed, TORQUE);
    if let Some(table) = &case.table {
        let laws = FlankLaws { drive: table.clone(), coast: None };
        system.scene.element = Element::with_laws(&pair, &parameters, &laws)?;
    }
    Ok((system, speed))
}

/// State carried from one frequency to the next: y and its rate at the start of a mesh cycle.
type Motion = (f64, f64);

/// Who integrates.
#[derive(Debug, Clone, Copy)]
pub enum Host {
    /// Runge-Kutta over everything, 160 steps a mesh cycle.
    Monolithic,
    /// A master with so many steps a mesh cycle and predicted loads.
    Master { master: Master, steps: usize },
}

/// Settles for `settle` periods, then the rms of y about its mean over `measure` periods, and the motion there.
fn run(case: &Case, host: Host, frequency: f64, start: Motion, settle: usize, measure: usize) -> Result<(f64, Motion)> {
    let (o, speed) = oscillator(case, frequency)?;
    let steps = match host {
        Host::Monolithic => 160,
        Host::Master { steps, .. } => steps,
    };
    let period = TAU / frequency / o.omega;
    let h = period / steps as f64;
    let mut y: State = o.start(start.0, start.1, speed);
    let mut coupled = match host {
        Host::Monolithic => None,
        Host::Master { master, .. } => {
            let mass = INERTIA / o.base_radius.powi(2);
            Some(CoSimulation::new(&o.scene, Way::predicted(master, mass), y, h, 4)?)
        }
    };
    let (mut sum, mut squares) = (0.0, 0.0);
    for n in 0..(settle + measure) * steps {
        let t = n as f64 * h;
        if n >= settle * steps {
            let y = o.elongation(t, &y)?;
            sum += y;
            squares += y * y;
        }
        y = match &mut coupled {
            None => o.scene.step(t, &y, h)?,
            Some(coupled) => {
                coupled.advance()?;
                coupled.state
            }
        };
    }
    let end = (settle + measure) as f64 * period;
    let outputs = o.scene.contact(end, &y)?;
    let scale = o.scene.element.line_of_action(outputs.center_distance) / o.static_elongation;
    let motion = (outputs.transmission_error * scale, outputs.transmission_error_rate * scale / o.omega);
    let count = (measure * steps) as f64;
    let rms = (squares / count - (sum / count).powi(2)).max(0.0).sqrt();
    Ok((rms, motion))
}

/// rms over frequency along a sweep.
pub fn sweep(case: &Case, host: Host, from: f64, to: f64) -> Result<Vec<(f64, f64)>> {
    let settle = (4.0 / (TAU * case.zeta)).ceil() as usize * 3;
    let count = ((to - from).abs() / 0.005).round() as usize;
    let mut motion = (1.0, 0.0);
    let mut curve = Vec::new();
    for i in 0..=count {
        let frequency = from + (to - from) * i as f64 / count as f64;
        let (rms, next) = run(case, host, frequency, motion, settle, 20)?;
        motion = next;
        curve.push((frequency, rms));
    }
    Ok(curve)
}

/// Frequency of the last point of a sweep before its largest step.
pub fn jump(curve: &[(f64, f64)]) -> f64 {
    let step = |w: &[(f64, f64)]| (w[1].1 - w[0].1).abs();
    curve.windows(2).max_by(|a, b| step(a).total_cmp(&step(b))).map_or(f64::NAN, |w| w[0].0)
}

/// rms of the point next to `frequency`.
pub fn at(curve: &[(f64, f64)], frequency: f64) -> f64 {
    let off = |p: &(f64, f64)| (p.0 - frequency).abs();
    curve.iter().min_by(|a, b| off(a).total_cmp(&off(b))).map_or(f64::NAN, |p| p.1)
}

/// Growth of a small difference at `frequency` from an early to a late window, natural logarithm.
pub fn growth(case: &Case, frequency: f64) -> Result<f64> {
    let (o, speed) = oscillator(case, frequency)?;
    let steps = 120;
    let h = TAU / frequency / o.omega / steps as f64;
    // Near the forced motion 1 + eps/(Omega^2 - 1) cos(Omega tau), so that contact holds while the
    // difference is watched.
    let forced = 1.0 + case.depth / (frequency * frequency - 1.0);
    let mut pair = [forced, forced + 1e-7].map(|y| o.start(y, 0.0, speed));
    let mut peaks = [0.0_f64; 2];
    let (window, periods) = (16, 70);
    for n in 0..periods * steps {
        let t = n as f64 * h;
        let difference = (o.elongation(t, &pair[1])? - o.elongation(t, &pair[0])?).abs();
        let cycle = n / steps;
        if (window..2 * window).contains(&cycle) {
            peaks[0] = peaks[0].max(difference);
        } else if cycle >= periods - window {
            peaks[1] = peaks[1].max(difference);
        }
        for y in &mut pair {
            *y = o.scene.step(t, y, h)?;
        }
    }
    Ok((peaks[1] / peaks[0]).ln())
}

/// Period of the undamped free motion with amplitude `a` about y = 1 (a > 1: with contact loss), scaled time.
pub fn free_period(case: &Case, a: f64) -> Result<f64> {
    let (o, _) = oscillator(case, 1e-9)?;
    let h = 2e-3 / o.omega;
    let mut y = o.start(1.0 + a, 0.0, 0.0);
    let mut before = o.elongation(0.0, &y)? - 1.0;
    let mut crossings = Vec::new();
    let mut t = 0.0;
    while crossings.len() < 3 {
        y = o.scene.step(t, &y, h)?;
        let now = o.elongation(t, &y)? - 1.0;
        if before > 0.0 && now <= 0.0 {
            crossings.push((t + h * before / (before - now)) * o.omega);
        }
        before = now;
        t += h;
    }
    Ok(crossings[2] - crossings[1])
}

/// The same in closed form: a part of a circle in contact, a parabola out of it.
pub fn exact_period(a: f64) -> f64 {
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
            rising.push(sweep(&case, Host::Monolithic, up - 0.1, up + 0.05)?);
            falling.push(sweep(&case, Host::Monolithic, up + 0.05, down - 0.03)?);
        }
        for (what, expected, curves) in [("jump up", up, &rising), ("jump down", down, &falling)] {
            rows.push(row![name, what, expected, fixed(jump(&curves[0]), 3), fixed(jump(&curves[1]), 3)]);
        }
        if depth == 0.2 {
            for (branch, expected, curves) in [("lower", 0.529, &rising), ("upper", 1.539, &falling)] {
                let [imported, closed] = [0, 1].map(|i| fixed(at(&curves[i], 0.85), 6));
                rows.push(row![name, format!("rms at 0.85, {branch} branch"), expected, imported, closed]);
            }
        }
    }

    let (depth, zeta) = (0.2_f64, 0.03_f64);
    let mut coupled = vec![];
    let case = Case::imported(depth, zeta)?;
    for steps in if context.quick { vec![20] } else { vec![40, 20, 12] } {
        for (name, master) in [("sequential", Master::Sequential), ("parallel", Master::Parallel)] {
            let host = Host::Master { master, steps };
            let rising = sweep(&case, host, 0.8, 0.95)?;
            let falling = sweep(&case, host, 0.95, 0.65)?;
            let [up, down] = [&rising, &falling].map(|curve| fixed(jump(curve), 3));
            let [lower, upper] = [&rising, &falling].map(|curve| fixed(at(curve, 0.85), 3));
            coupled.push(row![steps, name, up, down, lower, upper]);
        }
    }
    let head = ["steps a mesh cycle", "master", "jump up", "jump down", "rms at 0.85, lower branch", "upper branch"];
    data.table("oscillator-coupled", &head, &coupled)?;
    let cases = Case::both(depth, zeta)?;
    let half = (depth * depth / 4.0 - 4.0 * zeta * zeta).sqrt();
    for (name, sign) in [("lower", -1.0), ("upper", 1.0)] {
        let edge = |case: &Case| -> Result<String> {
            let around = [2.0 + sign * 0.4 * half, 2.0 + sign * 1.8 * half];
            let [inside, outside] = super::last_that_holds(around, 8, |f| Ok(growth(case, f)? > 0.0))?;
            Ok(fixed(0.5 * (inside + outside), 4))
        };
        let what = format!("{name} edge of the parametric tongue");
        let expected = fixed(2.0 + sign * half, 4);
        rows.push(row![format!("eps {depth}, zeta {zeta}"), what, expected, edge(&cases[0])?, edge(&cases[1])?]);
    }
    let cases = Case::both(0.0, 0.0)?;
    for a in [1.5_f64, 2.0, 4.0, 8.0] {
        let exact = exact_period(a);
        let found = |case: &Case| -> Result<String> {
            let t = free_period(case, a)?;
            Ok(format!("{t:.5} ({:+.4} %)", 100.0 * (t / exact - 1.0)))
        };
        let name = format!("free, undamped, amplitude {a}");
        rows.push(row![name, "period", fixed(exact, 5), found(&cases[0])?, found(&cases[1])?]);
    }
    data.table("oscillator", &["case", "quantity", "expected", "imported", "closed form"], &rows)
}
