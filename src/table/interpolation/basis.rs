//! B-splines of one coordinate, cell by cell as polynomials, so that uneven axes cost no divisions.
//!
//! de Boor, A Practical Guide to Splines (revised edition, 2001), chapters IX and X.

use super::kernel::add;
use nalgebra::DMatrix;

/// `N` neighbouring basis functions at one point: values and derivatives by the coordinate.
#[derive(Debug, Clone, Copy)]
pub struct Weights<const N: usize> {
    /// Stored index of the first of them.
    pub first: usize,
    /// Values.
    pub value: [f64; N],
    /// First derivatives.
    pub slope: [f64; N],
    /// Second derivatives.
    pub curvature: [f64; N],
    /// Third derivatives.
    pub third: [f64; N],
}

impl<const N: usize> Weights<N> {
    /// Weights of an axis that is not there: one function that is 1 everywhere.
    const fn constant() -> Self {
        let mut value = [0.0; N];
        value[0] = 1.0;
        Weights {
            first: 0,
            value,
            slope: [0.0; N],
            curvature: [0.0; N],
            third: [0.0; N],
        }
    }
}

/// How a coordinate goes on at its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// From the last point on to the first.
    Periodic,
    /// Linear beyond both ends.
    Bounded,
    /// Zero with all derivatives but the highest at the lower end; quadratic beyond the upper one.
    Onset,
}

/// B-splines of degree N - 1 over one axis; `N` = 1: the axis has a single point and no extent.
#[derive(Debug, Clone)]
pub struct Basis<const N: usize> {
    ends: Ends,
    /// Ends of the cells, ascending.
    breaks: Vec<f64>,
    /// 1 / length of each cell.
    inverse: Vec<f64>,
    /// Per cell: coefficients of the local coordinate in [0, 1], `[power][function]`.
    cells: Vec<[[f64; N]; N]>,
    /// First cell to try, by equal buckets over the range.
    buckets: Vec<u32>,
    bucket_scale: f64,
    /// How far the continuation beyond the lower and the upper end of a bounded axis stays linear, in units of
    /// the coordinate.
    pub(crate) guard: [f64; 2],
}

impl<const N: usize> Basis<N> {
    /// From cell ends `breaks` (ascending; periodic: the first one repeated a period later).
    pub fn new(breaks: &[f64], ends: Ends) -> Self {
        if N == 1 {
            return Self::absent();
        }
        let degree = N - 1;
        let n = breaks.len() - 1;
        let range = breaks[n] - breaks[0];
        // `degree` knots before the first cell and after the last one.
        let mut knots = Vec::with_capacity(n + 1 + 2 * degree);
        for k in (1..=degree).rev() {
            knots.push(match ends {
                Ends::Periodic => breaks[(n * degree - k) % n] - range * (k.div_ceil(n) as f64),
                Ends::Bounded => breaks[0],
                // Functions that begin here have no coefficient: any knots do.
                Ends::Onset => breaks[0] - k as f64 * (breaks[1] - breaks[0]),
            });
        }
        knots.extend_from_slice(breaks);
        for k in 1..=degree {
            knots.push(match ends {
                Ends::Periodic => breaks[k % n] + range * (1 + k / n) as f64,
                Ends::Bounded | Ends::Onset => breaks[n],
            });
        }
        let cells = (0..n).map(|i| polynomials(&knots, i + degree)).collect();
        let smallest = breaks
            .windows(2)
            .map(|w| w[1] - w[0])
            .fold(f64::INFINITY, f64::min);
        let count = (range / smallest * (1.0 + 1e-12)).ceil() as usize;
        let buckets = (0..count)
            .map(|b| {
                let x = breaks[0] + range * b as f64 / count as f64;
                (breaks.partition_point(|&k| k <= x).max(1) - 1).min(n - 1) as u32
            })
            .collect();
        Basis {
            ends,
            breaks: breaks.to_vec(),
            inverse: breaks.windows(2).map(|w| 1.0 / (w[1] - w[0])).collect(),
            cells,
            buckets,
            bucket_scale: count as f64 / range,
            guard: [0.25 * range; 2],
        }
    }

    fn absent() -> Self {
        Basis {
            ends: Ends::Bounded,
            breaks: vec![],
            inverse: vec![],
            cells: vec![],
            buckets: vec![],
            bucket_scale: 0.0,
            guard: [0.0; 2],
        }
    }

    /// Coefficients kept in memory: those of the fit, and N - 1 more of a periodic axis (the first
    /// ones again) or of an onset (zeros before it).
    pub fn stored(&self) -> usize {
        if N == 1 { 1 } else { self.cells.len() + N - 1 }
    }

    #[inline(always)]
    fn cell(&self, x: f64) -> usize {
        // `as` takes NaN and what lies below to 0, what lies above is cut by min.
        let bucket = ((x - self.breaks[0]) * self.bucket_scale) as u32 as usize;
        let i = self.buckets[bucket.min(self.buckets.len() - 1)] as usize;
        // A bucket is no longer than the shortest cell, so at most one cell ends in it. (A rounding at
        // its edge may take the neighbour's polynomials, which agree there.)
        let last = self.cells.len() - 1;
        i + usize::from(i < last && x >= self.breaks[i + 1])
    }

    /// Polynomials of the functions on each cell, `[power][function]`.
    pub fn cells(&self) -> &[[[f64; N]; N]] {
        &self.cells
    }

    /// Cell of `x` (the end cell beyond the range), local coordinate in it, 1 / its length.
    #[inline(always)]
    pub fn local(&self, x: f64) -> (usize, f64, f64) {
        let i = self.cell(x);
        let scale = self.inverse[i];
        (i, (x - self.breaks[i]) * scale, scale)
    }

    /// Weights inside the range, the end cell's polynomials beyond it.
    #[inline(always)]
    pub fn inside(&self, x: f64) -> Weights<N> {
        if N == 1 {
            return Weights::constant();
        }
        let (i, t, scale) = self.local(x);
        let p = &self.cells[i];
        let mut powers = [1.0; N];
        for k in 1..N {
            powers[k] = powers[k - 1] * t;
        }
        let mut w = Weights {
            first: i,
            value: p[0],
            slope: [0.0; N],
            curvature: [0.0; N],
            third: [0.0; N],
        };
        for k in 1..N {
            let (a, b, c) = (
                k as f64,
                (k * (k - 1)) as f64,
                (k * (k - 1) * (k.max(2) - 2)) as f64,
            );
            add(&mut w.value, powers[k], &p[k]);
            add(&mut w.slope, a * scale * powers[k - 1], &p[k]);
            if k >= 2 {
                add(&mut w.curvature, b * scale * scale * powers[k - 2], &p[k]);
            }
            if k >= 3 {
                add(
                    &mut w.third,
                    c * scale * scale * scale * powers[k - 3],
                    &p[k],
                );
            }
        }
        w
    }

    /// Weights at `x`, wrapped, or continued linearly from the nearer end, and whether `x` is outside.
    #[inline(always)]
    pub fn weights(&self, x: f64) -> (Weights<N>, bool) {
        if N == 1 {
            return (Weights::constant(), false);
        }
        match self.ends {
            Ends::Periodic => {
                let (low, high) = (self.breaks[0], self.breaks[self.breaks.len() - 1]);
                // Wrapped already, as a rule: `floor` is a call on baseline x86-64.
                let turns = if x >= low && x < high {
                    0.0
                } else {
                    ((x - low) / (high - low)).floor()
                };
                (self.inside(x - turns * (high - low)), false)
            }
            Ends::Bounded | Ends::Onset => {
                let edge = x.clamp(self.breaks[0], self.breaks[self.breaks.len() - 1]);
                let mut w = self.inside(edge);
                let outside = x != edge;
                if outside {
                    self.go_beyond(&mut w, x - edge);
                }
                (w, outside)
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn go_beyond(&self, w: &mut Weights<N>, d: f64) {
        if self.ends == Ends::Onset {
            // The potential goes on quadratically, so the force goes on linearly.
            for k in 0..N {
                w.value[k] += d * (w.slope[k] + 0.5 * d * w.curvature[k]);
                w.slope[k] += d * w.curvature[k];
                w.third[k] = 0.0;
            }
            return;
        }
        let (g, g1, g2) = levelled(d, self.guard[usize::from(d > 0.0)]);
        for k in 0..N {
            w.value[k] += g * w.slope[k];
            w.curvature[k] = g2 * w.slope[k];
            w.slope[k] *= g1;
        }
    }

    /// Row that takes coefficients to where the continuation beyond the lower (0) or upper (1) `end` of a
    /// bounded axis has levelled out.
    pub fn far_end(&self, end: usize) -> DMatrix<f64> {
        let (edge, sign) = [
            (self.breaks[0], -1.0),
            (self.breaks[self.breaks.len() - 1], 1.0),
        ][end];
        let w = self.inside(edge);
        let mut row = DMatrix::zeros(1, self.stored());
        for k in 0..N {
            row[(0, w.first + k)] = w.value[k] + sign * 2.0 * self.guard[end] * w.slope[k];
        }
        row
    }

    /// Weights continued linearly however far outside `x` is (bounded axes).
    pub fn linear(&self, x: f64) -> Weights<N> {
        if N == 1 || self.ends != Ends::Bounded {
            return self.weights(x).0;
        }
        let edge = x.clamp(self.breaks[0], self.breaks[self.breaks.len() - 1]);
        let mut w = self.inside(edge);
        if x != edge {
            for k in 0..N {
                w.value[k] += (x - edge) * w.slope[k];
                w.curvature[k] = 0.0;
            }
        }
        w
    }
}

/// The way `d` beyond an end as the continuation takes it, and its two derivatives: `d` itself up
/// to the guard distance, then a parabola into a constant two guards out. Stiffness and force thus
/// continue linearly, but never through zero (see `continuation::limit`).
fn levelled(d: f64, guard: f64) -> (f64, f64, f64) {
    let over = d.abs() - guard;
    if over <= 0.0 {
        (d, 1.0, 0.0)
    } else if over < 2.0 * guard {
        let g = d.abs() - over * over / (4.0 * guard);
        (
            g * d.signum(),
            1.0 - over / (2.0 * guard),
            -d.signum() / (2.0 * guard),
        )
    } else {
        (2.0 * guard * d.signum(), 0.0, 0.0)
    }
}

/// The N functions that live on the cell from `knots[m]` to `knots[m + 1]` as polynomials of the
/// local coordinate, by the recurrence of Cox and de Boor.
fn polynomials<const N: usize>(knots: &[f64], m: usize) -> [[f64; N]; N] {
    let degree = N - 1;
    let (start, length) = (knots[m], knots[m + 1] - knots[m]);
    // functions[j] is B_(m - degree + j) of the current degree, powers ascending.
    let mut functions = [[0.0; N]; N];
    functions[degree][0] = 1.0;
    for k in 1..=degree {
        let mut next = [[0.0; N]; N];
        for j in degree - k..=degree {
            let i = m - degree + j;
            let rising = (functions[j], knots.get(i + k).map_or(0.0, |e| e - knots[i]));
            if j > degree - k && rising.1 > 0.0 {
                // (x - t_i) / (t_(i+k) - t_i)
                let (a, b) = ((start - knots[i]) / rising.1, length / rising.1);
                for p in 0..N {
                    next[j][p] += a * rising.0[p];
                    if p > 0 {
                        next[j][p] += b * rising.0[p - 1];
                    }
                }
            }
            if j < degree {
                let width = knots[i + k + 1] - knots[i + 1];
                if width > 0.0 {
                    // (t_(i+k+1) - x) / (t_(i+k+1) - t_(i+1))
                    let (a, b) = ((knots[i + k + 1] - start) / width, -length / width);
                    for p in 0..N {
                        next[j][p] += a * functions[j + 1][p];
                        if p > 0 {
                            next[j][p] += b * functions[j + 1][p - 1];
                        }
                    }
                }
            }
        }
        functions = next;
    }
    let mut by_power = [[0.0; N]; N];
    for (j, function) in functions.iter().enumerate() {
        for (p, &a) in function.iter().enumerate() {
            by_power[p][j] = a;
        }
    }
    by_power
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const UNEVEN: [f64; 6] = [-1.0, -0.2, 0.0, 0.5, 1.5, 2.0];

    #[test]
    fn functions_add_up_to_one_with_vanishing_derivatives() {
        for ends in [Ends::Bounded, Ends::Periodic] {
            let basis = Basis::<4>::new(&UNEVEN, ends);
            for i in 0..=300 {
                let (w, _) = basis.weights(-1.0 + 3.0 * f64::from(i) / 300.0);
                assert_abs_diff_eq!(w.value.iter().sum::<f64>(), 1.0, epsilon = 1e-14);
                assert_abs_diff_eq!(w.slope.iter().sum::<f64>(), 0.0, epsilon = 1e-12);
                assert_abs_diff_eq!(w.curvature.iter().sum::<f64>(), 0.0, epsilon = 1e-11);
                assert!(w.value.iter().all(|&v| v >= -1e-15));
            }
        }
    }

    #[test]
    fn each_function_is_twice_continuously_differentiable() {
        for ends in [Ends::Bounded, Ends::Periodic, Ends::Onset] {
            let basis = Basis::<4>::new(&UNEVEN, ends);
            for &x in &UNEVEN[1..5] {
                let (left, right) = (basis.inside(x - 1e-9), basis.inside(x + 1e-9));
                assert_eq!(left.first + 1, right.first);
                for k in 1..4 {
                    assert_abs_diff_eq!(left.value[k], right.value[k - 1], epsilon = 1e-7);
                    assert_abs_diff_eq!(left.slope[k], right.slope[k - 1], epsilon = 1e-6);
                    assert_abs_diff_eq!(left.curvature[k], right.curvature[k - 1], epsilon = 1e-5);
                }
            }
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences_inside_and_beyond() {
        let basis = Basis::<5>::new(&UNEVEN, Ends::Bounded);
        for x in [-2.9, -1.4, -0.7, -0.1, 0.3, 1.7, 2.4, 3.9, 9.0] {
            let h = 1e-6;
            let (w, _) = basis.weights(x);
            let (a, b) = (basis.weights(x - h).0, basis.weights(x + h).0);
            for k in 0..5 {
                assert_abs_diff_eq!(
                    w.slope[k],
                    (b.value[k] - a.value[k]) / (2.0 * h),
                    epsilon = 1e-7
                );
                assert_abs_diff_eq!(
                    w.curvature[k],
                    (b.slope[k] - a.slope[k]) / (2.0 * h),
                    epsilon = 1e-6
                );
            }
        }
    }
}
