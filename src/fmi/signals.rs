//! The inputs as functions of time, and as poses and velocities.
//!
//! Within a communication step each input follows its Taylor polynomial about the start of the step
//! (fmi2SetRealInputDerivatives); a step moves value and derivatives to its end, so that an input
//! that is not set anew goes on along its polynomial.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::report::Refusal;
use super::variables::{INPUT_COUNT, VARIABLES, index};
use crate::element::{Inputs, Motion};

/// Highest order of input derivatives that is taken.
pub const MAXIMUM_ORDER: usize = 3;

/// Departure of a quaternion's length from 1 above which it is refused. Integrators and linear
/// interpolation between orientations 10 degrees apart stay below.
pub const QUATERNION_TOLERANCE: f64 = 1e-2;

/// Inputs of one body and their places in its block.
const BLOCK: usize = index::GEAR2_POSITION_1 - index::GEAR1_POSITION_1;
const POSITION: usize = 0;
const ANGLES: usize = index::GEAR1_ANGLES_1 - index::GEAR1_POSITION_1;
const QUATERNION: usize = index::GEAR1_QUATERNION_1 - index::GEAR1_POSITION_1;
const VELOCITY: usize = index::GEAR1_VELOCITY_1 - index::GEAR1_POSITION_1;
const ANGULAR_VELOCITY: usize = index::GEAR1_ANGULAR_VELOCITY_1 - index::GEAR1_POSITION_1;

const _: () = {
    assert!(index::GEAR1_POSITION_1 == 0 && INPUT_COUNT == 3 * BLOCK);
    assert!(index::CARRIER_POSITION_1 == 2 * BLOCK);
    assert!(index::CARRIER_ANGULAR_VELOCITY_3 == INPUT_COUNT - 1);
};

/// Which inputs give the orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Cardan angles: R = Rx(a1) Ry(a2) Rz(a3).
    Angles,
    /// Quaternions w x y z, normalised on entry.
    Quaternion,
}

/// Values and time derivatives of all inputs at the current communication point.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    /// Values in the order of the variables.
    pub value: [f64; INPUT_COUNT],
    /// Derivatives of order 1, 2, .. of each input.
    pub derivative: [[f64; MAXIMUM_ORDER]; INPUT_COUNT],
    /// Whether the host gave derivatives of this input since its value was last set.
    pub given: [bool; INPUT_COUNT],
}

impl Signals {
    /// Constant inputs.
    pub fn constant(value: [f64; INPUT_COUNT]) -> Self {
        Self {
            value,
            derivative: [[0.0; MAXIMUM_ORDER]; INPUT_COUNT],
            given: [false; INPUT_COUNT],
        }
    }

    /// fmi2SetReal: a new value clears the derivatives.
    pub fn set(&mut self, i: usize, value: f64) {
        self.value[i] = value;
        self.derivative[i] = [0.0; MAXIMUM_ORDER];
        self.given[i] = false;
    }

    /// fmi2SetRealInputDerivatives, `order` from 1 to [`MAXIMUM_ORDER`].
    pub fn set_derivative(&mut self, i: usize, order: usize, value: f64) {
        self.derivative[i][order - 1] = value;
        self.given[i] = true;
    }

    /// Moves all inputs on by `h` s. With `poses`, the pose of a body none of whose position and
    /// orientation derivatives were given moves with the body's velocity inputs.
    pub fn advance(&mut self, h: f64, poses: bool, orientation: Orientation) {
        if poses {
            for body in 0..3 {
                self.advance_pose(body * BLOCK, h, orientation);
            }
        }
        // Derivatives are zero but where given.
        if !self.given.contains(&true) {
            return;
        }
        for (value, derivative) in self.value.iter_mut().zip(&mut self.derivative) {
            if derivative.iter().all(|d| *d == 0.0) {
                continue;
            }
            *value += taylor(derivative, h) * h;
            for k in 0..MAXIMUM_ORDER - 1 {
                derivative[k] += taylor(&derivative[k + 1..], h) * h;
            }
        }
    }

    fn advance_pose(&mut self, start: usize, h: f64, orientation: Orientation) {
        if self.given[start..start + VELOCITY].contains(&true) {
            return;
        }
        // Way over the step: the velocity's polynomial integrated.
        let way = |s: &Self, at: usize| {
            Vector3::from_fn(|k, _| {
                let i = start + at + k;
                let [d1, d2, d3] = s.derivative[i];
                h * (s.value[i] + h / 2.0 * (d1 + h / 3.0 * (d2 + h / 4.0 * d3)))
            })
        };
        let moved = way(self, VELOCITY);
        let turned = way(self, ANGULAR_VELOCITY);
        if moved == Vector3::zeros() && turned == Vector3::zeros() {
            return;
        }
        for k in 0..3 {
            self.value[start + POSITION + k] += moved[k];
        }
        match orientation {
            Orientation::Angles => {
                let a = self.vector(start + ANGLES);
                // At 90 degrees of the middle angle the rates do not exist; the pose then rests.
                if let Some(inverse) = cardan_axes(&a).try_inverse() {
                    let change = inverse * turned;
                    for k in 0..3 {
                        self.value[start + ANGLES + k] += change[k];
                    }
                }
            }
            Orientation::Quaternion => {
                let q = UnitQuaternion::from_scaled_axis(turned).into_inner()
                    * self.quaternion(start + QUATERNION);
                for (k, c) in [q.w, q.i, q.j, q.k].into_iter().enumerate() {
                    self.value[start + QUATERNION + k] = c;
                }
            }
        }
    }

    fn vector(&self, i: usize) -> Vector3<f64> {
        Vector3::new(self.value[i], self.value[i + 1], self.value[i + 2])
    }

    fn quaternion(&self, i: usize) -> Quaternion<f64> {
        Quaternion::new(
            self.value[i],
            self.value[i + 1],
            self.value[i + 2],
            self.value[i + 3],
        )
    }

    /// The inputs as the element takes them.
    ///
    /// # Errors
    /// A quaternion in use whose length is not 1 within [`QUATERNION_TOLERANCE`].
    pub fn motions(&self, orientation: Orientation) -> Result<Inputs, Refusal> {
        Ok(Inputs {
            gears: [
                self.motion(0, orientation)?,
                self.motion(BLOCK, orientation)?,
            ],
            carrier: self.motion(2 * BLOCK, orientation)?,
        })
    }

    fn motion(&self, start: usize, orientation: Orientation) -> Result<Motion, Refusal> {
        let r = match orientation {
            Orientation::Angles => cardan(&self.vector(start + ANGLES)),
            Orientation::Quaternion => {
                let q = self.quaternion(start + QUATERNION);
                let length = q.norm();
                let is_unit = (length - 1.0).abs() <= QUATERNION_TOLERANCE; // never for NaN
                if !is_unit {
                    let name = VARIABLES[start + QUATERNION].name.trim_end_matches("[1]");
                    return Err(Refusal::error(format!(
                        "{name} has the length {length}; it must be 1 within \
                         {QUATERNION_TOLERANCE}: normalise it, or set orientationInput = angles"
                    )));
                }
                UnitQuaternion::new_unchecked(q / length)
                    .to_rotation_matrix()
                    .into_inner()
            }
        };
        Ok(Motion {
            p: self.vector(start + POSITION),
            r,
            v: self.vector(start + VELOCITY),
            w: self.vector(start + ANGULAR_VELOCITY),
        })
    }

    /// What a change of input `i` at unit rate does to the motions: body (0, 1, 2), and which of
    /// small translation, small rotation (both world axes), velocity, angular velocity changes.
    pub fn direction(&self, i: usize, orientation: Orientation) -> (usize, Part, Vector3<f64>) {
        let (body, k) = (i / BLOCK, i % BLOCK);
        let start = body * BLOCK;
        let unit = |at: usize| Vector3::ith(k - at, 1.0);
        let none = Vector3::zeros();
        match k {
            k if k < ANGLES => (body, Part::Translation, unit(POSITION)),
            k if k < QUATERNION => match orientation {
                Orientation::Angles => {
                    let axes = cardan_axes(&self.vector(start + ANGLES));
                    (body, Part::Rotation, axes.column(k - ANGLES).into_owned())
                }
                Orientation::Quaternion => (body, Part::Rotation, none),
            },
            k if k < VELOCITY => match orientation {
                Orientation::Quaternion => {
                    let q = self.quaternion(start + QUATERNION);
                    let mut dq = Quaternion::new(0.0, 0.0, 0.0, 0.0);
                    match k - QUATERNION {
                        0 => dq.w = 1.0,
                        c => dq.coords[c - 1] = 1.0,
                    }
                    // Vector part of 2 dq q*; the change of length is its scalar part.
                    let rate = (dq * q.conjugate()) * (2.0 / q.norm_squared());
                    (body, Part::Rotation, rate.imag())
                }
                Orientation::Angles => (body, Part::Rotation, none),
            },
            k if k < ANGULAR_VELOCITY => (body, Part::Velocity, unit(VELOCITY)),
            _ => (body, Part::AngularVelocity, unit(ANGULAR_VELOCITY)),
        }
    }

    /// Time derivatives of the velocity inputs: acceleration and angular acceleration of `body`.
    pub fn acceleration(&self, body: usize) -> [Vector3<f64>; 2] {
        [VELOCITY, ANGULAR_VELOCITY]
            .map(|at| Vector3::from_fn(|k, _| self.derivative[body * BLOCK + at + k][0]))
    }
}

/// Part of a body's motion that an input acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Small displacement of the origin, world.
    Translation,
    /// Small rotation vector, world.
    Rotation,
    /// Velocity of the origin.
    Velocity,
    /// Angular velocity.
    AngularVelocity,
}

/// d1 + d2 h/2! + d3 h^2/3! + ...
fn taylor(derivative: &[f64], h: f64) -> f64 {
    derivative
        .iter()
        .enumerate()
        .rev()
        .fold(0.0, |sum, (k, d)| (sum * h + d) / (k as f64 + 1.0))
}

/// Rx(a1) Ry(a2) Rz(a3).
fn cardan(a: &Vector3<f64>) -> Matrix3<f64> {
    let (s1, c1) = a.x.sin_cos();
    let (s2, c2) = a.y.sin_cos();
    let (s3, c3) = a.z.sin_cos();
    Matrix3::new(
        c2 * c3,
        -c2 * s3,
        s2,
        c1 * s3 + s1 * s2 * c3,
        c1 * c3 - s1 * s2 * s3,
        -s1 * c2,
        s1 * s3 - c1 * s2 * c3,
        s1 * c3 + c1 * s2 * s3,
        c1 * c2,
    )
}

/// World axes about which the three Cardan angles turn: x, Rx y, Rx Ry z.
fn cardan_axes(a: &Vector3<f64>) -> Matrix3<f64> {
    let (s1, c1) = a.x.sin_cos();
    let (s2, c2) = a.y.sin_cos();
    Matrix3::new(1.0, 0.0, s2, 0.0, c1, -s1 * c2, 0.0, s1, c1 * c2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::Rotation3;

    fn signals() -> Signals {
        let mut s = Signals::constant([0.0; INPUT_COUNT]);
        for body in 0..3 {
            s.value[body * BLOCK + QUATERNION] = 1.0;
        }
        s
    }

    #[test]
    fn angles_turn_about_x_then_the_new_y_then_the_new_z() {
        let a = Vector3::new(0.3, -0.4, 5.0);
        let product = Rotation3::from_axis_angle(&Vector3::x_axis(), a.x)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), a.y)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), a.z);
        assert_abs_diff_eq!(cardan(&a), product.into_inner(), epsilon = 1e-15);
    }

    #[test]
    fn an_input_follows_its_polynomial_over_two_steps() {
        let mut s = signals();
        let p = |t: f64| 2.0 + 3.0 * t - 0.5 * t * t + 4.0 * t * t * t;
        s.value[0] = p(0.0);
        s.set_derivative(0, 1, 3.0);
        s.set_derivative(0, 2, -1.0);
        s.set_derivative(0, 3, 24.0);
        s.advance(0.25, false, Orientation::Angles);
        s.advance(0.5, false, Orientation::Angles);
        assert_abs_diff_eq!(s.value[0], p(0.75), epsilon = 1e-14);
        s.set(0, 1.0);
        s.advance(1.0, false, Orientation::Angles);
        assert_eq!(s.value[0], 1.0);
    }

    #[test]
    fn both_orientation_inputs_move_alike_with_the_angular_velocity() {
        let h = 1e-4;
        let mut s = signals();
        let a = Vector3::new(2e-3, -1e-3, 0.7);
        let q = UnitQuaternion::from_matrix(&cardan(&a));
        for k in 0..3 {
            s.value[ANGLES + k] = a[k];
            s.value[VELOCITY + k] = 0.1 * (k as f64 + 1.0);
            s.value[ANGULAR_VELOCITY + k] = [0.3, -0.2, 200.0][k];
        }
        for (k, c) in [q.w, q.i, q.j, q.k].into_iter().enumerate() {
            s.value[QUATERNION + k] = c;
        }
        let mut t = s.clone();
        s.advance(h, true, Orientation::Angles);
        t.advance(h, true, Orientation::Quaternion);
        let (r, m) = (
            s.motions(Orientation::Angles).unwrap().gears[0],
            t.motions(Orientation::Quaternion).unwrap().gears[0],
        );
        // The angles move to first order: what remains is tilt x turn^2.
        assert_abs_diff_eq!(r.r, m.r, epsilon = 1e-6);
        assert_abs_diff_eq!(r.p, Vector3::new(1e-5, 2e-5, 3e-5), epsilon = 1e-18);
        assert_abs_diff_eq!(m.p, r.p, epsilon = 0.0);
    }

    #[test]
    fn directions_of_orientation_inputs_are_small_rotations_of_the_world() {
        let mut s = signals();
        let a = [0.1, -0.2, 2.0];
        let q = UnitQuaternion::from_matrix(&cardan(&Vector3::from(a))).into_inner() * 1.003;
        s.value[ANGLES..ANGLES + 3].copy_from_slice(&a);
        for (k, c) in [q.w, q.i, q.j, q.k].into_iter().enumerate() {
            s.value[QUATERNION + k] = c;
        }
        let step = 1e-6;
        for (from, count, orientation) in [
            (ANGLES, 3, Orientation::Angles),
            (QUATERNION, 4, Orientation::Quaternion),
        ] {
            for i in from..from + count {
                let (_, part, rotation) = s.direction(i, orientation);
                assert_eq!(part, Part::Rotation);
                let at = |sign: f64| {
                    let mut moved = s.clone();
                    moved.value[i] += sign * step;
                    moved.motions(orientation).unwrap().gears[0].r
                };
                let r = s.motions(orientation).unwrap().gears[0].r;
                let skew = (at(1.0) - at(-1.0)) / (2.0 * step) * r.transpose();
                let found = Vector3::new(skew.m32, skew.m13, skew.m21);
                assert_abs_diff_eq!(found, rotation, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn a_quaternion_far_from_unit_length_is_refused_by_name() {
        let mut s = signals();
        s.value[BLOCK + QUATERNION] = 1.004;
        let r = s.motions(Orientation::Quaternion).unwrap().gears[1].r;
        assert_abs_diff_eq!(r, Matrix3::identity(), epsilon = 1e-15);
        s.value[BLOCK + QUATERNION] = 1.1;
        let error = s.motions(Orientation::Quaternion).unwrap_err();
        assert!(
            error
                .message
                .starts_with("gear2.quaternion has the length 1.1")
        );
        assert!(s.motions(Orientation::Angles).is_ok());
    }
}
