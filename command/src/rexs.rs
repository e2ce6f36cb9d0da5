//! Cylindrical stages of REXS files, the exchange format of gearbox data (rexs.info, versions 1.4 and later), as pair files.

use std::fmt::Write;
use std::path::Path;

use gearmesh::words::rounded;
use gearmesh_preprocessor::pair::{self, PairError};
use serde_json::{Map, Value, json};

use crate::Error;

/// A number or word of a component, with its unit.
struct Attribute {
    name: String,
    unit: String,
    value: String,
}

struct Component {
    id: u64,
    kind: String,
    name: String,
    attributes: Vec<Attribute>,
}

/// Components and the roles in which relations name them.
#[derive(Default)]
struct Model {
    version: String,
    components: Vec<Component>,
    /// Kind, and role and component of each reference.
    relations: Vec<(String, Vec<(String, u64)>)>,
}

/// The pair file of a stage, and what is to be known of it.
pub struct Taken {
    pub text: String,
    pub summary: String,
}

/// The cylindrical stage `stage` (the only one, where none is named) of the file `path`, at `torque` N m on gear 1.
pub fn pair_file(path: &Path, stage: Option<u64>, torque: Option<f64>) -> Result<Taken, Error> {
    let text = crate::output::read_text(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let wrong = |what: String| format!("{}: {what}", path.display());
    let model = match text.trim_start().starts_with('{') {
        true => Model::of_json(text),
        false => Model::of_xml(text),
    }
    .map_err(wrong)?;
    let mut stem = path
        .file_stem()
        .map_or("rexs".into(), |stem| stem.to_string_lossy());
    let name = stem.to_mut();
    model
        .stage(stage, torque, name)
        .map_err(|error| wrong(error.to_string()).into())
}

impl Model {
    fn of_xml(text: &str) -> Result<Model, String> {
        let document = roxmltree::Document::parse(text).map_err(|e| {
            format!("no REXS file: {e}; give the .rexs (XML) or .rexsj (JSON) file")
        })?;
        let root = document.root_element();
        if root.tag_name().name() != "model" {
            return Err(format!(
                "its root is <{}>, that of a REXS file is <model>",
                root.tag_name().name()
            ));
        }
        let id = |node: &roxmltree::Node| {
            node.attribute("id")
                .and_then(|id| id.parse().ok())
                .unwrap_or(u64::MAX)
        };
        let word = |node: &roxmltree::Node, name: &str| {
            node.attribute(name).unwrap_or_default().to_owned()
        };
        let mut model = Model {
            version: word(&root, "version"),
            ..Model::default()
        };
        // Load spectra and accumulations list components again, with results.
        let children = |parent: &'static str, tag: &'static str| {
            let parents = root.children().filter(move |n| n.has_tag_name(parent));
            parents.flat_map(move |n| n.children().filter(move |c| c.has_tag_name(tag)))
        };
        for node in children("relations", "relation") {
            let refs = node.children().filter(|c| c.has_tag_name("ref"));
            model.relations.push((
                word(&node, "type"),
                refs.map(|r| (word(&r, "role"), id(&r))).collect(),
            ));
        }
        for node in children("components", "component") {
            let attributes = node.children().filter(|c| c.has_tag_name("attribute"));
            let attributes = attributes.map(|a| Attribute {
                name: word(&a, "id"),
                unit: word(&a, "unit"),
                value: a.text().unwrap_or_default().trim().to_owned(),
            });
            model.components.push(Component {
                id: id(&node),
                kind: word(&node, "type"),
                name: word(&node, "name"),
                attributes: attributes.collect(),
            });
        }
        Ok(model)
    }

    fn of_json(text: &str) -> Result<Model, String> {
        let root: Value = serde_json::from_str(text).map_err(|e| format!("no REXS file: {e}"))?;
        let root = &root["model"];
        if !root.is_object() {
            return Err("it has no `model`, as REXS files in JSON have".into());
        }
        let word = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        let id = |v: &Value| v["id"].as_u64().unwrap_or(u64::MAX);
        let list = |v: &Value| v.as_array().cloned().unwrap_or_default();
        let attribute = |a: &Value| Attribute {
            name: word(&a["id"]),
            unit: word(&a["unit"]),
            value: ["floating_point", "integer", "enum", "string", "boolean"]
                .iter()
                .map(|kind| &a[*kind])
                .find(|v| !v.is_null())
                .map_or(String::new(), |v| {
                    v.as_str().map_or_else(|| v.to_string(), str::to_owned)
                }),
        };
        let component = |c: &Value| Component {
            id: id(c),
            kind: word(&c["type"]),
            name: word(&c["name"]),
            attributes: list(&c["attributes"]).iter().map(attribute).collect(),
        };
        let relation = |r: &Value| {
            (
                word(&r["type"]),
                list(&r["refs"])
                    .iter()
                    .map(|r| (word(&r["role"]), id(r)))
                    .collect(),
            )
        };
        Ok(Model {
            version: word(&root["version"]),
            components: list(&root["components"]).iter().map(component).collect(),
            relations: list(&root["relations"]).iter().map(relation).collect(),
        })
    }

    fn component(&self, id: u64) -> Option<&Component> {
        self.components.iter().find(|c| c.id == id)
    }

    /// Components that stand in a relation with `id`, of a kind of which `is_kind` holds.
    fn related(&self, id: u64, is_kind: impl Fn(&str) -> bool) -> Vec<&Component> {
        let relations = self
            .relations
            .iter()
            .filter(|(_, refs)| refs.iter().any(|r| r.1 == id));
        let others = relations.flat_map(|(_, refs)| refs).filter(|r| r.1 != id);
        let mut found: Vec<&Component> = Vec::new();
        for component in others.filter_map(|(_, id)| self.component(*id)) {
            if is_kind(&component.kind) && found.iter().all(|c| c.id != component.id) {
                found.push(component);
            }
        }
        found
    }

    fn stage(&self, wanted: Option<u64>, torque: Option<f64>, name: &str) -> Result<Taken, Error> {
        let stages: Vec<&Component> = self
            .components
            .iter()
            .filter(|c| c.kind == "cylindrical_stage")
            .collect();
        let listed = || {
            let all: Vec<String> = stages
                .iter()
                .map(|s| format!("{} ({})", s.id, s.name))
                .collect();
            all.join(", ")
        };
        let stage = match (wanted, &stages[..]) {
            (_, []) => return Err("it has no cylindrical_stage".into()),
            (None, [only]) => only,
            (None, _) => {
                return Err(format!(
                    "it has {} cylindrical stages: {}; name one by --stage",
                    stages.len(),
                    listed()
                )
                .into());
            }
            (Some(id), _) => stages.iter().find(|s| s.id == id).ok_or_else(|| {
                format!(
                    "--stage = {id}: there is no such cylindrical stage; there are {}",
                    listed()
                )
            })?,
        };
        let is_stage = |(kind, refs): &&(String, Vec<(String, u64)>)| {
            kind == "stage"
                && refs
                    .iter()
                    .any(|(role, id)| role == "stage" && *id == stage.id)
        };
        let refs = self.relations.iter().find(is_stage).map(|(_, refs)| refs);
        let gear = |role: &str| {
            let id = refs?.iter().find(|(r, _)| r == role)?.1;
            self.component(id)
        };
        let [Some(gear1), Some(gear2)] = ["gear_1", "gear_2"].map(gear) else {
            return Err(format!(
                "stage {} has no relation `stage` with gear_1 and gear_2",
                stage.id
            )
            .into());
        };
        Draft::new(self, stage).fill([gear1, gear2], torque, name)
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

/// A pair file that grows, and the account of where its fields come from.
struct Draft<'a> {
    model: &'a Model,
    stage: &'a Component,
    taken: Vec<String>,
    assumed: Vec<String>,
    left: Vec<String>,
    used: Vec<(u64, String)>,
}

impl<'a> Draft<'a> {
    fn new(model: &'a Model, stage: &'a Component) -> Self {
        let all = || Vec::new();
        Draft {
            model,
            stage,
            taken: all(),
            assumed: all(),
            left: all(),
            used: Vec::new(),
        }
    }

    /// The first of `names` that one of `components` has as a number, in mm, degrees, GPa or none.
    fn number(
        &mut self,
        field: &str,
        components: &[&Component],
        names: &[&str],
    ) -> Result<Option<f64>, Error> {
        for name in names {
            for component in components {
                let Some(a) = component
                    .attributes
                    .iter()
                    .find(|a| a.name == *name && !a.value.is_empty())
                else {
                    continue;
                };
                let place = format!("attribute `{name}` of component {}", component.id);
                let scale = scale(&a.unit).ok_or_else(|| {
                    format!(
                        "{place}: unit `{}` is none of mm, mum, m, °, rad, MPa, N / mm^2",
                        a.unit
                    )
                })?;
                let value: f64 = a
                    .value
                    .parse()
                    .map_err(|_| format!("{place} = {}: no number", a.value))?;
                if !field.is_empty() {
                    self.taken.push(format!(
                        "{field} from {name} of {} {}",
                        component.kind, component.id
                    ));
                }
                self.used.push((component.id, a.name.clone()));
                return Ok(Some(rounded(value * scale)));
            }
        }
        Ok(None)
    }

    fn required(
        &mut self,
        field: &str,
        components: &[&Component],
        names: &[&str],
    ) -> Result<f64, Error> {
        let ids: Vec<String> = components.iter().map(|c| c.id.to_string()).collect();
        self.number(field, components, names)?.ok_or_else(|| {
            format!(
                "none of the components {} has `{}`",
                ids.join(", "),
                names.join("` or `")
            )
            .into()
        })
    }

    fn word(&mut self, component: &Component, name: &str) -> Option<String> {
        let a = component.attributes.iter().find(|a| a.name == name)?;
        self.used.push((component.id, a.name.clone()));
        Some(a.value.clone())
    }

    fn fill(
        mut self,
        gears: [&'a Component; 2],
        torque: Option<f64>,
        name: &str,
    ) -> Result<Taken, Error> {
        let ring = gears.iter().position(|g| g.kind == "ring_gear");
        let flanks = gears.map(|g| {
            self.model.related(g.id, |kind| {
                ["cylindrical_gear_flank", "flank_geometry"].contains(&kind)
            })
        });
        let everywhere: Vec<&Component> = [self.stage]
            .into_iter()
            .chain(gears)
            .chain(flanks.iter().flatten().copied())
            .collect();
        let module = self.required("normal_module_mm", &everywhere, &["normal_module"])?;
        let alpha = self.required(
            "normal_pressure_angle_deg",
            &everywhere,
            &["normal_pressure_angle"],
        )?;
        let helix = self.number(
            "helix_angle_deg (> 0: right-handed)",
            &gears[..1],
            &["helix_angle_reference_diameter"],
        )?;
        let distance = self.number("center_distance_mm", &[self.stage], &["center_distance"])?;
        let mut file = Map::new();
        let mut optional = Vec::new();
        for (i, gear) in gears.into_iter().enumerate() {
            let fields = self.gear(i, gear, &flanks[i], [module, alpha], &mut optional)?;
            file.insert(format!("gear{}", i + 1), Value::Object(fields));
        }
        let [b1, b2] = [1, 2].map(|i| {
            file[&format!("gear{i}")]["face_width_mm"]
                .as_f64()
                .unwrap_or(0.0)
        });
        let z1 = file["gear1"]["teeth"].as_f64().unwrap_or(0.0);
        // A hundred newtons for each mm of face and of module.
        let usual = rounded((0.05 * b1.min(b2) * module * module * z1).ceil());
        let nominal = torque.unwrap_or_else(|| {
            self.assumed.push(format!("operating.nominal_torque_nm = {usual}: 100 N per mm of face and of module; give --torque-nm"));
            usual
        });
        self.assumed.push("operating: torques up to 1.5 times the nominal one, ranges of centre distance and misalignment".into());
        self.assumed
            .push("face_offset_mm: both faces share their middle".into());
        file.extend([
            ("name".to_owned(), json!(name)),
            (
                "source".to_owned(),
                json!(format!(
                    "REXS {}, stage {} {}",
                    self.model.version, self.stage.id, self.stage.name
                )),
            ),
            (
                "meshing".to_owned(),
                json!(if ring.is_some() {
                    "internal"
                } else {
                    "external"
                }),
            ),
            ("normal_module_mm".to_owned(), json!(module)),
            ("normal_pressure_angle_deg".to_owned(), json!(alpha)),
            ("helix_angle_deg".to_owned(), json!(helix.unwrap_or(0.0))),
            ("face_offset_mm".to_owned(), json!(rounded(0.5 * (b1 - b2)))),
            (
                "operating".to_owned(),
                json!({
                    "nominal_torque_nm": nominal, "maximum_torque_nm": rounded(1.5 * nominal),
                    "center_distance_offset_um": [-20.0, 50.0], "misalignment_mrad": [-1.0, 1.0],
                }),
            ),
        ]);
        if let Some(mm) = distance {
            file.insert("center_distance_mm".into(), json!(mm.abs()));
        }
        let file = self.consistent(Value::Object(file), optional)?;
        let parts: Vec<&Component> = everywhere
            .into_iter()
            .chain(
                gears
                    .iter()
                    .flat_map(|g| self.model.related(g.id, |k| k == "material")),
            )
            .collect();
        for part in parts {
            let rest = part
                .attributes
                .iter()
                .filter(|a| !self.used.contains(&(part.id, a.name.clone())));
            let rest: Vec<&str> = rest.map(|a| a.name.as_str()).collect();
            if !rest.is_empty() {
                self.left
                    .push(format!("{} {}: {}", part.kind, part.id, rest.join(", ")));
            }
        }
        let mut summary = String::new();
        for (head, lines) in [
            ("taken", &self.taken),
            ("assumed", &self.assumed),
            ("left", &self.left),
        ] {
            for (k, line) in lines.iter().enumerate() {
                // Both flanks name the same.
                if lines[..k].contains(line) {
                    continue;
                }
                let _ = writeln!(summary, "{head}: {line}");
            }
        }
        let comments: String = summary.lines().map(|line| format!("// {line}\n")).collect();
        Ok(Taken {
            text: format!("{comments}{file:#}\n"),
            summary,
        })
    }

    fn gear(
        &mut self,
        i: usize,
        gear: &'a Component,
        flanks: &[&'a Component],
        [module, alpha]: [f64; 2],
        optional: &mut Vec<String>,
    ) -> Result<Map<String, Value>, Error> {
        let name = format!("gear{}", i + 1);
        let both: Vec<&Component> = [gear].into_iter().chain(flanks.iter().copied()).collect();
        let near = |kind: &'static str| -> Vec<&'a Component> {
            both.iter()
                .flat_map(|c| self.model.related(c.id, |k| k == kind))
                .collect()
        };
        let (tools, settings, materials) = (
            near("rack_shaped_tool"),
            near("cylindrical_gear_manufacturing_settings"),
            near("material"),
        );
        let mut fields = Map::new();
        let teeth = self.required(&format!("{name}.teeth"), &both, &["number_of_teeth"])?;
        fields.insert("teeth".into(), json!(teeth.abs().round() as u64));
        #[rustfmt::skip]
        let rows: &[(&str, &[&Component], &[&str], f64)] = &[
            ("face_width_mm", &both, &["face_width"], 1.0),
            ("profile_shift_iso_21771", &both, &["profile_shift_coefficient", "addendum_modification_coefficient"], 1.0),
            ("tip_diameter_mm", &both, &["tip_diameter"], 1.0),
            ("tip_form_diameter_mm", &both, &["tip_form_diameter"], 1.0),
            ("root_diameter_mm", &both, &["root_diameter"], 1.0),
            // The addendum of the tool cuts the dedendum of the gear.
            ("dedendum_coefficient", &tools, &["addendum_coefficient_reference_profile"], 1.0),
            ("tool_tip_radius_coefficient", &tools, &["tip_radius_factor"], 1.0),
            ("youngs_modulus_gpa", &materials, &["elastic_modulus"], 1.0),
            ("poisson_ratio", &materials, &["poisson_ratio"], 1.0),
        ];
        for (field, components, names, sign) in rows {
            if let Some(value) = self.number(&format!("{name}.{field}"), components, names)? {
                // Diameters of a ring may be negative.
                let value = if field.ends_with("_mm") {
                    value.abs()
                } else {
                    value * sign
                };
                fields.insert((*field).into(), json!(value));
            }
        }
        if gear.kind == "cylindrical_gear"
            && let Some(mm) = self
                .number(
                    &format!("{name}.bore_diameter_mm"),
                    &both,
                    &["inner_diameter"],
                )?
                .filter(|mm| *mm > 0.0)
        {
            fields.insert("bore_diameter_mm".into(), json!(mm));
        }
        let span = self
            .number("", &both, &["span_measurement"])?
            .zip(self.number("", &both, &["number_of_teeth_for_span_measurement"])?);
        let balls = self
            .number("", &both, &["size_over_balls"])?
            .zip(self.number("", &both, &["diameter_of_measuring_ball_or_pin"])?);
        let generated = self.number(
            "",
            &settings,
            &["generated_addendum_modification_coefficient"],
        )?;
        // Of several measures of the thickness one is enough.
        if let Some((w, k)) = span {
            fields.extend([
                ("span_measurement_mm".into(), json!(w.abs())),
                ("span_teeth".into(), json!(k.abs() as u64)),
            ]);
            self.taken
                .push(format!("{name}.span_measurement_mm, span_teeth"));
        } else if let Some((m, ball)) = balls {
            fields.extend([
                ("dimension_over_balls_mm".into(), json!(m.abs())),
                ("ball_diameter_mm".into(), json!(ball)),
            ]);
            self.taken
                .push(format!("{name}.dimension_over_balls_mm, ball_diameter_mm"));
        } else if let Some(x) = generated {
            let s = module * (std::f64::consts::FRAC_PI_2 + 2.0 * x * alpha.to_radians().tan());
            fields.insert("normal_tooth_thickness_mm".into(), json!(rounded(s)));
            self.taken.push(format!(
                "{name}.normal_tooth_thickness_mm from generated_addendum_modification_coefficient"
            ));
        } else {
            self.assumed.push(format!(
                "{name}: teeth of the thickness that profile shift and centre distance leave"
            ));
        }
        for field in [
            "tip_form_diameter_mm",
            "root_diameter_mm",
            "span_measurement_mm",
            "dimension_over_balls_mm",
            "normal_tooth_thickness_mm",
            "bore_diameter_mm",
        ] {
            if fields.contains_key(field) {
                optional.push(format!("{name}.{field}"));
            }
        }
        for (default, what) in [
            ("dedendum_coefficient", "1.25"),
            ("tool_tip_radius_coefficient", "0.38"),
            ("youngs_modulus_gpa", "206"),
        ] {
            let is_given = fields.contains_key(default)
                || default == "dedendum_coefficient" && fields.contains_key("root_diameter_mm");
            if !is_given {
                self.assumed.push(format!("{name}.{default} = {what}"));
            }
        }
        let sides = ["left", "right"].map(|side| self.flank(gear, side));
        let sides: Vec<Map<String, Value>> = sides
            .into_iter()
            .map(|c| c.map_or(Ok(Map::new()), |c| self.modifications(&name, c)))
            .collect::<Result<_, _>>()?;
        if sides[0] == sides[1] {
            fields.extend(sides[0].clone());
        } else {
            self.assumed.push(format!("{name}: the left flank is the drive flank; turn the two if the stage is driven the other way"));
            for (field, side) in ["drive_flank", "coast_flank"].iter().zip(sides) {
                fields.insert((*field).into(), Value::Object(side));
            }
        }
        Ok(fields)
    }

    fn flank(&self, gear: &Component, side: &str) -> Option<&'a Component> {
        let mut relations = self
            .model
            .relations
            .iter()
            .filter(|(kind, refs)| kind == "flank" && refs.iter().any(|r| r.1 == gear.id));
        let id =
            relations.find_map(|(_, refs)| Some(refs.iter().find(|(role, _)| role == side)?.1))?;
        self.model.component(id)
    }

    /// Modifications of a flank in fields of the pair file.
    fn modifications(
        &mut self,
        gear: &str,
        flank: &Component,
    ) -> Result<Map<String, Value>, Error> {
        let mut fields = Map::new();
        let kinds = [
            "tip_relief",
            "root_relief",
            "profile_crowning",
            "profile_slope",
            "helix_crowning",
            "helix_slope",
            "end_relief_datum_face",
            "end_relief_non_datum_face",
        ];
        let is_other = |k: &str| {
            (k.contains("relief")
                || k.contains("modification")
                || k.contains("deviation")
                || k == "profile_twist")
                && !kinds.contains(&k)
        };
        for other in self.model.related(flank.id, is_other) {
            self.left.push(format!(
                "{} {} of the flank {}",
                other.kind, other.id, flank.id
            ));
        }
        let um = |mm: f64| rounded(1e3 * mm);
        for c in self.model.related(flank.id, |k| kinds.contains(&k)) {
            let here = [c];
            let path = format!("{gear}.{}", c.kind);
            let mm = |draft: &mut Self, name: &str| draft.number("", &here, &[name]);
            let field = match c.kind.as_str() {
                kind @ ("tip_relief" | "root_relief") => {
                    let Some(depth) = mm(self, &format!("{kind}_depth"))? else {
                        continue;
                    };
                    let diameter = mm(self, &format!("{kind}_datum_diameter"))?;
                    let length =
                        mm(self, &format!("{kind}_datum_length"))?.filter(|_| kind == "tip_relief");
                    let start = match (diameter, length) {
                        (Some(d), _) => json!({ "diameter_mm": d.abs() }),
                        (None, Some(length)) => json!({ "from_tip_mm": length }),
                        (None, None) => {
                            self.assumed
                                .push(format!("{path}: starts at the pitch point"));
                            json!("pitch_point")
                        }
                    };
                    fields.insert(kind.into(), json!({ "amount_um": um(depth), "start": start, "shape": self.shape(c, &path) }));
                    kind
                }
                "profile_crowning" => {
                    let [root, tip] = [
                        mm(self, "profile_crowning_at_root")?.unwrap_or(0.0),
                        mm(self, "profile_crowning_at_tip")?.unwrap_or(0.0),
                    ];
                    if root != tip {
                        self.assumed.push(format!(
                            "{path}: the mean of {} um at the root and {} um at the tip",
                            um(root),
                            um(tip)
                        ));
                    }
                    fields.insert("profile_crowning_um".into(), json!(um(0.5 * (root + tip))));
                    "profile_crowning_um"
                }
                "helix_crowning" => {
                    let [a, b] = [
                        mm(self, "helix_crowning_amount_datum_face")?.unwrap_or(0.0),
                        mm(self, "helix_crowning_amount_non_datum_face")?.unwrap_or(0.0),
                    ];
                    if a != b {
                        self.assumed.push(format!(
                            "{path}: the mean of {} and {} um at the two faces",
                            um(a),
                            um(b)
                        ));
                    }
                    fields.insert("lead_crowning_um".into(), json!(um(0.5 * (a + b))));
                    "lead_crowning_um"
                }
                kind @ ("end_relief_datum_face" | "end_relief_non_datum_face") => {
                    let side = kind.trim_start_matches("end_relief_");
                    let (Some(depth), Some(length)) = (
                        mm(self, &format!("end_relief_depth_{side}"))?,
                        mm(self, &format!("end_relief_length_{side}"))?,
                    ) else {
                        continue;
                    };
                    // The datum face is taken as the one at z = 0.
                    let field = if side == "datum_face" {
                        "lower_end_relief"
                    } else {
                        "upper_end_relief"
                    };
                    self.assumed
                        .push(format!("{path}: the datum face is that at z = 0"));
                    fields.insert(field.into(), json!({ "amount_um": um(depth), "length_mm": length, "shape": self.shape(c, &path) }));
                    field
                }
                // Slopes: their sign depends on which face and flank they count from.
                kind => {
                    self.left.push(format!(
                        "{kind} {} of the flank {}: enter it with the sign of docs/pair-file.md",
                        c.id, flank.id
                    ));
                    continue;
                }
            };
            self.taken
                .push(format!("{gear}.{field} from {} {}", c.kind, c.id));
        }
        Ok(fields)
    }

    fn shape(&mut self, component: &Component, path: &str) -> &'static str {
        match self.word(component, "shape_of_relief").as_deref() {
            Some("linear") => "linear",
            Some("parabolic") => "parabolic",
            Some("circular") => "arc",
            other => {
                self.assumed.push(format!(
                    "{path}.shape = linear ({} in the file)",
                    other.unwrap_or("none")
                ));
                "linear"
            }
        }
    }

    /// The file without those of the `optional` fields that the pair does not fit, each with its reason.
    fn consistent(&mut self, mut file: Value, mut optional: Vec<String>) -> Result<Value, Error> {
        loop {
            let refusal = match pair::from_json(&file.to_string()) {
                Ok(_) => return Ok(file),
                Err(PairError::Refused(refusal)) => refusal,
                Err(other) => return Err(other.into()),
            };
            let Some(k) = optional.iter().position(|field| *field == refusal.field) else {
                return Err(refusal.into());
            };
            let field = optional.remove(k);
            let (gear, name) = field.split_once('.').unwrap_or(("", &field));
            if let Some(fields) = file[gear].as_object_mut() {
                let gauge = match name {
                    "span_measurement_mm" => "span_teeth",
                    "dimension_over_balls_mm" => "ball_diameter_mm",
                    _ => name,
                };
                fields.remove(gauge);
                fields.remove(name);
            }
            self.taken.retain(|line| !line.starts_with(&field));
            self.left
                .push(format!("{field} = {}: {}", refusal.value, refusal.problem));
        }
    }
}
