//! The numbers of the element's equations: plain ones, or ones that carry exact first derivatives.
//!
//! Own code, since the Jacobian hangs on it: derivatives in a plain array fill vector registers, where
//! those of the crate num-dual, an optional matrix, took several times as long (benches/evaluation.rs).

use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Vector3};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use wide::f64x4;

/// Directions of the derivatives: first ones of three each. All of them fill four registers of four lanes.
pub(crate) mod part {
    pub const POSITION_2: usize = 0;
    pub const ROTATION_2: usize = 3;
    pub const VELOCITY_2: usize = 6;
    pub const SPIN_2: usize = 9;
    pub const CARRIER_ROTATION: usize = 12;
    pub const COUNT: usize = 16;
}

/// A real number, or a real number that carries derivatives along. The element's equations are written once over this trait:
/// with `f64` they cost what plain code costs, with the element's dual numbers every output comes with its exact derivatives.
pub trait Scalar:
    nalgebra::Scalar
    + Copy
    + Default
    + From<f64>
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
    /// `re` with these derivatives: index of the direction and slope.
    fn varying(re: f64, slopes: [(usize, f64); 2]) -> Self;
    /// The number without its derivatives.
    fn re(self) -> f64;
    /// A function of this number with this value and this slope there.
    fn chained(self, value: f64, slope: f64) -> Self;

    /// Square root; of a number above zero.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re().sqrt();
        self.chained(root, 0.5 / root)
    }

    /// 1 / self.
    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = 1.0 / self.re();
        self.chained(inverse, -inverse * inverse)
    }

    /// Power; of a number above zero.
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let power = self.re().powf(exponent);
        self.chained(power, exponent * power / self.re())
    }
}

impl Scalar for f64 {
    const CARRIES: bool = false;

    #[inline(always)]
    fn varying(re: f64, _: [(usize, f64); 2]) -> Self {
        re
    }

    #[inline(always)]
    fn re(self) -> f64 {
        self
    }

    #[inline(always)]
    fn chained(self, value: f64, _: f64) -> Self {
        value
    }
}

/// `re` + sum of `eps[i]` e_i with e_i e_j = 0: a value and its derivatives along the directions of [`part`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Dual {
    /// Value.
    pub re: f64,
    /// Derivatives.
    pub eps: [f64; part::COUNT],
}

impl Dual {
    #[inline(always)]
    fn both(self, other: Self, re: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut eps = self.eps;
        for (e, o) in eps.iter_mut().zip(other.eps) {
            *e = f(*e, o);
        }
        Self { re, eps }
    }
}

impl Scalar for Dual {
    const CARRIES: bool = true;

    // In line it becomes an instruction that valgrind 3.19 does not know, and counts of instructions end there.
    #[inline(never)]
    fn varying(re: f64, slopes: [(usize, f64); 2]) -> Self {
        let mut out = Self::from(re);
        for (direction, slope) in slopes {
            out.eps[direction] += slope;
        }
        out
    }

    #[inline(always)]
    fn re(self) -> f64 {
        self.re
    }

    #[inline(always)]
    fn chained(self, value: f64, slope: f64) -> Self {
        Self {
            re: value,
            eps: self.eps.map(|e| e * slope),
        }
    }
}

impl From<f64> for Dual {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Self {
            re,
            eps: [0.0; part::COUNT],
        }
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $(($assign:ident $assigned:ident))? |$a:ident, $b:ident: $other:ty| $result:expr;)*) => {$(
        impl $operator<$other> for Dual {
            type Output = Dual;

            #[inline(always)]
            #[allow(clippy::suspicious_arithmetic_impl)] // The product rule is a sum.
            fn $method(self, $b: $other) -> Dual {
                let $a = self;
                $result
            }
        }

        $(impl $assign for Dual {
            #[inline(always)]
            fn $assigned(&mut self, other: Dual) {
                *self = self.$method(other);
            }
        })?
    )*};
}

operators! {
    Add add (AddAssign add_assign) |a, b: Dual| a.both(b, a.re + b.re, |x, y| x + y);
    Sub sub (SubAssign sub_assign) |a, b: Dual| a.both(b, a.re - b.re, |x, y| x - y);
    Mul mul (MulAssign mul_assign) |a, b: Dual| a.both(b, a.re * b.re, |x, y| x * b.re + y * a.re);
    Div div |a, b: Dual| {
        let inverse = 1.0 / b.re;
        let ratio = a.re * inverse;
        a.both(b, ratio, |x, y| (x - y * ratio) * inverse)
    };
    Add add |a, b: f64| Dual { re: a.re + b, ..a };
    Sub sub |a, b: f64| Dual { re: a.re - b, ..a };
    Mul mul |a, b: f64| a.chained(a.re * b, b);
}

impl Neg for Dual {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.chained(-self.re, -1.0)
    }
}

/// `v`, whose components are the directions from `first` on.
#[inline(always)]
pub(crate) fn shifted<T: Scalar>(v: &Vector3<f64>, first: usize) -> Vector3<T> {
    let component = |i: usize| T::varying(v[i], [(first + i, 1.0), (first, 0.0)]);
    Vector3::new(component(0), component(1), component(2))
}

/// `v`, fixed to a body whose rotation vector has the directions from `first` on.
#[inline(always)]
pub(crate) fn turned<T: Scalar>(v: &Vector3<f64>, first: usize) -> Vector3<T> {
    let component = |i: usize| {
        let (next, last) = ((i + 1) % 3, (i + 2) % 3);
        T::varying(v[i], [(first + next, v[last]), (first + last, -v[next])])
    };
    Vector3::new(component(0), component(1), component(2))
}

/// Scalar product; `w` may be a plain vector.
#[inline(always)]
pub(crate) fn dot<T: Scalar + Mul<U, Output = T>, U: nalgebra::Scalar + Copy>(
    v: &Vector3<T>,
    w: &Vector3<U>,
) -> T {
    v.x * w.x + v.y * w.y + v.z * w.z
}

/// `factor` v; `v` may be a plain vector. (nalgebra's product is not always inlined.)
#[inline(always)]
pub(crate) fn scaled<T: Scalar + Mul<U, Output = T>, U: nalgebra::Scalar + Copy>(
    v: &Vector3<U>,
    factor: T,
) -> Vector3<T> {
    Vector3::new(factor * v.x, factor * v.y, factor * v.z)
}

/// v x w; `w` may be a plain vector.
#[inline(always)]
pub(crate) fn cross<T: Scalar + Mul<U, Output = T>, U: nalgebra::Scalar + Copy>(
    v: &Vector3<T>,
    w: &Vector3<U>,
) -> Vector3<T> {
    Vector3::new(
        v.y * w.z - v.z * w.y,
        v.z * w.x - v.x * w.z,
        v.x * w.y - v.y * w.x,
    )
}

/// `angle` (rad) brought into [-pi, pi) by whole turns; its derivatives stay.
#[inline(always)]
pub(crate) fn wrap<T: Scalar>(angle: T) -> T {
    angle - std::f64::consts::TAU * whole_turns(angle.re())
}

/// The whole turns that [`wrap`] takes from `angle` (rad).
#[inline(always)]
pub(crate) fn whole_turns(angle: f64) -> f64 {
    nearest(angle / std::f64::consts::TAU)
}

/// `x` brought into [0, 1) by whole numbers; its derivatives stay.
#[inline(always)]
pub(crate) fn fraction<T: Scalar>(x: T) -> T {
    let re = x.re();
    let whole = nearest(re);
    x - if whole > re { whole - 1.0 } else { whole }
}

/// The whole number next to `x`. (`f64::round` is a call on processors that must all be served.)
#[inline(always)]
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
    let re = |v: &[T; 4]| f64x4::new([v[0].re(), v[1].re(), v[2].re(), v[3].re()]);
    // Zeros of either sign lie on the same side of the cut: -0 + 0 = 0.
    let values = (re(&y) + f64x4::splat(0.0)).atan2(re(&x)).to_array();
    let mut out = x;
    for i in 0..4 {
        let (a, b) = (x[i].re(), y[i].re());
        let inverse = 1.0 / (a * a + b * b);
        out[i] = lift(values[i], &[a * inverse, -b * inverse], &[y[i], x[i]]);
    }
    out
}

/// A function of `q` with this value and gradient there.
#[inline(always)]
pub(crate) fn lift<T: Scalar, const N: usize>(value: f64, gradient: &[f64; N], q: &[T; N]) -> T {
    let mut y = T::from(value);
    if T::CARRIES {
        for (slope, x) in gradient.iter().zip(q) {
            y += x.chained(0.0, *slope);
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(re: f64, direction: usize) -> Dual {
        Dual::varying(re, [(direction, 1.0), (direction, 0.0)])
    }

    #[test]
    fn four_angles_are_those_of_the_standard_library_with_their_derivatives() {
        for n in 0..4000 {
            let at = |k: usize| {
                let turn = 1e-3 + 0.001_570_8 * (n + 1000 * k) as f64;
                let length = 10f64.powi((n % 9) as i32 - 4);
                (length * turn.sin(), length * turn.cos())
            };
            let points = [0, 1, 2, 3].map(at);
            let y = points.map(|p| variable(p.0, 0).chained(p.0, 0.3));
            let x = points.map(|p| variable(p.1, 0).chained(p.1, -0.7));
            for (found, (y, x)) in angles(y, x).into_iter().zip(y.into_iter().zip(x)) {
                let exact = y.re.atan2(x.re);
                assert!((found.re - exact).abs() <= 4.0 * f64::EPSILON, "{exact}");
                // d atan2 = (x dy - y dx) / (x^2 + y^2).
                let length = x.re.hypot(y.re);
                let slope = (x.re / length * y.eps[0] - y.re / length * x.eps[0]) / length;
                assert!((found.eps[0] - slope).abs() <= 1e-14 / length, "{exact}");
            }
        }
        let found = angles::<f64>([0.0, -0.0, 0.0, -0.0], [-1.0, -1.0, 1.0, 1.0]);
        assert_eq!(found[0], found[1], "the sign of a zero turns no angle");
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
