//! The inputs: their values, how they move over a communication step, and the motions of the bodies that they give.
//!
//! An input whose derivatives the host gave (fmi2SetRealInputDerivatives) follows its Taylor polynomial over the coming
//! step, whether its value was set before them or after; it stays where the polynomial ends.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::Refusal;
use super::parameters::Orientation;
use super::variables::{INPUTS, VARIABLES};
use crate::element::{BODY_COLUMNS, Motion};
use crate::words::number;

/// The bodies as the names of their variables begin, in the order of their inputs.
pub const BODIES: [&str; 3] = ["gear1", "gear2", "carrier"];
/// Inputs of one body, all Real; body `b` has the variables from `b * BODY_INPUTS` on.
pub const BODY_INPUTS: usize = 16;
const _: () = assert!(INPUTS == BODIES.len() * BODY_INPUTS);
/// Offset of the position, 3 inputs, among those of a body.
pub const POSITION: usize = 0;
/// Of the Cardan angles, 3 inputs.
pub const ANGLES: usize = 3;
/// Of the quaternion w x y z, 4 inputs.
pub const QUATERNION: usize = 6;
/// Of the velocity, 3 inputs.
pub const VELOCITY: usize = 10;
/// Of the angular velocity, 3 inputs.
pub const ANGULAR_VELOCITY: usize = 13;

/// Highest order of input derivatives that is taken.
pub const MAXIMUM_ORDER: usize = 3;

/// Derivatives of order 1, 2, .. of one input.
type Derivatives = [f64; MAXIMUM_ORDER];

/// Departure of a quaternion's length from 1 above which it is refused. Integrators and linear
/// interpolation between orientations 10 degrees apart stay below.
const QUATERNION_TOLERANCE: f64 = 1e-2;

/// Values and derivatives of all inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputValues {
    /// By body.
    values: [[f64; BODY_INPUTS]; BODIES.len()],
    /// Time derivatives at the current communication point, by input, where the host gave some.
    derivatives: BTreeMap<usize, Derivatives>,
    /// Whether the step is done that the derivatives were given for.
    derivatives_spent: bool,
}

/// Sizes above which the rounding of a number alone moves the teeth.
#[derive(Debug, Clone, Copy)]
pub struct Resolution {
    /// Of an angle, rad.
    pub angle: f64,
    /// Of a coordinate, m.
    pub position: f64,
}

impl Resolution {
    /// Of a gear with `teeth` teeth `pitch` metres apart. Tables resolve a thousandth of the
    /// penetration under load, which is about a thousandth of a pitch: a number whose own rounding is
    /// more than a millionth of a pitch says nothing to them.
    pub fn new(teeth: f64, pitch: f64) -> Self {
        const SHARE: f64 = 1e-6 / f64::EPSILON;
        Self {
            angle: SHARE * std::f64::consts::TAU / teeth,
            position: SHARE * pitch,
        }
    }
}

impl InputValues {
    /// Constant, with the first of `values`.
    pub fn new(values: &[f64]) -> Self {
        let (bodies, _) = values.as_chunks();
        Self {
            values: std::array::from_fn(|body| bodies[body]),
            derivatives: BTreeMap::new(),
            derivatives_spent: false,
        }
    }

    /// Input `i`.
    pub fn get(&self, i: usize) -> f64 {
        self.values.as_flattened()[i]
    }

    /// Sets input `i`.
    #[inline]
    pub fn set(&mut self, i: usize, value: f64) {
        self.values.as_flattened_mut()[i] = value;
    }

    /// Sets the inputs from `first` on.
    #[inline]
    pub fn set_from(&mut self, first: usize, values: impl Iterator<Item = f64>) {
        let inputs = &mut self.values.as_flattened_mut()[first..];
        for (input, value) in inputs.iter_mut().zip(values) {
            *input = value;
        }
    }

    /// Sets the derivative of `order` (1 to [`MAXIMUM_ORDER`]) of input `i` for the coming step.
    pub fn set_derivative(&mut self, i: usize, order: usize, value: f64) {
        if std::mem::take(&mut self.derivatives_spent) {
            self.derivatives.clear();
        }
        self.derivatives.entry(i).or_default()[order - 1] = value;
    }

    /// The inputs `h` s later, at the end of a communication step; `None`: they are constant.
    pub fn after(&self, h: f64) -> Option<Self> {
        if self.derivatives.is_empty() {
            return None;
        }
        let mut end = self.clone();
        if end.derivatives_spent {
            end.derivatives.clear();
        }
        let values = end.values.as_flattened_mut();
        for (i, derivatives) in &mut end.derivatives {
            values[*i] += taylor(derivatives, h) * h;
            for k in 0..MAXIMUM_ORDER - 1 {
                derivatives[k] += taylor(&derivatives[k + 1..], h) * h;
            }
        }
        end.derivatives_spent = true;
        Some(end)
    }

    /// The first input that is not finite or has derivatives that are not, or that is none.
    pub fn fault(&self) -> Option<usize> {
        let mut derivatives = self.derivatives.iter();
        let bad = derivatives.find(|(i, d)| **i >= INPUTS || d.iter().any(|x| !x.is_finite()));
        let mut values = self.values.as_flattened().iter();
        bad.map(|(i, _)| (*i).min(INPUTS - 1))
            .or_else(|| values.position(|x| !x.is_finite()))
    }

    /// Index of the largest input in size.
    pub fn largest(&self) -> usize {
        let size = |i: &usize| self.get(*i).abs();
        (0..INPUTS)
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .unwrap_or(0)
    }

    fn vector(&self, body: usize, offset: usize) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.values[body][offset + k])
    }

    fn quaternion(&self, body: usize) -> Quaternion<f64> {
        quaternion(&self.values[body][QUATERNION..VELOCITY])
    }

    /// Rates of a body in the order of the columns of [`crate::element::Jacobian`]: velocity and angular velocity, which
    /// are those of its pose, then their own derivatives.
    pub fn rates(&self, body: usize) -> [Vector3<f64>; BODY_COLUMNS / 3] {
        let acceleration = |offset: usize| {
            let first = body * BODY_INPUTS + offset;
            Vector3::from_fn(|k, _| self.derivatives.get(&(first + k)).map_or(0.0, |d| d[0]))
        };
        [
            self.vector(body, VELOCITY),
            self.vector(body, ANGULAR_VELOCITY),
            acceleration(VELOCITY),
            acceleration(ANGULAR_VELOCITY),
        ]
    }

    /// Writes the motion of a body as the element takes it.
    /// Errors: a quaternion in use whose length is not 1 within `QUATERNION_TOLERANCE`; angles and positions
    /// beyond `resolution`.
    #[inline]
    pub fn write_motion(
        &self,
        body: usize,
        orientation: Orientation,
        resolution: Resolution,
        motion: &mut Motion,
    ) -> Result<(), Refusal> {
        motion.r = match orientation {
            Orientation::Angles => {
                let limit = resolution.angle;
                cardan(&self.resolved(body, ANGLES, limit, "rad", "take off whole turns")?)
            }
            Orientation::Quaternion => {
                let q = self.quaternion(body);
                let length = q.norm();
                let is_unit = (length - 1.0).abs() <= QUATERNION_TOLERANCE; // never for NaN
                if !is_unit {
                    return Err(Refusal::discard(format!(
                        "{}.quaternion has the length {}; it must be 1 within \
                         {QUATERNION_TOLERANCE}: normalise it, or set orientationInput = angles",
                        BODIES[body],
                        number(length)
                    )));
                }
                let q = UnitQuaternion::new_unchecked(q / length);
                q.to_rotation_matrix().into_inner()
            }
        };
        let (limit, remedy) = (resolution.position, "put the origin of the world nearer");
        motion.p = self.resolved(body, POSITION, limit, "m", remedy)?;
        motion.v = self.vector(body, VELOCITY);
        motion.w = self.vector(body, ANGULAR_VELOCITY);
        Ok(())
    }

    /// Three inputs of a body, refused where their rounding alone would matter.
    #[inline(always)]
    fn resolved(
        &self,
        body: usize,
        offset: usize,
        limit: f64,
        unit: &str,
        remedy: &str,
    ) -> Result<Vector3<f64>, Refusal> {
        let v = self.vector(body, offset);
        let Some(k) = v.iter().position(|x| x.abs() > limit) else {
            return Ok(v);
        };
        Err(Refusal::discard(format!(
            "{} = {} {unit}: above {limit:.1e} {unit} its own rounding moves the teeth by more \
             than the table resolves; {remedy}",
            VARIABLES[body * BODY_INPUTS + offset + k].name,
            number(v[k])
        )))
    }

    /// What a change of input `i` at unit rate does to its body: the first of the three columns of
    /// [`crate::element::Jacobian`], and the change there, world axes.
    pub fn direction(&self, i: usize, orientation: Orientation) -> (usize, Vector3<f64>) {
        let (body, k) = (i / BODY_INPUTS, i % BODY_INPUTS);
        let unit = |offset: usize| Vector3::ith(k - offset, 1.0);
        let (column, change) = match (k, orientation) {
            (POSITION..ANGLES, _) => (0, unit(POSITION)),
            (ANGLES..QUATERNION, Orientation::Angles) => {
                let axes = cardan_axes(&self.vector(body, ANGLES));
                (3, axes.column(k - ANGLES).into_owned())
            }
            (QUATERNION..VELOCITY, Orientation::Quaternion) => {
                let q = self.quaternion(body);
                let mut unit = [0.0; 4];
                unit[k - QUATERNION] = 1.0;
                let dq = quaternion(&unit);
                // Vector part of 2 dq q*; the change of length is its scalar part.
                (3, ((dq * q.conjugate()) * (2.0 / q.norm_squared())).imag())
            }
            (VELOCITY..ANGULAR_VELOCITY, _) => (6, unit(VELOCITY)),
            (ANGULAR_VELOCITY.., _) => (9, unit(ANGULAR_VELOCITY)),
            // The orientation that is not in use.
            _ => (3, Vector3::zeros()),
        };
        (body * BODY_COLUMNS + column, change)
    }
}

/// Of components in the order w x y z.
fn quaternion(q: &[f64]) -> Quaternion<f64> {
    Quaternion::new(q[0], q[1], q[2], q[3])
}

/// d1 + d2 h/2! + d3 h^2/3! + ...
fn taylor(derivatives: &[f64], h: f64) -> f64 {
    derivatives
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

    const FINE: Resolution = Resolution {
        angle: 1e9,
        position: 1e9,
    };

    fn values() -> InputValues {
        let mut inputs = InputValues::new(&[0.0; INPUTS]);
        for body in 0..BODIES.len() {
            inputs.set(body * BODY_INPUTS + QUATERNION, 1.0);
        }
        inputs
    }

    fn pose(inputs: &InputValues, orientation: Orientation) -> Motion {
        let mut motion = Motion::default();
        inputs
            .write_motion(0, orientation, FINE, &mut motion)
            .unwrap();
        motion
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
    fn what_the_teeth_do_not_resolve_is_refused_by_name() {
        let (teeth, pitch) = (20.0, 12e-3);
        let resolution = Resolution::new(teeth, pitch);
        // Rounding of the largest angle and coordinate, in pitches.
        let turn = resolution.angle * f64::EPSILON * teeth / std::f64::consts::TAU;
        let way = resolution.position * f64::EPSILON / pitch;
        assert_abs_diff_eq!(turn, 1e-6, epsilon = 1e-15);
        assert_abs_diff_eq!(way, 1e-6, epsilon = 1e-15);
        let refusal = |i: usize, value: f64, orientation| {
            let mut inputs = values();
            inputs.set(i, value);
            let refused = inputs
                .write_motion(0, orientation, resolution, &mut Motion::default())
                .err();
            refused.map_or(String::new(), |refusal| refusal.message)
        };
        use Orientation::{Angles, Quaternion};
        let length = "gear1.quaternion has the length 1.1";
        let angle = "gear1.angles[3] = 6000000000000 rad";
        let place = "gear1.position[2] = -1000000000 m";
        for (i, value, orientation, start) in [
            (QUATERNION, 1.004, Quaternion, ""),
            (QUATERNION, 1.1, Quaternion, length),
            (QUATERNION, 1.1, Angles, ""),
            (ANGLES + 2, 0.99 * resolution.angle, Angles, ""),
            (ANGLES + 2, 6e12, Angles, angle),
            (ANGLES + 2, 6e12, Quaternion, ""),
            (POSITION + 1, -1e9, Angles, place),
        ] {
            let refusal = refusal(i, value, orientation);
            assert!(refusal.starts_with(start), "{refusal}");
            assert_eq!(refusal.is_empty(), start.is_empty(), "{refusal}");
        }
        let mut inputs = values();
        inputs.set(QUATERNION, 1.004);
        let r = pose(&inputs, Quaternion).r;
        assert_abs_diff_eq!(r, Matrix3::identity(), epsilon = 1e-15);
    }

    fn step(inputs: &InputValues, h: f64) -> InputValues {
        inputs.after(h).unwrap()
    }

    #[test]
    fn an_input_follows_its_polynomial_over_one_step() {
        let p = |t: f64| 2.0 + 3.0 * t - 0.5 * t * t + 4.0 * t * t * t;
        let mut inputs = values();
        inputs.set_derivative(0, 1, 3.0);
        inputs.set_derivative(0, 2, -1.0);
        inputs.set_derivative(0, 3, 24.0);
        inputs.set(0, p(0.0));
        let mut inputs = step(&inputs, 0.75);
        assert_abs_diff_eq!(inputs.get(0), p(0.75), epsilon = 1e-14);
        inputs.set_derivative(1, 1, 1.0);
        let inputs = step(&inputs, 1.0);
        assert_abs_diff_eq!(inputs.get(0), p(0.75), epsilon = 1e-14);
        let inputs = step(&inputs, 1.0);
        assert!(inputs.after(1.0).is_none());
    }

    #[test]
    fn derivatives_that_overflow_are_found_by_their_input() {
        let mut inputs = values();
        inputs.set_derivative(7, 3, 1e308);
        assert_eq!(inputs.fault(), None);
        assert_eq!(step(&inputs, 1e3).fault(), Some(7));
    }
}
