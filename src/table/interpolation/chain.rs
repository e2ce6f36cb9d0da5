//! From the scaled displacement back to the coordinates of [`Query`](crate::table::Query).
//!
//! With the no-load approach D0 and the span S = D1 - D0 over y = (C, M, PMC):
//! u = (delta - D0) / S and W(delta, y) = S(y) w(u, y), hence F = dW/d delta = dw/du.

use super::kernel::{Jet, SECOND, Shape};
use crate::table::Potential;

/// Position of the coordinates y in the arrays of [`Potential`].
const Y: [usize; 3] = [1, 2, 3];

/// Derivatives of u by y; zero along axes that are not `present`.
#[inline(always)]
fn scaled_gradient(
    u: f64,
    no_load: &Jet,
    span: &Jet,
    inverse: f64,
    present: [bool; 3],
) -> [f64; 3] {
    let mut slopes = [0.0; 3];
    for i in 0..3 {
        if present[i] {
            slopes[i] = -(no_load.gradient[i] + u * span.gradient[i]) * inverse;
        }
    }
    slopes
}

/// W and its derivatives from w. Axes that are not `present` cost nothing: their derivatives stay zero.
#[inline(always)]
pub fn potential<const H: bool>(
    u: f64,
    shape: &Shape,
    no_load: &Jet,
    span: &Jet,
    present: [bool; 3],
) -> Potential {
    let (w, f, k) = (&shape.value, &shape.slope, shape.curvature);
    let s = span.value;
    let inverse = 1.0 / s;
    let mut out = Potential {
        value: s * w.value,
        ..Potential::default()
    };
    out.gradient[0] = f.value;
    out.hessian[0][0] = k * inverse;
    let complement = w.value - u * f.value;
    for i in 0..3 {
        if present[i] {
            // s du/dy = -(D0_y + u S_y) turns the chain rule into this.
            out.gradient[Y[i]] =
                span.gradient[i] * complement - no_load.gradient[i] * f.value + s * w.gradient[i];
        }
    }
    if H {
        let u_y = scaled_gradient(u, no_load, span, inverse, present);
        for i in 0..3 {
            if !present[i] {
                continue;
            }
            let mixed = k * u_y[i] + f.gradient[i];
            out.hessian[0][Y[i]] = mixed;
            out.hessian[Y[i]][0] = mixed;
            for j in i..3 {
                if !present[j] {
                    continue;
                }
                let n = SECOND[i][j];
                let second = span.second[n] * complement - no_load.second[n] * f.value
                    + span.gradient[i] * w.gradient[j]
                    + span.gradient[j] * w.gradient[i]
                    + s * (k * u_y[i] * u_y[j]
                        + f.gradient[i] * u_y[j]
                        + f.gradient[j] * u_y[i]
                        + w.second[n]);
                out.hessian[Y[i]][Y[j]] = second;
                out.hessian[Y[j]][Y[i]] = second;
            }
        }
    }
    out
}

/// Puts the slope of `shape`, a moment of its own, in the place of dW/dM.
#[inline(always)]
pub fn set_moment<const H: bool>(
    out: &mut Potential,
    u: f64,
    shape: &Shape,
    no_load: &Jet,
    span: &Jet,
    present: [bool; 3],
) {
    let moment = &shape.slope;
    out.gradient[2] = moment.value;
    if H {
        let inverse = 1.0 / span.value;
        let u_y = scaled_gradient(u, no_load, span, inverse, present);
        out.hessian[2][0] = shape.curvature * inverse;
        for i in 0..3 {
            if present[i] {
                out.hessian[2][Y[i]] = shape.curvature * u_y[i] + moment.gradient[i];
            }
        }
    }
}
