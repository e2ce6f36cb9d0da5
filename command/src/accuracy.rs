//! How far the forces of a packed unit are from those of its static contact, by the level that it starts with.

use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::{InterpolationError, TableFile};

/// The error of contact at run time.
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
        let variable = &VARIABLES[i];
        let own = unit.starts.get(variable.name).copied();
        own.or(variable.start).unwrap_or(0.0)
    };
    let item = |i: usize| {
        let items = VARIABLES[i].items;
        (start(i) as usize)
            .checked_sub(1)
            .and_then(|k| items.get(k).copied())
            .unwrap_or("")
    };
    let level = item(index::STIFFNESS_MODEL);
    let error = match (level, tables) {
        ("contact", _) => at_run_time(contact),
        (
            "teeth",
            Some(TableFile {
                teeth: Some(teeth), ..
            }),
        ) => {
            format!("{} against contact at run time", teeth.error)
        }
        ("table", Some(tables)) => {
            let error = tables.interpolation_error;
            let error = error.map_or_else(|| "not measured".to_owned(), |error| error.to_string());
            let all = [
                (start(index::LOAD_DEPENDENT) == 0.0, "loadDependent = false"),
                (
                    item(index::INTERPOLATION) != "spline",
                    "another interpolation",
                ),
                (
                    start(index::CENTER_DISTANCE_EFFECT) == 0.0
                        && tables.axes.center_distance_offset.len() > 1,
                    "centerDistanceEffect = false",
                ),
                (
                    start(index::MISALIGNMENT_EFFECT) == 0.0 && tables.axes.misalignment.len() > 1,
                    "misalignmentEffect = false",
                ),
            ];
            let less: Vec<&str> = all
                .iter()
                .filter(|(on, _)| *on)
                .map(|(_, name)| *name)
                .collect();
            if less.is_empty() {
                error
            } else {
                format!(
                    "{error}; that of the spline with all axes, more with {}",
                    less.join(", ")
                )
            }
        }
        _ => "not measured: one stiffness for all loads and mesh positions".to_owned(),
    };
    format!("{level}: {error}")
}
