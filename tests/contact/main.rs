//! Claims about static contact and contact at run time, on real pairs with coarse finite elements.

#[path = "../common/fzg.rs"]
mod fzg;
#[path = "../common/gears.rs"]
mod gears;
#[path = "../common/solver.rs"]
mod solver;

mod file;
mod flanks;
mod mechanics;
mod paper;
mod root_stress;
mod runtime;
mod sliding;
mod symmetry;
mod teeth;
mod tilt;

use gearmesh::contact::*;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::random::Random;
use gearmesh_preprocessor::contact::*;
use gearmesh_preprocessor::pair;
use solver::{coarse_solver, with_stations};
use std::sync::Arc;

const PAPER: &str = include_str!("../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../resources/pairs/palermo2013-unmodified.json");
const HELICAL: &str = include_str!("../../resources/pairs/helical-25-47.json");
const RING: &str = include_str!("../../resources/pairs/planet-ring-27-84.json");
const SPUR: &str = include_str!("../../resources/pairs/fzg-c.json");
