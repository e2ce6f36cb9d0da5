//! The documentation in the archive: a page with the frames drawn and all defaults, a picture, and
//! the licences.

use std::fmt::Write as _;

use super::coupling::{Coupling, DAMPING_RATIO};
use super::example::CYCLES;
use super::starts::meshing_spin;
use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{
    Causality, Kind, STOP_TIME, VARIABLES, Variability, Variable, escape, index, index_by_name,
    template_starts,
};
use gearmesh::table::TableFile;
use gearmesh::words::rounded;

const PAGE: &str = include_str!("../../../resources/documentation/index.html");
/// Licences of what the library links; `make licenses` writes it.
const THIRD_PARTY: &str = include_str!("../../../resources/documentation/third-party.txt");
/// Name of the file of input signals.
const EXAMPLE: &str = "example-input.csv";
const FRAMES: &str = include_str!("../../../docs/frames.svg");

/// The icon of the unit.
pub(super) const PICTURE: &[u8] = include_bytes!("../../../resources/documentation/model.png");

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

/// The files of the folder `documentation`; `example` is the text of the signals in it.
pub(super) fn files(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    coupling: &Coupling,
    example: Option<String>,
) -> Vec<(String, Vec<u8>)> {
    let text = |name: &str, text: String| (format!("documentation/{name}"), text.into_bytes());
    let page = page(unit, tables, coupling, example.is_some());
    let mut files = vec![
        text("index.html", page),
        text("licenses/license.txt", licence()),
        text(
            "licenses/LICENSE-MIT",
            include_str!("../../../LICENSE-MIT").into(),
        ),
        text(
            "licenses/LICENSE-APACHE",
            include_str!("../../../LICENSE-APACHE").into(),
        ),
        text("licenses/third-party.txt", THIRD_PARTY.into()),
    ];
    files.extend(example.map(|signals| text(EXAMPLE, signals)));
    files
}

fn licence() -> String {
    "This unit is licensed under MIT (LICENSE-MIT) or Apache-2.0 (LICENSE-APACHE), as you like.\n\
     third-party.txt has the licences of the crates that its library links.\n"
        .into()
}

fn page(unit: &UnitFile, tables: Option<&TableFile>, coupling: &Coupling, example: bool) -> String {
    let frames = FRAMES.find("<svg").map_or(FRAMES, |start| &FRAMES[start..]);
    let mut starts = template_starts();
    for (i, v) in VARIABLES.iter().enumerate() {
        if let Some(value) = unit.starts.get(v.name) {
            starts[i] = *value;
        }
    }
    let table = |causality| variables(causality, &starts);
    PAGE.replace("@NAME@", &escape(&unit.name))
        .replace("@SUMMARY@", &escape(&summary(unit, tables.is_some())))
        .replace("@PAIR@", &pair(unit))
        .replace("@TABLES@", &tabulated(tables))
        .replace("@FRAMES@", frames)
        .replace("@SPIN@", &format!("{:.9}", meshing_spin(&unit.geometry)))
        .replace(
            "@EXAMPLE@",
            &first_run(starts[index::NOMINAL_TORQUE], example),
        )
        .replace("@COUPLING@", &step(coupling))
        .replace("@PARAMETERS@", &table(Causality::Parameter))
        .replace("@INPUTS@", &table(Causality::Input))
        .replace("@OUTPUTS@", &table(Causality::Output))
}

/// What the tables cover, how far they can be trusted, and what they were made of.
fn tabulated(tables: Option<&TableFile>) -> String {
    let Some(file) = tables else {
        return "<p>None: the stiffness is constant.</p>".into();
    };
    let mut out = String::from("<table>\n");
    for (name, value) in file.summary() {
        let (name, value) = (escape(&name), escape(&value));
        let _ = writeln!(out, "<tr><td>{name}</td><td>{value}</td></tr>");
    }
    out + "</table>"
}

/// How to see the unit at work.
fn first_run(torque: f64, example: bool) -> String {
    if !example {
        return "<p>The nominal torque is more than the mesh bears within a quarter of a pitch, so that there \
                is no example input.</p>"
            .into();
    }
    format!(
        "<p><code>documentation/{EXAMPLE}</code> in the archive holds input signals for the default experiment, \
         0 to {STOP_TIME} s: gear 1 turns at a constant speed through {CYCLES} mesh cycles, and gear 2 follows behind by what \
         the contact yields under {torque} N m on gear 1, reached after the first cycle. Give them to any host, such as \
         fmpy, here for an archive UNIT.fmu:</p>\n\
         <pre>python -m zipfile -e UNIT.fmu unit\n\
         fmpy simulate UNIT.fmu --input-file unit/documentation/{EXAMPLE} --output-file outputs.csv</pre>\n\
         <p>From the second cycle on <code>gear1.moment[3]</code> shows that torque, and \
         <code>mesh.transmissionError</code> the transmission error over the cycle. Without any input the gears stand \
         still and just touch: all loads are zero.</p>"
    )
}

/// Damping and communication step, with the numbers of this unit.
fn step(c: &Coupling) -> String {
    let [b1, b2] = &c.blanks;
    let mut out = String::from("<table><tr><th></th><th>gear 1</th><th>gear 2</th></tr>\n");
    let mut row = |what: &str, values: [f64; 2]| {
        let [one, two] = values.map(short);
        let _ = writeln!(out, "<tr><td>{what}</td><td>{one}</td><td>{two}</td></tr>");
    };
    row("mass as a solid steel disc, kg", [b1.mass, b2.mass]);
    row(
        "its moment of inertia about the axis, kg m&sup2;",
        [b1.axial_inertia, b2.axial_inertia],
    );
    out.push_str("</table>\n<table>\n");
    let mut row = |what: &str, value: f64, unit: &str| {
        let value = short(value);
        let _ = writeln!(out, "<tr><td>{what}</td><td>{value} {unit}</td></tr>");
    };
    let stiffness = &c.stiffness;
    row(
        "reduced mass m on the pitch circle, both spinning",
        c.reduced_mass,
        "kg",
    );
    row("the same with all six freedoms of both", c.free_mass, "kg");
    row(
        "mean tangent stiffness k at nominal torque",
        stiffness.mean,
        "N/m",
    );
    row(
        "largest tangent stiffness, k<sub>max</sub>",
        stiffness.largest,
        "N/m",
    );
    row(
        "angular frequency sqrt(k/m) of both gears",
        c.frequency(),
        "rad/s",
    );
    row("<code>damping</code> c", c.damping, "N s/m");
    row("its ratio c/(2 sqrt(k m))", c.damping_ratio(), "");
    row(
        "<code>effectiveMass</code> on the line of action",
        c.effective_mass,
        "kg",
    );
    row("<code>stepSize</code>", c.step(), "s");
    row(
        "held loads: longest stable step, sequential master",
        c.sequential_limit(),
        "s",
    );
    row(
        "held loads: longest stable step, parallel master",
        c.parallel_limit(),
        "s",
    );
    out.push_str("</table>");
    if c.held && c.damping == 0.0 {
        let _ = write!(
            out,
            "\n<p>This unit starts without damping: then no step is stable under held forces, and \
             <code>stepSize</code> is that of a damping ratio of {DAMPING_RATIO}.</p>"
        );
    }
    out
}

/// `value` to four digits.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-2..1e5).contains(&value.abs()) {
        let decimals = if value == 0.0 {
            0
        } else {
            (3 - value.abs().log10().floor() as i32).max(0) as usize
        };
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
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

/// Start value of the variable `name` as a person writes it: an item's name, true or false, a number with its unit as in
/// modelDescription.xml.
pub fn start_in_words(name: &str, start: f64) -> String {
    let Some(i) = index_by_name(name) else {
        return start.to_string();
    };
    let (value, unit) = (value(&VARIABLES[i], start), VARIABLES[i].unit);
    match unit {
        "" | "1" => value,
        unit => format!("{value} {unit}"),
    }
}

fn value(variable: &Variable, value: f64) -> String {
    let value = rounded(value);
    match variable.kind {
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Enumeration => {
            let item = (value as usize)
                .checked_sub(1)
                .and_then(|i| variable.items.get(i));
            item.map_or_else(|| value.to_string(), |name| (*name).to_owned())
        }
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
