//! The grid of nodes on the loaded flank, and segments as weights on it: line loads spread by a kernel.

use super::element::{GAUSS3, QUAD8};
use super::outline::Outline;
use super::section::Section;
use gearmesh::contact::Segment;
use gearmesh::root::bisection;
use std::ops::Range;

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
    pub fn new(
        outline: &Outline,
        section: &Section,
        stations: &[f64],
        half_width: f64,
    ) -> FlankGrid {
        let corners = section.flank.iter().step_by(2);
        FlankGrid {
            arcs: corners.map(|(_, arc)| *arc).collect(),
            stations: stations.to_vec(),
            form_roll: outline.form_roll,
            arc_per_roll_squared: outline.kappa / (2.0 * outline.base_radius),
            kernel_half_width: half_width,
        }
    }

    pub fn len(&self) -> usize {
        self.planes().map(|plane| plane.len()).sum()
    }

    /// The nodes of each station and of each middle between two, as [`face_nodes`] numbers them.
    pub fn planes(&self) -> impl Iterator<Item = Range<usize>> {
        let (elements, layers) = (self.arcs.len() - 1, self.stations.len() - 1);
        (0..=2 * layers).map(move |half| {
            let first = half / 2 * (3 * elements + 2);
            match half.is_multiple_of(2) {
                true => first..first + 2 * elements + 1,
                false => first + 2 * elements + 1..first + 3 * elements + 2,
            }
        })
    }

    /// Length of roll at both ends of the involute, m.
    pub fn rolls(&self) -> [f64; 2] {
        let last = self.arcs[self.arcs.len() - 1] / self.arc_per_roll_squared;
        [self.form_roll, (self.form_roll.powi(2) + last).sqrt()]
    }

    fn kernel(&self, roll: f64) -> Kernel {
        let edges = [self.arcs[0], self.arcs[self.arcs.len() - 1]];
        let arc = self.arc_per_roll_squared * (roll * roll - self.form_roll * self.form_roll);
        // Not wider than the distance to the tip edge, so that the load stays where it acts, as far as the elements there resolve it.
        let least = self.edge_half_width().min(self.kernel_half_width);
        let half_width = (edges[1] - arc).clamp(least, self.kernel_half_width);
        Kernel::new(half_width, arc, edges)
    }

    fn edge_half_width(&self) -> f64 {
        let last = self.arcs.len() - 1;
        EDGE_KERNEL_OVER_ELEMENT * (self.arcs[last] - self.arcs[last - 1])
    }

    /// As [`crate::compliance::ToothCompliance::corner_resolution`].
    pub fn edge_resolution(&self) -> f64 {
        HALF_KERNEL_FROM_EDGE * self.edge_half_width().min(self.kernel_half_width)
    }

    pub fn reference_length(&self, segment: &Segment) -> f64 {
        let middle = 0.5 * (segment.roll[0] + segment.roll[1]);
        self.kernel(middle).reference_length()
    }

    pub fn weights(&self, segment: &Segment) -> Weights {
        let length = segment.z[1] - segment.z[0];
        let layers = cells(&self.stations, segment.z);
        // Nodes of these layers follow on each other.
        let of_layer = 3 * (self.arcs.len() - 1) + 2;
        let first = layers.first().map_or(0, |(layer, ..)| layer * of_layer);
        let end = layers
            .last()
            .map_or(0, |(layer, ..)| (layer + 2) * of_layer);
        let mut sum = vec![0.0; end.min(self.len()) - first];
        for (layer, low, high) in layers {
            for (x, weight) in GAUSS3 {
                let share = 0.5 * (1.0 + x);
                let z = low + share * (high - low);
                let along = (z - segment.z[0]) / length;
                let roll = segment.roll[0] + along * (segment.roll[1] - segment.roll[0]);
                let part = 0.5 * weight * (high - low) / length;
                self.spread(layer, z, roll, part, &mut |node, share| {
                    sum[node - first] += share
                });
            }
        }
        let weights = (first..).zip(sum);
        weights.filter(|(_, weight)| *weight != 0.0).collect()
    }

    fn spread(&self, layer: usize, z: f64, roll: f64, part: f64, add: &mut impl FnMut(usize, f64)) {
        let kernel = self.kernel(roll);
        let plane = self.stations.len() == 1;
        let zeta = if plane {
            -1.0
        } else {
            local(z, &self.stations, layer)
        };
        for (element, low, high) in cells(&self.arcs, kernel.support()) {
            // Of the load over the element, about its middle along the profile.
            let mut moments = [0.0; 3];
            for (x, weight) in GAUSS5 {
                let arc = low + x * (high - low);
                let load = part * weight * (high - low) * kernel.density(arc);
                let xi = local(arc, &self.arcs, element);
                for (moment, power) in moments.iter_mut().zip([1.0, xi, xi * xi]) {
                    *moment += load * power;
                }
            }
            for (node, c) in face_nodes(self.arcs.len() - 1, element, layer, plane) {
                add(node, face_share(c, zeta, moments));
            }
        }
    }
}

/// Integral of a load along a line of constant `zeta` on a face times the shape function of its node at `c`, [`shape`]; `moments` are the
/// integrals of the load times 1, xi and xi².
fn face_share(c: &[f64; 3], zeta: f64, [whole, first, second]: [f64; 3]) -> f64 {
    let [along, across] = [c[0] * first, c[1] * zeta];
    match (c[0] == 0.0, c[1] == 0.0) {
        (false, false) => {
            0.25 * (1.0 + across) * (second + across * along - (1.0 - across) * whole)
        }
        (true, _) => 0.5 * (1.0 + across) * (whole - second),
        (false, true) => 0.5 * (1.0 - zeta * zeta) * (whole + along),
    }
}

/// Nodes of the face of one `element` along the profile and one `layer`, with their local coordinates (xi along the profile, zeta along
/// the face), in the numbering of the `loads` and the `fillet` of a mesh: planes of all nodes alternate with planes of corners
/// alone. A surface that is `elements` long; of a `plane` model the line zeta = -1.
pub(super) fn face_nodes(
    elements: usize,
    element: usize,
    layer: usize,
    plane: bool,
) -> impl Iterator<Item = (usize, &'static [f64; 3])> {
    let nodes = QUAD8.iter().filter(move |c| !plane || c[1] == -1.0);
    nodes.map(move |c| {
        let [along, across] = [c[0], c[1]].map(|c| (1.0 + c) as usize);
        let (i, k) = (2 * element + along, 2 * layer + across);
        let within = match k.is_multiple_of(2) {
            true => i,
            false => 2 * elements + 1 + i / 2,
        };
        ((k / 2) * (3 * elements + 2) + within, c)
    })
}

fn local(x: f64, ends: &[f64], i: usize) -> f64 {
    2.0 * (x - ends[i]) / (ends[i + 1] - ends[i]) - 1.0
}

/// Cells of `ends` that `range` touches, as (cell, low, high), the limits cut to the cell. With a single end there is one cell.
fn cells(ends: &[f64], range: [f64; 2]) -> Vec<(usize, f64, f64)> {
    let count = ends.len() - 1;
    if count == 0 {
        return vec![(0, range[0], range[1])];
    }
    let [first, last] = range.map(|x| ends.partition_point(|end| *end <= x).clamp(1, count) - 1);
    let parts = (first..=last).map(|i| {
        let low = if i == first { range[0] } else { ends[i] };
        let high = if i == last { range[1] } else { ends[i + 1] };
        (i, low, high)
    });
    parts.filter(|(_, low, high)| high > low).collect()
}

/// Half-width of the kernel at the tip edge over the element there, which five Gauss points on half a kernel resolve.
const EDGE_KERNEL_OVER_ELEMENT: f64 = 1.5;

/// Distance from the edge at which a load deflects the tip corner as much as one that half a kernel spreads from the edge on, over
/// the half-width: half of exp of the mean of ln(x + y) over both.
const HALF_KERNEL_FROM_EDGE: f64 = 0.269;

/// Spreads a line load across its contact line, and its logarithmic self-displacement.
///
/// phi(t) = 15/16 (1 - t²)² / w for abs(t) < 1, t the distance over the half-width w; cut off at the edges
/// of the flank and scaled back to unit mass.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kernel {
    half_width: f64,
    center: f64,
    /// The part of [-1, 1] that lies on the flank.
    low: f64,
    high: f64,
    mass: f64,
}

/// Gauss-Legendre abscissae and weights on [0, 1], 5 points, exact to degree 9.
const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668_0, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

impl Kernel {
    /// Kernel for a line at the arc length `line` of a flank from `flank[0]` to `flank[1]`, m; beyond an edge as at that edge.
    ///
    /// Near the tip edge the part beyond it is missing. So that the load does not move away from the edge with it, the kernel's
    /// middle is moved towards the edge until its centre of mass lies on the line; half of the kernel always stays.
    pub fn new(half_width: f64, line: f64, flank: [f64; 2]) -> Kernel {
        let line = line.clamp(flank[0], flank[1]);
        let room = (flank[1] - line) / half_width;
        let low = ((flank[0] - line) / half_width).clamp(-1.0, 0.0);
        let mut high = room.clamp(0.0, 1.0);
        if high < 1.0 {
            // The distance of the centre of mass from the edge rises with `high` from the half kernel's value.
            high = bisection([0.0, high], 60, |high| high - mean(low, high) < room);
        }
        let center = if high < 1.0 {
            flank[1] - high * half_width
        } else {
            line
        };
        Kernel {
            half_width,
            center,
            low,
            high,
            mass: cumulative(high) - cumulative(low),
        }
    }

    pub fn support(&self) -> [f64; 2] {
        [self.low, self.high].map(|t| self.center + t * self.half_width)
    }

    pub fn density(&self, arc: f64) -> f64 {
        bump((arc - self.center) / self.half_width) / (self.mass * self.half_width)
    }

    /// exp of the double integral of phi(x) phi(y) ln abs(x - y), m: the line load spread by the kernel
    /// displaces itself, in the kernel's own average, like a half-plane at this distance.
    pub fn reference_length(&self) -> f64 {
        // With the autocorrelation g of the kernel this is 2 int g(t) ln t dt over [0, span]; t = span v^3
        // takes the logarithm's singularity away.
        let span = self.high - self.low;
        let panels = 4;
        let mut sum = 0.0;
        for panel in 0..panels {
            for (x, weight) in GAUSS5 {
                let v = (f64::from(panel) + x) / f64::from(panels);
                let t = span * v * v * v;
                let jacobian = 3.0 * span * v * v / f64::from(panels);
                sum += 2.0 * weight * jacobian * self.autocorrelation(t) * t.ln();
            }
        }
        self.half_width * sum.exp()
    }

    /// int phi(x) phi(x + t) dx over the support, in units of the half-width; degree 8, so exact.
    fn autocorrelation(&self, t: f64) -> f64 {
        let length = self.high - self.low - t;
        let parts = GAUSS5.iter().map(|(x, weight)| {
            let at = self.low + length * x;
            weight * length * bump(at) * bump(at + t)
        });
        parts.sum::<f64>() / (self.mass * self.mass)
    }
}

fn bump(t: f64) -> f64 {
    let inside = (1.0 - t * t).max(0.0);
    15.0 / 16.0 * inside * inside
}

/// Centre of mass of [`bump`] between `low` and `high`.
fn mean(low: f64, high: f64) -> f64 {
    (first_moment(high) - first_moment(low)) / (cumulative(high) - cumulative(low))
}

/// Integral of t [`bump`] from 0 to t.
fn first_moment(t: f64) -> f64 {
    15.0 / 16.0 * t * t * (0.5 - 0.5 * t * t + t.powi(4) / 6.0)
}

/// Integral of [`bump`] from 0 to t.
fn cumulative(t: f64) -> f64 {
    15.0 / 16.0 * (t - 2.0 / 3.0 * t.powi(3) + 0.2 * t.powi(5))
}

#[cfg(test)]
mod tests {
    use super::super::element::shape;
    use super::*;
    use approx::assert_abs_diff_eq;

    /// The double integral cell by cell, the density constant and the logarithm exact in each.
    fn by_cells(kernel: &Kernel, steps: usize) -> f64 {
        let [low, high] = kernel.support();
        let h = (high - low) / steps as f64;
        let twice_integrated = |x: f64| {
            if x == 0.0 {
                0.0
            } else {
                x * x * (0.5 * x.abs().ln() - 0.75)
            }
        };
        let mean_logarithm: Vec<f64> = (0..steps)
            .map(|k| {
                let x = k as f64 * h;
                (twice_integrated(x + h) - 2.0 * twice_integrated(x) + twice_integrated(x - h))
                    / (h * h)
            })
            .collect();
        let mass: Vec<f64> = (0..steps)
            .map(|i| kernel.density(low + (i as f64 + 0.5) * h) * h)
            .collect();
        let mut sum = 0.0;
        for (i, p) in mass.iter().enumerate() {
            for (j, q) in mass.iter().enumerate() {
                sum += p * q * mean_logarithm[i.abs_diff(j)];
            }
        }
        sum.exp()
    }

    #[test]
    fn shares_of_a_load_on_a_line_are_its_shape_functions() {
        for (zeta, xi) in [(-1.0, 0.3), (0.4, -0.7), (0.0, 0.0)] {
            for c in &QUAD8 {
                let expected = 3.0 * shape(2, c, &[xi, zeta, 0.0]).0;
                let share = face_share(c, zeta, [3.0, 3.0 * xi, 3.0 * xi * xi]);
                assert_abs_diff_eq!(share, expected, epsilon = 1e-14);
            }
        }
    }

    #[test]
    fn reference_length_is_the_logarithmic_self_distance_also_at_an_edge() {
        for to_edge in [5.0, 0.4, 0.1, 0.0] {
            let kernel = Kernel::new(0.6, 0.0, [-3.0, to_edge]);
            let expected = by_cells(&kernel, 800);
            assert_abs_diff_eq!(kernel.reference_length() / expected, 1.0, epsilon = 2e-5);
        }
    }

    #[test]
    fn mass_is_one_and_its_centre_on_the_line_up_to_a_third_of_the_width_from_the_edge() {
        for to_edge in [5.0, 0.5, 0.3, 0.2, 0.0] {
            let kernel = Kernel::new(0.6, 0.0, [-3.0, to_edge]);
            let [low, high] = kernel.support();
            assert!(high <= to_edge + 1e-12);
            let points = GAUSS5.map(|(x, w)| (low + x * (high - low), w * (high - low)));
            let moment = |power: i32| -> f64 {
                let parts = points
                    .iter()
                    .map(|(x, w)| w * x.powi(power) * kernel.density(*x));
                parts.sum()
            };
            assert_abs_diff_eq!(moment(0), 1.0, epsilon = 1e-14);
            if to_edge >= 0.2 {
                assert_abs_diff_eq!(moment(1), 0.0, epsilon = 1e-6);
            }
        }
    }
}
