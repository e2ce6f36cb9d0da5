//! The coordinates but the displacement, and where the displacement begins at them: what all interpolants share.

use super::basis::{Basis, Weights};
use super::compiled::{present, weights};
use super::fit::Block;
use super::kernel::{Coefficients, Jet, field};
use super::lanes::{Registers, Two};
use crate::table::Query;

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
    /// Weights of centre distance.
    pub wc: Weights<N>,
    /// Weights of misalignment.
    pub wm: Weights<N>,
    /// Weights of mesh position.
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
        [
            present::<AXES, N>(0, &self.c),
            present::<AXES, N>(1, &self.m),
            present::<AXES, N>(2, &self.p),
        ]
    }

    /// Memory of the coefficients.
    pub fn bytes(&self) -> usize {
        self.fields.bytes()
    }

    /// At `q`, with second derivatives if `H`.
    #[inline(always)]
    pub fn at<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        q: &Query,
    ) -> Framed<N> {
        let mut at = registers.run(
            #[inline(always)]
            || self.inside::<H, AXES>(registers, q),
        );
        if at.outside {
            at.no_load = self.begins(q, at.wp);
        }
        at
    }

    #[inline(always)]
    fn inside<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        q: &Query,
    ) -> Framed<N> {
        let order = if H { 2 } else { 1 };
        let (wc, c_outside) =
            weights::<AXES, N>((0, &self.c), registers, q.center_distance_offset, order);
        let (wm, m_outside) = weights::<AXES, N>((1, &self.m), registers, q.misalignment, order);
        let (wp, _) = weights::<AXES, N>((2, &self.p), registers, q.mesh_position, order);
        Framed {
            no_load: field::<N, H, AXES>(registers, &self.fields, 0, &wc, &wm, &wp),
            span: field::<N, H, AXES>(registers, &self.fields, 1, &wc, &wm, &wp),
            wc,
            wm,
            wp,
            outside: c_outside || m_outside,
        }
    }

    /// The approach at which contact begins outside the range: it follows the coordinate however far that goes; only
    /// stiffness levels out.
    #[cold]
    #[inline(never)]
    fn begins(&self, q: &Query, wp: Weights<N>) -> Jet {
        let wc = self.c.linear(q.center_distance_offset);
        let wm = self.m.linear(q.misalignment);
        field::<N, true, { super::ANY }>(Two, &self.fields, 0, &wc, &wm, &wp)
    }
}
