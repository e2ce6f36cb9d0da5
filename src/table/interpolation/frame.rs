//! The coordinates but the displacement, and the way from the scaled displacement back to those of [`Query`]: what all
//! interpolants share.
//!
//! With the no-load approach D0 and the span S = D1 - D0 over y = (C, M, PMC):
//! u = (delta - D0) / S and W(delta, y) = S(y) w(u, y), hence F = dW/d delta = dw/du.

use super::basis::{Basis, Weights};
use super::kernel::{ANY, Coefficients, Jet, Point, SECOND, Shape};
use crate::table::{Potential, Query};
use crate::vector::Lanes;

/// Axes of centre distance, misalignment and mesh position, and what the scaled displacement is measured by along them.
#[derive(Debug, Clone)]
pub struct Frame<const N: usize> {
    pub c: Basis<N>,
    pub m: Basis<N>,
    pub p: Basis<N>,
    pub no_load: Coefficients<N>,
    pub span: Coefficients<N>,
}

pub struct Framed<const N: usize> {
    pub weights: Point<N>,
    /// Which of them are axes; the others cost nothing, and derivatives by them are zero.
    present: [bool; 3],
    no_load: Jet,
    span: Jet,
    pub u: f64,
    /// Whether the point is outside the range of centre distance or misalignment.
    pub outside: bool,
}

impl<const N: usize> Frame<N> {
    pub fn axes(&self) -> usize {
        let [c, m, p] = self.present::<ANY>().map(usize::from);
        c | m << 1 | p << 2
    }

    #[inline(always)]
    fn present<const AXES: usize>(&self) -> [bool; 3] {
        match AXES {
            ANY => [self.c.present(), self.m.present(), self.p.present()],
            _ => [AXES & 1 != 0, AXES & 2 != 0, AXES & 4 != 0],
        }
    }

    pub fn bytes(&self) -> usize {
        self.no_load.bytes() + self.span.bytes()
    }

    #[inline(always)]
    pub fn at<const H: bool, const AXES: usize>(&self, lanes: Lanes, q: &Query) -> Framed<N> {
        let present @ [by_c, by_m, by_p] = self.present::<AXES>();
        let weights = |present: bool, basis: &Basis<N>, x: f64| match present {
            true => basis.weights(lanes, x, if H { 2 } else { 1 }),
            false => (Weights::constant(), false),
        };
        let (c, c_outside) = weights(by_c, &self.c, q.center_distance_offset);
        let (m, m_outside) = weights(by_m, &self.m, q.misalignment);
        let (p, _) = weights(by_p, &self.p, q.mesh_position);
        let weights = Point { c, m, p };
        let outside = c_outside || m_outside;
        let mut no_load = self.no_load.field::<H, AXES>(lanes, &weights);
        let span = self.span.field::<H, AXES>(lanes, &weights);
        if outside {
            no_load = self.begins(q, p);
        }
        Framed {
            u: (q.delta - no_load.value) / span.value,
            weights,
            present,
            no_load,
            span,
            outside,
        }
    }

    pub fn fraction(&self, q: &Query) -> f64 {
        self.at::<false, ANY>(Lanes::COMMON, q).u
    }

    /// The approach at which contact begins outside the range: it follows the coordinate however far that goes; only
    /// stiffness levels out.
    #[cold]
    #[inline(never)]
    fn begins(&self, q: &Query, p: Weights<N>) -> Jet {
        let c = self.c.linear(q.center_distance_offset);
        let m = self.m.linear(q.misalignment);
        (self.no_load).field::<true, ANY>(Lanes::COMMON, &Point { c, m, p })
    }
}

impl<const N: usize> Framed<N> {
    #[inline(always)]
    pub fn none(&self) -> Potential {
        Potential {
            out_of_range: self.outside,
            ..Potential::default()
        }
    }

    #[inline(always)]
    fn scaled_gradient(&self, inverse: f64) -> [f64; 3] {
        let mut slopes = [0.0; 3];
        for i in 0..3 {
            if self.present[i] {
                slopes[i] = -(self.no_load.gradient[i] + self.u * self.span.gradient[i]) * inverse;
            }
        }
        slopes
    }

    /// W and its derivatives from w; y are its coordinates 1 to 3.
    #[inline(always)]
    pub fn potential<const H: bool>(&self, shape: &Shape) -> Potential {
        let (w, f, k) = (&shape.value, &shape.slope, shape.curvature);
        let (no_load, span) = (&self.no_load, &self.span);
        let s = span.value;
        let inverse = 1.0 / s;
        let mut out = Potential {
            value: s * w.value,
            ..self.none()
        };
        out.gradient[0] = f.value;
        out.hessian[0][0] = k * inverse;
        let complement = w.value - self.u * f.value;
        for i in 0..3 {
            if self.present[i] {
                // s du/dy = -(D0_y + u S_y) turns the chain rule into this.
                out.gradient[1 + i] = span.gradient[i] * complement - no_load.gradient[i] * f.value
                    + s * w.gradient[i];
            }
        }
        if H {
            let u_y = self.scaled_gradient(inverse);
            for i in (0..3).filter(|&i| self.present[i]) {
                let mixed = k * u_y[i] + f.gradient[i];
                out.hessian[0][1 + i] = mixed;
                out.hessian[1 + i][0] = mixed;
                for j in (i..3).filter(|&j| self.present[j]) {
                    let n = SECOND[i][j];
                    let second = span.second[n] * complement - no_load.second[n] * f.value
                        + span.gradient[i] * w.gradient[j]
                        + span.gradient[j] * w.gradient[i]
                        + s * (k * u_y[i] * u_y[j]
                            + f.gradient[i] * u_y[j]
                            + f.gradient[j] * u_y[i]
                            + w.second[n]);
                    out.hessian[1 + i][1 + j] = second;
                    out.hessian[1 + j][1 + i] = second;
                }
            }
        }
        out
    }

    /// Puts the slope of `shape`, a moment of its own, in the place of dW/dM.
    #[inline(always)]
    pub fn set_moment<const H: bool>(&self, out: &mut Potential, shape: &Shape) {
        let moment = &shape.slope;
        out.gradient[2] = moment.value;
        if H {
            let inverse = 1.0 / self.span.value;
            let u_y = self.scaled_gradient(inverse);
            out.hessian[2][0] = shape.curvature * inverse;
            for i in (0..3).filter(|&i| self.present[i]) {
                out.hessian[2][1 + i] = shape.curvature * u_y[i] + moment.gradient[i];
            }
        }
    }
}
