//! How far the gears are in mesh.
//!
//! Tables know small departures from the nominal position. Gears that are pulled apart, radially or
//! along their axes, must still end without force, and without a jump on the way. So the potential of
//! each flank is multiplied by a factor that is one as long as at least half of the nominal face
//! overlap and half of the path of contact (at most half a base pitch of it) are left, and zero
//! where nothing is left; between them a quintic step, C2. Its slopes enter the loads, so energy is
//! kept on the way out, too.

use super::constants::Constants;
use super::dual::Scalar;

/// How far the gears are in mesh: factor on the potential and its slopes.
pub(crate) struct Engagement<T> {
    /// 1 in mesh, 0 out of mesh.
    pub factor: T,
    /// Its derivative by the centre distance, 1/m.
    pub by_center_distance: T,
    /// Its derivative by the axial position lambda of c2 in gear 2's frame, 1/m.
    pub by_axial_position: T,
    /// The factor is below one, or the gears share another part of their faces than the stiffness is for.
    pub leaving: bool,
}

impl<T: Scalar> Engagement<T> {
    /// At centre distance `c` with c2 at the axial position `lambda` in gear 2's frame.
    #[inline(always)]
    pub(crate) fn new(k: &Constants, c: T, lambda: T) -> Self {
        let (radial, radial_slope) = radial_share(k, c);
        let [(low, low_slope), (high, high_slope)] = face_overlap(k, -lambda + k.z_ref);
        let per_half = 2.0 / (k.common_face[1] - k.common_face[0]);
        let (axial, axial_slope) = step((high - low) * per_half);
        Engagement {
            factor: radial * axial,
            by_center_distance: radial_slope * axial * k.radial_engagement.per_span,
            by_axial_position: radial * axial_slope * ((high_slope - low_slope) * per_half),
            leaving: radial.re() < 1.0 || axial.re() < 1.0 || is_shifted(k, [low.re(), high.re()]),
        }
    }
}

/// Part of the common face by which its ends may move before its stiffness and its middle are another pair's.
const SHIFT: f64 = 0.05;

/// Whether the common face `ends` (gear 1's frame, m) is not that of the nominal pose, which tables and contact are for: they
/// have no axis along the gears' axes.
pub(crate) fn is_shifted(k: &Constants, ends: [f64; 2]) -> bool {
    let [low, high] = k.common_face;
    let most = SHIFT * (high - low);
    (ends[0] - low).abs() > most || (ends[1] - high).abs() > most
}

/// Share of the engagement that the centre distance `c` leaves, and its slope by c `per_span`.
#[inline(always)]
pub(crate) fn radial_share<T: Scalar>(k: &Constants, c: T) -> (T, T) {
    step((c - k.radial_engagement.none) * k.radial_engagement.per_span)
}

/// Ends of the common face in gear 1's frame, m, each with its slope by the axial position of c2 in gear 2's frame, with gear 2's
/// z = 0 face at `offset`; the first beyond the second: the faces are apart.
#[inline(always)]
pub(crate) fn face_overlap<T: Scalar>(k: &Constants, offset: T) -> [(T, f64); 2] {
    let [b1, b2] = k.face_width;
    let low = if offset.re() > 0.0 {
        (offset, -1.0)
    } else {
        (T::from(0.0), 0.0)
    };
    let high = if offset.re() + b2 < b1 {
        (offset + b2, -1.0)
    } else {
        (T::from(b1), 0.0)
    };
    [low, high]
}

/// Quintic step from 0 at 0 to 1 at 1, and its slope.
#[inline(always)]
fn step<T: Scalar>(x: T) -> (T, T) {
    if x.re() >= 1.0 {
        return (T::from(1.0), T::from(0.0));
    }
    if x.re() <= 0.0 {
        return (T::from(0.0), T::from(0.0));
    }
    let square = x * x;
    let rest = -x + 1.0;
    (
        square * x * (x * (x * 6.0 - 15.0) + 10.0),
        square * rest * rest * 30.0,
    )
}
