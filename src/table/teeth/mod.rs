//! Tooth pair by tooth pair: the fast level for teeth that differ.
//!
//! A table holds the potential W1(a, C, M, s) of one tooth pair alone over its approach and its place s along the path of
//! contact, in base pitches from where it touches at the pitch point. Neighbours are coupled through tooth roots and bodies: the load of
//! one takes a part of the approach of the next. All of them together have one potential ([`TeethTable`]).
//! Teeth that differ enter as what their errors close of the gap of each pair.

// Loops over a few tooth pairs and coordinates read best by index, in step through several arrays.
#![allow(clippy::needless_range_loop)]

mod compliance;
mod coupled;
mod pairs;
mod record;
mod runtime;

pub use coupled::{Closing, TeethTable};
pub use record::{CouplingRecord, GearTeethRecord, TeethRecord};
pub use runtime::TeethFlank;
