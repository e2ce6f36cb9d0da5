//! B-splines of one coordinate, cell by cell as polynomials, so that uneven axes cost no divisions.
//!
//! de Boor, A Practical Guide to Splines (revised edition, 2001), chapters IX and X.

use crate::accuracy::is_beyond;
use crate::vector::Lanes;

/// `N` neighbouring basis functions at one point: values, first and second derivatives by the coordinate.
#[derive(Debug, Clone, Copy)]
pub struct Weights<const N: usize> {
    /// Stored index of the first of them.
    pub first: usize,
    /// How many of them there are: N, or 1 on an axis that is not there.
    pub count: usize,
    pub value: [f64; N],
    pub slope: [f64; N],
    pub curvature: [f64; N],
}

impl<const N: usize> Weights<N> {
    pub const fn constant() -> Self {
        let mut value = [0.0; N];
        value[0] = 1.0;
        Weights {
            first: 0,
            count: 1,
            value,
            slope: [0.0; N],
            curvature: [0.0; N],
        }
    }

    /// `weights`, values or derivatives, of the stored `coefficients`.
    pub fn sum(&self, weights: &[f64; N], coefficients: &[f64]) -> f64 {
        let stored = &coefficients[self.first..self.first + self.count];
        weights.iter().zip(stored).map(|(w, c)| w * c).sum()
    }
}

/// How a coordinate goes on at its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ends {
    /// From the last point on to the first.
    Periodic,
    /// Linear beyond both ends.
    #[default]
    Bounded,
    /// Zero with all derivatives but the highest at the lower end; quadratic beyond the upper one.
    Onset,
}

#[derive(Debug, Clone)]
struct Cell<const N: usize> {
    start: f64,
    end: f64,
    scale: f64,
    /// The functions as polynomials of the local coordinate in [0, 1], `[power][function]`.
    polynomials: [[f64; N]; N],
}

/// B-splines of degree N - 1 over one axis. Without cells the axis has a single point and no extent: one function that is
/// 1 everywhere.
#[derive(Debug, Clone, Default)]
pub struct Basis<const N: usize> {
    pub ends: Ends,
    low: f64,
    high: f64,
    cells: Vec<Cell<N>>,
    /// First cell to try, by equal buckets over the range.
    buckets: Vec<u32>,
    bucket_scale: f64,
    /// How far beyond the lower and the upper end of a bounded axis the continuation has levelled out, in units of the coordinate.
    pub(crate) levelling_length: [f64; 2],
}

impl<const N: usize> Basis<N> {
    /// From cell ends `breaks` (ascending; periodic: the first one repeated a period later; none: no extent).
    pub fn new(breaks: &[f64], ends: Ends) -> Self {
        if breaks.is_empty() {
            return Basis::default();
        }
        let degree = N - 1;
        let n = breaks.len() - 1;
        let range = breaks[n] - breaks[0];
        // `degree` knots before the first cell and after the last one.
        let before = (1..=degree).rev().map(|k| match ends {
            Ends::Periodic => breaks[(n * degree - k) % n] - range * (k.div_ceil(n) as f64),
            Ends::Bounded => breaks[0],
            // Functions that begin here have no coefficient: any knots do.
            Ends::Onset => breaks[0] - k as f64 * (breaks[1] - breaks[0]),
        });
        let after = (1..=degree).map(|k| match ends {
            Ends::Periodic => breaks[k % n] + range * (1 + k / n) as f64,
            Ends::Bounded | Ends::Onset => breaks[n],
        });
        let knots: Vec<f64> = before.chain(breaks.iter().copied()).chain(after).collect();
        let cells = (0..n)
            .map(|i| Cell {
                start: breaks[i],
                end: breaks[i + 1],
                scale: 1.0 / (breaks[i + 1] - breaks[i]),
                polynomials: polynomials(&knots, i + degree),
            })
            .collect();
        let lengths = breaks.windows(2).map(|w| w[1] - w[0]);
        let smallest = lengths.fold(f64::INFINITY, f64::min);
        let count = (range / smallest * (1.0 + 1e-12)).ceil() as usize;
        let buckets = (0..count)
            .map(|b| {
                let x = breaks[0] + range * b as f64 / count as f64;
                (breaks.partition_point(|&k| k <= x).max(1) - 1).min(n - 1) as u32
            })
            .collect();
        Basis {
            ends,
            low: breaks[0],
            high: breaks[n],
            cells,
            buckets,
            bucket_scale: count as f64 / range,
            levelling_length: [range; 2],
        }
    }

    /// Coefficients kept in memory: those of the fit, and N - 1 more of a periodic axis (the first ones again) or of an
    /// onset (zeros before it).
    pub fn stored(&self) -> usize {
        match self.present() {
            true => self.cells.len() + N - 1,
            false => 1,
        }
    }

    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Index of the cell of `x` (the end cell beyond the range) and the cell.
    #[inline(always)]
    fn cell(&self, x: f64) -> (usize, &Cell<N>) {
        // `as` takes NaN and what lies below to 0; what lies above has no bucket.
        let bucket = ((x - self.low) * self.bucket_scale) as u32 as usize;
        let last = self.cells.len() - 1;
        let i = self.buckets.get(bucket).map_or(last, |&i| i as usize);
        // A bucket is no longer than the shortest cell, so at most one cell ends in it. (A rounding at
        // its edge may take the neighbour's polynomials, which agree there.)
        let i = i + usize::from(i < last && x >= self.cells[i].end);
        (i, &self.cells[i])
    }

    /// Whether `x` lies inside the range, its upper end left out, or there is no range to leave.
    #[inline(always)]
    pub fn holds(&self, x: f64) -> bool {
        !self.present() || (x >= self.low && x < self.high)
    }

    /// Weights inside the range, the end cell's polynomials beyond it. Derivatives up to the `order`th, zero above.
    #[inline(always)]
    fn inside_of(&self, lanes: Lanes, x: f64, order: usize) -> Weights<N> {
        if !self.present() {
            return Weights::constant();
        }
        let (first, cell) = self.cell(x);
        let t = (x - cell.start) * cell.scale;
        // Horner's scheme for the polynomials and, k! times too small, their derivatives.
        let mut horner = [[0.0; N]; 3];
        horner[0] = cell.polynomials[N - 1];
        for k in (0..N - 1).rev() {
            for d in (1..=order).rev() {
                let known = N - 1 - k;
                if d < known {
                    let mut next = horner[d - 1];
                    lanes.add(&mut next, t, &horner[d]);
                    horner[d] = next;
                } else if d == known {
                    horner[d] = horner[d - 1];
                }
            }
            let mut next = cell.polynomials[k];
            lanes.add(&mut next, t, &horner[0]);
            horner[0] = next;
        }
        let s = cell.scale;
        let mut w = Weights {
            first,
            count: N,
            value: horner[0],
            slope: [0.0; N],
            curvature: [0.0; N],
        };
        if order >= 1 {
            w.slope = lanes.scaled(s, &horner[1]);
        }
        if order >= 2 {
            w.curvature = lanes.scaled(2.0 * s * s, &horner[2]);
        }
        w
    }

    pub fn inside(&self, x: f64) -> Weights<N> {
        self.inside_of(Lanes::COMMON, x, 2)
    }

    /// Weights at `x` with derivatives up to the `order`th (zero above), wrapped, or continued linearly from the
    /// nearer end, and whether `x` is outside.
    #[inline(always)]
    pub fn weights(&self, lanes: Lanes, x: f64, order: usize) -> (Weights<N>, bool) {
        if !self.present() {
            return (Weights::constant(), false);
        }
        if self.holds(x) {
            (self.inside_of(lanes, x, order), false)
        } else if self.ends == Ends::Periodic {
            (self.inside_of(lanes, self.wrapped(x), order), false)
        } else {
            let outside = is_beyond([self.low, self.high], x);
            (self.beyond(x, self.levelling_length), outside)
        }
    }

    /// `x` brought into the range by whole periods. Wrapped already, as a rule.
    #[cold]
    #[inline(never)]
    fn wrapped(&self, x: f64) -> f64 {
        let period = self.high - self.low;
        x - ((x - self.low) / period).floor() * period
    }

    /// Weights at the ends and outside, levelled out at `levelling_length` beyond the lower and the upper end.
    #[cold]
    #[inline(never)]
    fn beyond(&self, x: f64, levelling_length: [f64; 2]) -> Weights<N> {
        let edge = x.clamp(self.low, self.high);
        let d = x - edge;
        let mut w = self.inside(edge);
        if d == 0.0 {
            return w;
        }
        if self.ends == Ends::Onset {
            // The potential goes on quadratically, so the force goes on linearly.
            for k in 0..N {
                w.value[k] += d * (w.slope[k] + 0.5 * d * w.curvature[k]);
                w.slope[k] += d * w.curvature[k];
            }
            return w;
        }
        let [g, g1, g2] = levelled(d, levelling_length[usize::from(d > 0.0)]);
        for k in 0..N {
            w.value[k] += g * w.slope[k];
            w.curvature[k] = g2 * w.slope[k];
            w.slope[k] *= g1;
        }
        w
    }

    /// Length of the range.
    pub fn range(&self) -> f64 {
        self.high - self.low
    }

    /// Slope outwards at the lower (0) or upper (1) `end` of a bounded axis that is there, over what the last coefficient is larger
    /// than its neighbour: these two alone make it (de Boor, X).
    pub fn steepness(&self, end: usize) -> f64 {
        let cell = [self.cells.first(), self.cells.last()][end];
        cell.map_or(0.0, |cell| (N - 1) as f64 * cell.scale)
    }

    /// Weights continued `levelling_length` far outside (bounded axes).
    #[cold]
    #[inline(never)]
    pub fn levelling_within(&self, x: f64, levelling_length: [f64; 2]) -> Weights<N> {
        match self.ends {
            Ends::Bounded if self.present() => self.beyond(x, levelling_length),
            _ => self.weights(Lanes::COMMON, x, 2).0,
        }
    }
}

/// The way `d` beyond an end as the continuation takes it, and its two derivatives: its slope falls evenly from one to zero at
/// `levelling_length`, where it stays half of that. Without a limit it is `d` itself.
fn levelled(d: f64, levelling_length: f64) -> [f64; 3] {
    let (part, sign) = (d.abs() / levelling_length, d.signum());
    if part >= 1.0 {
        return [0.5 * levelling_length * sign, 0.0, 0.0];
    }
    [d * (1.0 - 0.5 * part), 1.0 - part, -sign / levelling_length]
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
            let mut add = |function: &[f64; N], zero: f64, one: f64| {
                if one == zero {
                    return;
                }
                let (a, b) = ((start - zero) / (one - zero), length / (one - zero));
                for p in 0..N {
                    next[j][p] += a * function[p];
                    if p > 0 {
                        next[j][p] += b * function[p - 1];
                    }
                }
            };
            if j > degree - k {
                add(&functions[j], knots[i], knots[i + k]);
            }
            if j < degree {
                add(&functions[j + 1], knots[i + k + 1], knots[i + 1]);
            }
        }
        functions = next;
    }
    std::array::from_fn(|p| std::array::from_fn(|j| functions[j][p]))
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
                let (w, _) = basis.weights(Lanes::COMMON, -1.0 + 3.0 * f64::from(i) / 300.0, 2);
                assert_abs_diff_eq!(w.value.iter().sum::<f64>(), 1.0, epsilon = 1e-14);
                assert_abs_diff_eq!(w.slope.iter().sum::<f64>(), 0.0, epsilon = 1e-12);
                assert_abs_diff_eq!(w.curvature.iter().sum::<f64>(), 0.0, epsilon = 1e-11);
                assert!(w.value.iter().all(|&v| v >= -1e-15));
            }
        }
    }

    #[test]
    fn a_coordinate_on_an_end_is_inside_however_it_was_rounded() {
        let basis = Basis::<4>::new(&UNEVEN, Ends::Bounded);
        for end in [-1.0, 2.0] {
            for (by, outside) in [(0.0, false), (1e-12, false), (1e-6, true)] {
                let (_, found) = basis.weights(Lanes::COMMON, end * (1.0 + by), 2);
                assert_eq!(found, outside, "{end} {by}");
            }
        }
    }
}
