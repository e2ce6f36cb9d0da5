//! One gear: basic rack, size, material and body, and what follows from them in closed form.

use std::f64::consts::{FRAC_PI_2, PI};

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
/// Public fields are the independent data; everything else is a method. A `Gear` out of [`crate::pair`] has passed all
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

    /// The body as rings, from the axis outwards, that end at the radius `outer` (m) within the teeth; for a ring
    /// gear the one from there to the held surface.
    pub fn annuli(&self, outer: f64) -> Vec<Annulus> {
        let face = [0.0, self.face_width];
        let whole = |radii| Annulus { radii, z: face };
        match (self.kind, self.body) {
            (GearKind::Ring, _) => vec![whole([outer, self.held_radius])],
            (_, None) => vec![whole([self.held_radius, outer])],
            (_, Some(body)) => [
                ([self.held_radius, body.hub_radius], body.hub),
                ([body.hub_radius, body.rim_radius], body.web),
                ([body.rim_radius, outer], face),
            ]
            .map(|(radii, z)| Annulus { radii, z })
            .into_iter()
            .filter(|ring| ring.radii[1] > ring.radii[0])
            .collect(),
        }
    }

    /// The gear turned end for end, where its body is another one then, by a billionth of a metre or more.
    pub fn turned(&self) -> Option<Gear> {
        let body = self.body?;
        let turned = body.mirrored(self.face_width);
        let near = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        let is_symmetric = near(body.web, turned.web)
            && near(body.hub, turned.hub)
            && body.held_ends == turned.held_ends;
        (!is_symmetric).then(|| Gear {
            body: Some(turned),
            ..self.clone()
        })
    }

    /// Displacement of the teeth along the line of action per force there that the body causes between them and where it is
    /// held, m/N: an estimate by its twist, the tilt of a web, the bending of a shaft and the foundation.
    pub fn body_compliance(&self) -> f64 {
        self.base_radius().powi(2) * self.body_twist() + self.body_tilt_and_foundation()
    }

    /// Angle by which the body twists under a torque on the teeth, rad/(N m): rings in shear; a shaft by Saint-Venant's torsion
    /// from mid-face to the ends that are held, and in shear outside of it.
    pub fn body_twist(&self) -> f64 {
        let shear_modulus = 0.5 * self.youngs_modulus / (1.0 + self.poisson_ratio);
        let mut annuli = self.annuli(self.root_radius());
        let mut torsion = 0.0;
        if let Some(body) = self.body.filter(Body::is_shaft) {
            let polar = |radius: f64| 0.5 * PI * (radius.powi(4) - self.held_radius.powi(4));
            // Of the teeth's part half a face; beyond, the radius of what reaches out there.
            let stiffness = |end: usize| {
                let out = |z: f64| if end == 0 { -z } else { z - self.face_width };
                let [thick, whole] = [out(body.web[end]), out(body.hub[end])];
                let compliance = 0.5 * self.face_width / polar(self.root_radius())
                    + thick / polar(body.rim_radius)
                    + (whole - thick) / polar(body.hub_radius);
                f64::from(body.held_ends[end]) * shear_modulus / compliance
            };
            torsion = (stiffness(0) + stiffness(1)).recip();
            annuli.retain(|ring| ring.radii[0] >= body.rim_radius);
        }
        let shear = annuli.iter().map(|ring| {
            let ([inner, outer], [low, high]) = (ring.radii, ring.z);
            (inner.powi(-2) - outer.powi(-2)) / (4.0 * PI * shear_modulus * (high - low))
        });
        torsion + shear.sum::<f64>()
    }

    /// Displacement of the teeth along the line of action per force there that a web and a foundation add to the
    /// twist, m/N: the tilt of the web under the axial force (a plate between two stiff discs: Timoshenko,
    /// Woinowsky-Krieger, Theory of Plates and Shells, section 63), the bending of a shaft from its held ends to mid-face, and
    /// the foundation. An estimate of its size.
    pub fn body_tilt_and_foundation(&self) -> f64 {
        let web = self.body.filter(|body| !body.is_shaft());
        let tilt = web.map_or(0.0, |body| {
            let thickness = body.web[1] - body.web[0];
            let plate = self.youngs_modulus * thickness.powi(3)
                / (12.0 * (1.0 - self.poisson_ratio.powi(2)));
            let [a, b] = [body.hub_radius, body.rim_radius].map(|r| r * r);
            let lever = self.reference_radius() * self.base_helix_angle().tan();
            lever.powi(2) * (0.5 * (b / a).ln() - (b - a) / (b + a)) / (4.0 * PI * plate)
        });
        let bending = self.body.filter(Body::is_shaft).map_or(0.0, |body| {
            let area_moment = 0.25 * PI * (body.hub_radius.powi(4) - self.held_radius.powi(4));
            let middle = 0.5 * self.face_width;
            let arms = [middle - body.hub[0], body.hub[1] - middle];
            // A cantilever; between two held ends the middle does not turn.
            let is_between = body.held_ends == [true; 2];
            let factor = if is_between { 12.0 } else { 3.0 };
            let held = (arms.iter().zip(body.held_ends)).filter(|(_, held)| *held);
            let stiffness =
                held.map(|(arm, _)| factor * self.youngs_modulus * area_moment / arm.powi(3));
            stiffness.sum::<f64>().recip()
        });
        let foundation = self.foundation.map_or(0.0, |stiffness| {
            let area = 2.0 * PI * self.held_radius * self.face_width;
            // Turned as a whole, and moved along the line of action.
            ((self.base_radius() / self.held_radius).powi(2) + 1.0) / (stiffness * area)
        });
        tilt + bending + foundation
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
/// with sharp corners between them. z counts from the gear's z = 0 face. A pinion [`Body::shaft`] is of this kind, too.
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

/// A piece of shaft on one side of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stub {
    /// m, below the root radius of the teeth.
    pub radius: f64,
    /// From the face to its end, m; 0: there is none.
    pub length: f64,
    /// Whether the end is held: there the shaft of the multibody model takes over.
    pub held: bool,
}

impl Body {
    /// The shaft that teeth of the width `face_width` (m) are cut from, with its pieces at low and at high z: solid
    /// below the root circle, held at the ends that say so, its bore free.
    pub fn shaft(stubs: [Stub; 2], face_width: f64) -> Body {
        let [low, high] = stubs;
        let whole = [-low.length, face_width + high.length];
        let (thin, thick) = match stubs.map(|stub| stub.length > 0.0) {
            [true, false] => (low.radius, low.radius),
            [false, true] => (high.radius, high.radius),
            _ => (low.radius.min(high.radius), low.radius.max(high.radius)),
        };
        Body {
            rim_radius: thick,
            web: match low.radius > high.radius {
                _ if thick == thin => whole,
                true => [whole[0], face_width],
                false => [0.0, whole[1]],
            },
            hub_radius: thin,
            hub: whole,
            held_ends: stubs.map(|stub| stub.held),
        }
    }

    /// Whether it is a shaft, held at an end.
    pub fn is_shaft(&self) -> bool {
        !is_held_at_its_bore(&self.held_ends)
    }

    /// The body seen with the face of width `face_width` (m) turned end for end.
    #[must_use]
    pub fn mirrored(&self, face_width: f64) -> Body {
        let turned = |z: [f64; 2]| [face_width - z[1], face_width - z[0]];
        let [low, high] = self.held_ends;
        Body {
            web: turned(self.web),
            hub: turned(self.hub),
            held_ends: [high, low],
            ..*self
        }
    }
}

/// A ring of rectangular section about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annulus {
    /// Inner and outer radius, m.
    pub radii: [f64; 2],
    /// z of both ends, m from the gear's z = 0 face.
    pub z: [f64; 2],
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
    use crate::gear::samples;
    use approx::assert_abs_diff_eq;

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

    fn webbed() -> Gear {
        Gear {
            body: Some(Body {
                rim_radius: 28e-3,
                web: [5e-3, 12e-3],
                hub_radius: 20e-3,
                hub: [-3e-3, 25e-3],
                held_ends: [false; 2],
            }),
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        }
    }

    #[test]
    fn mirroring_twice_gives_the_body_back_and_rings_join_from_the_held_surface_to_the_teeth() {
        let (gear, body) = (webbed(), webbed().body.unwrap());
        let turned = gear.turned().unwrap().body.unwrap();
        assert_eq!(turned.hub, [0.0, 28e-3]);
        let back = turned.mirrored(gear.face_width);
        assert_abs_diff_eq!(body.web[..], back.web[..], epsilon = 1e-15);
        assert_abs_diff_eq!(body.hub[..], back.hub[..], epsilon = 1e-15);
        let rings = gear.annuli(34e-3);
        assert_eq!(rings.len(), 3);
        assert_eq!(rings[0].radii[0], gear.held_radius);
        assert!(rings.windows(2).all(|w| w[0].radii[1] == w[1].radii[0]));
        assert_eq!(rings[2].radii[1], 34e-3);
        // A web that reaches the bore has no hub.
        let mut plain = gear.clone();
        plain.body.as_mut().unwrap().hub_radius = gear.held_radius;
        assert_eq!(plain.annuli(34e-3).len(), 2);
    }
}
