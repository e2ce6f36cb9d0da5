//! The coordinates but the displacement, and where the displacement begins at them: what all interpolants share.

use super::basis::{Basis, Weights};
use super::fit::Block;
use super::kernel::{ANY, Coefficients, Jet, field};
use crate::table::Query;
use crate::vector::Lanes;

/// Axes of centre distance, misalignment and mesh position, and what the scaled displacement is measured by along them.
#[derive(Debug, Clone)]
pub struct Frame<const N: usize> {
    pub c: Basis<N>,
    pub m: Basis<N>,
    pub p: Basis<N>,
    /// Row 0: the approach at which contact begins; row 1: the span from there to the top load.
    fields: Coefficients<N>,
}

/// A [`Frame`] at one point.
pub struct Framed<const N: usize> {
    /// Weights of centre distance, misalignment and mesh position.
    pub wc: Weights<N>,
    pub wm: Weights<N>,
    pub wp: Weights<N>,
    /// The approach at which contact begins, m.
    pub no_load: Jet,
    /// From there to the top load, m.
    pub span: Jet,
    /// Whether the point is outside the range of centre distance or misalignment.
    pub outside: bool,
}

impl<const N: usize> Frame<N> {
    /// From the bases of centre distance, misalignment and mesh position and the coefficients of no-load approach and
    /// span over them.
    pub fn new([c, m, p]: [Basis<N>; 3], fields: &Block) -> Self {
        Frame {
            c,
            m,
            p,
            fields: Coefficients::new(fields),
        }
    }

    /// Which of centre distance, misalignment and mesh position are axes.
    #[inline(always)]
    pub fn present<const AXES: usize>(&self) -> [bool; 3] {
        if AXES == ANY {
            [self.c.present(), self.m.present(), self.p.present()]
        } else {
            [AXES & 1 != 0, AXES & 2 != 0, AXES & 4 != 0]
        }
    }

    /// The same as bits, for code that is compiled for them.
    pub fn axes(&self) -> usize {
        let [c, m, p] = self.present::<ANY>().map(usize::from);
        c | m << 1 | p << 2
    }

    /// Memory of the coefficients.
    pub fn bytes(&self) -> usize {
        self.fields.bytes()
    }

    /// At `q`, with second derivatives if `H`.
    #[inline(always)]
    pub fn at<const H: bool, const AXES: usize>(&self, lanes: Lanes, q: &Query) -> Framed<N> {
        let order = if H { 2 } else { 1 };
        let [c, m, p] = self.present::<AXES>();
        let (wc, c_outside) = weights(c, &self.c, lanes, q.center_distance_offset, order);
        let (wm, m_outside) = weights(m, &self.m, lanes, q.misalignment, order);
        let (wp, _) = weights(p, &self.p, lanes, q.mesh_position, order);
        let mut at = Framed {
            no_load: field::<N, H, AXES>(lanes, &self.fields, 0, &wc, &wm, &wp),
            span: field::<N, H, AXES>(lanes, &self.fields, 1, &wc, &wm, &wp),
            wc,
            wm,
            wp,
            outside: c_outside || m_outside,
        };
        if at.outside {
            at.no_load = self.begins(q, at.wp);
        }
        at
    }

    /// The approach at which contact begins outside the range: it follows the coordinate however far that goes; only
    /// stiffness levels out.
    #[cold]
    #[inline(never)]
    fn begins(&self, q: &Query, wp: Weights<N>) -> Jet {
        let wc = self.c.linear(q.center_distance_offset);
        let wm = self.m.linear(q.misalignment);
        field::<N, true, ANY>(Lanes::COMMON, &self.fields, 0, &wc, &wm, &wp)
    }
}

/// [`Basis::weights`] of an axis that is `present`.
#[inline(always)]
fn weights<const N: usize>(
    present: bool,
    basis: &Basis<N>,
    lanes: Lanes,
    x: f64,
    order: usize,
) -> (Weights<N>, bool) {
    if present {
        basis.weights(lanes, x, order)
    } else {
        (Weights::constant(), false)
    }
}
