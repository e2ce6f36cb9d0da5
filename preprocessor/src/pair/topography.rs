//! The file of a topography: removal point by point, from a measuring machine or a design program.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::{Refusal, ensure, refusal};
use super::resolve::{MM, UM};
use super::text;
use gearmesh::gear::{Gear, Topography};
use gearmesh::words::rounded;

/// Share of the active profile or of the face that may lie beyond the grid, where its tangents go on.
const BEYOND: f64 = 0.25;

/// Reads the grid at `path`, which the field `field` names, for `gear` with the active profile between the lengths of
/// roll `active`: CSV with the columns `roll_mm` (or `diameter_mm`), `z_mm` and `removal_um`, one row for every point
/// of a full grid, in any order.
pub(super) fn read(
    path: &Path,
    field: &str,
    gear: &Gear,
    active: [f64; 2],
) -> Result<Topography, Refusal> {
    let text = text::read(path).map_err(|error| {
        refusal!(field => path.display();
            "cannot be read: {error}"; "give a CSV file beside the pair file, and that you may read")
    })?;
    let source = Source { path, field };
    let grid = source.parse(&text, gear)?;
    let [rolls, zs] = grid.range();
    let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
    for (name, range, [low, high]) in [
        ("roll_mm", rolls, [low, high]),
        ("z_mm", zs, [0.0, gear.face_width]),
    ] {
        let covered = range[1].min(high) - range[0].max(low);
        let [first, last, low, high] =
            [range[0], range[1], low, high].map(|m| rounded((m * 1e6).round() * 1e-3));
        ensure!(covered >= (1.0 - BEYOND) * (high - low) * MM, field => path.display();
            "{name} runs from {first} to {last}, and the flank from {low} to {high} mm";
            "give a grid that covers three quarters of the active profile and of the face at least; check its units");
    }
    let most = 0.05 * gear.normal_module;
    let limit = format!(
        "more than a twentieth of the normal module, {} um",
        rounded(most / UM)
    );
    ensure!(grid.largest_removal() <= 1.5 * most, field => path.display();
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
    ensure!(removal.abs() <= 1.5 * most, field => path.display();
        "{verb} {:.4e} um at roll_mm = {:.3}, z_mm = {:.3}, {limit}: {cause}", removal.abs() / UM, roll / MM, z / MM;
        "{remedy}");
    Ok(grid)
}

/// The file of a topography, and the field that names it.
struct Source<'a> {
    path: &'a Path,
    field: &'a str,
}

const COLUMNS: &str = "the columns are roll_mm (or diameter_mm), z_mm and removal_um";

impl Source<'_> {
    fn refused(&self, problem: impl std::fmt::Display, remedy: impl Into<String>) -> Refusal {
        let path = self.path.display();
        Refusal::new(self.field, path, problem.to_string(), remedy)
    }

    fn parse(&self, text: &str, gear: &Gear) -> Result<Topography, Refusal> {
        // The reader counts a line only at its \n, after the place of the next one.
        let text = text.replace("\r\n", "\n");
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let broken = |error: csv::Error| self.refused(error, format!("give CSV; {COLUMNS}"));
        let header = reader.headers().map_err(broken)?.clone();
        let [z, removal, roll, diameter] = ["z_mm", "removal_um", "roll_mm", "diameter_mm"]
            .map(|name| header.iter().position(|h| h == name));
        let (Some(z), Some(removal), Some(along)) = (z, removal, roll.or(diameter)) else {
            let found = header.iter().collect::<Vec<_>>().join(",");
            if !found.contains(';') {
                let problem = format!("has the columns {found}");
                return Err(self.refused(problem, format!("give a header; {COLUMNS}")));
            }
            return Err(self.refused(
                "has semicolons between its columns",
                format!("write commas there, and points in the numbers; {COLUMNS}"),
            ));
        };
        // Sorted by the bits of numbers that are not negative.
        let mut rows: BTreeMap<[u64; 2], f64> = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, csv::Position::line);
            let refused = |problem: &str, remedy: &str| {
                self.refused(format!("line {line}: {problem}"), remedy)
            };
            let number = |column: usize| {
                let cell = record.get(column).unwrap_or("");
                let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
                value.ok_or_else(|| {
                    let problem = format!("{} = {cell}: not a finite number", &header[column]);
                    refused(&problem, "give numbers with a decimal point")
                })
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
            return Err(self.refused("has a header and no points", remedy));
        }
        let [rolls, zs] = [0, 1].map(|k| {
            let values: BTreeSet<u64> = rows.keys().map(|key| key[k]).collect();
            values.into_iter().map(f64::from_bits).collect::<Vec<_>>()
        });
        let (points, lines) = (rows.len(), [rolls.len(), zs.len()]);
        if points != lines[0] * lines[1] {
            let problem = format!("has {points} points, and {} x {} lines", lines[0], lines[1]);
            return Err(self.refused(problem, "give one row for every point of a full grid"));
        }
        let removal: Vec<f64> = rows.into_values().collect();
        let removal = removal.chunks(lines[1]).map(<[f64]>::to_vec).collect();
        Topography::new(rolls, zs, removal)
            .map_err(|error| self.refused(error, "give at least 3 x 3 points"))
    }
}
