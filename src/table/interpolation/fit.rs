//! From values at the nodes of a grid to the coefficients of tensor B-splines.

use super::basis::{Basis, Ends, Weights};
use crate::table::TableError;
use nalgebra::DMatrix;

/// A dense array over (centre distance, misalignment, displacement, mesh position), the last index fastest.
#[derive(Debug, Clone)]
pub struct Block {
    /// Lengths in that order.
    pub lengths: [usize; 4],
    /// Values.
    pub values: Vec<f64>,
}

impl Block {
    /// All zero.
    pub fn zeros(lengths: [usize; 4]) -> Self {
        Block {
            lengths,
            values: vec![0.0; lengths.iter().product()],
        }
    }

    /// Distance in memory from one index of `axis` to the next.
    pub fn stride(&self, axis: usize) -> usize {
        self.lengths[axis + 1..].iter().product()
    }

    /// Start of every line along `axis`.
    pub fn lines(&self, axis: usize) -> impl Iterator<Item = usize> + use<> {
        let (n, stride) = (self.lengths[axis], self.stride(axis));
        (0..self.values.len() / (n * stride))
            .flat_map(move |outer| (0..stride).map(move |inner| outer * n * stride + inner))
    }

    /// The block with `matrix` (rows: new length) applied along `axis`.
    pub fn transformed(&self, axis: usize, matrix: &DMatrix<f64>) -> Block {
        let mut lengths = self.lengths;
        lengths[axis] = matrix.nrows();
        let mut out = Block::zeros(lengths);
        let stride = self.stride(axis);
        for (from, to) in self.lines(axis).zip(out.lines(axis)) {
            for (i, row) in matrix.row_iter().enumerate() {
                out.values[to + i * stride] = row
                    .iter()
                    .enumerate()
                    .map(|(j, m)| m * self.values[from + j * stride])
                    .sum();
            }
        }
        out
    }
}

/// Ends of the cells of an interpolant of degree `degree` whose data sit at `nodes` (periodic: over
/// [0, 1), period 1; onset: without the zero at 0), so that there are as many functions as nodes.
pub fn breaks(nodes: &[f64], degree: usize, ends: Ends) -> Vec<f64> {
    let n = nodes.len();
    match (ends, degree) {
        (Ends::Periodic, _) => {
            let mut b = nodes.to_vec();
            b.push(nodes[0] + 1.0);
            b
        }
        // Not-a-knot: no cell ends at the second and the last but one node.
        (Ends::Bounded, 3) => {
            let mut b = vec![nodes[0]];
            b.extend_from_slice(&nodes[2..n - 2]);
            b.push(nodes[n - 1]);
            b
        }
        // Value, slope and curvature vanish at 0: one more cell before the first node, and
        // not-a-knot at the upper end.
        (Ends::Onset, 3) => {
            let mut b = vec![0.0, 0.5 * nodes[0]];
            b.extend_from_slice(&nodes[..n - 2]);
            b.push(nodes[n - 1]);
            b
        }
        (Ends::Onset, _) => {
            let mut b = vec![0.0];
            b.extend_from_slice(nodes);
            b
        }
        (Ends::Bounded, _) => nodes.to_vec(),
    }
}

/// Coefficients from values at `nodes`: the inverse of the collocation matrix, with the repeated
/// (periodic) or zero (onset) coefficients appended or put before.
pub fn stored_from_values<const N: usize>(
    basis: &Basis<N>,
    nodes: &[f64],
    ends: Ends,
    name: &str,
) -> Result<DMatrix<f64>, TableError> {
    if !basis.present() {
        return Ok(DMatrix::identity(1, 1));
    }
    let n = nodes.len();
    let pad = if ends == Ends::Onset { N - 1 } else { 0 };
    let mut collocation = DMatrix::zeros(n, n);
    for (i, &x) in nodes.iter().enumerate() {
        let Weights { first, value, .. } = basis.inside(x);
        for (k, w) in value.iter().enumerate() {
            // Functions before the onset have no coefficient.
            if let Some(j) = (first + k).checked_sub(pad) {
                collocation[(i, j % n)] += w;
            }
        }
    }
    let inverse = collocation.try_inverse().ok_or_else(|| {
        TableError::field(
            name,
            format!("{nodes:?}"),
            "no spline passes through these nodes",
            "space them more evenly",
        )
    })?;
    let mut stored = DMatrix::zeros(basis.stored(), n);
    for row in pad..basis.stored() {
        stored.row_mut(row).copy_from(&inverse.row((row - pad) % n));
    }
    Ok(stored)
}

/// Makes `line` non-negative and non-decreasing with the least change in the mean square: pool
/// adjacent violators (Barlow et al., Statistical Inference under Order Restrictions, 1972).
/// Returns the largest change.
pub fn make_monotone(line: &mut [f64]) -> f64 {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(line.len());
    for &v in line.iter() {
        pools.push((v, 1));
        while let [.., (a, n), (b, m)] = pools[..] {
            if a <= b {
                break;
            }
            pools.pop();
            let last = pools.len() - 1;
            pools[last] = ((a * n as f64 + b * m as f64) / (n + m) as f64, n + m);
        }
    }
    let mut change: f64 = 0.0;
    let pooled = pools.iter().flat_map(|&(v, n)| std::iter::repeat_n(v, n));
    for (v, p) in line.iter_mut().zip(pooled) {
        change = change.max((p.max(0.0) - *v).abs());
        *v = p.max(0.0);
    }
    change
}

/// As [`make_monotone`] with increments, the first one from zero, of at least `least`.
pub fn make_increasing(line: &mut [f64], least: &[f64]) -> f64 {
    let before = line.to_vec();
    let mut ramp = 0.0;
    for (v, step) in line.iter_mut().zip(least) {
        ramp += step;
        *v -= ramp;
    }
    make_monotone(line);
    ramp = 0.0;
    let mut change: f64 = 0.0;
    for ((v, step), before) in line.iter_mut().zip(least).zip(before) {
        ramp += step;
        *v += ramp;
        change = change.max((*v - before).abs());
    }
    change
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
        let mut line = [0.0, 1.0, 1.0, 3.0];
        assert_eq!(make_monotone(&mut line), 0.0);
        let mut line = [-1.0, 2.0, 1.0, 3.0];
        assert_eq!(make_monotone(&mut line), 1.0);
        assert_eq!(line, [0.0, 1.5, 1.5, 3.0]);
    }

    #[test]
    fn increments_are_no_smaller_than_asked() {
        let mut line = [1.0, 2.0, 3.0];
        assert_eq!(make_increasing(&mut line, &[0.5; 3]), 0.0);
        let mut line = [-1.0, 2.0, 2.0, 2.5];
        assert_eq!(make_increasing(&mut line, &[0.25; 4]), 1.25);
        assert_eq!(line, [0.25, 1.875, 2.125, 2.5]);
    }

    #[test]
    fn onset_spline_reproduces_a_cubic_and_its_integral() {
        let nodes = [0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0];
        let b = breaks(&nodes, 3, Ends::Onset);
        let force = Basis::<4>::new(&b, Ends::Onset);
        let matrix = stored_from_values(&force, &nodes, Ends::Onset, "u").unwrap();
        let data = nalgebra::DVector::from_iterator(7, nodes.iter().map(|x| x * x * x));
        let coefficients: Vec<f64> = (matrix * data).iter().copied().collect();
        let potential = Basis::<5>::new(&b, Ends::Onset);
        let integral = integrated(&coefficients, &b, 3);
        assert_eq!(integral.len(), potential.stored());
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let w = potential.inside(x);
            let dot = |a: &[f64; 5]| -> f64 { (0..5).map(|k| a[k] * integral[w.first + k]).sum() };
            assert_abs_diff_eq!(dot(&w.value), x.powi(4) / 4.0, epsilon = 1e-13);
            assert_abs_diff_eq!(dot(&w.slope), x.powi(3), epsilon = 1e-12);
            assert_abs_diff_eq!(dot(&w.curvature), 3.0 * x * x, epsilon = 1e-10);
        }
    }
}
