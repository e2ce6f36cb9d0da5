//! The number type of the kinematics: `f64` for values, dual numbers for exact derivatives.

use num_dual::DualNum;

/// A real number, or a real number that carries derivatives along. The element's equations are
/// written once over this trait: with `f64` they cost what plain code costs, with a dual number every
/// output comes with its exact derivative.
pub trait Scalar: DualNum<Primitive = f64> + Copy + PartialOrd + Send + Sync {}

impl<T: DualNum<Primitive = f64> + Copy + PartialOrd + Send + Sync> Scalar for T {}

/// `angle` (rad) brought into [-pi, pi) by whole turns; its derivatives stay.
pub(crate) fn wrap<T: Scalar>(angle: T) -> T {
    use std::f64::consts::TAU;
    angle - TAU * (angle.re() / TAU).round()
}

/// `x` brought into [0, 1) by whole numbers; its derivatives stay.
pub(crate) fn fraction<T: Scalar>(x: T) -> T {
    x - x.re().floor()
}

/// `table(q)` with derivatives, from its value and gradient at the real parts of `q`.
pub(crate) fn lift<T: Scalar, const N: usize>(value: f64, gradient: &[f64; N], q: &[T; N]) -> T {
    let mut y = T::from(value);
    if T::NDERIV > 0 {
        for (slope, x) in gradient.iter().zip(q) {
            // x - re(x) has the value zero and the derivatives of x.
            y += (*x - x.re()) * *slope;
        }
    }
    y
}
