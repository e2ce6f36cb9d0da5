//! Gear geometry: one gear, the pair, and what is taken off its flanks.
//!
//! Coordinates of one gear (body frame): origin on the axis in the z = 0 face, z along the axis, x through a tooth centre
//! at z = 0 (ring: a space centre). A flank has the sign `sigma`: +1 is the flank that faces the +theta sense.

mod body;
mod check;
mod macrogeometry;
mod microgeometry;
mod modification;
mod pair_geometry;
mod profile;
#[cfg(test)]
#[path = "../../tests/common/gears.rs"]
pub mod samples;
pub mod teeth;
pub mod tolerance;
mod topography;
mod trochoid;

pub use body::{Annulus, Body, Stub};
pub use check::GeometryError;
pub use macrogeometry::{Gear, GearKind, LEAST_WALL};
pub use microgeometry::{Microgeometry, PairMicrogeometry};
pub use modification::{
    EndRelief, ProfileCrowning, ProfilePiece, ProfileRelief, ProfileSlope, ReliefShape,
};
pub use pair_geometry::{Flank, PairGeometry, PathOfContact};
pub use profile::{ProfileError, ProfilePoint, ToothProfile};
pub use teeth::{OwnFlank, PairTeeth, Runout, ToothErrors, WeakTooth};
pub use topography::{Topography, TopographyError};

/// Involute function inv(alpha) = tan(alpha) - alpha, rad.
pub fn involute(alpha: f64) -> f64 {
    alpha.tan() - alpha
}

/// The angle in [0, pi/2) whose involute function is `value` >= 0, rad; NaN for a negative value.
pub fn inverse_involute(value: f64) -> f64 {
    if value.is_nan() || value < 0.0 {
        return f64::NAN;
    }
    // t - atan(t) = value with t = tan(alpha). The left side is convex and rises, so that Newton
    // converges from the right of the root, where this start lies.
    let mut t = (3.0 * value).cbrt() + value;
    for _ in 0..64 {
        // d/dt (t - atan t) = t^2 / (1 + t^2).
        let step = (t - t.atan() - value) * (1.0 + t * t) / (t * t).max(f64::MIN_POSITIVE);
        t -= step;
        if step.abs() <= 1e-16 * t.abs() {
            break;
        }
    }
    t.atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_involute_inverts_from_zero_to_near_a_right_angle() {
        assert_eq!(inverse_involute(0.0), 0.0);
        assert!(inverse_involute(-1e-9).is_nan());
        for k in 1..150 {
            let alpha = 0.01 * f64::from(k);
            let back = inverse_involute(involute(alpha));
            // inv' = tan^2, so that rounding of inv is magnified by 1 / tan^2.
            let bound = 1e-15 * (1.0 + 1.0 / alpha.tan().powi(2));
            assert!((back - alpha).abs() < bound, "{alpha}: {back}");
        }
    }
}
