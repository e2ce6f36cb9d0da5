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
use super::kernel::{ANY, Coefficients, Shape, over_displacement};
use super::{chain, continuation};
use crate::root::bisection;
use crate::table::{Axes, Axis, FlankGrid, Potential, Query, TableError};
use crate::vector::Lanes;

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
    /// Largest u that is within the range.
    top: f64,
}

/// The coordinates but the displacement: bases of centre distance, misalignment and mesh position, and fits of values at
/// their nodes.
struct Others<const N: usize> {
    bases: [Basis<N>; 3],
    fits: [Fit; 3],
}

impl<const N: usize> Others<N> {
    fn new(axes: &Axes) -> Result<Self, TableError> {
        let (c, along_c) = axis(
            &axes.center_distance_offset,
            Ends::Bounded,
            Axis::CenterDistance.name(),
        )?;
        let (m, along_m) = axis(&axes.misalignment, Ends::Bounded, Axis::Misalignment.name())?;
        let (p, along_p) = axis(
            &axes.mesh_position,
            Ends::Periodic,
            Axis::MeshPosition.name(),
        )?;
        Ok(Others {
            bases: [c, m, p],
            fits: [along_c, along_m, along_p],
        })
    }

    /// Coefficients for the values of `block`; `displacement`: along the displacement, too.
    fn fit(&self, block: &Block, displacement: Option<&Fit>) -> Block {
        let [c, m, p] = &self.fits;
        let mut fitted = m.along(1, &c.along(0, block));
        if let Some(u) = displacement {
            fitted = u.along(2, &fitted);
        }
        p.along(3, &fitted)
    }
}

/// B-spline coefficients of what a [`Tensor`] is made of, over (c, m, u, mesh position).
struct Parts<'a> {
    u_breaks: &'a [f64],
    force: Block,
    moment: Option<Block>,
    /// Row 0: no-load approach; row 1: span.
    fields: Block,
    /// See [`Tensor::top`].
    top: f64,
}

impl<const NU: usize, const N: usize> Tensor<NU, N> {
    /// Fits the samples of one flank. The force's own basis, one degree below the potential's, has one function fewer;
    /// const generics cannot say NU - 1, so `NF` is a parameter.
    pub fn new<const NF: usize>(grid: &FlankGrid) -> Result<Self, TableError> {
        let degree = NF - 1;
        let nodes = &grid.axes.displacement_fraction;
        let u_breaks = breaks(nodes, degree, Ends::Onset);
        let force_basis = Basis::<NF>::new(&u_breaks, Ends::Onset);
        let along_u = Fit::new(&force_basis, nodes, Axis::Displacement.name())?;
        let others = Others::<N>::new(&grid.axes)?;

        let force = others.fit(&grid.force_block(), Some(&along_u));
        let least = least_increments(&force, degree);
        let force = force.mapped(2, force.lengths[2], |mut line| {
            make_increasing(&mut line[degree..], &least);
            line
        });
        let [_, m, _] = &others.bases;
        let own_moment = grid.moment_block().filter(|_| !m.present());
        let parts = Parts {
            moment: own_moment.map(|block| others.fit(&block, Some(&along_u))),
            fields: others.fit(&grid.field_block(), None),
            u_breaks: &u_breaks,
            force,
            top: 1.0,
        };
        Self::assembled(others.bases, parts)
    }

    fn assembled([mut c, mut m, p]: [Basis<N>; 3], parts: Parts<'_>) -> Result<Self, TableError> {
        let Parts {
            u_breaks, fields, ..
        } = parts;
        let integral = |block: &Block| {
            block.mapped(2, block.lengths[2] + 1, |line| {
                integrated(&line, u_breaks, NU - 2)
            })
        };
        continuation::limit(&mut c, &mut m, &continuation::spans(&fields), &parts.force)?;
        Ok(Tensor {
            u: Basis::new(u_breaks, Ends::Onset),
            shape: Coefficients::new(&integral(&parts.force)),
            moment: parts.moment.map(|b| Coefficients::new(&integral(&b))),
            no_contact: below_all(&fields),
            frame: Frame::new([c, m, p], &fields),
            top: parts.top,
        })
    }

    /// All but what depends on the displacement.
    pub fn into_frame(self) -> Frame<N> {
        self.frame
    }

    /// Memory of the coefficients.
    pub fn bytes(&self) -> usize {
        let moment = self.moment.as_ref().map_or(0, Coefficients::bytes);
        self.shape.bytes() + self.frame.bytes() + moment
    }

    /// See [`FlankTable::evaluate`](super::FlankTable::evaluate). Values are compiled for the displacement alone, and for the axes
    /// that there are with the registers that nearly every processor has and a mesh position; all else shares one evaluation, since each more would
    /// cost seconds of every build.
    pub fn evaluate(&self, lanes: Lanes, q: &Query, want_hessian: bool) -> Potential {
        if want_hessian {
            return self.on::<true, ANY>(lanes, q);
        }
        if self.frame.axes() == 0 {
            return self.on::<false, 0>(lanes, q);
        }
        if !lanes.are_wide() {
            return self.on::<false, ANY>(lanes, q);
        }
        match self.frame.axes() {
            4 => self.on::<false, 4>(lanes, q),
            5 => self.on::<false, 5>(lanes, q),
            6 => self.on::<false, 6>(lanes, q),
            7 => self.on::<false, 7>(lanes, q),
            _ => self.on::<false, ANY>(lanes, q),
        }
    }

    #[inline(always)]
    fn on<const H: bool, const AXES: usize>(&self, lanes: Lanes, q: &Query) -> Potential {
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
        let present = self.frame.present::<AXES>();
        let at = self.frame.at::<H, AXES>(lanes, q);
        let (no_load, span) = (&at.no_load, &at.span);
        let u = (q.delta - no_load.value) / span.value;
        if u <= 0.0 {
            return Potential {
                out_of_range: at.outside,
                ..Potential::default()
            };
        }
        let shape = self.over::<H, AXES>(lanes, &self.shape, u, &at);
        let mut out = chain::potential::<H>(u, &shape, no_load, span, present);
        if let Some(moment) = &self.moment {
            let shape = self.over::<H, AXES>(lanes, moment, u, &at);
            chain::set_moment::<H>(&mut out, u, &shape, no_load, span, present);
        }
        out.out_of_range = at.outside || u > self.top;
        out
    }

    /// What `coefficients` have over the displacement at `u` and `at`.
    #[inline(always)]
    fn over<const H: bool, const AXES: usize>(
        &self,
        lanes: Lanes,
        coefficients: &Coefficients<N>,
        u: f64,
        at: &Framed<N>,
    ) -> Shape {
        let (wu, _) = self.u.weights(lanes, u, 2);
        over_displacement::<NU, N, H, AXES>(lanes, coefficients, &wu, &at.wc, &at.wm, &at.wp)
    }
}

impl<const N: usize> Tensor<3, N> {
    /// Constant load, see [`FlankTable::constant_load`](super::FlankTable::constant_load): W = F (delta - O)² / (2 (STE - O)),
    /// that is S w(u) with u = (delta - O) / S, S = STE - O, w = F u² / 2.
    pub fn constant_load(grid: &FlankGrid, loa_force: f64) -> Result<Self, TableError> {
        let at = AtForce::new(grid, loa_force)?;
        let others = Others::<N>::new(&grid.axes)?;
        let fields = others.fit(&at.fields, None);
        if continuation::spans(&fields)
            .values
            .iter()
            .any(|&span| span <= 0.0)
        {
            return Err(TableError::field(
                "nominalTorque",
                format!("{loa_force} N on the line of action"),
                "STE at this load is not positive everywhere, so there is no secant stiffness",
                "raise nominalTorque or set loadDependent = true",
            ));
        }
        // A line from the onset on.
        let moment = |lever: Block| {
            let line = |lever: Vec<f64>| vec![0.0, loa_force * lever[0]];
            others.fit(&lever, None).mapped(2, 2, line)
        };
        let parts = Parts {
            u_breaks: &[0.0, 1.0],
            force: fields.mapped(2, 2, |_| vec![0.0, loa_force]),
            moment: at.lever.map(moment),
            fields,
            top: f64::INFINITY,
        };
        Self::assembled(others.bases, parts)
    }
}

/// STE and lever at the nodes for one force.
struct AtForce {
    /// Rows O and STE - O.
    fields: Block,
    /// z_c - z_ref, m.
    lever: Option<Block>,
}

impl AtForce {
    /// By inversion of the spline over u.
    fn new(grid: &FlankGrid, loa_force: f64) -> Result<Self, TableError> {
        let nodes = &grid.axes.displacement_fraction;
        let basis = Basis::<4>::new(&breaks(nodes, 3, Ends::Onset), Ends::Onset);
        let fit = Fit::new(&basis, nodes, Axis::Displacement.name())?;
        let force = fit.along(2, &grid.force_block());
        let moment = grid.moment_block().map(|b| fit.along(2, &b));
        let spline = |block: &Block, start: usize, u: f64| {
            let w = basis.inside(u);
            let stride = block.stride(2);
            (0..4)
                .map(|k| w.value[k] * block.values[start + (w.first + k) * stride])
                .sum::<f64>()
        };
        let [nc, nm, _, np] = force.lengths;
        let origin = grid.touch_shift()?;
        let mut fields = grid.field_block();
        let mut lever = moment.as_ref().map(|_| Block::zeros([nc, nm, 1, np]));
        for (column, (start, field)) in force.lines(2).zip(fields.lines(2)).enumerate() {
            let top = spline(&force, start, 1.0);
            if !(loa_force > 0.0 && loa_force <= top * (1.0 + 1e-9)) {
                return Err(TableError::field(
                    "nominalTorque",
                    format!("{loa_force} N on the line of action"),
                    format!("the table holds forces above 0 up to {top} N"),
                    "choose a torque in this range or make tables with a larger maximum_torque_nm",
                ));
            }
            let u = bisection([0.0, 1.0], 60, |u| spline(&force, start, u) < loa_force);
            let ste = fields.values[field] + u * fields.values[field + np];
            fields.values[field] = origin[column / np];
            fields.values[field + np] = ste - origin[column / np];
            if let (Some(lever), Some(moment)) = (&mut lever, &moment) {
                lever.values[column] = spline(moment, start, u) / loa_force;
            }
        }
        Ok(AtForce { fields, lever })
    }
}

/// Basis and fit of an axis with samples at `nodes`: degree N - 1; a single one has no extent, nothing depends on it.
pub fn axis<const N: usize>(
    nodes: &[f64],
    ends: Ends,
    name: &str,
) -> Result<(Basis<N>, Fit), TableError> {
    let basis = match nodes {
        [_] => Basis::new(&[], ends),
        _ => Basis::new(&breaks(nodes, N - 1, ends), ends),
    };
    let fit = Fit::new(&basis, nodes, name)?;
    Ok((basis, fit))
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
