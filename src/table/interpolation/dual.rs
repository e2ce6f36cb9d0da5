//! Numbers with first and second derivatives by the coordinates of scattered data.

use std::array::from_fn;
use std::ops::AddAssign;

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
