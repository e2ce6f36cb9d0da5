//! Shepard's method with C2 weights on the nodes of a grid, in one to four coordinates.
//!
//! Each node k has a quadratic q_k through its neighbours and a weight ((R - d)/(R d))³, zero beyond the
//! distance R (Renka, ACM Trans. Math. Softw. 14 (1988) 139-148, with the third power of Algorithm 790, ibid. 25
//! (1999) 70-73, which makes the result twice continuously differentiable). Distances are measured in node
//! spacings of node k, so a node of a sparse region reaches farther. The nodes that reach into a cell are
//! listed per axis when the table is made; no other node is looked at.

use super::fit::Block;
use std::array::from_fn;
use std::ops::AddAssign;

/// Distance, in node spacings, at which a node's weight vanishes. The middle of a four-dimensional cell is 1 away
/// from its corners; half a cell beyond the edge, it is 1 again.
const REACH: f64 = 1.75;

/// Coordinates: centre distance, misalignment, displacement, mesh position.
pub const DIMENSIONS: usize = 4;

/// Value with its first and second derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dual {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; DIMENSIONS],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; DIMENSIONS]; DIMENSIONS],
}

impl Dual {
    /// 1, a constant.
    pub const ONE: Dual = Dual {
        value: 1.0,
        gradient: [0.0; DIMENSIONS],
        hessian: [[0.0; DIMENSIONS]; DIMENSIONS],
    };

    /// A function of this number from its value `f`, slope `d` and second derivative `dd` there.
    #[inline(always)]
    pub fn chain(&self, f: f64, d: f64, dd: f64) -> Dual {
        let g = &self.gradient;
        Dual {
            value: f,
            gradient: from_fn(|i| d * g[i]),
            hessian: from_fn(|i| from_fn(|j| d * self.hessian[i][j] + dd * g[i] * g[j])),
        }
    }

    /// This number times `b`.
    #[inline(always)]
    pub fn times(&self, b: &Dual) -> Dual {
        let (g, h) = (&self.gradient, &b.gradient);
        Dual {
            value: self.value * b.value,
            gradient: from_fn(|i| g[i] * b.value + self.value * h[i]),
            hessian: from_fn(|i| {
                from_fn(|j| {
                    self.hessian[i][j] * b.value
                        + g[i] * h[j]
                        + g[j] * h[i]
                        + self.value * b.hessian[i][j]
                })
            }),
        }
    }

    /// Of a quadratic with this value and these derivatives by ways in units of their own, at `way`, by the coordinates, of which
    /// `scale` makes one such unit.
    #[inline(always)]
    fn moved(&self, way: &[f64; DIMENSIONS], scale: &[f64; DIMENSIONS]) -> Dual {
        let mut out = Dual {
            value: self.value,
            ..Dual::default()
        };
        for i in 0..DIMENSIONS {
            let bend: f64 = (0..DIMENSIONS).map(|j| self.hessian[i][j] * way[j]).sum();
            out.value += way[i] * (self.gradient[i] + 0.5 * bend);
            out.gradient[i] = (self.gradient[i] + bend) * scale[i];
            for j in 0..DIMENSIONS {
                out.hessian[i][j] = self.hessian[i][j] * scale[i] * scale[j];
            }
        }
        out
    }

    /// This number over `b`.
    #[inline(always)]
    pub fn over(&self, b: &Dual) -> Dual {
        let per = 1.0 / b.value;
        self.times(&b.chain(per, -per * per, 2.0 * per * per * per))
    }
}

impl AddAssign for Dual {
    #[inline(always)]
    fn add_assign(&mut self, b: Dual) {
        self.value += b.value;
        for i in 0..DIMENSIONS {
            self.gradient[i] += b.gradient[i];
            for j in 0..DIMENSIONS {
                self.hessian[i][j] += b.hessian[i][j];
            }
        }
    }
}

/// A node that reaches the point along one axis.
#[derive(Debug, Clone, Copy, Default)]
struct Near {
    /// Index in the grid.
    index: usize,
    /// Way from the node, in its spacings.
    way: f64,
    /// 1 / spacing.
    scale: f64,
}

/// One coordinate: its nodes, or a single one on which nothing depends.
#[derive(Debug, Clone)]
struct Line {
    /// Nodes, ascending; a periodic axis with a period more on both sides.
    nodes: Vec<f64>,
    /// 1 / spacing at each of them: the larger of the two beside it.
    scale: Vec<f64>,
    /// Nodes of the grid (a period of `nodes`).
    count: usize,
    /// Per interval of `nodes` and beyond both ends: the nodes that reach into it.
    reaching: Vec<(u32, u32)>,
}

/// Most nodes that are looked at along one axis. On an even axis four can reach a point; on one so wildly graded that
/// more than these do, the farther ones are left out.
const MOST: usize = 24;

impl Line {
    fn new(nodes: &[f64], periodic: bool) -> Self {
        let count = nodes.len();
        if count == 1 {
            return Line {
                nodes: vec![0.0],
                scale: vec![0.0],
                count,
                reaching: vec![],
            };
        }
        let mut all = nodes.to_vec();
        if periodic {
            all = [-1.0, 0.0, 1.0]
                .iter()
                .flat_map(|turn| nodes.iter().map(move |x| x + turn))
                .collect();
        }
        let n = all.len();
        let scale: Vec<f64> = (0..n)
            .map(|i| {
                let below = if i > 0 { all[i] - all[i - 1] } else { 0.0 };
                let above = if i + 1 < n { all[i + 1] - all[i] } else { 0.0 };
                1.0 / below.max(above)
            })
            .collect();
        let reaching = (0..=n)
            .map(|cell| {
                let low = if cell == 0 {
                    f64::NEG_INFINITY
                } else {
                    all[cell - 1]
                };
                let high = if cell == n { f64::INFINITY } else { all[cell] };
                let reaches = |&i: &usize| {
                    all[i] + REACH / scale[i] > low && all[i] - REACH / scale[i] < high
                };
                let first = (0..n).find(reaches).unwrap_or(0);
                let end = (0..n).rev().find(reaches).map_or(0, |i| i + 1);
                (first as u32, end as u32)
            })
            .collect();
        Line {
            nodes: all,
            scale,
            count,
            reaching,
        }
    }

    /// Writes the nodes that reach `x`; returns how many.
    #[inline]
    fn near(&self, x: f64, out: &mut [Near; MOST]) -> usize {
        if self.count == 1 {
            out[0] = Near::default();
            return 1;
        }
        let cell = self.nodes.partition_point(|&n| n <= x);
        let (first, end) = self.reaching[cell];
        let mut n = 0;
        for i in first as usize..end as usize {
            let way = (x - self.nodes[i]) * self.scale[i];
            if way.abs() < REACH && n < MOST {
                out[n] = Near {
                    index: i % self.count,
                    way,
                    scale: self.scale[i],
                };
                n += 1;
            }
        }
        n
    }

    /// For grid node `i`: three nodes (grid indices) and the weights of first and second derivative of the
    /// parabola through them, in spacings of node i. None on an axis that is not there.
    fn parabola(&self, i: usize) -> Option<[(usize, f64, f64); 3]> {
        if self.count == 1 {
            return None;
        }
        let n = self.nodes.len();
        // The middle period of a periodic axis.
        let i = if n == self.count { i } else { i + self.count };
        let first = i.clamp(1, n - 2) - 1;
        let t: [f64; 3] = from_fn(|k| (self.nodes[first + k] - self.nodes[i]) * self.scale[i]);
        Some(from_fn(|k| {
            let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            let denominator = (t[k] - a) * (t[k] - b);
            (
                (first + k) % self.count,
                -(a + b) / denominator,
                2.0 / denominator,
            )
        }))
    }
}

/// A quantity on the nodes of a grid.
#[derive(Debug, Clone)]
pub struct Scatter {
    lines: [Line; DIMENSIONS],
    strides: [usize; DIMENSIONS],
    quadratics: Vec<Dual>,
}

impl Scatter {
    /// Through `values` at `nodes`; the last coordinate has period 1. A coordinate with one node is not there.
    pub fn new(nodes: [&[f64]; DIMENSIONS], values: &Block) -> Self {
        let lines: [Line; DIMENSIONS] = from_fn(|i| Line::new(nodes[i], i == 3));
        let strides: [usize; DIMENSIONS] = from_fn(|i| values.stride(i));
        let parabolas: Vec<Vec<_>> = lines
            .iter()
            .map(|l| (0..l.count).map(|i| l.parabola(i)).collect())
            .collect();
        let v = &values.values;
        let quadratic = |at: usize| {
            let index: [usize; DIMENSIONS] = from_fn(|i| at / strides[i] % values.lengths[i]);
            let mut q = Dual {
                value: v[at],
                ..Dual::default()
            };
            for i in 0..DIMENSIONS {
                let Some(along) = &parabolas[i][index[i]] else {
                    continue;
                };
                let base = at - index[i] * strides[i];
                for &(k, first, second) in along {
                    q.gradient[i] += first * v[base + k * strides[i]];
                    q.hessian[i][i] += second * v[base + k * strides[i]];
                }
                for j in i + 1..DIMENSIONS {
                    let Some(across) = &parabolas[j][index[j]] else {
                        continue;
                    };
                    let base = base - index[j] * strides[j];
                    for &(k, a, _) in along {
                        for &(l, b, _) in across {
                            q.hessian[i][j] += a * b * v[base + k * strides[i] + l * strides[j]];
                        }
                    }
                    q.hessian[j][i] = q.hessian[i][j];
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

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&self.quadratics[..])
    }

    /// The quantity at `x`, at most half a cell outside the nodes (see [`saturated`]); the last coordinate in [0, 1).
    ///
    /// With k the nearest node and its weight w_k divided out, q = (q_k + N / w_k) / (1 + S / w_k), N and S the sums
    /// over all others: nothing is infinite at a node, and no neighbourhood of it has a rule of its own.
    pub fn at(&self, x: [f64; DIMENSIONS]) -> Dual {
        let mut near = [[Near::default(); MOST]; DIMENSIONS];
        let counts: [usize; DIMENSIONS] = from_fn(|i| self.lines[i].near(x[i], &mut near[i]));
        // Distances add up axis by axis, so the nearest node is the nearest along each.
        let nearest: [usize; DIMENSIONS] = from_fn(|i| {
            let way = |n: &usize| near[i][*n].way.abs();
            (0..counts[i])
                .min_by(|a, b| way(a).total_cmp(&way(b)))
                .unwrap_or_default()
        });
        let (mut weights, mut sum) = (Dual::default(), Dual::default());
        for (i, a) in near[0][..counts[0]].iter().enumerate() {
            let d0 = a.way * a.way;
            for (j, b) in near[1][..counts[1]].iter().enumerate() {
                let d1 = d0 + b.way * b.way;
                if d1 >= REACH * REACH {
                    continue;
                }
                for (k, c) in near[2][..counts[2]].iter().enumerate() {
                    let d2 = d1 + c.way * c.way;
                    if d2 >= REACH * REACH {
                        continue;
                    }
                    for (l, d) in near[3][..counts[3]].iter().enumerate() {
                        let square = d2 + d.way * d.way;
                        if square >= REACH * REACH || [i, j, k, l] == nearest {
                            continue;
                        }
                        let (square, q) = self.node([a, b, c, d]);
                        let weight = weight(&square);
                        weights += weight;
                        sum += weight.times(&q);
                    }
                }
            }
        }
        let (square, mut above) = self.node(from_fn(|i| &near[i][nearest[i]]));
        let per_weight = inverse_weight(&square);
        let mut below = Dual::ONE;
        below += per_weight.times(&weights);
        above += per_weight.times(&sum);
        above.over(&below)
    }

    /// Square of the distance from a node, in its spacings, and its quadratic at the point.
    #[inline(always)]
    fn node(&self, axes: [&Near; DIMENSIONS]) -> (Dual, Dual) {
        let (way, scale) = (axes.map(|n| n.way), axes.map(|n| n.scale));
        let mut square = Dual::default();
        for i in 0..DIMENSIONS {
            square.value += way[i] * way[i];
            square.gradient[i] = 2.0 * way[i] * scale[i];
            square.hessian[i][i] = 2.0 * scale[i] * scale[i];
        }
        let at: usize = (0..DIMENSIONS)
            .map(|i| axes[i].index * self.strides[i])
            .sum();
        (square, self.quadratics[at].moved(&way, &scale))
    }
}

/// (1/d - 1/R)³ of the square of d > 0.
#[inline(always)]
fn weight(square: &Dual) -> Dual {
    let per = 1.0 / square.value.sqrt();
    let x = per - 1.0 / REACH;
    // Derivatives of x by the square.
    let (d, dd) = (-0.5 * per.powi(3), 0.75 * per.powi(5));
    square.chain(
        x * x * x,
        3.0 * x * x * d,
        6.0 * x * d * d + 3.0 * x * x * dd,
    )
}

/// 1 / (1/d - 1/R)³ of the square of d < R.
#[inline(always)]
fn inverse_weight(square: &Dual) -> Dual {
    let d = square.value.sqrt();
    let r = 1.0 / (1.0 - d / REACH);
    let r4 = r * r * r * r;
    // The second derivative by the square is infinite at the node itself, and its share of any nought.
    let dd = if d > 0.0 {
        (3.0 * r - 2.25) * r4 / d
    } else {
        0.0
    };
    square.chain((r * d).powi(3), 1.5 * r4 * d, dd)
}

/// `x` inside the ends of `nodes`; beyond an end it slows down, twice continuously differentiable, and stops half
/// a cell outside. Value and two derivatives.
pub fn saturated(x: f64, nodes: &[f64]) -> [f64; 3] {
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
    let way = (x - end) * sign / cell;
    let t = way.min(1.0);
    [
        end + sign * cell * (t - t.powi(3) + 0.5 * t.powi(4)),
        1.0 - 3.0 * t * t + 2.0 * t.powi(3),
        sign * (6.0 * t * t - 6.0 * t) / cell,
    ]
}
