//! Two gears in mesh: what the transverse section and the face overlap say in closed form.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use super::macrogeometry::ensure;
use super::{Gear, GearKind, GeometryError, involute};

/// The loaded flank of gear 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Flank {
    /// Gear 1 pushes in its +theta sense (s = +1).
    Drive,
    /// Gear 1 pushes in its -theta sense (s = -1).
    Coast,
}

impl Flank {
    /// s of the formulas: +1 drive, -1 coast.
    pub fn sign(self) -> f64 {
        match self {
            Flank::Drive => 1.0,
            Flank::Coast => -1.0,
        }
    }
}

/// What both gears have on both flanks. The default: none has any.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BothFlanks<T> {
    /// Gear 1 and gear 2, the flanks that touch when gear 1 turns in its + sense and drives. On gear 1 and on
    /// gear 2 of an external pair they face +theta, on gear 2 of an internal pair -theta.
    pub drive: [T; 2],
    /// The other flanks.
    pub coast: [T; 2],
}

impl<T> BothFlanks<T> {
    /// Gear 1 and gear 2 on the loaded flanks.
    pub fn flank(&self, flank: Flank) -> &[T; 2] {
        match flank {
            Flank::Drive => &self.drive,
            Flank::Coast => &self.coast,
        }
    }
}

/// Limits of contact on the line of action, from the pitch point, positive in the sense in which contact moves while gear 1
/// turns in the sense of its loaded flank, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Where gear 2's tip enters (negative).
    pub start: f64,
    /// Where gear 1's tip leaves (positive).
    pub end: f64,
}

impl PathOfContact {
    /// Length of the path of contact, m.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }
}

/// Two gears in mesh, SI. At most one of them is a ring. Its serialised form is what tables and
/// packed units carry: plain SI values, nothing derived.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairGeometry {
    /// Gear 1 and gear 2.
    pub gears: [Gear; 2],
    /// Nominal centre distance, m, > 0.
    pub center_distance: f64,
}

impl PairGeometry {
    /// e: +1 external, -1 internal pair.
    pub fn e(&self) -> f64 {
        self.gears[0].kappa() * self.gears[1].kappa()
    }

    /// Whether z is mirrored to make gear `i` (0 or 1) a right-handed one whose loaded flank faces +theta.
    ///
    /// The loaded flank faces the sense sigma_1 = s on gear 1 and sigma_2 = e s on gear 2. A mirror theta -> -theta
    /// turns over both sigma and the hand, a mirror z -> -z the hand alone; so theta is mirrored for sigma = -1 and z for
    /// h sigma = -1.
    pub fn is_mirrored(&self, flank: Flank, i: usize) -> bool {
        let s = flank.sign();
        let sigma = if i == 0 { s } else { self.e() * s };
        self.gears[i].hand * sigma < 0.0
    }

    /// z1 + e z2.
    fn tooth_sum(&self) -> f64 {
        self.gears[0].z() + self.e() * self.gears[1].z()
    }

    /// sc = sign(z1 + e z2): the mesh lies at `sc` times the direction O1 -> O2, seen from O1.
    pub fn sc(&self) -> f64 {
        self.tooth_sum().signum()
    }

    /// abs(rb1 + e rb2), m: the sum (internal: the difference) of the base radii.
    pub fn base_radius_sum(&self) -> f64 {
        (self.gears[0].base_radius() + self.e() * self.gears[1].base_radius()).abs()
    }

    /// Index of the ring, if one of the gears is one.
    pub fn ring(&self) -> Option<usize> {
        self.gears.iter().position(|g| g.kind == GearKind::Ring)
    }

    /// Transverse base pitch, m.
    pub fn base_pitch(&self) -> f64 {
        2.0 * std::f64::consts::PI * self.gears[0].base_radius() / self.gears[0].z()
    }

    /// Base helix angle, rad, >= 0.
    pub fn base_helix_angle(&self) -> f64 {
        self.gears[0].base_helix_angle()
    }

    /// Operating transverse pressure angle at `center_distance`, rad, (15). NaN where the base
    /// circles are farther apart than the centre distance allows.
    pub fn operating_pressure_angle(&self, center_distance: f64) -> f64 {
        (self.base_radius_sum() / center_distance).acos()
    }

    /// inv phi_0: involute of the pressure angle at which teeth without thinning mesh without
    /// backlash, inv alpha_t + 2 tan alpha_n (x1 + e x2) / (z1 + e z2).
    pub fn backlash_free_involute(&self) -> f64 {
        let [first, second] = &self.gears;
        let shift = first.profile_shift + self.e() * second.profile_shift;
        involute(first.transverse_pressure_angle())
            + 2.0 * first.normal_pressure_angle.tan() * shift / self.tooth_sum()
    }

    /// Effective mass along the line of action, kg, of both gears that spin as discs between the surface that is held and the
    /// reference cylinder: what `effectiveMass` = 0 stands for, as modelDescription.xml says. The mass that packing writes counts rim and
    /// web, too.
    pub fn disc_mass(&self) -> f64 {
        let mobility = self.gears.each_ref().map(|gear| {
            let [reference, held] = [gear.reference_radius(), gear.held_radius].map(|r| r.powi(4));
            let inertia = 0.5 * PI * gear.density() * gear.face_width * (reference - held).abs();
            gear.base_radius().powi(2) / inertia
        });
        (mobility[0] + mobility[1]).recip()
    }

    /// Operating pitch radius of gear `i` (0 or 1) at `center_distance`, m, (3).
    pub fn operating_pitch_radius(&self, i: usize, center_distance: f64) -> f64 {
        self.gears[i].z() * center_distance / self.tooth_sum().abs()
    }

    /// Backlash on the line of action at `center_distance`, m: the way from one flank to the other,
    /// j + 2 e abs(rb1 + e rb2) (inv phi - inv phi_0).
    pub fn backlash(&self, center_distance: f64) -> f64 {
        let phi = self.operating_pressure_angle(center_distance);
        let opening = involute(phi) - self.backlash_free_involute();
        let [first, second] = self.gears.each_ref().map(|gear| gear.tooth_thinning);
        first + second + 2.0 * self.e() * self.base_radius_sum() * opening
    }

    /// Length of roll on gear `i` (0 or 1) at the distance `xi` from the pitch point, m:
    /// rho_1 = rb1 tan phi + kappa_1 xi, rho_2 = rb2 tan phi - kappa_2 xi.
    pub fn roll_at(&self, i: usize, center_distance: f64, xi: f64) -> f64 {
        let tan_phi = self.operating_pressure_angle(center_distance).tan();
        self.gears[i].base_radius() * tan_phi + self.side(i) * xi
    }

    /// Distance from the pitch point at which the length of roll on gear `i` (0 or 1) is `roll`, m.
    pub fn distance_at_roll(&self, i: usize, center_distance: f64, roll: f64) -> f64 {
        (roll - self.roll_at(i, center_distance, 0.0)) / self.side(i)
    }

    /// Growth of the length of roll on gear `i` with the distance from the pitch point.
    fn side(&self, i: usize) -> f64 {
        [1.0, -1.0][i] * self.gears[i].kappa()
    }

    /// Path of contact at `center_distance`, tip to tip.
    pub fn path_of_contact(&self, center_distance: f64) -> PathOfContact {
        let tan_phi = self.operating_pressure_angle(center_distance).tan();
        let beyond = |g: &Gear| g.kappa() * (g.tip_form_roll() - g.base_radius() * tan_phi);
        PathOfContact {
            start: -beyond(&self.gears[1]),
            end: beyond(&self.gears[0]),
        }
    }

    /// Length of roll on gear `i` (0 or 1) where the mate's tip touches, m: the start of its active
    /// profile at `center_distance`.
    pub fn active_start_roll(&self, i: usize, center_distance: f64) -> f64 {
        let path = self.path_of_contact(center_distance);
        let xi = if i == 0 { path.start } else { path.end };
        self.roll_at(i, center_distance, xi)
    }

    /// Transverse contact ratio at `center_distance`.
    pub fn transverse_contact_ratio(&self, center_distance: f64) -> f64 {
        self.path_of_contact(center_distance).length() / self.base_pitch()
    }

    /// Clearance between the tip of gear `i` and the root of its mate at `center_distance`, m; at or below zero they meet.
    pub fn tip_clearance(&self, i: usize, center_distance: f64) -> f64 {
        let (gear, mate) = (&self.gears[i], &self.gears[1 - i]);
        let (tip, root) = (gear.tip_radius, mate.root_radius());
        match (gear.kind, mate.kind) {
            (GearKind::External, GearKind::External) => center_distance - tip - root,
            (GearKind::External, GearKind::Ring) => root - center_distance - tip,
            (GearKind::Ring, _) => tip - center_distance - root,
        }
    }

    /// Overlap of both faces as (z of its lower end, width), m, in gear 1's frame.
    pub fn face_overlap(&self) -> (f64, f64) {
        let g = &self.gears;
        let low = g[0].face_offset.max(g[1].face_offset);
        let high = (g[0].face_offset + g[0].face_width).min(g[1].face_offset + g[1].face_width);
        (low, high - low)
    }

    /// Mid-face of the overlap in gear 1's frame, m: the reference of delta, M and z_c.
    pub fn z_ref(&self) -> f64 {
        let (low, width) = self.face_overlap();
        low + 0.5 * width
    }

    /// Overlap ratio: face overlap x tan beta_b / base pitch.
    pub fn overlap_ratio(&self) -> f64 {
        self.face_overlap().1 * self.base_helix_angle().tan() / self.base_pitch()
    }

    /// Spin of gear 1 against gear 2 over that of gear 1, against the line of centres: abs(1 + e z1 / z2).
    pub fn sliding_per_spin(&self) -> f64 {
        (1.0 + self.e() * self.gears[0].z() / self.gears[1].z()).abs()
    }

    /// Sum of the rolling speeds of both flanks at the pitch point over the spin of gear 1 against the line of
    /// centres, m, at `center_distance` (m): 2 rb1 tan phi.
    pub fn rolling_speed_per_spin(&self, center_distance: f64) -> f64 {
        2.0 * self.gears[0].base_radius() * self.operating_pressure_angle(center_distance).tan()
    }

    /// Relative radius of curvature at the pitch point of the nominal centre distance, m, normal section.
    pub fn pitch_point_radius(&self) -> f64 {
        let tan_phi = self.operating_pressure_angle(self.center_distance).tan();
        let curvature = |g: &Gear| g.kappa() / (g.base_radius() * tan_phi);
        let transverse = curvature(&self.gears[0]) + curvature(&self.gears[1]);
        1.0 / (transverse * self.base_helix_angle().cos())
    }

    /// Refuses numbers that no checked pair file gives.
    ///
    /// # Errors
    /// The first such number, by field.
    pub fn check(&self) -> Result<(), GeometryError> {
        self.gears[0].check("gear1")?;
        self.gears[1].check("gear2")?;
        let has_external = self.gears.iter().any(|g| g.kind == GearKind::External);
        ensure(has_external, "gear2.kind", "ring", "both gears are rings")?;
        let (distance, least) = (self.center_distance, self.base_radius_sum());
        let is_mesh = distance > least && distance.is_finite() && least > 0.0;
        let reason =
            format!("it must be above {least}, where the base circles leave no pressure angle");
        ensure(is_mesh, "center_distance_m", distance, &reason)?;
        let (offset, overlap) = (self.gears[1].face_offset, self.face_overlap().1);
        let reason = "the faces do not overlap";
        ensure(overlap > 0.0, "gear2.face_offset_m", offset, reason)
    }
}

/// The numbers of a pair that are needed again and again, worked out once: in [`PairGeometry`] they follow from the nominal data
/// through several angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairNumbers {
    /// Of gear 1 and gear 2, m, as all pairs below.
    pub base_radius: [f64; 2],
    /// +1 external gear, -1 ring.
    pub kappa: [f64; 2],
    /// +1 external, -1 internal pair.
    pub e: f64,
    /// Growth of the lengths of roll with the conjugate position: q = kappa_1 for gear 1 and -kappa_2 for gear 2.
    pub q: [f64; 2],
    /// abs(rb1 + e rb2), m.
    pub base_radius_sum: f64,
    /// Transverse base pitch, m.
    pub base_pitch: f64,
    /// Of the base helix angle, >= 0.
    pub tan_beta_b: f64,
    /// Of the base helix angle.
    pub cos_beta_b: f64,
    /// +1 right-handed helix of gear 1, -1 left-handed.
    pub hand: f64,
    /// Mid-face of the overlap in gear 1's frame, m.
    pub z_ref: f64,
    /// The overlap of both faces in gear 1's frame: lower end and width, m.
    pub face: [f64; 2],
    /// Lengths of roll at the ends of the involutes at the tips, m.
    pub tip_roll: [f64; 2],
    /// z of the z = 0 face of each gear in gear 1's frame, m.
    pub face_offset: [f64; 2],
}

impl PairNumbers {
    /// Those of `pair`.
    pub fn new(pair: &PairGeometry) -> PairNumbers {
        let each = |number: fn(&Gear) -> f64| pair.gears.each_ref().map(number);
        let (low, width) = pair.face_overlap();
        let kappa = each(Gear::kappa);
        PairNumbers {
            base_radius: each(Gear::base_radius),
            kappa,
            e: pair.e(),
            q: [kappa[0], -kappa[1]],
            base_radius_sum: pair.base_radius_sum(),
            base_pitch: pair.base_pitch(),
            tan_beta_b: pair.base_helix_angle().tan(),
            cos_beta_b: pair.base_helix_angle().cos(),
            hand: pair.gears[0].hand,
            z_ref: pair.z_ref(),
            face: [low, width],
            tip_roll: each(Gear::tip_form_roll),
            face_offset: each(|gear| gear.face_offset),
        }
    }
}

#[cfg(test)]
mod tests;
