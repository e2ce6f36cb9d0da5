//! Constant load: the secant stiffness at the nominal torque, (21)-(22).

use super::law::Elasticity;
use crate::table::{COORDINATES, Potential, Query};
use std::sync::Arc;

/// F = K delta with K(C, M, PMC) = F_n / STE(C, M, PMC), STE being where the underlying law reaches the
/// nominal force F_n; the resultant stays where it is at F_n.
///
/// The paper's constant load. Half the tangent stiffness or so for relieved gears, and no potential:
/// the shuttling moment is not dW/dM here, so the energy bars hold for variable load alone.
pub(crate) struct Secant {
    surface: Arc<dyn Elasticity>,
    /// F_n on the line of action, N.
    force: f64,
    /// Displacement where the search starts, m.
    start: f64,
}

/// Displacement beyond which no table can want to go, m.
const LARGEST: f64 = 1e-2;

impl Secant {
    /// Secant of `surface` at `force` (N on the line of action); `None` where it never reaches it.
    pub(crate) fn new(surface: Arc<dyn Elasticity>, force: f64) -> Option<Self> {
        let mut secant = Self {
            surface,
            force,
            start: 1e-5,
        };
        let origin = Query {
            delta: 0.0,
            center_distance_offset: 0.0,
            misalignment: 0.0,
            mesh_position: 0.0,
        };
        let (delta, w) = secant.nominal(&origin);
        let reached = (w.gradient[0] - force).abs() < 1e-6 * force && delta > 0.0;
        secant.start = delta;
        reached.then_some(secant)
    }

    /// STE at the nominal force and the law there: Newton, kept in a bracket.
    fn nominal(&self, query: &Query) -> (f64, Potential) {
        let mut x = self.start;
        let (mut low, mut high) = (-LARGEST, LARGEST);
        let mut w = Potential::default();
        for _ in 0..60 {
            w = self.surface.evaluate(&Query { delta: x, ..*query }, true);
            let miss = w.gradient[0] - self.force;
            if miss.abs() <= 1e-13 * self.force {
                break;
            }
            if miss > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - miss / w.hessian[0][0];
            x = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        (x, w)
    }

    /// Gradient without second derivatives, and K with its slopes by (C, M, PMC) in `hessian[0]`.
    fn first_order(&self, query: &Query) -> Potential {
        let (ste, at_nominal) = self.nominal(query);
        let stiffness = self.force / ste;
        let delta = query.delta;
        let tangent = at_nominal.hessian[0][0];
        // dSTE/dq at constant force = -F_q / F_delta, and K = F_n / STE.
        let slope = |i: usize| stiffness / ste * at_nominal.hessian[0][i] / tangent;
        let mut w = Potential {
            value: 0.5 * stiffness * delta * delta,
            out_of_range: at_nominal.out_of_range,
            ..Potential::default()
        };
        w.gradient[0] = stiffness * delta;
        w.hessian[0][0] = stiffness;
        for i in 1..COORDINATES {
            w.gradient[i] = 0.5 * slope(i) * delta * delta;
            w.hessian[0][i] = slope(i) * delta;
        }
        w.gradient[2] = w.gradient[0] * at_nominal.gradient[2] / self.force;
        w
    }
}

impl Elasticity for Secant {
    fn evaluate(&self, query: &Query, want_hessian: bool) -> Potential {
        if query.delta <= 0.0 {
            return Potential::default();
        }
        let mut w = self.first_order(query);
        if want_hessian {
            // Slopes of the side terms are third derivatives of the table: central differences.
            for (j, step) in [0.0, 1e-7, 1e-7, 1e-5].into_iter().enumerate() {
                for i in 1..COORDINATES {
                    w.hessian[i][j] = if j == 0 {
                        let power = if i == 2 { 1.0 } else { 2.0 };
                        power * w.gradient[i] / query.delta
                    } else {
                        0.0
                    };
                }
                if j > 0 {
                    let side = |h: f64| {
                        let mut x = *query;
                        match j {
                            1 => x.center_distance_offset += h,
                            2 => x.misalignment += h,
                            _ => x.mesh_position += h,
                        }
                        self.first_order(&x).gradient
                    };
                    let (up, down) = (side(step), side(-step));
                    for i in 1..COORDINATES {
                        w.hessian[i][j] = (up[i] - down[i]) / (2.0 * step);
                    }
                }
            }
        }
        w
    }
}
