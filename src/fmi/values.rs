//! What is checked of the value references and values that a host passes.

use super::report::Refusal;
use super::variables::{Kind, VARIABLES, Variable, index_of};

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

/// Refuses NaN and infinities.
pub(super) fn check_finite(function: &str, name: &str, value: f64) -> Result<(), Refusal> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Refusal::error(format!(
        "{function}: {name} = {value}; set a finite number"
    )))
}

/// Refuses NaN, infinities and values outside the variable's range.
pub(super) fn check_value(function: &str, variable: &Variable, value: f64) -> Result<(), Refusal> {
    let name = variable.name;
    check_finite(function, name, value)?;
    let (min, max) = match variable.kind {
        Kind::Boolean => (Some(0.0), Some(1.0)),
        _ => (variable.min, variable.max),
    };
    if min.is_none_or(|m| value >= m) && max.is_none_or(|m| value <= m) {
        return Ok(());
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
        "{function}: {name} = {value}; {remedy}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::index;

    fn message(i: usize, value: f64) -> String {
        let refused = check_value("fmi2SetX", &VARIABLES[i], value);
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
    fn each_variable_is_served_by_the_functions_of_its_type_alone() {
        for v in &VARIABLES {
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
