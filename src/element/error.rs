//! What the element refuses.

use crate::words::{fixed, number};

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
        "stiffnessModel = contact, but the unit does not hold the contact of its pair: build it with `gearmesh build \
         --contact`, or set stiffnessModel = table"
    )]
    NoContact,
    /// An input is NaN or infinite.
    #[error(
        "{body}: {quantity} is not finite; every position and velocity must be a finite number"
    )]
    NotFinite {
        /// Which body: gear1, gear2 or carrier.
        body: &'static str,
        /// position, orientation, velocity or angular velocity.
        quantity: &'static str,
    },
    /// A rotation matrix is none.
    #[error(
        "{body}: the orientation is no rotation (it departs from an orthonormal, right-handed matrix by {departure:.1e}); normalise the quaternion or rebuild the matrix"
    )]
    NotARotation {
        /// Which body: gear1, gear2 or carrier.
        body: &'static str,
        /// Largest departure of lengths and products of the columns.
        departure: f64,
    },
    /// The axes do not run alike.
    #[error(
        "the axis of {body} is tilted by {tilt_deg:.3} deg against {reference}; the element holds up to {limit_deg:.1} deg and both z axes must point alike"
    )]
    Tilt {
        /// Which body: gear1, gear2 or carrier.
        body: &'static str,
        /// The body it is measured against.
        reference: &'static str,
        /// Angle between both z axes, degrees.
        tilt_deg: f64,
        /// The largest one allowed, degrees.
        limit_deg: f64,
    },
    /// No line of action: the base circles overlap (external) or do not contain one another (internal).
    #[error(
        "centre distance {} mm is below {} mm, where the base circles leave no common tangent; move the gears apart or check which gear is which (with gear 1 at the origin gear2.position[1] starts as {} m: a host that fills all inputs with zeros must set it)",
        fixed(*center_distance_mm, 6), fixed(*limit_mm, 6), number(*nominal_m)
    )]
    NoLineOfAction {
        /// Distance of the axes in the transverse plane, mm.
        center_distance_mm: f64,
        /// abs(rb1 + e rb2), mm.
        limit_mm: f64,
        /// Nominal centre distance, m.
        nominal_m: f64,
    },
    /// The initial pose of an internal pair lies out of mesh, where no phase can be taken.
    #[error(
        "at the initial pose the gears are out of reach of one another; start from a pose in mesh"
    )]
    OutOfReach,
    /// The initial pose keeps the teeth of one gear out of reach of the other's.
    #[error(
        "the initial pose is no mesh: {reasons}; correct the positions of the gears, in m, or start from a pose in mesh"
    )]
    NoMesh {
        /// Each with its value and what would be right.
        reasons: String,
    },
    /// At the initial pose the teeth press by more than any load of the table.
    #[error(
        "the initial pose jams the teeth with {} kN on the line of action, where the largest load is {} kN: {pose}; correct the positions and orientations of the gears",
        fixed(*force_kn, 2), fixed(*largest_kn, 2)
    )]
    Jammed {
        /// Force, kN.
        force_kn: f64,
        /// Force of the largest load, kN.
        largest_kn: f64,
        /// Centre distance and misalignment, and what they should be.
        pose: String,
    },
    /// The table cannot give what the parameters ask for.
    #[error(transparent)]
    Table(#[from] crate::table::TableError),
    /// In the absolute phase reference the start pose lets teeth overlap more than any load of the table.
    #[error(
        "phaseReference = absolute: at the initial pose the flanks overlap by {overlap_um:.1} um, which takes {} kN on the line of action where the largest load is {} kN; turn gear 1 by {turn_rad:+.3e} rad, or set phaseReference = fromInitialPose",
        fixed(*force_kn, 2), fixed(*largest_kn, 2)
    )]
    TeethOverlap {
        /// Penetration on the line of action beyond the first touch, um.
        overlap_um: f64,
        /// Its force, kN.
        force_kn: f64,
        /// Force of the largest load, kN.
        largest_kn: f64,
        /// Rotation of gear 1 after which its loaded flank just touches, rad.
        turn_rad: f64,
    },
    /// A law of the caller's has no potential at this pose.
    #[error("{0}")]
    NoPotential(
        /// Why.
        String,
    ),
    /// With one flank alone the gears have turned back to the tooth behind.
    #[error(
        "loadedFlank = {loaded_flank}: the teeth overlap by {overlap_mm:.3} mm on the line of action; nothing holds the gears when they turn back from this flank, and they have come to the tooth behind: set loadedFlank = both"
    )]
    TeethPassed {
        /// Penetration on the line of action, mm.
        overlap_mm: f64,
        /// The flank that can carry.
        loaded_flank: &'static str,
    },
}
