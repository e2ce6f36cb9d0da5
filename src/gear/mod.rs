//! Gear geometry: one gear, the pair, and what is taken off its flanks.
//!
//! Coordinates of one gear (body frame): origin on the axis in the z = 0 face, z along the axis,
//! x through a tooth centre at z = 0 (ring: a space centre). A flank has the sign `sigma`: +1 is
//! the flank that faces the +theta sense.

mod blank;
mod pair_geometry;

pub use blank::{Gear, GearKind};
pub use pair_geometry::{Flank, PairGeometry, PathOfContact};

/// Involute function inv(alpha) = tan(alpha) - alpha, rad.
pub fn involute(alpha: f64) -> f64 {
    alpha.tan() - alpha
}
