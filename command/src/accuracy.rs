//! How far the forces of a packed unit are from those of its static contact, by the level that it starts with.

use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::{InterpolationError, TableFile};

pub fn at_run_time(error: Option<&InterpolationError>) -> String {
    error.map_or_else(
        || "not measured; build the unit again".to_owned(),
        |error| format!("{error}; against static contact on more stations, all teeth alike"),
    )
}

/// The level that `unit` starts with, by the name of its `stiffnessModel`, and its error as it was measured when the
/// unit was made, that of contact at run time being `contact`.
pub fn of_level(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    contact: Option<&InterpolationError>,
) -> String {
    let start = |i: usize| {
        let own = unit.starts.get(VARIABLES[i].name).copied();
        own.or(VARIABLES[i].start).unwrap_or(0.0)
    };
    // Items are counted from 1.
    let item = |i: usize| {
        let place = (start(i) as usize).wrapping_sub(1);
        VARIABLES[i].items.get(place).copied().unwrap_or("")
    };
    let level = item(index::STIFFNESS_MODEL);
    let error = match (level, tables) {
        ("contact", _) => at_run_time(contact),
        ("teeth", Some(TableFile { teeth: Some(t), .. })) => {
            format!("{} against contact at run time", t.error)
        }
        ("table", Some(tables)) => {
            let error = tables.interpolation_error.map(|error| error.to_string());
            let error = error.unwrap_or("not measured".into());
            let axes = &tables.axes;
            let off = |i: usize, nodes: usize| start(i) == 0.0 && nodes > 1;
            let center_distances = axes.center_distance_offset.len();
            let mut less = Vec::new();
            for (is_so, name) in [
                (off(index::LOAD_DEPENDENT, 2), "loadDependent = false"),
                (
                    item(index::INTERPOLATION) != "spline",
                    "another interpolation",
                ),
                (
                    off(index::CENTER_DISTANCE_EFFECT, center_distances),
                    "centerDistanceEffect = false",
                ),
                (
                    off(index::MISALIGNMENT_EFFECT, axes.misalignment.len()),
                    "misalignmentEffect = false",
                ),
            ] {
                less.extend(is_so.then_some(name));
            }
            match less.is_empty() {
                true => error,
                false => format!(
                    "{error}; that of the spline with all axes, more with {}",
                    less.join(", ")
                ),
            }
        }
        _ => "not measured: one stiffness for all loads and mesh positions".to_owned(),
    };
    format!("{level}: {error}")
}
