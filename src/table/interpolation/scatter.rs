//! Shepard's method with C2 weights on the nodes of a grid, in one to four coordinates.
//!
//! Each node k has a quadratic q_k through its neighbours and a weight ((R - d)/(R d))³, zero beyond the
//! distance R (Renka, ACM Trans. Math. Softw. 14 (1988) 139-148, with the third power of Algorithm 790, ibid. 25
//! (1999) 70-73, which makes the result twice continuously differentiable). Distances are measured in node
//! spacings of node k, so a node of a sparse region reaches farther. The nodes that reach into a cell are
//! listed per axis when the table is made; no other node is looked at.

use super::fit::Block;

/// Coordinates: centre distance, misalignment, displacement, mesh position.
pub const DIMENSIONS: usize = 4;
/// Pairs (i, j) with i <= j.
const PAIRS: usize = 10;
/// Distance, in node spacings, at which a node's weight vanishes. The middle of a four-dimensional cell is 1 away
/// from its corners; half a cell beyond the edge, it is 1 again.
const REACH: f64 = 1.75;
/// Below this distance from a node its own quadratic is the result to rounding.
const AT_NODE: f64 = 1e-4;

/// Where the second derivative by coordinates i and j stands.
pub const PAIR: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

/// Value with first and second derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet4 {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; DIMENSIONS],
    /// Second derivatives, see [`PAIR`].
    pub second: [f64; PAIRS],
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

/// A node that reaches the point along one axis.
#[derive(Debug, Clone, Copy, Default)]
struct Near {
    /// Index in the grid.
    index: usize,
    /// Way from the node, in its spacings.
    way: f64,
    scale: f64,
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
        let t: [f64; 3] =
            std::array::from_fn(|k| (self.nodes[first + k] - self.nodes[i]) * self.scale[i]);
        Some(std::array::from_fn(|k| {
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

/// K quantities on the nodes of one grid.
#[derive(Debug, Clone)]
pub struct Scatter<const K: usize> {
    lines: [Line; DIMENSIONS],
    strides: [usize; DIMENSIONS],
    /// The quadratics, derivatives by ways in spacings of their node.
    quadratics: Vec<[Jet4; K]>,
}

impl<const K: usize> Scatter<K> {
    /// Through `values` at `nodes`; the last coordinate has period 1. A coordinate with one node is not there.
    pub fn new(nodes: [&[f64]; DIMENSIONS], values: [&Block; K]) -> Self {
        let lines: [Line; DIMENSIONS] = std::array::from_fn(|i| Line::new(nodes[i], i == 3));
        let strides: [usize; DIMENSIONS] = std::array::from_fn(|i| values[0].stride(i));
        let lengths = values[0].lengths;
        let mut quadratics = Vec::with_capacity(values[0].values.len());
        let parabolas: Vec<Vec<_>> = lines
            .iter()
            .map(|l| (0..l.count).map(|i| l.parabola(i)).collect())
            .collect();
        for at in 0..values[0].values.len() {
            let index: [usize; DIMENSIONS] = std::array::from_fn(|i| at / strides[i] % lengths[i]);
            let mut jets = [Jet4::default(); K];
            for (jet, block) in jets.iter_mut().zip(values) {
                let v = &block.values;
                jet.value = v[at];
                for i in 0..DIMENSIONS {
                    let Some(along) = &parabolas[i][index[i]] else {
                        continue;
                    };
                    let base = at - index[i] * strides[i];
                    for &(k, first, second) in along {
                        jet.gradient[i] += first * v[base + k * strides[i]];
                        jet.second[PAIR[i][i]] += second * v[base + k * strides[i]];
                    }
                    for j in i + 1..DIMENSIONS {
                        let Some(across) = &parabolas[j][index[j]] else {
                            continue;
                        };
                        let base = base - index[j] * strides[j];
                        for &(k, a, _) in along {
                            for &(l, b, _) in across {
                                jet.second[PAIR[i][j]] +=
                                    a * b * v[base + k * strides[i] + l * strides[j]];
                            }
                        }
                    }
                }
            }
            quadratics.push(jets);
        }
        Scatter {
            lines,
            strides,
            quadratics,
        }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&self.quadratics[..])
    }

    /// The quantities at `x`, at most half a cell outside the nodes (see [`saturated`]); the last
    /// coordinate in [0, 1).
    /// `H`: all second derivatives, otherwise only the one by displacement (coordinate 2).
    pub fn at<const H: bool>(&self, x: [f64; DIMENSIONS]) -> [Jet4; K] {
        let mut near = [[Near::default(); MOST]; DIMENSIONS];
        let counts: [usize; DIMENSIONS] =
            std::array::from_fn(|i| self.lines[i].near(x[i], &mut near[i]));
        let mut sum = Jet4::default();
        let mut sums = [Jet4::default(); K];
        for a in &near[0][..counts[0]] {
            let d0 = a.way * a.way;
            for b in &near[1][..counts[1]] {
                let d1 = d0 + b.way * b.way;
                if d1 >= REACH * REACH {
                    continue;
                }
                for c in &near[2][..counts[2]] {
                    let d2 = d1 + c.way * c.way;
                    if d2 >= REACH * REACH {
                        continue;
                    }
                    for d in &near[3][..counts[3]] {
                        let square = d2 + d.way * d.way;
                        if square >= REACH * REACH {
                            continue;
                        }
                        let at = a.index * self.strides[0]
                            + b.index * self.strides[1]
                            + c.index * self.strides[2]
                            + d.index * self.strides[3];
                        let axes = [a, b, c, d];
                        let way = axes.map(|n| n.way);
                        let scale = axes.map(|n| n.scale);
                        let quadratics = &self.quadratics[at];
                        if square < AT_NODE * AT_NODE {
                            return quadratics.map(|q| local::<true>(&q, way, scale));
                        }
                        let weight = weight::<H>(square, way, scale);
                        add::<H>(&mut sum, &weight, &ONE);
                        for (sum, q) in sums.iter_mut().zip(quadratics) {
                            add::<H>(sum, &weight, &local::<H>(q, way, scale));
                        }
                    }
                }
            }
        }
        sums.map(|n| quotient::<H>(&n, &sum))
    }
}

const ONE: Jet4 = Jet4 {
    value: 1.0,
    gradient: [0.0; DIMENSIONS],
    second: [0.0; PAIRS],
};

/// Calls `f(i, j)` for the second derivatives that are wanted.
#[inline(always)]
fn pairs<const H: bool>(mut f: impl FnMut(usize, usize)) {
    if H {
        for i in 0..DIMENSIONS {
            for j in i..DIMENSIONS {
                f(i, j);
            }
        }
    } else {
        f(2, 2);
    }
}

/// A node's quadratic at `way` from it.
#[inline(always)]
fn local<const H: bool>(q: &Jet4, way: [f64; DIMENSIONS], scale: [f64; DIMENSIONS]) -> Jet4 {
    let mut out = Jet4 {
        value: q.value,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        let bend: f64 = (0..DIMENSIONS).map(|j| q.second[PAIR[i][j]] * way[j]).sum();
        out.value += way[i] * (q.gradient[i] + 0.5 * bend);
        out.gradient[i] = (q.gradient[i] + bend) * scale[i];
    }
    pairs::<H>(|i, j| out.second[PAIR[i][j]] = q.second[PAIR[i][j]] * scale[i] * scale[j]);
    out
}

/// (1/d - 1/R)³.
#[inline(always)]
fn weight<const H: bool>(square: f64, way: [f64; DIMENSIONS], scale: [f64; DIMENSIONS]) -> Jet4 {
    let inverse = 1.0 / square.sqrt();
    let x = inverse - 1.0 / REACH;
    // First derivative by d over d, and (second derivative - that) over d².
    let first = -3.0 * x * x * inverse.powi(3);
    let second =
        (6.0 * x * inverse.powi(4) + 6.0 * x * x * inverse.powi(3) - first) * inverse * inverse;
    let mut out = Jet4 {
        value: x * x * x,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        out.gradient[i] = first * way[i] * scale[i];
    }
    pairs::<H>(|i, j| {
        let own = if i == j { first } else { 0.0 };
        out.second[PAIR[i][j]] = (own + second * way[i] * way[j]) * scale[i] * scale[j];
    });
    out
}

/// Adds the product of two.
#[inline(always)]
fn add<const H: bool>(sum: &mut Jet4, a: &Jet4, b: &Jet4) {
    sum.value += a.value * b.value;
    for i in 0..DIMENSIONS {
        sum.gradient[i] += a.gradient[i] * b.value + a.value * b.gradient[i];
    }
    pairs::<H>(|i, j| {
        let n = PAIR[i][j];
        sum.second[n] += a.second[n] * b.value
            + a.gradient[i] * b.gradient[j]
            + a.gradient[j] * b.gradient[i]
            + a.value * b.second[n];
    });
}

/// a / b.
#[inline(always)]
fn quotient<const H: bool>(a: &Jet4, b: &Jet4) -> Jet4 {
    let mut out = Jet4 {
        value: a.value / b.value,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        out.gradient[i] = (a.gradient[i] - out.value * b.gradient[i]) / b.value;
    }
    pairs::<H>(|i, j| {
        let n = PAIR[i][j];
        out.second[n] = (a.second[n]
            - out.value * b.second[n]
            - out.gradient[i] * b.gradient[j]
            - out.gradient[j] * b.gradient[i])
            / b.value;
    });
    out
}

/// `x` inside the ends of `nodes`; beyond an end it slows down, twice continuously differentiable, and stops half
/// a cell outside. Value, first and second derivative.
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
    let t = ((x - end) * sign / cell).min(1.0);
    [
        end + sign * cell * (t - t.powi(3) + 0.5 * t.powi(4)),
        1.0 - 3.0 * t * t + 2.0 * t.powi(3),
        sign * (6.0 * t * t - 6.0 * t) / cell,
    ]
}
