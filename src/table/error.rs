//! What can be wrong with a table, with field, value and remedy.

use crate::gear::GeometryError;
use crate::words::json_problem;
use thiserror::Error;

/// Refusal of a table, of samples, or of a choice that a table cannot serve.
#[derive(Debug, Error)]
pub enum TableError {
    /// The file could not be read or written.
    #[error("{path}: {source}; name a tables file that exists and that you may read")]
    Io {
        /// File as given.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not JSON, or a field is missing, unknown or of the wrong type.
    #[error("tables file: {}; make it again with `gearmesh tables` or `gearmesh import`", json_problem(.0))]
    Json(#[from] serde_json::Error),
    /// A field holds what it must not.
    #[error("{field} = {value}: {reason}")]
    Field {
        /// Name of the field, with the index where it is an array.
        field: String,
        /// What it holds.
        value: String,
        /// What is wrong with that, and what to do.
        reason: String,
    },
    /// Axes so coarse that the interpolant of the top-load minus the no-load approach may not be positive.
    #[error(
        "top_load_approach_m: the spline through top-load minus no-load approach may fall to {least_m:.2e} m between the nodes; {}",
        closer([*.has_center_distance, *.has_misalignment])
    )]
    TooCoarse {
        /// Least coefficient of that spline, m.
        least_m: f64,
        /// Whether the table has an axis of the centre distance.
        has_center_distance: bool,
        /// Whether it has one of the misalignment.
        has_misalignment: bool,
    },
    /// A setting of the FMU needs what the table lacks.
    #[error("{0}")]
    Missing(&'static str),
    /// Geometry that no checked pair file gives.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A static solve that failed, with its operating point, or samples that cannot become a table.
    #[error("{0}")]
    Failed(String),
}

impl TableError {
    /// Of centre distance and misalignment.
    pub(crate) const NO_AXIS: [Self; 2] = [
        TableError::Missing(
            "centerDistanceEffect = true: the table has no axis `center_distance_offset_m` (one value only); switch the \
             effect off or make tables with this axis",
        ),
        TableError::Missing(
            "misalignmentEffect = true: the table has no axis `misalignment_rad` (one value only); switch the effect off \
             or make tables with this axis",
        ),
    ];
    pub(crate) const NO_MOMENT: Self = TableError::Missing(
        "shuttlingEffect = true: the table has no moment_nm; switch the effect off or make tables with it",
    );
    pub(crate) const NO_FRICTION: Self = TableError::Missing(
        "friction = true: the table does not know how the load slides; switch friction off or make the tables with \
         `gearmesh tables --friction`",
    );
    pub(crate) const NO_FRICTION_LAW: Self = TableError::Missing(
        "friction = true: the FMU was built by an earlier version and has no law of friction for its stiffnessModel; build it \
         again or set friction = false",
    );
    pub(crate) const NO_ROOT_STRESS: Self = TableError::Missing(
        "rootStress = true: the table does not hold the stress in the tooth roots; switch rootStress off or make the \
         tables with `gearmesh tables --root-stress`",
    );
    pub(crate) const NO_ROOT_STRESS_AT_CONTACT: Self = TableError::Missing(
        "rootStress = true: the contact of this FMU does not hold the stress in the tooth roots; switch rootStress off or \
         build the FMU with `gearmesh build --contact --root-stress`",
    );
    pub(crate) const NO_BODIES: Self = TableError::Missing(
        "bodyEffect = true: the tables do not hold a body that is no solid of revolution; set bodyEffect = false, or give the gear \
         web_holes, rim_pins, rim_supports or body_matrix in the pair file and make the tables again",
    );
    pub(crate) const NO_TEETH: Self = TableError::Missing(
        "stiffnessModel = teeth: the table does not hold tooth pairs one by one; set stiffnessModel = table or make \
         the tables with `gearmesh tables --teeth`",
    );
}

/// What helps a table whose nodes lie too far apart, with these of the axes of centre distance and misalignment.
fn closer(has: [bool; 2]) -> String {
    let axes = [
        ("centre distances", "center_distance_offset_um"),
        ("misalignments about 0", "misalignment_mrad"),
    ];
    let axes: Vec<_> = axes
        .iter()
        .zip(has)
        .filter_map(|(axis, has)| has.then_some(axis))
        .collect();
    let spaced: String = axes
        .iter()
        .map(|(nodes, _)| format!("{nodes} or "))
        .collect();
    let narrowed: String = axes
        .iter()
        .map(|(_, field)| format!("narrow operating.{field} or "))
        .collect();
    format!(
        "space {spaced}mesh positions closer, with `gearmesh tables --max-error 0.002`, or {narrowed}raise \
         operating.maximum_torque_nm in the pair file"
    )
}

/// A [`TableError::Field`]: what is wrong with `value` of `field` and what to do.
pub(crate) fn refused<T>(
    field: impl Into<String>,
    value: impl ToString,
    reason: impl Into<String>,
) -> Result<T, TableError> {
    Err(TableError::Field {
        field: field.into(),
        value: crate::words::shown(&value.to_string()),
        reason: reason.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_too_coarse_are_those_that_the_table_has() {
        let said = |has_misalignment| {
            let error = TableError::TooCoarse {
                least_m: -1e-8,
                has_center_distance: true,
                has_misalignment,
            };
            error.to_string()
        };
        let one = said(false);
        assert!(
            one.contains("narrow operating.center_distance_offset_um or raise"),
            "{one}"
        );
        assert!(!one.contains("misalignment"), "{one}");
        let words = "space centre distances or misalignments about 0 or mesh positions closer";
        assert!(said(true).contains(words), "{}", said(true));
    }
}
