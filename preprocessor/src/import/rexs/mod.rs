//! Cylindrical stages of REXS files, the exchange format of gearbox data (rexs.info, versions 1.4 to 2.0), as pair files, with
//! an account of where each field comes from.

mod account;
mod draft;
mod gear;
mod given;
mod loads;
mod model;
mod modifications;
mod teeth;

use std::path::Path;

use gearmesh::words::rounded;
use serde_json::{Value, json};

use crate::gear::Pair;
use crate::pair::{self, PairError};
use account::{Account, Head};
use draft::Draft;
use loads::GEAR_DATA;
pub use model::RexsError;
use model::{Component, Model, Result, refused};
use teeth::{Basic, SETTINGS, TOOLS};

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

/// Likewise of the pair. Backlash that both tooth thicknesses contradict is left out, as they are what is measured.
const OPTIONAL_OF_PAIR: [&[&str]; 2] = [&["normal_backlash_um"], &["backlash_um"]];

/// Fields that say how thick the teeth of a gear are.
const THICKNESS: [&str; 3] = [
    "normal_tooth_thickness_mm",
    "span_measurement_mm",
    "dimension_over_balls_mm",
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

impl<'a> Draft<'a> {
    fn fill(mut self, torque: Option<f64>, name: &str) -> Result<Imported> {
        self.check_version();
        let is_internal = self.is_ring(1);
        let mut parts = vec![self.stage];
        parts.extend(self.teeth.iter().flatten());
        let module = self.required("normal_module_mm", &parts, "normal_module")?;
        let alpha = self.required("normal_pressure_angle_deg", &parts, "normal_pressure_angle")?;
        let helix = self.helix(is_internal)?;
        let basic = Basic {
            module,
            alpha: alpha.to_radians(),
            helix: helix.to_radians().abs(),
            teeth: [self.number_of_teeth(0)?, self.number_of_teeth(1)?],
        };
        let distance = self.center_distance()?;
        let mut gears = [self.gear(0, &basic)?, self.gear(1, &basic)?];
        self.shifts(&basic, distance, &mut gears)?;
        let backlash = self.backlash()?;
        for (i, fields) in gears.iter_mut().enumerate() {
            self.tooth_thickness(i, &basic, backlash.is_some(), fields)?;
            self.root(i, &basic, fields)?;
            self.tip(i, &basic, fields)?;
            self.modifications(i, fields)?;
        }
        let widths = gears.each_ref().map(|gear| gear.get("face_width_mm"));
        let [b1, b2] = widths.map(|width| width.and_then(Value::as_f64).unwrap_or(0.0));
        // A hundred newtons for each mm of face and of module.
        let usual = rounded((0.05 * b1.min(b2) * module * module * basic.teeth[0]).ceil());
        let given = match torque {
            None => self.torque(&basic)?,
            given => given,
        };
        if given.is_none() {
            let line = format!(
                "operating.nominal_torque_nm = {usual}: 100 N per mm of face and of module; give --torque-nm"
            );
            self.account.add(Head::Assumed, line);
        }
        let nominal = given.unwrap_or(usual);
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
        if let Some((field, value)) = backlash {
            file[field] = value;
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
        self.list_what_is_left(parts, &file);
        self.list_load_cases();
        let lines = self.account.lines();
        let comments: String = lines.iter().map(|line| format!("// {line}")).collect();
        Ok(Imported {
            text: format!("{comments}{file:#}\n"),
            account: lines.concat(),
        })
    }

    /// Number of teeth of gear `i`, negative for a ring.
    fn number_of_teeth(&mut self, i: usize) -> Result<f64> {
        let parts = self.teeth[i].clone();
        let number = self.required(&format!("gear{}.teeth", i + 1), &parts, "number_of_teeth")?;
        if number.fract() != 0.0 {
            return refused(format!(
                "gear{}.teeth: number_of_teeth = {number} is no whole number; correct it in the REXS file",
                i + 1
            ));
        }
        Ok(match self.is_ring(i) {
            true => -number.abs(),
            false => number.abs(),
        })
    }

    /// The file and its pair without those of the optional fields that do not fit, each with its reason.
    fn consistent(&mut self, file: Value) -> Result<(Value, Pair)> {
        let refusals = match pair::from_json(&file.to_string()) {
            Ok(pair) => return Ok((file, pair)),
            Err(PairError::Refused(refusals)) => refusals,
            Err(other) => return Err(other.into()),
        };
        let mut fitting = file.clone();
        let of_gears = ["gear1", "gear2"]
            .into_iter()
            .flat_map(|gear| OPTIONAL.map(|fields| (gear, fields)));
        let groups = of_gears.chain(OPTIONAL_OF_PAIR.map(|fields| (PAIR, fields)));
        for (part, fields) in groups.clone() {
            if let Some(part) = part_of(&mut fitting, part).as_object_mut() {
                part.retain(|name, _| !fields.contains(&&**name));
            }
        }
        // Without them it may be refused for another reason.
        let Ok(mut pair) = pair::from_json(&fitting.to_string()) else {
            return Err(PairError::from(refusals).into());
        };
        let mut given = file.clone();
        for (part, fields) in groups {
            let given = part_of(&mut given, part);
            let mut more = fitting.clone();
            for field in fields.iter().filter(|field| given.get(field).is_some()) {
                part_of(&mut more, part)[field] = given[field].clone();
            }
            match pair::from_json(&more.to_string()) {
                Ok(made) => (fitting, pair) = (more, made),
                Err(error) => {
                    let (name, value) = (fields[0], &given[fields[0]]);
                    let why = match error {
                        PairError::Refused(refusals) => refusals.all()[0].problem.clone(),
                        other => other.to_string(),
                    };
                    let dot = if part == PAIR { "" } else { "." };
                    let line = format!("{part}{dot}{name} = {value} is left out: {why}");
                    self.account.add(Head::Warning, line);
                }
            }
        }
        Ok((fitting, pair))
    }

    /// Lists attributes of the stage and its gears that the pair `file` has no use for, those of geometry as warnings.
    fn list_what_is_left(&mut self, mut parts: Vec<&'a Component>, file: &Value) {
        let has = |part: &Value, fields: &[&str]| fields.iter().any(|f| part.get(f).is_some());
        let has_backlash = has(file, &OPTIONAL_OF_PAIR.concat());
        let is_thick = ["gear1", "gear2"].map(|gear| has(&file[gear], &THICKNESS));
        let is_of = self.teeth.clone();
        // Whether the attribute `id` of `c` changes the geometry: thickness and backlash where the file leaves them open.
        let is_geometry = |c: &Component, id: &str| {
            // Diameters and thickness of gears in mesh follow from those of the gears.
            if c.kind.ends_with(GEAR_DATA) {
                return false;
            }
            if id.contains("tooth_thickness") || id.contains("backlash") {
                let of = (0..2).find(|&i| is_of[i].iter().any(|part| part.id == c.id));
                return !has_backlash && !of.map_or(is_thick == [true; 2], |i| is_thick[i]);
            }
            // `helix_angle` is no name of REXS, but is written for `helix_angle_reference_diameter`.
            GEOMETRY.iter().any(|word| id.contains(word)) || id == "helix_angle"
        };
        for i in 0..2 {
            parts.extend(self.beside(i, &[TOOLS[0], TOOLS[1], TOOLS[2], SETTINGS, "material"]));
            parts.extend(self.gear_data(i));
        }
        for c in parts {
            let mut left = Vec::new();
            for a in c.attributes.iter().filter(|a| !a.is_taken.replace(true)) {
                let value = format!("{} = {}", a.id, a.shown());
                // Nothing to take off; a shift of zero is a shift.
                let is_zero = !a.id.contains("shift") && a.shown().trim().parse() == Ok(0.0);
                if is_geometry(c, &a.id) && !is_zero && !a.is_empty() {
                    let line = format!(
                        "{} {}: {value} is left out and changes the geometry",
                        c.kind, c.id
                    );
                    self.account.add(Head::Warning, line);
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

/// The pair itself as a part of its file.
const PAIR: &str = "";

/// The object of a gear in the pair file `file`, or that of the pair.
fn part_of<'v>(file: &'v mut Value, part: &str) -> &'v mut Value {
    match part {
        PAIR => file,
        gear => &mut file[gear],
    }
}

#[cfg(test)]
mod tests;
