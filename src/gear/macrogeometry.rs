//! One gear: basic rack, size, material and body, and what follows from them in closed form.

use std::f64::consts::FRAC_PI_2;

use serde::{Deserialize, Serialize};

use crate::words::shown;

/// Whether the teeth stand outward or inward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GearKind {
    /// Teeth outward, held at its bore.
    External,
    /// Internal teeth, held at its outer rim.
    Ring,
}

/// Macrogeometry and material of one gear, SI.
///
/// Public fields are the independent data; everything else is a method. A `Gear` of a checked pair file has passed all
/// checks there. Files carry units in the names; those of version 0.1.0 of packed units have the names without. What may be
/// absent is left out where it is none, so that files without it stay what they were.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gear {
    /// External teeth or ring.
    pub kind: GearKind,
    /// Number of teeth, positive for a ring, too.
    pub teeth: u32,
    /// +1 right-handed, -1 left-handed; of no effect for a spur gear.
    pub hand: f64,
    /// Normal module, m.
    #[serde(rename = "normal_module_m", alias = "normal_module")]
    pub normal_module: f64,
    /// Normal pressure angle of the basic rack, rad.
    #[serde(rename = "normal_pressure_angle_rad", alias = "normal_pressure_angle")]
    pub normal_pressure_angle: f64,
    /// Helix angle on the reference cylinder, rad, >= 0; its sense is `hand`.
    #[serde(rename = "helix_angle_rad", alias = "helix_angle")]
    pub helix_angle: f64,
    /// Profile shift coefficient x; > 0 makes teeth thicker (ring: spaces wider).
    pub profile_shift: f64,
    /// Face width, m.
    #[serde(rename = "face_width_m", alias = "face_width")]
    pub face_width: f64,
    /// z of this gear's z = 0 face minus that of gear 1, m (0 for gear 1).
    #[serde(rename = "face_offset_m", alias = "face_offset")]
    pub face_offset: f64,
    /// Tip radius, m (ring: the inner radius).
    #[serde(rename = "tip_radius_m", alias = "tip_radius")]
    pub tip_radius: f64,
    /// Radial height of the chamfer or rounding at the tips, m, >= 0: the involute ends this far from the tip circle.
    #[serde(rename = "tip_chamfer_m", alias = "tip_chamfer")]
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tip_chamfer: f64,
    /// Radius at which the usable involute begins, m (d_Ff / 2), where the tool ends it above its own fillet, as one with
    /// protuberance does; None: the involute begins at the fillet.
    #[serde(rename = "root_form_radius_m")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root_form_radius: Option<f64>,
    /// Dedendum of the basic rack over the normal module.
    pub dedendum_coefficient: f64,
    /// Tip radius of the generating rack (ring: of the fillet) over the normal module.
    pub tool_tip_radius_coefficient: f64,
    /// Radius of the surface that is held, m: bore of an external gear, outer rim of a ring.
    #[serde(rename = "held_radius_m", alias = "held_radius")]
    pub held_radius: f64,
    /// Rim, web and hub of an external gear; None: a full disc.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<Body>,
    /// Stiffness of an elastic foundation on which the held surface rests, N/m³, alike in all directions; None: it
    /// is held rigidly.
    #[serde(rename = "foundation_n_per_m3", alias = "foundation")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foundation: Option<f64>,
    /// Thinning of each tooth (ring: widening of each space) on the base circle, m, >= 0.
    #[serde(rename = "tooth_thinning_m", alias = "tooth_thinning")]
    pub tooth_thinning: f64,
    /// Young's modulus, Pa.
    #[serde(rename = "youngs_modulus_pa", alias = "youngs_modulus")]
    pub youngs_modulus: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Gear {
    /// +1 for external teeth, -1 for a ring.
    pub fn kappa(&self) -> f64 {
        match self.kind {
            GearKind::External => 1.0,
            GearKind::Ring => -1.0,
        }
    }

    /// Number of teeth as a real number.
    pub fn z(&self) -> f64 {
        f64::from(self.teeth)
    }

    /// Transverse module, m.
    pub fn transverse_module(&self) -> f64 {
        self.normal_module / self.helix_angle.cos()
    }

    /// Transverse pressure angle at the reference cylinder, rad.
    pub fn transverse_pressure_angle(&self) -> f64 {
        (self.normal_pressure_angle.tan() / self.helix_angle.cos()).atan()
    }

    /// Base helix angle, rad, >= 0.
    pub fn base_helix_angle(&self) -> f64 {
        (self.helix_angle.tan() * self.transverse_pressure_angle().cos()).atan()
    }

    /// Density, kg/m³, as Young's modulus tells the material: steel from 100 GPa on, light metal from 40 GPa on, plastics below.
    pub fn density(&self) -> f64 {
        match self.youngs_modulus {
            modulus if modulus >= 100e9 => 7850.0,
            modulus if modulus >= 40e9 => 2700.0,
            _ => 1400.0,
        }
    }

    /// Reference radius, m.
    pub fn reference_radius(&self) -> f64 {
        0.5 * self.z() * self.transverse_module()
    }

    /// Base radius, m.
    pub fn base_radius(&self) -> f64 {
        self.reference_radius() * self.transverse_pressure_angle().cos()
    }

    /// Root radius of the generated gear, m (ring: the outer end of the space).
    pub fn root_radius(&self) -> f64 {
        // A positive shift moves the root circle outward: it moves the rack outward, and widens a ring's spaces.
        self.reference_radius()
            + self.normal_module * (self.profile_shift - self.kappa() * self.dedendum_coefficient)
    }

    /// Radius at which the involute ends at the tip, m: that of the tip form circle (d_Fa / 2).
    pub fn tip_form_radius(&self) -> f64 {
        self.tip_radius - self.kappa() * self.tip_chamfer
    }

    /// Length of roll there, m.
    pub fn tip_form_roll(&self) -> f64 {
        self.roll_length(self.tip_form_radius())
    }

    /// Half angle of the tooth (ring: of the space) on the base cylinder, rad, thinning included:
    /// psi = pi/(2z) + 2 x tan(alpha_n)/z + inv(alpha_t) - kappa j/(2 rb), j the thinning of this gear.
    pub fn half_base_angle(&self) -> f64 {
        FRAC_PI_2 / self.z()
            + 2.0 * self.profile_shift * self.normal_pressure_angle.tan() / self.z()
            + involute(self.transverse_pressure_angle())
            - self.kappa() * self.tooth_thinning / (2.0 * self.base_radius())
    }

    /// Length of roll sqrt(r^2 - rb^2) at radius `r`, m: the radius of curvature of the involute in
    /// the transverse plane. NaN below the base circle.
    pub fn roll_length(&self, radius: f64) -> f64 {
        let rb = self.base_radius();
        ((radius - rb) * (radius + rb)).sqrt()
    }

    /// Radius at the length of roll `roll`, m.
    pub fn radius_at_roll(&self, roll: f64) -> f64 {
        roll.hypot(self.base_radius())
    }

    /// (1 - nu²) / E, 1/Pa: compliance in plane strain.
    pub fn plane_compliance(&self) -> f64 {
        (1.0 - self.poisson_ratio.powi(2)) / self.youngs_modulus
    }

    /// Refuses numbers that no checked pair file gives; `name` is that of the gear in the file.
    pub(super) fn check(&self, name: &str) -> Result<(), GeometryError> {
        let any = [f64::MIN_POSITIVE, f64::MAX];
        let (alpha_n, round) = (self.normal_pressure_angle, self.tool_tip_radius_coefficient);
        for (field, value, [low, high]) in [
            ("normal_module_m", self.normal_module, any),
            ("face_width_m", self.face_width, any),
            ("tip_radius_m", self.tip_radius, any),
            ("dedendum_coefficient", self.dedendum_coefficient, any),
            ("held_radius_m", self.held_radius, any),
            ("youngs_modulus_pa", self.youngs_modulus, any),
            ("foundation_n_per_m3", self.foundation.unwrap_or(1.0), any),
            (
                "root_form_radius_m",
                self.root_form_radius.unwrap_or(1.0),
                any,
            ),
            ("normal_pressure_angle_rad", alpha_n, [1e-9, 0.8]),
            ("helix_angle_rad", self.helix_angle, [0.0, 1.4]),
            ("profile_shift", self.profile_shift, [-10.0, 10.0]),
            ("face_offset_m", self.face_offset, [-1e3, 1e3]),
            ("tool_tip_radius_coefficient", round, [0.0, 2.0]),
            ("tooth_thinning_m", self.tooth_thinning, [-1.0, 1.0]),
            ("tip_chamfer_m", self.tip_chamfer, [0.0, 1e3]),
            ("poisson_ratio", self.poisson_ratio, [-1.0, 0.5]),
            ("teeth", self.z(), [1.0, f64::MAX]),
        ] {
            let reason = match [low, high] {
                range if range == any => "it must be positive".to_owned(),
                [_, f64::MAX] => format!("it must be at least {low}"),
                _ => format!("it must lie in [{low}, {high}]"),
            };
            let is_within = (low..=high).contains(&value);
            ensure(is_within, &format!("{name}.{field}"), value, &reason)?;
        }
        let (hand, field) = (self.hand, format!("{name}.hand"));
        ensure(hand.abs() == 1.0, &field, hand, "it must be 1 or -1")?;
        let Some(body) = &self.body else {
            return Ok(());
        };
        let ([w0, w1], [h0, h1]) = (body.web, body.hub);
        let is_nested = h0 <= w0 && w0 < w1 && w1 <= h1 && (h1 - h0).is_finite();
        let (hub, rim) = (body.hub_radius, body.rim_radius);
        let is_stepped = rim > hub || body.is_shaft() && rim == hub;
        let is_fine = is_nested && is_stepped && hub > 0.0 && rim.is_finite();
        let reason = "rim, web and hub must follow each other from outside to inside, the web within the hub's ends";
        let field = format!("{name}.body");
        ensure(is_fine, &field, format!("{body:?}"), reason)
    }
}

/// Rim, web and hub of an external gear, a solid of revolution that fills
///
/// ```text
///   rim   rim_radius .. root circle   over the face
///   web   hub_radius .. rim_radius    over `web`
///   hub   held radius .. hub_radius   over `hub`
/// ```
///
/// with sharp corners between them. z counts from the gear's z = 0 face. A pinion shaft is of this kind, too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Inner radius of the rim, m.
    #[serde(rename = "rim_radius_m", alias = "rim_radius")]
    pub rim_radius: f64,
    /// z of both faces of the web, m, ascending, within the face unless it is a shaft.
    #[serde(rename = "web_z_m", alias = "web")]
    pub web: [f64; 2],
    /// Outer radius of the hub, m; the held radius where the web reaches down to it.
    #[serde(rename = "hub_radius_m", alias = "hub_radius")]
    pub hub_radius: f64,
    /// z of both ends of the hub, m, ascending; they may lie beyond the face, and enclose the web.
    #[serde(rename = "hub_z_m", alias = "hub")]
    pub hub: [f64; 2],
    /// Which ends of a shaft (at low and at high z) are held in place of the bore; a gear on a shaft has none.
    #[serde(default, skip_serializing_if = "is_held_at_its_bore")]
    pub held_ends: [bool; 2],
}

fn is_held_at_its_bore(held_ends: &[bool; 2]) -> bool {
    *held_ends == [false; 2]
}

impl Body {
    /// Whether it is a shaft, held at an end.
    pub fn is_shaft(&self) -> bool {
        !is_held_at_its_bore(&self.held_ends)
    }
}

/// A number that no gear of a checked pair file has.
#[derive(Debug, thiserror::Error)]
#[error("geometry.{0}; make this file again from the pair file")]
pub struct GeometryError(String);

pub(super) fn ensure(
    is_fine: bool,
    field: &str,
    value: impl ToString,
    reason: &str,
) -> Result<(), GeometryError> {
    if is_fine {
        return Ok(());
    }
    let value = shown(&value.to_string());
    Err(GeometryError(format!("{field} = {value}: {reason}")))
}

/// Involute function inv(alpha) = tan(alpha) - alpha, rad.
pub fn involute(alpha: f64) -> f64 {
    alpha.tan() - alpha
}

/// The angle in [0, pi/2) whose involute function is `value` >= 0, rad; NaN for a negative value.
pub fn inverse_involute(value: f64) -> f64 {
    if value.is_nan() || value < 0.0 {
        return f64::NAN;
    }
    // t - atan(t) = value with t = tan(alpha); the left side is convex and rises, so Newton converges from the right.
    let mut t = (3.0 * value).cbrt() + value;
    for _ in 0..64 {
        // d/dt (t - atan t) = t^2 / (1 + t^2).
        let step = (t - t.atan() - value) * (1.0 + t * t) / (t * t).max(f64::MIN_POSITIVE);
        t -= step;
        if step.abs() <= 1e-16 * t.abs() {
            break;
        }
    }
    t.atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_involute_inverts_from_zero_to_near_a_right_angle() {
        assert_eq!(inverse_involute(0.0), 0.0);
        assert!(inverse_involute(-1e-9).is_nan());
        for k in 1..150 {
            let alpha = 0.01 * f64::from(k);
            let back = inverse_involute(involute(alpha));
            // inv' = tan^2, so that rounding of inv is magnified by 1 / tan^2.
            let bound = 1e-15 * (1.0 + 1.0 / alpha.tan().powi(2));
            assert!((back - alpha).abs() < bound, "{alpha}: {back}");
        }
    }
}
