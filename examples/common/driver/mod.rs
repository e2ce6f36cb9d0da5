//! A small driver for numerical experiments with the element: two gears on bearings, imposed speeds
//! or torques, integrators, and a co-simulation loop. For examples and tests.
//!
//! Each gear is a rigid body, axisymmetric about its axis. Its state holds the position of the centre
//! of mass, the orientation as a unit quaternion, the velocity and the angular momentum about the centre of
//! mass, all in the world frame, so the equations have no inertia terms:
//!
//! ```text
//! p' = v,   q' = w q / 2,   m v' = force,   L' = moment,   w = L/J_t + (1/J_p - 1/J_t) (L . a) a
//! ```
//!
//! with J_p about the axis a and J_t across it. Freedoms that are locked get neither force nor moment.

// Every example uses a part of it.
#![allow(dead_code, unused_imports)]

mod cosimulation;
mod fixed_step;
mod scene;
mod state;

pub use cosimulation::{Coupling, Extrapolation, Master};
pub use fixed_step::Method;
pub use scene::{Bearing, Freedoms, Gear, Scene, Spin, twist};
pub use state::{GEAR_STATES, GearState, STATES, State, gear_state, set_gear_state};
