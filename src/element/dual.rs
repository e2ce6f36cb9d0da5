//! Numbers with `N` exact first derivatives (forward differentiation).
//!
//! Own code, since the Jacobian hangs on it: derivatives in a plain array fill vector registers, where
//! those of the crate num-dual, an optional matrix, took several times as long (benches/evaluation.rs).

use num_traits::{One, Zero};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// `re` + sum of `eps[i]` e_i with e_i e_j = 0: a value and its derivatives along `N` directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// Value.
    pub re: f64,
    /// Derivatives.
    pub eps: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A value with derivatives.
    #[inline(always)]
    pub fn new(re: f64, eps: [f64; N]) -> Self {
        Self { re, eps }
    }

    /// A value whose derivative along direction `i` is one.
    pub fn variable(re: f64, i: usize) -> Self {
        let mut out = Self::from(re);
        out.eps[i] = 1.0;
        out
    }

    /// f(self), of the value `f` and the slope `df` there.
    #[inline(always)]
    pub(super) fn chained(self, f: f64, df: f64) -> Self {
        Self::new(f, self.eps.map(|e| e * df))
    }

    #[inline(always)]
    fn both(self, other: Self, re: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut eps = self.eps;
        for (e, o) in eps.iter_mut().zip(other.eps) {
            *e = f(*e, o);
        }
        Self::new(re, eps)
    }
}

impl<const N: usize> From<f64> for Dual<N> {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Self::new(re, [0.0; N])
    }
}

impl<const N: usize> PartialOrd for Dual<N> {
    /// By the value.
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.both(o, self.re + o.re, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.both(o, self.re - o.re, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    #[inline(always)]
    #[allow(clippy::suspicious_arithmetic_impl)] // The product rule is a sum.
    fn mul(self, o: Self) -> Self {
        self.both(o, self.re * o.re, |a, b| a * o.re + b * self.re)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let inverse = 1.0 / o.re;
        let ratio = self.re * inverse;
        self.both(o, ratio, |a, b| (a - b * ratio) * inverse)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.chained(-self.re, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: f64) -> Self {
        Self::new(self.re + o, self.eps)
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: f64) -> Self {
        Self::new(self.re - o, self.eps)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        self.chained(self.re * o, o)
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<const N: usize> SubAssign for Dual<N> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<const N: usize> MulAssign for Dual<N> {
    #[inline(always)]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl<const N: usize> Zero for Dual<N> {
    fn zero() -> Self {
        Self::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.re == 0.0 && self.eps == [0.0; N]
    }
}

impl<const N: usize> One for Dual<N> {
    fn one() -> Self {
        Self::from(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::scalar::Scalar;
    use super::*;

    #[test]
    fn every_operation_carries_the_derivative_of_its_formula() {
        // f(x, y) by each operation, and its partial derivatives by hand.
        let (x, y) = (1.7, -0.6);
        let (a, b) = (Dual::<2>::variable(x, 0), Dual::<2>::variable(y, 1));
        let cases = [
            (a + b, x + y, [1.0, 1.0]),
            (a - b, x - y, [1.0, -1.0]),
            (a * b, x * y, [y, x]),
            (a / b, x / y, [1.0 / y, -x / (y * y)]),
            (-a, -x, [-1.0, 0.0]),
            (a + 2.0, x + 2.0, [1.0, 0.0]),
            (b - 2.0, y - 2.0, [0.0, 1.0]),
            (a * 3.0, x * 3.0, [3.0, 0.0]),
            (a.sqrt(), x.sqrt(), [0.5 / x.sqrt(), 0.0]),
            (b.recip(), 1.0 / y, [0.0, -1.0 / (y * y)]),
            (a.powf(-0.3), x.powf(-0.3), [-0.3 * x.powf(-1.3), 0.0]),
        ];
        for (n, (found, value, slopes)) in cases.into_iter().enumerate() {
            assert!((found.re - value).abs() <= 1e-15, "{n}");
            for (eps, slope) in found.eps.iter().zip(slopes) {
                assert!((eps - slope).abs() <= 1e-14, "{n}: {eps}");
            }
        }
    }
}
