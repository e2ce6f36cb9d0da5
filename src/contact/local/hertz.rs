//! Local contact of one strip: force over penetration in closed form.

use super::constants::{LARGEST_HALF_WIDTH_OVER_RADIUS, WIDTH_OVER_REFERENCE};
use super::tip_edge::TipEdge;

/// Force of one strip over the approach of its two flanks that the local contact takes up.
///
/// The penetration under the force per length w is, summed over both gears (see
/// [`crate::compliance::ToothCompliance`]),
/// h(w) = sum_g c_g w (ln(2 L_g / b) + 1/2), c_g = 2 (1 - nu_g^2) / (pi E_g), b = sqrt(kappa w),
/// kappa = 4 rho (1/E'_1 + 1/E'_2) / pi (Hertz). h rises from zero with an infinite slope, so that its
/// inverse starts with slope zero: contact begins smoothly. With u = ln w - 2 B / c the inverse is the
/// lower branch of Lambert's W, -u e^u = y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalContact {
    /// Length of the strip along the contact line, m.
    length: f64,
    /// c_1 + c_2, 1/Pa.
    c: f64,
    /// ln(2 exp(-2 B / c) / c): turns a penetration into ln y.
    log_scale: f64,
    /// kappa, m^2 per N/m.
    kappa: f64,
    /// Relative radius of curvature, m.
    radius: f64,
    /// Takes over from the width of contact at which one side of it ends at a tip edge.
    edge: Option<TipEdge>,
}

/// Elastic constants and reference length of one gear at a strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBody {
    /// (1 - nu^2) / E, 1/Pa.
    pub plane_compliance: f64,
    /// Reference length L of the local contact, m.
    pub reference_length: f64,
}

impl LocalContact {
    /// Law of a strip of `length` (m, along the contact line) between two bodies of the relative
    /// radius of curvature `radius` (m, normal section). `edge_slope` is the slope of the gap at the nearest
    /// tip edge, away from it into the flank: negative where the flanks come closest inside the flank, at the
    /// distance -`edge_slope` * `radius` from the edge.
    pub fn new(bodies: [LocalBody; 2], radius: f64, length: f64, edge_slope: f64) -> LocalContact {
        let scale = 2.0 / std::f64::consts::PI;
        let kappa =
            2.0 * scale * radius * (bodies[0].plane_compliance + bodies[1].plane_compliance);
        let c: f64 = bodies.iter().map(|g| scale * g.plane_compliance).sum();
        let b: f64 = bodies
            .iter()
            .map(|g| {
                scale
                    * g.plane_compliance
                    * ((2.0 * g.reference_length).ln() - 0.5 * kappa.ln() + 0.5)
            })
            .sum();
        let log_reference = b / c - std::f64::consts::LN_2 + 0.5 * kappa.ln() - 0.5;
        LocalContact {
            length,
            c,
            log_scale: (2.0 / c).ln() - 2.0 * b / c,
            kappa,
            radius,
            edge: TipEdge::new(c, radius, log_reference, edge_slope),
        }
    }

    /// Force (N) and its derivative (N/m) at the penetration `x` (m); zero for x <= 0.
    pub fn force(&self, x: f64) -> (f64, f64) {
        if x <= 0.0 {
            return (0.0, 0.0);
        }
        if let Some(edge) = &self.edge
            && x > edge.least_penetration()
        {
            let (w, slope) = edge.line_load(x);
            return (self.length * w, self.length * slope);
        }
        let log_y = x.ln() + self.log_scale;
        let u_wide = u_wide();
        let log_y_wide = (-u_wide).ln() + u_wide;
        if log_y >= log_y_wide {
            let slope = self.length / self.slope_at(u_wide);
            let x_wide = (log_y_wide - self.log_scale).exp();
            let f_wide = self.length * 2.0 * x_wide / (self.c * -u_wide);
            return (f_wide + slope * (x - x_wide), slope);
        }
        // ln(-u) + u = ln y by Newton.
        let mut u = lower_branch(log_y).min(u_wide);
        for _ in 0..20 {
            let step = ((-u).ln() + u - log_y) / (1.0 + 1.0 / u);
            u -= step;
            // Quadratic: what is left is the square of it.
            if step.abs() <= 1e-7 * u.abs() {
                break;
            }
        }
        (
            self.length * 2.0 * x / (self.c * -u),
            self.length / self.slope_at(u),
        )
    }

    /// Energy of the local contact at the penetration `x` (m), J: the integral of the force, zero for x <= 0.
    ///
    /// Within Hertz, with the line load w: integral of h dw = w h / 2 + c w² / 8.
    pub fn energy(&self, x: f64) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        let hertz =
            |x: f64, force: f64| 0.5 * x * force - self.c * force * force / (8.0 * self.length);
        if let Some(edge) = &self.edge
            && x > edge.least_penetration()
        {
            let reached = edge.least_penetration();
            let force = self.length * edge.least_line_load();
            return hertz(reached, force) + self.length * edge.energy(x);
        }
        let u_wide = u_wide();
        let x_wide = ((-u_wide).ln() + u_wide - self.log_scale).exp();
        if x <= x_wide {
            return hertz(x, self.force(x).0);
        }
        let (f_wide, slope) = self.force(x_wide);
        let beyond = x - x_wide;
        hertz(x_wide, f_wide) + beyond * (f_wide + 0.5 * slope * beyond)
    }

    /// dh/dw at u.
    fn slope_at(&self, u: f64) -> f64 {
        -0.5 * self.c * (u + 1.0)
    }

    /// Hertz pressure, Pa, of the force `f`, N, where that is more than any flank carries
    /// ([`LARGEST_HALF_WIDTH_OVER_RADIUS`]).
    pub fn overload(&self, f: f64) -> Option<f64> {
        let half_width = (self.kappa * f.max(0.0) / self.length).sqrt();
        (half_width > LARGEST_HALF_WIDTH_OVER_RADIUS * self.radius).then(|| self.hertz_pressure(f))
    }

    /// Whether contact reaches a tip edge under the force `f`, N.
    pub fn reaches_edge(&self, f: f64) -> bool {
        self.edge
            .is_some_and(|edge| f / self.length > edge.least_line_load())
    }

    /// Largest Hertz pressure, Pa, under the force `f`, N: 2 w / (pi b). None where contact reaches a tip
    /// edge: at a sharp edge pressure has no bound.
    pub fn pressure(&self, f: f64) -> Option<f64> {
        (!self.reaches_edge(f)).then(|| self.hertz_pressure(f))
    }

    /// 2 w / (pi b), with b = sqrt(kappa w).
    fn hertz_pressure(&self, f: f64) -> f64 {
        2.0 / std::f64::consts::PI * (f.max(0.0) / self.length / self.kappa).sqrt()
    }

    /// Length of the strip along the contact line, m.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// Lower branch of Lambert's W at -y within 3e-4, so that two or three Newton steps end at rounding: Barry,
/// Culligan-Hensley, Barry (1995), Real values of the W-function, ACM Transactions on Mathematical Software
/// 21, 161-171, for ln y < -1.
fn lower_branch(log_y: f64) -> f64 {
    let sigma = -1.0 - log_y;
    let root = sigma.sqrt();
    let falling = 1.0 - 0.0042 * sigma * (-0.0201 * root).exp();
    let inner = 1.0 + 0.3361 * std::f64::consts::FRAC_1_SQRT_2 * root / falling;
    -1.0 - sigma - 2.0 / 0.3361 * (1.0 - inner.recip())
}

/// u at the width at which the law goes over into its tangent, for the weighted mean of the reference lengths:
/// -1 - 2 ln(2 L / b).
fn u_wide() -> f64 {
    -1.0 - 2.0 * (2.0 / WIDTH_OVER_REFERENCE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const STEEL: f64 = (1.0 - 0.09) / 206e9;

    fn law() -> LocalContact {
        let body = |reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
        };
        LocalContact::new(
            [body(1.2e-3), body(2.0e-3)],
            7e-3,
            0.6e-3,
            f64::NEG_INFINITY,
        )
    }

    #[test]
    fn the_inverse_satisfies_the_stated_law() {
        let law = law();
        for w in [1e-3, 1.0, 1e3, 1e5, 5e5] {
            let b = (4.0 * w * 7e-3 * 2.0 * STEEL / std::f64::consts::PI).sqrt();
            let h: f64 = [1.2e-3, 2.0e-3]
                .iter()
                .map(|l| 2.0 * STEEL / std::f64::consts::PI * w * ((2.0 * l / b).ln() + 0.5))
                .sum();
            assert_relative_eq!(law.force(h).0, w * 0.6e-3, max_relative = 1e-13);
        }
    }

    #[test]
    fn the_derivative_is_that_of_the_force() {
        let law = law();
        for x in [1e-9, 1e-7, 2e-6, 1e-5, 1e-3, 1e-2] {
            let d = 1e-5 * x;
            let numeric = (law.force(x + d).0 - law.force(x - d).0) / (2.0 * d);
            assert_relative_eq!(law.force(x).1, numeric, max_relative = 1e-8);
        }
    }

    #[test]
    fn the_energy_is_the_integral_of_the_force() {
        let bodies = [1.2e-3, 2.0e-3].map(|reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
        });
        for edge_slope in [f64::NEG_INFINITY, -5e-3, 0.0, 0.02] {
            let law = LocalContact::new(bodies, 7e-3, 0.6e-3, edge_slope);
            for x in [1e-8, 1e-6, 5e-6, 2e-5, 1e-4, 1e-3] {
                let d = 1e-4 * x;
                let slope = (law.energy(x + d) - law.energy(x - d)) / (2.0 * d);
                assert_relative_eq!(law.force(x).0, slope, max_relative = 1e-6);
            }
            assert_eq!(law.energy(-1e-6), 0.0);
        }
    }

    #[test]
    fn pressure_is_that_of_hertz_for_two_cylinders() {
        // p = sqrt(w E* / (pi R)), 1/E* = 2 (1 - nu^2) / E.
        let p = (1e5 / (2.0 * STEEL) / (std::f64::consts::PI * 7e-3)).sqrt();
        assert_relative_eq!(
            law().pressure(1e5 * 0.6e-3).unwrap(),
            p,
            max_relative = 1e-13
        );
    }
}
