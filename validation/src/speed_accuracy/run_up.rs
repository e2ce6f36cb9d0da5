//! Error of the dynamic transmission error in a run-up, against the step size.

use super::{at, everything};
use crate::data::{Data, fixed, range, rms};
use crate::driver::{CoSimulation, Gear, INERTIA, Master, Scene, Spin, State, Way};
use crate::setup::Setup;
use crate::timing::timed;
use crate::{Context, Result, row};
use gearmesh::element::{Element, LoadedFlank, Parameters};
use gearmesh::pair::Refinement;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Duration of the run-up, s, and speed reached, rpm.
const DURATION: f64 = 0.1;
const SPEED_RPM: f64 = 3000.0;
/// Interval of the comparison, s; every step size divides it.
const SAMPLE: f64 = 2e-5;

/// Gear 1 turns faster and faster, gear 2 carries the nominal torque.
fn scene(setup: &Setup) -> Result<Scene> {
    let parameters = Parameters {
        center_distance_effect: false,
        misalignment_effect: false,
        shuttling_effect: false,
        loaded_flank: LoadedFlank::Drive,
        damping: 1e5,
        ..everything(setup)
    };
    let geometry = &setup.pair.geometry;
    let element = Element::new(geometry, &parameters, Some(setup.table(&setup.samples([12, 1, 1, 64])?)?))?;
    let nominal = setup.pair.operating.nominal_torque;
    let faster = Spin::Speed(Arc::new(move |t| SPEED_RPM * TAU / 60.0 * t / DURATION));
    let load = Spin::Torque(Arc::new(move |t: f64, _| {
        // A smooth rise over the first five milliseconds.
        let x = (t / 5e-3).min(1.0);
        nominal * x * x * (3.0 - 2.0 * x)
    }));
    Ok(Scene::new(element, [Gear::new(geometry, 0, faster), Gear::new(geometry, 1, load)])?)
}

/// Who integrates: one solver over everything, or a master with the element on the other side.
#[derive(Clone, Copy)]
enum Host {
    Monolithic,
    Coupled(Way),
}

/// DTE at every sample, m.
fn run(scene: &Scene, host: Host, step: f64) -> Result<Vec<f64>> {
    let mut state = scene.rest();
    let mut coupling = match host {
        Host::Coupled(way) => Some(CoSimulation::new(scene, way, state, step, 1)?),
        Host::Monolithic => None,
    };
    let mut advance = |t: f64, state: &State| -> Result<State> {
        Ok(match &mut coupling {
            Some(coupling) => {
                coupling.advance()?;
                coupling.state
            }
            None => scene.step(t, state, step)?,
        })
    };
    let per_sample = (SAMPLE / step).round() as usize;
    let mut out = vec![];
    for i in 0..(DURATION / SAMPLE).round() as usize {
        for n in 0..per_sample {
            state = advance((i * per_sample + n) as f64 * step, &state)?;
        }
        out.push(scene.contact((i + 1) as f64 * SAMPLE, &state)?.transmission_error);
    }
    Ok(out)
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let setup = at("palermo2013-unmodified", Refinement::Coarse)?;
    let scene = scene(&setup)?;
    let mass = INERTIA / setup.pair.geometry.gears[1].base_radius().powi(2);
    let runge_kutta = Host::Monolithic;
    let reference = run(&scene, runge_kutta, if context.quick { 1e-6 } else { 2.5e-7 })?;
    let [low, high] = range(reference[reference.len() / 5..].iter().copied());
    let swing = high - low;
    let mut rows = vec![row!["(the DTE itself swings by)", "", format!("{:.2}", 1e6 * swing), ""]];
    for (name, host) in [
        ("monolithic, Runge-Kutta 4", runge_kutta),
        ("sequential co-simulation, held", Host::Coupled(Way::held(Master::Sequential))),
        ("sequential co-simulation", Host::Coupled(Way::predicted(Master::Sequential, mass))),
        ("parallel co-simulation", Host::Coupled(Way::predicted(Master::Parallel, mass))),
    ] {
        for step in [5e-7, 1e-6, 2e-6, 4e-6, 5e-6, 1e-5].into_iter().skip(if context.quick { 4 } else { 0 }) {
            let (dte, seconds) = timed(|| run(&scene, host, step));
            let error = dte.ok().map(|dte| rms(dte.iter().zip(&reference).map(|(a, b)| a - b)));
            // Beyond the swing itself nothing of the signal is left.
            let found = match error {
                None => "diverges".into(),
                Some(rms) if !rms.is_finite() || rms > swing => "unstable".into(),
                Some(rms) => format!("{:.2e}", 1e6 * rms),
            };
            rows.push(row![name, fixed(1e6 * step, 1), found, fixed(seconds, 2)]);
        }
    }
    data.table("run-up", &["host", "step, µs", "rms error of the DTE, µm", "seconds"], &rows)
}
