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
        let variable = &VARIABLES[i];
        let own = unit.starts.get(variable.name).copied();
        own.or(variable.start).unwrap_or(0.0)
    };
    let item = |i: usize| {
        let items = VARIABLES[i].items.iter();
        items
            .zip(1..)
            .find(|(_, number)| *number == start(i) as usize)
            .map_or("", |(name, _)| *name)
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
            let mut error =
                error.map_or_else(|| "not measured".to_owned(), |error| error.to_string());
            let is_off = |i: usize, nodes: &[f64]| start(i) == 0.0 && nodes.len() > 1;
            let axes = &tables.axes;
            #[rustfmt::skip]
            let less = [
                (start(index::LOAD_DEPENDENT) == 0.0, "loadDependent = false"),
                (item(index::INTERPOLATION) != "spline", "another interpolation"),
                (is_off(index::CENTER_DISTANCE_EFFECT, &axes.center_distance_offset), "centerDistanceEffect = false"),
                (is_off(index::MISALIGNMENT_EFFECT, &axes.misalignment), "misalignmentEffect = false"),
            ];
            let less: Vec<&str> = less
                .iter()
                .filter(|(is_so, _)| *is_so)
                .map(|(_, name)| *name)
                .collect();
            if !less.is_empty() {
                error += &format!(
                    "; that of the spline with all axes, more with {}",
                    less.join(", ")
                );
            }
            error
        }
        _ => "not measured: one stiffness for all loads and mesh positions".to_owned(),
    };
    format!("{level}: {error}")
}
