//! Nominal tooth root stress of ISO 6336-3:2006, method B, with every term: an orientation beside finite elements.
//!
//! sigma_F0 = F_t / (b m_n) Y_F Y_S Y_beta Y_B, the load at the outer point of single pair contact of the virtual spur
//! gear; F_t at the reference circle. None of the load factors K is in it. Y_DT = 1: the standard lowers the stress for contact ratios
//! of the virtual gear above 2.05 only where the accuracy grade is 4 or better, which nobody states here.
//!
//! External gears: the standard's equations for a rack of dedendum h_fP and tip radius rho_fP; backlash is left
//! out as there. Rings: the standard's own definition, the chord between the 60 degree tangents, its lever arm and the radius of the
//! fillet, taken from the outline with the fillet's arc as it is: that of the virtual spur ring, its teeth rounded to a whole
//! number.

use gearmesh::root::bisection;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, FRAC_PI_6, PI};

use crate::gear::ToothProfile;
use gearmesh::gear::{Gear, GearKind, PairGeometry, involute};

/// The terms of ISO 6336-3:2006 for one gear, its symbols in brackets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalRootStress {
    /// Teeth of the virtual spur gear (z_n).
    pub virtual_teeth: f64,
    /// Transverse contact ratio of the virtual gears (epsilon_alpha_n).
    pub virtual_contact_ratio: f64,
    /// The critical section and its load.
    pub section: RootSection,
    /// Form factor (Y_F).
    pub form_factor: f64,
    /// Stress correction factor (Y_S).
    pub correction_factor: f64,
    /// Helix angle factor (Y_beta).
    pub helix_factor: f64,
    /// Rim thickness factor (Y_B).
    pub rim_factor: f64,
    /// Nominal root stress (sigma_F0), Pa.
    pub stress: f64,
}

/// The critical section of a tooth root and the load at the outer point of single pair contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootSection {
    /// Chord (s_Fn) over the normal module.
    pub chord: f64,
    /// Lever arm of the load (h_Fe) over the normal module.
    pub lever_arm: f64,
    /// Fillet radius (rho_F) over the normal module.
    pub fillet_radius: f64,
    /// Angle of the load (alpha_Fen), rad.
    pub load_angle: f64,
}

impl NominalRootStress {
    /// Of gear `i` (0 or 1) of `pair` under `torque` on gear 1, N m. None where the standard does not go: rims
    /// thinner than half the tooth height (ring: 1.75 modules), notches beyond 1 <= q_s < 8.
    pub fn new(pair: &PairGeometry, i: usize, torque: f64) -> Option<NominalRootStress> {
        let gear = &pair.gears[i];
        let ratio = pair.transverse_contact_ratio(pair.center_distance);
        let beta_b = (gear.helix_angle.sin() * gear.normal_pressure_angle.cos()).asin();
        let squared = beta_b.cos().powi(2);
        let virtual_teeth = gear.z() / (squared * gear.helix_angle.cos());
        let virtual_contact_ratio = ratio / squared;
        let section = match gear.kind {
            GearKind::External => external(gear, virtual_teeth, virtual_contact_ratio),
            GearKind::Ring => drawn(&virtual_spur(gear, virtual_teeth), virtual_contact_ratio)?,
        };
        let (chord, lever_arm) = (section.chord, section.lever_arm);
        let form_factor = 6.0 * lever_arm * section.load_angle.cos()
            / (chord * chord * gear.normal_pressure_angle.cos());
        let notch = chord / (2.0 * section.fillet_radius);
        if !(1.0..8.0).contains(&notch) {
            return None;
        }
        let slenderness = chord / lever_arm;
        let correction_factor =
            (1.2 + 0.13 * slenderness) * notch.powf(1.0 / (1.21 + 2.3 / slenderness));
        let helix = gear.helix_angle.to_degrees().min(30.0);
        let helix_factor = 1.0 - pair.overlap_ratio().min(1.0) * helix / 120.0;
        let rim_factor = rim_factor(gear)?;
        let force = torque / pair.gears[0].reference_radius();
        let (_, width) = pair.face_overlap();
        let nominal = force / (width * gear.normal_module);
        let stress = nominal * form_factor * correction_factor * helix_factor * rim_factor;
        Some(NominalRootStress {
            virtual_teeth,
            virtual_contact_ratio,
            section,
            form_factor,
            correction_factor,
            helix_factor,
            rim_factor,
            stress,
        })
    }
}

/// Y_B of ISO 6336-3:2006, clause 9; without a rim of its own the body between root circle and held surface counts.
fn rim_factor(gear: &Gear) -> Option<f64> {
    let web = gear.body.filter(|body| !body.is_shaft());
    let inside = web.map_or(gear.held_radius, |body| body.rim_radius);
    let rim = gear.kappa() * (gear.root_radius() - inside);
    // Backup ratio, the least and that of a full body, and the constants between them.
    let (backup, least, full, factor, over) = match gear.kind {
        GearKind::External => {
            let height = gear.tip_radius - gear.root_radius();
            (rim / height, 0.5, 1.2, 1.6, 2.242)
        }
        GearKind::Ring => (rim / gear.normal_module, 1.75, 3.5, 1.15, 8.324),
    };
    let thin = factor * (over / backup).ln();
    (backup > least).then_some(if backup >= full { 1.0 } else { thin })
}

/// ISO 6336-3:2006, equations (10) to (31), for a gear cut by a rack without protuberance; lengths over the module.
fn external(gear: &Gear, z_n: f64, contact_ratio: f64) -> RootSection {
    let alpha_n = gear.normal_pressure_angle;
    let (h, rho) = (gear.dedendum_coefficient, gear.tool_tip_radius_coefficient);
    let e = FRAC_PI_4 - h * alpha_n.tan() - (1.0 - alpha_n.sin()) * rho / alpha_n.cos();
    let g = rho - h + gear.profile_shift;
    let capital_h = 2.0 / z_n * (FRAC_PI_2 - e) - FRAC_PI_3;
    let mut theta = FRAC_PI_6;
    // The standard's iteration; its factor 2 G / (z_n cos^2) is well below 1.
    for _ in 0..200 {
        theta = 2.0 * g / z_n * theta.tan() - capital_h;
    }
    let root = g / theta.cos() - rho;
    let chord = z_n * (FRAC_PI_3 - theta).sin() + 3f64.sqrt() * root;
    let fillet_radius = rho + 2.0 * g * g / (theta.cos() * (z_n * theta.cos().powi(2) - 2.0 * g));
    // Diameters of the virtual gear.
    let m = gear.normal_module;
    let base = z_n * alpha_n.cos();
    let tip = z_n + 2.0 * (gear.tip_form_radius() - gear.reference_radius()) / m;
    let tip_roll = (0.25 * (tip * tip - base * base)).sqrt();
    // pi d cos beta cos alpha_n / z = pi m_n cos alpha_n: the normal base pitch.
    let roll = tip_roll - PI * alpha_n.cos() * (contact_ratio - 1.0);
    let load = 2.0 * roll.hypot(0.5 * base);
    let alpha_en = (base / load).acos();
    let gamma = (FRAC_PI_2 + 2.0 * alpha_n.tan() * gear.profile_shift) / z_n + involute(alpha_n)
        - involute(alpha_en);
    let load_angle = alpha_en - gamma;
    let lever_arm = 0.5
        * ((gamma.cos() - gamma.sin() * load_angle.tan()) * load
            - z_n * (FRAC_PI_3 - theta).cos()
            - root);
    RootSection {
        chord,
        lever_arm,
        fillet_radius,
        load_angle,
    }
}

/// The spur gear of about `teeth` teeth with the tooth of `gear` in its normal section.
fn virtual_spur(gear: &Gear, teeth: f64) -> Gear {
    let mut spur = Gear {
        teeth: teeth.round() as u32,
        helix_angle: 0.0,
        ..gear.clone()
    };
    let outwards = spur.reference_radius() - gear.reference_radius();
    spur.tip_radius += outwards;
    spur.held_radius += outwards;
    spur.tooth_thinning *= gear.base_helix_angle().cos();
    spur
}

/// The same terms from the outline as it is, in the transverse section: tangents at 30 degrees (ring: 60). None for a fillet
/// without such a tangent.
fn drawn(gear: &Gear, contact_ratio: f64) -> Option<RootSection> {
    let profile = ToothProfile::new(gear).ok()?;
    let tangent: f64 = match gear.kind {
        GearKind::External => FRAC_PI_6,
        GearKind::Ring => FRAC_PI_3,
    };
    // The normal turns from the centre line's direction at the root circle to across it at the flank.
    let excess = |t: f64| profile.fillet(t).normal[0].abs() - tangent.sin();
    if excess(0.0) < 0.0 || excess(1.0) > 0.0 {
        return None;
    }
    let t = bisection([0.0, 1.0], 60, |t| excess(t) > 0.0);
    let root = profile.fillet(t);
    // Radius of curvature from three neighbours.
    let step = 1e-3 * (1.0 - t).min(t).max(1e-3);
    let [a, b] = [t - step, t + step].map(|t| profile.fillet(t));
    let turned = a.normal[0] * b.normal[1] - a.normal[1] * b.normal[0];
    let turned = turned.asin().abs();
    let chord = (a.position[0] - b.position[0]).hypot(a.position[1] - b.position[1]);
    let pitch = 2.0 * PI * gear.base_radius() / gear.z();
    let roll = gear.tip_form_roll() - gear.kappa() * (contact_ratio - 1.0) * pitch;
    let load = profile.point_on_flank(roll);
    let slope = load.normal[0] / load.normal[1];
    let crossing = load.position[0] - load.position[1] * slope;
    let m = gear.normal_module;
    Some(RootSection {
        chord: 2.0 * root.position[1].abs() / m,
        lever_arm: gear.kappa() * (crossing - root.position[0]) / m,
        fillet_radius: chord / turned / m,
        load_angle: slope.abs().atan(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use approx::assert_relative_eq;

    /// At the centre distance of the reference circles and the sum of the profile shifts.
    fn pair_of(gears: [Gear; 2]) -> PairGeometry {
        let [first, second] = &gears;
        let reference = first.reference_radius() + second.kappa() * second.reference_radius();
        let shift = first.profile_shift + second.profile_shift;
        PairGeometry {
            center_distance: reference.abs() + shift * first.normal_module,
            gears,
        }
    }

    fn pair(teeth: [u32; 2], shift: [f64; 2], helix_deg: f64) -> PairGeometry {
        let hand = [1.0, -1.0];
        let gear = |i| samples::gear(GearKind::External, teeth[i], hand[i], helix_deg, shift[i]);
        pair_of([0, 1].map(gear))
    }

    #[test]
    fn equations_of_the_standard_are_the_generated_tooth_of_the_virtual_spur_gear() {
        // The outline by the law of gearing against the standard's closed forms: chord, radius and lever arm at the
        // 30 degree tangent.
        for (teeth, shift, helix) in [
            ([20, 20], [0.0, 0.0], 0.0),
            ([17, 43], [0.2, -0.1], 0.0),
            ([25, 80], [0.5, 0.3], 0.0),
            ([20, 20], [0.0, 0.0], 13.0),
            ([25, 80], [0.5, 0.3], 30.0),
        ] {
            let pair = pair(teeth, shift, helix);
            for gear in &pair.gears {
                let squared = gear.base_helix_angle().cos().powi(2);
                let whole = (gear.z() / (squared * gear.helix_angle.cos())).round();
                let ratio = pair.transverse_contact_ratio(pair.center_distance) / squared;
                let own = external(gear, whole, ratio);
                let seen = drawn(&virtual_spur(gear, whole), ratio).unwrap();
                assert_relative_eq!(own.chord, seen.chord, max_relative = 1e-9);
                assert_relative_eq!(own.fillet_radius, seen.fillet_radius, max_relative = 1e-4);
                assert_relative_eq!(own.load_angle, seen.load_angle, max_relative = 1e-9);
                assert_relative_eq!(own.lever_arm, seen.lever_arm, max_relative = 1e-9);
            }
        }
    }

    #[test]
    fn a_helix_moves_to_the_virtual_gear_and_lowers_the_stress() {
        let [spur, helical] = [0.0, 20.0].map(|helix| {
            NominalRootStress::new(&pair([20, 20], [0.0, 0.0], helix), 0, 100.0).unwrap()
        });
        assert_eq!(spur.virtual_teeth, 20.0);
        assert_eq!(spur.helix_factor, 1.0);
        // z / (cos^2 beta_b cos beta) with sin beta_b = sin beta cos alpha_n.
        let beta = 20f64.to_radians();
        let sin_beta_b = beta.sin() * 20f64.to_radians().cos();
        let teeth = 20.0 / ((1.0 - sin_beta_b * sin_beta_b) * beta.cos());
        assert_relative_eq!(helical.virtual_teeth, teeth, max_relative = 1e-12);
        assert!(helical.helix_factor < 1.0 && helical.stress < spur.stress);
    }

    #[test]
    fn thin_rims_raise_the_stress_and_end_where_the_standard_ends() {
        let mut thin = pair([40, 40], [0.0, 0.0], 0.0);
        let solid = NominalRootStress::new(&thin, 0, 100.0).unwrap();
        let height = thin.gears[0].tip_radius - thin.gears[0].root_radius();
        thin.gears[0].held_radius = thin.gears[0].root_radius() - 0.8 * height;
        let raised = NominalRootStress::new(&thin, 0, 100.0).unwrap();
        assert_eq!(solid.rim_factor, 1.0);
        let expected = 1.6 * (2.242f64 / 0.8).ln();
        assert_relative_eq!(raised.rim_factor, expected, max_relative = 1e-12);
        thin.gears[0].held_radius = thin.gears[0].root_radius() - 0.4 * height;
        assert_eq!(NominalRootStress::new(&thin, 0, 100.0), None);
    }

    #[test]
    fn a_ring_has_its_own_fillet_and_that_of_its_virtual_gear() {
        let ring = |helix: f64| {
            let gears = [(GearKind::External, 20), (GearKind::Ring, 60)];
            pair_of(gears.map(|(kind, teeth)| samples::gear(kind, teeth, 1.0, helix, 0.0)))
        };
        let of_ring = NominalRootStress::new(&ring(0.0), 1, 100.0).unwrap();
        assert_relative_eq!(of_ring.section.fillet_radius, 0.38, max_relative = 1e-4);
        let helical = NominalRootStress::new(&ring(10.0), 1, 100.0).unwrap();
        assert_relative_eq!(helical.section.fillet_radius, 0.38, max_relative = 1e-4);
        // Teeth of a ring are the thicker at the root the fewer there are: 63 of them instead of 60.
        let thinner = helical.section.chord / of_ring.section.chord;
        assert!((0.98..1.0).contains(&thinner), "{thinner}");
        assert!(helical.stress < of_ring.stress);
    }
}
