//! How the load of a solution slides.

use super::candidates::POINTS;
use super::position::PositionProblem;
use super::result::ContactResult;
use super::solver::ContactSolver;
use crate::friction::{FrictionLaw, Sliding, StripContact, TRANSITION_OVER_PITCH};

impl ContactSolver {
    /// Sliding of `result`, a solution of `problem`, weighted by `law`.
    ///
    /// The distance from the pitch point follows from the lengths of roll of both flanks, so that it is that of the
    /// flank and the tip edge where contact has left the path.
    pub fn sliding(
        &self,
        problem: &PositionProblem,
        result: &ContactResult,
        law: &FrictionLaw,
    ) -> Sliding {
        let g = self.geometry();
        let rb = [0, 1].map(|i| g.gears[i].base_radius());
        let per_roll = g.gears[0].kappa() / (1.0 / rb[0] + g.e() / rb[1]);
        let spin = g.rolling_speed_per_spin(g.center_distance).recip();
        let plane = |i: usize| (1.0 - g.gears[i].poisson_ratio.powi(2)) / g.gears[i].youngs_modulus;
        let transition = TRANSITION_OVER_PITCH * g.base_pitch();
        let mut sum = Sliding::default();
        if result.loa_force <= 0.0 {
            return sum;
        }
        let normal = result.loa_force / g.base_helix_angle().cos();
        for (i, candidate) in problem.candidates().iter().enumerate() {
            let force = result.forces[i];
            if force <= 0.0 {
                continue;
            }
            let turned = [0, 1].map(|k| candidate.roll[k] / rb[k]);
            let strip = StripContact {
                line_load: force / (POINTS as f64 * problem.local[i].length()),
                radius: candidate.radius,
                plane_compliance: plane(0) + plane(1),
                rolling: turned.map(|angle| spin * rb[0] * angle),
            };
            let weight = law.weight(&strip) * force / normal;
            let s = (turned[0] - turned[1]) * per_roll;
            sum.add(weight, s, candidate.middle() - problem.z_ref, transition);
        }
        sum
    }
}
