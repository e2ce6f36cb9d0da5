//! Drives the element in a loop, as a multibody solver does: poses and velocities in, forces and moments out.
//!
//! Gear 1 turns at a constant speed; gear 2 (8e-4 kg m², fixed bearings) follows under a load, both from rest in the mesh.
//! Positions are in m, orientations matrices whose third column is the gear's axis, everything in the world frame; moments
//! act about each gear's own origin. `cargo run --release --example drive_element`

use gearmesh::element::{Element, Parameters, StiffnessModel};
use gearmesh::table::{Table, TableFile};
use gearmesh_preprocessor::pair;
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

const SPEED: f64 = 100.0; // rad/s, gear 1
const INERTIA: f64 = 8e-4; // kg m², gear 2
const LOAD: f64 = 100.0; // N m, on gear 2: against its motion
const STEP: f64 = 2e-7; // s

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pair = pair::read("resources/pairs/palermo2013.json")?;
    let tables = TableFile::read("resources/tables/palermo2013.json")?;
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        nominal_torque: pair.operating.nominal_torque,
        ..Parameters::default()
    };
    let table = Arc::new(Table::from_file(tables)?);
    let element = Element::new(&pair.geometry, &parameters, Some(table))?;

    // The phase offset is that of the teeth in the pose in which the model is assembled.
    let mut inputs = element.nominal_inputs();
    let phase = element.phase_offset(&inputs)?;
    let [z1, z2] = [0, 1].map(|i| f64::from(pair.geometry.gears[i].teeth));
    let (mut angle, mut rate) = (0.0, -SPEED * z1 / z2);
    let spin = |angle: f64| *Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();

    for n in 0..=100_000 {
        let t = f64::from(n) * STEP;
        inputs.gears[0].r = spin(SPEED * t);
        inputs.gears[0].w = Vector3::z() * SPEED;
        inputs.gears[1].r = spin(angle);
        inputs.gears[1].w = Vector3::z() * rate;
        let out = element.evaluate(&phase, &inputs)?;
        if n % 10_000 == 0 {
            let (error, force) = (1e6 * out.transmission_error, out.normal_force);
            println!(
                "{:5.1} ms: transmission error {error:6.3} um, normal force {force:7.1} N",
                1e3 * t
            );
        }
        // Semi-implicit Euler: the rate first, then the angle with the new rate.
        rate += STEP * (out.moment[1].z + LOAD) / INERTIA;
        angle += STEP * rate;
    }
    Ok(())
}
