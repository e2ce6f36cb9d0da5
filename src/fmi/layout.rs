//! What each variable is to the unit: the one place that knows how many bodies and meshes there are.
//!
//! Everything else goes through [`BODIES`], [`MESHES`] and [`role`], whose sizes are those of
//! modelDescription.xml.

use super::variables::{Causality, VARIABLES, index};

/// Inputs of one body: this many variables from [`Body::first`] on, at the places below.
pub const BODY_INPUTS: usize = 16;
/// Place of the position, 3 inputs.
pub const POSITION: usize = 0;
/// Place of the Cardan angles, 3 inputs.
pub const ANGLES: usize = 3;
/// Place of the quaternion, 4 inputs.
pub const QUATERNION: usize = 6;
/// Place of the velocity, 3 inputs.
pub const VELOCITY: usize = 10;
/// Place of the angular velocity, 3 inputs.
pub const ANGULAR_VELOCITY: usize = 13;

/// A body whose motion the host gives.
#[derive(Debug)]
pub struct Body {
    /// As its variables begin.
    pub name: &'static str,
    /// Its first input, an index in [`VARIABLES`].
    pub first: usize,
}

/// All bodies, in the order of their inputs.
pub static BODIES: &[Body] = &[
    Body {
        name: "gear1",
        first: index::GEAR1_POSITION_1,
    },
    Body {
        name: "gear2",
        first: index::GEAR2_POSITION_1,
    },
    Body {
        name: "carrier",
        first: index::CARRIER_POSITION_1,
    },
];

/// The variables of one mesh, by their indices in [`VARIABLES`].
#[derive(Debug)]
pub struct MeshVariables {
    /// Gear 1 and gear 2, indices in [`BODIES`].
    pub gears: [usize; 2],
    /// The carrier, an index in [`BODIES`].
    pub carrier: usize,
    /// First output; the others follow as in [`crate::element::Outputs::to_array`].
    pub outputs: usize,
    /// First parameter; the others follow as in [`super::settings::FIELDS`].
    pub parameters: usize,
}

impl MeshVariables {
    /// Its bodies in the order of the element: gear 1, gear 2, carrier.
    pub fn bodies(&self) -> [usize; 3] {
        [self.gears[0], self.gears[1], self.carrier]
    }
}

/// All meshes.
pub static MESHES: &[MeshVariables] = &[MeshVariables {
    gears: [0, 1],
    carrier: 2,
    outputs: index::GEAR1_FORCE_1,
    parameters: index::STIFFNESS_MODEL,
}];

/// What a variable is to the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// An input; its index in [`VARIABLES`] is its place among the inputs.
    Input,
    /// An output of a mesh.
    Output {
        /// Index in [`MESHES`].
        mesh: usize,
        /// Place in [`crate::element::Outputs::to_array`].
        row: usize,
    },
    /// A parameter of a mesh.
    Parameter {
        /// Index in [`MESHES`].
        mesh: usize,
        /// Index in [`super::settings::FIELDS`].
        field: usize,
    },
}

/// Number of inputs; they are the first variables.
pub const fn inputs() -> usize {
    BODIES.len() * BODY_INPUTS
}

/// Index in [`BODIES`] of the body of input `i`.
pub const fn body_of(i: usize) -> usize {
    i / BODY_INPUTS
}

/// What the variable with the index `i` in [`VARIABLES`] is.
#[inline]
pub fn role(i: usize) -> Role {
    if i < inputs() {
        return Role::Input;
    }
    // The variables of one mesh stand together within outputs and within parameters.
    let is_output = VARIABLES[i].causality == Causality::Output;
    let first = |m: &MeshVariables| if is_output { m.outputs } else { m.parameters };
    let mesh = MESHES.iter().rposition(|m| first(m) <= i).unwrap_or(0);
    let variables = &MESHES[mesh];
    let place = i - first(variables);
    if is_output {
        Role::Output { mesh, row: place }
    } else {
        Role::Parameter { mesh, field: place }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CONTINUOUS_OUTPUTS;
    use crate::fmi::settings::FIELDS;

    #[test]
    fn the_inputs_of_a_body_are_its_block_and_come_first() {
        for (body, b) in BODIES.iter().enumerate() {
            assert_eq!(b.first, body * BODY_INPUTS);
            for (place, name) in [
                (POSITION, "position[1]"),
                (ANGLES, "angles[1]"),
                (QUATERNION, "quaternion[1]"),
                (VELOCITY, "velocity[1]"),
                (ANGULAR_VELOCITY, "angularVelocity[1]"),
                (BODY_INPUTS - 1, "angularVelocity[3]"),
            ] {
                assert_eq!(
                    VARIABLES[b.first + place].name,
                    format!("{}.{name}", b.name)
                );
            }
        }
        for (i, v) in VARIABLES.iter().enumerate() {
            let is_input = v.causality == Causality::Input;
            assert_eq!(role(i) == Role::Input, is_input, "{}", v.name);
        }
    }

    #[test]
    fn every_output_and_parameter_has_its_role() {
        for (i, v) in VARIABLES.iter().enumerate().skip(inputs()) {
            match role(i) {
                Role::Output { mesh: 0, row } => {
                    assert!(row < CONTINUOUS_OUTPUTS);
                    assert_eq!(i, MESHES[0].outputs + row);
                }
                Role::Parameter { mesh: 0, field } => assert_eq!(v.name, FIELDS[field].name),
                other => panic!("{}: {other:?}", v.name),
            }
        }
    }
}
