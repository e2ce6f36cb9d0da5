//! The transverse section of one tooth: involute flank, fillet and root circle.

use std::f64::consts::{FRAC_PI_2, PI};

use super::trochoid::Trochoid;
use super::{Gear, GearKind};

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
    /// Cut by a rack; `upper_end` is its parameter where the involute begins.
    Trochoid { curve: Trochoid, upper_end: f64 },
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

/// Fillet of a ring, the length of roll at which it touches the involute, m, and its angle at the root circle, rad; None when
/// the root circle lies so deep inside that it cannot.
fn ring_fillet(gear: &Gear) -> Option<(Fillet, f64, f64)> {
    let rb = gear.base_radius();
    let radius = gear.tool_tip_radius_coefficient * gear.normal_module;
    let center_radius = gear.root_radius() - radius;
    // A parallel to an involute is an involute of the same base circle, its length of roll less by the distance on the
    // hollow side, where the space is.
    let center_roll = gear.roll_length(center_radius);
    let roll = center_roll + radius;
    let t = roll / rb;
    let angle = PI / gear.z() - gear.half_base_angle() + t - t.atan();
    // The flank normal touches the base circle ahead of the flank by atan(t); both the point of contact and the centre
    // lie on it.
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
    /// Generates the profile of `gear`: external teeth by a rack ([`Gear::dedendum_coefficient`],
    /// [`Gear::tool_tip_radius_coefficient`], [`Gear::profile_shift`]), rings with an arc of the radius
    /// `tool_tip_radius_coefficient` times the normal module that touches involute and root circle.
    ///
    /// # Errors
    /// [`ProfileError`] when these data leave no tooth.
    pub fn new(gear: &Gear) -> Result<Self, ProfileError> {
        let (fillet, form_roll, root_angle) = match gear.kind {
            GearKind::External => {
                if gear.root_radius().is_nan() || gear.root_radius() <= 0.0 {
                    return Err(ProfileError::RootCircle);
                }
                let curve = Trochoid::new(gear);
                let upper_end = curve.upper_end(gear);
                let end_of_flank = curve.roll_at_flank_end(gear);
                let form_roll = match end_of_flank >= 0.0 {
                    true => end_of_flank,
                    false => gear.roll_length(curve.cut(upper_end).radius),
                };
                let fillet = Fillet::Trochoid { curve, upper_end };
                (fillet, form_roll, curve.root_angle())
            }
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

    /// Length of roll at the start of the involute, m. 0 or more, the tip's is larger for external
    /// teeth and smaller for a ring.
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
            Fillet::Trochoid { curve, .. } => curve.roll_at_flank_end(&self.gear) < 0.0,
            Fillet::Arc { .. } => false,
        }
    }

    /// Point of the involute at the length of roll `roll` >= 0, m. It is the flank between
    /// [`ToothProfile::form_roll`] and the tip; outside it is the involute continued.
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
            Fillet::Trochoid { curve, upper_end } => {
                let cut = curve.cut(FRAC_PI_2 + t * (upper_end - FRAC_PI_2));
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
mod tests;
