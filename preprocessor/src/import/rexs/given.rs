//! Numbers of REXS files in mm, degrees and GPa, with where they stand.

use gearmesh::words::rounded;
use serde_json::Value;

use super::model::{Attribute, Component, Result, refused};

/// Number of mm, degrees or GPa in the unit of REXS.
fn scale(unit: &str) -> Option<f64> {
    match unit.replace(' ', "").as_str() {
        "none" | "" | "mm" | "°" | "deg" | "GPa" => Some(1.0),
        "mum" | "µm" | "um" | "MPa" | "N/mm^2" | "N/mm²" => Some(1e-3),
        "m" => Some(1e3),
        "rad" => Some(1f64.to_degrees()),
        _ => None,
    }
}

/// What the attribute `id` is measured in, as its name says, with units of that.
fn quantity(id: &str) -> (&'static str, &'static [&'static str]) {
    match id {
        _ if id.contains("angle") => ("an angle", &["°", "deg", "rad"]),
        _ if id.contains("modulus") => ("a modulus", &["GPa", "MPa", "N/mm^2", "N/mm²"]),
        _ => ("a length or a number", &["mm", "mum", "µm", "um", "m"]),
    }
}

pub(super) fn um(mm: f64) -> f64 {
    rounded(1e3 * mm)
}

pub(super) fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * (1.0 + a.abs())
}

/// A number in mm, degrees, GPa or none, and where it stands.
#[derive(Clone)]
pub(super) struct Given {
    pub value: f64,
    pub origin: String,
}

/// The attribute `a` of `component` as numbers.
fn numbers(component: &Component, a: &Attribute) -> Result<Vec<f64>> {
    let attribute = format!("attribute `{}` of component {}", a.id, component.id);
    let Some(scale) = scale(&a.unit) else {
        return refused(format!(
            "{attribute}: unit `{}` is none of mm, mum, m, °, rad, MPa, N / mm^2",
            a.unit
        ));
    };
    let (what, units) = quantity(&a.id);
    let unit = a.unit.replace(' ', "");
    if !["none", ""].contains(&&unit[..]) && !units.contains(&&unit[..]) {
        return refused(format!(
            "{attribute}: unit `{}`, and it is {what}; give it in one of {}",
            a.unit,
            units.join(", ")
        ));
    }
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
