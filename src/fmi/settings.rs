//! The unit's parameters, each in the type that the element has for it.

use super::values::Value;
use super::variables::{VARIABLES, Variable};
use crate::element::{
    Formulation, Interpolation, LoadedFlank, Parameters, PhaseReference, StiffnessModel,
};

/// Which inputs give the orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Cardan angles: R = Rx(a1) Ry(a2) Rz(a3).
    Angles,
    /// Quaternions w x y z, normalised on entry.
    Quaternion,
}

/// Parameters of one mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Which inputs give the orientation of its bodies.
    pub orientation: Orientation,
    /// Whether poses move with the velocity inputs inside a communication step.
    pub extrapolate_poses: bool,
    /// What the element takes.
    pub element: Parameters,
}

/// A type that a parameter can have.
trait Setting: Sized {
    fn value(&self) -> Value;
    /// `None` if the value has another type, or is no item of the enumeration.
    fn of(value: Value) -> Option<Self>;
}

impl Setting for f64 {
    fn value(&self) -> Value {
        Value::Real(*self)
    }

    fn of(value: Value) -> Option<Self> {
        match value {
            Value::Real(x) => Some(x),
            _ => None,
        }
    }
}

/// In the unit the start value is the pair's own, so there always is one.
impl Setting for Option<f64> {
    fn value(&self) -> Value {
        Value::Real(self.unwrap_or(0.0))
    }

    fn of(value: Value) -> Option<Self> {
        f64::of(value).map(Some)
    }
}

impl Setting for bool {
    fn value(&self) -> Value {
        Value::Boolean(*self)
    }

    fn of(value: Value) -> Option<Self> {
        match value {
            Value::Boolean(x) => Some(x),
            _ => None,
        }
    }
}

/// Enumerations with their items in the order of modelDescription.xml, counted from 1.
macro_rules! enumerations {
    ($($type:ident { $($item:ident),* })*) => {$(
        impl Setting for $type {
            fn value(&self) -> Value {
                let items = [$($type::$item),*];
                let place = items.iter().position(|item| item == self);
                // Every item is in the list: a missing one would be a variant without a number.
                Value::Integer(place.map_or(0, |i| i as i32 + 1))
            }

            fn of(value: Value) -> Option<Self> {
                let Value::Integer(number) = value else {
                    return None;
                };
                let items = [$($type::$item),*];
                items.get(usize::try_from(number).ok()?.checked_sub(1)?).copied()
            }
        }
    )*};
}

enumerations! {
    StiffnessModel { Constant, Table, Contact, Teeth }
    Formulation { Paper, Conjugate }
    Interpolation { Linear, Spline, Shepard }
    Orientation { Angles, Quaternion }
    LoadedFlank { Drive, Coast, Both }
    PhaseReference { FromInitialPose, Absolute }
}

/// How a parameter is read and written.
pub struct Field {
    /// Name of the variable.
    pub name: &'static str,
    /// Its value.
    pub get: fn(&Settings) -> Value,
    /// Takes a value; false if it is none of this parameter's.
    pub set: fn(&mut Settings, Value) -> bool,
}

macro_rules! fields {
    ($($name:literal: $($path:ident).+,)*) => {
        &[$(Field {
            name: $name,
            get: |s| Setting::value(&s.$($path).+),
            set: |s, value| Setting::of(value).map(|x| s.$($path).+ = x).is_some(),
        }),*]
    };
}

/// All parameters of a mesh in the order of their variables.
pub static FIELDS: &[Field] = fields! {
    "stiffnessModel": element.stiffness_model,
    "constantStiffness": element.constant_stiffness,
    "loadDependent": element.load_dependent,
    "nominalTorque": element.nominal_torque,
    "centerDistanceEffect": element.center_distance_effect,
    "misalignmentEffect": element.misalignment_effect,
    "shuttlingEffect": element.shuttling_effect,
    "formulation": element.formulation,
    "interpolation": element.interpolation,
    "damping": element.damping,
    "backlash": element.backlash,
    "orientationInput": orientation,
    "loadedFlank": element.loaded_flank,
    "phaseReference": element.phase_reference,
    "meshPhase": element.mesh_phase,
    "dampingOnset": element.damping_onset,
    "extrapolatePoses": extrapolate_poses,
    "friction": element.friction,
    "frictionFactor": element.friction_factor,
    "frictionTransitionSpeed": element.friction_transition_speed,
    "rootStress": element.root_stress,
};

impl Settings {
    /// The settings with the numbers that `start` has for the variables from the index `first` on.
    ///
    /// # Errors
    /// The variable whose number is none of its values.
    pub fn of_starts(
        first: usize,
        start: impl Fn(usize) -> f64,
    ) -> Result<Self, &'static Variable> {
        let mut settings = Self {
            orientation: Orientation::Angles,
            extrapolate_poses: false,
            element: Parameters::default(),
        };
        for (i, field) in (first..).zip(FIELDS) {
            let variable = &VARIABLES[i];
            let value = Value::of(variable.kind, start(i));
            if !value.is_some_and(|value| (field.set)(&mut settings, value)) {
                return Err(variable);
            }
        }
        Ok(settings)
    }

    /// The numbers of all parameters in their order.
    pub fn numbers(&self) -> Vec<f64> {
        FIELDS
            .iter()
            .map(|field| (field.get)(self).number())
            .collect()
    }

    /// Whether nothing but the damping differs from `other`.
    pub fn differs_in_damping_alone(&self, other: &Self) -> bool {
        let damped = Parameters {
            damping: other.element.damping,
            ..self.element
        };
        let damped = Self {
            element: damped,
            ..self.clone()
        };
        damped == *other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::{Kind, index, template_starts};

    fn template() -> Settings {
        let starts = template_starts();
        Settings::of_starts(index::STIFFNESS_MODEL, |i| starts[i]).unwrap()
    }

    #[test]
    fn the_units_defaults_are_those_of_the_element() {
        let unit = template().element;
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
        let mut compared = 0;
        for (i, field) in (index::STIFFNESS_MODEL..).zip(FIELDS) {
            let variable = &VARIABLES[i];
            assert_eq!(variable.name, field.name);
            for (k, item) in variable.items.iter().enumerate() {
                let mut settings = template();
                let number = k as i32 + 1;
                assert!((field.set)(&mut settings, Value::Integer(number)));
                assert_eq!((field.get)(&settings), Value::Integer(number));
                let e = &settings.element;
                let spelled = match i {
                    index::STIFFNESS_MODEL => format!("{:?}", e.stiffness_model),
                    index::FORMULATION => format!("{:?}", e.formulation),
                    index::INTERPOLATION => format!("{:?}", e.interpolation),
                    index::ORIENTATION_INPUT => format!("{:?}", settings.orientation),
                    index::LOADED_FLANK => format!("{:?}", e.loaded_flank),
                    index::PHASE_REFERENCE => format!("{:?}", e.phase_reference),
                    _ => panic!("{} is no enumeration", variable.name),
                };
                assert_eq!(spelled.to_lowercase(), item.to_lowercase());
                compared += 1;
            }
            let beyond = Value::Integer(variable.items.len() as i32 + 1);
            assert!(!(field.set)(&mut template(), beyond), "{}", field.name);
        }
        assert_eq!(compared, 16);
    }

    #[test]
    fn settings_survive_as_numbers_and_a_number_that_is_none_is_refused_by_name() {
        let mut starts = template_starts();
        starts[index::LOAD_DEPENDENT] = 0.0;
        starts[index::DAMPING] = 7.25;
        starts[index::LOADED_FLANK] = 3.0;
        let first = index::STIFFNESS_MODEL;
        let settings = Settings::of_starts(first, |i| starts[i]).unwrap();
        assert!(!settings.element.load_dependent);
        assert_eq!(settings.element.damping, 7.25);
        let numbers = settings.numbers();
        let again = Settings::of_starts(first, |i| numbers[i - first]).unwrap();
        assert_eq!(again, settings);
        for (i, bad) in [
            (index::LOADED_FLANK, 4.0),
            (index::LOADED_FLANK, 1.5),
            (index::LOAD_DEPENDENT, 2.0),
        ] {
            let mut spoilt = starts.clone();
            spoilt[i] = bad;
            let refused = Settings::of_starts(first, |i| spoilt[i]).unwrap_err();
            assert_eq!(refused.name, VARIABLES[i].name);
            assert_ne!(refused.kind, Kind::Real);
        }
    }

    #[test]
    fn damping_alone_is_told_from_any_other_change() {
        let before = template();
        let mut after = before.clone();
        after.element.damping *= 2.0;
        assert!(before.differs_in_damping_alone(&after));
        after.element.mesh_phase = 1.0;
        assert!(!before.differs_in_damping_alone(&after));
    }
}
