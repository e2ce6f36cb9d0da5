//! The element as seen in motion.

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/gears.rs"]
mod gears;

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/spring.rs"]
mod spring;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use gearmesh::element::{Element, Formulation, LoadedFlank, Parameters, StiffnessModel};
use gearmesh::table::{FlankTable, Interpolation};
use gearmesh_validation::driver::{Bearing, Gear, INERTIA, Scene, Spin, State};
use gears::paper_pair;
use nalgebra::Vector3;
use spring::Spring;
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
    assert_relative_eq!(angle(&y), 2.0 * rest, max_relative = 1e-9);
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
            assert_abs_diff_eq!(gain, expected, epsilon = 2e-3);
        }
    }
}

/// Gear 2 in six freedoms on undamped springs against gear 1, held; all effects of a potential on.
fn six_freedoms(formulation: Formulation) -> (Scene, State) {
    let pair = paper_pair(1.0);
    let parameters = Parameters {
        formulation,
        stiffness_model: StiffnessModel::Table,
        ..quiet()
    };
    let grid = Spring::grid([10, 7, 9, 16]);
    let law = Arc::new(FlankTable::new(&grid, Interpolation::Spline).unwrap());
    let element = Element::with_laws(&pair, &parameters, law, None).unwrap();
    let mut second = gear(&pair, 1, Spin::torque(100.0));
    second.bearing = Some(Bearing::springs([2e8, 2e8, 1e8], 1e5));
    let scene = Scene::new(element, [gear(&pair, 0, Spin::speed(0.0)), second]).unwrap();
    let mut start = scene.with_spin(&scene.rest(), 1, 7e-6 / 38e-3, 0.0);
    start[1].v = Vector3::new(0.02, -0.03, 0.05);
    start[1].l += Vector3::new(2e-4, 1e-4, 0.0);
    (scene, start)
}

/// Energy with the potential of the constant torque, J.
fn energy(scene: &Scene, y: &State) -> f64 {
    scene.energy(0.0, y).unwrap() - 100.0 * angle(y)
}

#[test]
fn a_gear_in_six_freedoms_keeps_its_energy() {
    let drift = |formulation| {
        let (scene, mut y) = six_freedoms(formulation);
        let kinetic = 0.5 * 0.8 * y[1].v.norm_squared();
        let start = energy(&scene, &y);
        let mut worst = 0.0_f64;
        for n in 0..40_000 {
            y = scene.step(f64::from(n) * 2e-7, &y, 2e-7).unwrap();
            worst = worst.max((energy(&scene, &y) - start).abs());
        }
        worst / kinetic
    };
    let conjugate = drift(Formulation::Conjugate);
    let paper = drift(Formulation::Paper);
    assert!(
        conjugate < 1e-5,
        "conjugate: {conjugate:.1e} of the kinetic energy"
    );
    assert!(paper > 1e-2, "paper: {paper:.1e}");
}
