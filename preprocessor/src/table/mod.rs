//! Tables from static contact: which nodes they need, the sweep over them, and tables that come from elsewhere.

mod coverage;
pub mod import;
mod plan;
mod recipe;
mod records;
mod summary;
mod sweep;
mod teeth;
mod tooth_pair;

pub use coverage::{
    Coverage, default_axes, displacement_nodes, measure, measure_at_run_time, mesh_positions,
    misalignments,
};
pub use plan::table_within;
pub use recipe::{Account, Made, Recipe, RecipeError, other_flanks};
pub use records::{RootStressSweep, default_root_stress_axes, default_sliding_axes, sweep_sliding};
pub use summary::{size_and_error, summary, teeth_in_words};
pub use sweep::{
    Progress, Sample, SolveQuality, StaticPosition, StaticSource, WatchedSolver, sweep,
};
pub use teeth::{TeethSweep, default_teeth_axes};
