//! What the tests of the element share, those beside it and those on tables.

#![allow(dead_code)] // none needs all of it

use gearmesh::element::{Element, Formulation, Inputs, LoadedFlank, Outputs, Parameters};
use nalgebra::{Rotation3, Vector3};

/// Both formulations.
pub const FORMULATIONS: [Formulation; 2] = [Formulation::Paper, Formulation::Conjugate];

/// Constant stiffness without damping.
pub fn undamped(formulation: Formulation, loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        formulation,
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Loads at `inputs` with the phases of the nominal pose.
pub fn at(element: &Element, inputs: &Inputs) -> Outputs {
    let phase = element.phase_offset(&element.nominal_inputs()).unwrap();
    element.evaluate(&phase, inputs).unwrap()
}

/// Gear `i` turned by `angle` about its own axis.
pub fn spun(inputs: &Inputs, i: usize, angle: f64) -> Inputs {
    let mut out = *inputs;
    out.gears[i].r *= Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
    out
}

/// Power that the contact gives to the gears, W.
pub fn power(out: &Outputs, inputs: &Inputs) -> f64 {
    (0..2)
        .map(|i| out.force[i].dot(&inputs.gears[i].v) + out.moment[i].dot(&inputs.gears[i].w))
        .sum()
}
