//! The kernel that spreads a line load across its contact line, and its logarithmic self-displacement.
//!
//! phi(t) = 15/16 (1 - t²)² / w for abs(t) < 1, t the distance over the half-width w; cut off at the edges
//! of the flank and scaled back to unit mass.

use gearmesh::root::bisection;

/// Half-width of the kernel over that of the widest contact: the kernel's reference length, 0.29 of its
/// half-width, then exceeds that of the contact, and the local contact adds to the bulk.
pub const KERNEL_OVER_HERTZ: f64 = 4.0;

/// Widest kernel in normal modules: up to it the sum of bulk and local contact does not depend on the width
/// by more than 0.2 % (docs/theory/compliance.md).
pub const WIDEST_KERNEL: f64 = 0.35;

/// Half-width of the kernel at the tip edge over the element there: what the elements resolve,
/// measured with five Gauss points on half a kernel.
pub const EDGE_KERNEL_OVER_ELEMENT: f64 = 1.5;

/// Distance from the edge at which a load gives way at a tip corner as one that half a kernel spreads from the edge on, over
/// the half-width: half of exp of the mean of ln(x + y) over both.
pub const HALF_KERNEL_FROM_EDGE: f64 = 0.269;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kernel {
    half_width: f64,
    /// Arc length of its middle, m.
    center: f64,
    /// The part of [-1, 1] that lies on the flank.
    low: f64,
    high: f64,
    mass: f64,
}

/// Gauss-Legendre abscissae and weights on [0, 1], 5 points, exact to degree 9.
pub(crate) const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668_0, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

impl Kernel {
    /// Kernel for a line at the arc length `line` of a flank from `flank[0]` to `flank[1]`, m; a line
    /// beyond an edge is taken at that edge.
    ///
    /// Near the tip edge the part beyond it is missing. So that the load does not move away from the
    /// edge with it, the kernel's middle is moved towards the edge until its centre of mass lies on the
    /// line; half of the kernel always stays.
    pub fn new(half_width: f64, line: f64, flank: [f64; 2]) -> Kernel {
        let line = line.clamp(flank[0], flank[1]);
        let room = (flank[1] - line) / half_width;
        let low = ((flank[0] - line) / half_width).clamp(-1.0, 0.0);
        let mut high = room.clamp(0.0, 1.0);
        if high < 1.0 {
            // With the edge at `high` from the middle, the centre of mass lies `high - mean(high)` from
            // the edge: rising in `high` from the half kernel's value.
            let distance = |high: f64| high - mean(low, high);
            high = bisection([0.0, high], 60, |high| distance(high) < room);
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

    /// Ends of the support, arc length in m.
    pub fn support(&self) -> [f64; 2] {
        [self.low, self.high].map(|t| self.center + t * self.half_width)
    }

    /// Density at the arc length `arc` (m) inside the support, 1/m.
    pub fn density(&self, arc: f64) -> f64 {
        shape((arc - self.center) / self.half_width) / (self.mass * self.half_width)
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
        GAUSS5
            .iter()
            .map(|(x, weight)| {
                let at = self.low + length * x;
                weight * length * shape(at) * shape(at + t)
            })
            .sum::<f64>()
            / (self.mass * self.mass)
    }
}

fn shape(t: f64) -> f64 {
    let inside = (1.0 - t * t).max(0.0);
    15.0 / 16.0 * inside * inside
}

/// Centre of mass of [`shape`] between `low` and `high`.
fn mean(low: f64, high: f64) -> f64 {
    let first = |t: f64| 15.0 / 16.0 * t * t * (0.5 - 0.5 * t * t + t.powi(4) / 6.0);
    (first(high) - first(low)) / (cumulative(high) - cumulative(low))
}

/// Integral of [`shape`] from 0 to t.
fn cumulative(t: f64) -> f64 {
    15.0 / 16.0 * (t - 2.0 / 3.0 * t.powi(3) + 0.2 * t.powi(5))
}

#[cfg(test)]
mod tests {
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
    fn reference_length_is_the_logarithmic_self_distance_also_at_an_edge() {
        for to_edge in [5.0, 0.4, 0.1, 0.0] {
            let kernel = Kernel::new(0.6, 0.0, [-3.0, to_edge]);
            let expected = by_cells(&kernel, 800);
            assert_abs_diff_eq!(kernel.reference_length() / expected, 1.0, epsilon = 2e-5);
        }
    }

    #[test]
    fn centre_of_mass_stays_on_the_line_up_to_a_third_of_the_width_from_the_edge() {
        for to_edge in [5.0, 0.5, 0.3, 0.2] {
            let kernel = Kernel::new(0.6, 0.0, [-3.0, to_edge]);
            let [low, high] = kernel.support();
            assert!(high <= to_edge + 1e-12);
            let steps = 4000;
            let h = (high - low) / f64::from(steps);
            let mean: f64 = (0..steps)
                .map(|i| low + (f64::from(i) + 0.5) * h)
                .map(|x| x * kernel.density(x) * h)
                .sum();
            assert_abs_diff_eq!(mean, 0.0, epsilon = 1e-6);
        }
    }

    #[test]
    fn mass_is_one_also_at_an_edge() {
        for to_edge in [5.0, 0.3, 0.0] {
            let kernel = Kernel::new(0.6, 0.0, [-3.0, to_edge]);
            let [low, high] = kernel.support();
            let mass: f64 = GAUSS5
                .iter()
                .map(|(x, w)| w * (high - low) * kernel.density(low + x * (high - low)))
                .sum();
            assert_abs_diff_eq!(mass, 1.0, epsilon = 1e-14);
        }
    }
}
