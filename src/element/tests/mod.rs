//! Claims about the element.

mod bodies;
mod constant_load;
mod damping;
pub(crate) mod fixtures;
mod flanks;
mod friction;
mod jacobian;
mod limits;
mod poses;
mod prediction;
mod root_stress;
mod teeth;
mod whole;

use super::*;
use crate::gear::samples::paper_pair;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use fixtures::*;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
