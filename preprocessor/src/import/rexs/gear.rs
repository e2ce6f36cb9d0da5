//! Fields of a gear that attributes give as they are.

use gearmesh::words::rounded;
use serde_json::{Map, json};

use super::account::Head;
use super::draft::Draft;
use super::given::{Given, agreed, first};
use super::model::Result;
use super::teeth::{Basic, Fields, TOOLS};

/// Components that have a field of a gear.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// The gear and its flanks, which must agree.
    Gear,
    Tool,
    Material,
}

/// A field of a gear and the attributes that give it, older and newer names.
struct Source {
    field: &'static str,
    of: Of,
    attributes: &'static [&'static str],
    /// The same in mm, of which the field is the part of the module.
    lengths: &'static [&'static str],
    /// Stands for it where it is not given.
    default: Option<&'static str>,
}

const fn source(
    field: &'static str,
    of: Of,
    attributes: &'static [&'static str],
    default: Option<&'static str>,
) -> Source {
    Source {
        field,
        of,
        attributes,
        lengths: &[],
        default,
    }
}

/// The source of a tool's coefficient, which some files have in mm.
const fn of_tool(
    field: &'static str,
    attributes: &'static [&'static str],
    lengths: &'static [&'static str],
    default: Option<&'static str>,
) -> Source {
    Source {
        lengths,
        ..source(field, Of::Tool, attributes, default)
    }
}

/// The addendum of a tool cuts the dedendum of the gear.
const GEAR: [Source; 10] = [
    source("face_width_mm", Of::Gear, &["face_width"], None),
    source(
        "profile_shift_iso_21771",
        Of::Gear,
        &[
            "profile_shift_coefficient",
            "addendum_modification_coefficient",
        ],
        None,
    ),
    source("tip_diameter_mm", Of::Gear, &["tip_diameter"], None),
    source(
        "tip_form_diameter_mm",
        Of::Gear,
        &["tip_form_diameter"],
        None,
    ),
    source(
        "root_form_diameter_mm",
        Of::Gear,
        &["root_form_diameter"],
        None,
    ),
    source("root_diameter_mm", Of::Gear, &["root_diameter"], None),
    of_tool(
        "dedendum_coefficient",
        &["addendum_coefficient_reference_profile"],
        &["addendum_reference_profile"],
        Some("1.25"),
    ),
    // Names up to 1.7, and since 2.0.
    of_tool(
        "tool_tip_radius_coefficient",
        &[
            "tip_radius_factor",
            "tip_corner_radius_factor_reference_profile",
        ],
        &["tip_radius", "tip_corner_radius_reference_profile"],
        Some("0.38"),
    ),
    source(
        "youngs_modulus_gpa",
        Of::Material,
        &["elastic_modulus"],
        Some("206"),
    ),
    source(
        "poisson_ratio",
        Of::Material,
        &["poisson_ratio"],
        Some("0.3"),
    ),
];

impl Draft<'_> {
    /// Fields of gear `i` that attributes give as they are.
    pub(super) fn gear(&mut self, i: usize, basic: &Basic) -> Result<Fields> {
        let name = ["gear1", "gear2"][i];
        let mut fields = Map::new();
        fields.insert("teeth".into(), json!(basic.teeth[i].abs() as u64));
        let (tools, materials) = (self.beside(i, &TOOLS), self.beside(i, &["material"]));
        for Source {
            field,
            of,
            attributes,
            lengths,
            default,
        } in &GEAR
        {
            let path = format!("{name}.{field}");
            let given = match of {
                Of::Gear => agreed(&path, &self.teeth[i], attributes)?,
                Of::Tool => match first(&tools, attributes)? {
                    Some(given) => Some(given),
                    None => first(&tools, lengths)?.map(|given| Given {
                        value: rounded(given.value / basic.module),
                        origin: format!("{} = {} mm over the module", given.origin, given.value),
                    }),
                },
                Of::Material => first(&materials, attributes)?,
            };
            match (given, default) {
                (Some(given), _) => {
                    self.taken(&path, &given);
                    // Diameters of a ring may be negative.
                    let is_length = field.ends_with("_mm");
                    let value = if is_length {
                        given.value.abs()
                    } else {
                        given.value
                    };
                    fields.insert((*field).into(), json!(value));
                }
                (None, Some(default)) => self
                    .account
                    .add(Head::Assumed, format!("{path} = {default}")),
                (None, None) => {}
            }
        }
        if let Some(wheel) = tools.iter().find(|tool| tool.kind == TOOLS[1]) {
            let line = format!(
                "{name}: {} {} cuts as a rack would, to a dedendum of its addendum and with its tip radius",
                wheel.kind, wheel.id
            );
            self.account.add(Head::Assumed, line);
        }
        if !self.is_ring(i) {
            let bore = first(&[self.gears[i]], &["inner_diameter"])?;
            if let Some(bore) = bore.filter(|bore| bore.value > 0.0) {
                self.taken(&format!("{name}.bore_diameter_mm"), &bore);
                fields.insert("bore_diameter_mm".into(), json!(bore.value));
            }
        }
        Ok(fields)
    }
}
