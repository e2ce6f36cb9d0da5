//! The pair file: from a drawing in JSON to a checked gear pair in SI.
//!
//! [`from_json`] knows every field (docs/pair-file.md), fills in the defaults and refuses what cannot work, naming field,
//! value and remedy ([`Refusal`]); all that can be found come at once. What is legal but worth knowing comes as [`Pair::warnings`].

mod bodies;
mod body_matrix;
mod checks;
mod dimension;
pub mod drawing;
mod file;
mod flanks;
mod gears;
mod matrix_market;
mod mesh;
mod misformed;
mod modifications;
mod shafts;
mod signs;
mod temperature;
mod text;

use std::path::{Path, PathBuf};

pub use checks::{
    LARGEST_CENTER_DISTANCE_OFFSET, LARGEST_MISALIGNMENT, Refusal, Refusals, TORQUES,
};
pub use drawing::Gauges;
pub use gears::ASSUMED_HELD;
pub(crate) use gears::default_held_radius;
pub use mesh::{LARGEST_DEFLECTION, notes_on_offset};
pub use modifications::{modifications, topographies, topography};
pub use text::PairError;

use crate::gear::{Operating, Pair, Shaft};
use checks::{LEAST_HELIX, both, ensure, every, in_gear, limits, refusal, suspicious};
use file::{FrictionFile, FrictionLawFile, PairFile, UM};
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::{Gear, GearKind, PairGeometry, PairTeeth};
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
    let sizes = signs::without(&file)?;
    let gauges = [0, 1].map(|i| Gauges::of(sizes.gear(i), &pair.geometry.gears[i]));
    Ok((pair, gauges))
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Fills in defaults, checks, converts. Files that the file names are sought in `folder`.
fn resolve(file: &PairFile, folder: &Path) -> Result<Pair, Refusals> {
    let sizes = signs::without(file)?;
    resolve_sizes(&sizes, folder)
        .map_err(|refusals| refusals.map(|refusal| signs::as_given(file, refusal)))
}

/// The pair of a file without the signs of ISO 21771.
fn resolve_sizes(file: &PairFile, folder: &Path) -> Result<Pair, Refusals> {
    let fields = both(
        checks::check_fields(file),
        temperature::check_fields(file).map_err(Refusals::from),
    );
    let (fields, friction) = (fields.err(), friction(file.friction.as_ref()));
    let helix = drawing::helix(file)?;
    let alone = match fields {
        None => both(gear_alone(file, 0, helix), gear_alone(file, 1, helix)),
        Some(refusals) => Err(refusals),
    };
    // Of gears whose own fields and those of the pair are right, what else is wrong is known, too.
    let alone = alone.map_err(|refusals| {
        let sound =
            (0..2).filter(|i| (refusals.all().iter()).all(|r| concerns_others(*i, &r.field)));
        let profiles = sound.map(|i| check_profile(file, &gear_alone(file, i, helix)?.0, i));
        let more = every(profiles).err();
        more.into_iter().fold(refusals, Refusals::and)
    });
    let resolved = both(alone, friction)
        .and_then(|(alone, friction)| resolve_pair(file, helix, alone, friction, folder));
    resolved.map_err(|refusals| {
        // A helix angle in radians spoils anything.
        let first = &refusals.all()[0];
        let on_helix = suspicious("helix_angle_deg", helix, LEAST_HELIX).map(|meant| {
            refusal!("helix_angle_deg" => helix;
                "fits nothing (`{}` = {}: {})", first.field, first.value, first.problem; "check it: {meant}")
        });
        on_helix.map_or(refusals, Refusals::from)
    })
}

/// Whether a refusal of `field` leaves gear `i` as it is.
fn concerns_others(i: usize, field: &str) -> bool {
    let mate = in_gear(1 - i, "");
    let others = [
        "name",
        "operating.",
        "friction.",
        "backlash_um",
        "normal_backlash_um",
        &mate,
    ];
    others.iter().any(|start| field.starts_with(start))
}

/// A gear before it is in mesh: without a body and as its own fields have it, with a note on a smaller round of its tool.
type Alone = (Gear, Option<String>);

/// Gear `i` with a helix angle of `helix` degrees on gear 1.
fn gear_alone(file: &PairFile, i: usize, helix: f64) -> Result<Alone, Refusals> {
    let mut gear = drawing::gear(file, i, helix)?;
    let note = gears::shrink_default_round(file.gear(i), &mut gear, i);
    Ok((gear, note))
}

/// Checks the profile of `gear`, but for default tips of a ring, which may still be shortened.
fn check_profile(file: &PairFile, gear: &Gear, i: usize) -> Result<(), Refusals> {
    if gear.kind == GearKind::External || !file.gear(i).has_default_tip() {
        gears::profile(file, gear, i)?;
    }
    Ok(())
}

/// The pair of `gears`, the helix angle on gear 1 being `helix`, degrees.
fn resolve_pair(
    file: &PairFile,
    helix: f64,
    gears: (Alone, Alone),
    friction: FrictionLaw,
    folder: &Path,
) -> Result<Pair, Refusals> {
    let ((gear1, note1), (gear2, note2)) = gears;
    let mut geometry = PairGeometry {
        gears: [gear1, gear2],
        center_distance: f64::NAN,
    };
    let meshing = in_mesh(file, &mut geometry);
    let gears = geometry.gears.iter().enumerate();
    let profiles = every(gears.map(|(i, gear)| check_profile(file, gear, i)));
    let loads = both(
        mesh::check_faces(file, &geometry),
        mesh::check_torques(file, &geometry),
    );
    let (odd_backlash, (_, (mut notes, load_notes))) = both(meshing, both(profiles, loads))?;
    notes.extend([odd_backlash, note1, note2].into_iter().flatten());
    notes.extend(mesh::shorten_default_ring(file, &mut geometry)?);
    // Tips of a ring that were inside of its base circle hid that the round does not fit.
    let rounds = geometry.gears.iter_mut().enumerate();
    notes.extend(rounds.filter_map(|(i, gear)| gears::shrink_default_round(file.gear(i), gear, i)));
    let [one, two] = &mut geometry.gears;
    let ((profile1, profile2), _) = both(
        both(gears::profile(file, one, 0), gears::profile(file, two, 1)),
        both(
            gears::add_body(&file.gear1, one, 0),
            gears::add_body(&file.gear2, two, 1),
        ),
    )?;
    let profiles = [profile1, profile2];
    notes.extend(load_notes);
    notes.extend(checks::notes(file, helix));
    notes.extend(temperature::note(file));
    notes.extend((0..2).filter_map(|i| gears::small_bore(&geometry, i)));
    notes.extend(gears::default_held(file, &geometry));
    notes.extend(drawing::odd_thickness(file, &geometry));
    notes.extend(mesh::warnings(&geometry, &profiles));
    let meshing = mesh::check_center_distances(file, &geometry, &profiles)
        .and_then(|notes| mesh::check_tooth_difference(&geometry).map(|()| notes));
    let (in_mesh, ((flanks, bodies), shafts)) = both(
        meshing,
        both(
            both(
                flanks::of_pair(file, &geometry, folder),
                bodies::of_pair(file, &geometry, folder),
            ),
            shafts::of_pair(file, &geometry),
        ),
    )?;
    notes.extend(in_mesh);
    let (mut microgeometry, teeth) = flanks;
    notes.extend(flanks::notes(file, &microgeometry, &teeth));
    temperature::expand(file, &mut geometry, &mut microgeometry)?;
    mesh::check_warm(file, &geometry, &mut notes)?;
    notes.extend(note_on_teeth(&teeth).map(str::to_owned));
    let misalignment = misalignment(file, &geometry, &shafts)?;
    if shafts.iter().any(Option::is_some) {
        notes.push(NOTE_ON_SHAFTS.into());
    }
    notes.extend(shafts::note(file, &geometry, &shafts));
    if bodies.iter().any(Option::is_some) {
        notes.push(NOTE_ON_BODIES.into());
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
        friction,
        warnings: notes,
        shafts,
        bodies,
        geometry,
        microgeometry,
    })
}

/// Where bodies count that are no solids of revolution.
const NOTE_ON_BODIES: &str = "a body is no solid of revolution: `solve --revolution` and `report` follow it over a turn, FMUs with `bodyEffect`; all \
                              other results are those of its mean over all angles; root stress knows no holes and a ring that is held all around";

/// Sets centre distance and backlash; a note on profile shifts that do not fit.
fn in_mesh(file: &PairFile, geometry: &mut PairGeometry) -> Result<Option<String>, Refusal> {
    if let Some(ring) = file.ring() {
        let [teeth, mate] = [ring, 1 - ring].map(|i| file.gear(i).number_of_teeth());
        ensure!(teeth > mate, in_gear(ring, "teeth") => teeth;
            "the ring needs more teeth than the gear in it, {mate}";
            "choose a larger tooth difference, or give `rim_diameter_mm` to the other gear");
    }
    drawing::set_center_distance(file, geometry)?;
    drawing::set_backlash(file, geometry)
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

/// Refusal of a law of friction that needs the field `name`, which is not there.
fn missing(name: &str, remedy: &str) -> Refusal {
    refusal!(format!("friction.{name}") => "none";
        "this law asks for it"; "{remedy}, or leave `law` at `constant`")
}

/// The law of friction that `file` gives, or the default.
fn friction(file: Option<&FrictionFile>) -> Result<FrictionLaw, Refusals> {
    let Some(file) = file else {
        return Ok(FrictionLaw::default());
    };
    limits! { "friction.", file;
        coefficient: [0.0, 1.0];
        dynamic_viscosity_mpa_s: [1.01, 1e5];
        lubricant_factor: [0.1, 2.0];
    }?;
    for ra in file.roughness_ra_um.into_iter().flatten() {
        checks::check("friction.roughness_ra_um", ra, [0.01, 20.0])?;
    }
    if file.law == FrictionLawFile::Constant {
        return Ok(file
            .coefficient
            .map(|coefficient| FrictionLaw::Constant { coefficient })
            .unwrap_or_default());
    }
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

    fn value(&self, field: &str) -> Option<&Value> {
        self.fields
            .pointer(&format!("/{}", field.replace('.', "/")))
    }

    /// The number at `field`, such as `gear1.tip_relief.amount_um`; the middle of limits; None where there is none.
    pub fn number(&self, field: &str) -> Option<f64> {
        self.value(field)?
            .as_f64()
            .or_else(|| self.limits(field).map(|[low, high]| 0.5 * (low + high)))
    }

    /// The limits at `field`; None where there are none.
    pub fn limits(&self, field: &str) -> Option<[f64; 2]> {
        let value = self.value(field)?;
        Some([value.get(0)?.as_f64()?, value.get(1)?.as_f64()?])
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
                        Refusals::from(refusal!(group => format!("a list of {count}");
                            "there is no `{name}` in it"; "give a number of it, from 0 on"))
                    })?;
                continue;
            }
            // One form of a relief's start takes the place of another.
            if at.is_null() || i > 0 && names[i - 1] == "start" {
                *at = Value::Object(serde_json::Map::new());
            }
            let Some(fields) = at.as_object_mut() else {
                let group = names[..i].join(".");
                return Err(Refusals::from(refusal!(group => "no group of fields";
                    "there is no `{name}` in it"; "docs/pair-file.md has every field"))
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
            match value {
                Value::Object(fields) => {
                    let fields = fields.iter().filter_map(|(name, value)| match value {
                        Value::Null => None,
                        Value::String(file) if name.ends_with("_file") => {
                            let path =
                                std::path::absolute(folder.join(file)).unwrap_or(file.into());
                            Some((name.clone(), path.to_string_lossy().into()))
                        }
                        value => Some((name.clone(), kept(value, folder))),
                    });
                    Value::Object(fields.collect())
                }
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
        let file = text::parse_fields(&self.fields)?;
        Ok(resolve(&file, &self.folder)?)
    }
}

#[cfg(test)]
mod tests;
