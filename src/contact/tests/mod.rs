//! Claims about static contact, on real pairs.

use super::*;
use crate::pair::Pair;
use crate::testing::coarse_solver;

mod flanks;
mod mechanics;
mod paper;
mod root_stress;
mod runtime;
mod separation;
mod sliding;
mod stations;
mod symmetry;
mod teeth;
mod tilt;
