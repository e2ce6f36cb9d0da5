//! From values at the nodes of a grid to the coefficients of tensor B-splines.

use super::basis::{Basis, Ends};
use crate::table::block::Block;
use crate::table::error::refused;
use crate::table::{Axis, TableError};

/// Ends of the cells of an interpolant of degree `degree` whose data sit at `nodes` (periodic: over
/// [0, 1), period 1; onset: without the zero at 0), so that there are as many functions as nodes.
pub fn breaks(nodes: &[f64], degree: usize, ends: Ends) -> Vec<f64> {
    let n = nodes.len();
    match (ends, degree) {
        (Ends::Periodic, _) => [nodes, &[nodes[0] + 1.0]].concat(),
        // Not-a-knot: no cell ends at the second and the last but one node.
        (Ends::Bounded, 3) => [&nodes[..1], &nodes[2..n - 2], &nodes[n - 1..]].concat(),
        // Value, slope and curvature vanish at 0: one more cell before the first node, and not-a-knot at the upper end.
        (Ends::Onset, 3) => [&[0.0, 0.5 * nodes[0]], &nodes[..n - 2], &nodes[n - 1..]].concat(),
        (Ends::Onset, _) => [&[0.0], nodes].concat(),
        (Ends::Bounded, _) => nodes.to_vec(),
    }
}

/// From values at nodes to the coefficients of the spline through them.
pub struct Fit {
    /// Zero coefficients before the onset.
    pad: usize,
    /// Coefficients, those included and those that a period repeats.
    stored: usize,
    collocation: Banded,
}

impl Fit {
    /// Of the functions of `basis` through values at `nodes`; an axis that is not there has one value, its own coefficient.
    fn new<const N: usize>(basis: &Basis<N>, nodes: &[f64], name: &str) -> Result<Fit, TableError> {
        let n = nodes.len();
        let onset = basis.ends == Ends::Onset;
        let pad = if onset { N - 1 } else { 0 };
        let mut entries = Vec::with_capacity(n * N);
        for (i, &x) in nodes.iter().enumerate() {
            let w = basis.inside(x);
            for (k, value) in w.value.into_iter().enumerate().take(w.count) {
                // Functions before the onset have no coefficient.
                if let Some(j) = (w.first + k).checked_sub(pad) {
                    entries.push(((i, j % n), value));
                }
            }
        }
        let Some(collocation) = Banded::factored(n, &entries) else {
            let reason = "no spline passes through these nodes; space them more evenly";
            return refused(name, format!("{nodes:?}"), reason);
        };
        Ok(Fit {
            pad,
            stored: basis.stored(),
            collocation,
        })
    }

    /// Stored coefficients of the spline with `values` at the nodes.
    pub fn coefficients(&self, values: &[f64]) -> Vec<f64> {
        let found = self.collocation.solved(values);
        let repeated = found.iter().cycle().copied();
        let zeros = std::iter::repeat_n(0.0, self.pad);
        zeros.chain(repeated).take(self.stored).collect()
    }

    pub fn along(&self, axis: usize, block: &Block) -> Block {
        block.mapped(axis, self.stored, |line| self.coefficients(&line))
    }
}

/// Basis and fit of an axis with samples at `nodes`: degree N - 1; a single one has no extent, nothing depends on it.
pub fn axis<const N: usize>(
    nodes: &[f64],
    ends: Ends,
    name: &str,
) -> Result<(Basis<N>, Fit), TableError> {
    let basis = match nodes {
        [_] => Basis::new(&[], ends),
        _ => Basis::new(&breaks(nodes, N - 1, ends), ends),
    };
    let fit = Fit::new(&basis, nodes, name)?;
    Ok((basis, fit))
}

/// The coordinates but the displacement: bases of centre distance, misalignment and mesh position, and fits of values at
/// their nodes.
pub struct Others<const N: usize> {
    pub bases: [Basis<N>; 3],
    fits: [Fit; 3],
}

impl<const N: usize> Others<N> {
    /// On axes with `nodes` in the order of the samples.
    pub fn new([c, m, _, p]: [&[f64]; 4]) -> Result<Self, TableError> {
        let (c, along_c) = axis(c, Ends::Bounded, Axis::CenterDistance.name())?;
        let (m, along_m) = axis(m, Ends::Bounded, Axis::Misalignment.name())?;
        let (p, along_p) = axis(p, Ends::Periodic, Axis::MeshPosition.name())?;
        Ok(Others {
            bases: [c, m, p],
            fits: [along_c, along_m, along_p],
        })
    }

    /// Coefficients for the values of `block`, which has `third` along its third axis.
    pub fn fit(&self, block: &Block, third: Option<&Fit>) -> Block {
        let [c, m, p] = &self.fits;
        let mut fitted = m.along(1, &c.along(0, block));
        if let Some(third) = third {
            fitted = third.along(2, &fitted);
        }
        p.along(3, &fitted)
    }

    /// The axis that makes the spline through the values of `block` fall below zero: at its nodes, splined over the others alone, they
    /// do not, or least. The first one where that holds for several.
    pub fn falls_along(&self, block: &Block) -> Axis {
        let axes = [Axis::CenterDistance, Axis::Misalignment, Axis::MeshPosition];
        let without = |left_out: Axis| {
            let others = axes.into_iter().zip(&self.fits);
            let others = others.filter(|(axis, _)| *axis != left_out);
            let fitted = others.fold(block.clone(), |fitted, (axis, fit)| {
                fit.along(axis as usize, &fitted)
            });
            least(&fitted).min(0.0)
        };
        // Of equal ones the last is the largest.
        let there = axes.into_iter().zip(&self.bases).rev();
        let there = there.filter_map(|(axis, basis)| basis.present().then_some(axis));
        let highest = there.map(|axis| (without(axis), axis));
        let highest = highest.max_by(|a, b| a.0.total_cmp(&b.0));
        highest.map_or(Axis::MeshPosition, |(_, axis)| axis)
    }
}

/// The least value of `block`.
pub fn least(block: &Block) -> f64 {
    block.values.iter().copied().fold(f64::INFINITY, f64::min)
}

type Functional = Box<dyn Fn(&[f64]) -> f64>;

/// What takes samples at `nodes` to the value at 0, by the spline through them.
pub fn at_zero(nodes: &[f64], name: &str) -> Result<Functional, TableError> {
    if let Some(k) = nodes.iter().position(|&x| x == 0.0) {
        return Ok(Box::new(move |line| line[k]));
    }
    if !(nodes[0] < 0.0 && nodes[nodes.len() - 1] > 0.0) {
        let reason = "the nominal value 0 lies outside this axis, so its effect cannot be switched off; make tables whose range \
                      includes 0";
        return refused(name, format!("{nodes:?}"), reason);
    }
    let (basis, fit) = axis::<4>(nodes, Ends::Bounded, name)?;
    let w = basis.inside(0.0);
    Ok(Box::new(move |line| {
        w.sum(&w.value, &fit.coefficients(line))
    }))
}

/// A square matrix with entries near the diagonal, and near the corners next to it, after Gaussian elimination with
/// partial pivoting. Rows and columns stand in the order 0, n - 1, 1, n - 2, ..: so the corners come near the diagonal.
struct Banded {
    n: usize,
    /// Diagonals below the main one, and above it together with those that pivoting fills.
    below: usize,
    above: usize,
    /// Row by row from `below` before the diagonal on: factors of the elimination, then what it left.
    rows: Vec<f64>,
    pivots: Vec<usize>,
}

/// Where row or column `j` of `n` stands in a [`Banded`].
fn folded(n: usize, j: usize) -> usize {
    if 2 * j < n {
        2 * j
    } else {
        2 * (n - 1 - j) + 1
    }
}

impl Banded {
    /// The sum of `entries`; `None`: it is singular.
    fn factored(n: usize, entries: &[((usize, usize), f64)]) -> Option<Banded> {
        let places = || (entries.iter()).map(|&((i, j), w)| (folded(n, i), folded(n, j), w));
        let below = places().map(|(i, j, _)| i.saturating_sub(j)).max()?;
        let above = places().map(|(i, j, _)| j.saturating_sub(i)).max()? + below;
        let mut a = Banded {
            n,
            below,
            above,
            rows: vec![0.0; n * (below + above + 1)],
            pivots: Vec::with_capacity(n),
        };
        for (i, j, w) in places() {
            *a.at(i, j) += w;
        }
        for k in 0..n {
            let (rows, columns) = (k..n.min(k + below + 1), k..n.min(k + above + 1));
            let pivot = rows.clone().max_by(|&i, &j| {
                let [x, y] = [i, j].map(|i| a.at(i, k).abs());
                x.total_cmp(&y)
            })?;
            let divisor = *a.at(pivot, k);
            if divisor == 0.0 || !divisor.is_finite() {
                return None;
            }
            a.pivots.push(pivot);
            for j in columns.clone().filter(|_| pivot != k) {
                let upper = *a.at(k, j);
                *a.at(k, j) = std::mem::replace(a.at(pivot, j), upper);
            }
            for i in rows.skip(1) {
                *a.at(i, k) /= divisor;
                let factor = *a.at(i, k);
                for j in columns.clone().skip(1) {
                    let above = *a.at(k, j);
                    *a.at(i, j) -= factor * above;
                }
            }
        }
        Some(a)
    }

    fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.rows[i * (self.below + self.above) + self.below + j]
    }

    fn solved(&self, b: &[f64]) -> Vec<f64> {
        let (n, width) = (self.n, self.below + self.above);
        let row = |i: usize, columns: std::ops::Range<usize>| {
            let begin = i * width + self.below;
            &self.rows[begin + columns.start..begin + columns.end]
        };
        let mut x = vec![0.0; n];
        for (j, b) in b.iter().enumerate() {
            x[folded(n, j)] = *b;
        }
        for k in 0..n {
            x.swap(k, self.pivots[k]);
            for i in k + 1..n.min(k + self.below + 1) {
                x[i] -= row(i, k..k + 1)[0] * x[k];
            }
        }
        for k in (0..n).rev() {
            let columns = k..n.min(k + self.above + 1);
            let [diagonal, after @ ..] = row(k, columns) else {
                continue;
            };
            let known: f64 = after.iter().zip(&x[k + 1..]).map(|(a, x)| a * x).sum();
            x[k] = (x[k] - known) / diagonal;
        }
        (0..n).map(|j| x[folded(n, j)]).collect()
    }
}

/// Makes `line` increase, from zero on, with the least change in the mean square: pool adjacent violators (Barlow et al.,
/// Statistical Inference under Order Restrictions, 1972).
pub fn make_increasing(line: &mut [f64]) {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(line.len());
    for v in line.iter() {
        pools.push((*v, 1));
        while let [.., (a, n), (b, m)] = pools[..] {
            if a <= b {
                break;
            }
            pools.pop();
            let last = pools.len() - 1;
            pools[last] = ((a * n as f64 + b * m as f64) / (n + m) as f64, n + m);
        }
    }
    let pooled = pools.iter().flat_map(|&(v, n)| std::iter::repeat_n(v, n));
    for (v, pooled) in line.iter_mut().zip(pooled) {
        *v = pooled.max(0.0);
    }
}

/// Coefficients of the integral over the displacement of splines of degree `degree` (de Boor, X (33)): running
/// sums of c_j (t_(j + degree + 1) - t_j) / (degree + 1). `line` holds the stored coefficients of
/// an onset basis, with `degree` zeros before the onset; the result has one more.
pub fn integrated(line: &[f64], breaks: &[f64], degree: usize) -> Vec<f64> {
    let last = breaks.len() - 1;
    let mut out = vec![0.0; degree + 1];
    let mut sum = 0.0;
    for (j, c) in line[degree..].iter().enumerate() {
        sum += c * (breaks[(j + degree + 1).min(last)] - breaks[j]) / (degree + 1) as f64;
        out.push(sum);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn pooling_leaves_monotone_lines_alone_and_mends_the_others() {
        for (given, expected) in [
            ([0.0, 1.0, 1.0, 3.0], [0.0, 1.0, 1.0, 3.0]),
            ([-1.0, 2.0, 1.0, 3.0], [0.0, 1.5, 1.5, 3.0]),
        ] {
            let mut line = given;
            make_increasing(&mut line);
            assert_eq!(line, expected);
        }
    }

    /// Nodes in [0, 1), at most three times as far apart here as there.
    fn uneven(n: usize) -> Vec<f64> {
        let mut random = crate::random::Random::new(n as u64);
        let steps: Vec<f64> = (0..n).map(|_| random.within([0.5, 1.5])).collect();
        let sum: f64 = steps.iter().sum();
        let nodes = steps.iter().scan(0.0, |at, s| {
            *at += s / sum;
            Some(*at - s / sum)
        });
        nodes.collect()
    }

    /// As many nodes as the checks of tables admit, too; a dense matrix would have 1e8 entries.
    #[test]
    fn the_spline_passes_through_its_nodes_and_ten_thousand_are_fitted_at_once() {
        let before = std::time::Instant::now();
        for n in (5..40).chain([10_000]) {
            for ends in [Ends::Bounded, Ends::Onset, Ends::Periodic] {
                let mut nodes = uneven(n);
                if ends == Ends::Onset {
                    nodes.iter_mut().for_each(|x| *x += 0.5 / n as f64);
                }
                let values: Vec<f64> = nodes.iter().map(|x| (7.0 * x).sin()).collect();
                let (basis, fit) = axis::<4>(&nodes, ends, "x").unwrap();
                let found = fit.coefficients(&values);
                for (x, y) in nodes.iter().zip(&values) {
                    let w = basis.inside(*x);
                    assert_abs_diff_eq!(w.sum(&w.value, &found), *y, epsilon = 1e-13);
                }
            }
        }
        assert!(before.elapsed().as_secs_f64() < 1.0);
    }
}
