//! Cylindrical stages of REXS files, the exchange format of gearbox data (rexs.info, versions 1.4 and later), as pair files.

use std::path::Path;

use gearmesh::words::rounded;
use gearmesh_preprocessor::pair::{self, PairError};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};

use crate::Error;

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

/// Fields that are left out where the pair does not fit them.
const OPTIONAL: &str = "tip_form_diameter_mm root_diameter_mm span_measurement_mm dimension_over_balls_mm \
                        normal_tooth_thickness_mm bore_diameter_mm";

#[derive(Default, Deserialize)]
#[serde(default)]
struct Attribute {
    id: String,
    unit: String,
    #[serde(deserialize_with = "word", alias = "floating_point")]
    #[serde(alias = "integer", alias = "enum", alias = "string", alias = "boolean")]
    value: String,
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
pub fn pair_file(path: &Path, stage: Option<u64>, torque: Option<f64>) -> Result<Taken, Error> {
    let text = crate::output::read_text(path)?;
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let name = path.file_stem().unwrap_or("rexs".as_ref());
    let taken = || -> Result<Taken, Error> {
        let model = &match text.starts_with('{') {
            true => Model::of_json(text),
            false => Model::of_xml(text),
        }?;
        let (stage, gears) = model.stage(stage)?;
        let (notes, used) = (Vec::new(), Vec::new());
        let draft = Draft { model, notes, used };
        draft.fill(stage, gears, torque, &name.to_string_lossy())
    };
    taken().map_err(|error| format!("{}: {error}", path.display()).into())
}

/// An element of XML in the JSON form: its attributes, its text as `value`, and its children in lists, down to `depth` levels.
fn element(node: roxmltree::Node, depth: usize) -> Map<String, Value> {
    let attributes = node.attributes();
    let mut fields: Map<_, _> = attributes
        .map(|a| (a.name().to_owned(), a.value().into()))
        .collect();
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
    fn of_json(text: &str) -> Result<Model, Error> {
        let wrong = |error| format!("no REXS file: {error}");
        let mut file: Value = serde_json::from_str(text).map_err(wrong)?;
        if !file["model"].is_object() {
            return Err("it has no `model`, as REXS files in JSON have".into());
        }
        Ok(serde_json::from_value(file["model"].take()).map_err(wrong)?)
    }

    fn of_xml(text: &str) -> Result<Model, Error> {
        let document = roxmltree::Document::parse(text).map_err(|e| {
            format!("no REXS file: {e}; give the .rexs (XML) or .rexsj (JSON) file")
        })?;
        let root = document.root_element();
        let tag = root.tag_name().name();
        if tag != "model" {
            return Err(format!("its root is <{tag}>, that of a REXS file is <model>").into());
        }
        let mut model = element(root, 0);
        // Load spectra and accumulations list components again, with results.
        for part in ["relations", "components"] {
            let parts = root.children().filter(|c| c.has_tag_name(part));
            model.extend(parts.flat_map(|part| element(part, 2)));
        }
        Ok(serde_json::from_value(model.into())
            .map_err(|error| format!("no REXS file: {error}"))?)
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
    fn stage(&self, id: Option<u64>) -> Result<(&Component, [&Component; 2]), Error> {
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

/// The account of where the fields of a pair file come from.
struct Draft<'a> {
    model: &'a Model,
    /// Each after one of [`HEADS`].
    notes: Vec<(&'static str, String)>,
    used: Vec<(String, String)>,
}

const HEADS: [&str; 3] = ["taken", "assumed", "left"];

impl<'a> Draft<'a> {
    fn note(&mut self, head: &'static str, line: impl Into<String>) {
        self.notes.push((head, line.into()));
    }

    /// The first of the attributes `names` that one of `components` has, a number in mm, degrees, GPa or none; it is noted
    /// as taken unless `field` is empty.
    fn number(
        &mut self,
        field: &str,
        components: &[&Component],
        names: &[&str],
    ) -> Result<Option<f64>, Error> {
        let given = |name| {
            let all = components.iter().map(|c| (c, c.attribute(name)));
            all.filter_map(|(c, a)| Some((c, a.filter(|a| !a.value.is_empty())?)))
                .next()
        };
        let Some((Component { id, kind, .. }, a)) = names.iter().find_map(|name| given(name))
        else {
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
            self.note("taken", format!("{field} from {name} of {kind} {id}"));
        }
        self.used.push((id.clone(), name.clone()));
        Ok(Some(rounded(number * scale)))
    }

    fn required(&mut self, field: &str, of: &[&Component], name: &str) -> Result<f64, Error> {
        let ids: Vec<&str> = of.iter().map(|c| &*c.id).collect();
        let missing = format!("none of the components {} has `{name}`", ids.join(", "));
        Ok(self.number(field, of, &[name])?.ok_or(missing)?)
    }

    fn fill(
        mut self,
        stage: &'a Component,
        gears: [&'a Component; 2],
        torque: Option<f64>,
        name: &str,
    ) -> Result<Taken, Error> {
        let model = self.model;
        let is_flank = |kind: &str| ["cylindrical_gear_flank", "flank_geometry"].contains(&kind);
        let flanks = gears.map(|g| model.related(&g.id, is_flank));
        let mut parts = vec![stage, gears[0], gears[1]];
        parts.extend(flanks.iter().flatten());
        let module = self.required("normal_module_mm", &parts, "normal_module")?;
        let angle = "normal_pressure_angle";
        let alpha = self.required("normal_pressure_angle_deg", &parts, angle)?;
        let (field, attribute) = (
            "helix_angle_deg (> 0: right-handed)",
            "helix_angle_reference_diameter",
        );
        let helix = self.number(field, &gears[..1], &[attribute])?;
        let distance = self.number("center_distance_mm", &[stage], &["center_distance"])?;
        let [gear1, gear2] = [0, 1].map(|i| {
            let name = ["gear1", "gear2"][i];
            self.gear(name, gears[i], &flanks[i], [module, alpha])
        });
        let (gear1, gear2) = (gear1?, gear2?);
        let width = |gear: &Map<String, Value>| gear.get("face_width_mm")?.as_f64();
        let [b1, b2] = [&gear1, &gear2].map(|gear| width(gear).unwrap_or(0.0));
        let z1 = gear1["teeth"].as_f64().unwrap_or(0.0);
        // A hundred newtons for each mm of face and of module.
        let usual = rounded((0.05 * b1.min(b2) * module * module * z1).ceil());
        if torque.is_none() {
            self.note("assumed", format!("operating.nominal_torque_nm = {usual}: 100 N per mm of face and of module; give --torque-nm"));
        }
        let nominal = torque.unwrap_or(usual);
        for line in [
            "operating: torques up to 1.5 times the nominal one, ranges of centre distance and misalignment",
            "face_offset_mm: both faces share their middle",
        ] {
            self.note("assumed", line);
        }
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
            let is_left = |name: &&str| !self.used.iter().any(|(id, n)| *id == c.id && n == name);
            let names = c.attributes.iter().map(|a| &*a.id).filter(is_left);
            let names = names.collect::<Vec<_>>().join(", ");
            if !names.is_empty() {
                self.note("left", format!("{} {}: {names}", c.kind, c.id));
            }
        }
        let mut lines: Vec<String> = Vec::new();
        for head in HEADS {
            let own = self.notes.iter().filter(|note| note.0 == head);
            for line in own.map(|(head, line)| format!("{head}: {line}\n")) {
                // Both flanks name the same.
                if !lines.contains(&line) {
                    lines.push(line);
                }
            }
        }
        let comments: String = lines.iter().map(|line| format!("// {line}")).collect();
        Ok(Taken {
            text: format!("{comments}{file:#}\n"),
            summary: lines.concat(),
        })
    }

    fn gear(
        &mut self,
        name: &str,
        gear: &'a Component,
        flanks: &[&'a Component],
        [module, alpha]: [f64; 2],
    ) -> Result<Map<String, Value>, Error> {
        let both: Vec<&Component> = [gear].into_iter().chain(flanks.iter().copied()).collect();
        let model = self.model;
        let near = |kind: &str| -> Vec<&Component> {
            let all = both.iter();
            all.flat_map(|c| model.related(&c.id, |k| k == kind))
                .collect()
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
            (Some(measured), _) => self.note("taken", measured),
            (None, Some(x)) => {
                let s = module * (std::f64::consts::FRAC_PI_2 + 2.0 * x * alpha.to_radians().tan());
                let field = "normal_tooth_thickness_mm";
                fields.insert(field.into(), json!(rounded(s)));
                self.note("taken", format!("{name}.{field} from {attribute}"));
            }
            (None, None) => self.note(
                "assumed",
                format!(
                    "{name}: teeth of the thickness that profile shift and centre distance leave"
                ),
            ),
        }
        for (field, default) in DEFAULTS {
            let has = |field| fields.contains_key(field);
            let follows = field == "dedendum_coefficient" && has("root_diameter_mm");
            if !has(field) && !follows {
                self.note("assumed", format!("{name}.{field} = {default}"));
            }
        }
        let [left, right] = ["left", "right"].map(|side| self.flank(name, gear, side));
        let (left, right) = (left?, right?);
        if left == right {
            fields.extend(left);
        } else {
            self.note("assumed", format!("{name}: the left flank is the drive flank; turn the two if the stage is driven the other way"));
            fields.insert("drive_flank".into(), left.into());
            fields.insert("coast_flank".into(), right.into());
        }
        Ok(fields)
    }

    /// Modifications of the flank of `gear` on this `side` in fields of the pair file.
    fn flank(
        &mut self,
        name: &str,
        gear: &Component,
        side: &str,
    ) -> Result<Map<String, Value>, Error> {
        let model = self.model;
        let mut fields = Map::new();
        let of_flank = |r: &&Relation| r.kind == "flank" && r.names(&gear.id);
        let mut flanks = model.relations.iter().filter(of_flank);
        let Some(flank) = flanks.find_map(|r| model.component(r.role(side)?)) else {
            return Ok(fields);
        };
        for c in model.related(&flank.id, |_| true) {
            let Component { id, kind, .. } = c;
            let left = format!("{kind} {id} of the flank {}", flank.id);
            let words = ["relief", "modification", "deviation", "profile_twist"];
            if let Some((field, value)) = self.modification(&format!("{name}.{kind}"), c)? {
                fields.insert(field.into(), value);
                self.note("taken", format!("{name}.{field} from {kind} {id}"));
            } else if ["profile_slope", "helix_slope"].contains(&&**kind) {
                // Its sign depends on which face and flank it counts from.
                let line = format!("{left}: enter it with the sign of docs/pair-file.md");
                self.note("left", line);
            } else if words.iter().any(|word| kind.contains(word)) {
                self.note("left", left);
            }
        }
        Ok(fields)
    }

    /// Field and value of the modification `c`; none of another kind, and where its amount is not given.
    fn modification(
        &mut self,
        path: &str,
        c: &'a Component,
    ) -> Result<Option<(&'a str, Value)>, Error> {
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
                    let line = format!("{path}: the mean of {a} and {b} um at its two ends");
                    self.note("assumed", line);
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
        let Some(depth) = depth else {
            return Ok(None);
        };
        if let Some(assumed) = assumed {
            self.note("assumed", format!("{path}: {assumed}"));
        }
        let shape = c.attribute("shape_of_relief").map(|a| &*a.value);
        value["amount_um"] = json!(um(depth));
        value["shape"] = match shape.unwrap_or("none") {
            shape @ ("linear" | "parabolic") => shape,
            "circular" => "arc",
            other => {
                let line = format!("{path}.shape = linear ({other} in the file)");
                self.note("assumed", line);
                "linear"
            }
        }
        .into();
        Ok(Some((field, value)))
    }

    /// The file without those of the optional fields that the pair does not fit, each with its reason.
    fn consistent(&mut self, mut file: Value) -> Result<Value, Error> {
        loop {
            let refusal = match pair::from_json(&file.to_string()) {
                Ok(_) => return Ok(file),
                Err(PairError::Refused(refusal)) => refusal,
                Err(other) => return Err(other.into()),
            };
            let field = &refusal.field;
            let (gear, name) = field.split_once('.').unwrap_or(("", field));
            let is_optional = OPTIONAL.split(' ').any(|field| field == name);
            let fields = file.get_mut(gear).and_then(Value::as_object_mut);
            let fields = fields.filter(|_| is_optional);
            if fields.and_then(|fields| fields.remove(name)).is_none() {
                return Err(refusal.into());
            }
            file[gear].as_object_mut().map(|fields| {
                fields.remove(match name {
                    "span_measurement_mm" => "span_teeth",
                    "dimension_over_balls_mm" => "ball_diameter_mm",
                    _ => "",
                })
            });
            self.notes
                .retain(|(head, line)| *head != "taken" || !line.starts_with(field));
            let problem = format!("{field} = {}: {}", refusal.value, refusal.problem);
            self.note("left", problem);
        }
    }
}
