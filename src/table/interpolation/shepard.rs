//! Shepard's method as an interpolant of a table, the paper's choice.
//!
//! What is interpolated is the potential over that of the mean flank: w(u, y) = h(u) g(u, y), where h is the
//! integral of the mean force over all columns as an onset spline. g is near the same everywhere, and h carries the
//! onset: force, stiffness and its slope are zero at u = 0 exactly. Force and moment are derivatives of one
//! potential, as with the spline. What the method lacks: the force may fall over u between the nodes.

use super::basis::{Basis, Ends};
use super::chain;
use super::fit::{Block, Fit, breaks, integrated, make_increasing};
use super::frame::Frame;
use super::kernel::{ANY, Jet, SECOND, Shape};
use super::scatter::{DIMENSIONS, Dual, Scatter, saturated};
use super::tensor::Tensor;
use crate::table::{Axis, FlankGrid, Potential, Query, TableError};
use crate::vector::Lanes;

/// The displacement among the coordinates of the scattered data, and the others.
const U: usize = 2;
const Y: [usize; 3] = [0, 1, 3];

/// Potential of one flank by Shepard's method.
#[derive(Debug)]
pub struct Shepard {
    /// The coordinate, by the spline.
    frame: Frame<4>,
    u: Basis<5>,
    /// Coefficients of h.
    mean: Vec<f64>,
    /// g.
    shape: Scatter,
    /// Moment over dh/du, where it is not dW/dM.
    lever: Option<Scatter>,
    /// Nodes of centre distance, misalignment and displacement (with 0).
    nodes: [Vec<f64>; 3],
}

impl Shepard {
    /// From the samples of one flank; `tensor` is the spline through the same.
    pub fn new(grid: &FlankGrid, tensor: Tensor<5, 4>) -> Result<Self, TableError> {
        let axes = &grid.axes;
        let u_nodes = &axes.displacement_fraction;
        let u_breaks = breaks(u_nodes, 3, Ends::Onset);
        let force_basis = Basis::<4>::new(&u_breaks, Ends::Onset);
        let fit = Fit::new(&force_basis, u_nodes, Axis::Displacement.name())?;
        let u = Basis::<5>::new(&u_breaks, Ends::Onset);
        let top = grid.top_force();
        let stored = force_basis.stored();
        // A little of u³ keeps the mean above zero next to the onset, whatever the samples.
        let mut mean_force: Vec<f64> = (0..stored)
            .map(|r| match r {
                0..3 => 0.0,
                _ => 1e-4 * top * (r as f64 / (stored - 1) as f64).powi(3),
            })
            .collect();
        let columns = grid.loa_force.len() / u_nodes.len();
        let force = (fit.along(2, &grid.force_block())).mapped(2, stored, |mut line| {
            make_increasing(&mut line[3..], &vec![0.0; stored - 3]);
            for (mean, force) in mean_force.iter_mut().zip(&line) {
                *mean += force / columns as f64;
            }
            line
        });
        let mean = integrated(&mean_force, &u_breaks, 3);
        // Potential and force along the displacement.
        let along_u = |line: &[f64], u_at: f64| {
            let w = u.inside(u_at);
            let dot = |a: &[f64; 5]| (0..5).map(|k| a[k] * line[w.first + k]).sum::<f64>();
            [dot(&w.value), dot(&w.slope)]
        };
        // `line` over the mean: at the onset both begin with their first coefficient.
        let over_mean = |line: &[f64], derivative: usize| {
            let integral = integrated(line, &u_breaks, 3);
            let ratio =
                |&x: &f64| along_u(&integral, x)[derivative] / along_u(&mean, x)[derivative];
            let at_nodes = u_nodes.iter().map(ratio);
            [line[3] / mean_force[3]]
                .into_iter()
                .chain(at_nodes)
                .collect()
        };
        let with_zero = [&[0.0], &u_nodes[..]].concat();
        let scatter = |values: &Block| {
            let [c, m, p] = [
                &axes.center_distance_offset,
                &axes.misalignment,
                &axes.mesh_position,
            ];
            Scatter::new([c, m, &with_zero, p], values)
        };
        let own_moment = grid.moment_block().filter(|_| axes.misalignment.len() == 1);
        Ok(Shepard {
            frame: tensor.into_frame(),
            shape: scatter(&force.mapped(2, with_zero.len(), |line| over_mean(&line, 0))),
            lever: own_moment.map(|moment| {
                let fitted = fit.along(2, &moment);
                scatter(&fitted.mapped(2, with_zero.len(), |line| over_mean(&line, 1)))
            }),
            nodes: [
                axes.center_distance_offset.clone(),
                axes.misalignment.clone(),
                with_zero.clone(),
            ],
            u,
            mean,
        })
    }

    /// The `derivative`th derivative of h, times `scatter`, at x = (C, M, u, PMC).
    fn product(&self, scatter: &Scatter, derivative: usize, x: [f64; DIMENSIONS]) -> Dual {
        let stops: [[f64; 3]; 3] = std::array::from_fn(|i| saturated(x[i], &self.nodes[i]));
        let turn = if self.frame.p.present() {
            x[3] - x[3].floor()
        } else {
            0.0
        };
        let g = scatter.at([stops[0][0], stops[1][0], stops[2][0], turn]);
        let (w, _) = self.u.weights(Lanes::COMMON, x[U], 2);
        let dot = |a: &[f64; 5]| (0..5).map(|k| a[k] * self.mean[w.first + k]).sum::<f64>();
        let h = [&w.value, &w.slope, &w.curvature].map(dot);
        let mut factor = Dual {
            value: h[derivative],
            ..Dual::default()
        };
        factor.gradient[U] = h[derivative + 1];
        // That of the force is not asked for.
        factor.hessian[U][U] = h.get(derivative + 2).copied().unwrap_or_default();
        factor.times(&through_stops(&g, &stops))
    }

    /// The potential at `q`, all derivatives with it.
    pub fn evaluate(&self, lanes: Lanes, q: &Query) -> Potential {
        let at = lanes.run(
            #[inline(always)]
            |lanes| self.frame.at::<true, ANY>(lanes, q),
        );
        let (no_load, span) = (&at.no_load, &at.span);
        let u = (q.delta - no_load.value) / span.value;
        if u <= 0.0 || u.is_nan() {
            return Potential {
                out_of_range: at.outside,
                ..Potential::default()
            };
        }
        let x = [q.center_distance_offset, q.misalignment, u, q.mesh_position];
        let w = self.product(&self.shape, 0, x);
        let shape = Shape {
            value: Jet {
                value: w.value,
                gradient: Y.map(|i| w.gradient[i]),
                second: second(&w),
            },
            slope: Jet {
                value: w.gradient[U],
                gradient: Y.map(|i| w.hessian[i][U]),
                ..Jet::default()
            },
            curvature: w.hessian[U][U],
        };
        let present = self.frame.present::<ANY>();
        let mut out = chain::potential::<true>(u, &shape, no_load, span, present);
        if let Some(lever) = &self.lever {
            let moment = self.product(lever, 1, x);
            let shape = Shape {
                value: Jet::default(),
                slope: Jet {
                    value: moment.value,
                    gradient: Y.map(|i| moment.gradient[i]),
                    ..Jet::default()
                },
                curvature: moment.gradient[U],
            };
            chain::set_moment::<true>(&mut out, u, &shape, no_load, span, present);
        }
        out.out_of_range = at.outside || u > 1.0;
        out
    }

    /// Memory of the coefficients.
    pub fn bytes(&self) -> usize {
        let lever = self.lever.as_ref().map_or(0, Scatter::bytes);
        self.shape.bytes() + lever + self.frame.bytes() + 8 * self.mean.len()
    }
}

/// Derivatives by the coordinates from those by the coordinates that [`saturated`] keeps inside the range.
fn through_stops(g: &Dual, stops: &[[f64; 3]; 3]) -> Dual {
    let slope: [f64; DIMENSIONS] = std::array::from_fn(|i| stops.get(i).map_or(1.0, |s| s[1]));
    let mut out = *g;
    for i in 0..DIMENSIONS {
        out.gradient[i] *= slope[i];
        for j in 0..DIMENSIONS {
            out.hessian[i][j] *= slope[i] * slope[j];
        }
        if let Some([.., bend]) = stops.get(i) {
            out.hessian[i][i] += g.gradient[i] * bend;
        }
    }
    out
}

/// Second derivatives by the coordinates but the displacement, in the order of a [`Jet`].
fn second(w: &Dual) -> [f64; 6] {
    let mut second = [0.0; 6];
    for i in 0..3 {
        for j in i..3 {
            second[SECOND[i][j]] = w.hessian[Y[i]][Y[j]];
        }
    }
    second
}
