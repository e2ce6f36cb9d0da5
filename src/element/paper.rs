//! The paper's formulation, equations (1)-(26), with its signs and references put right.
//!
//! Everything is relative to the carrier: x along O1 -> O2 in its transverse plane, z its axis,
//! y = z × x. The elongation holds rotations and the centre distance vector's direction alone; the
//! radial and axial displacement are left out, as in the paper, though the force has both components.
//! So the elastic part of this law does work on closed loops; the conjugate formulation does not.
//!
//! The damper opposes the rate of that elongation. It acts along the same row of the map, tangentially, for
//! there alone it cannot give energy; the radial and axial force of (9) follow the elastic force.

use super::check;
use super::constants::{Constants, TILT_LIMIT};
use super::error::ElementError;
use super::flank::FlankLoad;
use super::map::{Coordinates, Spatial};
use super::motion::{Inputs, Motion};
use super::scalar::{Scalar, angles};
use nalgebra::{Matrix3, Vector3};

/// Pose of one gear relative to the carrier, in carrier axes.
struct Relative<T> {
    p: Vector3<T>,
    /// Axis of the gear.
    a: Vector3<T>,
    /// Sine and cosine, to one factor, of the rotation about the carrier's axis: the twist of the swing-twist
    /// decomposition, which a static tilt does not disturb.
    twist: [T; 2],
}

fn relative<T: Scalar>(
    body: &'static str,
    gear: &Motion,
    carrier: &Motion,
) -> Result<Relative<T>, ElementError> {
    let moves = if body == "gear2" { 1.0 } else { 0.0 };
    let zero = Vector3::zeros();
    let between = gear.p - carrier.p;
    let p = |i: usize| {
        let e = carrier.r.column(i).into_owned();
        T::varying(e.dot(&between), || [e * moves, zero, e.cross(&between)])
    };
    let r = |i: usize, j: usize| {
        let (e, g) = (carrier.r.column(i), gear.r.column(j));
        T::varying(e.dot(&g), || {
            let turned = g.cross(&e);
            [zero, turned * moves, -turned]
        })
    };
    let a: Vector3<T> = Vector3::new(r(0, 2), r(1, 2), r(2, 2));
    check::tilt(body, "carrier", a.z.re(), TILT_LIMIT)?;
    Ok(Relative {
        p: Vector3::new(p(0), p(1), p(2)),
        a,
        twist: [r(1, 0) - r(0, 1), r(0, 0) + r(1, 1)],
    })
}

/// Both gears in the carrier.
pub(crate) struct Carried<T> {
    gears: [Relative<T>; 2],
    /// Distance of the axes in the carrier's transverse plane, (14).
    c: T,
    xh: Vector3<T>,
    yh: Vector3<T>,
    /// z1 (theta1 - gamma) + e z2 (theta2 - gamma), rad.
    tooth_angle: T,
    /// theta1 - gamma, rad.
    turned: T,
    /// Middle of the overlap of both faces over gear 1's z = 0 face, m.
    pub middle: T,
    /// Rotation of the carrier.
    to_world: Matrix3<f64>,
}

impl<T: Scalar> Carried<T> {
    /// # Errors
    /// Gears that are tilted against the carrier, base circles without a common tangent in its plane.
    pub(crate) fn new(k: &Constants, inputs: &Inputs) -> Result<Self, ElementError> {
        let g1 = relative::<T>("gear1", &inputs.gears[0], &inputs.carrier)?;
        let g2 = relative::<T>("gear2", &inputs.gears[1], &inputs.carrier)?;
        let d = g2.p - g1.p;
        let c = (d.x * d.x + d.y * d.y).sqrt();
        check::has_line_of_action(k, c.re())?;
        let (zero, one) = (T::from(0.0), T::from(1.0));
        let [theta1, theta2, gamma, _] = angles(
            [g1.twist[0], g2.twist[0], d.y, zero],
            [g1.twist[1], g2.twist[1], d.x, one],
        );
        let [b1, b2] = k.face_width;
        let low = if d.z.re() > 0.0 { d.z } else { zero };
        let high = if d.z.re() + b2 < b1 {
            d.z + b2
        } else {
            T::from(b1)
        };
        Ok(Self {
            c,
            xh: Vector3::new(d.x / c, d.y / c, zero),
            yh: Vector3::new(-d.y / c, d.x / c, zero),
            tooth_angle: (theta1 - gamma) * k.z[0]
                + (theta2 - gamma) * (k.e * k.z[1])
                + tooth_angle_zero(k),
            turned: theta1 - gamma,
            middle: (low + high) * 0.5,
            to_world: inputs.carrier.r,
            gears: [g1, g2],
        })
    }

    /// cos and sin of the operating pressure angle, (15).
    fn pressure_angle(&self, k: &Constants) -> (T, T) {
        let cosine = self.c.recip() * k.base_sum;
        (cosine, (-cosine * cosine + 1.0).sqrt())
    }

    /// (1), (14), (18) with n of (17), (13); the gap does not change with the centre distance.
    pub(crate) fn coordinates(&self, k: &Constants) -> Coordinates<T> {
        let [g1, g2] = &self.gears;
        let (cos_phi, sin_phi) = self.pressure_angle(k);
        let tilt = g1.a - g2.a;
        Coordinates {
            turn: self.tooth_angle * k.per_tooth_angle,
            half_gap: T::from(0.5 * k.backlash * k.base_sum / k.center_distance),
            center_distance: self.c,
            misalignment: [
                self.xh.dot(&tilt) * sin_phi * k.e,
                self.yh.dot(&tilt) * cos_phi * k.sc,
            ],
            mesh_angle: -self.turned,
            axial: g1.p.z - g2.p.z + k.z_ref,
        }
    }

    /// Pitch point in the plane `z` of gear 1, from its origin, in carrier axes, (10)-(11).
    fn pitch_point(&self, k: &Constants, z: T) -> Vector3<T> {
        let mut point = self.xh * (self.c * k.pitch_fraction);
        point.z += z;
        point
    }

    /// Forces and moments of the elastic forces of both flanks, W: F_2 = F_tt T of (9) at the point of (12), (26).
    pub(crate) fn elastic_loads(
        &self,
        k: &Constants,
        flanks: &[FlankLoad<T>; 2],
    ) -> [Spatial<T>; 2] {
        let (cos_phi, sin_phi) = self.pressure_angle(k);
        let tan_phi = sin_phi / cos_phi;
        let tan_beta_w = self.c * (k.z[0] / k.tooth_sum * k.tan_beta_per_radius);
        let between = self.gears[1].p - self.gears[0].p;
        let mut total = [Spatial {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }; 2];
        for flank in flanks {
            let s = flank.sign;
            let mut direction = self.xh * (tan_phi * k.e) + self.yh * T::from(s * k.sc);
            direction.z -= tan_beta_w * (s * k.hand);
            let force = direction * (flank.elastic * cos_phi);
            let point = self.pitch_point(k, self.middle + flank.arm);
            let on_1 = Spatial {
                linear: -force,
                angular: -point.cross(&force),
            };
            let on_2 = Spatial {
                linear: force,
                angular: (point - between).cross(&force),
            };
            total = [total[0] + on_1, total[1] + on_2];
        }
        total.map(|load| Spatial {
            linear: self.to_world(&load.linear),
            angular: self.to_world(&load.angular),
        })
    }

    /// Contact point from gear 1's origin, W, and its axial position, with the resultant `arm` beyond mid-face.
    pub(crate) fn contact(&self, k: &Constants, arm: T) -> (Vector3<T>, T) {
        let z = self.middle + arm;
        (self.to_world(&self.pitch_point(k, z)), z)
    }

    /// The vector with the components `v` in the carrier, W.
    fn to_world(&self, v: &Vector3<T>) -> Vector3<T> {
        let still = v.map(T::re);
        let [ex, ey, ez] = [0, 1, 2].map(|j| self.to_world.column(j).into_owned());
        let component = |i: usize| {
            // Turning with the carrier: rotation x vector.
            let turned = T::varying(0.0, || {
                let [none, axis] = [Vector3::zeros(), Vector3::ith(i, 1.0)];
                [none, none, (self.to_world * still).cross(&axis)]
            });
            v.x * ex[i] + v.y * ey[i] + v.z * ez[i] + turned
        };
        Vector3::new(component(0), component(1), component(2))
    }
}

/// Tooth angle of the `absolute` reference at theta1 = theta2 = gamma, rad, mid-face, nominal faces.
fn tooth_angle_zero(k: &Constants) -> f64 {
    let w = k.pitch_fraction;
    let behind = |is: bool| if is { std::f64::consts::PI } else { 0.0 };
    k.tooth_zero - k.z[0] * behind(w < 0.0) - k.e * k.z[1] * behind(w < 1.0)
        + k.hand * k.face_offset * k.tan_beta_b * k.z[0] / k.rb[0]
}
