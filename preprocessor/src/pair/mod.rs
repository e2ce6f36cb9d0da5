//! The pair file: from a drawing in JSON to a checked gear pair in SI.
//!
//! [`from_json`] knows every field (docs/pair-file.md), fills in the defaults and refuses what cannot work, naming field,
//! value and remedy ([`Refusal`]). What is legal but worth knowing comes as [`Pair::warnings`].

mod checks;
pub mod drawing;
mod file;
mod flanks;
mod gears;
mod mesh;
mod modifications;
mod shafts;
mod text;

use std::path::{Path, PathBuf};

pub use checks::{Refusal, TORQUES};
pub use drawing::Gauges;
pub use gears::ASSUMED_HELD;
pub use mesh::LARGEST_DEFLECTION;
pub use modifications::{modifications, topographies, topography};
pub use text::PairError;

use checks::{LARGEST_MISALIGNMENT, LEAST_HELIX, ensure, in_gear, limits, refusal, suspicious};
use file::{FrictionFile, FrictionLawFile, PairFile, UM};
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::{PairGeometry, PairTeeth};
use gearmesh::pair::{Operating, Pair, Shaft};
use serde_json::Value;

use crate::shaft::misalignment_range;

/// Reads and checks the text of a pair file: JSON in which comments (`//`, `/* */`, `#`), commas before a
/// closing bracket and a byte-order mark are allowed. Files it names are sought in the working folder.
///
/// # Errors
/// [`PairError::Form`] for text of another form (unknown, missing or mistyped field),
/// [`PairError::Refused`] for a pair that cannot work.
pub fn from_json(text: &str) -> Result<Pair, PairError> {
    let file = text::parse(text)?;
    Ok(resolve(&file, Path::new(""))?)
}

/// Reads and checks the pair file at `path`. Files it names are sought in its folder.
///
/// # Errors
/// [`PairError::Read`] when the file cannot be read, else as [`from_json`].
pub fn read(path: impl AsRef<Path>) -> Result<Pair, PairError> {
    Ok(read_with_gauges(path)?.0)
}

/// The pair as [`read`] gives it, and with what the tooth thickness of each gear is measured: what the file names, else what
/// is usual.
///
/// # Errors
/// Those of [`read`].
pub fn read_with_gauges(path: impl AsRef<Path>) -> Result<(Pair, [Gauges; 2]), PairError> {
    let path = path.as_ref();
    let file = text::read_fields(path)?;
    let pair = resolve(&file, folder(path))?;
    let gauges = [0, 1].map(|i| Gauges::of(file.gear(i), &pair.geometry.gears[i]));
    Ok((pair, gauges))
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Fills in defaults, checks, converts. Files that the file names are sought in `folder`.
fn resolve(file: &PairFile, folder: &Path) -> Result<Pair, Refusal> {
    checks::check_fields(file)?;
    let helix = drawing::helix(file)?;
    let geometry = PairGeometry {
        gears: [
            drawing::gear(file, 0, helix)?,
            drawing::gear(file, 1, helix)?,
        ],
        center_distance: f64::NAN,
    };
    resolve_gears(file, helix, geometry, folder).map_err(|refusal| {
        // A helix angle in radians spoils anything.
        match suspicious("helix_angle_deg", helix, LEAST_HELIX) {
            Some(meant) => refusal!("helix_angle_deg" => helix;
                "fits nothing (`{}` = {}: {})", refusal.field, refusal.value, refusal.problem; "check it: {meant}"),
            None => refusal,
        }
    })
}

/// `geometry` is yet without centre distance, backlash and bodies, `helix` the helix angle on gear 1, degrees.
fn resolve_gears(
    file: &PairFile,
    helix: f64,
    mut geometry: PairGeometry,
    folder: &Path,
) -> Result<Pair, Refusal> {
    let mut notes = Vec::new();
    if let Some(ring) = file.ring() {
        let (teeth, mate) = (file.gear(ring).teeth, file.gear(1 - ring).teeth);
        ensure!(teeth > mate, in_gear(ring, "teeth") => teeth;
            "the ring needs more teeth than the gear in it, {mate}";
            "choose a larger tooth difference, or give `rim_diameter_mm` to the other gear");
    }
    drawing::set_center_distance(file, &mut geometry)?;
    notes.extend(drawing::set_backlash(file, &mut geometry)?);
    for (i, gear) in geometry.gears.iter_mut().enumerate() {
        notes.extend(gears::shrink_default_round(file.gear(i), gear, i));
    }
    notes.extend(mesh::shorten_default_ring(file, &mut geometry)?);
    let [a, b] = &geometry.gears;
    let profiles = [gears::profile(file, a, 0)?, gears::profile(file, b, 1)?];
    for (i, gear) in geometry.gears.iter_mut().enumerate() {
        gears::add_body(file.gear(i), gear, i)?;
    }
    notes.extend(mesh::check_faces(file, &geometry)?);
    notes.extend(mesh::check_torques(file, &geometry)?);
    notes.extend(checks::notes(file, helix));
    notes.extend((0..2).filter_map(|i| gears::small_bore(&geometry, i)));
    notes.extend(gears::default_held(file, &geometry));
    notes.extend(drawing::odd_thickness(file, &geometry));
    notes.extend(mesh::warnings(&geometry, &profiles));
    notes.extend(mesh::check_center_distances(file, &geometry, &profiles)?);
    mesh::check_tooth_difference(&geometry)?;
    let (microgeometry, teeth) = flanks::of_pair(file, &geometry, folder)?;
    notes.extend(note_on_teeth(&teeth).map(str::to_owned));
    let shafts = shafts::of_pair(file, &geometry)?;
    let misalignment = misalignment(file, &geometry, &shafts)?;
    if shafts.iter().any(Option::is_some) {
        notes.push(NOTE_ON_SHAFTS.into());
    }
    Ok(Pair {
        name: file.name.clone(),
        teeth,
        operating: Operating {
            nominal_torque: file.operating.nominal_torque_nm,
            maximum_torque: file.operating.maximum_torque_nm,
            center_distance_offset: file.operating.center_distance_offset_um.map(|v| v * UM),
            misalignment,
        },
        refinement: file.compliance.refinement,
        tip_corner_contact: file.tip_corner_contact,
        friction: friction(file.friction.as_ref())?,
        warnings: notes,
        shafts,
        geometry,
        microgeometry,
    })
}

/// Where shafts on bearings count, and where they must not count twice.
const NOTE_ON_SHAFTS: &str = "shafts on bearings: solve, report and study take them into account; tables and FMU end at the gears, whose \
                              shafts and bearings belong to the multibody model";

/// The range of misalignment, rad: that of the file, else what the shafts cause.
fn misalignment(
    file: &PairFile,
    geometry: &PairGeometry,
    shafts: &[Option<Shaft>; 2],
) -> Result<[f64; 2], Refusal> {
    if let Some(range) = file.operating.misalignment_mrad {
        return Ok(range.map(|mrad| mrad * 1e-3));
    }
    let field = "operating.misalignment_mrad";
    let range = misalignment_range(geometry, shafts, file.operating.maximum_torque_nm);
    let range = range.ok_or_else(|| {
        refusal!(field => "none"; "this field is required where no gear has a shaft on bearings";
            "give [lowest, highest], such as [-0.5, 0.5], or `shaft` with `sections` and `bearings`")
    })?;
    let largest = 1e3 * range[0].abs().max(range[1]);
    ensure!(largest <= LARGEST_MISALIGNMENT, field => "none";
        "the shafts on bearings tilt the gears by up to {largest:.1} mrad, beyond {LARGEST_MISALIGNMENT}";
        "check diameters, lengths and stiffnesses of `shaft`");
    Ok(range)
}

/// What is to be known of results that take all `teeth` as alike; `None` where they are. It is one of the [`Pair::warnings`],
/// too.
pub fn note_on_teeth(teeth: &PairTeeth) -> Option<&'static str> {
    let text = "the teeth differ (`tooth_errors`): solve, report, study and tables take them as all alike, with the nominal flanks; \
                `stiffnessModel = teeth` of an FMU built with --teeth takes index errors and run-out, `contact` of one built with \
                --contact all of them";
    (!teeth.are_alike()).then_some(text)
}

/// X_L of a mineral gear oil: see [`FrictionLaw::Schlenk`].
const MINERAL_OIL: f64 = 0.846;

/// The law of friction that `file` gives, or the default.
fn friction(file: Option<&FrictionFile>) -> Result<FrictionLaw, Refusal> {
    let Some(file) = file else {
        return Ok(FrictionLaw::default());
    };
    limits! { "friction.", file;
        coefficient: [0.0, 1.0];
        dynamic_viscosity_mpa_s: [1.01, 1e5];
        lubricant_factor: [0.1, 2.0];
    }
    for ra in file.roughness_ra_um.into_iter().flatten() {
        checks::check("friction.roughness_ra_um", ra, [0.01, 20.0])?;
    }
    if file.law == FrictionLawFile::Constant {
        let constant = |coefficient| FrictionLaw::Constant { coefficient };
        return Ok(file.coefficient.map(constant).unwrap_or_default());
    }
    let missing = |name: &str, remedy: &str| {
        refusal!(format!("friction.{name}") => "none";
            "this law asks for it"; "{remedy}, or leave `law` at `constant`")
    };
    let viscosity = file.dynamic_viscosity_mpa_s.ok_or_else(|| {
        let remedy = "give the dynamic viscosity at the temperature of the oil";
        missing("dynamic_viscosity_mpa_s", remedy)
    })?;
    let ra = (file.roughness_ra_um)
        .ok_or_else(|| missing("roughness_ra_um", "give Ra of both gears as a list of two"))?;
    let (viscosity, ra) = (1e-3 * viscosity, ra.map(|ra| ra * UM));
    Ok(match file.law {
        FrictionLawFile::XuKahraman => FrictionLaw::xu_kahraman(viscosity, ra),
        _ => FrictionLaw::schlenk(viscosity, ra, file.lubricant_factor.unwrap_or(MINERAL_OIL)),
    })
}

/// The fields of a pair file before they are checked.
#[derive(Debug, Clone)]
pub struct PairDraft {
    fields: Value,
    folder: PathBuf,
}

impl PairDraft {
    /// Reads the pair file at `path`.
    ///
    /// # Errors
    /// Those of [`read`], but for what makes a pair that cannot work.
    pub fn read(path: &Path) -> Result<PairDraft, PairError> {
        let fields = serde_json::to_value(text::read_fields(path)?);
        Ok(PairDraft {
            // Numbers, text and lists under names: they are values of JSON.
            fields: fields.expect("a pair file serialises"),
            folder: folder(path).to_owned(),
        })
    }

    /// The number at `field`, such as `gear1.tip_relief.amount_um`; the middle of limits; None where there is none.
    pub fn number(&self, field: &str) -> Option<f64> {
        let path = format!("/{}", field.replace('.', "/"));
        let value = self.fields.pointer(&path)?;
        let limit = |i: usize| value.get(i)?.as_f64();
        (value.as_f64()).or_else(|| Some(0.5 * (limit(0)? + limit(1)?)))
    }

    /// Sets `field` to `value`, in the unit of its name; groups of fields on the way to it are made.
    ///
    /// # Errors
    /// [`PairError::Refused`] where something else than a group of fields stands on the way.
    pub fn set(&mut self, field: &str, value: f64) -> Result<(), PairError> {
        let mut at = &mut self.fields;
        let names: Vec<&str> = field.split('.').collect();
        for (i, name) in names.iter().enumerate() {
            if let Value::Array(list) = at {
                let group = names[..i].join(".");
                let count = list.len();
                at = (name.parse::<usize>().ok())
                    .and_then(|k| list.get_mut(k))
                    .ok_or_else(|| {
                        refusal!(group => format!("a list of {count}"); "there is no `{name}` in it";
                            "give a number of it, from 0 on")
                    })?;
                continue;
            }
            // One form of a relief's start takes the place of another.
            if at.is_null() || i > 0 && names[i - 1] == "start" {
                *at = Value::Object(serde_json::Map::new());
            }
            let Some(fields) = at.as_object_mut() else {
                let group = names[..i].join(".");
                return Err(refusal!(group => "no group of fields";
                    "there is no `{name}` in it"; "docs/pair-file.md has every field")
                .into());
            };
            at = fields.entry(*name).or_insert(Value::Null);
        }
        *at = value.into();
        Ok(())
    }

    /// Gives the pair another name.
    pub fn rename(&mut self, name: &str) {
        self.fields["name"] = name.into();
    }

    /// The text of a pair file with these fields, for any folder: files that it names stand with their whole path.
    pub fn to_json(&self) -> String {
        fn kept(value: &Value, folder: &Path) -> Value {
            let field = |(name, value): (&String, &Value)| match value {
                Value::Null => None,
                Value::String(file) if name.ends_with("_file") => {
                    let path = std::path::absolute(folder.join(file)).unwrap_or(file.into());
                    Some((name.clone(), path.to_string_lossy().into()))
                }
                value => Some((name.clone(), kept(value, folder))),
            };
            match value {
                Value::Object(fields) => Value::Object(fields.iter().filter_map(field).collect()),
                Value::Array(values) => values.iter().map(|value| kept(value, folder)).collect(),
                value => value.clone(),
            }
        }
        format!("{:#}\n", kept(&self.fields, &self.folder))
    }

    /// The checked pair.
    ///
    /// # Errors
    /// Those of [`from_json`].
    pub fn pair(&self) -> Result<Pair, PairError> {
        let file = text::parse(&self.fields.to_string())?;
        Ok(resolve(&file, &self.folder)?)
    }
}

#[cfg(test)]
mod tests;
