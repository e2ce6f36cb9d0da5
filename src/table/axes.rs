//! The axes of a grid and what they must fulfil.

use super::error::refused;
use super::{Axis, TableError};
use serde::{Deserialize, Serialize};

/// Nodes of the grid, SI. An axis with one node is not there: nothing depends on that coordinate.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// u = (delta - D0) / (D1 - D0) with D0 the no-load and D1 the top-load approach; ascending,
    /// above 0, the last one 1. The force at u = 0 is zero by definition and not stored.
    pub displacement_fraction: Vec<f64>,
    /// Actual minus nominal centre distance, m.
    #[serde(rename = "center_distance_offset_m")]
    pub center_distance_offset: Vec<f64>,
    /// Misalignment in the plane of action, rad.
    #[serde(rename = "misalignment_rad")]
    pub misalignment: Vec<f64>,
    /// Mesh position, in [0, 1), periodic.
    pub mesh_position: Vec<f64>,
}

impl Axes {
    /// Nodes in the order of the samples: centre distance, misalignment, displacement, mesh position.
    pub fn nodes(&self) -> [&[f64]; 4] {
        [
            &self.center_distance_offset,
            &self.misalignment,
            &self.displacement_fraction,
            &self.mesh_position,
        ]
    }

    /// Number of nodes along each axis, in that order.
    pub fn lengths(&self) -> [usize; 4] {
        self.nodes().map(<[f64]>::len)
    }

    /// Whether centre distance, misalignment and mesh position have an axis.
    pub fn present(&self) -> [bool; 3] {
        let [c, m, _, p] = self.lengths().map(|n| n > 1);
        [c, m, p]
    }

    pub(super) fn check(&self) -> Result<(), TableError> {
        let (name, u) = ("axes.displacement_fraction", &self.displacement_fraction);
        check_axis(name, u, false)?;
        let (first, last) = (u[0], u[u.len() - 1]);
        if first <= 0.0 || last != 1.0 {
            let reason = "it must begin above 0 and end at 1; make the tables again";
            return refused(name, format!("{first} ... {last}"), reason);
        }
        // The spline's first cell begins at the onset of contact, which imports round over a few millionths.
        check_spacing(name, &[&[0.0], u.as_slice()].concat(), 1e-6)?;
        check_axes("axes", self.nodes())
    }
}

impl From<[Vec<f64>; 4]> for Axes {
    /// Of nodes in the order of [`Axes::nodes`].
    fn from([c, m, u, p]: [Vec<f64>; 4]) -> Self {
        Axes {
            displacement_fraction: u,
            center_distance_offset: c,
            misalignment: m,
            mesh_position: p,
        }
    }
}

/// Fewest nodes of an axis that is there: the C2 spline needs four.
const FEWEST: usize = 4;

/// Most nodes of an axis, beyond any use: four such axes still have a number of samples that can be counted.
const MOST: usize = 10_000;

/// Beyond all lengths, forces and moments of gears; products of a few of them with one another stay finite.
const LARGEST: f64 = 1e15;

/// Checks the axes that all samples have, those of centre distance, misalignment and mesh position, at `path` in the file.
pub(super) fn check_axes(path: &str, [c, m, _, positions]: [&[f64]; 4]) -> Result<(), TableError> {
    let named = |axis: Axis| format!("{path}.{}", axis.name());
    check_axis(&named(Axis::CenterDistance), c, true)?;
    check_axis(&named(Axis::Misalignment), m, true)?;
    let name = named(Axis::MeshPosition);
    check_axis(&name, positions, true)?;
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    if first < 0.0 || last >= 1.0 {
        let reason =
            "a mesh position lies in [0, 1); leave out the repeated end 1; the axis is periodic";
        return refused(name, format!("{first} ... {last}"), reason);
    }
    // The last cell ends at the first node of the next cycle.
    check_spacing(&name, &[positions, &[first + 1.0]].concat(), 1e-5)
}

pub(super) fn check_axis(name: &str, nodes: &[f64], may_be_one: bool) -> Result<(), TableError> {
    let count = nodes.len();
    if count < FEWEST && !(count == 1 && may_be_one) {
        let reason = format!(
            "a cubic spline needs at least {FEWEST}; add values, or give a single one to leave this axis out"
        );
        return refused(name, format!("{count} values"), reason);
    }
    if count > MOST {
        let reason = format!("an axis has at most {MOST}; leave some of them out");
        return refused(name, format!("{count} values"), reason);
    }
    check_values(name, nodes, count)?;
    if let Some(i) = (1..count).find(|&i| nodes[i] <= nodes[i - 1]) {
        let reason = format!(
            "not above the value before it, {}; sort the axis ascending and let each value stand once",
            nodes[i - 1]
        );
        return refused(format!("{name}[{i}]"), nodes[i], reason);
    }
    check_spacing(name, nodes, 1e-5)
}

/// Least distance of neighbours among the ascending `nodes`; infinite where there is one.
pub fn least_distance(nodes: &[f64]) -> f64 {
    let apart = nodes.windows(2).map(|ends| ends[1] - ends[0]);
    apart.fold(f64::INFINITY, f64::min)
}

/// Cells of a spline between `ends`, ascending: one narrower than `least` of the range costs memory without bound where
/// cells are found by equal buckets.
fn check_spacing(name: &str, ends: &[f64], least: f64) -> Result<(), TableError> {
    let range = ends[ends.len() - 1] - ends[0];
    match ends.windows(2).find(|w| w[1] - w[0] < least * range) {
        Some(pair) => refused(
            name,
            format!("{} and {}", pair[0], pair[1]),
            format!("closer than {least:e} of the range; leave one of them out"),
        ),
        None => Ok(()),
    }
}

pub(super) fn check_values(name: &str, values: &[f64], length: usize) -> Result<(), TableError> {
    if values.len() != length {
        let reason =
            format!("the axes need {length}; the file is incomplete; make the tables again");
        return refused(name, format!("{} values", values.len()), reason);
    }
    match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
        Some(i) => refused(
            format!("{name}[{i}]"),
            values[i],
            format!("it must be a number no larger than {LARGEST:e}; make the tables again"),
        ),
        None => Ok(()),
    }
}
