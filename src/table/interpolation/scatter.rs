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
/// Where the second derivative by coordinates i and j stands.
pub const PAIR: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

/// The displacement among the coordinates.
const U: usize = 2;

/// Value with first and second derivatives, and the derivatives of the second one by the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet4 {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; DIMENSIONS],
    /// Second derivatives, see [`PAIR`].
    pub second: [f64; PAIRS],
    /// Of `second[PAIR[2][2]]` by the coordinates: the stiffness has a gradient, too.
    pub third: [f64; DIMENSIONS],
}

/// A node's quadratic: value and derivatives there, by ways in spacings of the node.
#[derive(Debug, Clone, Copy, Default)]
struct Quadratic {
    value: f64,
    gradient: [f64; DIMENSIONS],
    second: [f64; PAIRS],
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
    quadratics: Vec<[Quadratic; K]>,
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
            let mut jets = [Quadratic::default(); K];
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
    /// `H`: all second derivatives and the third ones, otherwise only the second one by displacement.
    ///
    /// With k the nearest node and its weight w_k divided out, q = (q_k + N / w_k) / (1 + S / w_k), N and S the sums
    /// over all others: nothing is infinite at a node, and no neighbourhood of it has a rule of its own.
    pub fn at<const H: bool>(&self, x: [f64; DIMENSIONS]) -> [Jet4; K] {
        let mut near = [[Near::default(); MOST]; DIMENSIONS];
        let counts: [usize; DIMENSIONS] =
            std::array::from_fn(|i| self.lines[i].near(x[i], &mut near[i]));
        // Distances add up axis by axis, so the nearest node is the nearest along each.
        let nearest: [usize; DIMENSIONS] = std::array::from_fn(|i| {
            let way = |n: &usize| near[i][*n].way.abs();
            (0..counts[i])
                .min_by(|a, b| way(a).total_cmp(&way(b)))
                .unwrap_or_default()
        });
        let mut sum = Jet4::default();
        let mut sums = [Jet4::default(); K];
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
                        let at = Place::of([a, b, c, d]);
                        let weight = weight::<H>(square.sqrt(), &at);
                        add::<H>(&mut sum, &weight, &ONE);
                        for (sum, q) in sums.iter_mut().zip(self.quadratics(&at)) {
                            add::<H>(sum, &weight, &local::<H>(q, &at));
                        }
                    }
                }
            }
        }
        let at = Place::of(std::array::from_fn(|i| &near[i][nearest[i]]));
        let square: f64 = at.way.iter().map(|w| w * w).sum();
        let per_weight = inverse_weight::<H>(square.sqrt(), &at);
        let mut below = ONE;
        add::<H>(&mut below, &per_weight, &sum);
        let own = self.quadratics(&at);
        std::array::from_fn(|k| {
            let mut above = local::<H>(&own[k], &at);
            add::<H>(&mut above, &per_weight, &sums[k]);
            quotient::<H>(&above, &below)
        })
    }

    fn quadratics(&self, at: &Place) -> &[Quadratic; K] {
        &self.quadratics[(0..DIMENSIONS)
            .map(|i| at.index[i] * self.strides[i])
            .sum::<usize>()]
    }
}

/// A node as seen from the point.
struct Place {
    index: [usize; DIMENSIONS],
    /// Way from the node, in its spacings, and 1 / these.
    way: [f64; DIMENSIONS],
    scale: [f64; DIMENSIONS],
}

impl Place {
    fn of(axes: [&Near; DIMENSIONS]) -> Self {
        Place {
            index: axes.map(|n| n.index),
            way: axes.map(|n| n.way),
            scale: axes.map(|n| n.scale),
        }
    }
}

const ONE: Jet4 = Jet4 {
    value: 1.0,
    gradient: [0.0; DIMENSIONS],
    second: [0.0; PAIRS],
    third: [0.0; DIMENSIONS],
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
        f(U, U);
    }
}

/// A node's quadratic at the point.
#[inline(always)]
fn local<const H: bool>(q: &Quadratic, at: &Place) -> Jet4 {
    let (way, scale) = (&at.way, &at.scale);
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

/// A function f of the distance d from a node.
struct Radial {
    value: f64,
    /// f'.
    slope: f64,
    /// f' / d.
    across: f64,
    /// f'' - f' / d.
    along: f64,
    /// That over d.
    along_over: f64,
    /// d² times the derivative of (f'' - f' / d) / d².
    third: f64,
}

impl Radial {
    /// Over the coordinates, at the distance `d`.
    #[inline(always)]
    fn jet<const H: bool>(&self, d: f64, at: &Place) -> Jet4 {
        let scale = &at.scale;
        // At the node itself there is no direction, and nothing that is smooth there has need of one.
        let per = if d > 0.0 { 1.0 / d } else { 0.0 };
        let e = at.way.map(|w| w * per);
        let mut out = Jet4 {
            value: self.value,
            ..Jet4::default()
        };
        for i in 0..DIMENSIONS {
            out.gradient[i] = self.slope * e[i] * scale[i];
        }
        pairs::<H>(|i, j| {
            let across = if i == j { self.across } else { 0.0 };
            out.second[PAIR[i][j]] = (across + self.along * e[i] * e[j]) * scale[i] * scale[j];
        });
        if H {
            for i in 0..DIMENSIONS {
                let own = if i == U { 2.0 * e[U] } else { 0.0 };
                let sum = self.along_over * (e[i] + own) + self.third * e[i] * e[U] * e[U];
                out.third[i] = sum * scale[i] * scale[U] * scale[U];
            }
        }
        out
    }
}

/// (1/d - 1/R)³, d > 0.
#[inline(always)]
fn weight<const H: bool>(d: f64, at: &Place) -> Jet4 {
    let per = 1.0 / d;
    let x = per - 1.0 / REACH;
    let (per2, per3) = (per * per, per * per * per);
    let radial = Radial {
        value: x * x * x,
        slope: -3.0 * x * x * per2,
        across: -3.0 * x * x * per3,
        along: x * per3 * (6.0 * per + 9.0 * x),
        along_over: x * per2 * per2 * (6.0 * per + 9.0 * x),
        third: -per2 * per2 * (6.0 * per2 + 54.0 * x * per + 45.0 * x * x),
    };
    radial.jet::<H>(d, at)
}

/// 1 / (1/d - 1/R)³, d < R.
#[inline(always)]
fn inverse_weight<const H: bool>(d: f64, at: &Place) -> Jet4 {
    let r = 1.0 / (1.0 - d / REACH);
    let (r3, r4) = (r * r * r, r * r * r * r);
    let radial = Radial {
        value: r3 * d * d * d,
        slope: 3.0 * r4 * d * d,
        across: 3.0 * r4 * d,
        along: r4 * (12.0 * r - 9.0) * d,
        along_over: r4 * (12.0 * r - 9.0),
        third: r4 * ((60.0 * r - 108.0) * r + 45.0),
    };
    radial.jet::<H>(d, at)
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
    if H {
        let uu = PAIR[U][U];
        for i in 0..DIMENSIONS {
            let iu = PAIR[i][U];
            sum.third[i] += a.third[i] * b.value
                + a.second[uu] * b.gradient[i]
                + 2.0 * (a.second[iu] * b.gradient[U] + a.gradient[U] * b.second[iu])
                + a.gradient[i] * b.second[uu]
                + a.value * b.third[i];
        }
    }
}

/// a / b.
#[inline(always)]
fn quotient<const H: bool>(a: &Jet4, b: &Jet4) -> Jet4 {
    let per = 1.0 / b.value;
    let mut out = Jet4 {
        value: a.value * per,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        out.gradient[i] = (a.gradient[i] - out.value * b.gradient[i]) * per;
    }
    pairs::<H>(|i, j| {
        let n = PAIR[i][j];
        out.second[n] = (a.second[n]
            - out.value * b.second[n]
            - out.gradient[i] * b.gradient[j]
            - out.gradient[j] * b.gradient[i])
            * per;
    });
    if H {
        let uu = PAIR[U][U];
        for i in 0..DIMENSIONS {
            let iu = PAIR[i][U];
            out.third[i] = (a.third[i]
                - out.second[uu] * b.gradient[i]
                - 2.0 * (out.second[iu] * b.gradient[U] + out.gradient[U] * b.second[iu])
                - out.gradient[i] * b.second[uu]
                - out.value * b.third[i])
                * per;
        }
    }
    out
}

/// `x` inside the ends of `nodes`; beyond an end it slows down, twice continuously differentiable, and stops half
/// a cell outside. Value and three derivatives.
pub fn saturated(x: f64, nodes: &[f64]) -> [f64; 4] {
    let n = nodes.len();
    if n == 1 {
        return [0.0; 4];
    }
    let (end, sign, cell) = if x > nodes[n - 1] {
        (nodes[n - 1], 1.0, nodes[n - 1] - nodes[n - 2])
    } else if x < nodes[0] {
        (nodes[0], -1.0, nodes[1] - nodes[0])
    } else {
        return [x, 1.0, 0.0, 0.0];
    };
    // The slope falls from 1 to 0 over one cell as 1 - 3 t² + 2 t³, whose integral is 1/2.
    let way = (x - end) * sign / cell;
    let t = way.min(1.0);
    [
        end + sign * cell * (t - t.powi(3) + 0.5 * t.powi(4)),
        1.0 - 3.0 * t * t + 2.0 * t.powi(3),
        sign * (6.0 * t * t - 6.0 * t) / cell,
        if way < 1.0 {
            (12.0 * t - 6.0) / (cell * cell)
        } else {
            0.0
        },
    ]
}
