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
use gearmesh::gear::Gear;
use gearmesh::table::TableFile;
use gearmesh::words::rounded;

const PAGE: &str = include_str!("../../../resources/documentation/index.html");
const LICENCE: &str = "This unit is licensed under MIT (LICENSE-MIT) or Apache-2.0 (LICENSE-APACHE), as you like.\n\
     third-party.txt has the licences of the crates that its library links.\n";
/// Licences of what the library links; `make licenses` writes it.
const THIRD_PARTY: &str = include_str!("../../../resources/documentation/third-party.txt");
/// Name of the file of input signals.
const EXAMPLE: &str = "example-input.csv";
const FRAMES: &str = include_str!("../../../docs/frames.svg");

/// The icon of the unit.
pub(super) const PICTURE: &[u8] = include_bytes!("../../../resources/documentation/model.png");

/// One sentence about the unit.
pub(super) fn summary(unit: &UnitFile, has_tables: bool) -> String {
    let [z1, z2] = unit.geometry.gears.each_ref().map(|gear| gear.teeth);
    let kind = match unit.geometry.ring() {
        Some(_) => "internal",
        None => "external",
    };
    let stiffness = match has_tables {
        true => "tables of static tooth contact",
        false => "constant stiffness",
    };
    let name = &unit.name;
    format!("Contact of the {kind} gear pair {name}, {z1} and {z2} teeth, with {stiffness}")
}

/// The files of the folder `documentation`; `example` is the text of the signals in it.
pub(super) fn files(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    coupling: &Coupling,
    step_error: Option<f64>,
    example: Option<String>,
) -> Vec<(String, Vec<u8>)> {
    let damping_and_step = step(coupling, step_error);
    let page = page(unit, tables, &damping_and_step, example.is_some());
    let files = [
        ("index.html", page.as_str()),
        ("licenses/license.txt", LICENCE),
        ("licenses/LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
        (
            "licenses/LICENSE-APACHE",
            include_str!("../../../LICENSE-APACHE"),
        ),
        ("licenses/third-party.txt", THIRD_PARTY),
    ];
    let example = example.as_deref().map(|signals| (EXAMPLE, signals));
    let files = files.into_iter().chain(example);
    files
        .map(|(name, text)| (format!("documentation/{name}"), text.as_bytes().to_vec()))
        .collect()
}

fn page(unit: &UnitFile, tables: Option<&TableFile>, coupling: &str, example: bool) -> String {
    let frames = FRAMES.find("<svg").map_or(FRAMES, |start| &FRAMES[start..]);
    let mut starts = template_starts();
    for (i, v) in VARIABLES.iter().enumerate() {
        if let Some(value) = unit.starts.get(v.name) {
            starts[i] = *value;
        }
    }
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
        .replace("@COUPLING@", coupling)
        .replace("@PARAMETERS@", &variables(Causality::Parameter, &starts))
        .replace("@INPUTS@", &variables(Causality::Input, &starts))
        .replace("@OUTPUTS@", &variables(Causality::Output, &starts))
}

/// A table with these heads, if there are any, and rows of HTML.
fn table(heads: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |tag: &str, cells: &mut dyn Iterator<Item = &str>| {
        let cells: String = cells.map(|cell| format!("<{tag}>{cell}</{tag}>")).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let mut out = String::from("<table>\n");
    if !heads.is_empty() {
        out += &line("th", &mut heads.iter().copied());
    }
    for row in rows {
        out += &line("td", &mut row.iter().map(String::as_str));
    }
    out + "</table>"
}

/// What the tables cover, how far they can be trusted, and what they were made of.
fn tabulated(tables: Option<&TableFile>) -> String {
    let Some(file) = tables else {
        return "<p>None: the stiffness is constant.</p>".into();
    };
    let rows = file.summary().into_iter();
    table(
        &[],
        rows.map(|(name, value)| vec![escape(&name), escape(&value)]),
    )
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
fn step(c: &Coupling, step_error: Option<f64>) -> String {
    let [b1, b2] = &c.blanks;
    #[rustfmt::skip]
    let blanks = [
        ("mass as a solid steel disc, kg", b1.mass, b2.mass),
        ("its moment of inertia about the axis, kg m&sup2;", b1.axial_inertia, b2.axial_inertia),
    ];
    #[rustfmt::skip]
    let numbers = [
        ("reduced mass m on the pitch circle, both spinning", c.reduced_mass, "kg"),
        ("the same with all six freedoms of both", c.free_mass, "kg"),
        ("mean tangent stiffness k at nominal torque", c.stiffness.mean, "N/m"),
        ("largest tangent stiffness, k<sub>max</sub>", c.stiffness.largest, "N/m"),
        ("angular frequency sqrt(k/m) of both gears", c.frequency(), "rad/s"),
        ("<code>damping</code> c", c.damping, "N s/m"),
        ("its ratio c/(2 sqrt(k m))", c.damping_ratio(), ""),
        ("<code>effectiveMass</code> on the line of action", c.effective_mass, "kg"),
        ("<code>stepSize</code>", c.step(), "s"),
        ("held loads: longest stable step, sequential master", c.sequential_limit(), "s"),
        ("held loads: longest stable step, parallel master", c.parallel_limit(), "s"),
    ];
    let blanks = blanks.map(|(what, one, two)| vec![what.to_owned(), short(one), short(two)]);
    let numbers = numbers
        .map(|(what, value, unit)| vec![what.to_owned(), format!("{} {unit}", short(value))]);
    let mut out = format!(
        "{}\n{}",
        table(&["", "gear 1", "gear 2"], blanks),
        table(&[], numbers)
    );
    if let Some(error) = step_error {
        let _ = write!(
            out,
            "\n<p>Error of <code>mesh.transmissionError</code> at this <code>stepSize</code>: {} % rms of its variation, while both \
             discs spin at 750 tooth pitches a second and take up the nominal torque within 2 ms.</p>",
            short(100.0 * error)
        );
    }
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
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-2..1e5).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let decimals = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

fn pair(unit: &UnitFile) -> String {
    let geometry = &unit.geometry;
    let distance = geometry.center_distance;
    let g = &geometry.gears;
    let row =
        |what: &str, value: fn(&Gear) -> String| vec![what.to_owned(), value(&g[0]), value(&g[1])];
    let hand = |gear: &Gear| match (gear.helix_angle > 0.0, gear.hand > 0.0) {
        (false, _) => "spur".to_owned(),
        (true, true) => "right".to_owned(),
        (true, false) => "left".to_owned(),
    };
    #[rustfmt::skip]
    let rows = [
        row("teeth", |gear| gear.teeth.to_string()),
        row("kind", |gear| format!("{:?}", gear.kind).to_lowercase()),
        row("hand", hand),
        row("profile shift", |gear| gear.profile_shift.to_string()),
        row("face width, mm", |gear| format!("{:.3}", 1e3 * gear.face_width)),
        row("tip diameter, mm", |gear| format!("{:.3}", 2e3 * gear.tip_radius)),
    ];
    format!(
        "{}\n<p>Normal module {:.3} mm, normal pressure angle {:.2} deg, helix angle {:.2} deg, \
         centre distance {:.4} mm, operating transverse pressure angle {:.3} deg, transverse \
         contact ratio {:.3}, overlap ratio {:.3}.</p>\n",
        table(&["", "gear 1", "gear 2"], rows),
        1e3 * g[0].normal_module,
        g[0].normal_pressure_angle.to_degrees(),
        g[0].helix_angle.to_degrees(),
        1e3 * distance,
        geometry.operating_pressure_angle(distance).to_degrees(),
        geometry.transverse_contact_ratio(distance),
        geometry.overlap_ratio()
    )
}

/// All variables of one causality, with unit and, but for outputs, start value.
fn variables(causality: Causality, starts: &[f64]) -> String {
    let mut heads = vec!["name", "value reference", "unit", "default", "meaning"];
    let is_output = causality == Causality::Output;
    if is_output {
        heads.remove(3);
    }
    let chosen = VARIABLES
        .iter()
        .zip(starts)
        .filter(|(v, _)| v.causality == causality);
    let rows = chosen.map(|(v, start)| {
        let mut row = vec![
            format!("<code>{}</code>", v.name),
            v.value_reference.to_string(),
            v.unit.to_owned(),
        ];
        row.extend((!is_output).then(|| value(v, *start)));
        row.push(escape(v.description) + &remarks(v));
        row
    });
    table(&heads, rows)
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
            let item = variable
                .items
                .iter()
                .zip(1..)
                .find(|(_, number)| f64::from(*number) == value);
            item.map_or_else(|| value.to_string(), |(name, _)| (*name).to_owned())
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
