//! The unit's parameters as the element takes them.

use super::signals::Orientation;
use super::variables::{VARIABLE_COUNT, index};
use crate::element::{
    Formulation, Interpolation, LoadedFlank, Parameters, PhaseReference, StiffnessModel,
};

/// Which inputs give the orientation. Enumerations hold legal items only: they are checked where
/// they are set.
pub fn orientation(values: &[f64; VARIABLE_COUNT]) -> Orientation {
    match values[index::ORIENTATION_INPUT] {
        1.0 => Orientation::Angles,
        _ => Orientation::Quaternion,
    }
}

/// The element's parameters out of the values of all variables.
pub fn element_parameters(values: &[f64; VARIABLE_COUNT]) -> Parameters {
    let is_on = |i: usize| values[i] != 0.0;
    Parameters {
        stiffness_model: match values[index::STIFFNESS_MODEL] {
            1.0 => StiffnessModel::Constant,
            _ => StiffnessModel::Table,
        },
        constant_stiffness: values[index::CONSTANT_STIFFNESS],
        load_dependent: is_on(index::LOAD_DEPENDENT),
        nominal_torque: values[index::NOMINAL_TORQUE],
        center_distance_effect: is_on(index::CENTER_DISTANCE_EFFECT),
        misalignment_effect: is_on(index::MISALIGNMENT_EFFECT),
        shuttling_effect: is_on(index::SHUTTLING_EFFECT),
        formulation: match values[index::FORMULATION] {
            1.0 => Formulation::Paper,
            _ => Formulation::Conjugate,
        },
        interpolation: match values[index::INTERPOLATION] {
            1.0 => Interpolation::Linear,
            2.0 => Interpolation::Spline,
            _ => Interpolation::Shepard,
        },
        damping: values[index::DAMPING],
        damping_onset: values[index::DAMPING_ONSET],
        backlash: Some(values[index::BACKLASH]),
        loaded_flank: match values[index::LOADED_FLANK] {
            1.0 => LoadedFlank::Drive,
            2.0 => LoadedFlank::Coast,
            _ => LoadedFlank::Both,
        },
        phase_reference: match values[index::PHASE_REFERENCE] {
            1.0 => PhaseReference::FromInitialPose,
            _ => PhaseReference::Absolute,
        },
        mesh_phase: values[index::MESH_PHASE],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::{VARIABLES, template_starts};

    #[test]
    fn the_units_defaults_are_those_of_the_element() {
        let unit = element_parameters(&template_starts());
        // Packing switches on what the tables have, and writes the pair's own backlash.
        let packed = Parameters {
            center_distance_effect: true,
            misalignment_effect: true,
            shuttling_effect: true,
            backlash: None,
            ..unit
        };
        assert_eq!(packed, Parameters::default());
    }

    /// The items as the enumerations of the element spell them, in the order of the numbers.
    #[test]
    fn the_numbers_of_enumerations_mean_what_their_names_say() {
        type Spelling = fn(&Parameters) -> String;
        let cases: [(usize, Spelling); 5] = [
            (index::STIFFNESS_MODEL, |p| {
                format!("{:?}", p.stiffness_model)
            }),
            (index::FORMULATION, |p| format!("{:?}", p.formulation)),
            (index::INTERPOLATION, |p| format!("{:?}", p.interpolation)),
            (index::LOADED_FLANK, |p| format!("{:?}", p.loaded_flank)),
            (index::PHASE_REFERENCE, |p| {
                format!("{:?}", p.phase_reference)
            }),
        ];
        for (i, spelled) in cases {
            for (k, item) in VARIABLES[i].items.iter().enumerate() {
                let mut values = template_starts();
                values[i] = k as f64 + 1.0;
                let parameters = element_parameters(&values);
                assert_eq!(spelled(&parameters).to_lowercase(), item.to_lowercase());
            }
        }
        let mut values = template_starts();
        assert_eq!(orientation(&values), Orientation::Angles);
        values[index::ORIENTATION_INPUT] = 2.0;
        assert_eq!(orientation(&values), Orientation::Quaternion);
    }
}
