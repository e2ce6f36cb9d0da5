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
mod stations;
mod symmetry;
mod teeth;
mod tilt;

use gearmesh::contact::*;
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::*;
use gearmesh_preprocessor::pair;
use solver::{coarse_solver, with_stations};
