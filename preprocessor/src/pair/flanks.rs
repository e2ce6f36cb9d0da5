//! Flanks of the file: modifications, resolved to lengths of roll, topographies from a measuring machine or a design program,
//! and teeth that differ from each other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::checks::{
    Refusal, Refusals, STEEPEST, about, both, check, ensure, every, in_gear, limits, refusal,
    remedy, suspicious,
};
use super::file::{
    EndReliefFile, FlankFile, MM, PairFile, ReliefFile, ReliefStart, ToothErrorsFile, ToothFlank,
    UM, radius_of,
};
use super::mesh::short_tooth;
use super::text;
use crate::gear::tolerance::{CLASSES, random_index_errors};
use crate::storage::csv_reader;
use gearmesh::gear::{
    BothFlanks, EndRelief, Flank, Gear, Microgeometry, OwnFlank, PairGeometry, PairMicrogeometry,
    PairTeeth, ProfileCrowning, ProfileRelief, ProfileSlope, Runout, ToothErrors, Topography,
    WeakTooth,
};
use gearmesh::words::{number, rounded};

/// Modifications and tooth errors of both gears. Files that the file names are sought in `folder`.
pub(super) fn of_pair(
    file: &PairFile,
    geometry: &PairGeometry,
    folder: &Path,
) -> Result<(PairMicrogeometry, PairTeeth), Refusals> {
    let [one, two] = [0, 1].map(|i| Flanks {
        file,
        geometry,
        folder,
        i,
    });
    let [drive, coast] =
        [Flank::Drive, Flank::Coast].map(|flank| both(one.resolved(flank), two.resolved(flank)));
    let ((drive1, drive2), (coast1, coast2)) = both(drive, coast)?;
    let modified = BothFlanks {
        drive: [drive1.0, drive2.0],
        coast: [coast1.0, coast2.0],
    };
    let teeth = BothFlanks {
        drive: [drive1.1, drive2.1],
        coast: [coast1.1, coast2.1],
    };
    Ok((modified, teeth))
}

/// Notes on topographies that may be in another unit: nowhere a tenth of a micrometre.
pub(super) fn notes(
    file: &PairFile,
    modified: &PairMicrogeometry,
    teeth: &PairTeeth,
) -> Vec<String> {
    let mut notes = Vec::new();
    let mut look_at = |path: String, of: &Microgeometry| {
        let Some(grid) = &of.topography else { return };
        let [rolls, zs] = grid.range();
        let [least, largest] = grid.extremes(rolls, zs).map(|place| place[2]);
        let removal = if -least > largest { least } else { largest };
        let um = rounded((removal / UM * 1e9).round() * 1e-9);
        let Some(meant) = suspicious("removal_um", um, 0.1) else {
            return;
        };
        let note = format!(
            "`{path}`: removal_um = {um} at most is a suspicious value: {meant}; give it in the unit of the name"
        );
        // A file of both flanks counts once.
        if !notes.contains(&note) {
            notes.push(note);
        }
    };
    for (flank, name) in [
        (Flank::Drive, "drive_flank."),
        (Flank::Coast, "coast_flank."),
    ] {
        for i in 0..2 {
            let given = file.gear(i);
            let mut own = given.flanks().into_iter();
            let is_own = own.any(|(prefix, own)| prefix == name && own.topography_file.is_some());
            let prefix = if is_own { name } else { "" };
            look_at(
                in_gear(i, prefix) + "topography_file",
                &modified.flank(flank)[i],
            );
            for tooth in &teeth.flank(flank)[i].flanks {
                let mut all = given.tooth_errors.iter().flat_map(|errors| &errors.teeth);
                let Some(place) = all.position(|t| t.tooth == tooth.tooth) else {
                    continue;
                };
                let path = format!("tooth_errors.teeth[{place}].topography_file");
                look_at(in_gear(i, &path), &tooth.microgeometry);
            }
        }
    }
    notes
}

/// Flanks of gear `i`.
struct Flanks<'a> {
    file: &'a PairFile,
    geometry: &'a PairGeometry,
    /// Where files are sought.
    folder: &'a Path,
    i: usize,
}

impl Flanks<'_> {
    fn resolved(&self, flank: Flank) -> Result<(Microgeometry, ToothErrors), Refusals> {
        let modified = self.microgeometry(flank)?;
        let errors = self.tooth_errors(flank, &modified)?;
        Ok((modified, errors))
    }

    fn gear(&self) -> &Gear {
        &self.geometry.gears[self.i]
    }

    /// Lengths of roll at both ends of the active profile, m: from where the mate's tip touches at the nominal centre distance
    /// to the end of this gear's involute at the tip.
    fn active(&self) -> [f64; 2] {
        let g = self.geometry;
        let start = g.active_start_roll(self.i, g.center_distance);
        [start, self.gear().tip_form_roll()]
    }

    /// The same, ascending.
    fn active_range(&self) -> [f64; 2] {
        let [start, end] = self.active();
        [start.min(end), start.max(end)]
    }

    /// Modifications of `flank`, field by field: what it has of its own, else what the gear has for both.
    fn microgeometry(&self, flank: Flank) -> Result<Microgeometry, Refusals> {
        let [(_, common), drive, coast] = self.file.gear(self.i).flanks();
        let (name, own) = if flank == Flank::Drive { drive } else { coast };
        // What is given as this field, and its path.
        macro_rules! given {
            ($field:ident) => {{
                let path = |prefix: &str| in_gear(self.i, prefix) + stringify!($field);
                let own = own.$field.as_ref().map(|value| (path(name), value));
                own.or_else(|| Some((path(""), common.$field.as_ref()?)))
            }};
        }
        // What the flank says of this end, else of both; else what the gear says.
        let ends: [fn(&FlankFile) -> &Option<EndReliefFile>; 2] =
            [|f| &f.lower_end_relief, |f| &f.upper_end_relief];
        let end_relief = ends.map(|end| {
            let [own, common] = [&own, &common].map(|f| end(f).as_ref().or(f.end_relief.as_ref()));
            let relief = own.or(common).filter(|r| r.amount_um > 0.0)?;
            Some(EndRelief {
                amount: relief.amount_um * UM,
                length: relief.length_mm * MM,
                shape: relief.shape,
            })
        });
        let rolls = self.active();
        let slope = ProfileSlope {
            amount: amount(given!(profile_slope_um)),
            bias: amount(given!(bias_um)),
            rolls,
        };
        let crowning = ProfileCrowning {
            amount: amount(given!(profile_crowning_um)),
            rolls,
        };
        let topography = given!(topography_file);
        let topography = topography.map(|(path, csv)| self.topography(csv, &path));
        let reliefs = both(
            self.relief(given!(tip_relief), rolls[1]),
            self.relief(given!(root_relief), rolls[0]),
        );
        let (topography, (tip_relief, root_relief)) = both(topography.transpose(), reliefs)?;
        Ok(Microgeometry {
            topography,
            tip_relief,
            root_relief,
            profile_crowning: (crowning.amount != 0.0).then_some(crowning),
            profile_slope: (slope.amount != 0.0 || slope.bias != 0.0).then_some(slope),
            lead_crowning: amount(given!(lead_crowning_um)),
            lead_slope: amount(given!(lead_slope_um)),
            end_relief,
        })
    }

    /// The relief given with its path, which ends at the length of roll `end_roll`, m; none without an amount.
    fn relief(
        &self,
        given: Option<(String, &ReliefFile)>,
        end_roll: f64,
    ) -> Result<Option<ProfileRelief>, Refusal> {
        let Some((path, r)) = given else {
            return Ok(None);
        };
        let (g, gear) = (self.geometry, self.gear());
        let base = gear.base_radius();
        let tip = gear.tip_form_roll();
        let (form, value, start_roll) = match r.start {
            ReliefStart::PitchPoint => ("", 0.0, g.roll_at(self.i, g.center_distance, 0.0)),
            ReliefStart::DiameterMm(mm) => ("diameter_mm", mm, gear.roll_length(radius_of(mm))),
            ReliefStart::RollLengthMm(mm) => ("roll_length_mm", mm, mm * MM),
            ReliefStart::RollAngleDeg(deg) => ("roll_angle_deg", deg, base * deg.to_radians()),
            ReliefStart::FromTipMm(mm) => ("from_tip_mm", mm, tip - gear.kappa() * mm * MM),
        };
        let shown = match form {
            "" => "pitch_point".to_owned(),
            _ => format!("{{\"{form}\": {value}}}"),
        };
        let [low, high] = self.active_range();
        let diameter = |roll: f64| 2.0 * gear.radius_at_roll(roll) / MM;
        let is_within = start_roll > low && start_roll < high;
        if !is_within {
            let failure = format!("the start of `{path}` is not on the active profile");
            short_tooth(self.file, g, &failure, ", or another start of the relief")?;
        }
        let path = format!("{path}.start");
        // Only of a diameter it is known what is usual.
        let usual = match form {
            "diameter_mm" => about(diameter(0.5 * (low + high))),
            _ => [f64::NAN; 2],
        };
        let remedy = remedy(form, value, usual, "give {\"diameter_mm\": ...} within it");
        ensure!(is_within, path => shown;
            "lies outside the active profile, diameters {:.3} to {:.3} mm, lengths of roll {:.3} to {:.3} mm",
            diameter(low), diameter(high), low / MM, high / MM;
            "{remedy}");
        let (amount, length) = (r.amount_um * UM, (end_roll - start_roll).abs());
        ensure!(amount <= STEEPEST * length, path => shown;
            "leaves {} mm of roll for {} um, steeper than one in ten: a chamfer, and no relief",
            number(rounded(length / MM)), r.amount_um;
            "give a start at least {} mm of roll before the end of the relief, or end the involute there by \
             `tip_form_diameter_mm`", rounded(amount / STEEPEST / MM));
        Ok((amount > 0.0).then_some(ProfileRelief {
            amount,
            start_roll,
            end_roll,
            shape: r.shape,
        }))
    }

    /// The topography in the file `name`, which the field `field` names: CSV with the columns `roll_mm` (or `diameter_mm`),
    /// `z_mm` and `removal_um`, one row for every point of a full grid, in any order.
    fn topography(&self, name: &str, field: &str) -> Result<Topography, Refusal> {
        let (path, gear, active) = (self.folder.join(name), self.gear(), self.active_range());
        let shown = path.display().to_string();
        let text = text::read(&path).map_err(|error| {
            refusal!(field => &shown;
                "cannot be read: {error}"; "give a CSV file beside the pair file, and that you may read")
        })?;
        let most = 0.05 * gear.normal_module;
        let um = rounded(most / UM);
        let limit = format!("more than a twentieth of the normal module, {um} um");
        let grid = grid(&text, gear, 1.5 * most, &limit)
            .map_err(|problem| refusal!(field => &shown; "{problem}"; "{GRID}"))?;
        let ([rolls, zs], face) = (grid.range(), [0.0, gear.face_width]);
        for (name, range, flank) in [("roll_mm", rolls, active), ("z_mm", zs, face)] {
            let covered = range[1].min(flank[1]) - range[0].max(flank[0]);
            let [[first, last], [from, to]] =
                [range, flank].map(|ends| ends.map(|m| rounded((m * 1e6).round() * 1e-3)));
            ensure!(covered >= (1.0 - BEYOND) * (flank[1] - flank[0]), field => &shown;
                "{name} runs from {first} to {last}, and the flank from {from} to {to} mm";
                "give a grid that covers three quarters of the active profile and of the face at least; check its units");
        }
        let bound = grid.largest_removal();
        ensure!(bound <= 1.5 * most, field => &shown;
            "may take off {:.4e} um between its lines, {limit}", bound / UM;
            "give smooth values that jump less from one line to the next");
        let [least, largest] = grid.extremes(active, face);
        let is_least = least[2].abs() > largest[2].abs();
        let [roll, z, removal] = if is_least { least } else { largest };
        let verb = if removal < 0.0 { "adds" } else { "takes off" };
        ensure!(removal.abs() <= 1.5 * most, field => &shown;
            "{verb} {:.4e} um at roll_mm = {:.3}, z_mm = {:.3}, {limit}", removal.abs() / UM, roll / MM, z / MM;
            "give lines at about equal distances, a grid that covers the whole active profile and the whole face, and smooth \
             values that jump from one line to the next");
        Ok(grid)
    }

    /// Tooth errors of `flank`, on which the other teeth have the modifications `nominal`.
    fn tooth_errors(&self, flank: Flank, nominal: &Microgeometry) -> Result<ToothErrors, Refusals> {
        let Some(given) = &self.file.gear(self.i).tooth_errors else {
            return Ok(ToothErrors::default());
        };
        let gear = self.gear();
        let path = in_gear(self.i, "tooth_errors.");
        limits! { path, given;
            runout_um: [0.0, largest(gear)];
            runout_angle_deg: [-360.0, 360.0];
        }?;
        let mut errors = ToothErrors {
            index: index(given, gear, flank, &path)?,
            runout: (given.runout_um > 0.0).then(|| Runout {
                amount: given.runout_um * UM,
                angle: given.runout_angle_deg.to_radians(),
            }),
            ..ToothErrors::default()
        };
        let other = match flank {
            Flank::Drive => ToothFlank::Coast,
            Flank::Coast => ToothFlank::Drive,
        };
        for (place, own) in given.teeth.iter().enumerate() {
            let (path, tooth) = (format!("{path}teeth[{place}]."), own.tooth);
            check(
                &format!("{path}tooth"),
                f64::from(tooth),
                [0.0, gear.z() - 1.0],
            )?;
            let is_again = given.teeth[..place].iter().any(|t| t.tooth == tooth);
            ensure!(!is_again, format!("{path}tooth") => tooth;
                "stands in the list twice"; "give a tooth once, with all that is its own");
            limits! { path, own; compliance_factor: [1.0, LARGEST_FACTOR]; }?;
            let factor = own.compliance_factor;
            if factor > 1.0 {
                errors.weak.push(WeakTooth { tooth, factor });
            }
            let file = own.topography_file.as_ref();
            if let Some(file) = file.filter(|_| own.flank != other) {
                let topography = self.topography(file, &format!("{path}topography_file"))?;
                let mut microgeometry = nominal.clone();
                microgeometry.topography = Some(topography);
                errors.flanks.push(OwnFlank {
                    tooth,
                    microgeometry,
                });
            }
        }
        Ok(errors)
    }
}

/// The amount given in micrometres beside its path, m; none is 0.
fn amount(given: Option<(String, &f64)>) -> f64 {
    given.map_or(0.0, |(_, um)| um * UM)
}

/// Share of the active profile or of the face that may lie beyond the grid, where its tangents go on.
const BEYOND: f64 = 0.25;

/// What a topography is to be.
const GRID: &str = "give CSV with a header and commas between its columns, roll_mm (or diameter_mm), z_mm and removal_um \
    (normal to the flank), numbers with a decimal point, and one row for every point of a full grid of at least 3 x 3 points on involute and face";

/// The grid in `text`, or what is wrong with it: to remove more than `most` (m) is more than `limit` says.
fn grid(text: &str, gear: &Gear, most: f64, limit: &str) -> Result<Topography, String> {
    let mut reader = csv_reader(text);
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    let [roll, diameter, z, removal] = ["roll_mm", "diameter_mm", "z_mm", "removal_um"]
        .map(|name| header.iter().position(|h| h == name));
    let (Some(along_column), Some(z), Some(removal)) = (roll.or(diameter), z, removal) else {
        let found = header.iter().collect::<Vec<_>>().join(",");
        return Err(match found.contains(';') {
            true => "has semicolons between its columns".into(),
            false => format!("has the columns {found}"),
        });
    };
    let place = |roll_length: f64, z: f64| {
        let along = match roll {
            Some(_) => roll_length,
            None => 2.0 * gear.radius_at_roll(roll_length),
        };
        let [along_mm, z] = [along, z].map(|m| rounded((m * 1e9).round() * 1e-6));
        format!("{} = {along_mm}, z_mm = {z}", &header[along_column])
    };
    // Sorted by the bits of numbers that are not negative.
    let mut rows: BTreeMap<[u64; 2], f64> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |column: usize| {
            let (name, cell) = (&header[column], record.get(column).unwrap_or(""));
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| format!("line {line}: {name} = {cell}: not a finite number"))
        };
        let (along_mm, z_mm, um) = (number(along_column)?, number(z)?, number(removal)?);
        let (along, z, removal) = (along_mm * MM, z_mm * MM, um * UM);
        let roll = roll.map_or_else(|| gear.roll_length(0.5 * along), |_| along);
        if !(roll >= 0.0 && z >= 0.0) {
            let (name, base) = (&header[along_column], 2.0 * gear.base_radius() / MM);
            return Err(format!(
                "line {line}: {name} = {along_mm}, z_mm = {z_mm}: outside of involute and face, which begin at the base circle, \
                 {base:.3} mm in diameter, and at z = 0"
            ));
        }
        // Added material counts on the active flank alone, which is seen later.
        if removal > most {
            return Err(format!("line {line}: removal_um = {um} takes off {limit}"));
        }
        let point = [roll + 0.0, z + 0.0].map(f64::to_bits);
        if rows.insert(point, removal).is_some() {
            let place = place(roll, z);
            return Err(format!(
                "line {line}: {place} stands in an earlier line, too"
            ));
        }
    }
    let [rolls, zs] = [0, 1].map(|k| {
        let values: BTreeSet<u64> = rows.keys().map(|key| key[k]).collect();
        values.into_iter().map(f64::from_bits).collect::<Vec<_>>()
    });
    let (points, lines) = (rows.len(), [rolls.len(), zs.len()]);
    if points == 0 || points != lines[0] * lines[1] {
        let mut all = (rolls.iter()).flat_map(|&roll| zs.iter().map(move |&z| [roll, z]));
        let missing = all.find(|point| !rows.contains_key(&point.map(f64::to_bits)));
        let missing = missing.map_or_else(String::new, |[roll, z]| {
            format!("; {} is missing", place(roll, z))
        });
        return Err(format!(
            "has {points} points, and {} x {} lines{missing}",
            lines[0], lines[1]
        ));
    }
    if lines.iter().any(|count| *count < 3) {
        return Err(format!("has {} x {} lines", lines[0], lines[1]));
    }
    let removal: Vec<f64> = rows.into_values().collect();
    let removal = removal.chunks(lines[1]).map(<[f64]>::to_vec).collect();
    Topography::new(rolls, zs, removal).map_err(|error| error.to_string())
}

/// Largest compliance factor: a tooth that is all but gone.
const LARGEST_FACTOR: f64 = 100.0;

/// Largest index error and run-out, um.
fn largest(gear: &Gear) -> f64 {
    0.05 * gear.normal_module / UM
}

/// Index errors of the flank, m.
fn index(
    given: &ToothErrorsFile,
    gear: &Gear,
    flank: Flank,
    path: &str,
) -> Result<Vec<f64>, Refusals> {
    let (part, given) = match flank {
        Flank::Drive => ("drive_flank", &given.drive_flank),
        Flank::Coast => ("coast_flank", &given.coast_flank),
    };
    let Some(given) = given else {
        return Ok(Vec::new());
    };
    let (path, most) = (format!("{path}{part}"), largest(gear));
    let (list, class) = (&given.cumulative_pitch_um, given.pitch_class);
    let problem = match (list, class) {
        (Some(list), None) => {
            let path = format!("{path}.cumulative_pitch_um");
            ensure!(list.len() == gear.teeth as usize, path => format!("{} numbers", list.len());
                "the gear has {} teeth", gear.teeth; "give one number for every tooth");
            every(
                list.iter()
                    .enumerate()
                    .map(|(tooth, um)| check(&format!("{path}[{tooth}]"), *um, [-most, most])),
            )?;
            let are_zero = list.iter().all(|um| *um == 0.0);
            let errors = list.iter().filter(|_| !are_zero).map(|um| um * UM);
            return Ok(errors.collect());
        }
        (None, Some(class)) => {
            let path = format!("{path}.pitch_class");
            let classes = [*CLASSES.start(), *CLASSES.end()].map(f64::from);
            check(&path, f64::from(class), classes)?;
            let errors = random_index_errors(gear, class, given.seed);
            let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.abs())) / UM;
            ensure!(largest <= most, path => class;
                "gives index errors above a twentieth of the normal module, {} um", rounded(most);
                "give a finer class");
            return Ok(errors);
        }
        (Some(_), Some(_)) => {
            "`cumulative_pitch_um` and `pitch_class` both say what the errors are"
        }
        (None, None) => "says nothing of the errors",
    };
    let value = if list.is_some() { "two sources" } else { "{}" };
    Err(refusal!(path => value; "{problem}";
        "give `cumulative_pitch_um`, one number for every tooth, or `pitch_class` with a `seed`")
    .into())
}
