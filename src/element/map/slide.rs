//! Sliding of the flanks, and the friction against it: one row of the map between motions and law.
//!
//! In the transverse plane of gear 1 let n be the line of action of a flank, the direction of its force on gear 2, and
//! t = a1 x n. At X + s n + z a1 gear 1 slides on gear 2 with t . v12(X) - z n . w12 + s a1 . w12, v12 and w12 velocity
//! and angular velocity of gear 1 against gear 2. With the sums over the line loads of
//! [`crate::friction::Sliding`], sliding as friction sees it has the mean speed
//!
//! ```text
//! r = share t . v12(X) - share_z n . w12 + distance a1 . w12,
//! ```
//!
//! and friction of the size k against it is -k dr/dv: on gear 2 the wrench k times a row, of which r is minus the product
//! with the twist of gear 2 against gear 1. Its power is -k r.

use super::{Map, Spatial};
use crate::element::constants::Constants;
use crate::element::scalar::Scalar;
use nalgebra::Vector3;

impl<T: Scalar> Map<T> {
    /// Row of the flank `sign` with the sums `share`, `share_z` (m) and `distance` (m): wrench on gear 2 by friction of unit size.
    #[inline(always)]
    pub(crate) fn slide(
        &self,
        k: &Constants,
        sign: f64,
        [share, share_z, distance]: [T; 3],
    ) -> Spatial<T> {
        let cos_phi = self.per_c * k.base_sum;
        let sin_phi = (-cos_phi * cos_phi + 1.0).sqrt();
        let (x, y) = (sin_phi * k.e, cos_phi * (sign * k.sc));
        let force = [-y * share, x * share];
        // X - c2, mid-face, has these components along x and z.
        let (across, up) = (self.frame.c * (self.w - 1.0), k.z_ref - self.frame.station);
        Spatial {
            linear: Vector3::new(force[0], force[1], T::from(0.0)),
            angular: Vector3::new(
                -x * share_z - force[1] * up,
                force[0] * up - y * share_z,
                distance + across * force[1],
            ),
        }
    }
}

impl<T: Scalar> Spatial<T> {
    /// Power of this wrench on the twist `other`, or of this twist under it.
    #[inline(always)]
    pub(crate) fn power(&self, other: &Self) -> T {
        self.linear.dot(&other.linear) + self.angular.dot(&other.angular)
    }

    /// Without derivatives.
    pub(crate) fn re(&self) -> Spatial<f64> {
        Spatial {
            linear: self.linear.map(T::re),
            angular: self.angular.map(T::re),
        }
    }

    /// This wrench `factor` times.
    #[inline(always)]
    pub(crate) fn times(&self, factor: T) -> Self {
        Self {
            linear: self.linear * factor,
            angular: self.angular * factor,
        }
    }
}
