//! The element as seen in motion.

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/gears.rs"]
mod gears;

use gearmesh::element::{Element, Formulation, LoadedFlank, Parameters};
use gearmesh_validation::driver::{Gear, INERTIA, Scene, Spin, State};
use gears::paper_pair;
use std::sync::Arc;

fn gear(pair: &gearmesh::gear::PairGeometry, i: usize, spin: Spin) -> Gear {
    Gear {
        center_of_mass: 12.5e-3,
        ..Gear::new(pair, i, spin)
    }
}

/// Constant stiffness, drive flank, gear 1 held or driven, gear 2 free to spin under `torque`.
fn one_freedom(parameters: &Parameters, torque: Spin) -> Scene {
    let pair = paper_pair(1.0);
    let element = Element::new(&pair, parameters, None).unwrap();
    let gears = [gear(&pair, 0, Spin::speed(0.0)), gear(&pair, 1, torque)];
    Scene::new(element, gears).unwrap()
}

fn quiet() -> Parameters {
    Parameters {
        loaded_flank: LoadedFlank::Drive,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Spin angle of gear 2, rad.
fn angle(state: &State) -> f64 {
    state[1].twist()
}

#[test]
fn runge_kutta_finds_the_mesh_frequency() {
    // Gear 1 held; external: the drive flank pushes gear 2 to -theta, so the load is +.
    let scene = one_freedom(&quiet(), Spin::torque(100.0));
    let pair = paper_pair(1.0);
    let rb = pair.gears[1].base_radius();
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let stiffness = 4.35e8 / phi.cos().powi(2) * rb * rb; // N m/rad
    let omega = (stiffness / INERTIA).sqrt();
    let period = std::f64::consts::TAU / omega;
    let rest = 100.0 / stiffness;
    // Released at touch: theta = rest (1 - cos), back at zero after one period; half-way at 2 rest.
    let steps = 4000;
    let h = 0.5 * period / f64::from(steps);
    let mut y = scene.rest();
    for n in 0..steps {
        y = scene.step(f64::from(n) * h, &y, h).unwrap();
    }
    let found = angle(&y) / (2.0 * rest);
    assert!((found - 1.0).abs() < 1e-9, "{found}");
}

#[test]
fn gains_are_those_of_the_papers_table_2() {
    // |H| = k / sqrt((k - m w^2)^2 + (c w)^2), k = 4.35e8, c = 1e5, m = 0.25 kg tangential.
    for formulation in [Formulation::Paper, Formulation::Conjugate] {
        for frequency in [200.0, 1000.0, 5000.0] {
            let w = std::f64::consts::TAU * frequency;
            let parameters = Parameters {
                formulation,
                damping: 1e5,
                ..quiet()
            };
            let torque = Spin::Torque(Arc::new(move |t, _| 100.0 + 30.0 * (w * t).sin()));
            let scene = one_freedom(&parameters, torque);
            // c/k = 0.23 ms: the start has died out after 4 ms. The pair is overdamped, so 1 us steps.
            let settle = (4e-3 * frequency).ceil() / frequency;
            let (mut sine, mut cosine) = (0.0, 0.0);
            let h = 1e-6_f64.min(1.0 / frequency / 400.0);
            let settle_steps = (settle / h).round() as usize;
            let period_steps = (1.0 / frequency / h).round() as usize;
            let mut y = scene.rest();
            for n in 0..settle_steps + period_steps {
                let t = n as f64 * h;
                if n >= settle_steps {
                    sine += angle(&y) * (w * t).sin();
                    cosine += angle(&y) * (w * t).cos();
                }
                y = scene.step(t, &y, h).unwrap();
            }
            let pair = paper_pair(1.0);
            let r = pair.operating_pitch_radius(1, pair.center_distance);
            let amplitude = 2.0 * sine.hypot(cosine) / period_steps as f64;
            let gain = amplitude / (30.0 / (4.35e8 * r * r));
            let m = INERTIA / (r * r);
            let expected = 4.35e8 / ((4.35e8 - m * w * w).powi(2) + (1e5 * w).powi(2)).sqrt();
            assert!(
                (gain - expected).abs() < 2e-3,
                "{formulation:?}, {frequency} Hz: {gain} {expected}"
            );
        }
    }
}
