//! The grid of nodes on the loaded flank, and segments as weights on it.

use super::element::{GAUSS3, QUAD8, shape};
use super::kernel::{EDGE_KERNEL_OVER_ELEMENT, GAUSS5, HALF_KERNEL_FROM_EDGE, Kernel};
use super::outline::Outline;
use super::section::Section;
use gearmesh::compliance::Segment;
use std::collections::BTreeMap;

/// Weights of the flank nodes that share the force on a segment (they sum to one) and, since loads and
/// displacements are treated alike, average the displacement of the segment.
pub(super) type Weights = Vec<(usize, f64)>;

/// Faces of the elements along the loaded flank: arc length of their ends by z of their ends. A plane
/// model has a single station and faces that are lines.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FlankGrid {
    /// Ends of the elements along the profile, arc length, m, ascending.
    pub arcs: Vec<f64>,
    /// Ends of the layers, m, ascending; a single one in plane strain.
    pub stations: Vec<f64>,
    /// Roll length at arc length zero, m.
    pub form_roll: f64,
    /// kappa / (2 rb), 1/m: arc = this * (roll² - form_roll²).
    pub arc_per_roll_squared: f64,
    pub kernel_half_width: f64,
}

impl FlankGrid {
    /// Grid of the flank of `section` in the layers between `stations`.
    pub fn new(
        outline: &Outline,
        section: &Section,
        stations: &[f64],
        half_width: f64,
    ) -> FlankGrid {
        FlankGrid {
            arcs: section
                .flank
                .iter()
                .step_by(2)
                .map(|(_, arc)| *arc)
                .collect(),
            stations: stations.to_vec(),
            form_roll: outline.form_roll,
            arc_per_roll_squared: outline.kappa / (2.0 * outline.base_radius),
            kernel_half_width: half_width,
        }
    }

    pub fn len(&self) -> usize {
        let (elements, layers) = (self.arcs.len() - 1, self.stations.len() - 1);
        (layers + 1) * (2 * elements + 1) + layers * (elements + 1)
    }

    /// Thickest layer, m; none in plane strain.
    pub fn thickest_layer(&self) -> f64 {
        let layers = self.stations.windows(2).map(|ends| ends[1] - ends[0]);
        layers.fold(0.0, f64::max)
    }

    /// Arc length from the form point at the length of roll `roll`, m.
    pub fn arc(&self, roll: f64) -> f64 {
        self.arc_per_roll_squared * (roll * roll - self.form_roll * self.form_roll)
    }

    fn kernel(&self, roll: f64) -> Kernel {
        let edges = [self.arcs[0], self.arcs[self.arcs.len() - 1]];
        let arc = self.arc(roll);
        // Not wider than the distance to the tip edge, so that the load stays where it acts, down to what the
        // elements at the edge resolve.
        let least = self.edge_half_width().min(self.kernel_half_width);
        let half_width = (edges[1] - arc).clamp(least, self.kernel_half_width);
        Kernel::new(half_width, arc, edges)
    }

    /// Half-width of the kernel at the tip edge, m: one and a half of the element there.
    fn edge_half_width(&self) -> f64 {
        let last = self.arcs.len() - 1;
        EDGE_KERNEL_OVER_ELEMENT * (self.arcs[last] - self.arcs[last - 1])
    }

    /// As [`gearmesh::compliance::ToothCompliance::corner_resolution`].
    pub fn edge_resolution(&self) -> f64 {
        HALF_KERNEL_FROM_EDGE * self.edge_half_width().min(self.kernel_half_width)
    }

    /// Reference length of the kernel at the middle of `segment`, m.
    pub fn reference_length(&self, segment: &Segment) -> f64 {
        self.kernel(0.5 * (segment.roll[0] + segment.roll[1]))
            .reference_length()
    }

    pub fn weights(&self, segment: &Segment) -> Weights {
        let length = segment.z[1] - segment.z[0];
        let mut sum = BTreeMap::new();
        for (layer, low, high) in cells(&self.stations, segment.z) {
            for (x, weight) in GAUSS3 {
                let share = 0.5 * (1.0 + x);
                let z = low + share * (high - low);
                let along = (z - segment.z[0]) / length;
                let roll = segment.roll[0] + along * (segment.roll[1] - segment.roll[0]);
                let part = 0.5 * weight * (high - low) / length;
                self.spread(layer, z, roll, part, &mut sum);
            }
        }
        sum.into_iter().collect()
    }

    /// Adds `part` of a unit load at `z` and `roll`.
    fn spread(&self, layer: usize, z: f64, roll: f64, part: f64, sum: &mut BTreeMap<usize, f64>) {
        let kernel = self.kernel(roll);
        let plane = self.stations.len() == 1;
        let zeta = if plane {
            -1.0
        } else {
            local(z, &self.stations, layer)
        };
        for (element, low, high) in cells(&self.arcs, kernel.support()) {
            for (x, weight) in GAUSS5 {
                let arc = low + x * (high - low);
                let load = part * weight * (high - low) * kernel.density(arc);
                let xi = local(arc, &self.arcs, element);
                for (node, c) in face_nodes(self.arcs.len() - 1, element, layer, plane) {
                    *sum.entry(node).or_insert(0.0) += load * shape(2, c, &[xi, zeta, 0.0]).0;
                }
            }
        }
    }
}

/// Nodes of the face of one `element` along the profile and one `layer`, with their local coordinates (xi along the profile, zeta along
/// the face), in the numbering of [`super::mesh::Mesh::flank`] and `fillet`: planes of all nodes alternate with planes of corners
/// alone. A surface that is `elements` long; of a `plane` model the line zeta = -1.
pub(super) fn face_nodes(
    elements: usize,
    element: usize,
    layer: usize,
    plane: bool,
) -> impl Iterator<Item = (usize, &'static [f64; 3])> {
    let half = |c: f64| (1.0 + c) as usize;
    let nodes = QUAD8.iter().filter(move |c| !plane || c[1] == -1.0);
    nodes.map(move |c| {
        let (i, k) = (2 * element + half(c[0]), 2 * layer + half(c[1]));
        let base = (k / 2) * (3 * elements + 2);
        let corners = base + 2 * elements + 1 + i / 2;
        (
            if k.is_multiple_of(2) {
                base + i
            } else {
                corners
            },
            c,
        )
    })
}

/// Local coordinate in [-1, 1] of `x` in cell `i` of `ends`.
fn local(x: f64, ends: &[f64], i: usize) -> f64 {
    2.0 * (x - ends[i]) / (ends[i + 1] - ends[i]) - 1.0
}

/// Cells of `ends` that `range` touches, as (cell, low, high) with the limits cut to the cell; what lies
/// outside by rounding belongs to the outermost cells. With a single end there is one cell, the range.
fn cells(ends: &[f64], range: [f64; 2]) -> Vec<(usize, f64, f64)> {
    let count = ends.len() - 1;
    if count == 0 {
        return vec![(0, range[0], range[1])];
    }
    let cell = |x: f64| ends.partition_point(|end| *end <= x).clamp(1, count) - 1;
    let (first, last) = (cell(range[0]), cell(range[1]));
    (first..=last)
        .map(|i| {
            let low = if i == first { range[0] } else { ends[i] };
            let high = if i == last { range[1] } else { ends[i + 1] };
            (i, low, high)
        })
        .filter(|(_, low, high)| high > low)
        .collect()
}
