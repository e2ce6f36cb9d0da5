//! Tables from static contact: which nodes they need, the sweep over them, and tables that come from elsewhere.

mod choices;
pub mod import;
mod load_sweep;
mod measure;
pub mod plan;
mod root_stress;
mod sliding;
pub mod source;
pub mod sweep;
mod teeth;

pub use root_stress::{RootStressSweep, default_root_stress_axes};
pub use sliding::{default_sliding_axes, sweep_sliding};
pub use teeth::{TeethSweep, default_teeth_axes};
