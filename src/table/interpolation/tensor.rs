//! Tensor-product interpolants, linear and C2, of any number of dimensions: one potential each.
//!
//! The force over the scaled displacement u is a B-spline whose coefficients vanish before u = 0 and never decrease over u: it is
//! exactly zero out of contact, as smooth at the onset as elsewhere, and monotone for any (C, M, PMC), since the functions of
//! those are non-negative and add up to one. Its integral over u is a B-spline one degree higher; only that one is stored, and
//! force, shuttling and the other gradients are its derivatives.
//!
//! Beyond an end of C or M every coefficient goes on with its slope there and levels out at twice the guard distance
//! ([`Basis::guard`]): the force has a continuous slope and its stiffness, far out, a constant value. A guard is as long as the span
//! keeps at least half of its least value and no force decreases over the displacement.

use super::basis::{Basis, Ends};
use super::fit::{Others, axis, breaks, integrated, make_increasing};
use super::kernel::{ANY, Coefficients, Frame, Framed, Shape};
use crate::root::bisection;
use crate::table::block::Block;
use crate::table::error::refused;
use crate::table::{Axis, FlankGrid, Potential, Query, TableError};
use crate::vector::Lanes;

/// `NU` functions at one displacement, `N` at one point of each other coordinate: spline 5 and 4, linear 3 and 2. A
/// coordinate without an axis has one.
#[derive(Debug, Clone)]
pub struct Tensor<const NU: usize, const N: usize> {
    u: Basis<NU>,
    pub frame: Frame<N>,
    shape: Coefficients<N>,
    /// Integral over u of the moment, likewise, where it is not dW/dM.
    moment: Option<Coefficients<N>>,
    /// Below it there is no contact anywhere inside the range: less than every coefficient of the no-load approach.
    no_contact: f64,
    /// Largest u that is within the range.
    top: f64,
}

/// B-spline coefficients of what a [`Tensor`] is made of, over (c, m, u, mesh position).
struct Parts<'a> {
    u_breaks: &'a [f64],
    force: Block,
    moment: Option<Block>,
    no_load: Block,
    span: Block,
    top: f64,
}

impl<const NU: usize, const N: usize> Tensor<NU, N> {
    /// Fits the samples of one flank. The force's own basis, one degree below the potential's, has one function fewer;
    /// const generics cannot say NU - 1, so `NF` is a parameter.
    pub fn new<const NF: usize>(grid: &FlankGrid) -> Result<Self, TableError> {
        let degree = NF - 1;
        let nodes = &grid.axes.displacement_fraction;
        let (_, along_u) = axis::<NF>(nodes, Ends::Onset, Axis::Displacement.name())?;
        let others = Others::<N>::new(grid.axes.nodes())?;
        let along_all = |samples: &[f64]| others.fit(&grid.block(samples), Some(&along_u));
        let force = along_all(&grid.loa_force);
        let least = least_increments(&force, degree);
        let force = force.mapped(2, force.lengths[2], |mut line| {
            make_increasing(&mut line[degree..], &least);
            line
        });
        let own_moment = (grid.moment.as_ref()).filter(|_| grid.axes.misalignment.len() == 1);
        let [no_load, span] = grid.fields().map(|field| others.fit(&field, None));
        let parts = Parts {
            u_breaks: &breaks(nodes, degree, Ends::Onset),
            force,
            moment: own_moment.map(|moment| along_all(moment)),
            no_load,
            span,
            top: 1.0,
        };
        Self::assembled(others.bases, parts)
    }

    fn assembled([mut c, mut m, p]: [Basis<N>; 3], parts: Parts<'_>) -> Result<Self, TableError> {
        let integral = |block: &Block| {
            let integral = |line: Vec<f64>| integrated(&line, parts.u_breaks, NU - 2);
            Coefficients::new(&block.mapped(2, block.lengths[2] + 1, integral))
        };
        limit_guards(&mut c, &mut m, &parts.span, &parts.force)?;
        let values = parts.no_load.values.iter();
        let largest = values.clone().fold(0.0, |l: f64, v| l.max(v.abs()));
        let least = values.copied().fold(f64::INFINITY, f64::min);
        Ok(Tensor {
            u: Basis::new(parts.u_breaks, Ends::Onset),
            shape: integral(&parts.force),
            moment: parts.moment.as_ref().map(integral),
            // The spline stays above its least coefficient but for rounding.
            no_contact: least - 1e-12 * largest,
            frame: Frame {
                c,
                m,
                p,
                no_load: Coefficients::new(&parts.no_load),
                span: Coefficients::new(&parts.span),
            },
            top: parts.top,
        })
    }

    pub fn bytes(&self) -> usize {
        let moment = self.moment.as_ref().map_or(0, Coefficients::bytes);
        self.shape.bytes() + self.frame.bytes() + moment
    }

    /// See [`FlankTable::evaluate`](super::FlankTable::evaluate). Values are compiled for the usual axes and registers; all else
    /// shares one evaluation, since each more would cost seconds of every build.
    pub fn evaluate(&self, lanes: Lanes, q: &Query, want_hessian: bool) -> Potential {
        match self.frame.axes() {
            _ if want_hessian => self.compiled::<true, ANY>(lanes, q),
            0 => self.compiled::<false, 0>(lanes, q),
            4 if lanes.are_wide() => self.compiled::<false, 4>(lanes, q),
            5 if lanes.are_wide() => self.compiled::<false, 5>(lanes, q),
            6 if lanes.are_wide() => self.compiled::<false, 6>(lanes, q),
            7 if lanes.are_wide() => self.compiled::<false, 7>(lanes, q),
            _ => self.compiled::<false, ANY>(lanes, q),
        }
    }

    #[inline(always)]
    fn compiled<const H: bool, const AXES: usize>(&self, lanes: Lanes, q: &Query) -> Potential {
        lanes.run(
            #[inline(always)]
            |lanes| self.at::<H, AXES>(lanes, q),
        )
    }

    #[inline(always)]
    fn at<const H: bool, const AXES: usize>(&self, lanes: Lanes, q: &Query) -> Potential {
        // The flank that does not carry, as a rule.
        if q.delta < self.no_contact
            && self.frame.c.holds(q.center_distance_offset)
            && self.frame.m.holds(q.misalignment)
        {
            return Potential::default();
        }
        let at = self.frame.at::<H, AXES>(lanes, q);
        if at.u <= 0.0 {
            return at.none();
        }
        let mut out = at.potential::<H>(&self.over::<H, AXES>(lanes, &self.shape, &at));
        if let Some(moment) = &self.moment {
            at.set_moment::<H>(&mut out, &self.over::<H, AXES>(lanes, moment, &at));
        }
        out.out_of_range |= at.u > self.top;
        out
    }

    #[inline(always)]
    fn over<const H: bool, const AXES: usize>(
        &self,
        lanes: Lanes,
        coefficients: &Coefficients<N>,
        at: &Framed<N>,
    ) -> Shape {
        let (wu, _) = self.u.weights(lanes, at.u, 2);
        coefficients.shape::<NU, H, AXES>(lanes, &wu, &at.weights)
    }
}

impl<const N: usize> Tensor<3, N> {
    /// Constant load, see [`FlankTable::constant_load`](super::FlankTable::constant_load): W = F (delta - O)² / (2 (STE - O)),
    /// that is S w(u) with u = (delta - O) / S, S = STE - O, w = F u² / 2. STE and lever at F are found at the nodes by inversion of
    /// the spline over the displacement.
    pub fn constant_load(grid: &FlankGrid, loa_force: f64) -> Result<Self, TableError> {
        let nodes = &grid.axes.displacement_fraction;
        let (basis, fit) = axis::<4>(nodes, Ends::Onset, Axis::Displacement.name())?;
        let along_u = |samples: &Vec<f64>| fit.along(2, &grid.block(samples));
        let force = along_u(&grid.loa_force);
        let moment = grid.moment.as_ref().map(along_u);
        let spline = |block: &Block, start: usize, u: f64| {
            let w = basis.inside(u);
            let coefficient = |k: usize| block.values[start + (w.first + k) * block.stride(2)];
            (0..4).map(|k| w.value[k] * coefficient(k)).sum::<f64>()
        };
        let field = "nominalTorque";
        let value = format!("{loa_force} N on the line of action");
        let shifts = grid.touch_shift()?;
        let [mut origin, mut span] = grid.fields();
        let mut lever = moment.as_ref().map(|_| origin.clone());
        for (column, start) in force.lines(2).enumerate() {
            let top = spline(&force, start, 1.0);
            if !(loa_force > 0.0 && loa_force <= top * (1.0 + 1e-9)) {
                let reason = format!(
                    "the table holds forces above 0 up to {top} N; choose a torque in this range or make tables with a larger \
                     maximum_torque_nm"
                );
                return refused(field, value, reason);
            }
            let u = bisection([0.0, 1.0], 60, |u| spline(&force, start, u) < loa_force);
            let ste = origin.values[column] + u * span.values[column];
            let shift = shifts[column / grid.axes.mesh_position.len()];
            origin.values[column] = shift;
            span.values[column] = ste - shift;
            if let (Some(lever), Some(moment)) = (&mut lever, &moment) {
                lever.values[column] = spline(moment, start, u) / loa_force;
            }
        }
        let others = Others::<N>::new(grid.axes.nodes())?;
        let [no_load, span] = [origin, span].map(|field| others.fit(&field, None));
        if span.values.iter().any(|&span| span <= 0.0) {
            let reason = "STE at this load is not positive everywhere, so there is no secant stiffness; raise nominalTorque or set \
                          loadDependent = true";
            return refused(field, value, reason);
        }
        let line = |lever: Vec<f64>| vec![0.0, loa_force * lever[0]];
        let parts = Parts {
            u_breaks: &[0.0, 1.0],
            force: span.mapped(2, 2, |_| vec![0.0, loa_force]),
            moment: lever.map(|lever| others.fit(&lever, None).mapped(2, 2, line)),
            no_load,
            span,
            top: f64::INFINITY,
        };
        Self::assembled(others.bases, parts)
    }
}

/// Least increments of the force from one coefficient over u to the next: a hundredth of the mean ones. Without,
/// coefficients that are equal over a stretch would leave no room for a continuation beyond the ends of C and M
/// that has a continuous slope and does not fall over u.
fn least_increments(force: &Block, degree: usize) -> Vec<f64> {
    let (n, stride) = (force.lengths[2], force.stride(2));
    let lines = force.values.len() / n;
    let mean = |r: usize| {
        let values = (force.lines(2)).map(|start| force.values[start + r * stride]);
        values.sum::<f64>() / lines as f64
    };
    let increment = |r: usize| {
        let before = if r == degree { 0.0 } else { mean(r - 1) };
        0.01 * (mean(r) - before).max(0.0)
    };
    (degree..n).map(increment).collect()
}

/// A guard halved this often is shorter than any coordinate can tell: never reached, since spans are positive
/// and forces increase strictly within the range ([`make_increasing`]).
const HALVINGS: usize = 50;

/// Shortens the guards of `c` and `m`, each end by itself, until `span` and the coefficients `force` over u stay legal beyond
/// each end of each axis and beyond both at once.
fn limit_guards<const N: usize>(
    c: &mut Basis<N>,
    m: &mut Basis<N>,
    span: &Block,
    force: &Block,
) -> Result<(), TableError> {
    let least = span.values.iter().copied().fold(f64::INFINITY, f64::min);
    if least <= 0.0 {
        return Err(TableError::TooCoarse { least_m: least });
    }
    // Where the axes 0 and 1 have levelled out beyond the ends given.
    let is_legal = |axes: [&Basis<N>; 2], ends: [Option<usize>; 2]| {
        let far_out = |block: &Block| {
            let mut block = block.clone();
            for (axis, (basis, end)) in axes.into_iter().zip(ends).enumerate() {
                if let Some(row) = end.map(|end| basis.far_end(end)) {
                    let far = |line: Vec<f64>| row.iter().zip(line).map(|(w, x)| w * x).sum();
                    block = block.mapped(axis, 1, |line| vec![far(line)]);
                }
            }
            block
        };
        let force = far_out(force);
        let increases = |start: usize| {
            let line = force.values[start..].iter().step_by(force.stride(2));
            line.take(force.lengths[2]).is_sorted()
        };
        far_out(span).values.iter().all(|&v| v >= 0.5 * least) && force.lines(2).all(increases)
    };
    // What is linear in either coordinate is extreme at the corners: legal there, legal between.
    let (low, high) = (Some(0), Some(1));
    let beyond_one = [[low, None], [None, low], [high, None], [None, high]];
    let beyond_both = [[low, low], [low, high], [high, low], [high, high]];
    for ends in beyond_one.into_iter().chain(beyond_both) {
        if ends[0].is_some() && !c.present() || ends[1].is_some() && !m.present() {
            continue;
        }
        for _ in 0..HALVINGS {
            if is_legal([c, m], ends) {
                break;
            }
            for (basis, end) in [&mut *c, &mut *m].into_iter().zip(ends) {
                if let Some(end) = end {
                    basis.guard[end] *= 0.5;
                }
            }
        }
    }
    Ok(())
}
