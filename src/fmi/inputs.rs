//! The inputs as poses and velocities of the bodies.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::layout::{
    ANGLES, ANGULAR_VELOCITY, BODIES, BODY_INPUTS, POSITION, QUATERNION, VELOCITY, body_of,
};
use super::report::Refusal;
use super::settings::Orientation;
use super::variables::VARIABLES;
use crate::element::Motion;
use crate::words::number;

/// Departure of a quaternion's length from 1 above which it is refused. Integrators and linear
/// interpolation between orientations 10 degrees apart stay below.
pub const QUATERNION_TOLERANCE: f64 = 1e-2;

/// How far a body has moved beyond its pose inputs: `extrapolatePoses` moves bodies, never inputs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Drift {
    /// Way of the origin, m, world axes.
    moved: [f64; 3],
    /// Rotation in world axes, a unit quaternion w x y z.
    turned: [f64; 4],
    /// Whether angles, not a quaternion, gave the orientation that it started from.
    from_angles: bool,
}

/// Values of all inputs, and how far the bodies have gone beyond them.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct InputValues {
    /// In the order of the variables.
    value: Vec<f64>,
    /// By body.
    drift: Vec<Option<Drift>>,
    drifting: bool,
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
    /// elongation under load, which is about a thousandth of a pitch: a number whose own rounding is
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
    /// The inputs with these values.
    pub fn new(value: Vec<f64>) -> Self {
        Self {
            value,
            drift: vec![None; BODIES.len()],
            drifting: false,
        }
    }

    /// Whether these are values for `count` inputs, all of them finite.
    pub fn fits(&self, count: usize) -> bool {
        let sizes = (self.value.len(), self.drift.len());
        sizes == (count, BODIES.len()) && self.finite().is_ok()
    }

    /// Value of input `i`.
    pub fn get(&self, i: usize) -> f64 {
        self.value[i]
    }

    /// Sets input `i`: a body whose position or orientation (the one in use) is set stands there.
    #[inline]
    pub fn set(&mut self, i: usize, value: f64) {
        self.value[i] = value;
        if self.drifting {
            self.stop(i);
        }
    }

    /// Sets the inputs from `first` on; see [`InputValues::set`].
    pub fn set_block(&mut self, first: usize, values: &[f64]) {
        let block = first..first + values.len();
        self.value[block.clone()].copy_from_slice(values);
        if self.drifting {
            block.for_each(|i| self.stop(i));
        }
    }

    fn stop(&mut self, i: usize) {
        let Some(drift) = &mut self.drift[body_of(i)] else {
            return;
        };
        match i % BODY_INPUTS {
            ANGLES..QUATERNION if drift.from_angles => drift.turned = [1.0, 0.0, 0.0, 0.0],
            QUATERNION..VELOCITY if !drift.from_angles => drift.turned = [1.0, 0.0, 0.0, 0.0],
            POSITION..ANGLES => drift.moved = [0.0; 3],
            _ => {}
        }
    }

    /// Changes the value of input `i` without stopping the body: it goes on along its polynomial.
    pub fn advance(&mut self, i: usize, by: f64) {
        self.value[i] += by;
    }

    /// Moves a body on by a way (m) and a rotation vector (rad), both in world axes.
    pub fn move_body(
        &mut self,
        body: usize,
        way: Vector3<f64>,
        turn: Vector3<f64>,
        orientation: Orientation,
    ) {
        if way == Vector3::zeros() && turn == Vector3::zeros() {
            return;
        }
        let drift = self.drift[body].get_or_insert(Drift {
            moved: [0.0; 3],
            turned: [1.0, 0.0, 0.0, 0.0],
            from_angles: orientation == Orientation::Angles,
        });
        self.drifting = true;
        let q = UnitQuaternion::from_scaled_axis(turn).into_inner() * unit(&drift.turned);
        let q = q.normalize();
        drift.moved = (Vector3::from(drift.moved) + way).into();
        drift.turned = [q.w, q.i, q.j, q.k];
    }

    /// All values are finite; else the index of an input that is not.
    pub fn finite(&self) -> Result<(), usize> {
        let bad = |(i, body): (usize, &Option<Drift>)| {
            let drift = body.as_ref()?;
            let all = drift.moved.iter().chain(&drift.turned);
            all.copied()
                .any(|x| !x.is_finite())
                .then_some(i * BODY_INPUTS + VELOCITY)
        };
        let value = self.value.iter().position(|x| !x.is_finite());
        let drift = || self.drift.iter().enumerate().find_map(bad);
        value.or_else(drift).map_or(Ok(()), Err)
    }

    /// The largest input in size, for messages.
    pub fn largest(&self) -> (usize, f64) {
        let sizes = self.value.iter().copied().enumerate();
        sizes
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .unwrap_or((0, 0.0))
    }

    fn vector(&self, i: usize) -> Vector3<f64> {
        Vector3::new(self.value[i], self.value[i + 1], self.value[i + 2])
    }

    fn quaternion(&self, i: usize) -> Quaternion<f64> {
        let v = &self.value;
        Quaternion::new(v[i], v[i + 1], v[i + 2], v[i + 3])
    }

    /// Velocity of a body's origin and its angular velocity.
    pub fn velocities(&self, body: usize) -> [Vector3<f64>; 2] {
        let first = BODIES[body].first;
        [VELOCITY, ANGULAR_VELOCITY].map(|at| self.vector(first + at))
    }

    /// Writes the motion of a body, as the element takes it, into `motion`: in place, since it is large and wanted in every
    /// step.
    ///
    /// # Errors
    /// A quaternion in use whose length is not 1 within [`QUATERNION_TOLERANCE`]; angles and positions
    /// beyond `resolution`.
    pub fn write_motion(
        &self,
        body: usize,
        orientation: Orientation,
        resolution: Resolution,
        motion: &mut Motion,
    ) -> Result<(), Refusal> {
        let first = BODIES[body].first;
        motion.r = self.rotation(body, orientation, resolution.angle)?;
        self.resolved(first + POSITION, resolution.position, "m")?;
        motion.p = self.vector(first + POSITION);
        motion.v = self.vector(first + VELOCITY);
        motion.w = self.vector(first + ANGULAR_VELOCITY);
        if let Some(drift) = &self.drift[body] {
            motion.p += Vector3::from(drift.moved);
            motion.r = turned(drift) * motion.r;
        }
        Ok(())
    }

    fn rotation(
        &self,
        body: usize,
        orientation: Orientation,
        largest: f64,
    ) -> Result<Matrix3<f64>, Refusal> {
        let first = BODIES[body].first;
        match orientation {
            Orientation::Angles => {
                self.resolved(first + ANGLES, largest, "rad")?;
                Ok(cardan(&self.vector(first + ANGLES)))
            }
            Orientation::Quaternion => {
                let q = self.quaternion(first + QUATERNION);
                let length = q.norm();
                let is_unit = (length - 1.0).abs() <= QUATERNION_TOLERANCE; // never for NaN
                if !is_unit {
                    return Err(Refusal::discard(format!(
                        "{}.quaternion has the length {}; it must be 1 within \
                         {QUATERNION_TOLERANCE}: normalise it, or set orientationInput = angles",
                        BODIES[body].name,
                        number(length)
                    )));
                }
                let q = UnitQuaternion::new_unchecked(q / length);
                Ok(q.to_rotation_matrix().into_inner())
            }
        }
    }

    /// Three inputs from `i` on are small enough for their rounding not to matter.
    fn resolved(&self, i: usize, largest: f64, unit: &str) -> Result<(), Refusal> {
        let v = self.vector(i);
        if v.abs().sum() <= largest {
            return Ok(());
        }
        let Some(k) = v.iter().position(|x| x.abs() > largest) else {
            return Ok(());
        };
        let remedy = match unit {
            "rad" => "take off whole turns",
            _ => "put the origin of the world nearer",
        };
        Err(Refusal::discard(format!(
            "{} = {} {unit}: above {largest:.1e} {unit} its own rounding moves the teeth by more \
             than the table resolves; {remedy}",
            VARIABLES[i + k].name,
            number(v[k])
        )))
    }

    /// What a change of input `i` at unit rate does to its body: which of small translation, small
    /// rotation (both world axes), velocity and angular velocity changes, and how.
    pub fn direction(&self, i: usize, orientation: Orientation) -> (Part, Vector3<f64>) {
        let (body, k) = (body_of(i), i % BODY_INPUTS);
        let first = BODIES[body].first;
        let unit = |at: usize| Vector3::ith(k - at, 1.0);
        let drifted = |rotation: Vector3<f64>| match &self.drift[body] {
            Some(drift) => turned(drift) * rotation,
            None => rotation,
        };
        match (k, orientation) {
            (POSITION..ANGLES, _) => (Part::Translation, unit(POSITION)),
            (ANGLES..QUATERNION, Orientation::Angles) => {
                let axes = cardan_axes(&self.vector(first + ANGLES));
                (
                    Part::Rotation,
                    drifted(axes.column(k - ANGLES).into_owned()),
                )
            }
            (QUATERNION..VELOCITY, Orientation::Quaternion) => {
                let q = self.quaternion(first + QUATERNION);
                let mut dq = Quaternion::new(0.0, 0.0, 0.0, 0.0);
                match k - QUATERNION {
                    0 => dq.w = 1.0,
                    c => dq.coords[c - 1] = 1.0,
                }
                // Vector part of 2 dq q*; the change of length is its scalar part.
                let rate = (dq * q.conjugate()) * (2.0 / q.norm_squared());
                (Part::Rotation, drifted(rate.imag()))
            }
            (VELOCITY..ANGULAR_VELOCITY, _) => (Part::Velocity, unit(VELOCITY)),
            (ANGULAR_VELOCITY.., _) => (Part::AngularVelocity, unit(ANGULAR_VELOCITY)),
            // The orientation that is not in use.
            _ => (Part::Rotation, Vector3::zeros()),
        }
    }
}

/// Part of a body's motion that an input acts on, in the order of the element's freedoms.
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

fn unit([w, x, y, z]: &[f64; 4]) -> Quaternion<f64> {
    Quaternion::new(*w, *x, *y, *z)
}

fn turned(drift: &Drift) -> Matrix3<f64> {
    let q = UnitQuaternion::new_unchecked(unit(&drift.turned));
    q.to_rotation_matrix().into_inner()
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
#[path = "inputs_tests.rs"]
mod tests;
