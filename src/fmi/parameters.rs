//! The parameters of the FMU in the types that the element has for them.

use super::Refusal;
use super::variables::{FIRST_PARAMETER, VARIABLES, check_value, index};
use crate::element::{
    Coupling, Formulation, Interpolation, LoadedFlank, Parameters, PhaseReference, StiffnessModel,
};

/// Which inputs give the orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Cardan angles: R = Rx(a1) Ry(a2) Rz(a3).
    Angles,
    /// Quaternions w x y z, normalised on entry.
    Quaternion,
}

/// All parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Which inputs give the orientation of the bodies.
    pub orientation: Orientation,
    /// In which step the loads act.
    pub coupling: Coupling,
    /// Effective mass along the line of action, kg; 0: not known.
    pub effective_mass: f64,
    /// What the element takes.
    pub element: Parameters,
}

/// Items of the enumerations in the order of their numbers in modelDescription.xml, which count from 1.
const STIFFNESS_MODELS: [StiffnessModel; 4] = [
    StiffnessModel::Constant,
    StiffnessModel::Table,
    StiffnessModel::Contact,
    StiffnessModel::Teeth,
];
const FORMULATIONS: [Formulation; 2] = [Formulation::Paper, Formulation::Conjugate];
const INTERPOLATIONS: [Interpolation; 3] = [
    Interpolation::Linear,
    Interpolation::Spline,
    Interpolation::Shepard,
];
const ORIENTATIONS: [Orientation; 2] = [Orientation::Angles, Orientation::Quaternion];
const LOADED_FLANKS: [LoadedFlank; 3] = [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both];
const COUPLINGS: [Coupling; 4] = [
    Coupling::Held,
    Coupling::Sequential,
    Coupling::Parallel,
    Coupling::Automatic,
];
const PHASE_REFERENCES: [PhaseReference; 2] =
    [PhaseReference::FromInitialPose, PhaseReference::Absolute];

impl Settings {
    /// From the numbers of the parameters in the order of their variables; a Boolean is 0 or 1.
    /// Errors: a number that is no value of its parameter.
    pub fn new(numbers: &[f64]) -> Result<Self, Refusal> {
        for (variable, number) in VARIABLES[FIRST_PARAMETER..].iter().zip(numbers) {
            check_value(variable, *number)?;
        }
        let real = |i: usize| numbers[i - FIRST_PARAMETER];
        let boolean = |i: usize| real(i) != 0.0;
        let item = |i: usize| real(i) as usize - 1; // checked above: 1 or more
        Ok(Self {
            orientation: ORIENTATIONS[item(index::ORIENTATION_INPUT)],
            coupling: COUPLINGS[item(index::COUPLING)],
            effective_mass: real(index::EFFECTIVE_MASS),
            element: Parameters {
                stiffness_model: STIFFNESS_MODELS[item(index::STIFFNESS_MODEL)],
                constant_stiffness: real(index::CONSTANT_STIFFNESS),
                load_dependent: boolean(index::LOAD_DEPENDENT),
                nominal_torque: real(index::NOMINAL_TORQUE),
                center_distance_effect: boolean(index::CENTER_DISTANCE_EFFECT),
                misalignment_effect: boolean(index::MISALIGNMENT_EFFECT),
                shuttling_effect: boolean(index::SHUTTLING_EFFECT),
                formulation: FORMULATIONS[item(index::FORMULATION)],
                interpolation: INTERPOLATIONS[item(index::INTERPOLATION)],
                damping: real(index::DAMPING),
                damping_onset: real(index::DAMPING_ONSET),
                backlash: Some(real(index::BACKLASH)),
                loaded_flank: LOADED_FLANKS[item(index::LOADED_FLANK)],
                phase_reference: PHASE_REFERENCES[item(index::PHASE_REFERENCE)],
                mesh_phase: real(index::MESH_PHASE),
                friction: boolean(index::FRICTION),
                friction_factor: real(index::FRICTION_FACTOR),
                friction_transition_speed: real(index::FRICTION_TRANSITION_SPEED),
                root_stress: boolean(index::ROOT_STRESS),
                body_effect: boolean(index::BODY_EFFECT),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::{Kind, template_starts};
    use std::fmt::Debug;

    fn template() -> Vec<f64> {
        template_starts().split_off(FIRST_PARAMETER)
    }

    #[test]
    fn the_defaults_are_those_of_the_element() {
        let unit = Settings::new(&template()).unwrap().element;
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

    #[test]
    fn the_numbers_of_enumerations_mean_what_their_names_say() {
        fn spelled(items: &[impl Debug]) -> Vec<String> {
            let items = items.iter().map(|item| format!("{item:?}").to_lowercase());
            items.collect()
        }
        let mut compared = 0;
        for (i, items) in [
            (index::STIFFNESS_MODEL, spelled(&STIFFNESS_MODELS)),
            (index::FORMULATION, spelled(&FORMULATIONS)),
            (index::INTERPOLATION, spelled(&INTERPOLATIONS)),
            (index::ORIENTATION_INPUT, spelled(&ORIENTATIONS)),
            (index::LOADED_FLANK, spelled(&LOADED_FLANKS)),
            (index::PHASE_REFERENCE, spelled(&PHASE_REFERENCES)),
            (index::COUPLING, spelled(&COUPLINGS)),
        ] {
            let names = VARIABLES[i].items.iter().map(|name| name.to_lowercase());
            assert_eq!(items, names.collect::<Vec<_>>(), "{}", VARIABLES[i].name);
            compared += 1;
        }
        let all = VARIABLES.iter().filter(|v| v.kind == Kind::Enumeration);
        assert_eq!(compared, all.count());
    }

    /// Two numbers of each parameter give different settings.
    #[test]
    fn every_parameter_has_a_setting_of_its_own() {
        let before = template();
        let base = Settings::new(&before).unwrap();
        let mut seen = vec![base.clone()];
        for (k, v) in VARIABLES[FIRST_PARAMETER..].iter().enumerate() {
            let mut numbers = before.clone();
            numbers[k] = match v.kind {
                Kind::Real => 0.5 * before[k] + 0.25,
                Kind::Boolean => 1.0 - before[k],
                Kind::Enumeration if before[k] == 1.0 => 2.0,
                Kind::Enumeration => 1.0,
            };
            let settings = Settings::new(&numbers).unwrap();
            assert!(!seen.contains(&settings), "{}", v.name);
            seen.push(settings);
            numbers[k] = -7.5;
            let is_any = v.kind == Kind::Real && v.min.is_none();
            assert_eq!(Settings::new(&numbers).is_ok(), is_any, "{}", v.name);
        }
    }
}
