//! The element as seen in motion.

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/gears.rs"]
mod gears;

#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/spring.rs"]
mod spring;

use approx::assert_relative_eq;
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
    let pair = paper_pair(1.0);
    let element = Element::new(&pair, &quiet(), None).unwrap();
    let [held, free] = [Spin::speed(0.0), Spin::torque(100.0)];
    let gears = [gear(&pair, 0, held), gear(&pair, 1, free)];
    let scene = Scene::new(element, gears).unwrap();
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
    assert!(conjugate < 1e-5, "conjugate: {conjugate:.1e}");
    assert!(paper > 1e-2, "paper: {paper:.1e}");
}
