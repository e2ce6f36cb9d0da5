//! The frame on the line of centres, in which the map between motions and coordinates is sparse.
//!
//! A fixed station on gear 1's axis is c1; c2 is where the axis of gear 2 pierces the transverse plane of gear 1
//! through c1. Origin c2, x along c1 -> c2, z = a1, y = z × x. What gear 2's pose can change here are the distance C, the
//! axial position lambda of c2 on gear 2, the components b of its axis a2, the direction gamma of x about z, and
//! the angle theta_2 of the line of centres in gear 2. If gear 2 moves against gear 1 by the small twist (d, w) at c2,
//! then with D = 1 - b_x²
//!
//! ```text
//! dlambda = -d_z / b_z                     db_x = b_z w_y - b_y (w_z - dgamma)
//! dC      = d_x + b_x dlambda              db_y = b_x (w_z - dgamma) - b_z w_x
//! dgamma  = (d_y + b_y dlambda) / C        dtheta_2 = -[b_z (w_z - dgamma) + b_y w_y] / D
//! ```
//!
//! and theta_1 changes as gamma.

use super::Spatial;
use crate::element::check;
use crate::element::constants::TILT_LIMIT;
use crate::element::error::ElementError;
use crate::element::motion::Motion;
use crate::element::scalar::{Scalar, lift};
use nalgebra::Vector3;

/// The frame at one pose.
pub(crate) struct LineFrame<T> {
    /// Directions of x, y and z, W.
    pub axes: [Vector3<f64>; 3],
    /// Axial position of c1 in gear 1, m.
    pub station: f64,
    /// C, m.
    pub c: T,
    /// lambda, m.
    pub lambda: T,
    /// b.
    pub b: [T; 3],
    /// gamma, rad, without its value: derivatives alone.
    pub gamma: T,
    /// theta_2, rad, without its value.
    pub theta2: T,
}

impl<T: Scalar> LineFrame<T> {
    /// Of the poses of both gears, with the station `station` (m) beyond gear 1's z = 0 face. Derivatives are by motions of gear 2.
    ///
    /// # Errors
    /// Axes that do not run alike. Axes that meet at c1 give a frame without meaning.
    #[inline(always)]
    pub(super) fn new([g1, g2]: &[Motion; 2], station: f64) -> Result<Self, ElementError> {
        let [z, a2] = [g1.r.column(2).into_owned(), g2.r.column(2).into_owned()];
        let bz = z.dot(&a2);
        check::tilt("gear2", "gear1", bz, TILT_LIMIT)?;
        let per_bz = 1.0 / bz;
        let relative = g2.p - g1.p;
        let lambda = (station - relative.dot(&z)) * per_bz;
        let k2 = a2 * lambda;
        let u = relative + k2 - z * station;
        let c = u.dot(&u).sqrt();
        let per_c = 1.0 / c;
        let x = u * per_c;
        let y = z.cross(&x);
        let (bx, by) = (x.dot(&a2), y.dot(&a2));
        let zero = Vector3::zeros();
        // By d, which is dp + w × k2, and by w and gamma.
        let shifted = |by_d: Vector3<f64>| [by_d, k2.cross(&by_d), zero];
        let gamma = T::varying(0.0, || shifted((y - z * (by * per_bz)) * per_c));
        let turned = |by_gamma: f64| lift::<T, 1>(0.0, &[by_gamma], &[gamma]);
        let per_d = 1.0 / (1.0 - bx * bx);
        Ok(Self {
            station,
            c: T::varying(c, || shifted(x - z * (bx * per_bz))),
            lambda: T::varying(lambda, || shifted(z * -per_bz)),
            b: [
                turned(by) + T::varying(bx, || [zero, a2.cross(&x), zero]),
                turned(-bx) + T::varying(by, || [zero, a2.cross(&y), zero]),
                T::varying(bz, || [zero, a2.cross(&z), zero]),
            ],
            theta2: turned(bz * per_d) + T::varying(0.0, || [zero, (x * bx - a2) * per_d, zero]),
            gamma,
            axes: [x, y, z],
        })
    }

    /// Components of a vector that stands still in W.
    #[inline(always)]
    fn components(&self, v: &Vector3<f64>) -> ([T; 2], f64) {
        let [x, y, z] = self.axes.map(|axis| axis.dot(v));
        let of = |value: f64, slope: f64| lift(value, &[slope], &[self.gamma]);
        ([of(x, y), of(y, -x)], z)
    }

    /// The vector with the components `v`, W.
    #[inline(always)]
    pub(super) fn to_world(&self, v: &Vector3<T>) -> Vector3<T> {
        let turned = |value: T, slope: f64| value + lift::<T, 1>(0.0, &[slope], &[self.gamma]);
        let (x, y) = (turned(v.x, -v.y.re()), turned(v.y, v.x.re()));
        let [ex, ey, ez] = &self.axes;
        let component = |i: usize| x * ex[i] + y * ey[i] + v.z * ez[i];
        Vector3::new(component(0), component(1), component(2))
    }

    /// Twist of gear 2 against gear 1 at c2 while both move as `gears` tell: m/s, rad/s, components here.
    #[inline(always)]
    pub(super) fn twist(&self, [g1, g2]: &[Motion; 2]) -> Spatial<T> {
        let ([vx, vy], vz) = self.components(&(g2.v - g1.v));
        let ([w1x, w1y], w1z) = self.components(&g1.w);
        let ([w2x, w2y], w2z) = self.components(&g2.w);
        let [k2x, k2y, k2z] = self.k2();
        let (c, station) = (self.c, self.station);
        Spatial {
            linear: Vector3::new(
                vx + w2y * k2z - k2y * w2z - w1y * station,
                vy + k2x * w2z - w2x * k2z - c * w1z + w1x * station,
                w2x * k2y - w2y * k2x + w1y * c + vz,
            ),
            angular: Vector3::new(w2x - w1x, w2y - w1y, T::from(w2z - w1z)),
        }
    }

    /// Forces and moments on both gears about their origins, W, of the wrench `on_2` on gear 2 at c2 and its
    /// opposite on gear 1.
    #[inline(always)]
    pub(super) fn loads(&self, on_2: &Spatial<T>) -> [Spatial<T>; 2] {
        let (f, m) = (&on_2.linear, &on_2.angular);
        let [k2x, k2y, k2z] = self.k2();
        let (c, station) = (self.c, self.station);
        let about_2 = Vector3::new(
            m.x + k2y * f.z - k2z * f.y,
            m.y + k2z * f.x - k2x * f.z,
            m.z + k2x * f.y - k2y * f.x,
        );
        let about_1 = Vector3::new(
            f.y * station - m.x,
            c * f.z - f.x * station - m.y,
            -(c * f.y) - m.z,
        );
        let force = self.to_world(f);
        [
            Spatial {
                linear: -force,
                angular: self.to_world(&about_1),
            },
            Spatial {
                linear: force,
                angular: self.to_world(&about_2),
            },
        ]
    }

    /// c2 - p2.
    #[inline(always)]
    fn k2(&self) -> [T; 3] {
        let [x, y, z] = self.b;
        [x * self.lambda, y * self.lambda, z * self.lambda]
    }

    /// Without derivatives.
    pub(super) fn re(&self) -> LineFrame<f64> {
        LineFrame {
            axes: self.axes,
            station: self.station,
            c: self.c.re(),
            lambda: self.lambda.re(),
            b: self.b.map(T::re),
            gamma: 0.0,
            theta2: 0.0,
        }
    }
}
