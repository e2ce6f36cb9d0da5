//! Tooth stiffness of ISO 6336-1:2006, method B, and nominal contact stress of ISO 6336-2:2019: an orientation beside finite elements.
//!
//! No load factor K is in them. The standard's stiffness is that of line loads from 100 N/mm on; below, the fourth root of what is there.

use std::f64::consts::PI;

use gearmesh::gear::{Gear, GearKind, PairGeometry};

/// Stiffness of a mesh by ISO 6336-1:2006, clause 9, per face width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalStiffness {
    /// Single stiffness (c'), N/m².
    pub single: f64,
    /// Mean mesh stiffness (c_gamma_alpha), N/m².
    pub mesh: f64,
    /// Mesh stiffness for the face load factor (c_gamma_beta), N/m².
    pub along_face: f64,
}

/// Line load from which on the stiffness does not depend on it, N/m.
const FULL_LINE_LOAD: f64 = 100e3;
/// Young's modulus of the gears that the standard's equation is of, Pa.
const STEEL: f64 = 206e9;

impl NominalStiffness {
    /// Of `pair` under `torque` on gear 1, N m. None beyond the standard: profile shifts with x_1 < x_2 or a sum outside -0.5 to 2.
    pub fn new(pair: &PairGeometry, torque: f64) -> Option<NominalStiffness> {
        let (pinion, wheel) = pinion_and_wheel(pair);
        let [x1, x2] = [pinion, wheel].map(shift);
        let is_covered = x1 >= x2 && (-0.5..=2.0).contains(&(x1 + x2));
        is_covered.then(|| Self::extrapolated(pair, torque))
    }

    /// The same beyond the limits of the standard, too. A transverse contact ratio below 1 counts as 1.
    pub fn extrapolated(pair: &PairGeometry, torque: f64) -> NominalStiffness {
        let (pinion, wheel) = pinion_and_wheel(pair);
        let cos_beta = pinion.helix_angle.cos();
        let theoretical = theoretical_pair_stiffness(pair);
        let blank = 0.5 * (blank(pinion) + blank(wheel));
        let rack = 0.5 * (rack(pinion) + rack(wheel));
        let [e1, e2] = [pinion, wheel].map(|gear| gear.youngs_modulus);
        let modulus = 2.0 * e1 * e2 / (e1 + e2) / STEEL;
        let line_load = tangential_force(pair, torque) / pair.face_overlap().1;
        let low = (line_load / FULL_LINE_LOAD).min(1.0).powf(0.25);
        let single = 0.8 * theoretical * blank * rack * cos_beta * modulus * low;
        let ratio = pair.transverse_contact_ratio(pair.center_distance);
        let mesh = single * (0.75 * ratio.max(1.0) + 0.25);
        NominalStiffness {
            single,
            mesh,
            along_face: 0.85 * mesh,
        }
    }
}

/// Profile shift of `gear` in the sign of the standard, in which a ring's is reversed.
fn shift(gear: &Gear) -> f64 {
    gear.kappa() * gear.profile_shift
}

/// Theoretical single stiffness c'_th of ISO 6336-1:2006, equations 83 and 84, N/m per m of face width: of one pair of steel teeth on solid discs
/// with a basic rack of dedendum 1.2, on the line of action in the normal section. A ring has infinitely many teeth there.
/// Beyond the limits of [`NominalStiffness::new`] it is an extrapolation.
pub fn theoretical_pair_stiffness(pair: &PairGeometry) -> f64 {
    let (pinion, wheel) = pinion_and_wheel(pair);
    let [x1, x2] = [pinion, wheel].map(shift);
    // Of the virtual numbers of teeth, z_n = z / (cos² beta_b cos beta).
    let [per_pinion, per_wheel] = [pinion, wheel].map(|gear| match gear.kind {
        GearKind::External => {
            gear.base_helix_angle().cos().powi(2) * gear.helix_angle.cos() / gear.z()
        }
        GearKind::Ring => 0.0,
    });
    // mm um / N.
    let flexibility = 0.04723 + 0.15551 * per_pinion + 0.25791 * per_wheel
        - 0.00635 * x1
        - 0.11654 * x1 * per_pinion
        - 0.00193 * x2
        - 0.24188 * x2 * per_wheel
        + 0.00529 * x1 * x1
        + 0.00182 * x2 * x2;
    1e9 / flexibility
}

/// Basic rack factor (C_B).
fn rack(gear: &Gear) -> f64 {
    let angle = gear.normal_pressure_angle.to_degrees();
    (1.0 + 0.5 * (1.2 - gear.dedendum_coefficient)) * (1.0 - 0.02 * (20.0 - angle))
}

/// Gear blank factor (C_R): 1 of solid discs.
fn blank(gear: &Gear) -> f64 {
    let Some(body) = gear.body.filter(|body| !body.is_shaft()) else {
        return 1.0;
    };
    let web = ((body.web[1] - body.web[0]) / gear.face_width).clamp(0.2, 1.2);
    let rim = ((gear.root_radius() - body.rim_radius) / gear.normal_module).max(1.0);
    1.0 + web.ln() / (5.0 * (rim / 5.0).exp())
}

/// The standard's gear 1, which is the external one or has fewer teeth, and gear 2.
fn pinion_and_wheel(pair: &PairGeometry) -> (&Gear, &Gear) {
    let [one, two] = &pair.gears;
    match pair.ring() == Some(0) || pair.ring().is_none() && two.teeth < one.teeth {
        true => (two, one),
        false => (one, two),
    }
}

/// F_t at the reference circle, N, of `torque` on gear 1, N m.
fn tangential_force(pair: &PairGeometry, torque: f64) -> f64 {
    torque / pair.gears[0].reference_radius()
}

/// Nominal contact stress at the pitch point (sigma_H0) of ISO 6336-2:2019 with its factors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalContactStress {
    /// Zone factor (Z_H).
    pub zone_factor: f64,
    /// Elasticity factor (Z_E), sqrt(Pa).
    pub elasticity_factor: f64,
    /// Contact ratio factor (Z_epsilon).
    pub contact_ratio_factor: f64,
    /// Helix angle factor (Z_beta).
    pub helix_factor: f64,
    /// sigma_H0, Pa.
    pub stress: f64,
}

impl NominalContactStress {
    /// Of `pair` under `torque` on gear 1, N m.
    pub fn new(pair: &PairGeometry, torque: f64) -> NominalContactStress {
        let (pinion, wheel) = pinion_and_wheel(pair);
        let phi = pair.operating_pressure_angle(pair.center_distance);
        let cos_beta_b = pinion.base_helix_angle().cos();
        let alpha_t = pinion.transverse_pressure_angle();
        let zone = (2.0 * cos_beta_b * phi.cos() / (alpha_t.cos().powi(2) * phi.sin())).sqrt();
        let compliance = pinion.plane_compliance() + wheel.plane_compliance();
        let elasticity = (PI * compliance).recip().sqrt();
        let ratio = pair.transverse_contact_ratio(pair.center_distance);
        let overlap = pair.overlap_ratio().min(1.0);
        let squared = (4.0 - ratio) / 3.0 * (1.0 - overlap) + overlap / ratio;
        let helix = pinion.helix_angle.cos().sqrt().recip();
        // Of a ring the ratio of the teeth is negative.
        let u = wheel.kappa() * wheel.z() / pinion.z();
        let width = pair.face_overlap().1;
        let load = tangential_force(pair, torque) / (2.0 * pinion.reference_radius() * width);
        let factors = zone * elasticity * squared.sqrt() * helix;
        NominalContactStress {
            zone_factor: zone,
            elasticity_factor: elasticity,
            contact_ratio_factor: squared.sqrt(),
            helix_factor: helix,
            stress: factors * (load * (u + 1.0) / u).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair;
    use approx::assert_relative_eq;

    /// ISO/TR 6336-30:2017, example 1; its bores are not given and do not count here.
    const EXAMPLE: &str = include_str!("../../tests/data/iso-tr-6336-30-example-1.json");

    #[test]
    fn stiffness_and_contact_stress_are_those_of_the_standards_first_example() {
        let geometry = pair::from_json(EXAMPLE).unwrap().geometry;
        let stiffness = NominalStiffness::new(&geometry, 9000.0).unwrap();
        assert_relative_eq!(1e-9 * stiffness.single, 12.3705, max_relative = 2e-3);
        assert_relative_eq!(1e-9 * stiffness.mesh, 17.4648, max_relative = 2e-3);
        assert_relative_eq!(1e-9 * stiffness.along_face, 14.8451, max_relative = 2e-3);
        let stress = NominalContactStress::new(&geometry, 9000.0);
        assert_relative_eq!(stress.zone_factor, 2.3953, max_relative = 1e-4);
        assert_relative_eq!(
            1e-3 * stress.elasticity_factor,
            189.8117,
            max_relative = 1e-4
        );
        assert_relative_eq!(stress.contact_ratio_factor, 0.803, max_relative = 1e-3);
        assert_relative_eq!(stress.helix_factor, 1.0194, max_relative = 1e-4);
        assert_relative_eq!(1e-6 * stress.stress, 1206.58, max_relative = 1e-3);
    }

    #[test]
    fn the_mate_as_gear_1_under_its_own_torque_changes_nothing() {
        let geometry = pair::from_json(EXAMPLE).unwrap().geometry;
        let [one, two] = geometry.gears.clone();
        let turned = PairGeometry {
            gears: [two, one],
            ..geometry.clone()
        };
        let torque = 9000.0 * 103.0 / 17.0;
        let found = NominalContactStress::new(&turned, torque).stress;
        let right = NominalContactStress::new(&geometry, 9000.0).stress;
        assert_relative_eq!(found, right, max_relative = 1e-12);
        assert_eq!(
            NominalStiffness::new(&turned, torque).unwrap().single,
            NominalStiffness::new(&geometry, 9000.0).unwrap().single
        );
    }

    #[test]
    fn the_theoretical_stiffness_of_a_tooth_pair_is_that_of_iso_tr_6336_30_example_1() {
        let pair = pair::from_json(EXAMPLE).unwrap();
        let found = 1e-9 * theoretical_pair_stiffness(&pair.geometry);
        assert!((found - 17.8558).abs() < 1e-3, "{found}");
    }

    #[test]
    fn below_100_newtons_per_millimetre_stiffness_falls_and_a_web_lowers_it() {
        let mut geometry = pair::from_json(EXAMPLE).unwrap().geometry;
        let single = |g: &PairGeometry, torque| NominalStiffness::new(g, torque).unwrap().single;
        let full = single(&geometry, 9000.0);
        let torque = 10e3 * geometry.face_overlap().1 * geometry.gears[0].reference_radius();
        assert_relative_eq!(
            single(&geometry, torque) / full,
            0.1f64.powf(0.25),
            max_relative = 1e-12
        );
        let root = geometry.gears[1].root_radius();
        geometry.gears[1].body = Some(gearmesh::gear::Body {
            rim_radius: root - 3.0 * geometry.gears[1].normal_module,
            web: [40e-3, 60e-3],
            hub_radius: 0.4 * root,
            hub: [0.0, 0.1],
            held_ends: [false; 2],
        });
        let factor = 1.0 + 0.2f64.ln() / (5.0 * 0.6f64.exp());
        assert_relative_eq!(
            single(&geometry, 9000.0) / full,
            0.5 * (1.0 + factor),
            max_relative = 1e-9
        );
        geometry.gears[0].profile_shift = -0.2;
        assert_eq!(NominalStiffness::new(&geometry, 9000.0), None);
    }
}
