//! The number type of the kinematics: `f64` for values, dual numbers for exact derivatives.

use super::dual::Dual;
use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Vector3};
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::f64x4;

/// A real number, or a real number that carries derivatives along. The element's equations are
/// written once over this trait: with `f64` they cost what plain code costs, with a [`Dual`] every
/// output comes with its exact derivatives.
pub trait Scalar:
    nalgebra::Scalar
    + Copy
    + PartialOrd
    + From<f64>
    + Zero
    + One
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + Neg<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Whether it carries derivatives.
    const CARRIES: bool;
    /// `re` with the derivatives `slopes` by translation (per m) and rotation (per rad) of gear 2 and by rotation of the carrier, in world
    /// axes: as many of them as it carries, and not even asked for where it carries none.
    fn varying(re: f64, slopes: impl FnOnce() -> [Vector3<f64>; 3]) -> Self;
    /// The number without its derivatives.
    fn re(self) -> f64;
    /// Square root; of a number above zero.
    fn sqrt(self) -> Self;
    /// 1 / self.
    fn recip(self) -> Self;
    /// Power; of a number above zero.
    fn powf(self, exponent: f64) -> Self;
}

impl Scalar for f64 {
    const CARRIES: bool = false;

    #[inline(always)]
    fn varying(re: f64, _: impl FnOnce() -> [Vector3<f64>; 3]) -> Self {
        re
    }

    #[inline(always)]
    fn re(self) -> f64 {
        self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    const CARRIES: bool = true;

    #[inline(always)]
    fn varying(re: f64, slopes: impl FnOnce() -> [Vector3<f64>; 3]) -> Self {
        const { assert!(N <= 9) };
        let rows: [[f64; 3]; 3] = slopes().map(Into::into);
        let mut out = Self::from(re);
        out.eps.copy_from_slice(&rows.as_flattened()[..N]);
        out
    }

    #[inline(always)]
    fn re(self) -> f64 {
        self.re
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chained(root, 0.5 / root)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = 1.0 / self.re;
        self.chained(inverse, -inverse * inverse)
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let power = self.re.powf(exponent);
        self.chained(power, exponent * power / self.re)
    }
}

/// `angle` (rad) brought into [-pi, pi) by whole turns; its derivatives stay.
pub(crate) fn wrap<T: Scalar>(angle: T) -> T {
    angle - std::f64::consts::TAU * whole_turns(angle.re())
}

/// The whole turns that [`wrap`] takes from `angle` (rad).
pub(crate) fn whole_turns(angle: f64) -> f64 {
    nearest(angle / std::f64::consts::TAU)
}

/// `x` brought into [0, 1) by whole numbers; its derivatives stay.
pub(crate) fn fraction<T: Scalar>(x: T) -> T {
    let re = x.re();
    let whole = nearest(re);
    x - if whole > re { whole - 1.0 } else { whole }
}

/// The whole number next to `x`. (`f64::round` is a call on processors that must all be served.)
fn nearest(x: f64) -> f64 {
    // Beyond 2^52 there are no fractions: adding it rounds them away.
    const LIMIT: f64 = (1_u64 << 51) as f64;
    const SHIFT: f64 = 3.0 * LIMIT;
    if x.abs() < LIMIT {
        (x + SHIFT) - SHIFT
    } else {
        x.round()
    }
}

/// The four angles of the points (`x`, `y`), rad in [-pi, pi], to two units in the last place; one call for all,
/// since a single angle costs as much as four in vector registers.
#[inline(always)]
pub(crate) fn angles<T: Scalar>(y: [T; 4], x: [T; 4]) -> [T; 4] {
    let re = |v: [T; 4]| f64x4::new([v[0].re(), v[1].re(), v[2].re(), v[3].re()]);
    // Zeros of either sign lie on the same side of the cut: -0 + 0 = 0.
    let values = (re(y) + f64x4::splat(0.0)).atan2(re(x)).to_array();
    let mut out = [
        T::from(values[0]),
        T::from(values[1]),
        T::from(values[2]),
        T::from(values[3]),
    ];
    if T::CARRIES {
        for i in 0..4 {
            let (a, b) = (x[i].re(), y[i].re());
            let inverse = 1.0 / (a * a + b * b);
            out[i] += (y[i] - b) * (a * inverse) - (x[i] - a) * (b * inverse);
        }
    }
    out
}

/// `table(q)` with derivatives, from its value and gradient at the real parts of `q`.
#[inline(always)]
pub(crate) fn lift<T: Scalar, const N: usize>(value: f64, gradient: &[f64; N], q: &[T; N]) -> T {
    let mut y = T::from(value);
    if T::CARRIES {
        for (slope, x) in gradient.iter().zip(q) {
            // x - re(x) has the value zero and the derivatives of x.
            y += (*x - x.re()) * *slope;
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_angles_are_those_of_the_standard_library_with_their_derivatives() {
        for n in 0..4000 {
            let at = |k: usize| {
                let turn = 1e-3 + 0.001_570_8 * (n + 1000 * k) as f64;
                let length = 10f64.powi((n % 9) as i32 - 4);
                (length * turn.sin(), length * turn.cos())
            };
            let points = [0, 1, 2, 3].map(at);
            let y = points.map(|p| Dual::<1>::new(p.0, [0.3]));
            let x = points.map(|p| Dual::<1>::new(p.1, [-0.7]));
            for (found, (y, x)) in angles(y, x).into_iter().zip(y.into_iter().zip(x)) {
                let exact = y.re.atan2(x.re);
                assert!(
                    (found.re - exact).abs() <= 4.0 * f64::EPSILON,
                    "{y:?} {x:?}"
                );
                // d atan2 = (x dy - y dx) / (x^2 + y^2).
                let length = x.re.hypot(y.re);
                let slope = (x.re / length * y.eps[0] - y.re / length * x.eps[0]) / length;
                assert!(
                    (found.eps[0] - slope).abs() <= 1e-14 / length,
                    "{y:?} {x:?}"
                );
            }
        }
    }

    #[test]
    fn the_sign_of_a_zero_does_not_turn_an_angle() {
        let found = angles::<f64>([0.0, -0.0, 0.0, -0.0], [-1.0, -1.0, 1.0, 1.0]);
        assert_eq!(found[0], found[1]);
        assert_eq!(found[2..], [0.0; 2]);
    }

    #[test]
    fn whole_turns_and_whole_numbers_are_taken_off_at_any_size() {
        use std::f64::consts::{PI, TAU};
        for n in -2000..2000 {
            let x = 0.37 * f64::from(n);
            assert_eq!(fraction(x), x - x.floor());
            let turned = wrap(x);
            assert!((-PI..=PI).contains(&turned));
            assert!(((x - turned) / TAU - ((x - turned) / TAU).round()).abs() < 1e-12);
        }
        for whole in [0.0, 1.0, -1.0, 1e15, -1e15, 1e300] {
            assert_eq!(fraction(whole), 0.0);
        }
        assert!(fraction(f64::NAN).is_nan() && wrap(f64::INFINITY).is_nan());
    }
}
