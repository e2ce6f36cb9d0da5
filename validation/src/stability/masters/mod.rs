//! Packed units under every kind of master: which loads act in a step, how the bodies move under them, and what hangs on the gears.
//!
//! Bodies are linear and move exactly between the loads: along the line of action q, with M q'' + C q' + K q = load - B F and the approaches
//! B^T q of the meshes. Loads act over the step (theta = 1/2), as an impulse at its begin (1, as in `v += h a; x += h v`) or at its
//! end (0, the explicit Euler rule).

mod bodies;
mod experiments;
mod packed;
mod tables;

pub use bodies::{Bodies, systems};
pub use experiments::{
    ALIKE, BY_TURNS, Case, Errors, MASTERS, OfMass, STEPS, Settling, Stepping, given, of_masses,
    settling, swing_kept,
};
pub use packed::Packed;
pub use tables::report;
