//! The file of a topography: removal point by point, from a measuring machine or a design program.

use std::collections::BTreeMap;
use std::path::Path;

use super::checks::require;
use super::error::Refusal;
use super::resolve::{MM, UM};
use super::text;
use crate::gear::{Gear, Topography};
use crate::words::rounded;

/// Share of the active profile or of the face that may lie beyond the grid, where its tangents go on.
const BEYOND: f64 = 0.25;

/// A problem and its remedy.
type Fault = (String, String);

/// Reads the grid at `path`, which the field `field` names, for `gear` with the active profile between the lengths of
/// roll `active`: CSV with the columns `roll_mm` (or `diameter_mm`), `z_mm` and `removal_um`, one row for every point
/// of a full grid, in any order.
pub(super) fn read(
    path: &Path,
    field: &str,
    gear: &Gear,
    active: [f64; 2],
) -> Result<Topography, Refusal> {
    let refused = |(problem, remedy): Fault| Refusal::new(field, path.display(), problem, remedy);
    let text = text::read(path).map_err(|error| {
        refused((
            format!("cannot be read: {error}"),
            "give a file beside the pair file, and that you may read".into(),
        ))
    })?;
    let grid = parse(&text, gear).map_err(refused)?;
    let [rolls, zs] = grid.range();
    let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
    for (name, range, [low, high]) in [
        ("roll_mm", rolls, [low, high]),
        ("z_mm", zs, [0.0, gear.face_width]),
    ] {
        let covered = range[1].min(high) - range[0].max(low);
        let [first, last, low, high] =
            [range[0], range[1], low, high].map(|m| rounded((m * 1e6).round() * 1e-3));
        require(
            covered >= (1.0 - BEYOND) * (high - low) * MM,
            field,
            path.display(),
            format!("{name} runs from {first} to {last}, and the flank from {low} to {high} mm"),
            "give a grid that covers three quarters of the active profile and of the face at least; check its units",
        )?;
    }
    let most = 0.05 * gear.normal_module;
    let limit = format!(
        "more than a twentieth of the normal module, {} um",
        rounded(most / UM)
    );
    require(
        grid.largest_removal() <= 1.5 * most,
        field,
        path.display(),
        format!("takes off {limit}"),
        "give removal_um normal to the flank in micrometres",
    )?;
    let [roll, z, removal] = grid.extreme([low, high], [0.0, gear.face_width]);
    let is_within = rolls[0] <= roll && roll <= rolls[1] && zs[0] <= z && z <= zs[1];
    require(
        removal.abs() <= 1.5 * most,
        field,
        path.display(),
        format!(
            "{} {:.4e} um at roll_mm = {:.3}, z_mm = {:.3}, {limit}: {}",
            if removal < 0.0 { "adds" } else { "takes off" },
            removal.abs() / UM,
            roll / MM,
            z / MM,
            if is_within {
                "its bicubic does, where two lines lie close or values jump"
            } else {
                "its tangents do, beyond the grid"
            },
        ),
        if is_within {
            "give lines at about equal distances, and smooth values that jump from one to the next"
        } else {
            "give a grid that covers the whole active profile and the whole face, at about equal distances"
        },
    )?;
    Ok(grid)
}

fn parse(text: &str, gear: &Gear) -> Result<Topography, Fault> {
    let columns = "the columns are roll_mm (or diameter_mm), z_mm and removal_um";
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let broken = |error: csv::Error| (error.to_string(), format!("give CSV; {columns}"));
    let header = reader.headers().map_err(broken)?.clone();
    let at = |name: &str| header.iter().position(|h| h == name);
    let (Some(z), Some(removal), Some(along)) = (
        at("z_mm"),
        at("removal_um"),
        at("roll_mm").or(at("diameter_mm")),
    ) else {
        let found = header.iter().collect::<Vec<_>>().join(",");
        return Err((
            format!("has the columns {found}"),
            format!("give a header; {columns}"),
        ));
    };
    let is_diameter = at("roll_mm").is_none();
    // Sorted by the bits of numbers that are not negative.
    let mut rows: BTreeMap<[u64; 2], f64> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |column: usize| {
            let cell = record.get(column).unwrap_or("");
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| {
                (
                    format!(
                        "line {line}: {} = {cell}: not a finite number",
                        &header[column]
                    ),
                    "give numbers with a decimal point".to_owned(),
                )
            })
        };
        let (mut roll, z_mm, um) = (number(along)? * MM, number(z)? * MM, number(removal)? * UM);
        if is_diameter {
            roll = gear.roll_length(0.5 * roll);
        }
        if !(roll >= 0.0 && z_mm >= 0.0) {
            return Err((
                format!("line {line}: lies outside of involute and face"),
                "give lengths of roll or diameters of the involute, and z from the z = 0 face"
                    .into(),
            ));
        }
        if rows
            .insert([roll + 0.0, z_mm + 0.0].map(f64::to_bits), um)
            .is_some()
        {
            return Err((
                format!("line {line}: its point stands in an earlier line, too"),
                "leave one of them out".into(),
            ));
        }
    }
    if rows.is_empty() {
        return Err((
            "has a header and no points".into(),
            format!("give at least 3 x 3 points; {columns}"),
        ));
    }
    let axis = |k: usize| {
        let mut values: Vec<u64> = rows.keys().map(|key| key[k]).collect();
        values.sort_unstable();
        values.dedup();
        values.into_iter().map(f64::from_bits).collect::<Vec<_>>()
    };
    let (rolls, zs) = (axis(0), axis(1));
    if rows.len() != rolls.len() * zs.len() {
        return Err((
            format!(
                "has {} points, and {} x {} lines",
                rows.len(),
                rolls.len(),
                zs.len()
            ),
            "give one row for every point of a full grid".into(),
        ));
    }
    let removal: Vec<f64> = rows.into_values().collect();
    let removal = removal.chunks(zs.len()).map(<[f64]>::to_vec).collect();
    Topography::new(rolls, zs, removal)
        .map_err(|error| (error.to_string(), "give at least 3 x 3 points".into()))
}
