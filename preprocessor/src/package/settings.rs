//! Start values that the user chooses when packing, for hosts that cannot set them.

use std::str::FromStr;

use gearmesh::fmi::variables::{Causality, Kind, VARIABLES, index, index_by_name};

/// A start value by the name of its variable: `damping=500`, `interpolation=shepard`,
/// `coupling=held`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Index in [`VARIABLES`].
    pub(super) index: usize,
    /// Value; a Boolean as 0 or 1, an item of an enumeration as its number.
    pub(super) value: f64,
}

/// Why a text is no [`Setting`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// Not of the form `name=value`.
    #[error("give a variable and its start value as name=value")]
    Form,
    /// No parameter or input has this name.
    #[error("the unit has no parameter or input {name}; its parameters are {known}")]
    Unknown {
        /// As given.
        name: String,
        /// All parameters.
        known: String,
    },
    /// A value that the variable cannot take.
    #[error("{name} = {value}: give {wanted}")]
    Value {
        /// The variable.
        name: &'static str,
        /// As given.
        value: String,
        /// What it takes.
        wanted: String,
    },
}

impl Setting {
    /// Whether it chooses contact at run time.
    pub fn is_contact(&self) -> bool {
        self.is_stiffness_model("contact")
    }

    /// Whether it chooses tooth pairs one by one.
    pub fn is_teeth(&self) -> bool {
        self.is_stiffness_model("teeth")
    }

    fn is_stiffness_model(&self, name: &str) -> bool {
        let items = VARIABLES[index::STIFFNESS_MODEL].items;
        self.index == index::STIFFNESS_MODEL && items.get(self.value as usize - 1) == Some(&name)
    }

    /// Whether it switches friction on.
    pub fn is_friction(&self) -> bool {
        self.index == index::FRICTION && self.value != 0.0
    }

    /// Whether it switches root stress on.
    pub fn is_root_stress(&self) -> bool {
        self.index == index::ROOT_STRESS && self.value != 0.0
    }
}

impl FromStr for Setting {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        let (name, value) = text.split_once('=').ok_or(SettingError::Form)?;
        let (name, value) = (name.trim(), value.trim());
        let found = index_by_name(name).filter(|&i| VARIABLES[i].causality != Causality::Output);
        let index = found.ok_or_else(|| SettingError::Unknown {
            name: name.to_owned(),
            known: parameters(),
        })?;
        let variable = &VARIABLES[index];
        let refuse = |wanted: String| SettingError::Value {
            name: variable.name,
            value: value.to_owned(),
            wanted,
        };
        let number = match variable.kind {
            Kind::Boolean => match value {
                "true" => Some(1.0),
                "false" => Some(0.0),
                _ => None,
            }
            .ok_or_else(|| refuse("true or false".into()))?,
            Kind::Enumeration => variable
                .items
                .iter()
                .position(|item| *item == value)
                .map(|i| i as f64 + 1.0)
                .ok_or_else(|| refuse(format!("one of {}", variable.items.join(", "))))?,
            Kind::Real | Kind::Integer => value
                .parse()
                .ok()
                .filter(|x: &f64| {
                    x.is_finite()
                        && variable.min.is_none_or(|m| *x >= m)
                        && variable.max.is_none_or(|m| *x <= m)
                })
                .ok_or_else(|| refuse(range(variable.min, variable.max, variable.unit)))?,
        };
        Ok(Self {
            index,
            value: number,
        })
    }
}

fn parameters() -> String {
    VARIABLES
        .iter()
        .filter(|v| v.causality == Causality::Parameter)
        .map(|v| v.name)
        .collect::<Vec<_>>()
        .join(", ")
}

fn range(min: Option<f64>, max: Option<f64>, unit: &str) -> String {
    let mut text = String::from("a number with a decimal point");
    if let Some(min) = min {
        text += &format!(", {min} or above");
    }
    if let Some(max) = max {
        text += &format!(", {max} or below");
    }
    if !["", "1"].contains(&unit) {
        text += &format!(", in {unit}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_names_of_items_and_booleans_are_taken() {
        for (text, index, value) in [
            ("damping=500", index::DAMPING, 500.0),
            (" backlash = 8e-5 ", index::BACKLASH, 8e-5),
            ("interpolation=shepard", index::INTERPOLATION, 3.0),
            ("friction=true", index::FRICTION, 1.0),
            ("gear1.angles[3]=-0.5", index::GEAR1_ANGLES_3, -0.5),
        ] {
            assert_eq!(text.parse(), Ok(Setting { index, value }), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_what_can() {
        for (text, reason) in [
            ("damping", "name=value"),
            (
                "dampin=3",
                "no parameter or input dampin; its parameters are stiffnessModel",
            ),
            ("mesh.stiffness=3", "no parameter or input mesh.stiffness"),
            (
                "damping=-1",
                "damping = -1: give a number with a decimal point, 0 or above, in N.s/m",
            ),
            ("damping=1,5", "damping = 1,5"),
            ("damping=inf", "damping = inf"),
            (
                "loadedFlank=2",
                "loadedFlank = 2: give one of drive, coast, both",
            ),
            ("friction=1", "friction = 1: give true or false"),
        ] {
            let error = text.parse::<Setting>().unwrap_err().to_string();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
