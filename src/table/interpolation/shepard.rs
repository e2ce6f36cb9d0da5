//! Shepard's method with C2 weights as an interpolant of a table, the paper's choice.
//!
//! Each node k of the grid has a quadratic q_k through its neighbours and a weight ((R - d)/(R d))³, zero beyond the
//! distance R (Renka, ACM Trans. Math. Softw. 14 (1988) 139-148, with the third power of Algorithm 790, ibid. 25
//! (1999) 70-73, which makes the result twice continuously differentiable). Distances are measured in node
//! spacings of node k, so a node of a sparse region reaches farther.
//!
//! What is interpolated is the potential over that of the mean flank: w(u, y) = h(u) g(u, y), where h is the
//! integral of the mean force over all columns as an onset spline. g is near the same everywhere, and h carries the
//! onset: force, stiffness and its slope are zero at u = 0 exactly. Force and moment are derivatives of one
//! potential, as with the spline. What the method lacks: the force may fall over u between the nodes.

use super::basis::{Basis, Ends};
use super::fit::{axis, breaks, integrated, make_increasing};
use super::kernel::{ANY, Frame, Jet, SECOND, Shape};
use super::tensor::Tensor;
use crate::table::block::Block;
use crate::table::{Axis, COORDINATES, FlankGrid, Potential, Query, TableError};
use crate::vector::Lanes;
use nalgebra::{Matrix4, Vector4};
use std::array::from_fn;
use std::ops::AddAssign;

/// The displacement among the coordinates (centre distance, misalignment, displacement, mesh position), and the others.
const U: usize = 2;
const Y: [usize; 3] = [0, 1, 3];

/// Distance, in node spacings, at which a node's weight vanishes. The middle of a four-dimensional cell is 1 away
/// from its corners; half a cell beyond the edge, it is 1 again.
const RADIUS: f64 = 1.75;

/// Steps below u = 1 over which third derivatives of g are taken.
const BELOW_TOP: f64 = 1e-5;

/// Most nodes along one axis that are looked at. On an even axis four can reach a point.
const MOST: usize = 24;

#[derive(Debug)]
pub struct Shepard {
    pub frame: Frame<4>,
    u: Basis<5>,
    /// Coefficients of h.
    mean: Vec<f64>,
    shape: Scatter,
    /// Moment over dh/du, where it is not dW/dM.
    lever: Option<Scatter>,
    /// Nodes of centre distance and misalignment.
    nodes: [Vec<f64>; 2],
}

impl Shepard {
    pub fn new(grid: &FlankGrid, tensor: Tensor<5, 4>) -> Result<Self, TableError> {
        let axes = &grid.axes;
        let u_nodes = &axes.displacement_fraction;
        let u_breaks = breaks(u_nodes, 3, Ends::Onset);
        let (force_basis, fit) = axis::<4>(u_nodes, Ends::Onset, Axis::Displacement.name())?;
        let u = Basis::<5>::new(&u_breaks, Ends::Onset);
        let top = grid.top_force();
        let stored = force_basis.stored();
        // A little of u³ keeps the mean above zero next to the onset, whatever the samples.
        let mut mean_force: Vec<f64> = (0..stored)
            .map(|r| match r {
                0..3 => 0.0,
                _ => 1e-4 * top * (r as f64 / (stored - 1) as f64).powi(3),
            })
            .collect();
        let columns = grid.no_load_approach.len();
        let force = fit.along(2, &grid.block(&grid.loa_force));
        let force = force.mapped(2, stored, |mut line| {
            make_increasing(&mut line[3..]);
            for (mean, force) in mean_force.iter_mut().zip(&line) {
                *mean += force / columns as f64;
            }
            line
        });
        let mean = integrated(&mean_force, &u_breaks, 3);
        let with_zero = [&[0.0], &u_nodes[..]].concat();
        // `values` over the mean, potentials (0) or forces (1): at the onset both begin with their first coefficient.
        let over_mean = |values: &Block, derivative: usize| {
            let ratios = values.mapped(2, with_zero.len(), |line| {
                let integral = integrated(&line, &u_breaks, 3);
                let ratio = |&x: &f64| {
                    let w = u.inside(x);
                    let weights = [&w.value, &w.slope][derivative];
                    w.sum(weights, &integral) / w.sum(weights, &mean)
                };
                let onset = [line[3] / mean_force[3]];
                onset.into_iter().chain(u_nodes.iter().map(ratio)).collect()
            });
            let [c, m] = [&axes.center_distance_offset, &axes.misalignment];
            Scatter::new([c, m, &with_zero, &axes.mesh_position], &ratios)
        };
        let own_moment = (grid.moment.as_ref()).filter(|_| axes.misalignment.len() == 1);
        let own_moment = own_moment.map(|moment| fit.along(2, &grid.block(moment)));
        Ok(Shepard {
            frame: tensor.frame,
            shape: over_mean(&force, 0),
            lever: own_moment.map(|moment| over_mean(&moment, 1)),
            nodes: [
                axes.center_distance_offset.clone(),
                axes.misalignment.clone(),
            ],
            u,
            mean,
        })
    }

    /// The `derivative`th derivative of h, times `scatter`, at x = (C, M, u, PMC). Beyond the top load, u = 1, it goes on by its Taylor
    /// series there, W to the second order and dW/du to the first, so that loads go on linearly. The curvature of g is left out of it:
    /// that of the nodes' quadratics is rough.
    fn product(&self, scatter: &Scatter, derivative: usize, x: [f64; COORDINATES]) -> Dual {
        let (w, _) = self.u.weights(Lanes::COMMON, x[U].min(1.0), 2);
        let h = [&w.value, &w.slope, &w.curvature].map(|weights| w.sum(weights, &self.mean));
        // The second derivative of the force is not needed.
        let h: [f64; 3] = from_fn(|i| h.get(derivative + i).copied().unwrap_or_default());
        if x[U] <= 1.0 {
            return Dual::along_u(h).times(&self.at(scatter, x));
        }
        let below = [0.0, 1.0, 2.0].map(|steps| {
            let u = 1.0 - steps * BELOW_TOP;
            self.at(scatter, [x[0], x[1], u, x[3]])
        });
        let beyond = x[U] - 1.0;
        let bend = if derivative == 0 { h[1] } else { 0.0 };
        let of_value = [
            h[0] + (h[1] + 0.5 * h[2] * beyond) * beyond,
            h[1] + h[2] * beyond,
            h[2],
        ];
        let of_slope = [
            (h[0] + bend * beyond) * beyond,
            h[0] + 2.0 * bend * beyond,
            2.0 * bend,
        ];
        let mut out = Dual::along_u(of_value).times(&below[0].at_fixed_u());
        out += Dual::along_u(of_slope).times(&Dual::slope_over_u(&below));
        out
    }

    /// `scatter` at x, its displacement within the nodes.
    fn at(&self, scatter: &Scatter, x: [f64; COORDINATES]) -> Dual {
        let stops: [[f64; 3]; 2] = from_fn(|i| saturated(x[i], &self.nodes[i]));
        let turn = match self.frame.p.present() {
            true => x[3] - x[3].floor(),
            false => 0.0,
        };
        let g = scatter.at([stops[0][0], stops[1][0], x[U], turn]);
        g.through_stops(&stops)
    }

    pub fn evaluate(&self, lanes: Lanes, q: &Query) -> Potential {
        let at = lanes.run(
            #[inline(always)]
            |lanes| self.frame.at::<true, ANY>(lanes, q),
        );
        if at.u <= 0.0 || at.u.is_nan() {
            return at.none();
        }
        let (c, m) = (q.center_distance_offset, q.misalignment);
        let x = [c, m, at.u, q.mesh_position];
        let w = self.product(&self.shape, 0, x);
        let jet = |value: f64, gradient: [f64; 3]| Jet {
            value,
            gradient,
            ..Jet::default()
        };
        let mut shape = Shape {
            value: jet(w.value, Y.map(|i| w.gradient[i])),
            slope: jet(w.gradient[U], Y.map(|i| w.hessian[(i, U)])),
            curvature: w.hessian[(U, U)],
        };
        for (i, row) in SECOND.iter().enumerate() {
            for (j, n) in row.iter().enumerate().skip(i) {
                shape.value.second[*n] = w.hessian[(Y[i], Y[j])];
            }
        }
        let mut out = at.potential::<true>(&shape);
        if let Some(lever) = &self.lever {
            let moment = self.product(lever, 1, x);
            let shape = Shape {
                value: Jet::default(),
                slope: jet(moment.value, Y.map(|i| moment.gradient[i])),
                curvature: moment.gradient[U],
            };
            at.set_moment::<true>(&mut out, &shape);
        }
        out.out_of_range |= at.u > 1.0;
        out
    }

    pub fn bytes(&self) -> usize {
        let scatters = [&self.shape].into_iter().chain(&self.lever);
        let quadratics = scatters.map(|scatter| size_of_val(&scatter.quadratics[..]));
        quadratics.sum::<usize>() + self.frame.bytes() + 8 * self.mean.len()
    }
}

/// `x` inside the ends of `nodes`; beyond an end it slows down, twice continuously differentiable, and stops half
/// a cell outside. Value and two derivatives.
fn saturated(x: f64, nodes: &[f64]) -> [f64; 3] {
    let n = nodes.len();
    if n == 1 {
        return [0.0; 3];
    }
    let (end, sign, cell) = if x > nodes[n - 1] {
        (nodes[n - 1], 1.0, nodes[n - 1] - nodes[n - 2])
    } else if x < nodes[0] {
        (nodes[0], -1.0, nodes[1] - nodes[0])
    } else {
        return [x, 1.0, 0.0];
    };
    // The slope falls from 1 to 0 over one cell as 1 - 3 t² + 2 t³, whose integral is 1/2.
    let t = ((x - end) * sign / cell).min(1.0);
    [
        end + sign * cell * (t - t.powi(3) + 0.5 * t.powi(4)),
        1.0 - 3.0 * t * t + 2.0 * t.powi(3),
        sign * (6.0 * t * t - 6.0 * t) / cell,
    ]
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Dual {
    value: f64,
    gradient: Vector4<f64>,
    hessian: Matrix4<f64>,
}

impl Dual {
    fn constant(value: f64) -> Dual {
        Dual {
            value,
            ..Dual::default()
        }
    }

    /// A function of u alone from its value and two derivatives.
    fn along_u([value, slope, curvature]: [f64; 3]) -> Dual {
        let mut of_u = Dual::constant(value);
        of_u.gradient[U] = slope;
        of_u.hessian[(U, U)] = curvature;
        of_u
    }

    /// This at its u, as a function of the other coordinates.
    fn at_fixed_u(mut self) -> Dual {
        self.gradient[U] = 0.0;
        self.hessian.row_mut(U).fill(0.0);
        self.hessian.column_mut(U).fill(0.0);
        self
    }

    /// The slope over u, at a fixed u, as a function of the other coordinates, of what has these values there, [`BELOW_TOP`] and twice that
    /// below. Their second derivatives tell the third ones, to the second order.
    fn slope_over_u(below: &[Dual; 3]) -> Dual {
        let [at, once, twice] = below.map(|dual| dual.hessian);
        let slope = Dual {
            value: below[0].gradient[U],
            gradient: below[0].hessian.column(U).into_owned(),
            hessian: (at * 3.0 - once * 4.0 + twice) / (2.0 * BELOW_TOP),
        };
        slope.at_fixed_u()
    }

    /// A function of this number from its value `f`, slope `d` and second derivative `dd` there.
    fn chain(&self, f: f64, d: f64, dd: f64) -> Dual {
        let g = &self.gradient;
        Dual {
            value: f,
            gradient: g * d,
            hessian: self.hessian * d + g * dd * g.transpose(),
        }
    }

    fn times(&self, b: &Dual) -> Dual {
        let (g, h) = (&self.gradient, &b.gradient);
        let mixed = self.hessian * b.value + g * h.transpose() + h * g.transpose();
        Dual {
            value: self.value * b.value,
            gradient: g * b.value + h * self.value,
            hessian: mixed + b.hessian * self.value,
        }
    }

    /// Of a quadratic with this value and these derivatives by ways in units of their own, at `way`, by the coordinates, of which
    /// `scale` makes one such unit.
    fn moved(&self, way: &Vector4<f64>, scale: &Vector4<f64>) -> Dual {
        let bend = self.hessian * way;
        let slopes = self.gradient + 0.5 * bend;
        Dual {
            value: (0..COORDINATES).fold(self.value, |sum, i| sum + way[i] * slopes[i]),
            gradient: (self.gradient + bend).component_mul(scale),
            hessian: Matrix4::from_fn(|i, j| self.hessian[(i, j)] * scale[i] * scale[j]),
        }
    }

    /// Derivatives by the coordinates from those by the coordinates that [`saturated`] keeps inside the range.
    fn through_stops(&self, stops: &[[f64; 3]; 2]) -> Dual {
        let slope = Vector4::from_fn(|i, _| stops.get(i).map_or(1.0, |s| s[1]));
        let bend = Vector4::from_fn(|i, _| stops.get(i).map_or(0.0, |s| self.gradient[i] * s[2]));
        let hessian = self.hessian.component_mul(&(slope * slope.transpose()));
        Dual {
            value: self.value,
            gradient: self.gradient.component_mul(&slope),
            hessian: hessian + Matrix4::from_diagonal(&bend),
        }
    }
}

impl AddAssign for Dual {
    fn add_assign(&mut self, b: Dual) {
        self.value += b.value;
        self.gradient += b.gradient;
        self.hessian += b.hessian;
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Near {
    index: usize,
    /// Way from the node, in its spacings.
    way: f64,
    scale: f64,
}

/// One coordinate: its nodes, or a single one on which nothing depends.
#[derive(Debug, Clone)]
struct Line {
    /// Nodes, ascending; a periodic axis with a period more on both sides.
    nodes: Vec<f64>,
    /// 1 / spacing at each of them: the larger of the two next to it.
    scale: Vec<f64>,
    /// Nodes of the grid (a period of `nodes`).
    count: usize,
    radius: f64,
}

impl Line {
    fn new(nodes: &[f64], periodic: bool) -> Self {
        let count = nodes.len();
        let turns: &[f64] = match periodic && count > 1 {
            true => &[-1.0, 0.0, 1.0],
            false => &[0.0],
        };
        let of_turn = |turn: f64| nodes.iter().map(move |x| x + turn);
        let all: Vec<f64> = turns.iter().copied().flat_map(of_turn).collect();
        let spacing = |i: usize| {
            let below = if i > 0 { all[i] - all[i - 1] } else { 0.0 };
            let above = all.get(i + 1).map_or(0.0, |next| next - all[i]);
            below.max(above)
        };
        let spacings = (0..all.len()).map(spacing);
        Line {
            radius: RADIUS * spacings.clone().fold(0.0, f64::max),
            scale: spacings.map(f64::recip).collect(),
            nodes: all,
            count,
        }
    }

    #[inline]
    fn near<'a>(&self, x: f64, out: &'a mut [Near; MOST]) -> &'a [Near] {
        if self.count == 1 {
            return &out[..1];
        }
        let mut n = 0;
        for i in self.nodes.partition_point(|&node| node < x - self.radius)..self.nodes.len() {
            let way = (x - self.nodes[i]) * self.scale[i];
            if self.nodes[i] > x + self.radius || n == MOST {
                break;
            }
            if way.abs() < RADIUS {
                out[n] = Near {
                    index: i % self.count,
                    way,
                    scale: self.scale[i],
                };
                n += 1;
            }
        }
        &out[..n]
    }

    /// For grid node `i`: three nodes (grid indices) and the weights of first and second derivative of the
    /// parabola through them, in spacings of node i. None on an axis that is not there.
    fn parabola(&self, i: usize) -> Option<[(usize, f64, f64); 3]> {
        if self.count == 1 {
            return None;
        }
        let n = self.nodes.len();
        let i = if n == self.count { i } else { i + self.count };
        let first = i.clamp(1, n - 2) - 1;
        let t: [f64; 3] = from_fn(|k| (self.nodes[first + k] - self.nodes[i]) * self.scale[i]);
        Some(from_fn(|k| {
            let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            let denominator = (t[k] - a) * (t[k] - b);
            let (slope, curvature) = (-(a + b) / denominator, 2.0 / denominator);
            ((first + k) % self.count, slope, curvature)
        }))
    }
}

#[derive(Debug, Clone)]
struct Scatter {
    lines: [Line; COORDINATES],
    strides: [usize; COORDINATES],
    quadratics: Vec<Dual>,
}

impl Scatter {
    /// Through `values` at `nodes`; the last coordinate has period 1. A coordinate with one node is not there.
    fn new(nodes: [&[f64]; COORDINATES], values: &Block) -> Self {
        let lines: [Line; COORDINATES] = from_fn(|i| Line::new(nodes[i], i == 3));
        let strides: [usize; COORDINATES] = from_fn(|i| values.stride(i));
        let v = &values.values;
        let quadratic = |at: usize| {
            let index: [usize; COORDINATES] = from_fn(|i| at / strides[i] % values.lengths[i]);
            let parabolas: [_; COORDINATES] = from_fn(|i| lines[i].parabola(index[i]));
            let mut q = Dual::constant(v[at]);
            for (i, along) in parabolas.iter().enumerate() {
                let base = at - index[i] * strides[i];
                for (k, first, second) in along.iter().flatten() {
                    q.gradient[i] += first * v[base + k * strides[i]];
                    q.hessian[(i, i)] += second * v[base + k * strides[i]];
                    for (j, across) in parabolas.iter().enumerate().skip(i + 1) {
                        let base = base + k * strides[i] - index[j] * strides[j];
                        for (l, factor, _) in across.iter().flatten() {
                            q.hessian[(i, j)] += first * factor * v[base + l * strides[j]];
                        }
                        q.hessian[(j, i)] = q.hessian[(i, j)];
                    }
                }
            }
            q
        };
        Scatter {
            quadratics: (0..v.len()).map(quadratic).collect(),
            lines,
            strides,
        }
    }

    /// The quantity at `x`, at most half a cell outside the nodes (see [`saturated`]); the last coordinate in [0, 1).
    ///
    /// With k the nearest node and its weight w_k divided out, q = (q_k + N / w_k) / (1 + S / w_k), N and S the sums
    /// over all others: nothing is infinite at a node, and no neighbourhood of it has a rule of its own.
    fn at(&self, x: [f64; COORDINATES]) -> Dual {
        let mut near = [[Near::default(); MOST]; COORDINATES];
        let [c, m, u, p] = &mut near;
        let [along_c, along_m, along_u, along_p] = &self.lines;
        let axes = [
            along_c.near(x[0], c),
            along_m.near(x[1], m),
            along_u.near(x[2], u),
            along_p.near(x[3], p),
        ];
        // Distances add up axis by axis, so the nearest node is the nearest along each.
        let nearest = axes.map(|near| {
            let ways = near.iter().copied();
            let nearest = ways.min_by(|a, b| a.way.abs().total_cmp(&b.way.abs()));
            nearest.unwrap_or_default()
        });
        let (mut weights, mut sum) = (Dual::default(), Dual::default());
        for &a in axes[0] {
            for &b in axes[1] {
                for &c in axes[2] {
                    for &d in axes[3] {
                        let node = [a, b, c, d];
                        let square: f64 = node.iter().map(|n| n.way * n.way).sum();
                        if square < RADIUS * RADIUS && node != nearest {
                            let (square, q) = self.node(node);
                            let weight = weight(&square);
                            weights += weight;
                            sum += weight.times(&q);
                        }
                    }
                }
            }
        }
        let (square, mut above) = self.node(nearest);
        let per_weight = inverse_weight(&square);
        let mut below = per_weight.times(&weights);
        below.value += 1.0;
        above += per_weight.times(&sum);
        let per = 1.0 / below.value;
        above.times(&below.chain(per, -per * per, 2.0 * per * per * per))
    }

    /// Square of the distance from a node, in its spacings, and its quadratic at the point.
    fn node(&self, axes: [Near; COORDINATES]) -> (Dual, Dual) {
        let [way, scale] = [axes.map(|n| n.way), axes.map(|n| n.scale)].map(Vector4::from);
        let square = Dual {
            value: way.iter().map(|way| way * way).sum(),
            gradient: 2.0 * way.component_mul(&scale),
            hessian: Matrix4::from_diagonal(&(2.0 * scale.component_mul(&scale))),
        };
        let indices = axes.iter().zip(self.strides);
        let at: usize = indices.map(|(n, stride)| n.index * stride).sum();
        (square, self.quadratics[at].moved(&way, &scale))
    }
}

/// (1/d - 1/R)³ of the square of d > 0.
fn weight(square: &Dual) -> Dual {
    let per = 1.0 / square.value.sqrt();
    let x = per - 1.0 / RADIUS;
    let (d, dd) = (-0.5 * per.powi(3), 0.75 * per.powi(5));
    let bend = 6.0 * x * d * d + 3.0 * x * x * dd;
    square.chain(x * x * x, 3.0 * x * x * d, bend)
}

/// 1 / (1/d - 1/R)³ of the square of d < R.
fn inverse_weight(square: &Dual) -> Dual {
    let d = square.value.sqrt();
    let r = 1.0 / (1.0 - d / RADIUS);
    let r4 = r * r * r * r;
    // The second derivative by the square is infinite at the node itself, and its share of any nought.
    let dd = match d > 0.0 {
        true => (3.0 * r - 2.25) * r4 / d,
        false => 0.0,
    };
    square.chain((r * d).powi(3), 1.5 * r4 * d, dd)
}
