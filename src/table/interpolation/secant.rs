//! Constant load: a secant stiffness over (C, M, PMC), paper (21)-(22).

use super::basis::{Basis, Ends};
use super::fit::{Block, Fit, breaks};
use super::frame::Frame;
use super::kernel::{Coefficients, Jet, field};
use super::lanes::{Registers, Two};
use super::tensor::axis_basis;
use super::{Checks, Evaluate, chain, continuation};
use crate::table::{FlankGrid, Potential, Query, TableError};

/// `N` functions at one point per coordinate: spline 4, linear 2.
///
/// W = F_n (delta - O)² / (2 (STE - O)), that is S w(u) with u = (delta - O)/S, S = STE - O, w = F_n u²/2.
#[derive(Debug, Clone)]
pub struct Secant<const N: usize> {
    /// Of O and S.
    frame: Frame<N>,
    /// z_c - z_ref likewise.
    lever: Option<Coefficients<N>>,
    loa_force: f64,
}

impl<const N: usize> Secant<N> {
    /// From the samples of one flank at the force `loa_force`, N.
    pub fn new(grid: &FlankGrid, loa_force: f64) -> Result<Self, TableError> {
        let at = at_force(grid, loa_force)?;
        let axes = &grid.axes;
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
            Fit::new(&p, &axes.mesh_position, Ends::Periodic, "mesh_position")?,
        ];
        let fit = |b: Block| {
            let [c, m, p] = &along;
            p.along(3, &m.along(1, &c.along(0, &b)))
        };
        let stiffness = fit(at.fields);
        let row = stiffness.stride(2);
        for (k, &span) in stiffness.values.iter().enumerate() {
            if (k / row) % 2 == 1 && span <= 0.0 {
                return Err(TableError::field(
                    "nominalTorque",
                    format!("{loa_force} N on the line of action"),
                    "STE at this load is not positive everywhere, so there is no secant stiffness",
                    "raise nominalTorque or set loadDependent = true",
                ));
            }
        }
        continuation::limit(&mut c, &mut m, &continuation::spans(&stiffness), None)?;
        Ok(Secant {
            frame: Frame::new([c, m, p], &stiffness),
            lever: at.lever.map(|b| Coefficients::new(&fit(b))),
            loa_force,
        })
    }
}

impl<const N: usize> Evaluate for Secant<N> {
    const WIDE: bool = N == 4;

    #[inline(always)]
    fn at<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        q: &Query,
    ) -> Potential {
        let at = self.frame.at::<H, AXES>(registers, q);
        let (origin, span, out_of_range) = (&at.no_load, &at.span, at.outside);
        let u = (q.delta - origin.value) / span.value;
        if u <= 0.0 {
            return Potential {
                out_of_range,
                ..Potential::default()
            };
        }
        let jet = |value| Jet {
            value,
            ..Jet::default()
        };
        let f = self.loa_force;
        let present = self.frame.present::<AXES>();
        let mut out = chain::potential::<H>(
            u,
            &[jet(0.5 * f * u * u), jet(f * u), jet(f)],
            0.0,
            origin,
            span,
            present,
        );
        if let Some(lever) = &self.lever {
            let z = field::<N, H, AXES>(Two, lever, 0, &at.wc, &at.wm, &at.wp);
            let moment = Jet {
                value: f * u * z.value,
                gradient: z.gradient.map(|g| f * u * g),
                ..Jet::default()
            };
            chain::set_moment::<H>(
                &mut out,
                u,
                &[Jet::default(), moment, jet(f * z.value)],
                origin,
                span,
                present,
            );
        }
        out.out_of_range = out_of_range;
        out
    }

    fn checks(&self) -> Checks {
        Checks {
            // A secant is a straight line from u = 0 to 1.
            minimum_slope: 1.0,
            monotone_correction: 0.0,
        }
    }

    fn bytes(&self) -> usize {
        let lever = self.lever.as_ref().map_or(0, Coefficients::bytes);
        self.frame.bytes() + lever
    }
}

struct AtForce {
    /// Rows O and S.
    fields: Block,
    /// z_c - z_ref, m.
    lever: Option<Block>,
}

/// STE and lever at every node for the force `loa_force`, by inversion of the spline over u.
fn at_force(grid: &FlankGrid, loa_force: f64) -> Result<AtForce, TableError> {
    let nodes = &grid.axes.displacement_fraction;
    let u_breaks = breaks(nodes, 3, Ends::Onset);
    let basis = Basis::<4>::new(&u_breaks, Ends::Onset);
    let fit = Fit::new(&basis, nodes, Ends::Onset, "displacement_fraction")?;
    let force = fit.along(2, &grid.force_block());
    let moment = grid.moment_block().map(|b| fit.along(2, &b));
    let fields = grid.field_block();
    let at = |block: &Block, start: usize, u: f64| {
        let w = basis.inside(u);
        let stride = block.stride(2);
        (0..4)
            .map(|k| w.value[k] * block.values[start + (w.first + k) * stride])
            .sum::<f64>()
    };
    let [nc, nm, _, np] = force.lengths;
    let origin = grid.touch_shift()?;
    let mut out = Block::zeros([nc, nm, 2, np]);
    let mut lever = moment.as_ref().map(|_| Block::zeros([nc, nm, 1, np]));
    for c in 0..nc {
        for m in 0..nm {
            for p in 0..np {
                let start = c * force.stride(0) + m * force.stride(1) + p;
                let top = at(&force, start, 1.0);
                if !(loa_force > 0.0 && loa_force <= top * (1.0 + 1e-9)) {
                    return Err(TableError::field(
                        "nominalTorque",
                        format!("{loa_force} N on the line of action"),
                        format!("the table holds forces above 0 up to {top} N"),
                        "choose a torque in this range or make tables with a larger maximum_torque_nm",
                    ));
                }
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if at(&force, start, middle) < loa_force {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let u = 0.5 * (low + high);
                let field = c * fields.stride(0) + m * fields.stride(1) + p;
                let ste = fields.values[field] + u * fields.values[field + np];
                let o = origin[c * nm + m];
                out.values[field] = o;
                out.values[field + np] = ste - o;
                if let (Some(lever), Some(moment)) = (&mut lever, &moment) {
                    lever.values[(c * nm + m) * np + p] = at(moment, start, u) / loa_force;
                }
            }
        }
    }
    Ok(AtForce { fields: out, lever })
}
