//! Values of variables, and what is checked of those that a host passes.

use super::layout::{Role, role};
use super::report::Refusal;
use super::variables::{Kind, VARIABLES, Variable, index_of};
use crate::words;

/// Value of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Of a Real.
    Real(f64),
    /// Of an Integer, or the number of an enumeration's item, counted from 1.
    Integer(i32),
    /// Of a Boolean.
    Boolean(bool),
}

impl Value {
    /// The value of a variable of `kind` that a start value writes as `number`: a Boolean as 0 or 1.
    /// `None` if it is no such value.
    pub fn of(kind: Kind, number: f64) -> Option<Self> {
        let whole = number as i32;
        match kind {
            Kind::Real => Some(Value::Real(number)),
            Kind::Boolean if number == 0.0 || number == 1.0 => Some(Value::Boolean(whole == 1)),
            Kind::Integer | Kind::Enumeration if f64::from(whole) == number => {
                Some(Value::Integer(whole))
            }
            _ => None,
        }
    }

    /// The number that a start value writes for it.
    pub fn number(self) -> f64 {
        match self {
            Value::Real(x) => x,
            Value::Integer(x) => f64::from(x),
            Value::Boolean(x) => f64::from(u8::from(x)),
        }
    }
}

/// Index of the variable with this reference, if functions of `kind` serve it.
pub(super) fn find(function: &str, kind: Kind, reference: u32) -> Result<usize, Refusal> {
    let i = index_of(reference).ok_or_else(|| {
        Refusal::error(format!(
            "{function}: value reference {reference} belongs to no variable"
        ))
    })?;
    let variable = &VARIABLES[i];
    let served = match variable.kind {
        Kind::Enumeration => Kind::Integer,
        other => other,
    };
    if served != kind {
        return Err(Refusal::error(format!(
            "{function}: {} (value reference {reference}) is a {:?}",
            variable.name, variable.kind
        )));
    }
    Ok(i)
}

/// Index and name of the input with this reference.
pub(super) fn input(function: &str, reference: u32) -> Result<(usize, &'static str), Refusal> {
    let i = find(function, Kind::Real, reference)?;
    let name = VARIABLES[i].name;
    if role(i) == Role::Input {
        return Ok((i, name));
    }
    Err(Refusal::error(format!("{function}: {name} is no input")))
}

/// Refuses NaN and infinities.
pub(super) fn check_finite(function: &str, name: &str, value: f64) -> Result<(), Refusal> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Refusal::error(format!(
        "{function}: {name} = {value}; set a finite number"
    )))
}

/// The value that `number` is for `variable`: not for NaN, infinities and what lies outside its range.
pub(super) fn accept(function: &str, variable: &Variable, number: f64) -> Result<Value, Refusal> {
    let name = variable.name;
    check_finite(function, name, number)?;
    let (min, max) = match variable.kind {
        Kind::Boolean => (Some(0.0), Some(1.0)),
        _ => (variable.min, variable.max),
    };
    if min.is_none_or(|m| number >= m)
        && max.is_none_or(|m| number <= m)
        && let Some(value) = Value::of(variable.kind, number)
    {
        return Ok(value);
    }
    let remedy = match (variable.kind, min, max) {
        (Kind::Enumeration, _, _) => {
            let items = variable.items.iter().enumerate();
            let items: Vec<String> = items.map(|(i, n)| format!("{} ({n})", i + 1)).collect();
            format!("choose one of {}", items.join(", "))
        }
        (_, Some(min), Some(max)) => format!("set {min} to {max}"),
        (_, Some(min), None) => format!("set {min} or more"),
        (_, _, max) => format!("set {} or less", max.unwrap_or(f64::INFINITY)),
    };
    Err(Refusal::error(format!(
        "{function}: {name} = {}; {remedy}",
        words::number(number)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::index;

    fn message(i: usize, value: f64) -> String {
        let refused = accept("fmi2SetX", &VARIABLES[i], value);
        refused.expect_err("out of range").message
    }

    #[test]
    fn a_refusal_names_variable_value_and_remedy() {
        assert_eq!(
            message(index::GEAR1_POSITION_2, f64::NAN),
            "fmi2SetX: gear1.position[2] = NaN; set a finite number"
        );
        assert_eq!(
            message(index::DAMPING, -1.0),
            "fmi2SetX: damping = -1; set 0 or more"
        );
        assert_eq!(
            message(index::FORMULATION, 3.0),
            "fmi2SetX: formulation = 3; choose one of 1 (paper), 2 (conjugate)"
        );
        assert_eq!(
            message(index::LOAD_DEPENDENT, 2.0),
            "fmi2SetX: loadDependent = 2; set 0 to 1"
        );
    }

    #[test]
    fn a_value_keeps_the_type_of_its_variable() {
        let of = |i: usize, number| accept("f", &VARIABLES[i], number).unwrap();
        assert_eq!(of(index::DAMPING, 2.5), Value::Real(2.5));
        assert_eq!(of(index::FORMULATION, 2.0), Value::Integer(2));
        assert_eq!(of(index::LOAD_DEPENDENT, 1.0), Value::Boolean(true));
        assert_eq!(Value::of(Kind::Enumeration, 1.5), None);
        assert_eq!(Value::of(Kind::Integer, 1e10), None);
        assert_eq!(Value::of(Kind::Boolean, f64::NAN), None);
    }

    #[test]
    fn each_variable_is_served_by_the_functions_of_its_type_alone() {
        for v in VARIABLES {
            for kind in [Kind::Real, Kind::Integer, Kind::Boolean] {
                let serves =
                    v.kind == kind || (v.kind == Kind::Enumeration && kind == Kind::Integer);
                assert_eq!(
                    find("f", kind, v.value_reference).is_ok(),
                    serves,
                    "{}",
                    v.name
                );
            }
        }
        let error = find("fmi2GetReal", Kind::Real, 77).unwrap_err();
        assert!(error.message.contains("value reference 77"));
    }
}
