//! The element on the tables that are shipped: energy and momentum, at every state and over whole mesh cycles.

use super::element::{self, power};
use super::*;
use Formulation::{Conjugate, Paper};
use Interpolation::{Linear, Shepard, Spline};
use gearmesh::element::*;
use nalgebra::{Rotation3, Vector3};

/// Loaded states for each of the twenty laws, over twenty thousand in all.
const STATES: usize = 1040;

/// Up to 20 um into either flank anywhere on the mesh cycle, tilts of 1 mrad, +-30 um and +-0.5 mm axially; the
/// velocities of resonance and impact.
fn state(element: &Element, table: &Table, random: &mut Random) -> Inputs {
    let mut next = || random.within([-1.0, 1.0]);
    let gears = &table.file.geometry.gears;
    let mut inputs = element.nominal_inputs();
    let depth = 20e-6 * next();
    let backlash = if depth < 0.0 { -60e-6 } else { 0.0 };
    let turn = 3.0 * next();
    let ratio = -table.file.geometry.e() * gears[0].z() / gears[1].z();
    let spins = [
        turn + (depth + backlash) / gears[0].base_radius(),
        ratio * turn,
    ];
    for (gear, spin) in inputs.gears.iter_mut().zip(spins) {
        gear.p += Vector3::new(15e-6 * next(), 15e-6 * next(), 0.25e-3 * next());
        let tilt = Rotation3::from_euler_angles(0.5e-3 * next(), 0.5e-3 * next(), 0.0);
        gear.r = *(tilt * Rotation3::from_axis_angle(&Vector3::z_axis(), spin)).matrix();
        gear.v = 0.2 * Vector3::new(next(), next(), next());
        gear.w = 4.0 * Vector3::new(next(), next(), next());
    }
    // Down to rates that change the force by a thousandth, while the gears roll up to 2000 rpm.
    let slow = 10_f64.powf(1.5 * (next() - 1.0));
    let speed = 200.0 * next();
    for (gear, rolling) in inputs.gears.iter_mut().zip([1.0, ratio]) {
        gear.v *= slow;
        gear.w = slow * gear.w + gear.r.column(2) * (speed * rolling);
    }
    inputs
}

/// Power that flows in and out of the contact, W.
fn flow(out: &Outputs, inputs: &Inputs) -> f64 {
    (0..2)
        .map(|i| {
            let m = &inputs.gears[i];
            out.force[i].norm() * m.v.norm() + out.moment[i].norm() * m.w.norm()
        })
        .sum()
}

/// The element on `table` with every effect, both flanks and no damping.
fn undamped(table: &Arc<Table>, formulation: Formulation, interpolation: Interpolation) -> Element {
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        backlash: Some(60e-6),
        interpolation,
        ..element::undamped(formulation, LoadedFlank::Both)
    };
    Element::new(&table.file.geometry, &parameters, Some(table.clone())).unwrap()
}

/// Laws with the dampers that are tried on them, N s/m.
const LAWS: [(Formulation, Interpolation, f64); 5] = [
    (Conjugate, Spline, 3e3),
    (Conjugate, Spline, 1e6),
    (Conjugate, Linear, 3e3),
    (Conjugate, Shepard, 3e3),
    (Paper, Spline, 1e5),
];

#[test]
fn the_loads_on_both_gears_balance_and_the_damper_gives_no_energy_and_leaves_the_rest_alone() {
    let mut states = Random::new(26);
    for name in TABLES {
        let table = Arc::new(Table::from_file(tables(name)).unwrap());
        for (formulation, interpolation, damping) in LAWS {
            let free = undamped(&table, formulation, interpolation);
            let mut damped = free.clone();
            damped.set_damping(damping);
            let phase = free.phase_offset(&free.nominal_inputs()).unwrap();
            let law = format!("{name}, {formulation:?}, {interpolation:?}");
            let (mut loaded, mut taken) = (0, 0);
            while loaded < STATES {
                let inputs = state(&free, &table, &mut states);
                let elastic = free.evaluate(&phase, &inputs).unwrap();
                if elastic.flank == 0 {
                    continue;
                }
                loaded += 1;
                let out = damped.evaluate(&phase, &inputs).unwrap();
                assert!(out.tangential_force >= 0.0, "{law}: teeth pull");
                assert_eq!((out.flank, out.energy), (elastic.flank, elastic.energy));
                let ([f1, f2], [m1, m2]) = (out.force, out.moment);
                let arm = inputs.gears[1].p - inputs.gears[0].p;
                let total = m1 + m2 + arm.cross(&f2);
                let scale = m1.norm() + m2.norm() + arm.norm() * f2.norm();
                assert!((f1 + f2).norm() <= 1e-13 * f1.norm(), "{law}");
                assert!(total.norm() <= 1e-13 * scale, "{law}: {total}");
                let given = power(&out, &inputs) - power(&elastic, &inputs);
                let share = given / (flow(&elastic, &inputs) + flow(&out, &inputs));
                assert!(share <= 1e-9, "{law}: {share:.1e} of the power that flows");
                taken += usize::from(share < 0.0);
            }
            // A damper it is all the same.
            assert!(20 * taken >= 19 * loaded, "{law}: {taken} of {loaded}");
        }
    }
}
