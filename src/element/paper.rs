//! The paper's formulation, equations (1)-(26), with its signs and references put right.
//!
//! Everything is relative to the carrier: x along O1 -> O2 in its transverse plane, z its axis,
//! y = z × x. The penetration holds rotations and the centre distance vector's direction alone; the
//! radial and axial displacement are left out, as in the paper, though the force has both components.
//! So the elastic part of this law does work on closed loops; the conjugate formulation does not.
//!
//! The damper opposes the rate of that penetration. It acts along the same row of the map, tangentially, for
//! there alone it cannot give energy; the radial and axial force of (9) follow the elastic force.

use super::constants::{Constants, behind};
use super::dual::{Scalar, angles, cross, dot, part, scaled, shifted, turned};
use super::engagement::face_overlap;
use super::flank::FlankLoad;
use super::kinematics::{Coordinates, Spatial, check_tilt};
use super::motion::{ElementError, Inputs, Motion};
use nalgebra::Vector3;

/// Both gears in the carrier.
pub(crate) struct Carried<T> {
    /// Axes of the carrier, W.
    axes: [Vector3<T>; 3],
    /// From gear 1's origin to gear 2's, in carrier axes, m.
    between: Vector3<T>,
    /// Axis of gear 1 less that of gear 2.
    tilt: Vector3<T>,
    /// Distance of the axes in the carrier's transverse plane, (14).
    c: T,
    xh: Vector3<T>,
    yh: Vector3<T>,
    /// z1 (theta1 - gamma) + e z2 (theta2 - gamma), rad.
    tooth_angle: T,
    /// gamma - theta1, rad.
    mesh_angle: T,
    /// Middle of the overlap of both faces over gear 1's z = 0 face, m.
    pub middle: T,
}

impl<T: Scalar> Carried<T> {
    /// Errors: gears that are tilted against the carrier, base circles without a common tangent in its plane.
    #[inline(always)]
    pub(crate) fn new(k: &Constants, inputs: &Inputs) -> Result<Self, ElementError> {
        let [g1, g2] = &inputs.gears;
        let column = |body: &Motion, axis: usize| body.r.column(axis).into_owned();
        let axis = |i: usize| turned::<T>(&column(&inputs.carrier, i), part::CARRIER_ROTATION);
        let axes = [axis(0), axis(1), axis(2)];
        let (x1, y1, z1) = (column(g1, 0), column(g1, 1), column(g1, 2));
        let axis = |i: usize| turned::<T>(&column(g2, i), part::ROTATION_2);
        let (x2, y2, z2) = (axis(0), axis(1), axis(2));
        // Components of the gears' axes along those of the carrier.
        let a1 = Vector3::new(dot(&axes[0], &z1), dot(&axes[1], &z1), dot(&axes[2], &z1));
        let a2 = components(&z2, &axes);
        check_tilt("gear1", "carrier", a1.z.re())?;
        check_tilt("gear2", "carrier", a2.z.re())?;
        let between = components(&shifted(&(g2.p - g1.p), part::POSITION_2), &axes);
        let c = (between.x * between.x + between.y * between.y).sqrt();
        k.has_line_of_action(c.re())?;
        // Rotation about the carrier's axis: the twist of the swing-twist decomposition, which a static tilt does not disturb.
        let [ex, ey, _] = &axes;
        let (zero, one) = (T::from(0.0), T::from(1.0));
        let [theta1, theta2, gamma, _] = angles(
            [
                dot(ey, &x1) - dot(ex, &y1),
                dot(ey, &x2) - dot(ex, &y2),
                between.y,
                zero,
            ],
            [
                dot(ex, &x1) + dot(ey, &y1),
                dot(ex, &x2) + dot(ey, &y2),
                between.x,
                one,
            ],
        );
        let [(low, _), (high, _)] = face_overlap(k, between.z);
        // Tooth angle of the `absolute` reference at theta1 = theta2 = gamma, mid-face, nominal faces.
        let w = k.pitch_fraction;
        let tooth_angle_zero = k.tooth_zero - k.z[0] * behind(w) - k.e * k.z[1] * behind(w - 1.0)
            + k.hand * k.face_offset * k.tan_beta_b * k.z[0] / k.base_radius[0];
        Ok(Self {
            axes,
            tilt: a1 - a2,
            c,
            xh: Vector3::new(between.x / c, between.y / c, zero),
            yh: Vector3::new(-between.y / c, between.x / c, zero),
            tooth_angle: (theta1 - gamma) * k.z[0]
                + (theta2 - gamma) * (k.e * k.z[1])
                + tooth_angle_zero,
            mesh_angle: gamma - theta1,
            middle: (low + high) * 0.5,
            between,
        })
    }

    /// cos and sin of the operating pressure angle, (15).
    #[inline(always)]
    fn pressure_angle(&self, k: &Constants) -> (T, T) {
        let cosine = self.c.recip() * k.base_radius_sum;
        (cosine, (-cosine * cosine + 1.0).sqrt())
    }

    /// (1), (14), (18) with n of (17), (13); the gap does not change with the centre distance.
    #[inline(always)]
    pub(crate) fn coordinates(&self, k: &Constants) -> Coordinates<T> {
        let (cos_phi, sin_phi) = self.pressure_angle(k);
        Coordinates {
            turn: self.tooth_angle * k.per_tooth_angle,
            half_gap: T::from(0.5 * k.backlash * k.base_radius_sum / k.center_distance),
            center_distance: self.c,
            misalignment: [
                dot(&self.xh, &self.tilt) * sin_phi * k.e,
                dot(&self.yh, &self.tilt) * cos_phi * k.sc,
            ],
            mesh_angle: self.mesh_angle,
            axial: -self.between.z + k.z_ref,
        }
    }

    /// Pitch point in the plane `z` of gear 1, from its origin, in carrier axes, (10)-(11).
    #[inline(always)]
    fn pitch_point(&self, k: &Constants, z: T) -> Vector3<T> {
        let mut point = scaled(&self.xh, self.c * k.pitch_fraction);
        point.z += z;
        point
    }

    /// Adds forces and moments of the elastic forces of both flanks, W: F_2 = F_tt T of (9) at the point of (12), (26).
    #[inline(always)]
    pub(crate) fn add_elastic_loads(
        &self,
        k: &Constants,
        flanks: &[FlankLoad<T>; 2],
        loads: &mut [Spatial<T>; 2],
    ) {
        let (cos_phi, sin_phi) = self.pressure_angle(k);
        let tan_phi = sin_phi / cos_phi;
        let tan_beta_w = self.c * (k.pitch_fraction.abs() * k.tan_beta_per_radius);
        for flank in flanks {
            if flank.elastic.re() <= 0.0 {
                continue;
            }
            let s = flank.sign;
            let mut direction = scaled(&self.xh, tan_phi * k.e) + self.yh.map(|y| y * (s * k.sc));
            direction.z -= tan_beta_w * (s * k.hand);
            let force = scaled(&direction, flank.elastic * cos_phi);
            let point = self.pitch_point(k, self.middle + flank.arm);
            let linear = self.in_world(&force);
            let about_1 = self.in_world(&cross(&point, &force));
            let about_2 = self.in_world(&cross(&(point - self.between), &force));
            loads[0].linear -= linear;
            loads[0].angular -= about_1;
            loads[1].linear += linear;
            loads[1].angular += about_2;
        }
    }

    /// Contact point from gear 1's origin, W, and its axial position, with the resultant `arm` beyond mid-face.
    #[inline(always)]
    pub(crate) fn contact(&self, k: &Constants, arm: T) -> (Vector3<T>, T) {
        let z = self.middle + arm;
        (self.in_world(&self.pitch_point(k, z)), z)
    }

    /// The vector with the components `v` in the carrier, W.
    #[inline(always)]
    fn in_world(&self, v: &Vector3<T>) -> Vector3<T> {
        let [ex, ey, ez] = &self.axes;
        scaled(ex, v.x) + scaled(ey, v.y) + scaled(ez, v.z)
    }
}

#[inline(always)]
fn components<T: Scalar>(v: &Vector3<T>, axes: &[Vector3<T>; 3]) -> Vector3<T> {
    Vector3::new(dot(v, &axes[0]), dot(v, &axes[1]), dot(v, &axes[2]))
}
