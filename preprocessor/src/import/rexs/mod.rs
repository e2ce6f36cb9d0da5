//! Cylindrical stages of REXS files, the exchange format of gearbox data (rexs.info, versions 1.4 to 2.0), as pair files, with
//! an account of where each field comes from.

mod model;

use std::path::Path;

use crate::gear::Pair;
use crate::gear::protuberance_form_radius;
use gearmesh::gear::involute;
use gearmesh::words::rounded;
use serde_json::{Map, Value, json};

use crate::pair::{self, PairError};
pub use model::RexsError;
use model::{Attribute, Component, Model, refused};

impl From<PairError> for RexsError {
    fn from(error: PairError) -> RexsError {
        RexsError(error.to_string())
    }
}

type Result<T, E = RexsError> = std::result::Result<T, E>;

/// Versions whose names of attributes are known.
const VERSIONS: [[u32; 2]; 2] = [[1, 4], [2, 0]];

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

/// Tools whose profile cuts the teeth; the last one is there since version 2.0.
const TOOLS: [&str; 3] = ["rack_shaped_tool", "cutter_wheel_tool", "profile_tool"];
const SETTINGS: &str = "cylindrical_gear_manufacturing_settings";
const GENERATED_SHIFT: &str = "generated_addendum_modification_coefficient";

/// Fields that are left out where the pair does not fit them, measures with their gauges.
const OPTIONAL: [&[&str]; 7] = [
    &["root_diameter_mm"],
    &["tip_form_diameter_mm"],
    &["root_form_diameter_mm"],
    &["span_measurement_mm", "span_teeth"],
    &["dimension_over_balls_mm", "ball_diameter_mm"],
    &["normal_tooth_thickness_mm"],
    &["bore_diameter_mm"],
];

/// Parts of the names of attributes that change the geometry of teeth.
const GEOMETRY: [&str; 8] = [
    "chamfer",
    "rounding",
    "protuberance",
    "allowance",
    "form_diameter",
    "root_diameter",
    "tip_diameter",
    "shift",
];

type Fields = Map<String, Value>;

/// Where a line of the account belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Head {
    Taken,
    Derived,
    Assumed,
    Left,
    Warning,
    Note,
}

/// Where the fields come from: each line once.
#[derive(Default)]
struct Account(Vec<(Head, String)>);

impl Account {
    fn add(&mut self, head: Head, line: impl Into<String>) {
        let line = (head, line.into());
        if !self.0.contains(&line) {
            self.0.push(line);
        }
    }

    fn lines(mut self) -> Vec<String> {
        self.0.sort_by_key(|(head, _)| *head);
        let name = |head| format!("{head:?}").to_lowercase();
        let lines = self.0.into_iter();
        lines
            .map(|(head, line)| format!("{}: {line}\n", name(head)))
            .collect()
    }
}

/// The pair file of a stage.
#[derive(Debug)]
pub struct Imported {
    /// The file: the account in comments, then the fields.
    pub text: String,
    /// What was taken, derived, assumed and left out, each with its value, warnings, and the notes on the pair.
    pub account: String,
}

/// The cylindrical stage `stage` (the only one, where none is named) of the file at `path`, at `torque` N m on gear 1.
///
/// # Errors
/// A file that is no REXS, a stage that is missing, incomplete or contradicts itself, and a pair that cannot work.
pub fn pair_file(path: &Path, stage: Option<u64>, torque: Option<f64>) -> Result<Imported> {
    let name = path.file_stem().unwrap_or("rexs".as_ref());
    let imported =
        Model::read(path).and_then(|model| import(&model, stage, torque, &name.to_string_lossy()));
    imported.map_err(|RexsError(problem)| RexsError(format!("{}: {problem}", path.display())))
}

/// The same of the `bytes` of a file, with the name of the pair.
///
/// # Errors
/// Those of [`pair_file`].
pub fn from_bytes(bytes: Vec<u8>, name: &str) -> Result<Imported> {
    import(&Model::from_bytes(bytes)?, None, None, name)
}

fn import(model: &Model, stage: Option<u64>, torque: Option<f64>, name: &str) -> Result<Imported> {
    let (stage, gears) = stage_of(model, stage)?;
    let teeth = gears.map(|gear| {
        let mut parts = vec![gear];
        parts.extend(model.related(&gear.id, |kind| {
            ["cylindrical_gear_flank", "flank_geometry"].contains(&kind)
        }));
        parts
    });
    let mut draft = Draft {
        model,
        stage,
        gears,
        teeth,
        account: Account::default(),
    };
    match [draft.is_ring(0), draft.is_ring(1)] {
        [true, true] => {
            return refused(format!(
                "gear_1 and gear_2 of stage {} are both rings; an internal stage has one",
                stage.id
            ));
        }
        [true, false] => {
            draft.gears.reverse();
            draft.teeth.reverse();
            draft.account.add(
                Head::Assumed,
                format!(
                    "the ring, gear_1 of stage {}, is gear 2 of the pair, so that torques are those on gear_2 of the stage",
                    stage.id
                ),
            );
        }
        _ => {}
    }
    draft.fill(torque, name)
}

/// The stage `id`, the only one where none is named, and its gears.
fn stage_of(model: &Model, id: Option<u64>) -> Result<(&Component, [&Component; 2])> {
    let all = model.components.iter();
    let stages: Vec<_> = all.filter(|c| c.kind == "cylindrical_stage").collect();
    let listed = stages.iter().map(|s| format!("{} ({})", s.id, s.name));
    let (listed, count) = (listed.collect::<Vec<_>>().join(", "), stages.len());
    let id = id.map(|id| id.to_string());
    let named = stages
        .iter()
        .find(|s| id.as_ref().is_none_or(|id| s.id == *id));
    let stage = match (&id, named) {
        (None, None) => return refused("it has no cylindrical_stage"),
        (None, _) if count > 1 => {
            return refused(format!(
                "it has {count} cylindrical stages: {listed}; name one by --stage"
            ));
        }
        (Some(id), None) => {
            return refused(format!(
                "--stage = {id}: there is no such cylindrical stage; there are {listed}"
            ));
        }
        (_, Some(stage)) => *stage,
    };
    let relation = model
        .relations
        .iter()
        .find(|r| r.kind == "stage" && r.role("stage") == Some(&stage.id));
    match ["gear_1", "gear_2"].map(|role| model.component(relation?.role(role)?)) {
        [Some(gear1), Some(gear2)] => Ok((stage, [gear1, gear2])),
        _ => refused(format!(
            "stage {} has no relation `stage` with gear_1 and gear_2",
            stage.id
        )),
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

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * (1.0 + a.abs())
}

/// A number in mm, degrees, GPa or none, and where it stands.
#[derive(Clone)]
struct Given {
    value: f64,
    origin: String,
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
    let cells = match &a.value {
        Value::Array(cells) => &cells[..],
        one => std::slice::from_ref(one),
    };
    let number = |cell: &Value| {
        let text = cell.as_str().and_then(|text| text.trim().parse().ok());
        cell.as_f64()
            .or(text)
            .filter(|number: &f64| number.is_finite())
    };
    let numbers: Option<Vec<f64>> = cells
        .iter()
        .map(|c| Some(rounded(number(c)? * scale)))
        .collect();
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
fn first(components: &[&Component], names: &[&str]) -> Result<Option<Given>> {
    Ok(all_given(components, names)?.into_iter().next())
}

/// The number in which all of them agree.
fn agreed(field: &str, components: &[&Component], names: &[&str]) -> Result<Option<Given>> {
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

fn vector(component: &Component, name: &str) -> Result<Option<[f64; 3]>> {
    let Some(a) = component.attribute(name) else {
        return Ok(None);
    };
    let numbers = numbers(component, a)?;
    let wrong = || {
        RexsError(format!(
            "attribute `{name}` of component {} = {}: no three numbers",
            component.id,
            a.shown()
        ))
    };
    Ok(Some(numbers.try_into().map_err(|_| wrong())?))
}

/// What both gears have in common, with the signs of ISO 21771: those of a ring negative.
struct Basic {
    module: f64,
    /// Normal pressure angle and helix angle, rad.
    alpha: f64,
    helix: f64,
    teeth: [f64; 2],
}

impl Basic {
    fn transverse_pressure_angle(&self) -> f64 {
        (self.alpha.tan() / self.helix.cos()).atan()
    }

    /// mm.
    fn reference_diameter(&self, i: usize) -> f64 {
        self.teeth[i] * self.module / self.helix.cos()
    }

    /// Sum of the profile shifts without backlash at the centre distance `a`, mm.
    fn shift_sum(&self, a: f64) -> f64 {
        let alpha = self.transverse_pressure_angle();
        let zero = 0.5 * (self.reference_diameter(0) + self.reference_diameter(1));
        let working = (zero.abs() * alpha.cos() / a).acos();
        (self.teeth[0] + self.teeth[1]) * (involute(working) - involute(alpha))
            / (2.0 * self.alpha.tan())
    }
}

/// A pair file in the making.
struct Draft<'a> {
    model: &'a Model,
    stage: &'a Component,
    gears: [&'a Component; 2],
    /// Each gear and its flanks.
    teeth: [Vec<&'a Component>; 2],
    account: Account,
}

impl<'a> Draft<'a> {
    fn taken(&mut self, field: &str, given: &Given) {
        self.account.add(
            Head::Taken,
            format!("{field} from {}: {}", given.origin, given.value),
        );
    }

    /// Components of one of `kinds` related to gear `i` or its flanks.
    fn beside(&self, i: usize, kinds: &[&str]) -> Vec<&'a Component> {
        self.teeth[i]
            .iter()
            .flat_map(|c| self.model.related(&c.id, |k| kinds.contains(&k)))
            .collect()
    }

    fn required(&mut self, field: &str, parts: &[&Component], name: &str) -> Result<f64> {
        let Some(given) = agreed(field, parts, &[name])? else {
            let ids: Vec<&str> = parts.iter().map(|c| &*c.id).collect();
            return refused(format!(
                "none of the components {} has `{name}`",
                ids.join(", ")
            ));
        };
        self.taken(field, &given);
        Ok(given.value)
    }

    /// Whether gear `i` is a ring: by its kind, or by negative teeth as in ISO 21771.
    fn is_ring(&self, i: usize) -> bool {
        let teeth = first(&self.teeth[i], &["number_of_teeth"]);
        self.gears[i].kind == "ring_gear"
            || teeth.is_ok_and(|z| z.is_some_and(|given| given.value < 0.0))
    }

    fn fill(mut self, torque: Option<f64>, name: &str) -> Result<Imported> {
        self.check_version();
        let is_internal = self.is_ring(1);
        let mut parts = vec![self.stage];
        parts.extend(self.teeth.iter().flatten());
        let module = self.required("normal_module_mm", &parts, "normal_module")?;
        let alpha = self.required("normal_pressure_angle_deg", &parts, "normal_pressure_angle")?;
        let helix = self.helix(is_internal)?;
        let mut teeth = [0.0; 2];
        for (i, teeth) in teeth.iter_mut().enumerate() {
            let parts = self.teeth[i].clone();
            let number =
                self.required(&format!("gear{}.teeth", i + 1), &parts, "number_of_teeth")?;
            *teeth = if self.is_ring(i) {
                -number.abs()
            } else {
                number.abs()
            };
        }
        let basic = Basic {
            module,
            alpha: alpha.to_radians(),
            helix: helix.to_radians().abs(),
            teeth,
        };
        let distance = self.center_distance()?;
        let mut gears = [self.gear(0, &basic)?, self.gear(1, &basic)?];
        self.shifts(&basic, distance, &mut gears)?;
        for (i, fields) in gears.iter_mut().enumerate() {
            self.tooth_thickness(i, &basic, fields)?;
            self.root(i, &basic, fields)?;
            self.tip(i, &basic, fields)?;
            self.modifications(i, fields)?;
        }
        let width = |gear: &Fields| {
            gear.get("face_width_mm")
                .and_then(Value::as_f64)
                .unwrap_or(0.0)
        };
        let [b1, b2] = [width(&gears[0]), width(&gears[1])];
        // A hundred newtons for each mm of face and of module.
        let usual = rounded((0.05 * b1.min(b2) * module * module * teeth[0]).ceil());
        if torque.is_none() {
            let line = format!(
                "operating.nominal_torque_nm = {usual}: 100 N per mm of face and of module; give --torque-nm"
            );
            self.account.add(Head::Assumed, line);
        }
        let nominal = torque.unwrap_or(usual);
        let offset = rounded(0.5 * (b1 - b2));
        self.account.add(
            Head::Assumed,
            "operating: torques up to 1.5 times the nominal one, centre distance -20 to 50 um, misalignment -1 to 1 mrad",
        );
        self.account.add(
            Head::Assumed,
            format!("face_offset_mm = {offset}: both faces share their middle"),
        );
        let [gear1, gear2] = gears;
        let mut file = json!({
            "name": name,
            "source": format!("REXS {}, stage {} {}", self.model.version, self.stage.id, self.stage.name),
            "meshing": if is_internal { "internal" } else { "external" },
            "normal_module_mm": module,
            "normal_pressure_angle_deg": alpha,
            "helix_angle_deg": helix,
            "face_offset_mm": offset,
            "gear1": gear1,
            "gear2": gear2,
            "operating": {
                "nominal_torque_nm": nominal, "maximum_torque_nm": rounded(1.5 * nominal),
                "center_distance_offset_um": [-20.0, 50.0], "misalignment_mrad": [-1.0, 1.0],
            },
        });
        if let Some(mm) = distance {
            file["center_distance_mm"] = json!(mm);
        }
        let (file, pair) = self.consistent(file)?;
        let mm = 1e3 * pair.geometry.center_distance;
        if distance.is_none() {
            let line = format!(
                "center_distance_mm = {mm:.4}: without backlash, as neither the stage nor positions of the gears give it"
            );
            self.account.add(Head::Assumed, line);
        }
        for note in &pair.warnings {
            self.account.add(Head::Note, note.clone());
        }
        self.list_what_is_left(parts);
        let lines = self.account.lines();
        let comments: String = lines.iter().map(|line| format!("// {line}")).collect();
        Ok(Imported {
            text: format!("{comments}{file:#}\n"),
            account: lines.concat(),
        })
    }

    fn check_version(&mut self) {
        let version = &self.model.version;
        let mut numbers = version.split('.').map(|part| part.parse::<u32>().ok());
        let [major, minor] = [(); 2].map(|()| numbers.next().flatten());
        let known = major.map(|major| [major, minor.unwrap_or(0)]);
        if !known.is_some_and(|version| VERSIONS[0] <= version && version <= VERSIONS[1]) {
            let line = format!(
                "the file has version {version:?}; names of versions 1.4 to 2.0 are known, and others may be left out"
            );
            self.account.add(Head::Warning, line);
        }
    }

    /// The helix angle on gear 1, degrees, > 0 right-handed. External gears have opposite hands; for a ring both signs are in use.
    fn helix(&mut self, is_internal: bool) -> Result<f64> {
        let name = "helix_angle_reference_diameter";
        let field = "helix_angle_deg (> 0: right-handed)";
        let [one, two] = [0, 1].map(|i| agreed(field, &self.teeth[i], &[name]));
        match (one?, two?) {
            (None, None) => {
                self.account.add(Head::Assumed, "helix_angle_deg = 0");
                Ok(0.0)
            }
            (None, Some(two)) => {
                let value = if is_internal { two.value } else { -two.value };
                self.account.add(
                    Head::Derived,
                    format!("helix_angle_deg = {value} from {}", two.origin),
                );
                Ok(value)
            }
            (Some(one), two) => {
                if let Some(two) = two {
                    let fits =
                        near(two.value, -one.value) || is_internal && near(two.value, one.value);
                    if !fits {
                        return refused(format!(
                            "helix_angle_deg: {} = {}, and {} = {}; the gears of an external stage have the same angle and opposite \
                             hands, those of an internal one the same angle",
                            one.origin, one.value, two.origin, two.value
                        ));
                    }
                }
                self.taken(field, &one);
                Ok(one.value)
            }
        }
    }

    /// The centre distance, mm: that of the stage, else from the positions of the gears.
    fn center_distance(&mut self) -> Result<Option<f64>> {
        let given = first(&[self.stage], &["center_distance"])?;
        let positions = self.distance_of_positions()?;
        match (given, positions) {
            (Some(given), positions) => {
                self.taken("center_distance_mm", &given);
                let mm = given.value.abs();
                if let Some(other) = positions.filter(|other| (other - mm).abs() > 1e-3) {
                    let line = format!(
                        "center_distance_mm = {mm} of the stage, but the positions of the gears are {other} mm apart"
                    );
                    self.account.add(Head::Warning, line);
                }
                Ok(Some(mm))
            }
            (None, Some(mm)) => {
                let line = format!(
                    "center_distance_mm = {mm} from support_vector and u_axis_vector of both gears"
                );
                self.account.add(Head::Derived, line);
                Ok(Some(mm))
            }
            (None, None) => Ok(None),
        }
    }

    /// Distance of the axes, mm; none where positions or a direction are missing, or on one axis.
    fn distance_of_positions(&self) -> Result<Option<f64>> {
        let [mut points, mut axes] = [[None; 2]; 2];
        for i in 0..2 {
            for c in [vec![self.gears[i]], self.beside(i, &["shaft"])].concat() {
                points[i] = points[i].or(vector(c, "support_vector")?);
                axes[i] = axes[i].or(vector(c, "u_axis_vector")?);
            }
        }
        let ([Some(a), Some(b)], Some(axis)) = (points, axes[0].or(axes[1])) else {
            return Ok(None);
        };
        let [a, b, axis] = [a, b, axis].map(nalgebra::Vector3::from);
        let distance = axis
            .try_normalize(1e-9)
            .map(|axis| (b - a).cross(&axis).norm());
        Ok(distance.map(rounded).filter(|mm| *mm > 0.0))
    }

    /// Fields of gear `i` that attributes give as they are.
    fn gear(&mut self, i: usize, basic: &Basic) -> Result<Fields> {
        let name = ["gear1", "gear2"][i];
        let mut fields = Map::new();
        fields.insert("teeth".into(), json!(basic.teeth[i].abs().round() as u64));
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

    /// Profile shifts that are not given, from the centre distance.
    fn shifts(
        &mut self,
        basic: &Basic,
        distance: Option<f64>,
        gears: &mut [Fields; 2],
    ) -> Result<()> {
        let field = "profile_shift_iso_21771";
        let given = [0, 1].map(|i| gears[i].get(field).and_then(Value::as_f64));
        let sum = distance
            .map(|mm| basic.shift_sum(mm))
            .filter(|sum| sum.is_finite());
        let Some(sum) = sum else {
            for i in [0, 1].into_iter().filter(|i| given[*i].is_none()) {
                self.account
                    .add(Head::Assumed, format!("gear{}.{field} = 0", i + 1));
            }
            return Ok(());
        };
        let values = match given {
            [Some(_), Some(_)] => return Ok(()),
            [Some(x1), None] => [x1, sum - x1],
            [None, Some(x2)] => [sum - x2, x2],
            // A ring takes all of it, so that a pinion of many mates stays what it is.
            [None, None] if self.is_ring(1) => [0.0, sum],
            [None, None] => [0.5 * sum; 2],
        };
        for i in [0, 1].into_iter().filter(|i| given[*i].is_none()) {
            let value = if values[i].abs() < 1e-6 {
                0.0
            } else {
                rounded(values[i])
            };
            gears[i].insert(field.into(), json!(value));
            let (name, mm) = (
                format!("gear{}.{field} = {value}", i + 1),
                distance.unwrap_or(0.0),
            );
            let (head, why) = match given {
                [None, None] => (
                    Head::Assumed,
                    format!(
                        "the sum {sum:.5} follows from the centre distance {mm} mm without backlash, its parts do not"
                    ),
                ),
                _ => (
                    Head::Derived,
                    format!(
                        "from that of the other gear and the centre distance {mm} mm without backlash"
                    ),
                ),
            };
            self.account.add(head, format!("{name}: {why}"));
        }
        Ok(())
    }

    /// Measures of the tooth thickness, or that of the generating profile shift x_E with its limits.
    fn tooth_thickness(&mut self, i: usize, basic: &Basic, fields: &mut Fields) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        let mut is_measured = false;
        for (measure, size, value_of, size_of) in [
            (
                "span_measurement_mm",
                "span_teeth",
                "span_measurement",
                "number_of_teeth_for_span_measurement",
            ),
            (
                "dimension_over_balls_mm",
                "ball_diameter_mm",
                "size_over_balls",
                "diameter_of_measuring_ball_or_pin",
            ),
        ] {
            let parts = &self.teeth[i];
            let [value, gauge] = [value_of, size_of].map(|attribute| first(parts, &[attribute]));
            if let (false, Some(value), Some(gauge)) = (is_measured, value?, gauge?) {
                let number = match size {
                    "span_teeth" => json!(gauge.value.abs() as u64),
                    _ => json!(gauge.value),
                };
                fields.insert(measure.into(), json!(value.value.abs()));
                fields.insert(size.into(), number);
                self.taken(&format!("{name}.{measure}"), &value);
                self.taken(&format!("{name}.{size}"), &gauge);
                is_measured = true;
            }
        }
        let Some(limits) = self.generated_shift(i)? else {
            if !is_measured {
                let line = format!(
                    "{name}: teeth of the thickness that profile shift and centre distance leave"
                );
                self.account.add(Head::Assumed, line);
            }
            return Ok(());
        };
        if is_measured {
            return Ok(());
        }
        let [low, high] = [limits[1], limits[2]].map(|x| {
            rounded(basic.module * (std::f64::consts::FRAC_PI_2 + 2.0 * x * basic.alpha.tan()))
        });
        let value = if low == high {
            json!(low)
        } else {
            json!([low, high])
        };
        let field = "normal_tooth_thickness_mm";
        let line = format!(
            "{name}.{field} = {value} from {GENERATED_SHIFT}, x_E {} to {}",
            limits[1], limits[2]
        );
        self.account.add(Head::Derived, line);
        fields.insert(field.into(), value);
        Ok(())
    }

    /// The generating profile shift of gear `i`: as it stands, its lower and its upper limit. Programs write the limits
    /// themselves, or their deviations, under the same names.
    fn generated_shift(&self, i: usize) -> Result<Option<[f64; 3]>> {
        let settings = self.beside(i, &[SETTINGS]);
        let Some(x) = first(&settings, &[GENERATED_SHIFT])? else {
            return Ok(None);
        };
        let limit = |end: &str| first(&settings, &[&format!("{GENERATED_SHIFT}_{end}_deviation")]);
        let limits = match (limit("lower")?, limit("upper")?) {
            (Some(low), Some(high)) => {
                let slack = 1e-9;
                let is_absolute = low.value - slack <= x.value && x.value <= high.value + slack;
                let zero = if is_absolute { 0.0 } else { x.value };
                [zero + low.value, zero + high.value]
            }
            _ => [x.value; 2],
        };
        Ok(Some([x.value, limits[0], limits[1]]))
    }

    /// Root circle and start of the usable involute: what the file gives, else what the tool cuts with the generating profile
    /// shift and the machining allowance, under a protuberance.
    fn root(&mut self, i: usize, basic: &Basic, fields: &mut Fields) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        let (tools, settings) = (self.beside(i, &TOOLS), self.beside(i, &[SETTINGS]));
        let number = |fields: &Fields, field: &str| fields.get(field).and_then(Value::as_f64);
        let nominal = number(fields, "profile_shift_iso_21771").unwrap_or(0.0);
        let generating = self.generated_shift(i)?.map_or(nominal, |limits| limits[0]);
        let allowance = first(&settings, &["machining_allowance"])?.filter(|q| q.value > 0.0);
        let protuberance = match first(&tools, &["protuberance_amount"])? {
            Some(given) => Some(given),
            None => first(&tools, &["protuberance_amount_factor"])?.map(|factor| Given {
                value: rounded(factor.value * basic.module),
                ..factor
            }),
        };
        let protuberance = protuberance.filter(|given| given.value > 0.0);
        let angle = first(&tools, &["protuberance_angle"])?;
        // A tool that leaves an allowance stands farther out.
        let stock = allowance.as_ref().map_or(0.0, |q| q.value);
        let generated = generating + stock / (basic.module * basic.alpha.sin());
        let cut = number(fields, "dedendum_coefficient").map(|dedendum| {
            (basic.reference_diameter(i) + 2.0 * basic.module * (generated - dedendum)).abs()
        });
        match (number(fields, "root_diameter_mm"), cut) {
            (Some(root), Some(cut)) => {
                fields.remove("dedendum_coefficient");
                if (root - cut).abs() > 0.02 {
                    let line = format!(
                        "{name}.root_diameter_mm = {root} of the file, but its tool cuts {cut:.4}: the diameter counts"
                    );
                    self.account.add(Head::Warning, line);
                }
            }
            (None, Some(cut)) if generated != nominal => {
                fields.remove("dedendum_coefficient");
                let root = rounded(cut);
                fields.insert("root_diameter_mm".into(), json!(root));
                let line = format!(
                    "{name}.root_diameter_mm = {root} from the tool at the generating profile shift {generated:.5}{}",
                    if stock > 0.0 {
                        format!(", which a machining allowance of {stock} mm raises")
                    } else {
                        String::new()
                    }
                );
                self.account.add(Head::Derived, line);
            }
            _ => {}
        }
        let Some(protuberance) =
            protuberance.filter(|_| !fields.contains_key("root_form_diameter_mm"))
        else {
            return Ok(());
        };
        let undercut = rounded(protuberance.value - stock);
        let words = format!(
            "protuberance {} mm less machining allowance {stock} mm",
            protuberance.value
        );
        if undercut <= 0.0 {
            let line = format!("{name}: no undercut is left: {words}");
            self.account.add(Head::Derived, line);
            return Ok(());
        }
        let angle = angle.map_or(basic.alpha, |angle| angle.value.to_radians());
        let form = self
            .bare_gear(i, basic, fields)
            .and_then(|gear| protuberance_form_radius(&gear, 1e-3 * undercut, angle));
        match form {
            Some(radius) => {
                let mm = rounded(2e3 * radius);
                fields.insert("root_form_diameter_mm".into(), json!(mm));
                self.account.add(
                    Head::Derived,
                    format!("{name}.root_form_diameter_mm = {mm} from {words}"),
                );
            }
            None => self.account.add(
                Head::Warning,
                format!(
                    "{name}: left out: {words}, for which no start of the usable involute follows"
                ),
            ),
        }
        Ok(())
    }

    /// Gear `i` with these fields, alone: its teeth are what the pair makes of them.
    fn bare_gear(&self, i: usize, basic: &Basic, fields: &Fields) -> Option<gearmesh::gear::Gear> {
        if self.is_ring(i) {
            return None;
        }
        let field = |name: &str| fields.get(name).cloned().unwrap_or(Value::Null);
        let alike = json!({
            "teeth": field("teeth"), "face_width_mm": 10.0 * basic.module, "profile_shift": field("profile_shift_iso_21771"),
            "root_diameter_mm": field("root_diameter_mm"), "dedendum_coefficient": field("dedendum_coefficient"),
            "tool_tip_radius_coefficient": field("tool_tip_radius_coefficient"), "addendum_coefficient": 0.9
        });
        let mut alike = alike;
        alike.as_object_mut()?.retain(|_, value| !value.is_null());
        let file = json!({
            "name": "alone", "meshing": "external", "normal_module_mm": basic.module,
            "normal_pressure_angle_deg": basic.alpha.to_degrees(), "helix_angle_deg": basic.helix.to_degrees(),
            "gear1": alike, "gear2": alike,
            "operating": {
                "nominal_torque_nm": 1.0, "maximum_torque_nm": 1.0,
                "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0],
            },
        });
        let [gear, _] = pair::from_json(&file.to_string()).ok()?.geometry.gears;
        Some(gear)
    }

    /// The tip form circle of a chamfer.
    fn tip(&mut self, i: usize, basic: &Basic, fields: &mut Fields) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        let chamfer = agreed(
            &format!("{name}: tooth_tip_chamfer"),
            &self.teeth[i],
            &["tooth_tip_chamfer"],
        )?;
        let Some(chamfer) = chamfer.filter(|c| c.value != 0.0) else {
            return Ok(());
        };
        if fields.contains_key("tip_form_diameter_mm") {
            return Ok(());
        }
        let number = |field: &str| fields.get(field).and_then(Value::as_f64);
        let side = if self.is_ring(i) { -1.0 } else { 1.0 };
        let usual = basic.reference_diameter(i)
            + 2.0 * basic.module * (1.0 + number("profile_shift_iso_21771").unwrap_or(0.0));
        let tip = number("tip_diameter_mm").unwrap_or(usual.abs());
        let form = rounded(tip - side * 2.0 * chamfer.value.abs());
        fields.insert("tip_form_diameter_mm".into(), json!(form));
        let line = format!(
            "{name}.tip_form_diameter_mm = {form} from {}: {} at the tip diameter {tip}",
            chamfer.origin, chamfer.value
        );
        self.account.add(Head::Derived, line);
        Ok(())
    }

    /// Modifications of both flanks of gear `i`.
    fn modifications(&mut self, i: usize, fields: &mut Fields) -> Result<()> {
        let left = self.flank(i, "left")?;
        let right = self.flank(i, "right")?;
        if left == right {
            fields.extend(left);
        } else {
            let line = format!(
                "gear{}: the left flank is the drive flank; turn the two if the stage is driven the other way",
                i + 1
            );
            self.account.add(Head::Assumed, line);
            fields.insert("drive_flank".into(), left.into());
            fields.insert("coast_flank".into(), right.into());
        }
        Ok(())
    }
    /// Modifications of the flank of gear `i` on this `side` in fields of the pair file.
    fn flank(&mut self, i: usize, side: &str) -> Result<Fields> {
        let (model, gear, name) = (self.model, self.gears[i], ["gear1", "gear2"][i]);
        let mut fields = Map::new();
        let mut flanks = model
            .relations
            .iter()
            .filter(|r| r.kind == "flank" && r.names(&gear.id));
        let Some(flank) = flanks.find_map(|r| model.component(r.role(side)?)) else {
            return Ok(fields);
        };
        for c in model.related(&flank.id, |_| true) {
            let Component { id, kind, .. } = c;
            let left = format!("{kind} {id} of the flank {}", flank.id);
            let words = ["relief", "modification", "deviation", "profile_twist"];
            if let Some((field, value)) = self.modification(&format!("{name}.{kind}"), c)? {
                self.account.add(
                    Head::Taken,
                    format!("{name}.{field} from {kind} {id}: {value}"),
                );
                fields.insert(field.into(), value);
            } else if ["profile_slope", "helix_slope"].contains(&&**kind) {
                // Its sign depends on which face and flank it counts from.
                self.account.add(
                    Head::Warning,
                    format!(
                        "{left} left out: enter it with the sign of docs/pair-file.md: {}",
                        values(c)
                    ),
                );
            } else if words.iter().any(|word| kind.contains(word)) {
                self.account.add(Head::Left, left.clone());
                self.account
                    .add(Head::Warning, format!("{left} left out: {}", values(c)));
            }
        }
        Ok(fields)
    }

    /// Field and value of the modification `c`; none of another kind, and where its amount is not given.
    fn modification(&mut self, path: &str, c: &'a Component) -> Result<Option<(&'a str, Value)>> {
        let kind = &*c.kind;
        let mm = |name: &str| Ok::<_, RexsError>(first(&[c], &[name])?.map(|given| given.value));
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
                    self.account.add(
                        Head::Assumed,
                        format!("{path}: the mean of {a} and {b} um at its two ends"),
                    );
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
            self.account
                .add(Head::Assumed, format!("{path}: {assumed}"));
        }
        let shape = c.attribute("shape_of_relief").map(Attribute::shown);
        value["amount_um"] = json!(um(depth));
        value["shape"] = match shape.as_deref().unwrap_or("none") {
            shape @ ("linear" | "parabolic") => shape,
            "circular" => "arc",
            other => {
                self.account.add(
                    Head::Assumed,
                    format!("{path}.shape = linear ({other} in the file)"),
                );
                "linear"
            }
        }
        .into();
        Ok(Some((field, value)))
    }

    /// The file and its pair without those of the optional fields that do not fit, each with its reason.
    fn consistent(&mut self, file: Value) -> Result<(Value, Pair)> {
        let refusals = match pair::from_json(&file.to_string()) {
            Ok(pair) => return Ok((file, pair)),
            Err(PairError::Refused(refusals)) => refusals,
            Err(other) => return Err(other.into()),
        };
        let mut fitting = file.clone();
        let groups = ["gear1", "gear2"]
            .into_iter()
            .flat_map(|gear| OPTIONAL.map(|fields| (gear, fields)));
        for (gear, fields) in groups.clone() {
            if let Some(gear) = fitting[gear].as_object_mut() {
                gear.retain(|name, _| !fields.contains(&&**name));
            }
        }
        // Without them it may be refused for another reason.
        let Ok(mut pair) = pair::from_json(&fitting.to_string()) else {
            return Err(PairError::from(refusals).into());
        };
        for (gear, fields) in groups {
            let mut more = fitting.clone();
            for field in fields
                .iter()
                .filter(|field| file[gear].get(field).is_some())
            {
                more[gear][field] = file[gear][field].clone();
            }
            match pair::from_json(&more.to_string()) {
                Ok(made) => (fitting, pair) = (more, made),
                Err(error) => {
                    let (name, value) = (fields[0], &file[gear][fields[0]]);
                    let why = match error {
                        PairError::Refused(refusals) => refusals.all()[0].problem.clone(),
                        other => other.to_string(),
                    };
                    let line = format!("{gear}.{name} = {value} is left out: {why}");
                    self.account.add(Head::Warning, line);
                }
            }
        }
        Ok((fitting, pair))
    }

    /// Lists attributes of the stage and its gears that the pair file has no use for, those of geometry as warnings.
    fn list_what_is_left(&mut self, mut parts: Vec<&'a Component>) {
        for i in 0..2 {
            parts.extend(self.beside(i, &[TOOLS[0], TOOLS[1], TOOLS[2], SETTINGS, "material"]));
        }
        for c in parts {
            let mut left = Vec::new();
            for a in c.attributes.iter().filter(|a| !a.is_taken.replace(true)) {
                let value = format!("{} = {}", a.id, a.shown());
                if GEOMETRY.iter().any(|word| a.id.contains(word)) && !a.is_empty() {
                    let line = format!(
                        "{} {}: {value} is left out and changes the geometry",
                        c.kind, c.id
                    );
                    self.account.0.push((Head::Warning, line));
                } else {
                    left.push(value);
                }
            }
            if !left.is_empty() {
                self.account.add(
                    Head::Left,
                    format!("{} {}: {}", c.kind, c.id, left.join(", ")),
                );
            }
        }
    }
}

/// Attributes of `component` with their values.
fn values(component: &Component) -> String {
    let all = component.attributes.iter();
    let all = all.map(|a| format!("{} = {} {}", a.id, a.shown(), a.unit));
    all.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
