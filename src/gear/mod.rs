//! Gear geometry: one gear, the pair, and what is taken off its flanks.
//!
//! Coordinates of one gear (body frame): origin on the axis in the z = 0 face, z along the axis, x through a tooth centre
//! at z = 0 (ring: a space centre). A flank has the sign `sigma`: +1 is the flank that faces the +theta sense.

mod body_orders;
mod macrogeometry;
mod microgeometry;
mod pair_geometry;
#[cfg(test)]
#[path = "../../tests/common/gears.rs"]
pub mod samples;
pub mod teeth;
mod topography;

pub use body_orders::{BodyOrder, BodyOrders, CompliancePath, TurningBodies};
pub use macrogeometry::{Body, Gear, GearKind, GeometryError, inverse_involute, involute};
pub use microgeometry::{
    EndRelief, Microgeometry, PairMicrogeometry, ProfileCrowning, ProfileRelief, ProfileSlope,
    ReliefShape,
};
pub use pair_geometry::{BothFlanks, Flank, PairGeometry, PairNumbers, PathOfContact};
pub use teeth::{OwnFlank, PairTeeth, Runout, ToothErrors, WeakTooth, first_teeth};
pub use topography::{ProfilePiece, Topography, TopographyError};
