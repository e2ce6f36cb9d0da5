//! The documentation in the archive: a page with the frames drawn and all defaults, a picture, and
//! the licences.

use std::fmt::Write as _;

use super::starts::meshing_spin;
use crate::fmi::resources::UnitFile;
use crate::fmi::variables::{
    Causality, Kind, VARIABLES, Variability, Variable, escape, template_starts,
};

const PAGE: &str = include_str!("../../resources/documentation/index.html");
const FRAMES: &str = include_str!("../../docs/frames.svg");

/// The icon of the unit.
pub(super) const PICTURE: &[u8] = include_bytes!("../../resources/documentation/model.png");

/// One sentence about the unit.
pub(super) fn summary(unit: &UnitFile, has_tables: bool) -> String {
    let [g1, g2] = &unit.geometry.gears;
    let kind = if unit.geometry.ring().is_some() {
        "internal"
    } else {
        "external"
    };
    let (z1, z2) = (g1.teeth, g2.teeth);
    let stiffness = if has_tables {
        "tables of static tooth contact"
    } else {
        "constant stiffness"
    };
    let name = &unit.name;
    format!("Contact of the {kind} gear pair {name}, {z1} and {z2} teeth, with {stiffness}")
}

/// The files of the folder `documentation`.
pub(super) fn files(unit: &UnitFile, has_tables: bool) -> Vec<(String, Vec<u8>)> {
    let text = |name: &str, text: String| (format!("documentation/{name}"), text.into_bytes());
    vec![
        text("index.html", page(unit, has_tables)),
        text("licenses/license.txt", licence()),
        text(
            "licenses/LICENSE-MIT",
            include_str!("../../LICENSE-MIT").into(),
        ),
        text(
            "licenses/LICENSE-APACHE",
            include_str!("../../LICENSE-APACHE").into(),
        ),
    ]
}

fn licence() -> String {
    "This unit is licensed under MIT (LICENSE-MIT) or Apache-2.0 (LICENSE-APACHE), as you like.\n\
     Its library links Rust's standard library and crates under MIT, Apache-2.0, Zlib, BSD and\n\
     Unicode-3.0 terms, and the headers of the FMI standard (BSD 2-clause).\n"
        .into()
}

fn page(unit: &UnitFile, has_tables: bool) -> String {
    let frames = FRAMES.find("<svg").map_or(FRAMES, |start| &FRAMES[start..]);
    let mut starts = template_starts();
    for (i, v) in VARIABLES.iter().enumerate() {
        if let Some(value) = unit.starts.get(v.name) {
            starts[i] = *value;
        }
    }
    let table = |causality| variables(causality, &starts);
    PAGE.replace("@NAME@", &escape(&unit.name))
        .replace("@SUMMARY@", &escape(&summary(unit, has_tables)))
        .replace("@PAIR@", &pair(unit))
        .replace("@FRAMES@", frames)
        .replace("@SPIN@", &format!("{:.9}", meshing_spin(&unit.geometry)))
        .replace("@PARAMETERS@", &table(Causality::Parameter))
        .replace("@INPUTS@", &table(Causality::Input))
        .replace("@OUTPUTS@", &table(Causality::Output))
}

fn pair(unit: &UnitFile) -> String {
    let geometry = &unit.geometry;
    let distance = geometry.center_distance;
    let angle = geometry.operating_pressure_angle(distance).to_degrees();
    let mut out = String::from("<table><tr><th></th><th>gear 1</th><th>gear 2</th></tr>\n");
    let mut row = |what: &str, of: &dyn Fn(usize) -> String| {
        let (one, two) = (of(0), of(1));
        let _ = writeln!(out, "<tr><td>{what}</td><td>{one}</td><td>{two}</td></tr>");
    };
    let g = &geometry.gears;
    row("teeth", &|i| g[i].teeth.to_string());
    row("kind", &|i| format!("{:?}", g[i].kind).to_lowercase());
    row("hand", &|i| {
        match (g[i].helix_angle > 0.0, g[i].hand > 0.0) {
            (false, _) => "spur",
            (true, true) => "right",
            (true, false) => "left",
        }
        .into()
    });
    row("profile shift", &|i| g[i].profile_shift.to_string());
    row("face width, mm", &|i| {
        format!("{:.3}", 1e3 * g[i].face_width)
    });
    row("tip diameter, mm", &|i| {
        format!("{:.3}", 2e3 * g[i].tip_radius)
    });
    let _ = writeln!(
        out,
        "</table>\n<p>Normal module {:.3} mm, normal pressure angle {:.2} deg, helix angle {:.2} deg, \
         centre distance {:.4} mm, operating transverse pressure angle {angle:.3} deg, transverse \
         contact ratio {:.3}, overlap ratio {:.3}.</p>",
        1e3 * g[0].normal_module,
        g[0].normal_pressure_angle.to_degrees(),
        g[0].helix_angle.to_degrees(),
        1e3 * distance,
        geometry.transverse_contact_ratio(distance),
        geometry.overlap_ratio()
    );
    out
}

/// All variables of one causality, with unit and start value.
fn variables(causality: Causality, starts: &[f64]) -> String {
    let with_start = causality != Causality::Output;
    let mut out = String::from("<table><tr><th>name</th><th>value reference</th><th>unit</th>");
    out.push_str(if with_start { "<th>default</th>" } else { "" });
    out.push_str("<th>meaning</th></tr>\n");
    for (v, start) in VARIABLES.iter().zip(starts) {
        if v.causality != causality {
            continue;
        }
        let _ = write!(
            out,
            "<tr><td><code>{}</code></td><td>{}</td><td>{}</td>",
            v.name, v.value_reference, v.unit
        );
        if with_start {
            let _ = write!(out, "<td>{}</td>", value(v, *start));
        }
        let _ = writeln!(out, "<td>{}{}</td></tr>", escape(v.description), remarks(v));
    }
    out + "</table>"
}

fn value(variable: &Variable, value: f64) -> String {
    match variable.kind {
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Enumeration => variable.items[value as usize - 1].to_owned(),
        Kind::Real | Kind::Integer if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) => {
            format!("{value:e}")
        }
        Kind::Real | Kind::Integer => value.to_string(),
    }
}

fn remarks(variable: &Variable) -> String {
    let mut out = String::new();
    if !variable.items.is_empty() {
        let items = variable.items.iter().enumerate();
        let items: Vec<String> = items.map(|(i, name)| format!("{} {name}", i + 1)).collect();
        let _ = write!(out, " ({})", items.join(", "));
    }
    if variable.variability == Variability::Tunable {
        out.push_str(" (tunable)");
    }
    out
}
