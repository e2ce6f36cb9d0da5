//! What the element refuses.

/// Why an element cannot be made, or has no meaning at a pose.
#[derive(Debug, thiserror::Error)]
pub enum ElementError {
    /// A parameter has no meaning.
    #[error("{name} = {value}: {remedy}")]
    Parameter {
        /// Name of the parameter as in the FMU.
        name: &'static str,
        /// The value given, with its unit.
        value: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The parameters ask for a table and none was given.
    #[error(
        "stiffnessModel = table or teeth, but there is no table: pack one with `gearmesh tables`, or set stiffnessModel = constant"
    )]
    NoTable,
    /// The parameters ask for contact at run time and none was given.
    #[error(
        "stiffnessModel = contact, but the FMU does not hold the contact of its pair: build it with `gearmesh build \
         --contact`, or set stiffnessModel = table"
    )]
    NoContact,
    /// A pose without a meaning, or that makes no mesh: the body, the value and what would be right, as text.
    #[error("{0}")]
    Pose(String),
    /// The table cannot give what the parameters ask for.
    #[error(transparent)]
    Table(#[from] crate::table::TableError),
    /// The law of the flank has no potential at this pose; why, as text.
    #[error("{0}")]
    NoPotential(String),
}
