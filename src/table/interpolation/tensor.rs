//! Tensor-product interpolants, linear and C2, of any number of dimensions: one potential each.
//!
//! The force over the scaled displacement u is a B-spline whose coefficients vanish before u = 0 and never decrease over u: it is
//! exactly zero out of contact, as smooth at the onset as elsewhere, and monotone for any (C, M, PMC), since the functions of
//! those are non-negative and add up to one. Its integral over u is a B-spline one degree higher; only that one is stored, and
//! force, shuttling and the other gradients are its derivatives.
//!
//! Beyond an end of C or M the onset of contact goes on linearly, and span and shape with a slope that falls evenly to zero, so
//! that loads and their slopes are continuous and far out the resultant is where the teeth touch first. Teeth that touch over a part
//! of the face only set the pace: along a wedge the span grows with the root of the misalignment. The fit
//! sees to it that no force decreases over the displacement there ([`keep_increasing_beyond`]); a span that falls levels out sooner.

use super::basis::{Basis, Ends};
use super::fit::{Others, axis, breaks, integrated, least, make_increasing};
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
        let force = force.mapped(2, force.lengths[2], |mut line| {
            make_increasing(&mut line[degree..]);
            line
        });
        let mut bases = others.bases.clone();
        // Those of centre distance and misalignment.
        for (axis, basis) in bases[..2].iter_mut().enumerate() {
            basis.levelling_length = [SHAPE_LEVELLING * basis.range(); 2];
            shorten_levelling(basis, axis, &force);
        }
        let force = keep_increasing_beyond(&bases, &force);
        let own_moment = (grid.moment.as_ref()).filter(|_| grid.axes.misalignment.len() == 1);
        let fields = grid.fields();
        let [no_load, span] = fields.each_ref().map(|field| others.fit(field, None));
        let least_m = least(&span);
        if least_m <= 0.0 {
            let axis = others.falls_along(&fields[1]);
            return Err(TableError::TooCoarse { least_m, axis });
        }
        let parts = Parts {
            u_breaks: &breaks(nodes, degree, Ends::Onset),
            force,
            moment: own_moment.map(|moment| along_all(moment)),
            no_load,
            span,
            top: 1.0,
        };
        Self::assembled(bases, parts)
    }

    fn assembled([c, m, p]: [Basis<N>; 3], parts: Parts<'_>) -> Result<Self, TableError> {
        let integral = |block: &Block| {
            let integral = |line: Vec<f64>| integrated(&line, parts.u_breaks, NU - 2);
            Coefficients::new(&block.mapped(2, block.lengths[2] + 1, integral))
        };
        let span_levelling = span_levelling([&c, &m], &parts.span);
        let values = parts.no_load.values.iter();
        let largest = values.fold(0.0, |l: f64, v| l.max(v.abs()));
        let least = least(&parts.no_load);
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
                span_levelling,
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

/// How far beyond an end of C or M the shape and the span have levelled out, in ranges of the axis. Measured against contact solves
/// at up to half the largest misalignment beyond it, where the resultant moves on as far as the face lasts.
const SHAPE_LEVELLING: f64 = 0.5;
const SPAN_LEVELLING: f64 = 1.25;

/// How often the levelling length of the shape is halved where the fit would have to give up more than this share of the largest force for it: at an
/// end far beyond the deflection of the teeth, where they barely touch.
const HALVINGS: i32 = 6;
const MOST_GIVEN_UP: f64 = 4e-3;

/// An end of a bounded axis: its last coefficient, the one before, and how many times their difference the continuation adds
/// to the last one until it has levelled out.
struct End {
    last: usize,
    before: usize,
    gain: f64,
}

fn ends<const N: usize>(basis: &Basis<N>, n: usize) -> Vec<End> {
    let end = |end: usize, last, before| End {
        last,
        before,
        // A little more than it adds, so that rounding takes nothing below zero.
        gain: (1.0 + 1e-9) * 0.5 * basis.levelling_length[end] * basis.steepness(end),
    };
    match basis.present() {
        true => vec![end(0, 0, 1), end(1, n - 1, n - 2)],
        false => Vec::new(),
    }
}

/// Halves the levelling length of `basis`, that of `axis`, at an end where [`keep_increasing_beyond`] would change the coefficients `force` over u by
/// more than [`MOST_GIVEN_UP`].
fn shorten_levelling<const N: usize>(basis: &mut Basis<N>, axis: usize, force: &Block) {
    let largest = force.values.iter().copied().fold(0.0, f64::max);
    let (over, along_u, n) = (force.stride(axis), force.stride(2), force.lengths[2]);
    for k in 0..ends(basis, force.lengths[axis]).len() {
        for _ in 0..HALVINGS {
            let end = &ends(basis, force.lengths[axis])[k];
            let increment = |i: usize, r: usize| {
                let before = if r == 0 {
                    0.0
                } else {
                    force.values[i - along_u]
                };
                force.values[i] - before
            };
            let given_up = |start: usize| -> f64 {
                (0..n)
                    .map(|r| {
                        let [last, before] = [end.last, end.before]
                            .map(|k| increment(start + k * over + r * along_u, r));
                        (before - last * (1.0 + 1.0 / end.gain)).max(0.0)
                    })
                    .sum()
            };
            let lines = force.lines(axis).filter(|start| start / along_u % n == 0);
            if lines.map(given_up).fold(0.0, f64::max) <= MOST_GIVEN_UP * largest {
                break;
            }
            basis.levelling_length[k] *= 0.5;
        }
    }
}

/// The coefficients `force` over u, none of which is less than the one before, so changed that this holds beyond the ends of C and M,
/// too. An increment over u stays positive there if the last but one along the axis is no more than so many times the last one: it
/// is lowered to that. Beyond both axes the increment next to the corner counts, too: it is raised as far as it has to be, which
/// is never more than both ends allow.
fn keep_increasing_beyond<const N: usize>(bases: &[Basis<N>; 3], force: &Block) -> Block {
    let n = force.lengths[2];
    let mut increments = force.mapped(2, n, |line| {
        let before = std::iter::once(&0.0).chain(&line);
        line.iter()
            .zip(before)
            .map(|(f, before)| f - before)
            .collect()
    });
    let [along_c, along_m] = [0, 1].map(|axis| ends(&bases[axis], force.lengths[axis]));
    let [by_c, by_m] = [0, 1].map(|axis| force.stride(axis));
    for (axis, ends) in [(1, &along_m), (0, &along_c)] {
        let stride = increments.stride(axis);
        for line in increments.lines(axis) {
            for end in ends {
                let most = increments.values[line + end.last * stride] * (1.0 + 1.0 / end.gain);
                let before = &mut increments.values[line + end.before * stride];
                *before = before.min(most);
            }
        }
    }
    for (c, m) in along_c
        .iter()
        .flat_map(|c| along_m.iter().map(move |m| (c, m)))
    {
        for line in 0..by_m {
            let at = |i: usize, k: usize| line + i * by_c + k * by_m;
            let [corner, along_c, along_m] =
                [(c.last, m.last), (c.before, m.last), (c.last, m.before)]
                    .map(|(i, k)| increments.values[at(i, k)]);
            let [more_c, more_m] = [c, m].map(|end| 1.0 + 1.0 / end.gain);
            let least = more_m * along_c + more_c * along_m - more_c * more_m * corner;
            let before = &mut increments.values[at(c.before, m.before)];
            *before = before.max(least);
        }
    }
    increments.mapped(2, n, |line| {
        let sum = line.iter().scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        });
        sum.collect()
    })
}

/// How far `span` goes on beyond the ends of C and M: [`SPAN_LEVELLING`], and where it falls outwards as far as half of it is left.
fn span_levelling<const N: usize>(bases: [&Basis<N>; 2], span: &Block) -> [[f64; 2]; 2] {
    let mut rows = span.clone();
    let mut lengths = [[f64::INFINITY; 2]; 2];
    for axis in [1, 0].into_iter().filter(|&axis| bases[axis].present()) {
        let (n, stride) = (rows.lengths[axis], rows.stride(axis));
        let steepness = [0, 1].map(|end| bases[axis].steepness(end));
        let places = [[0, 1], [n - 1, n - 2]];
        let levelling_length = [0, 1].map(|end| {
            let longest = rows.lines(axis).map(|line| {
                let [last, before] = places[end].map(|k| rows.values[line + k * stride]);
                last / (steepness[end] * (before - last).max(0.0))
            });
            longest.fold(SPAN_LEVELLING * bases[axis].range(), f64::min)
        });
        // What the other axis starts from where this one has been left.
        rows = rows.mapped(axis, n + 2, |mut line| {
            let [low, high] = [0, 1].map(|end| {
                let [last, before] = places[end].map(|k| line[k]);
                last + 0.5 * levelling_length[end] * steepness[end] * (last - before)
            });
            line.insert(0, low);
            line.push(high);
            line
        });
        lengths[axis] = levelling_length;
    }
    lengths
}
