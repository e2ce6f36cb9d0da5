//! Four numbers at once, in whatever registers the code around is compiled for: a type of fixed instructions would stay in
//! those of the whole library, [`crate::table::widest`] inlines these into wider ones.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Four numbers, each operation lane by lane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct F64x4(pub [f64; 4]);

/// What is true of four numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mask([bool; 4]);

macro_rules! operation {
    ($operator:ident, $method:ident, $sign:tt) => {
        impl $operator for F64x4 {
            type Output = F64x4;
            #[inline(always)]
            fn $method(self, other: F64x4) -> F64x4 {
                F64x4(from_fn(|i| self.0[i] $sign other.0[i]))
            }
        }

        impl $operator<f64> for F64x4 {
            type Output = F64x4;
            #[inline(always)]
            fn $method(self, other: f64) -> F64x4 {
                F64x4(from_fn(|i| self.0[i] $sign other))
            }
        }
    };
}

operation!(Add, add, +);
operation!(Sub, sub, -);
operation!(Mul, mul, *);
operation!(Div, div, /);

impl Neg for F64x4 {
    type Output = F64x4;
    #[inline(always)]
    fn neg(self) -> F64x4 {
        F64x4(self.0.map(|x| -x))
    }
}

impl AddAssign for F64x4 {
    #[inline(always)]
    fn add_assign(&mut self, other: F64x4) {
        *self = *self + other;
    }
}

impl SubAssign for F64x4 {
    #[inline(always)]
    fn sub_assign(&mut self, other: F64x4) {
        *self = *self - other;
    }
}

impl F64x4 {
    pub const ZERO: F64x4 = F64x4([0.0; 4]);

    #[inline(always)]
    pub fn splat(x: f64) -> F64x4 {
        F64x4([x; 4])
    }

    /// 1 / x.
    #[inline(always)]
    pub fn recip(self) -> F64x4 {
        F64x4(self.0.map(|x| 1.0 / x))
    }

    #[inline(always)]
    pub fn sqrt(self) -> F64x4 {
        F64x4(self.0.map(f64::sqrt))
    }

    /// The larger of each and `least`.
    #[inline(always)]
    pub fn at_least(self, least: f64) -> F64x4 {
        F64x4(self.0.map(|x| if x > least { x } else { least }))
    }

    /// The smaller of each and that of `other`.
    #[inline(always)]
    pub fn min(self, other: F64x4) -> F64x4 {
        F64x4(from_fn(|i| {
            let (a, b) = (self.0[i], other.0[i]);
            if a < b { a } else { b }
        }))
    }

    /// Whether all are positive.
    #[inline(always)]
    pub fn are_positive(self) -> bool {
        let [a, b, c, d] = self.0;
        let least = |a: f64, b: f64| if a < b { a } else { b };
        least(least(a, b), least(c, d)) > 0.0
    }

    /// Where `holds`.
    #[inline(always)]
    pub fn is(self, holds: impl Fn(f64) -> bool) -> Mask {
        Mask(self.0.map(holds))
    }

    /// Natural logarithm of positive normal numbers, within 3e-16 of the larger of it and 1.
    ///
    /// With x = 2^k m, m about 1, and s = (m - 1) / (m + 1): ln m = 2 (s + s³/3 + s⁵/5 + ...).
    #[inline(always)]
    pub fn ln(self) -> F64x4 {
        const ONE: u64 = 1.0f64.to_bits();
        // From here on m begins anew.
        const ROOT: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
        const EXPONENT: u64 = !((1 << 52) - 1);
        const LARGE: f64 = 4_503_599_627_370_496.0;
        let exponent = self.0.map(|x| (x.to_bits() + (ONE - ROOT)) & EXPONENT);
        let m = F64x4(from_fn(|i| {
            f64::from_bits(self.0[i].to_bits() + ONE - exponent[i])
        }));
        // A whole number below the last digit of 2^52 is its mantissa.
        let k =
            F64x4(exponent.map(|e| f64::from_bits((e >> 52) | LARGE.to_bits()))) - (LARGE + 1023.0);
        let s = (m - 1.0) / (m + 1.0);
        let z = s * s;
        let pair = |n: f64| z * (n + 2.0).recip() + n.recip();
        let (z2, z3) = (z * z, z * z * z);
        let z4 = z2 * z2;
        let low = z2 * pair(7.0) + pair(3.0);
        let high = z2 * pair(15.0) + pair(11.0);
        let series = z * (low + z4 * high) + z3 * z3 * z3 * 19.0f64.recip();
        (s * 2.0 + s * 2.0 * series) + k * std::f64::consts::LN_2
    }
}

impl Mask {
    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select(self, yes: F64x4, no: F64x4) -> F64x4 {
        F64x4(from_fn(|i| if self.0[i] { yes.0[i] } else { no.0[i] }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_that_of_the_standard_library() {
        for i in 0..100_000 {
            let x = f64::exp(-300.0 + 6e-3 * f64::from(i)) * (1.0 + 1e-3 * f64::from(i % 7));
            let near = 1.0 + 1e-5 * f64::from(i - 50_000);
            let all = [x, 1.0 / x, near, 1.0];
            for (found, x) in F64x4(all).ln().0.into_iter().zip(all) {
                let error = (found - x.ln()).abs();
                assert!(error <= 3e-16 * x.ln().abs().max(1.0), "{x}: {error:e}");
            }
        }
    }
}
