//! What all interpolants do at a point: contraction of a block of coefficients with the weights of each coordinate, and the way
//! from the scaled displacement back to the coordinates of [`Query`].
//!
//! The mesh position is the fastest index, so its neighbouring coefficients fill vector registers and
//! nothing is summed across a register until the very end. The coordinates that only few sums need come first:
//! misalignment, then centre distance, then displacement.
//!
//! With the no-load approach D0 and the span S = D1 - D0 over y = (C, M, PMC):
//! u = (delta - D0) / S and W(delta, y) = S(y) w(u, y), hence F = dW/d delta = dw/du.

use super::basis::{Basis, Weights};
use crate::table::block::Block;
use crate::table::{Potential, Query};
use crate::vector::{Lanes, dot};

/// Axes that code finds out as it runs. A smaller number says that code is compiled for the axes of centre distance,
/// misalignment and mesh position whose bits 0 to 2 are set in it.
pub const ANY: usize = 8;

/// Weights of centre distance, misalignment and mesh position at one point.
#[derive(Debug, Clone, Copy)]
pub struct Point<const N: usize> {
    pub c: Weights<N>,
    pub m: Weights<N>,
    pub p: Weights<N>,
}

impl<const N: usize> Point<N> {
    #[inline(always)]
    fn counts<const AXES: usize>(&self) -> [usize; 2] {
        if AXES == ANY {
            [self.c.count, self.m.count]
        } else {
            [0, 1].map(|axis| if AXES >> axis & 1 == 1 { N } else { 1 })
        }
    }
}

/// Value and derivatives over (centre distance, misalignment, mesh position), the second ones CC, CM, CP, MM, MP, PP.
#[derive(Debug, Clone, Copy, Default)]
pub struct Jet {
    pub value: f64,
    pub gradient: [f64; 3],
    pub second: [f64; 6],
}

/// Where the second derivative by coordinates i and j stands in [`Jet::second`].
pub const SECOND: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

#[inline(always)]
fn put<const N: usize>(lanes: Lanes, time: usize, to: &mut [f64; N], factor: f64, from: &[f64; N]) {
    if time == 0 {
        *to = lanes.scaled(factor, from);
    } else {
        lanes.add(to, factor, from);
    }
}

/// Sums over centre distance and misalignment, still open along the mesh position: of the value and its derivatives C, M, CC, CM, MM.
type Plane<const N: usize> = [[f64; N]; 6];

/// Of `rows` from `start` on, `c` and `m` apart. `H`: with second derivatives.
#[inline(always)]
fn plane<const N: usize, const H: bool, const AXES: usize>(
    lanes: Lanes,
    rows: &[[f64; N]],
    [start, c, m]: [usize; 3],
    at: &Point<N>,
) -> Plane<N> {
    let (wc, wm) = (&at.c, &at.m);
    let [nc, nm] = at.counts::<AXES>();
    let mut sum = [[0.0; N]; 6];
    for i in 0..nc {
        let first = &rows[start + i * c];
        let mut a = lanes.scaled(wm.value[0], first);
        let mut a_m = lanes.scaled(wm.slope[0], first);
        let mut a_mm = lanes.scaled(wm.curvature[0], first);
        for j in 1..nm {
            let row = &rows[start + i * c + j * m];
            lanes.add(&mut a, wm.value[j], row);
            lanes.add(&mut a_m, wm.slope[j], row);
            if H {
                lanes.add(&mut a_mm, wm.curvature[j], row);
            }
        }
        put(lanes, i, &mut sum[0], wc.value[i], &a);
        put(lanes, i, &mut sum[1], wc.slope[i], &a);
        put(lanes, i, &mut sum[2], wc.value[i], &a_m);
        if H {
            put(lanes, i, &mut sum[3], wc.curvature[i], &a);
            put(lanes, i, &mut sum[4], wc.slope[i], &a_m);
            put(lanes, i, &mut sum[5], wc.value[i], &a_mm);
        }
    }
    sum
}

#[inline(always)]
fn jet<const N: usize, const H: bool>(plane: &Plane<N>, wp: &Weights<N>) -> Jet {
    let along = |n: usize| dot(&plane[n], &wp.value);
    let mut jet = Jet {
        value: along(0),
        gradient: [along(1), along(2), dot(&plane[0], &wp.slope)],
        ..Jet::default()
    };
    if H {
        let [c_p, m_p] = [1, 2].map(|n| dot(&plane[n], &wp.slope));
        let p_p = dot(&plane[0], &wp.curvature);
        jet.second = [along(3), along(4), c_p, along(5), m_p, p_p];
    }
    jet
}

/// A block of coefficients `[c][m][row][mesh position]`, rows as long as whole groups of N lanes.
#[derive(Debug, Clone)]
pub struct Coefficients<const N: usize> {
    values: Vec<f64>,
    /// Distances from one c, m and row to the next, in groups; short, so that sums of a few cannot overflow and
    /// one check serves a whole cell.
    strides: [u32; 3],
}

impl<const N: usize> Coefficients<N> {
    pub fn new(block: &Block) -> Self {
        let [_, nm, rows, np] = block.lengths;
        let groups = np.div_ceil(N);
        let stride = |n: usize| u32::try_from(n).expect("a table fits into memory");
        let mut values = Vec::with_capacity(block.values.len() / np * groups * N);
        for row in block.values.chunks_exact(np) {
            values.extend_from_slice(row);
            values.resize(values.len().next_multiple_of(N), 0.0);
        }
        let strides = [groups * rows * nm, groups * rows, groups].map(stride);
        Coefficients { values, strides }
    }

    pub fn bytes(&self) -> usize {
        8 * self.values.len()
    }

    /// The lanes of every row from the first functions of `at` and `u` on, and the distances from one c, m and u to the next;
    /// the last of `count` functions of u lies within.
    #[inline(always)]
    fn cell<const AXES: usize>(
        &self,
        at: &Point<N>,
        u: usize,
        count: usize,
    ) -> (&[[f64; N]], [usize; 3]) {
        let strides @ [dc, dm, du] = self.strides.map(|x| x as usize);
        let (rows, _) = self.values[at.p.first..].as_chunks();
        let rows = &rows[at.c.first * dc + at.m.first * dm + u * du..];
        let [nc, nm] = at.counts::<AXES>();
        assert!((nc - 1) * dc + (nm - 1) * dm + (count - 1) * du < rows.len());
        (rows, strides)
    }

    #[inline(always)]
    pub fn field<const H: bool, const AXES: usize>(&self, lanes: Lanes, at: &Point<N>) -> Jet {
        let (rows, [c, m, _]) = self.cell::<AXES>(at, 0, 1);
        jet::<N, H>(&plane::<N, H, AXES>(lanes, rows, [0, c, m], at), &at.p)
    }

    /// A quantity over the displacement, at the weights `wu` of it.
    #[inline(always)]
    pub fn shape<const NU: usize, const H: bool, const AXES: usize>(
        &self,
        lanes: Lanes,
        wu: &Weights<NU>,
        at: &Point<N>,
    ) -> Shape {
        let (rows, [c, m, u]) = self.cell::<AXES>(at, wu.first, NU);
        let [mut w, mut f] = [[[0.0; N]; 6]; 2];
        let mut k = [0.0; N];
        for r in 0..NU {
            let plane = plane::<N, H, AXES>(lanes, rows, [r * u, c, m], at);
            for n in 0..if H { 6 } else { 3 } {
                put(lanes, r, &mut w[n], wu.value[r], &plane[n]);
            }
            for n in 0..if H { 3 } else { 1 } {
                put(lanes, r, &mut f[n], wu.slope[r], &plane[n]);
            }
            put(lanes, r, &mut k, wu.curvature[r], &plane[0]);
        }
        Shape {
            value: jet::<N, H>(&w, &at.p),
            slope: jet::<N, false>(&f, &at.p),
            curvature: dot(&k, &at.p.value),
        }
    }
}

/// A quantity over the displacement, its slope and second derivative by that, as the chain rule needs them; second derivatives of
/// the quantity and first ones of the slope only with `H`.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    pub value: Jet,
    pub slope: Jet,
    pub curvature: f64,
}

/// Axes of centre distance, misalignment and mesh position, and what the scaled displacement is measured by along them.
#[derive(Debug, Clone)]
pub struct Frame<const N: usize> {
    pub c: Basis<N>,
    pub m: Basis<N>,
    pub p: Basis<N>,
    pub no_load: Coefficients<N>,
    pub span: Coefficients<N>,
    /// How far the span goes on beyond the ends of `c` and `m`; the shape goes as far as these say themselves.
    pub span_levelling: [[f64; 2]; 2],
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
        let mut span = self.span.field::<H, AXES>(lanes, &weights);
        if outside {
            no_load = self.beyond(&self.no_load, q, p, [[f64::INFINITY; 2]; 2]);
            span = self.beyond(&self.span, q, p, self.span_levelling);
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

    /// `field` outside the range, where it goes on as far as `levelling_length` says.
    #[cold]
    #[inline(never)]
    fn beyond(
        &self,
        field: &Coefficients<N>,
        q: &Query,
        p: Weights<N>,
        levelling_length: [[f64; 2]; 2],
    ) -> Jet {
        let c = self
            .c
            .levelling_within(q.center_distance_offset, levelling_length[0]);
        let m = self.m.levelling_within(q.misalignment, levelling_length[1]);
        field.field::<true, ANY>(Lanes::COMMON, &Point { c, m, p })
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
