//! The state vector: a plain array, so that any integrator takes it.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Numbers per gear: position 3, quaternion w x y z 4, velocity 3, angular momentum 3.
pub const GEAR_STATES: usize = 13;
/// Numbers of both gears.
pub const STATES: usize = 2 * GEAR_STATES;
/// State of both gears.
pub type State = [f64; STATES];

/// State of one gear, taken apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearState {
    /// Position of the centre of mass, m, W.
    pub p: Vector3<f64>,
    /// Orientation R_WG.
    pub q: UnitQuaternion<f64>,
    /// Velocity of the centre of mass, m/s.
    pub v: Vector3<f64>,
    /// Angular momentum about the centre of mass, kg m^2/s, W.
    pub l: Vector3<f64>,
}

/// Gear `i` (0 or 1) of `state`.
pub fn gear_state(state: &State, i: usize) -> GearState {
    let s = &state[i * GEAR_STATES..(i + 1) * GEAR_STATES];
    GearState {
        p: Vector3::new(s[0], s[1], s[2]),
        q: UnitQuaternion::new_normalize(Quaternion::new(s[3], s[4], s[5], s[6])),
        v: Vector3::new(s[7], s[8], s[9]),
        l: Vector3::new(s[10], s[11], s[12]),
    }
}

/// Put gear `i` (0 or 1) into `state`.
pub fn set_gear_state(state: &mut State, i: usize, gear: &GearState) {
    let s = &mut state[i * GEAR_STATES..(i + 1) * GEAR_STATES];
    s[0..3].copy_from_slice(gear.p.as_slice());
    s[3] = gear.q.w;
    s[4..7].copy_from_slice(gear.q.imag().as_slice());
    s[7..10].copy_from_slice(gear.v.as_slice());
    s[10..13].copy_from_slice(gear.l.as_slice());
}
