//! What describes an FMU in its archive: modelDescription.xml, a page with the frames drawn and all defaults, and the
//! licences.

use std::fmt::Write as _;

use super::driven::CYCLES;
use super::dynamics::{MeshDynamics, nominal_pose};
use super::starts::meshing_spin;
use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{
    Causality, Kind, STOP_TIME, VARIABLES, Variability, Variable, index, index_by_name,
};
use gearmesh::gear::Flank;
use gearmesh::table::Table;
use gearmesh::words::{fixed, rounded, significant};
use roxmltree::{Document, Node};

/// The template of modelDescription.xml, without what belongs to a pair.
pub(super) const TEMPLATE: &str = include_str!("../../../modelDescription.xml");
const PAGE: &str = include_str!("../../../resources/documentation/index.html");
const LICENCE: &str = "This FMU is licensed under MIT (LICENSE-MIT) or Apache-2.0 (LICENSE-APACHE), as you like.\n\
     third-party.txt has the licences of the crates that its library links.\n";
const FRAMES: &str = include_str!("../../../docs/frames.svg");

/// Files that are the same in each FMU.
const CONSTANT: [(&str, &[u8]); 5] = [
    (
        "model.png",
        include_bytes!("../../../resources/documentation/model.png"),
    ),
    ("documentation/licenses/license.txt", LICENCE.as_bytes()),
    (
        "documentation/licenses/LICENSE-MIT",
        include_bytes!("../../../LICENSE-MIT"),
    ),
    (
        "documentation/licenses/LICENSE-APACHE",
        include_bytes!("../../../LICENSE-APACHE"),
    ),
    // `make licenses` writes it.
    (
        "documentation/licenses/third-party.txt",
        include_bytes!("../../../resources/documentation/third-party.txt"),
    ),
];

/// What there is to describe.
pub(super) struct Description<'a> {
    pub unit: &'a UnitFile,
    pub table: Option<&'a Table>,
    pub dynamics: &'a MeshDynamics,
    /// By [`super::step_error`].
    pub step_error: Option<f64>,
    /// Input signals as CSV.
    pub example: Option<String>,
}

impl Description<'_> {
    /// Files of the archive by their names.
    pub fn files(self) -> Vec<(String, Vec<u8>)> {
        let mut files = CONSTANT
            .map(|(name, bytes)| (name.to_owned(), bytes.to_vec()))
            .to_vec();
        files.push(("modelDescription.xml".into(), self.xml().into_bytes()));
        files.push(("documentation/index.html".into(), self.page().into_bytes()));
        let example = self.example.map(String::into_bytes);
        files.extend(example.map(|bytes| ("documentation/example-input.csv".into(), bytes)));
        files
    }

    /// One sentence about the FMU, for XML.
    fn summary(&self) -> String {
        let [z1, z2] = self.unit.geometry.gears.each_ref().map(|gear| gear.teeth);
        let is_internal = self.unit.geometry.ring().is_some();
        let kind = if is_internal { "internal" } else { "external" };
        let has_tables = self.table.is_some();
        let stiffness = if has_tables {
            "tables of static tooth contact"
        } else {
            "constant stiffness"
        };
        let name = escape(&self.unit.name);
        format!("Contact of the {kind} gear pair {name}, {z1} and {z2} teeth, with {stiffness}")
    }

    /// modelDescription.xml: the template with name, GUID, step and start values.
    fn xml(&self) -> String {
        let document = Document::parse(TEMPLATE).expect("the template is XML");
        let root = document.root_element();
        let mut edits: Vec<(Node, &str, String)> = vec![
            (root, "modelName", escape(&self.unit.name)),
            (root, "guid", self.unit.guid.clone()),
            (root, "description", self.summary()),
        ];
        for node in document.descendants() {
            let start = node
                .attribute("name")
                .and_then(|name| self.unit.starts.get(name));
            if node.has_tag_name("DefaultExperiment") {
                edits.push((node, "stepSize", format!("{:?}", self.dynamics.step())));
            } else if let (Some(start), Some(typed)) = (start, node.first_element_child()) {
                let text = match typed.tag_name().name() {
                    "Real" => format!("{start:?}"),
                    "Boolean" => (*start != 0.0).to_string(),
                    _ => format!("{start:.0}"),
                };
                edits.push((typed, "start", text));
            }
        }
        let (mut out, mut done) = (String::new(), 0);
        for (node, attribute, text) in edits {
            if let Some(attribute) = node.attribute_node(attribute) {
                let range = attribute.range_value();
                out += &TEMPLATE[done..range.start];
                out += &text;
                done = range.end;
            }
        }
        out + &TEMPLATE[done..]
    }

    /// The page: the template without the parts that do not apply, and with the numbers of this FMU.
    fn page(&self) -> String {
        let (c, geometry) = (self.dynamics, &self.unit.geometry);
        let mut page = PAGE.to_owned();
        for (part, applies) in [
            ("tables", self.table.is_some()),
            ("no tables", self.table.is_none()),
            ("example", self.example.is_some()),
            ("no example", self.example.is_none()),
            ("step error", self.step_error.is_some()),
            ("undamped", c.held && c.damping == 0.0),
        ] {
            let start = format!("<!--if {part}-->\n");
            if let Some((before, rest)) = page.split_once(&start)
                && let Some((inside, after)) = rest.split_once("<!--end-->\n")
            {
                page = [before, if applies { inside } else { "" }, after].concat();
            }
        }
        let mut texts = Vec::new();
        let mut put = |key: &str, text: String| texts.push((format!("@{key}@"), text));
        put("NAME", escape(&self.unit.name));
        put("SUMMARY", self.summary());
        let svg = FRAMES.find("<svg").unwrap_or(0);
        put("FRAMES", FRAMES[svg..].to_owned());
        put("SPIN", format!("{:.9}", meshing_spin(geometry)));
        let torque = self.start(&VARIABLES[index::NOMINAL_TORQUE]);
        put("TORQUE", torque.to_string());
        put("CYCLES", CYCLES.to_string());
        put("STOP", STOP_TIME.to_string());
        if let Some(tables) = self.table {
            let rows = tables.file().summary().into_iter();
            let rows = rows.map(|(name, value)| [escape(&name), escape(&value)]);
            put("TABLES", table(&[], rows));
            put("STE", ste_figure(tables, torque));
        }
        put("PARAMETERS", self.variables(Causality::Parameter));
        put("INPUTS", self.variables(Causality::Input));
        put("OUTPUTS", self.variables(Causality::Output));
        for (number, gear, blank) in [
            (1, &geometry.gears[0], &c.blanks[0]),
            (2, &geometry.gears[1], &c.blanks[1]),
        ] {
            let hand = match gear.hand > 0.0 {
                _ if gear.helix_angle == 0.0 => "spur",
                true => "right",
                false => "left",
            };
            let mut put = |key: &str, text: String| put(&format!("{key}_{number}"), text);
            put("TEETH", gear.teeth.to_string());
            put("KIND", format!("{:?}", gear.kind).to_lowercase());
            put("HAND", hand.to_owned());
            put("SHIFT", gear.profile_shift.to_string());
            put("WIDTH", fixed(1e3 * gear.face_width, 3));
            put("TIP", fixed(2e3 * gear.tip_radius, 3));
            put("MASS", significant(blank.mass, 4));
            put("INERTIA", significant(blank.axial_inertia, 4));
        }
        let gear = &geometry.gears[0];
        let distance = geometry.center_distance;
        let phi = geometry.operating_pressure_angle(distance);
        let pressure_angle = gear.normal_pressure_angle;
        put("MODULE", fixed(1e3 * gear.normal_module, 3));
        put("PRESSURE_ANGLE", fixed(pressure_angle.to_degrees(), 2));
        put("HELIX", fixed(gear.helix_angle.to_degrees(), 2));
        put("DISTANCE", fixed(1e3 * distance, 4));
        put("PHI", fixed(phi.to_degrees(), 3));
        let ratio = geometry.transverse_contact_ratio(distance);
        put("CONTACT_RATIO", fixed(ratio, 3));
        put("OVERLAP_RATIO", fixed(geometry.overlap_ratio(), 3));
        for (key, value) in [
            ("REDUCED_MASS", c.reduced_mass),
            ("FREE_MASS", c.free_mass),
            ("MEAN_STIFFNESS", c.stiffness.mean),
            ("LARGEST_STIFFNESS", c.stiffness.largest),
            ("FREQUENCY", c.frequency()),
            ("DAMPING", c.damping),
            ("DAMPING_RATIO", c.damping_ratio()),
            ("EFFECTIVE_MASS", c.effective_mass),
            ("STEP", c.step()),
            ("SEQUENTIAL_LIMIT", c.sequential_limit()),
            ("PARALLEL_LIMIT", c.parallel_limit()),
            ("STEP_ERROR", 100.0 * self.step_error.unwrap_or(0.0)),
        ] {
            put(key, significant(value, 4));
        }
        for (key, text) in texts {
            page = page.replace(&key, &text);
        }
        page
    }

    /// All variables of one causality with their start values; outputs have none.
    fn variables(&self, causality: Causality) -> String {
        let default = if causality == Causality::Output {
            ""
        } else {
            "default"
        };
        let heads = ["name", "value reference", "unit", default, "meaning"];
        let chosen = VARIABLES.iter().filter(|v| v.causality == causality);
        let rows = chosen.map(|v| {
            let start = v.start.map(|_| value(v, self.start(v)));
            let mut meaning = escape(v.description);
            if !v.items.is_empty() {
                let _ = write!(meaning, ": {}", v.numbered_items());
            }
            if v.variability == Variability::Tunable {
                meaning += " (tunable)";
            }
            [
                format!("<code>{}</code>", v.name),
                v.value_reference.to_string(),
                v.unit.to_owned(),
                start.unwrap_or_default(),
                meaning,
            ]
        });
        table(&heads, rows)
    }

    fn start(&self, variable: &Variable) -> f64 {
        let own = self.unit.starts.get(variable.name).copied();
        own.or(variable.start).unwrap_or(0.0)
    }
}

/// Text inside an XML attribute or element.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A table of HTML with these heads, if there are any.
fn table<const N: usize>(heads: &[&str], rows: impl IntoIterator<Item = [String; N]>) -> String {
    let line = |tag: &str, cells: &[&str]| {
        let cells = cells.iter().map(|cell| format!("<{tag}>{cell}</{tag}>"));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let mut out = String::from("<table>\n");
    if !heads.is_empty() {
        out += &line("th", heads);
    }
    for row in rows {
        out += &line("td", &row.each_ref().map(String::as_str));
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
            let item = variable.items.get((value - 1.0) as usize);
            item.map_or_else(|| value.to_string(), |name| (*name).to_owned())
        }
        Kind::Real if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) => {
            format!("{value:e}")
        }
        Kind::Real => value.to_string(),
    }
}

/// Points of the curve.
const POINTS: usize = 96;

/// Left, top, width and height of the diagram's frame, pixels.
const FRAME: [f64; 4] = [60.0, 15.0, 560.0, 150.0];

/// Static transmission error on the line of action (m) at both ends of one base pitch and evenly between: drive flank,
/// aligned, nominal centre distance, under `torque` on gear 1 (N m).
fn curve(table: &Table, torque: f64) -> Vec<f64> {
    let force = torque / table.geometry().gears[0].base_radius();
    let (drive, _) = table.flank(Flank::Drive);
    let positions = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
    let approaches = positions.map(|position| drive.approach_at(force, &nominal_pose(position)));
    approaches.collect()
}

/// A figure of HTML with the curve at `torque` (on gear 1, N m), or at the largest of the tables.
fn ste_figure(table: &Table, torque: f64) -> String {
    let torque = torque.min(table.file().maximum_torque_nm);
    let values: Vec<f64> = (curve(table, torque).iter()).map(|m| 1e6 * m).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [left, top, width, height] = FRAME;
    // A curve without variation lies at the bottom.
    let scale = height / (largest - least).max(1e-9);
    let mut points = String::new();
    for (i, value) in values.iter().enumerate() {
        let x = left + width * i as f64 / POINTS as f64;
        let y = top + height - scale * (value - least);
        let _ = write!(points, "{x:.1},{y:.1} ");
    }
    let (right, bottom) = (left + width, top + height);
    let (line, text) = (bottom + 18.0, left - 8.0);
    format!(
        r##"<figure>
<svg viewBox="0 0 640 190" style="max-width: 640px" font-family="sans-serif" font-size="13" role="img" aria-label="Static transmission error over one base pitch">
<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#bbb"/>
<polyline points="{points}" fill="none" stroke="#c33" stroke-width="2"/>
<g fill="#222"><text x="{left}" y="{line}" text-anchor="middle">0</text><text x="{right}" y="{line}" text-anchor="middle">1</text>
<text x="340" y="{line}" text-anchor="middle">base pitches</text><text x="{text}" y="{bottom}" text-anchor="end">{}</text>
<text x="{text}" y="{top}" dy="0.7em" text-anchor="end">{}</text><text x="{text}" y="95" text-anchor="end">um</text></g>
</svg>
<figcaption>Static transmission error on the line of action at {} N m on gear 1, aligned, at the nominal centre distance: mean {} um,
peak to peak {} um.</figcaption>
</figure>
"##,
        fixed(least, 2),
        fixed(largest, 2),
        rounded(torque),
        fixed(values[1..].iter().sum::<f64>() / POINTS as f64, 2),
        fixed(largest - least, 3)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::{Starts, shipped_tables};
    use crate::samples::paper_pair;
    use gearmesh::fmi::resources::UNIT_VERSION;
    use gearmesh::table::TableFile;

    #[test]
    fn packing_changes_the_start_values_it_names_and_nothing_else() {
        let geometry = paper_pair(1.0);
        let dynamics = Starts::constant_stiffness(&geometry, 100.0).dynamics(&geometry);
        let starts = [
            ("gear2.position[1]", 0.25),
            ("misalignmentEffect", 1.0),
            ("stiffnessModel", 2.0),
        ];
        let unit = UnitFile {
            version: UNIT_VERSION,
            guid: "{guid}".into(),
            name: "20/30 \"spur\"".into(),
            starts: starts.map(|(name, value)| (name.to_owned(), value)).into(),
            geometry,
        };
        let description = Description {
            unit: &unit,
            table: None,
            dynamics: &dynamics,
            step_error: None,
            example: None,
        };
        let page = description.page();
        let unfilled = page.split('@').skip(1).step_by(2).find(|key| {
            key.chars()
                .all(|c| c.is_ascii_uppercase() || c == '_' || c.is_ascii_digit())
        });
        assert_eq!(unfilled, None);
        assert!(!page.contains("<!--if") && !page.contains("<!--end"));
        let text = description.xml();
        let before: Vec<&str> = TEMPLATE.lines().collect();
        let after: Vec<&str> = text.lines().collect();
        assert_eq!(before.len(), after.len());
        let changed = before.iter().zip(&after).filter(|(a, b)| a != b);
        assert_eq!(changed.count(), 7);
        for part in [
            "modelName=\"20/30 &quot;spur&quot;\"",
            "guid=\"{guid}\"",
            "gear pair 20/30 &quot;spur&quot;, 20 and 20 teeth",
            &format!("stepSize=\"{:?}\"", dynamics.step()),
            "<Real unit=\"m\" displayUnit=\"mm\" nominal=\"0.1\" start=\"0.25\"/>",
            "<Boolean start=\"true\"/>",
            "declaredType=\"StiffnessModel\" start=\"2\"",
        ] {
            assert!(text.contains(part), "{part}");
        }
    }

    /// Peak to peak of the approach (um) from the samples alone, linear between the displacements.
    fn of_samples(file: &TableFile, torque: f64) -> f64 {
        let grid = file.drive_grid();
        let lengths @ [_, nm, nu, columns] = grid.axes.lengths();
        let [c, m, ..] = lengths.map(|length| length / 2);
        let force = torque / file.geometry.gears[0].base_radius();
        let approaches = (0..columns).map(|p| {
            let carried = |u| grid.loa_force[((c * nm + m) * nu + u) * columns + p];
            let approach = |u| 1e6 * grid.query([c, m, u, p]).delta;
            let above = (1..nu).find(|&u| carried(u) >= force).unwrap();
            let below = above - 1;
            let share = (force - carried(below)) / (carried(above) - carried(below));
            approach(below) + share * (approach(above) - approach(below))
        });
        let approaches: Vec<f64> = approaches.collect();
        let [least, largest] = [f64::min, f64::max].map(|f| approaches.iter().copied().reduce(f));
        largest.unwrap() - least.unwrap()
    }

    #[test]
    fn the_curve_is_drawn_with_the_variation_that_the_tables_hold() {
        for name in ["fzg-c", "palermo2013"] {
            let file = shipped_tables(name);
            let torque = 0.8 * file.nominal_torque_nm;
            let table = Table::from_file(file.clone()).unwrap();
            let figure = ste_figure(&table, torque);
            let number = |after: &str| -> f64 {
                let (_, text) = figure.split_once(after).unwrap();
                text.split_whitespace().next().unwrap().parse().unwrap()
            };
            let peak_to_peak = number("peak to peak ");
            let expected = of_samples(&file, torque);
            assert!(
                (peak_to_peak / expected - 1.0).abs() < 0.05,
                "{name}: {peak_to_peak} {expected}"
            );
            // Beyond the tables: at their largest torque.
            let end = ste_figure(&table, 1e9);
            assert_eq!(end, ste_figure(&table, file.maximum_torque_nm));
        }
    }
}
