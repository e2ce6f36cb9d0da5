//! The fillet that a rack leaves at the root of an external tooth.
//!
//! In its normal section the rack has straight flanks at the normal pressure angle and a tip round of
//! radius rho that touches flank and tip line. In the transverse section, in which the gear is generated
//! by plain rolling, tangential lengths are longer by 1 / cos beta, so that the round is an ellipse.
//! The tooth is what the rack leaves over while its pitch line rolls on the reference circle: a point of
//! the rack cuts last where its normal passes through the pitch point (law of gearing; Litvin and
//! Fuentes, Gear Geometry and Applied Theory, 2004, ch. 6).

use crate::root::bisection;
use std::f64::consts::FRAC_PI_2;

use super::Gear;

/// Rack flank and tip round beside the +theta flank of a tooth whose centre line is theta = 0.
///
/// Rack coordinates: s tangential (transverse) from the tooth centre line towards +theta, d from the
/// pitch line towards the gear's axis. A point of the round is given by nu, the angle of its normal in
/// the normal section: `alpha_n` where the round meets the flank, pi/2 where it meets the tip line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trochoid {
    reference_radius: f64,
    cos_beta: f64,
    normal_pressure_angle: f64,
    /// Tip radius of the rack in the normal section, m.
    round: f64,
    /// Centre of the round: s in the transverse plane and d, m.
    center: [f64; 2],
}

/// A point of the generated profile: polar coordinates and outward normal (Cartesian, unit).
pub(super) struct Cut {
    pub radius: f64,
    pub angle: f64,
    pub normal: [f64; 2],
}

impl Trochoid {
    pub(super) fn new(gear: &Gear) -> Self {
        let m = gear.normal_module;
        let alpha_n = gear.normal_pressure_angle;
        let cos_beta = gear.helix_angle.cos();
        let round = gear.tool_tip_radius_coefficient * m;
        let depth = gear.reference_radius() - gear.root_radius() - round;
        // Tooth half-thickness on the reference circle; thinning comes from a thicker rack tooth, so
        // that it leaves the root circle where it is.
        let half_thickness = m * (std::f64::consts::FRAC_PI_4 + gear.profile_shift * alpha_n.tan())
            / cos_beta
            - gear.tooth_thinning / (2.0 * gear.transverse_pressure_angle().cos());
        Trochoid {
            reference_radius: gear.reference_radius(),
            cos_beta,
            normal_pressure_angle: alpha_n,
            round,
            center: [
                half_thickness + (depth * alpha_n.tan() + round / alpha_n.cos()) / cos_beta,
                depth,
            ],
        }
    }

    /// Angle from the tooth centre at which the fillet runs into the root circle, rad.
    pub(super) fn root_angle(&self) -> f64 {
        self.center[0] / self.reference_radius
    }

    /// Length of roll at which the end of the rack's straight flank cuts, m; negative when that lies
    /// beyond the point where the line of action touches the base circle: undercut.
    pub(super) fn roll_at_flank_end(&self, gear: &Gear) -> f64 {
        let depth = self.center[1] + self.round * self.normal_pressure_angle.sin();
        let alpha_t = gear.transverse_pressure_angle();
        gear.base_radius() * alpha_t.tan() - depth / alpha_t.sin()
    }

    /// The point of the gear that the point `nu` of the round cuts.
    pub(super) fn cut(&self, nu: f64) -> Cut {
        let (sin, cos) = nu.sin_cos();
        let s = self.center[0] - self.round * cos / self.cos_beta;
        let d = self.center[1] + self.round * sin;
        // Transverse normal of the round, from the rack into the gear, is (-cos nu cos beta, sin nu) in
        // (s, d). It passes through the pitch point when the rack has moved to the height y.
        let x = self.reference_radius - d;
        let y = -d * self.cos_beta * cos / sin;
        let turned = (y - s) / self.reference_radius;
        let (n_radial, n_tangential) = (sin, cos * self.cos_beta);
        let norm = n_radial.hypot(n_tangential);
        let (st, ct) = turned.sin_cos();
        Cut {
            radius: x.hypot(y),
            angle: y.atan2(x) - turned,
            normal: [
                (n_radial * ct + n_tangential * st) / norm,
                (n_tangential * ct - n_radial * st) / norm,
            ],
        }
    }

    /// nu at the upper end of the fillet: of the end of the rack's flank, or with undercut of the point
    /// where the fillet crosses the involute.
    pub(super) fn upper_end(&self, gear: &Gear) -> f64 {
        let alpha_n = self.normal_pressure_angle;
        if self.roll_at_flank_end(gear) >= 0.0 {
            return alpha_n;
        }
        // Beyond (at smaller nu) the fillet lies outside the tooth that the involute bounds. Below the
        // base circle there is no involute: the tooth ends at the fillet.
        let rb = gear.base_radius();
        let outside = |nu: f64| {
            let cut = self.cut(nu);
            cut.radius > rb && {
                let t = gear.roll_length(cut.radius) / rb;
                cut.angle > gear.half_base_angle() - (t - t.atan())
            }
        };
        bisection([alpha_n, FRAC_PI_2], 60, outside)
    }
}
