//! Sweeps for tables of tooth pairs one by one.

mod alone;
mod coupling;
mod sweep;

pub use sweep::{TeethSweep, default_teeth_axes};
