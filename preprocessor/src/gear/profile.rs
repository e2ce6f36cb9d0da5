//! The transverse section of one tooth: involute flank, fillet and root circle.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use gearmesh::gear::{Gear, GearKind};
use gearmesh::root::bisection;

/// A point of the profile, in the transverse section.
///
/// Origin on the axis, x along the centre line of the tooth, y towards +theta. For a ring this frame is
/// turned by half a pitch against the body frame, whose x axis passes through a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// x and y, m.
    pub position: [f64; 2],
    /// Unit normal in the section, out of the material.
    pub normal: [f64; 2],
}

impl ProfilePoint {
    /// Distance from the axis, m.
    pub fn radius(&self) -> f64 {
        self.position[0].hypot(self.position[1])
    }

    /// Angle from the tooth's centre line, rad.
    pub fn angle(&self) -> f64 {
        self.position[1].atan2(self.position[0])
    }

    fn polar(radius: f64, angle: f64, normal: [f64; 2]) -> Self {
        ProfilePoint {
            position: [radius * angle.cos(), radius * angle.sin()],
            normal,
        }
    }
}

/// Why a gear has no usable profile.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// The flanks of a tooth meet at or before the tip circle.
    #[error("the tooth is pointed: its flanks meet before the tip circle")]
    PointedTooth,
    /// The tool's tip has no room for its round (ring: the space for two fillets).
    #[error("the tip round of the tool does not fit into the tooth space")]
    RoundTooLarge,
    /// No involute is left between fillet and tip.
    #[error("the fillet reaches the tip: no involute is left")]
    NoInvolute,
    /// The tip circle of a ring lies inside its base circle, where there is no involute.
    #[error("the tip circle of the ring lies inside its base circle")]
    TipInsideBase,
    /// The root circle has no positive radius, or the fillet arc of a ring misses the involute.
    #[error("the root circle lies where no fillet can reach it")]
    RootCircle,
}

/// Fillet of either kind.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fillet {
    /// Cut by the tip round of a rack.
    Trochoid {
        /// Centre of the round, m: s in the transverse plane and d, see [`cut`].
        center: [f64; 2],
        /// Angle nu of the round at which the involute begins, rad.
        upper_end: f64,
    },
    /// Arc of a ring, in the space beside the +theta flank.
    Arc {
        /// m.
        radius: f64,
        /// Polar coordinates of its centre, m and rad.
        center: [f64; 2],
        /// Direction from the centre to where it touches the involute, rad.
        upper_direction: f64,
    },
}

/// Tip radius of the rack in the normal section (ring: radius of the fillet), m.
fn round(gear: &Gear) -> f64 {
    gear.tool_tip_radius_coefficient * gear.normal_module
}

/// Fillet that a rack leaves at the root of an external tooth, the length of roll at the start of the involute, m, and the
/// fillet's angle at the root circle, rad.
///
/// In its normal section the rack has straight flanks at the normal pressure angle and a tip round that touches flank and
/// tip line. In the transverse section tangential lengths are longer by 1 / cos beta, so that the round is an ellipse. The
/// tooth is what the rack leaves over while its pitch line rolls on the reference circle.
fn rack_fillet(gear: &Gear) -> (Fillet, f64, f64) {
    let alpha_n = gear.normal_pressure_angle;
    let center = center_of_round(gear);
    let end_of_flank = roll_at_flank_end(gear, center);
    let (upper_end, form_roll) = if end_of_flank >= 0.0 {
        (alpha_n, end_of_flank)
    } else {
        // Undercut: where the fillet crosses the involute; at smaller nu it lies outside of that.
        let nu = bisection([alpha_n, FRAC_PI_2], 60, |nu| is_outside(gear, center, nu));
        (nu, gear.roll_length(cut(gear, center, nu).radius))
    };
    let root_angle = center[0] / gear.reference_radius();
    let fillet = Fillet::Trochoid { center, upper_end };
    (fillet, form_roll, root_angle)
}

/// Centre of the round of a rack that cuts the flanks of `gear`, m: s and d, see [`cut`].
fn center_of_round(gear: &Gear) -> [f64; 2] {
    let (alpha_n, cos_beta) = (gear.normal_pressure_angle, gear.helix_angle.cos());
    let round = round(gear);
    let depth = gear.reference_radius() - gear.root_radius() - round;
    // Tooth half-thickness on the reference circle; thinning comes from a thicker rack tooth and leaves the root circle.
    let half_thickness = gear.normal_module * (FRAC_PI_4 + gear.profile_shift * alpha_n.tan())
        / cos_beta
        - gear.tooth_thinning / (2.0 * gear.transverse_pressure_angle().cos());
    let s = half_thickness + (depth * alpha_n.tan() + round / alpha_n.cos()) / cos_beta;
    [s, depth]
}

/// Whether what the round about `center` cuts at `nu` lies outside of the involute. Below the base circle there is none: the
/// tooth ends at the fillet.
fn is_outside(gear: &Gear, center: [f64; 2], nu: f64) -> bool {
    let cut = cut(gear, center, nu);
    let t = gear.roll_length(cut.radius) / gear.base_radius();
    cut.radius > gear.base_radius() && cut.angle > gear.half_base_angle() - (t - t.atan())
}

/// Radius, m, at which the usable involute of an external `gear` begins if the tip round of its rack reaches `undercut` (m,
/// normal to the flank) deeper than the finished flank: a protuberance less the machining allowance. `angle` is that of the
/// flank of the protuberance, rad. None where that flank itself, or nothing, leaves the involute.
pub fn protuberance_form_radius(gear: &Gear, undercut: f64, angle: f64) -> Option<f64> {
    let mut center = center_of_round(gear);
    center[0] -= undercut / (gear.normal_pressure_angle.cos() * gear.helix_angle.cos());
    let range = [angle, gear.normal_pressure_angle];
    let [begins, ends] = range.map(|nu| is_outside(gear, center, nu));
    if !begins || ends {
        return None;
    }
    let nu = bisection(range, 60, |nu| is_outside(gear, center, nu));
    Some(cut(gear, center, nu).radius)
}

/// Length of roll at which the end of the rack's straight flank cuts, m; negative when that lies beyond the point where the
/// line of action touches the base circle: undercut. `center` is that of the round.
fn roll_at_flank_end(gear: &Gear, center: [f64; 2]) -> f64 {
    let depth = center[1] + round(gear) * gear.normal_pressure_angle.sin();
    let alpha_t = gear.transverse_pressure_angle();
    gear.base_radius() * alpha_t.tan() - depth / alpha_t.sin()
}

/// A point that the rack cuts: polar coordinates and outward normal (Cartesian, unit).
struct Cut {
    radius: f64,
    angle: f64,
    normal: [f64; 2],
}

/// The point of the gear that a point of the rack's round about `center` cuts: there its normal passes through the pitch
/// point (law of gearing; Litvin and Fuentes, Gear Geometry and Applied Theory, 2004, ch. 6).
///
/// Rack coordinates: s tangential (transverse) from the tooth centre line towards +theta, d from the pitch line towards the
/// gear's axis. nu is the angle of the point's normal in the normal section: `alpha_n` at the flank, pi/2 at the tip line.
fn cut(gear: &Gear, center: [f64; 2], nu: f64) -> Cut {
    let (r, cos_beta, round) = (gear.reference_radius(), gear.helix_angle.cos(), round(gear));
    let (sin, cos) = nu.sin_cos();
    let s = center[0] - round * cos / cos_beta;
    let d = center[1] + round * sin;
    // The transverse normal of the round, (-cos nu cos beta, sin nu) in (s, d), passes through the pitch point at the height y.
    let x = r - d;
    let y = -d * cos_beta * cos / sin;
    let turned = (y - s) / r;
    let (n_radial, n_tangential) = (sin, cos * cos_beta);
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

/// Fillet of a ring, the length of roll at which it touches the involute, m, and its angle at the root circle, rad; None when
/// the root circle lies so deep inside that it cannot.
fn ring_fillet(gear: &Gear) -> Option<(Fillet, f64, f64)> {
    let (rb, radius) = (gear.base_radius(), round(gear));
    let center_radius = gear.root_radius() - radius;
    // A parallel to an involute is an involute of the same base circle, its length of roll less by the distance on the
    // hollow side, where the space is.
    let center_roll = gear.roll_length(center_radius);
    let roll = center_roll + radius;
    let t = roll / rb;
    let angle = PI / gear.z() - gear.half_base_angle() + t - t.atan();
    // The flank normal, on which the centre lies, too, touches the base circle ahead of the flank by atan(t).
    let tangent_point = angle + t.atan();
    let center_angle = tangent_point - (center_roll / rb).atan();
    let fillet = Fillet::Arc {
        radius,
        center: [center_radius, center_angle],
        upper_direction: tangent_point - FRAC_PI_2,
    };
    (!roll.is_nan()).then_some((fillet, roll, center_angle))
}

/// The generated transverse section of one tooth, symmetric about its centre line.
///
/// All methods speak of the flank that faces +theta; the other is its mirror image. From the middle of
/// the tooth space (angle [`ToothProfile::half_pitch`]) the outline follows the root circle to
/// [`ToothProfile::root_angle`], the fillet ([`ToothProfile::fillet`]) to the form radius, the involute
/// ([`ToothProfile::point_on_flank`]) to the tip radius. Unmodified: microgeometry is no part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothProfile {
    gear: Gear,
    fillet: Fillet,
    form_roll: f64,
    root_angle: f64,
}

impl ToothProfile {
    /// Generates the profile of `gear`: external teeth by a rack, rings with an arc of the radius `tool_tip_radius_coefficient`
    /// times the normal module that touches involute and root circle.
    ///
    /// # Errors
    /// [`ProfileError`] when these data leave no tooth.
    pub fn new(gear: &Gear) -> Result<Self, ProfileError> {
        let (fillet, form_roll, root_angle) = match gear.kind {
            GearKind::External if gear.root_radius() > 0.0 => rack_fillet(gear),
            GearKind::External => return Err(ProfileError::RootCircle),
            GearKind::Ring => ring_fillet(gear).ok_or(ProfileError::RootCircle)?,
        };
        let profile = ToothProfile {
            gear: gear.clone(),
            fillet,
            form_roll,
            root_angle,
        };
        let tip_roll = gear.roll_length(gear.tip_radius);
        if gear.kind == GearKind::Ring && tip_roll.is_nan() {
            return Err(ProfileError::TipInsideBase);
        }
        let left = gear.kappa() * (gear.tip_form_roll() - form_roll);
        if left.is_nan() || left <= 0.0 {
            return Err(ProfileError::NoInvolute);
        }
        if root_angle.is_nan() || root_angle > profile.half_pitch() {
            return Err(ProfileError::RoundTooLarge);
        }
        if profile.involute_half_angle(tip_roll) <= 0.0 {
            return Err(ProfileError::PointedTooth);
        }
        Ok(profile)
    }

    /// The gear it belongs to.
    pub fn gear(&self) -> &Gear {
        &self.gear
    }

    /// Half of the angular pitch, rad: the middle of the tooth space.
    pub fn half_pitch(&self) -> f64 {
        PI / self.gear.z()
    }

    /// Angle at which the fillet runs into the root circle, rad.
    pub fn root_angle(&self) -> f64 {
        self.root_angle
    }

    /// Length of roll at the start of the involute that teeth may touch on, m: that of [`Gear::root_form_radius`], else
    /// [`ToothProfile::form_roll`].
    pub fn usable_roll(&self) -> f64 {
        let given = self.gear.root_form_radius;
        given.map_or(self.form_roll, |radius| self.gear.roll_length(radius))
    }

    /// Radius there, m.
    pub fn usable_radius(&self) -> f64 {
        self.gear.radius_at_roll(self.usable_roll())
    }

    /// Length of roll where fillet and involute meet, m; the tip's is larger for external teeth and smaller for a ring.
    pub fn form_roll(&self) -> f64 {
        self.form_roll
    }

    /// Radius at the start of the involute, m.
    pub fn form_radius(&self) -> f64 {
        self.gear.radius_at_roll(self.form_roll)
    }

    /// Whether the rack has cut away the start of the involute, so that fillet and flank meet in a corner.
    pub fn is_undercut(&self) -> bool {
        match self.fillet {
            Fillet::Trochoid { center, .. } => roll_at_flank_end(&self.gear, center) < 0.0,
            Fillet::Arc { .. } => false,
        }
    }

    /// Point of the involute at the length of roll `roll` >= 0, m: of the flank between [`ToothProfile::form_roll`] and the tip.
    pub fn point_on_flank(&self, roll: f64) -> ProfilePoint {
        let angle = self.involute_half_angle(roll);
        let pressure_angle = (roll / self.gear.base_radius()).atan();
        // In the radial and the tangential direction: (kappa sin alpha, cos alpha).
        let (sin, cos) = (angle + self.gear.kappa() * (FRAC_PI_2 - pressure_angle)).sin_cos();
        let normal = [self.gear.kappa() * cos, self.gear.kappa() * sin];
        ProfilePoint::polar(self.gear.radius_at_roll(roll), angle, normal)
    }

    /// Point of the fillet, `t` from 0 at the root circle to 1 at the start of the involute. The parameter runs evenly
    /// with the angle of the normal on the tool's round (ring: on the arc), so that the radius is monotone in it.
    pub fn fillet(&self, t: f64) -> ProfilePoint {
        match self.fillet {
            Fillet::Trochoid { center, upper_end } => {
                let nu = FRAC_PI_2 + t * (upper_end - FRAC_PI_2);
                let cut = cut(&self.gear, center, nu);
                ProfilePoint::polar(cut.radius, cut.angle, cut.normal)
            }
            Fillet::Arc {
                radius,
                center,
                upper_direction,
            } => {
                let direction = center[1] + t * (upper_direction - center[1]);
                let (sin, cos) = direction.sin_cos();
                let x = center[0] * center[1].cos() + radius * cos;
                let y = center[0] * center[1].sin() + radius * sin;
                ProfilePoint {
                    position: [x, y],
                    normal: [-cos, -sin],
                }
            }
        }
    }

    /// Thickness of the tooth at its tip circle, m, along the arc.
    pub fn tip_land(&self) -> f64 {
        let tip = self.gear.tip_radius;
        2.0 * tip * self.involute_half_angle(self.gear.roll_length(tip))
    }

    /// Half angle of the tooth's material at the length of roll `roll` on the involute, rad.
    fn involute_half_angle(&self, roll: f64) -> f64 {
        let t = roll / self.gear.base_radius();
        let half_base = self.gear.half_base_angle();
        match self.gear.kind {
            GearKind::External => half_base - (t - t.atan()),
            GearKind::Ring => self.half_pitch() - half_base + (t - t.atan()),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
