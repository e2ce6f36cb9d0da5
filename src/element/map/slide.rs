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
//! and friction of the size k against it is -k dr/dv: force and moment on gear 1, and exactly the opposite on
//! gear 2. Its power is -k r.

use super::{Coordinates, Map, Spatial};
use crate::element::constants::Constants;
use crate::element::scalar::{Scalar, scaled};
use nalgebra::Vector3;

/// The row of one flank.
pub(crate) struct Slide<T> {
    /// Share of the force, over that of the normal force.
    force: Vector3<T>,
    /// Moment about the axis and about the line of action.
    couple: Vector3<T>,
    /// X - p1 and X - p2, mid-face.
    arms: [Vector3<T>; 2],
}

impl<T: Scalar> Map<T> {
    /// Row of the flank `sign` with the sums `share`, `share_z` (m) and `distance` (m).
    #[inline(always)]
    pub(crate) fn slide(
        &self,
        k: &Constants,
        sign: f64,
        [share, share_z, distance]: [T; 3],
    ) -> Slide<T> {
        let c = self.u.dot(&self.line);
        let cos_phi = c.recip() * k.base_sum;
        let sin_phi = (-cos_phi * cos_phi + 1.0).sqrt();
        let across = self.a[0].cross(&self.line);
        let action = self.line * (sin_phi * self.e) + scaled(&(across * cos_phi), sign * k.sc);
        let slip = self.a[0].cross(&action);
        let shift = scaled(&self.a[0], k.z_ref - self.station);
        let pitch = self.pitch_point() + shift;
        Slide {
            force: slip * share,
            couple: self.a[0] * distance - action * share_z,
            arms: [pitch, self.k2 - scaled(&self.u, 1.0 - self.w) + shift],
        }
    }

    /// Spin of gear 1 against the line of centres, rad/s, out of the `rates` of the coordinates.
    pub(crate) fn spin(rates: &Coordinates<T>) -> T {
        -rates.mesh_angle
    }
}

impl<T: Scalar> Slide<T> {
    /// r, m/s, while the gears move with `v`.
    #[inline(always)]
    pub(crate) fn speed(&self, [v1, v2]: &[Spatial<T>; 2]) -> T {
        let at = |v: &Spatial<T>, arm: &Vector3<T>| v.linear + v.angular.cross(arm);
        let between = at(v1, &self.arms[0]) - at(v2, &self.arms[1]);
        self.force.dot(&between) + self.couple.dot(&(v1.angular - v2.angular))
    }

    /// Loads of friction of the size `k`, N: -k dr/dv.
    #[inline(always)]
    pub(crate) fn loads(&self, k: T) -> [Spatial<T>; 2] {
        let (force, couple) = (self.force * -k, self.couple * -k);
        [
            Spatial {
                linear: force,
                angular: self.arms[0].cross(&force) + couple,
            },
            Spatial {
                linear: -force,
                angular: -(self.arms[1].cross(&force) + couple),
            },
        ]
    }

    /// Without derivatives.
    pub(crate) fn re(&self) -> Slide<f64> {
        let re = |v: &Vector3<T>| v.map(|x| x.re());
        Slide {
            force: re(&self.force),
            couple: re(&self.couple),
            arms: [re(&self.arms[0]), re(&self.arms[1])],
        }
    }
}
