//! A table of the displacement alone: its B-spline as one polynomial per cell.
//!
//! With a single coordinate the weights cost more than the sum they serve, so the sum is done beforehand.

use super::basis::{Basis, Cell};
use super::kernel::Jet;

/// Coefficients of each cell's polynomial of the local coordinate in [0, 1], powers ascending.
#[derive(Debug, Clone)]
pub struct Line<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Line<N> {
    /// From the B-spline `coefficients` over `basis`.
    pub fn new(basis: &Basis<N>, coefficients: &[f64]) -> Self {
        let cell = |(first, cell): (usize, &Cell<N>)| {
            cell.polynomials.map(|of_power| {
                (0..N)
                    .map(|k| of_power[k] * coefficients[first + k])
                    .sum::<f64>()
            })
        };
        Line(basis.cells().iter().enumerate().map(cell).collect())
    }

    /// Value and two derivatives, and the third one, at the local coordinate `t` of `cell`, which is 1 / `scale` long.
    #[inline(always)]
    pub fn at(&self, cell: usize, t: f64, scale: f64) -> ([Jet; 3], f64) {
        let a = &self.0[cell];
        let mut derivatives = [0.0; 4];
        let mut power = [1.0; N];
        for k in 1..N {
            power[k] = power[k - 1] * t;
        }
        for k in 0..N {
            let mut factor = a[k];
            for d in 0..4.min(k + 1) {
                derivatives[d] += factor * power[k - d];
                factor *= (k - d) as f64;
            }
        }
        let [w, slope, curvature, third] = derivatives;
        let square = scale * scale;
        let shape = [w, slope * scale, curvature * square].map(|value| Jet {
            value,
            ..Jet::default()
        });
        (shape, third * square * scale)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        8 * N * self.0.len()
    }
}
