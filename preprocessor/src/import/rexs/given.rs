//! Numbers of REXS files in mm, degrees, GPa and N m, with where they stand.

use gearmesh::words::rounded;
use serde_json::Value;

use super::model::{Attribute, Component, Result, refused};

/// What the attribute `id` is measured in, as its name says, with the units of that and how many mm, degrees, GPa or N m each is.
fn quantity(id: &str) -> (&'static str, &'static [(&'static str, f64)]) {
    match id {
        _ if id.contains("angle") => (
            "an angle",
            &[
                ("°", 1.0),
                ("deg", 1.0),
                ("rad", 180.0 / std::f64::consts::PI),
            ],
        ),
        _ if id.contains("torque") => ("a torque", &[("Nm", 1.0), ("kNm", 1e3), ("Nmm", 1e-3)]),
        _ if id.contains("modulus") => (
            "a modulus",
            &[
                ("MPa", 1e-3),
                ("N/mm^2", 1e-3),
                ("N/mm²", 1e-3),
                ("GPa", 1.0),
            ],
        ),
        _ if ["number", "coefficient", "factor", "ratio"]
            .iter()
            .any(|word| id.contains(word)) =>
        {
            ("a number", &[])
        }
        _ => (
            "a length",
            &[
                ("mm", 1.0),
                ("mum", 1e-3),
                ("µm", 1e-3),
                ("um", 1e-3),
                ("m", 1e3),
            ],
        ),
    }
}

/// How many mm, degrees, GPa or N m the unit of the attribute `a` is, 1 where it has none; else why it cannot be.
fn scale(a: &Attribute) -> std::result::Result<f64, String> {
    let unit = a.unit.replace(' ', "");
    let (what, units) = quantity(&a.id);
    if ["none", ""].contains(&&unit[..]) {
        return Ok(1.0);
    }
    let known = units.iter().find(|(name, _)| *name == unit);
    known.map(|(_, scale)| *scale).ok_or_else(|| {
        let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        let (unit, names) = (&a.unit, names.join(", "));
        match units.is_empty() {
            true => format!("unit `{unit}`, and it is {what}; give it without a unit"),
            false => format!("unit `{unit}`, and it is {what}; give it in one of {names}"),
        }
    })
}

pub(super) fn um(mm: f64) -> f64 {
    rounded(1e3 * mm)
}

pub(super) fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * (1.0 + a.abs())
}

/// A number in mm, degrees, GPa, N m or none, and where it stands.
#[derive(Clone)]
pub(super) struct Given {
    pub value: f64,
    pub origin: String,
}

/// The attribute `a` of `component` as numbers.
fn numbers(component: &Component, a: &Attribute) -> Result<Vec<f64>> {
    let attribute = format!("attribute `{}` of component {}", a.id, component.id);
    let scale = match scale(a) {
        Ok(scale) => scale,
        Err(problem) => return refused(format!("{attribute}: {problem}")),
    };
    let cells = match &a.value {
        Value::Array(cells) => &cells[..],
        one => std::slice::from_ref(one),
    };
    let numbers = cells.iter().map(|cell| {
        let text = cell.as_str().and_then(|text| text.trim().parse().ok());
        let number: Option<f64> = cell.as_f64().or(text);
        Some(rounded(number.filter(|number| number.is_finite())? * scale))
    });
    let numbers: Option<Vec<f64>> = numbers.collect();
    a.is_taken.set(true);
    numbers.map_or_else(
        || refused(format!("{attribute} = {}: no number", a.shown())),
        Ok,
    )
}

/// Numbers that `components` have under one of `names`, in the order of the names.
fn all_given(components: &[&Component], names: &[&str]) -> Result<Vec<Given>> {
    let mut found = Vec::new();
    for name in names {
        for c in components {
            let Some(a) = c.attribute(name) else { continue };
            let [value] = numbers(c, a)?[..] else {
                return refused(format!(
                    "attribute `{name}` of component {} = {}: no single number",
                    c.id,
                    a.shown()
                ));
            };
            let origin = format!("{name} of {} {}", c.kind, c.id);
            found.push(Given { value, origin });
        }
    }
    Ok(found)
}

/// The first of them.
pub(super) fn first(components: &[&Component], names: &[&str]) -> Result<Option<Given>> {
    Ok(all_given(components, names)?.into_iter().next())
}

/// The number in which all of them agree.
pub(super) fn agreed(
    field: &str,
    components: &[&Component],
    names: &[&str],
) -> Result<Option<Given>> {
    let all = all_given(components, names)?;
    let Some(first) = all.first() else {
        return Ok(None);
    };
    match all.iter().find(|other| !near(first.value, other.value)) {
        None => Ok(Some(first.clone())),
        Some(other) => refused(format!(
            "{field}: {} = {}, but {} = {}; correct the one that is wrong",
            first.origin, first.value, other.origin, other.value
        )),
    }
}

pub(super) fn vector(component: &Component, name: &str) -> Result<Option<[f64; 3]>> {
    let Some(a) = component.attribute(name) else {
        return Ok(None);
    };
    let numbers = numbers(component, a)?;
    let Ok(numbers) = numbers.try_into() else {
        let (id, value) = (&component.id, a.shown());
        return refused(format!(
            "attribute `{name}` of component {id} = {value}: no three numbers"
        ));
    };
    Ok(Some(numbers))
}
