//! From the scaled displacement back to the coordinates of [`Query`](crate::table::Query).
//!
//! With the no-load approach D0 and the span S = D1 - D0 over y = (C, M, PMC):
//! u = (delta - D0) / S and W(delta, y) = S(y) w(u, y), hence F = dW/d delta = dw/du.

use super::kernel::{Jet, SECOND};
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

/// W and its derivatives from w, dw/du and d²w/du² (`shape`) with theirs by y, and d³w/du³ (`third`,
/// only with `H`). Axes that are not `present` cost nothing: their derivatives stay zero.
#[inline(always)]
pub fn potential<const H: bool>(
    u: f64,
    shape: &[Jet; 3],
    third: f64,
    no_load: &Jet,
    span: &Jet,
    present: [bool; 3],
) -> Potential {
    let [w, f, k] = shape;
    let s = span.value;
    let inverse = 1.0 / s;
    let mut out = Potential {
        value: s * w.value,
        ..Potential::default()
    };
    out.gradient[0] = f.value;
    out.hessian[0][0] = k.value * inverse;
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
        let mut stiffness = [third * inverse * inverse, 0.0, 0.0, 0.0];
        for i in 0..3 {
            if !present[i] {
                continue;
            }
            let mixed = k.value * u_y[i] + f.gradient[i];
            out.hessian[0][Y[i]] = mixed;
            out.hessian[Y[i]][0] = mixed;
            stiffness[Y[i]] =
                inverse * (third * u_y[i] + k.gradient[i] - k.value * span.gradient[i] * inverse);
            for j in i..3 {
                if !present[j] {
                    continue;
                }
                let n = SECOND[i][j];
                let second = span.second[n] * complement - no_load.second[n] * f.value
                    + span.gradient[i] * w.gradient[j]
                    + span.gradient[j] * w.gradient[i]
                    + s * (k.value * u_y[i] * u_y[j]
                        + f.gradient[i] * u_y[j]
                        + f.gradient[j] * u_y[i]
                        + w.second[n]);
                out.hessian[Y[i]][Y[j]] = second;
                out.hessian[Y[j]][Y[i]] = second;
            }
        }
        out.stiffness_gradient = Some(stiffness);
    }
    out
}

/// Puts a moment of its own, mu(u, y) with its derivative by u in `shape[1]` and `shape[2]`, in place of dW/dM.
#[inline(always)]
pub fn set_moment<const H: bool>(
    out: &mut Potential,
    u: f64,
    [_, moment, slope]: &[Jet; 3],
    no_load: &Jet,
    span: &Jet,
    present: [bool; 3],
) {
    out.gradient[2] = moment.value;
    if H {
        let inverse = 1.0 / span.value;
        let u_y = scaled_gradient(u, no_load, span, inverse, present);
        out.hessian[2][0] = slope.value * inverse;
        for i in 0..3 {
            if present[i] {
                out.hessian[2][Y[i]] = slope.value * u_y[i] + moment.gradient[i];
            }
        }
    }
}
