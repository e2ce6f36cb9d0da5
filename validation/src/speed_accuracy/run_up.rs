//! Error of the dynamic transmission error in a run-up, against the step size.

use super::{coarse, everything};
use crate::data::{Data, range, rms};
use crate::driver::{CoSimulation, Gear, INERTIA, Master, Scene, Scheme, Spin};
use crate::setup::Setup;
use crate::timing::timed;
use crate::{Context, Result};
use gearmesh::element::{Element, LoadedFlank};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Duration of the run-up, s, and speed reached, rpm.
const DURATION: f64 = 0.1;
const SPEED_RPM: f64 = 3000.0;
/// Interval of the comparison, s; every step size divides it.
const SAMPLE: f64 = 2e-5;

/// Gear 1 turns faster and faster, gear 2 carries the nominal torque.
fn scene(setup: &Setup) -> Result<Scene> {
    let mut parameters = everything(setup);
    parameters.center_distance_effect = false;
    parameters.misalignment_effect = false;
    parameters.shuttling_effect = false;
    parameters.loaded_flank = LoadedFlank::Drive;
    parameters.damping = 1e5;
    let geometry = &setup.pair.geometry;
    let table = setup.table(&setup.samples([12, 1, 1, 64])?)?;
    let element = Element::new(geometry, &parameters, Some(table))?;
    let nominal = setup.pair.operating.nominal_torque;
    let faster = Spin::Speed(Arc::new(move |t| SPEED_RPM * TAU / 60.0 * t / DURATION));
    let load = Spin::Torque(Arc::new(move |t: f64, _| {
        // A smooth rise over the first five milliseconds.
        let x = (t / 5e-3).min(1.0);
        nominal * x * x * (3.0 - 2.0 * x)
    }));
    let gears = [Gear::new(geometry, 0, faster), Gear::new(geometry, 1, load)];
    Scene::new(element, gears)
}

/// DTE at every sample, m, of one solver over everything, or of a master with the element on the other side in its `scheme`.
fn run(scene: &Scene, scheme: Option<Scheme>, step: f64) -> Result<Vec<f64>> {
    let mut state = scene.rest();
    let coupled = |scheme| CoSimulation::new(scene, scheme, state, step, 1);
    let mut coupled = scheme.map(coupled).transpose()?;
    let per_sample = (SAMPLE / step).round() as usize;
    let mut dte = vec![];
    for i in 0..(DURATION / SAMPLE).round() as usize {
        for n in 0..per_sample {
            let t = (i * per_sample + n) as f64 * step;
            if let Some(coupled) = &mut coupled {
                coupled.advance()?;
                state = coupled.state;
            } else {
                state = scene.step(t, &state, step)?;
            }
        }
        let out = scene.contact((i + 1) as f64 * SAMPLE, &state)?;
        dte.push(out.transmission_error);
    }
    Ok(dte)
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let setup = coarse("palermo2013-unmodified")?;
    let scene = scene(&setup)?;
    let mass = INERTIA / setup.pair.geometry.gears[1].base_radius().powi(2);
    let finest = if context.quick { 1e-6 } else { 2.5e-7 };
    let reference = run(&scene, None, finest)?;
    let [low, high] = range(reference[reference.len() / 5..].iter().copied());
    let swing = high - low;
    let mut rows = vec![format!(
        "(the DTE itself swings by) | | {:.2} |",
        1e6 * swing
    )];
    let predicted = |master| Some(Scheme::predicted(master, mass));
    for (name, scheme) in [
        ("monolithic, Runge-Kutta 4", None),
        (
            "sequential co-simulation, held",
            Some(Scheme::held(Master::Sequential)),
        ),
        ("sequential co-simulation", predicted(Master::Sequential)),
        ("parallel co-simulation", predicted(Master::Parallel)),
    ] {
        let steps = [5e-7, 1e-6, 2e-6, 4e-6, 5e-6, 1e-5];
        for &step in &steps[if context.quick { 4 } else { 0 }..] {
            let (dte, seconds) = timed(|| run(&scene, scheme, step));
            let error = |dte: Vec<f64>| rms(dte.iter().zip(&reference).map(|(a, b)| a - b));
            // Beyond the swing itself nothing of the signal is left.
            let found = match dte.map(error) {
                Err(_) => "diverges".into(),
                Ok(rms) if !rms.is_finite() || rms > swing => "unstable".into(),
                Ok(rms) => format!("{:.2e}", 1e6 * rms),
            };
            rows.push(format!(
                "{name} | {:.1} | {found} | {seconds:.2}",
                1e6 * step
            ));
        }
    }
    data.table(
        "run-up",
        "host | step, µs | rms error of the DTE, µm | seconds",
        &rows,
    )
}
