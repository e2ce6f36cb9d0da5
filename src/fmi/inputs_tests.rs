//! Poses from inputs: angles, quaternions, motion within a step.

use super::*;
use approx::assert_abs_diff_eq;
use nalgebra::Rotation3;
use std::f64::consts::FRAC_PI_2;

const FINE: Resolution = Resolution {
    angle: 1e9,
    position: 1e9,
};

fn values() -> InputValues {
    let mut inputs = InputValues::new(vec![0.0; BODIES.len() * BODY_INPUTS]);
    for body in BODIES {
        inputs.set(body.first + QUATERNION, 1.0);
    }
    inputs
}

impl InputValues {
    pub(in crate::fmi) fn motion(
        &self,
        body: usize,
        orientation: Orientation,
        resolution: Resolution,
    ) -> Result<Motion, Refusal> {
        let mut motion = Motion::default();
        self.write_motion(body, orientation, resolution, &mut motion)?;
        Ok(motion)
    }
}

fn pose(inputs: &InputValues, orientation: Orientation) -> Motion {
    inputs.motion(0, orientation, FINE).unwrap()
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
fn a_moved_body_goes_as_a_rigid_body_and_its_inputs_stay_even_at_90_degrees() {
    let turn = Vector3::new(0.02, -0.01, 0.4);
    let way = Vector3::new(1e-3, 2e-3, 3e-3);
    for a in [[2e-3, -1e-3, 0.7], [0.0, FRAC_PI_2, 0.0]].map(Vector3::from) {
        let q = UnitQuaternion::from_matrix(&cardan(&a));
        let mut inputs = values();
        for k in 0..3 {
            inputs.set(ANGLES + k, a[k]);
        }
        for (k, c) in [q.w, q.i, q.j, q.k].into_iter().enumerate() {
            inputs.set(QUATERNION + k, c);
        }
        let set = inputs.value.clone();
        for orientation in [Orientation::Angles, Orientation::Quaternion] {
            let mut moved = inputs.clone();
            for _ in 0..2 {
                moved.move_body(0, way, turn, orientation);
            }
            assert_eq!(moved.value, set);
            let there = pose(&moved, orientation);
            let exact = Rotation3::new(2.0 * turn).into_inner() * cardan(&a);
            assert_abs_diff_eq!(there.r, exact, epsilon = 1e-15);
            assert_abs_diff_eq!(there.p, 2.0 * way, epsilon = 1e-18);
            // Setting one angle takes the orientation back, not the position; and the other way.
            let first = if orientation == Orientation::Angles {
                ANGLES
            } else {
                QUATERNION
            };
            let mut set_anew = moved.clone();
            set_anew.set(first, inputs.get(first));
            assert_abs_diff_eq!(pose(&set_anew, orientation).r, cardan(&a), epsilon = 1e-15);
            assert_eq!(pose(&set_anew, orientation).p, there.p);
            moved.set(POSITION, 0.0);
            assert_eq!(pose(&moved, orientation).p, Vector3::zeros());
            assert_eq!(pose(&moved, orientation).r, there.r);
        }
    }
}

#[test]
fn directions_of_orientation_inputs_are_small_rotations_of_the_world() {
    let mut inputs = values();
    let a = [0.1, -0.2, 2.0];
    let q = UnitQuaternion::from_matrix(&cardan(&Vector3::from(a))).into_inner() * 1.003;
    for (k, x) in a.into_iter().chain([q.w, q.i, q.j, q.k]).enumerate() {
        inputs.set(ANGLES + k, x);
    }
    let step = 1e-6;
    for (from, count, orientation) in [
        (ANGLES, 3, Orientation::Angles),
        (QUATERNION, 4, Orientation::Quaternion),
    ] {
        for drift in [Vector3::zeros(), Vector3::new(0.3, 0.2, -0.5)] {
            let mut inputs = inputs.clone();
            inputs.move_body(0, Vector3::zeros(), drift, orientation);
            for i in from..from + count {
                let (part, rotation) = inputs.direction(i, orientation);
                assert_eq!(part, Part::Rotation);
                let at = |sign: f64| {
                    let mut moved = inputs.clone();
                    moved.advance(i, sign * step);
                    pose(&moved, orientation).r
                };
                let r = pose(&inputs, orientation).r;
                let skew = (at(1.0) - at(-1.0)) / (2.0 * step) * r.transpose();
                let found = Vector3::new(skew.m32, skew.m13, skew.m21);
                assert_abs_diff_eq!(found, rotation, epsilon = 1e-9);
            }
        }
    }
}

#[test]
fn a_quaternion_far_from_unit_length_is_refused_by_name() {
    let mut inputs = values();
    let second = |inputs: &InputValues| inputs.motion(1, Orientation::Quaternion, FINE);
    inputs.set(BODY_INPUTS + QUATERNION, 1.004);
    let r = second(&inputs).unwrap().r;
    assert_abs_diff_eq!(r, Matrix3::identity(), epsilon = 1e-15);
    inputs.set(BODY_INPUTS + QUATERNION, 1.1);
    let error = second(&inputs).unwrap_err();
    assert!(
        error
            .message
            .starts_with("gear2.quaternion has the length 1.1")
    );
    assert!(inputs.motion(1, Orientation::Angles, FINE).is_ok());
}

#[test]
fn numbers_whose_rounding_moves_the_teeth_are_refused_by_name() {
    let (teeth, pitch) = (20.0, 12e-3);
    let resolution = Resolution::new(teeth, pitch);
    // Rounding of the largest angle and coordinate, in pitches.
    let turn = resolution.angle * f64::EPSILON * teeth / std::f64::consts::TAU;
    let way = resolution.position * f64::EPSILON / pitch;
    assert_abs_diff_eq!(turn, 1e-6, epsilon = 1e-15);
    assert_abs_diff_eq!(way, 1e-6, epsilon = 1e-15);
    let mut inputs = values();
    let ask = |inputs: &InputValues| inputs.motion(0, Orientation::Angles, resolution);
    inputs.set(ANGLES + 2, 0.99 * resolution.angle);
    assert!(ask(&inputs).is_ok());
    inputs.set(ANGLES + 2, 6e12);
    let said = ask(&inputs).unwrap_err().message;
    assert!(
        said.starts_with("gear1.angles[3] = 6000000000000 rad"),
        "{said}"
    );
    assert!(
        inputs
            .motion(0, Orientation::Quaternion, resolution)
            .is_ok()
    );
    inputs.set(ANGLES + 2, 0.0);
    inputs.set(POSITION + 1, -1e9);
    let said = ask(&inputs).unwrap_err().message;
    assert!(
        said.starts_with("gear1.position[2] = -1000000000 m"),
        "{said}"
    );
}
