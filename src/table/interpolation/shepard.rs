//! Shepard's method as an interpolant of a table, the paper's choice.
//!
//! What is interpolated is the potential over that of the mean flank: w(u, y) = h(u) g(u, y), where h is the
//! integral of the mean force over all columns as an onset spline. g is near the same everywhere, and h carries the
//! onset: force, stiffness and its slope are zero at u = 0 exactly. Force and moment are derivatives of one
//! potential, as with the spline. What the method lacks: the force may fall over u between the nodes. That is
//! looked for at many points when the table is made ([`Checks::minimum_slope`]), not prevented.

use super::basis::{Basis, Ends};
use super::fit::{Block, Fit, breaks, integrated, make_monotone};
use super::frame::{Frame, Framed};
use super::jet::{Jet4, PAIR};
use super::kernel::Jet;
use super::lanes::{Registers, Two};
use super::scatter::{Scatter, saturated};
use super::tensor::Tensor;
use super::{Checks, Evaluate, chain};
use crate::table::{FlankGrid, Potential, Query, TableError};

/// Coordinates of the scattered data that are not the displacement.
const Y: [usize; 3] = [0, 1, 3];

/// Points at which the slope of the force is looked at.
const SCANNED: usize = 8_000;

/// `K` = 2 with a moment of its own (where it is not dW/dM).
#[derive(Debug)]
pub struct Shepard<const K: usize> {
    /// The coordinate, by the spline.
    frame: Frame<4>,
    u: Basis<5>,
    /// Coefficients of h.
    mean: Vec<f64>,
    scatter: Scatter<K>,
    /// Nodes of centre distance, misalignment and displacement (with 0).
    nodes: [Vec<f64>; 3],
    checks: Checks,
}

impl<const K: usize> Shepard<K> {
    /// From the samples of one flank; `tensor` is the spline through the same.
    pub fn new(grid: &FlankGrid, tensor: Tensor<5, 4>) -> Result<Self, TableError> {
        let u_nodes = &grid.axes.displacement_fraction;
        let u_breaks = breaks(u_nodes, 3, Ends::Onset);
        let force_basis = Basis::<4>::new(&u_breaks, Ends::Onset);
        let fit = Fit::new(&force_basis, u_nodes, Ends::Onset, "displacement_fraction")?;
        let u = Basis::<5>::new(&u_breaks, Ends::Onset);
        let force = fit.along(2, &grid.force_block());
        let top = grid.top_force();
        let mut checks = Checks::default();
        let line_of = |block: &Block, start: usize| -> Vec<f64> {
            let stride = block.stride(2);
            (0..block.lengths[2])
                .map(|r| block.values[start + r * stride])
                .collect()
        };
        let mut lines: Vec<Vec<f64>> = force.lines(2).map(|s| line_of(&force, s)).collect();
        for line in &mut lines {
            let change = make_monotone(&mut line[3..]);
            checks.monotone_correction = checks.monotone_correction.max(change / top);
        }
        // A little of u³ keeps the mean above zero next to the onset, whatever the samples.
        let stored = force_basis.stored();
        let mean_force: Vec<f64> = (0..stored)
            .map(|r| {
                let u = r as f64 / (stored - 1) as f64;
                let sum: f64 = lines.iter().map(|l| l[r]).sum();
                let floor = if r < 3 { 0.0 } else { 1e-4 * top * u.powi(3) };
                sum / lines.len() as f64 + floor
            })
            .collect();
        let mean = integrated(&mean_force, &u_breaks, 3);

        let n = u_nodes.len() + 1;
        let mut lengths = force.lengths;
        lengths[2] = n;
        let mut shape = Block::zeros(lengths);
        let stride = shape.stride(2);
        let along_u = |line: &[f64], u_at: f64| {
            let w = u.inside(u_at);
            let dot = |a: &[f64; 5]| (0..5).map(|k| a[k] * line[w.first + k]).sum::<f64>();
            [dot(&w.value), dot(&w.slope)]
        };
        for (line, to) in lines.iter().zip(shape.lines(2)) {
            let potential = integrated(line, &u_breaks, 3);
            // At the onset both begin with their first coefficient.
            shape.values[to] = line[3] / mean_force[3];
            for (j, &x) in u_nodes.iter().enumerate() {
                shape.values[to + (j + 1) * stride] =
                    along_u(&potential, x)[0] / along_u(&mean, x)[0];
            }
        }
        let lever = match grid.moment_block() {
            Some(block) if K == 2 => {
                let fitted = fit.along(2, &block);
                let mut out = Block::zeros(lengths);
                for ((from, data), to) in fitted.lines(2).zip(block.lines(2)).zip(shape.lines(2)) {
                    out.values[to] = line_of(&fitted, from)[3] / mean_force[3];
                    for (j, &x) in u_nodes.iter().enumerate() {
                        out.values[to + (j + 1) * stride] =
                            block.values[data + j * block.stride(2)] / along_u(&mean, x)[1];
                    }
                }
                out
            }
            _ => shape.clone(),
        };
        let mut with_zero = vec![0.0];
        with_zero.extend_from_slice(u_nodes);
        let axes = &grid.axes;
        let scatter = Scatter::new(
            [
                &axes.center_distance_offset,
                &axes.misalignment,
                &with_zero,
                &axes.mesh_position,
            ],
            std::array::from_fn(|k| if k == 0 { &shape } else { &lever }),
        );
        let mut shepard = Shepard {
            frame: tensor.into_frame(),
            u,
            mean,
            scatter,
            nodes: [
                axes.center_distance_offset.clone(),
                axes.misalignment.clone(),
                with_zero,
            ],
            checks,
        };
        shepard.checks.minimum_slope = shepard.least_slope(&axes.mesh_position) / top;
        Ok(shepard)
    }

    /// Least dF/du over points between the nodes (additive recurrence with the roots of x⁵ = x + 1).
    fn least_slope(&self, positions: &[f64]) -> f64 {
        let root = [
            0.856_674_883_9,
            0.733_891_856_6,
            0.628_706_721_0,
            0.538_597_257_2,
        ];
        let within = |nodes: &[f64], s: f64| nodes[0] + s * (nodes[nodes.len() - 1] - nodes[0]);
        let fixed = positions[0];
        (0..SCANNED)
            .map(|n| {
                let s = root.map(|r| (0.5 + r * n as f64).fract());
                let u = within(&self.nodes[2], s[2]);
                let y = [
                    within(&self.nodes[0], s[0]),
                    within(&self.nodes[1], s[1]),
                    if positions.len() > 1 { s[3] } else { fixed },
                ];
                self.shape::<false>(u, y).0.by_u[2].value
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// w with its derivatives by u, and the moment likewise, at the displacement u over (C, M, PMC).
    #[inline(always)]
    fn shape<const H: bool>(&self, u: f64, [c, m, p]: [f64; 3]) -> (Shape, Option<[Jet; 3]>) {
        let bounded = [c, m, u];
        let stops: [[f64; 4]; 3] = std::array::from_fn(|i| saturated(bounded[i], &self.nodes[i]));
        let turn = if self.frame.p.present() {
            p - p.floor()
        } else {
            0.0
        };
        let mut jets = self
            .scatter
            .at::<H>([stops[0][0], stops[1][0], stops[2][0], turn]);
        for jet in &mut jets {
            through_stops(jet, &stops);
        }
        let (w, _) = self.u.weights(Two, u, if H { 3 } else { 2 });
        let dot = |a: &[f64; 5]| (0..5).map(|k| a[k] * self.mean[w.first + k]).sum::<f64>();
        let [h, h1, h2] = [dot(&w.value), dot(&w.slope), dot(&w.curvature)];
        let [g, g1, g2] = along_displacement::<H>(&jets[0]);
        let mut shape = Shape {
            by_u: [
                combined(&[(h, &g)]),
                combined(&[(h1, &g), (h, &g1)]),
                combined(&[(h2, &g), (2.0 * h1, &g1), (h, &g2)]),
            ],
            third: 0.0,
        };
        if H {
            shape.third = dot(&w.third) * g.value
                + 3.0 * (h2 * g1.value + h1 * g2.value)
                + h * jets[0].third[2];
        }
        let moment = (K == 2).then(|| {
            let [z, z1, _] = along_displacement::<H>(&jets[K - 1]);
            [
                Jet::default(),
                combined(&[(h1, &z)]),
                combined(&[(h2, &z), (h1, &z1)]),
            ]
        });
        (shape, moment)
    }
}

impl<const K: usize> Evaluate for Shepard<K> {
    const WIDE: bool = false;

    #[inline(always)]
    fn at<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        q: &Query,
    ) -> Potential {
        let Framed {
            no_load,
            span,
            outside,
            ..
        } = self.frame.at::<H, AXES>(registers, q);
        let u = (q.delta - no_load.value) / span.value;
        if u <= 0.0 || u.is_nan() {
            return Potential {
                out_of_range: outside,
                ..Potential::default()
            };
        }
        let y = [q.center_distance_offset, q.misalignment, q.mesh_position];
        let (shape, moment) = self.shape::<H>(u, y);
        let present = self.frame.present::<AXES>();
        let mut out = chain::potential::<H>(u, &shape.by_u, shape.third, &no_load, &span, present);
        if let Some(moment) = &moment {
            chain::set_moment::<H>(&mut out, u, moment, &no_load, &span, present);
        }
        out.out_of_range = outside || u > 1.0;
        out
    }

    fn checks(&self) -> Checks {
        self.checks
    }

    fn bytes(&self) -> usize {
        self.scatter.bytes() + self.frame.bytes() + 8 * self.mean.len()
    }
}

/// w(u, y): itself, dw/du and d²w/du² with derivatives by y, and d³w/du³ (only with `H`).
struct Shape {
    by_u: [Jet; 3],
    third: f64,
}

/// Derivatives by the coordinates from those by the coordinates held inside the range.
fn through_stops(jet: &mut Jet4, stops: &[[f64; 4]; 3]) {
    let slope: [f64; 4] = std::array::from_fn(|i| stops.get(i).map_or(1.0, |s| s[1]));
    let [_, u1, u2, u3] = stops[2];
    for i in 0..4 {
        // d/dx_i of g_uu u'² + g_u u''.
        let own = if i == 2 {
            2.0 * jet.second[PAIR[2][2]] * u1 * u2 + jet.gradient[2] * u3
        } else {
            0.0
        };
        jet.third[i] = (jet.third[i] * u1 * u1 + jet.second[PAIR[i][2]] * u2) * slope[i] + own;
    }
    for i in 0..4 {
        for j in i..4 {
            jet.second[PAIR[i][j]] *= slope[i] * slope[j];
        }
        if let Some(stop) = stops.get(i) {
            jet.second[PAIR[i][i]] += jet.gradient[i] * stop[2];
        }
    }
    for i in 0..4 {
        jet.gradient[i] *= slope[i];
    }
}

/// The quantity and its two derivatives by the displacement, the first with second derivatives, the others with
/// first ones (all only with `H`).
#[inline(always)]
fn along_displacement<const H: bool>(jet: &Jet4) -> [Jet; 3] {
    let mut value = Jet {
        value: jet.value,
        gradient: Y.map(|i| jet.gradient[i]),
        ..Jet::default()
    };
    let mut slope = Jet {
        value: jet.gradient[2],
        ..Jet::default()
    };
    let mut curvature = Jet {
        value: jet.second[PAIR[2][2]],
        ..Jet::default()
    };
    if H {
        slope.gradient = Y.map(|i| jet.second[PAIR[i][2]]);
        curvature.gradient = Y.map(|i| jet.third[i]);
        for i in 0..3 {
            for j in i..3 {
                value.second[super::kernel::SECOND[i][j]] = jet.second[PAIR[Y[i]][Y[j]]];
            }
        }
    }
    [value, slope, curvature]
}

/// Sum of multiples.
#[inline(always)]
fn combined(terms: &[(f64, &Jet)]) -> Jet {
    let mut out = Jet::default();
    for (factor, jet) in terms {
        out.value += factor * jet.value;
        for i in 0..3 {
            out.gradient[i] += factor * jet.gradient[i];
        }
        for n in 0..6 {
            out.second[n] += factor * jet.second[n];
        }
    }
    out
}
