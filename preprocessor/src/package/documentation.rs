//! What describes an FMU in its archive: modelDescription.xml, a page with the frames drawn and all defaults, and the
//! licences.

use std::fmt::Write as _;

use askama::Template;

use super::driven::CYCLES;
use super::dynamics::{MeshDynamics, nominal_pose};
use super::starts::meshing_spin;
use crate::pair::default_held_radius;
use crate::pair::drawing::hand;
use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{
    Causality, Kind, STOP_TIME, VARIABLES, Variability, Variable, index, index_by_name,
};
use gearmesh::gear::{Flank, Gear, GearKind, PairGeometry};
use gearmesh::table::Table;
use gearmesh::words::{fixed, rounded, significant};
use roxmltree::{Document, Node};

/// The template of modelDescription.xml, without what belongs to a pair.
pub(super) const TEMPLATE: &str = include_str!("../../../modelDescription.xml");
const LICENCE: &str = "This FMU is licensed under MIT (LICENSE-MIT) or Apache-2.0 (LICENSE-APACHE), as you like.\n\
     third-party.txt has the licences of the crates that its library links.\n";
/// Drawings of the frames (demo/frames.py): of an external pair, and of an internal one with gear 1 or gear 2 as the ring.
const FRAMES: &str = include_str!("../../../docs/frames.svg");
const FRAMES_OF_RINGS: [&str; 2] = [
    include_str!("../../../docs/frames-ring-gear1.svg"),
    include_str!("../../../docs/frames-ring-gear2.svg"),
];
const PICTURE: &[u8] = include_bytes!("../../../resources/documentation/model.png");
const MIT: &[u8] = include_bytes!("../../../LICENSE-MIT");
const APACHE: &[u8] = include_bytes!("../../../LICENSE-APACHE");
/// `make licenses` writes it.
const THIRD_PARTY: &[u8] = include_bytes!("../../../resources/documentation/third-party.txt");

/// Files that are the same in each FMU.
const CONSTANT: [(&str, &[u8]); 5] = [
    ("model.png", PICTURE),
    ("documentation/licenses/license.txt", LICENCE.as_bytes()),
    ("documentation/licenses/LICENSE-MIT", MIT),
    ("documentation/licenses/LICENSE-APACHE", APACHE),
    ("documentation/licenses/third-party.txt", THIRD_PARTY),
];

/// What there is to describe; the template is that of the page.
#[derive(Template)]
#[template(path = "fmu.html", escape = "none")]
pub(super) struct Description<'a> {
    pub unit: &'a UnitFile,
    pub table: Option<&'a Table>,
    pub dynamics: &'a MeshDynamics,
    /// By [`super::step_error`].
    pub step_error: Option<super::StepError>,
    /// Input signals as CSV.
    pub example: Option<String>,
}

impl Description<'_> {
    /// Files of the archive by their names.
    pub fn files(self) -> Vec<(String, Vec<u8>)> {
        let mut files = vec![("modelDescription.xml".into(), self.xml().into_bytes())];
        files.extend(CONSTANT.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())));
        // Text and numbers alone: nothing in the template fails.
        let page = self.render().expect("the page is written") + "\n";
        files.push(("documentation/index.html".into(), page.into_bytes()));
        let example = self.example.map(String::into_bytes);
        files.extend(example.map(|bytes| ("documentation/example-input.csv".into(), bytes)));
        files
    }

    /// One sentence about the FMU, for XML.
    fn summary(&self) -> String {
        let [z1, z2] = self.unit.geometry.gears.each_ref().map(|gear| gear.teeth);
        let is_internal = self.unit.geometry.ring().is_some();
        let kind = if is_internal { "internal" } else { "external" };
        let stiffness = match self.table {
            Some(_) => "tables of static tooth contact",
            None => "constant stiffness",
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
            let name = node.attribute("name");
            let start = name.and_then(|name| self.unit.starts.get(name));
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
        let edits = edits.into_iter().filter_map(|(node, attribute, text)| {
            Some((node.attribute_node(attribute)?.range_value(), text))
        });
        let mut edits: Vec<_> = edits.collect();
        edits.sort_by_key(|(range, _)| range.start);
        let (mut out, mut done) = (String::new(), 0);
        for (range, text) in edits {
            out += &TEMPLATE[done..range.start];
            out += &text;
            done = range.end;
        }
        out + &TEMPLATE[done..]
    }

    /// Nominal torque on gear 1, N m.
    fn torque(&self) -> f64 {
        self.unit.start(&VARIABLES[index::NOMINAL_TORQUE])
    }
}

/// The diameter at which `gear` is held, mm, and whether it is the one that is assumed where a pair file gives none.
fn held(gear: &Gear) -> String {
    let assumed = (gear.held_radius / default_held_radius(gear) - 1.0).abs() < 1e-9;
    let rule = match gear.kind {
        GearKind::External => "half of the root diameter",
        GearKind::Ring => "the root diameter and 7 modules",
    };
    let note = match assumed && gear.body.is_none() {
        true => format!("; {rule}, as assumed where the pair file gives none"),
        false => String::new(),
    };
    format!("{}{note}", significant(2e3 * gear.held_radius, 5))
}

/// The drawing of the frames of a pair, without its XML declaration.
fn frames(geometry: &PairGeometry) -> &'static str {
    let drawing = geometry.ring().map_or(FRAMES, |ring| FRAMES_OF_RINGS[ring]);
    &drawing[drawing.find("<svg").unwrap_or(0)..]
}

/// Text inside an XML attribute or element.
fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
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

/// Left, top, width and height of the diagram's frame in the template, pixels.
const FRAME: [f64; 4] = [60.0, 15.0, 560.0, 150.0];

/// Static transmission error on the line of action over one base pitch, um: drive flank, aligned, nominal centre distance.
#[derive(Debug, PartialEq)]
struct Ste {
    /// On gear 1, N m.
    torque: f64,
    least: f64,
    largest: f64,
    mean: f64,
    /// Corners of the curve in the diagram.
    points: String,
}

impl Ste {
    /// At `torque` (on gear 1, N m), or at the largest of the tables.
    fn new(table: &Table, torque: f64) -> Ste {
        let torque = torque.min(table.file.maximum_torque_nm);
        let force = torque / table.file.geometry.gears[0].base_radius();
        let (drive, _) = table.flank(Flank::Drive);
        let positions = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
        let values = positions.map(|p| 1e6 * drive.approach_at(force, &nominal_pose(p)));
        let values: Vec<f64> = values.collect();
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
        Ste {
            torque,
            least,
            largest,
            mean: values[1..].iter().sum::<f64>() / POINTS as f64,
            points,
        }
    }
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
        let grid = file.drive.on(&file.axes);
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
    fn the_page_says_which_diameters_are_assumed() {
        let external = crate::samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        let assumed = |radius: f64| {
            let gear = Gear {
                held_radius: radius,
                ..external.clone()
            };
            held(&gear).contains("assumed")
        };
        assert!(assumed(0.5 * external.root_radius()));
        assert!(!assumed(0.51 * external.root_radius()));
        let ring = crate::samples::gear(GearKind::Ring, 60, 1.0, 0.0, 0.0);
        let root = ring.root_radius();
        let usual = Gear {
            held_radius: root + 3.5 * ring.normal_module,
            ..ring
        };
        assert!(held(&usual).contains("7 modules"));
    }

    #[test]
    fn an_internal_pair_is_drawn_with_its_own_gear_as_the_ring() {
        let external = shipped_tables("fzg-c").geometry;
        assert!(!frames(&external).contains("the ring"));
        let mut internal = shipped_tables("planet-ring-27-84").geometry;
        for ring in ["gear2, the ring", "gear1, the ring"] {
            let drawing = frames(&internal);
            assert!(drawing.starts_with("<svg") && drawing.contains(ring));
            internal.gears.swap(0, 1);
        }
    }

    #[test]
    fn the_curve_is_drawn_with_the_variation_that_the_tables_hold() {
        for name in ["fzg-c", "palermo2013"] {
            let file = shipped_tables(name);
            let torque = 0.8 * file.nominal_torque_nm;
            let table = Table::from_file(file.clone()).unwrap();
            let ste = Ste::new(&table, torque);
            let ratio = (ste.largest - ste.least) / of_samples(&file, torque);
            assert!((ratio - 1.0).abs() < 0.05, "{name}: {ratio}");
            // Beyond the tables: at their largest torque.
            let end = Ste::new(&table, 1e9);
            assert_eq!(end, Ste::new(&table, file.maximum_torque_nm));
        }
    }
}
