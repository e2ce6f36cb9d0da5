//! Flanks of the file: modifications, resolved to lengths of roll, and topographies from a measuring machine or a design
//! program.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use super::checks::{STEEPEST, in_gear, meant_about, remedy};
use super::error::{Refusal, ensure, refusal};
use super::file::{EndReliefFile, FlankFile, MM, PairFile, ReliefFile, ReliefStart, UM};
use super::mesh::short_tooth;
use super::text;
use gearmesh::gear::{
    EndRelief, Flank, Gear, Microgeometry, PairGeometry, ProfileCrowning, ProfileRelief,
    ProfileSlope, Topography,
};
use gearmesh::words::{number, rounded};

/// Flanks of gear `i`.
pub(super) struct Flanks<'a> {
    pub file: &'a PairFile,
    pub geometry: &'a PairGeometry,
    /// Where files are sought.
    pub folder: &'a Path,
    pub i: usize,
}

impl Flanks<'_> {
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

    /// Modifications of `flank`, field by field: what it has of its own, else what the gear has for both.
    pub fn microgeometry(&self, flank: Flank) -> Result<Microgeometry, Refusal> {
        let given = self.file.gear(self.i);
        let (name, own) = match flank {
            Flank::Drive => ("drive_flank.", &given.drive_flank),
            Flank::Coast => ("coast_flank.", &given.coast_flank),
        };
        let sources = [
            (name, own.clone().unwrap_or_default()),
            ("", given.modifications()),
        ];
        let path = |prefix: &str, name: &str| in_gear(self.i, &format!("{prefix}{name}"));
        let rolls = self.active();
        let relief = |field: fn(&FlankFile) -> &Option<ReliefFile>, name: &str, end: f64| {
            let mut all = sources.iter();
            match all.find_map(|(prefix, f)| Some((prefix, field(f).as_ref()?))) {
                Some((prefix, relief)) => self.relief(relief, &path(prefix, name), end),
                None => Ok(None),
            }
        };
        let um = |field: fn(&FlankFile) -> Option<f64>| {
            sources.iter().find_map(|(_, f)| field(f)).unwrap_or(0.0) * UM
        };
        let end = |field: fn(&FlankFile) -> &Option<EndReliefFile>| {
            let mut all = sources.iter();
            let relief = all.find_map(|(_, f)| field(f).as_ref().or(f.end_relief.as_ref()));
            let relief = relief.map(|r| EndRelief {
                amount: r.amount_um * UM,
                length: r.length_mm * MM,
                shape: r.shape,
            });
            relief.filter(|r| r.amount > 0.0)
        };
        let (crowning, slope, bias) = (
            um(|f| f.profile_crowning_um),
            um(|f| f.profile_slope_um),
            um(|f| f.bias_um),
        );
        let mut files = sources.iter();
        let file = files.find_map(|(prefix, f)| Some((prefix, f.topography_file.as_ref()?)));
        Ok(Microgeometry {
            tip_relief: relief(|f| &f.tip_relief, "tip_relief", rolls[1])?,
            root_relief: relief(|f| &f.root_relief, "root_relief", rolls[0])?,
            profile_crowning: (crowning != 0.0).then_some(ProfileCrowning {
                amount: crowning,
                rolls,
            }),
            profile_slope: (slope != 0.0 || bias != 0.0).then_some(ProfileSlope {
                amount: slope,
                bias,
                rolls,
            }),
            lead_crowning: um(|f| f.lead_crowning_um),
            lead_slope: um(|f| f.lead_slope_um),
            end_relief: [end(|f| &f.lower_end_relief), end(|f| &f.upper_end_relief)],
            topography: file
                .map(|(prefix, name)| self.topography(name, &path(prefix, "topography_file")))
                .transpose()?,
        })
    }

    /// The relief at `path` that ends at the length of roll `end_roll`, m; none without an amount.
    fn relief(
        &self,
        r: &ReliefFile,
        path: &str,
        end_roll: f64,
    ) -> Result<Option<ProfileRelief>, Refusal> {
        let (g, gear) = (self.geometry, self.gear());
        let (form, value, start_roll) = match r.start {
            ReliefStart::PitchPoint => ("", 0.0, g.roll_at(self.i, g.center_distance, 0.0)),
            ReliefStart::DiameterMm(mm) => ("diameter_mm", mm, gear.roll_length(0.5 * mm * MM)),
            ReliefStart::RollLengthMm(mm) => ("roll_length_mm", mm, mm * MM),
            ReliefStart::RollAngleDeg(deg) => {
                ("roll_angle_deg", deg, gear.base_radius() * deg.to_radians())
            }
            ReliefStart::FromTipMm(mm) => {
                let roll = gear.tip_form_roll() - gear.kappa() * mm * MM;
                ("from_tip_mm", mm, roll)
            }
        };
        let shown = match form {
            "" => "pitch_point".to_owned(),
            _ => format!("{{\"{form}\": {value}}}"),
        };
        let active = self.active();
        let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
        let diameter = |roll: f64| 2.0 * gear.radius_at_roll(roll) / MM;
        let is_within = start_roll > low && start_roll < high;
        if let Some((tip, value, problem)) = short_tooth(self.file, g) {
            ensure!(is_within, tip => value;
                "{problem}, and the start of `{path}` is not on the active profile";
                "give the diameter of the tips, or another start of the relief");
        }
        let path = format!("{path}.start");
        let meant = meant_about(form, value, diameter(0.5 * (low + high)));
        let meant = meant.filter(|_| form == "diameter_mm");
        let remedy = remedy(meant, "give {\"diameter_mm\": ...} within it");
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
    pub fn topography(&self, name: &str, field: &str) -> Result<Arc<Topography>, Refusal> {
        let (path, gear, active) = (self.folder.join(name), self.gear(), self.active());
        let shown = path.display().to_string();
        let text = text::read(&path).map_err(|error| {
            refusal!(field => &shown;
                "cannot be read: {error}"; "give a CSV file beside the pair file, and that you may read")
        })?;
        let grid = grid(&text, gear)
            .map_err(|(problem, remedy)| refusal!(field => &shown; "{problem}"; "{remedy}"))?;
        let [rolls, zs] = grid.range();
        let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
        for (name, range, [low, high]) in [
            ("roll_mm", rolls, [low, high]),
            ("z_mm", zs, [0.0, gear.face_width]),
        ] {
            let covered = range[1].min(high) - range[0].max(low);
            let [first, last, from, to] =
                [range[0], range[1], low, high].map(|m| rounded((m * 1e6).round() * 1e-3));
            ensure!(covered >= (1.0 - BEYOND) * (high - low) * MM, field => &shown;
                "{name} runs from {first} to {last}, and the flank from {from} to {to} mm";
                "give a grid that covers three quarters of the active profile and of the face at least; check its units");
        }
        let most = 0.05 * gear.normal_module;
        let limit = format!(
            "more than a twentieth of the normal module, {} um",
            rounded(most / UM)
        );
        ensure!(grid.largest_removal() <= 1.5 * most, field => &shown;
            "takes off {limit}"; "give removal_um normal to the flank in micrometres");
        let [least, largest] = grid.extremes([low, high], [0.0, gear.face_width]);
        let [roll, z, removal] = match least[2].abs() > largest[2].abs() {
            true => least,
            false => largest,
        };
        let is_within = rolls[0] <= roll && roll <= rolls[1] && zs[0] <= z && z <= zs[1];
        let verb = if removal < 0.0 { "adds" } else { "takes off" };
        let (cause, remedy) = match is_within {
            true => (
                "its bicubic does, where two lines lie close or values jump",
                "give lines at about equal distances, and smooth values that jump from one to the next",
            ),
            false => (
                "its tangents do, beyond the grid",
                "give a grid that covers the whole active profile and the whole face, at about equal distances",
            ),
        };
        ensure!(removal.abs() <= 1.5 * most, field => &shown;
            "{verb} {:.4e} um at roll_mm = {:.3}, z_mm = {:.3}, {limit}: {cause}",
            removal.abs() / UM, roll / MM, z / MM; "{remedy}");
        Ok(Arc::new(grid))
    }
}

/// Share of the active profile or of the face that may lie beyond the grid, where its tangents go on.
const BEYOND: f64 = 0.25;

const COLUMNS: &str = "the columns are roll_mm (or diameter_mm), z_mm and removal_um";

/// The grid in `text`; if it is none, the problem and the remedy.
fn grid(text: &str, gear: &Gear) -> Result<Topography, (String, String)> {
    // The reader counts a line only at its \n, after the place of the next one.
    let text = text.replace("\r\n", "\n");
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let broken = |error: csv::Error| (error.to_string(), format!("give CSV; {COLUMNS}"));
    let header = reader.headers().map_err(broken)?.clone();
    let column = |name: &str| header.iter().position(|h| h == name);
    let (roll, along) = (
        column("roll_mm"),
        column("roll_mm").or(column("diameter_mm")),
    );
    let (Some(along), Some(z), Some(removal)) = (along, column("z_mm"), column("removal_um"))
    else {
        let found = header.iter().collect::<Vec<_>>().join(",");
        return Err(match found.contains(';') {
            true => (
                "has semicolons between its columns".into(),
                format!("write commas there, and points in the numbers; {COLUMNS}"),
            ),
            false => (
                format!("has the columns {found}"),
                format!("give a header; {COLUMNS}"),
            ),
        });
    };
    // Sorted by the bits of numbers that are not negative.
    let mut rows: BTreeMap<[u64; 2], f64> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let line = record.position().map_or(0, csv::Position::line);
        let refused = |problem: &str, remedy: &str| {
            let problem = format!("line {line}: {problem}");
            (problem, remedy.to_owned())
        };
        let number = |column: usize| {
            let cell = record.get(column).unwrap_or("");
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            let problem = format!("{} = {cell}: not a finite number", &header[column]);
            value.ok_or_else(|| refused(&problem, "give numbers with a decimal point"))
        };
        let (along, z, removal) = (number(along)? * MM, number(z)? * MM, number(removal)? * UM);
        let roll = match roll {
            Some(_) => along,
            None => gear.roll_length(0.5 * along),
        };
        if !(roll >= 0.0 && z >= 0.0) {
            return Err(refused(
                "lies outside of involute and face",
                "give lengths of roll or diameters of the involute, and z from the z = 0 face",
            ));
        }
        let point = [roll + 0.0, z + 0.0].map(f64::to_bits);
        if rows.insert(point, removal).is_some() {
            let problem = "its point stands in an earlier line, too";
            return Err(refused(problem, "leave one of them out"));
        }
    }
    if rows.is_empty() {
        let remedy = format!("give at least 3 x 3 points; {COLUMNS}");
        return Err(("has a header and no points".into(), remedy));
    }
    let [rolls, zs] = [0, 1].map(|k| {
        let values: BTreeSet<u64> = rows.keys().map(|key| key[k]).collect();
        values.into_iter().map(f64::from_bits).collect::<Vec<_>>()
    });
    let (points, lines) = (rows.len(), [rolls.len(), zs.len()]);
    if points != lines[0] * lines[1] {
        return Err((
            format!("has {points} points, and {} x {} lines", lines[0], lines[1]),
            "give one row for every point of a full grid".into(),
        ));
    }
    let removal: Vec<f64> = rows.into_values().collect();
    let removal = removal.chunks(lines[1]).map(<[f64]>::to_vec).collect();
    let few = "give at least 3 x 3 points";
    Topography::new(rolls, zs, removal).map_err(|error| (error.to_string(), few.into()))
}
