//! Contact at run time: teeth that differ, segments, cost and error.

pub mod cost;
pub mod index_errors;
pub mod stations;

/// The shipped pairs that segments and cost are measured on.
const PAIRS: [&str; 4] = ["palermo2013", "fzg-c", "helical-25-47", "planet-ring-27-84"];
