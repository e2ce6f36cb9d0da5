//! Contact at run time: teeth that differ, segments, cost and error.

mod cost;
mod index_errors;
mod stations;

use crate::Chapter;

pub const CHAPTERS: [(&str, Chapter); 3] = [
    ("index-errors", index_errors::report),
    ("stations", stations::report),
    ("cost", cost::report),
];

/// The shipped pairs that segments and cost are measured on.
const PAIRS: [&str; 4] = ["palermo2013", "fzg-c", "helical-25-47", "planet-ring-27-84"];
