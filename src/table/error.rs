//! What can be wrong with a table, with field, value and remedy.

use super::axis::Axis;
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
        closer(*.axis)
    )]
    TooCoarse {
        /// Least coefficient of that spline, m.
        least_m: f64,
        /// Axis whose nodes lie too far apart.
        axis: Axis,
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

/// What helps a table whose nodes along `axis` lie too far apart.
fn closer(axis: Axis) -> String {
    let (nodes, narrow) = match axis {
        Axis::CenterDistance => (
            "centre distances",
            "narrow operating.center_distance_offset_um or ",
        ),
        Axis::Misalignment => (
            "misalignments about 0",
            "narrow operating.misalignment_mrad or ",
        ),
        Axis::Displacement | Axis::MeshPosition => ("mesh positions", ""),
    };
    format!(
        "space {nodes} closer, with `gearmesh tables --max-error 0.002`, or {narrow}raise operating.maximum_torque_nm in the pair file"
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
    fn the_axis_that_is_too_coarse_is_named_with_its_field() {
        let cases = [
            (
                Axis::CenterDistance,
                "space centre distances closer",
                "narrow operating.center_distance_offset_um or raise",
            ),
            (
                Axis::Misalignment,
                "space misalignments about 0 closer",
                "narrow operating.misalignment_mrad or raise",
            ),
            (
                Axis::MeshPosition,
                "space mesh positions closer",
                "or raise operating.maximum_torque_nm",
            ),
        ];
        for (axis, space, narrow) in cases {
            let least_m = -1e-8;
            let said = TableError::TooCoarse { least_m, axis }.to_string();
            assert!(said.contains(space) && said.contains(narrow), "{said}");
        }
    }
}
