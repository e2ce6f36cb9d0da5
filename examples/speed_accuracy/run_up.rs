//! Error of the dynamic transmission error in a run-up, against the step size.

use crate::document::{Document, Error};
use crate::driver::{Coupling, Extrapolation, Gear, Master, Method, Scene, Spin, State};
use crate::plot::{Series, log_log};
use crate::setting::Setting;
use crate::timing::timed;
use crate::whole_element::everything;
use gearmesh::element::{Element, LoadedFlank, Parameters};
use gearmesh::table::Table;
use nalgebra::Vector3;
use std::sync::Arc;

/// Duration of the run-up, s.
const DURATION: f64 = 0.1;
/// Speed reached, rpm.
const SPEED_RPM: f64 = 3000.0;
/// Interval of the comparison, s; every step size divides it.
const SAMPLE: f64 = 2e-5;
/// Polar inertia of gear 2 behind Table 2 of the paper, kg m².
const INERTIA: f64 = 4.213e-4;

/// Gear 1 turns faster and faster, gear 2 carries the nominal torque.
fn scene(setting: &Setting) -> Result<Scene, Error> {
    let table = Arc::new(Table::from_file(
        setting.file(&setting.samples([12, 1, 1, 64])?),
    )?);
    let parameters = Parameters {
        center_distance_effect: false,
        misalignment_effect: false,
        shuttling_effect: false,
        loaded_flank: LoadedFlank::Drive,
        damping: 1e5,
        ..everything(setting)
    };
    let geometry = &setting.pair.geometry;
    let element = Element::new(geometry, &parameters, Some(table))?;
    let nominal = setting.pair.operating.nominal_torque;
    let top = SPEED_RPM * std::f64::consts::TAU / 60.0;
    let gear = |i: usize, spin| Gear {
        mass: 0.8,
        polar_inertia: INERTIA,
        transverse_inertia: 0.6 * INERTIA,
        center_of_mass: 0.0,
        origin: Vector3::new(i as f64 * geometry.center_distance, 0.0, 0.0),
        bearing: crate::driver::Bearing::default(),
        freedoms: crate::driver::Freedoms::default(),
        spin,
    };
    let faster = Spin::Speed(Arc::new(move |t| top * t / DURATION));
    let load = Spin::Torque(Arc::new(move |t: f64, _| {
        // A smooth rise over the first five milliseconds.
        let x = (t / 5e-3).min(1.0);
        nominal * x * x * (3.0 - 2.0 * x)
    }));
    Ok(Scene::new(element, [gear(0, faster), gear(1, load)])?)
}

/// DTE at every sample, m, and the seconds it took.
fn run(
    scene: &Scene,
    step: f64,
    mut advance: impl FnMut(f64) -> Result<State, Error>,
) -> Result<(Vec<f64>, f64), Error> {
    let per_sample = (SAMPLE / step).round() as usize;
    let samples = (DURATION / SAMPLE).round() as usize;
    let (out, seconds) = timed(|| -> Result<Vec<f64>, Error> {
        let mut out = vec![];
        for i in 0..samples {
            let mut state = [0.0; crate::driver::STATES];
            for n in 0..per_sample {
                state = advance((i * per_sample + n) as f64 * step)?;
            }
            let t = (i + 1) as f64 * SAMPLE;
            out.push(scene.contact(t, &state)?.transmission_error);
        }
        Ok(out)
    });
    Ok((out?, seconds))
}

fn integrated(scene: &Scene, method: Method, step: f64) -> Result<(Vec<f64>, f64), Error> {
    let mut state = scene.rest();
    run(scene, step, |t| {
        state = method.step(scene, t, &state, step)?;
        Ok(state)
    })
}

fn coupled(
    scene: &Scene,
    extrapolation: Extrapolation,
    step: f64,
) -> Result<(Vec<f64>, f64), Error> {
    let mut coupling = Coupling::new(
        scene,
        Master::Sequential,
        extrapolation,
        scene.rest(),
        step,
        1,
    )?;
    run(scene, step, |_| {
        coupling.advance()?;
        Ok(*coupling.state())
    })
}

/// The section.
pub fn report(document: &mut Document, setting: &Setting) -> Result<(), Error> {
    document.section("Step size in a run-up");
    let scene = scene(setting)?;
    let (reference, _) = integrated(&scene, Method::RungeKutta4, 2.5e-7)?;
    let swing = {
        let late = &reference[reference.len() / 5..];
        let low = late.iter().copied().fold(f64::INFINITY, f64::min);
        late.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low
    };
    document.paragraph(&format!(
        "Pair {}: gear 1 runs up from 0 to {SPEED_RPM:.0} rpm in {DURATION} s, gear 2 (inertia {INERTIA} kg m²) \
         carries the nominal torque, damping 1e5 N s/m, load and mesh position from the table. The error is the \
         rms difference of the DTE, over the whole run, from classical Runge-Kutta with steps of 0.25 µs; \
         the DTE itself swings by {:.2} µm. *Monolithic*: the integrator calls the element at its own \
         stages, as Model Exchange does. *Co-simulation*: the element's loads cross the boundary once per \
         step, held, or carried on by input derivatives. Seconds are for the whole run, the host's \
         equations of motion included.",
        setting.pair.name,
        1e6 * swing,
    ));
    let mut rows = vec![];
    let mut series = vec![];
    type Run<'a> = Box<dyn Fn(f64) -> Result<(Vec<f64>, f64), Error> + 'a>;
    let scene = &scene;
    let kinds: [(&str, Run); 4] = [
        (
            "monolithic, Runge-Kutta 4",
            Box::new(move |h| integrated(scene, Method::RungeKutta4, h)),
        ),
        (
            "monolithic, semi-implicit Euler",
            Box::new(move |h| integrated(scene, Method::SemiImplicitEuler, h)),
        ),
        (
            "co-simulation, held",
            Box::new(move |h| coupled(scene, Extrapolation::Hold, h)),
        ),
        (
            "co-simulation, input derivatives",
            Box::new(move |h| coupled(scene, Extrapolation::Inputs, h)),
        ),
    ];
    for (name, run) in &kinds {
        let mut points = vec![];
        for step in [5e-7, 1e-6, 2e-6, 4e-6, 5e-6, 1e-5] {
            let Ok((dte, seconds)) = run(step) else {
                rows.push([
                    (*name).to_owned(),
                    format!("{}", 1e6 * step),
                    "diverges".into(),
                    "–".into(),
                ]);
                continue;
            };
            let squares: f64 = dte
                .iter()
                .zip(&reference)
                .map(|(a, b)| (a - b).powi(2))
                .sum();
            let rms = (squares / dte.len() as f64).sqrt();
            // Beyond the swing itself nothing of the signal is left.
            let lost = !rms.is_finite() || rms > swing;
            if !lost {
                points.push((1e6 * step, 1e6 * rms));
            }
            rows.push([
                (*name).to_owned(),
                format!("{:.1}", 1e6 * step),
                if lost {
                    "unstable".into()
                } else {
                    format!("{:.2e}", 1e6 * rms)
                },
                format!("{seconds:.2}"),
            ]);
        }
        series.push(Series {
            label: (*name).to_owned(),
            points,
            joined: true,
        });
    }
    document.table(
        ["host", "step, µs", "rms error of the DTE, µm", "seconds"],
        &rows,
    );
    let svg = log_log("step, µs", "rms error of the DTE, µm", &series, &[])?;
    document.plot(
        "speed-step-size",
        "Error of the DTE in a run-up against the step",
        &svg,
    )
}
