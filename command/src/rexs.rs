//! Cylindrical stages of REXS files, the exchange format of gearbox data (rexs.info, versions 1.4 and later), as pair files.

use std::cell::Cell;
use std::path::Path;

use gearmesh::words::rounded;
use gearmesh_preprocessor::pair::{self, PairError};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};

use crate::error::Result;
use crate::output;

/// Fields of a gear, the components that may have them, and the attributes that give them, the first one first. The
/// addendum of a tool cuts the dedendum of the gear.
const GEAR: &str = "
    face_width_mm                 gear      face_width
    profile_shift_iso_21771       gear      profile_shift_coefficient addendum_modification_coefficient
    tip_diameter_mm               gear      tip_diameter
    tip_form_diameter_mm          gear      tip_form_diameter
    root_diameter_mm              gear      root_diameter
    dedendum_coefficient          tool      addendum_coefficient_reference_profile
    tool_tip_radius_coefficient   tool      tip_radius_factor
    youngs_modulus_gpa            material  elastic_modulus
    poisson_ratio                 material  poisson_ratio
    bore_diameter_mm              bored     inner_diameter";

/// Measures of the tooth thickness with their gauges, and the attributes that give them; one measure is enough.
const MEASURES: &str = "
    span_measurement_mm      span_measurement  span_teeth        number_of_teeth_for_span_measurement
    dimension_over_balls_mm  size_over_balls   ball_diameter_mm  diameter_of_measuring_ball_or_pin";

/// Defaults that stand for fields a gear does not have.
const DEFAULTS: [(&str, &str); 3] = [
    ("dedendum_coefficient", "1.25"),
    ("tool_tip_radius_coefficient", "0.38"),
    ("youngs_modulus_gpa", "206"),
];

/// Fields that are left out where the pair does not fit them, measures with their gauges.
const OPTIONAL: &str = "tip_form_diameter_mm root_diameter_mm span_measurement_mm,span_teeth \
                        dimension_over_balls_mm,ball_diameter_mm normal_tooth_thickness_mm bore_diameter_mm";

type Fields = Map<String, Value>;

#[derive(Default, Deserialize)]
#[serde(default)]
struct Attribute {
    id: String,
    unit: String,
    #[serde(deserialize_with = "word", alias = "floating_point")]
    #[serde(alias = "integer", alias = "enum", alias = "string", alias = "boolean")]
    value: String,
    /// Whether the pair file has it.
    #[serde(skip)]
    is_taken: Cell<bool>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Component {
    #[serde(deserialize_with = "word")]
    id: String,
    #[serde(rename = "type")]
    kind: String,
    #[serde(deserialize_with = "word")]
    name: String,
    attributes: Vec<Attribute>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Ref {
    role: String,
    #[serde(deserialize_with = "word")]
    id: String,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Relation {
    #[serde(rename = "type")]
    kind: String,
    refs: Vec<Ref>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Model {
    version: String,
    components: Vec<Component>,
    relations: Vec<Relation>,
}

fn word<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    Ok(match Value::deserialize(from)? {
        Value::String(word) => word,
        Value::Null => String::new(),
        other => other.to_string(),
    })
}

/// The pair file of a stage, and what is to be known of it.
pub struct Taken {
    pub text: String,
    pub summary: String,
}

/// The cylindrical stage `stage` (the only one, where none is named) of the file `path`, at `torque` N m on gear 1.
pub fn pair_file(path: &Path, stage: Option<u64>, torque: Option<f64>) -> Result<Taken> {
    let text = output::read_text(path)?;
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let name = path.file_stem().unwrap_or("rexs".as_ref());
    let taken = || -> Result<Taken> {
        let model = &Model::read(text)?;
        let (stage, gears) = model.stage(stage)?;
        let draft = Draft {
            model,
            gears,
            notes: Vec::new(),
        };
        draft.fill(stage, torque, &name.to_string_lossy())
    };
    taken().map_err(|error| format!("{}: {error}", path.display()).into())
}

/// An element of XML in the JSON form: its attributes, its text as `value`, and its children in lists, down to `depth` levels.
fn element(node: roxmltree::Node, depth: usize) -> Fields {
    let attributes = node.attributes();
    let attributes = attributes.map(|a| (a.name().to_owned(), a.value().into()));
    let mut fields: Map<_, _> = attributes.collect();
    fields.insert(
        "value".into(),
        node.text().unwrap_or_default().trim().into(),
    );
    for child in node.children().filter(|c| depth > 0 && c.is_element()) {
        let list = fields.entry(format!("{}s", child.tag_name().name()));
        if let Value::Array(list) = list.or_insert_with(|| json!([])) {
            list.push(element(child, depth - 1).into());
        }
    }
    fields
}

impl Component {
    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.id == name)
    }
}

impl Relation {
    fn role(&self, role: &str) -> Option<&str> {
        let found = self.refs.iter().find(|r| r.role == role)?;
        Some(&found.id)
    }

    fn names(&self, id: &str) -> bool {
        self.refs.iter().any(|r| r.id == id)
    }
}

impl Model {
    /// The model in the `text` of a file, XML or JSON.
    fn read(text: &str) -> Result<Model> {
        let wrong = |error: serde_json::Error| format!("no REXS file: {error}");
        if text.starts_with('{') {
            let mut file: Value = serde_json::from_str(text).map_err(wrong)?;
            if !file["model"].is_object() {
                refuse!("it has no `model`, as REXS files in JSON have");
            }
            return Ok(serde_json::from_value(file["model"].take()).map_err(wrong)?);
        }
        let remedy = "give the .rexs (XML) or .rexsj (JSON) file";
        let document = roxmltree::Document::parse(text);
        let document = document.map_err(|e| format!("no REXS file: {e}; {remedy}"))?;
        let root = document.root_element();
        let tag = root.tag_name().name();
        if tag != "model" {
            refuse!("its root is <{tag}>, that of a REXS file is <model>");
        }
        let mut model = element(root, 0);
        // Load spectra and accumulations list components again, with results.
        for part in ["relations", "components"] {
            let parts = root.children().filter(|c| c.has_tag_name(part));
            model.extend(parts.flat_map(|part| element(part, 2)));
        }
        Ok(serde_json::from_value(model.into()).map_err(wrong)?)
    }

    fn component(&self, id: &str) -> Option<&Component> {
        self.components.iter().find(|c| c.id == id)
    }

    /// Components that stand in a relation with `id`, of a kind of which `is_kind` holds.
    fn related(&self, id: &str, is_kind: impl Fn(&str) -> bool) -> Vec<&Component> {
        let relations = self.relations.iter().filter(|r| r.names(id));
        let others = relations.flat_map(|r| &r.refs).filter(|r| r.id != id);
        let mut found: Vec<&Component> = Vec::new();
        for component in others.filter_map(|r| self.component(&r.id)) {
            if is_kind(&component.kind) && found.iter().all(|c| c.id != component.id) {
                found.push(component);
            }
        }
        found
    }

    /// The stage `id`, the only one where none is named, and its gears.
    fn stage(&self, id: Option<u64>) -> Result<(&Component, [&Component; 2])> {
        let all = self.components.iter();
        let stages: Vec<_> = all.filter(|c| c.kind == "cylindrical_stage").collect();
        let listed = stages.iter().map(|s| format!("{} ({})", s.id, s.name));
        let (listed, count) = (listed.collect::<Vec<_>>().join(", "), stages.len());
        let id = id.map(|id| id.to_string());
        let is_named = |s: &&&Component| id.as_ref().is_none_or(|id| s.id == *id);
        let stage = match (&id, stages.iter().find(is_named)) {
            (None, None) => refuse!("it has no cylindrical_stage"),
            (None, _) if count > 1 => {
                refuse!("it has {count} cylindrical stages: {listed}; name one by --stage")
            }
            (Some(id), None) => {
                refuse!("--stage = {id}: there is no such cylindrical stage; there are {listed}")
            }
            (_, Some(stage)) => *stage,
        };
        let is_stage = |r: &&Relation| r.kind == "stage" && r.role("stage") == Some(&stage.id);
        let relation = self.relations.iter().find(is_stage);
        let gear = |role| self.component(relation?.role(role)?);
        let [Some(gear1), Some(gear2)] = ["gear_1", "gear_2"].map(gear) else {
            let id = &stage.id;
            refuse!("stage {id} has no relation `stage` with gear_1 and gear_2");
        };
        Ok((stage, [gear1, gear2]))
    }
}

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

fn um(mm: f64) -> f64 {
    rounded(1e3 * mm)
}

/// A pair file in the making, with the account of where its fields come from.
struct Draft<'a> {
    model: &'a Model,
    gears: [&'a Component; 2],
    /// Each once, after one of [`HEADS`].
    notes: Vec<(&'static str, String)>,
}

const HEADS: [&str; 3] = ["taken", "assumed", "left"];

/// Adds a line to the account, once if both flanks have it.
macro_rules! note {
    ($draft:ident, $head:literal: $($words:tt)*) => {{
        let note = ($head, format!($($words)*));
        if !$draft.notes.contains(&note) {
            $draft.notes.push(note);
        }
    }};
}

impl<'a> Draft<'a> {
    /// The first of the attributes `names` that one of `components` has, a number in mm, degrees, GPa or none; it is noted
    /// as taken unless `field` is empty.
    fn number(
        &mut self,
        field: &str,
        components: &[&Component],
        names: &[&str],
    ) -> Result<Option<f64>> {
        let all = names.iter().flat_map(|name| {
            let given = components.iter().map(|c| (c, c.attribute(name)));
            given.filter_map(|(c, a)| Some((c, a.filter(|a| !a.value.is_empty())?)))
        });
        let Some((Component { id, kind, .. }, a)) = all.into_iter().next() else {
            return Ok(None);
        };
        let (name, unit, value) = (&a.id, &a.unit, &a.value);
        let attribute = format!("attribute `{name}` of component {id}");
        let Some(scale) = scale(unit) else {
            refuse!("{attribute}: unit `{unit}` is none of mm, mum, m, °, rad, MPa, N / mm^2");
        };
        let Ok(number) = value.parse::<f64>() else {
            refuse!("{attribute} = {value}: no number");
        };
        if !field.is_empty() {
            note!(self, "taken": "{field} from {name} of {kind} {id}");
        }
        a.is_taken.set(true);
        Ok(Some(rounded(number * scale)))
    }

    fn required(&mut self, field: &str, of: &[&Component], name: &str) -> Result<f64> {
        let ids: Vec<&str> = of.iter().map(|c| &*c.id).collect();
        let missing = format!("none of the components {} has `{name}`", ids.join(", "));
        Ok(self.number(field, of, &[name])?.ok_or(missing)?)
    }

    fn fill(mut self, stage: &'a Component, torque: Option<f64>, name: &str) -> Result<Taken> {
        let (model, gears) = (self.model, self.gears);
        let is_flank = |kind: &str| ["cylindrical_gear_flank", "flank_geometry"].contains(&kind);
        let flanks = gears.map(|g| model.related(&g.id, is_flank));
        let mut parts = vec![stage, gears[0], gears[1]];
        parts.extend(flanks.iter().flatten());
        let module = self.required("normal_module_mm", &parts, "normal_module")?;
        let angle = "normal_pressure_angle";
        let alpha = self.required("normal_pressure_angle_deg", &parts, angle)?;
        let angle = "helix_angle_reference_diameter";
        let helix = self.number("helix_angle_deg (> 0: right-handed)", &gears[..1], &[angle])?;
        let distance = self.number("center_distance_mm", &[stage], &["center_distance"])?;
        let gear1 = self.gear(0, &flanks[0], [module, alpha])?;
        let gear2 = self.gear(1, &flanks[1], [module, alpha])?;
        let width = |gear: &Fields| gear.get("face_width_mm")?.as_f64();
        let [b1, b2] = [&gear1, &gear2].map(|gear| width(gear).unwrap_or(0.0));
        let z1 = gear1["teeth"].as_f64().unwrap_or(0.0);
        // A hundred newtons for each mm of face and of module.
        let usual = rounded((0.05 * b1.min(b2) * module * module * z1).ceil());
        if torque.is_none() {
            note!(self, "assumed": "operating.nominal_torque_nm = {usual}: 100 N per mm of face and of module; give --torque-nm");
        }
        let nominal = torque.unwrap_or(usual);
        note!(self, "assumed": "operating: torques up to 1.5 times the nominal one, ranges of centre distance and misalignment");
        note!(self, "assumed": "face_offset_mm: both faces share their middle");
        let is_internal = gears.iter().any(|g| g.kind == "ring_gear");
        let mut file = json!({
            "name": name,
            "source": format!("REXS {}, stage {} {}", model.version, stage.id, stage.name),
            "meshing": if is_internal { "internal" } else { "external" },
            "normal_module_mm": module,
            "normal_pressure_angle_deg": alpha,
            "helix_angle_deg": helix.unwrap_or(0.0),
            "face_offset_mm": rounded(0.5 * (b1 - b2)),
            "gear1": gear1,
            "gear2": gear2,
            "operating": {
                "nominal_torque_nm": nominal, "maximum_torque_nm": rounded(1.5 * nominal),
                "center_distance_offset_um": [-20.0, 50.0], "misalignment_mrad": [-1.0, 1.0],
            },
        });
        if let Some(mm) = distance {
            file["center_distance_mm"] = json!(mm.abs());
        }
        let file = self.consistent(file)?;
        for gear in gears {
            parts.extend(model.related(&gear.id, |kind| kind == "material"));
        }
        for c in parts {
            let left = c.attributes.iter().filter(|a| !a.is_taken.get());
            let left = left.map(|a| &*a.id).collect::<Vec<_>>().join(", ");
            if !left.is_empty() {
                note!(self, "left": "{} {}: {left}", c.kind, c.id);
            }
        }
        let of_head = |head| self.notes.iter().filter(move |note| note.0 == head);
        let lines = HEADS.into_iter().flat_map(of_head);
        let lines = lines.map(|(head, line)| format!("{head}: {line}\n"));
        let lines: Vec<String> = lines.collect();
        let comments: String = lines.iter().map(|line| format!("// {line}")).collect();
        Ok(Taken {
            text: format!("{comments}{file:#}\n"),
            summary: lines.concat(),
        })
    }

    /// Fields of gear `i` with these `flanks`, of the normal module (mm) and pressure angle (degrees) of the pair.
    fn gear(&mut self, i: usize, flanks: &[&'a Component], pair: [f64; 2]) -> Result<Fields> {
        let (model, gear, name) = (self.model, self.gears[i], ["gear1", "gear2"][i]);
        let both: Vec<&Component> = [gear].into_iter().chain(flanks.iter().copied()).collect();
        let near = |kind: &str| -> Vec<&Component> {
            let near = both.iter().map(|c| model.related(&c.id, |k| k == kind));
            near.flatten().collect()
        };
        let mut fields = Map::new();
        let teeth = self.required(&format!("{name}.teeth"), &both, "number_of_teeth")?;
        fields.insert("teeth".into(), json!(teeth.abs().round() as u64));
        for row in GEAR.lines() {
            let row: Vec<&str> = row.split_whitespace().collect();
            let [field, source, names @ ..] = &row[..] else {
                continue;
            };
            let components = match *source {
                "tool" => near("rack_shaped_tool"),
                "material" => near("material"),
                "bored" if gear.kind != "cylindrical_gear" => continue,
                _ => both.clone(),
            };
            if let Some(value) = self.number(&format!("{name}.{field}"), &components, names)? {
                // Diameters of a ring may be negative.
                let is_length = field.ends_with("_mm") && *source != "bored";
                let value = if is_length { value.abs() } else { value };
                if *source != "bored" || value > 0.0 {
                    fields.insert((*field).into(), json!(value));
                }
            }
        }
        let mut measured = None;
        for row in MEASURES.lines().skip(1) {
            let row: Vec<&str> = row.split_whitespace().collect();
            let [value, size] = [1, 3].map(|i| self.number("", &both, &row[i..=i]));
            if let (None, Some(value), Some(size)) = (&measured, value?, size?) {
                let size = match row[2] {
                    "span_teeth" => json!(size.abs() as u64),
                    _ => json!(size),
                };
                fields.extend([(row[0].into(), json!(value.abs())), (row[2].into(), size)]);
                measured = Some(format!("{name}.{}, {}", row[0], row[2]));
            }
        }
        let settings = near("cylindrical_gear_manufacturing_settings");
        let attribute = "generated_addendum_modification_coefficient";
        match (measured, self.number("", &settings, &[attribute])?) {
            (Some(measured), _) => note!(self, "taken": "{measured}"),
            (None, Some(x)) => {
                let [module, alpha] = [pair[0], pair[1].to_radians()];
                let s = module * (std::f64::consts::FRAC_PI_2 + 2.0 * x * alpha.tan());
                let field = "normal_tooth_thickness_mm";
                fields.insert(field.into(), json!(rounded(s)));
                note!(self, "taken": "{name}.{field} from {attribute}");
            }
            (None, None) => {
                note!(self, "assumed": "{name}: teeth of the thickness that profile shift and centre distance leave")
            }
        }
        for (field, default) in DEFAULTS {
            let has = |field| fields.contains_key(field);
            let follows = field == "dedendum_coefficient" && has("root_diameter_mm");
            if !has(field) && !follows {
                note!(self, "assumed": "{name}.{field} = {default}");
            }
        }
        let left = self.flank(i, "left")?;
        let right = self.flank(i, "right")?;
        if left == right {
            fields.extend(left);
        } else {
            note!(self, "assumed": "{name}: the left flank is the drive flank; turn the two if the stage is driven the other way");
            fields.insert("drive_flank".into(), left.into());
            fields.insert("coast_flank".into(), right.into());
        }
        Ok(fields)
    }

    /// Modifications of the flank of gear `i` on this `side` in fields of the pair file.
    fn flank(&mut self, i: usize, side: &str) -> Result<Fields> {
        let (model, gear, name) = (self.model, self.gears[i], ["gear1", "gear2"][i]);
        let mut fields = Map::new();
        let of_gear = |r: &&Relation| r.kind == "flank" && r.names(&gear.id);
        let mut flanks = model.relations.iter().filter(of_gear);
        let Some(flank) = flanks.find_map(|r| model.component(r.role(side)?)) else {
            return Ok(fields);
        };
        for c in model.related(&flank.id, |_| true) {
            let Component { id, kind, .. } = c;
            let left = format!("{kind} {id} of the flank {}", flank.id);
            let words = ["relief", "modification", "deviation", "profile_twist"];
            if let Some((field, value)) = self.modification(&format!("{name}.{kind}"), c)? {
                fields.insert(field.into(), value);
                note!(self, "taken": "{name}.{field} from {kind} {id}");
            } else if ["profile_slope", "helix_slope"].contains(&&**kind) {
                // Its sign depends on which face and flank it counts from.
                note!(self, "left": "{left}: enter it with the sign of docs/pair-file.md");
            } else if words.iter().any(|word| kind.contains(word)) {
                note!(self, "left": "{left}");
            }
        }
        Ok(fields)
    }

    /// Field and value of the modification `c`; none of another kind, and where its amount is not given.
    fn modification(&mut self, path: &str, c: &'a Component) -> Result<Option<(&'a str, Value)>> {
        let kind = &*c.kind;
        let mut mm = |name: &str| self.number("", &[c], &[name]);
        let (field, depth, mut value, assumed) = match kind {
            "profile_crowning" | "helix_crowning" => {
                let (field, ends) = match kind {
                    "profile_crowning" => ("profile_crowning_um", ["at_root", "at_tip"]),
                    _ => (
                        "lead_crowning_um",
                        ["amount_datum_face", "amount_non_datum_face"],
                    ),
                };
                let [a, b] = ends.map(|end| mm(&format!("{kind}_{end}")));
                let [a, b] = [a?, b?].map(|mm| um(mm.unwrap_or(0.0)));
                if a != b {
                    note!(self, "assumed": "{path}: the mean of {a} and {b} um at its two ends");
                }
                return Ok(Some((field, json!(rounded(0.5 * (a + b))))));
            }
            "tip_relief" | "root_relief" => {
                let diameter = mm(&format!("{kind}_datum_diameter"))?;
                let length = mm(&format!("{kind}_datum_length"))?.filter(|_| kind == "tip_relief");
                let start = match (diameter, length) {
                    (Some(d), _) => json!({ "diameter_mm": d.abs() }),
                    (None, Some(length)) => json!({ "from_tip_mm": length }),
                    (None, None) => json!("pitch_point"),
                };
                let assumed = start.is_string().then_some("starts at the pitch point");
                let depth = mm(&format!("{kind}_depth"))?;
                (kind, depth, json!({ "start": start }), assumed)
            }
            "end_relief_datum_face" | "end_relief_non_datum_face" => {
                let side = &kind["end_relief_".len()..];
                let field = match side {
                    "datum_face" => "lower_end_relief",
                    _ => "upper_end_relief",
                };
                let length = mm(&format!("end_relief_length_{side}"))?;
                let depth = mm(&format!("end_relief_depth_{side}"))?.filter(|_| length.is_some());
                let assumed = Some("the datum face is that at z = 0");
                (field, depth, json!({ "length_mm": length }), assumed)
            }
            _ => return Ok(None),
        };
        let Some(depth) = depth else { return Ok(None) };
        if let Some(assumed) = assumed {
            note!(self, "assumed": "{path}: {assumed}");
        }
        let shape = c.attribute("shape_of_relief").map(|a| &*a.value);
        value["amount_um"] = json!(um(depth));
        value["shape"] = match shape.unwrap_or("none") {
            shape @ ("linear" | "parabolic") => shape,
            "circular" => "arc",
            other => {
                note!(self, "assumed": "{path}.shape = linear ({other} in the file)");
                "linear"
            }
        }
        .into();
        Ok(Some((field, value)))
    }

    /// The file without those of the optional fields that the pair does not fit, each with its reason.
    fn consistent(&mut self, mut file: Value) -> Result<Value> {
        loop {
            let refusal = match pair::from_json(&file.to_string()) {
                Ok(_) => return Ok(file),
                Err(PairError::Refused(refusal)) => refusal,
                Err(other) => return Err(other.into()),
            };
            let field = &refusal.field;
            let (gear, name) = field.split_once('.').unwrap_or(("", field));
            let mut optional = OPTIONAL.split(' ').map(|fields| fields.split(','));
            let own = optional.find(|own| own.clone().next() == Some(name));
            let fields = file.get_mut(gear).and_then(Value::as_object_mut);
            let (Some(own), Some(fields)) = (own, fields.filter(|f| f.contains_key(name))) else {
                return Err(refusal.into());
            };
            fields.retain(|name, _| !own.clone().any(|own| own == name));
            let is_gone = |note: &(&str, String)| note.0 == "taken" && note.1.starts_with(field);
            self.notes.retain(|note| !is_gone(note));
            note!(self, "left": "{field} = {}: {}", refusal.value, refusal.problem);
        }
    }
}
