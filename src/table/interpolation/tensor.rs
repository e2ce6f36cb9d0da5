//! Tensor-product interpolants, linear and C2, of any number of dimensions: one potential each.
//!
//! The force over the scaled displacement u is a B-spline whose coefficients vanish before u = 0 and
//! never decrease over u: it is exactly zero out of contact, as smooth at the onset as elsewhere, and
//! monotone for any (C, M, PMC), since the functions of those are non-negative and add up to one. Its
//! integral over u is again a B-spline, one degree higher; only that one is stored, and force, shuttling
//! and the other gradients are its derivatives.

use super::basis::{Basis, Ends};
use super::fit::{Block, Fit, breaks, integrated, make_increasing};
use super::frame::{Frame, Framed};
use super::kernel::{Coefficients, Jet, over_displacement};
use super::lanes::Registers;
use super::line::Line;
use super::{Checks, Evaluate, chain, continuation};
use crate::table::{FlankGrid, Potential, Query, TableError};

/// `NU` functions at one displacement, `N` at one point of each other coordinate: spline 5 and 4, linear 3 and 2. A
/// coordinate without an axis has one.
#[derive(Debug, Clone)]
pub struct Tensor<const NU: usize, const N: usize> {
    u: Basis<NU>,
    frame: Frame<N>,
    /// w over (c, m, u, mesh position).
    shape: Coefficients<N>,
    /// Integral over u of the moment, likewise, where it is not dW/dM.
    moment: Option<Coefficients<N>>,
    /// Below it there is no contact anywhere inside the range: less than every coefficient of the no-load approach.
    no_contact: f64,
    /// Potential and moment without any other coordinate, for u up to 1.
    lines: Option<Vec<Line<NU>>>,
    checks: Checks,
}

/// The force's own basis, one degree below the potential's, has one function fewer; const generics
/// cannot say NU - 1, so `NF` is a parameter of the constructor.
impl<const NU: usize, const N: usize> Tensor<NU, N> {
    /// Fits the samples of one flank.
    pub fn new<const NF: usize>(grid: &FlankGrid) -> Result<Self, TableError> {
        assert_eq!(NF + 1, NU, "the potential is one degree above the force");
        let axes = &grid.axes;
        let u_breaks = breaks(&axes.displacement_fraction, NF - 1, Ends::Onset);
        let force_basis = Basis::<NF>::new(&u_breaks, Ends::Onset);
        let mut c = axis_basis::<N>(&axes.center_distance_offset, Ends::Bounded);
        let mut m = axis_basis::<N>(&axes.misalignment, Ends::Bounded);
        let p = axis_basis::<N>(&axes.mesh_position, Ends::Periodic);
        let along = [
            Fit::new(
                &c,
                &axes.center_distance_offset,
                Ends::Bounded,
                "center_distance_offset_m",
            )?,
            Fit::new(&m, &axes.misalignment, Ends::Bounded, "misalignment_rad")?,
            Fit::new(
                &force_basis,
                &axes.displacement_fraction,
                Ends::Onset,
                "displacement_fraction",
            )?,
            Fit::new(&p, &axes.mesh_position, Ends::Periodic, "mesh_position")?,
        ];
        let fit = |block: Block, u_axis: bool| {
            along.iter().enumerate().fold(block, |b, (axis, fit)| {
                if axis == 2 && !u_axis {
                    b
                } else {
                    fit.along(axis, &b)
                }
            })
        };

        let mut force = fit(grid.force_block(), true);
        let top = grid.top_force();
        let mut checks = Checks::default();
        let least = least_increments(&force, NF - 1);
        let stride = force.stride(2);
        for start in force.lines(2) {
            let index = |r: usize| start + r * stride;
            let mut line: Vec<f64> = (0..force.lengths[2])
                .map(|r| force.values[index(r)])
                .collect();
            let degree = NF - 1;
            for j in 0..line.len() - degree {
                // B-spline coefficients of dF/du, which bound it from below (de Boor, X (15)).
                let width = u_breaks[(j + degree).min(u_breaks.len() - 1)] - u_breaks[j];
                let slope = (line[degree + j] - line[degree + j - 1]) * degree as f64 / width;
                checks.minimum_slope = checks.minimum_slope.min(slope / top);
            }
            let change = make_increasing(&mut line[NF - 1..], &least);
            checks.monotone_correction = checks.monotone_correction.max(change / top);
            for (r, v) in line.into_iter().enumerate() {
                force.values[index(r)] = v;
            }
        }
        let shape = integrate(&force, &u_breaks, NF - 1);
        let moment = grid
            .moment_block()
            .filter(|_| !m.present())
            .map(|b| integrate(&fit(b, true), &u_breaks, NF - 1));
        let fields = fit(grid.field_block(), false);
        continuation::limit(&mut c, &mut m, &continuation::spans(&fields), Some(&force))?;
        let u = Basis::new(&u_breaks, Ends::Onset);
        let alone = ![&c, &m, &p].into_iter().any(Basis::present);
        let line = |b: &Block| Line::new(&u, &b.values);
        Ok(Tensor {
            lines: alone.then(|| [&shape].into_iter().chain(&moment).map(line).collect()),
            u,
            shape: Coefficients::new(&shape),
            moment: moment.as_ref().map(Coefficients::new),
            no_contact: below_all(&fields),
            frame: Frame::new([c, m, p], &fields),
            checks,
        })
    }

    /// All but what depends on the displacement.
    pub fn into_frame(self) -> Frame<N> {
        self.frame
    }

    /// What `coefficients` have over the displacement at `u` and `at`.
    #[inline(always)]
    fn over<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        coefficients: &Coefficients<N>,
        u: f64,
        at: &Framed<N>,
    ) -> ([Jet; 3], f64) {
        registers.run(
            #[inline(always)]
            || {
                let (wu, _) = self.u.weights(registers, u, if H { 3 } else { 2 });
                over_displacement::<NU, N, H, AXES>(
                    registers,
                    coefficients,
                    &wu,
                    &at.wc,
                    &at.wm,
                    &at.wp,
                )
            },
        )
    }
}

impl<const NU: usize, const N: usize> Evaluate for Tensor<NU, N> {
    const WIDE: bool = N == 4;

    #[inline(always)]
    fn at<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        q: &Query,
    ) -> Potential {
        // The flank that does not carry, as a rule.
        if q.delta < self.no_contact
            && self.frame.c.holds(q.center_distance_offset)
            && self.frame.m.holds(q.misalignment)
        {
            return Potential::default();
        }
        let present = self.frame.present::<AXES>();
        let at = self.frame.at::<H, AXES>(registers, q);
        let (no_load, span, outside) = (&at.no_load, &at.span, at.outside);
        let u = (q.delta - no_load.value) / span.value;
        if u <= 0.0 {
            return Potential {
                out_of_range: outside,
                ..Potential::default()
            };
        }
        if let Some(lines) = &self.lines
            && u <= 1.0
        {
            let (cell, t, scale) = self.u.local(u);
            let (shape, third) = lines[0].at(cell, t, scale);
            let mut out = chain::potential::<H>(u, &shape, third, no_load, span, present);
            if let Some(moment) = lines.get(1) {
                let (shape, _) = moment.at(cell, t, scale);
                chain::set_moment::<H>(&mut out, u, &shape, no_load, span, present);
            }
            return out;
        }
        let (shape, third) = self.over::<H, AXES>(registers, &self.shape, u, &at);
        let mut out = chain::potential::<H>(u, &shape, third, no_load, span, present);
        if let Some(moment) = &self.moment {
            let (shape, _) = self.over::<H, AXES>(registers, moment, u, &at);
            chain::set_moment::<H>(&mut out, u, &shape, no_load, span, present);
        }
        out.out_of_range = outside || self.u.is_outside(u);
        out
    }

    fn checks(&self) -> Checks {
        self.checks
    }

    fn bytes(&self) -> usize {
        let moment = self.moment.as_ref().map_or(0, Coefficients::bytes);
        let lines = self.lines.iter().flatten().map(Line::bytes).sum::<usize>();
        self.shape.bytes() + self.frame.bytes() + moment + lines
    }
}

/// Basis of an axis that is not the displacement.
pub fn axis_basis<const N: usize>(nodes: &[f64], ends: Ends) -> Basis<N> {
    if nodes.len() == 1 {
        // A single point: the nodes say where, nothing depends on it.
        return Basis::new(&[], ends);
    }
    Basis::new(&breaks(nodes, N - 1, ends), ends)
}

/// A value below the spline of the first of two rows of `fields`, which stays above its least coefficient, by more
/// than its rounding.
fn below_all(fields: &Block) -> f64 {
    let row = fields.stride(2);
    let values = fields.values.chunks(2 * row).flat_map(|c| &c[..row]);
    let (least, largest) = values.fold((f64::INFINITY, 0.0_f64), |(least, largest), &v| {
        (least.min(v), largest.max(v.abs()))
    });
    least - 1e-12 * largest
}

/// Least increments of the force from one coefficient over u to the next: a hundredth of the mean ones. Without,
/// coefficients that are equal over a stretch would leave no room for a continuation beyond the ends of C and M
/// that has a continuous slope and does not fall over u.
fn least_increments(force: &Block, degree: usize) -> Vec<f64> {
    let (n, stride) = (force.lengths[2], force.stride(2));
    let lines = force.values.len() / n;
    let mean = |r: usize| {
        let sum: f64 = force
            .lines(2)
            .map(|start| force.values[start + r * stride])
            .sum();
        sum / lines as f64
    };
    (degree..n)
        .map(|r| {
            let before = if r == degree { 0.0 } else { mean(r - 1) };
            0.01 * (mean(r) - before).max(0.0)
        })
        .collect()
}

fn integrate(force: &Block, breaks: &[f64], degree: usize) -> Block {
    let mut lengths = force.lengths;
    lengths[2] += 1;
    let mut out = Block::zeros(lengths);
    let (from_stride, to_stride) = (force.stride(2), out.stride(2));
    for (from, to) in force.lines(2).zip(out.lines(2)) {
        let line: Vec<f64> = (0..force.lengths[2])
            .map(|r| force.values[from + r * from_stride])
            .collect();
        for (r, v) in integrated(&line, breaks, degree).into_iter().enumerate() {
            out.values[to + r * to_stride] = v;
        }
    }
    out
}
