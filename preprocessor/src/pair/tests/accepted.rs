use crate::pair;
use approx::assert_abs_diff_eq;

use super::*;
use gearmesh::gear::{GearKind, ToothProfile};

#[test]
fn contact_ratios_from_the_pair_file_are_those_of_the_papers_table_1() {
    for text in [PAPER, UNMODIFIED] {
        let pair = pair::from_json(text).unwrap();
        let g = &pair.geometry;
        let transverse = g.transverse_contact_ratio(g.center_distance);
        assert_abs_diff_eq!(transverse, 1.540, epsilon = 1e-3);
        assert_abs_diff_eq!(g.overlap_ratio(), 0.448, epsilon = 1e-3);
        assert_abs_diff_eq!(transverse + g.overlap_ratio(), 1.988, epsilon = 1e-3);
    }
}

#[test]
fn the_papers_nominal_normal_force_follows_from_torque_and_base_cylinder() {
    let pair = pair::from_json(PAPER).unwrap();
    let [gear, _] = &pair.geometry.gears;
    let force = pair.operating.nominal_torque / gear.base_radius() / gear.base_helix_angle().cos();
    assert_abs_diff_eq!(force, 2660.4, epsilon = 0.1);
}

#[test]
fn the_papers_relief_starts_at_the_pitch_circle_and_is_whole_at_the_tip() {
    let pair = pair::from_json(PAPER).unwrap();
    for i in 0..2 {
        let gear = &pair.geometry.gears[i];
        let removal = |radius: f64| {
            pair.microgeometry.drive[i].removal(gear, gear.roll_length(radius), 12.5e-3)
        };
        assert_abs_diff_eq!(removal(41.052e-3), 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(removal(gear.tip_radius), 7e-6, epsilon = 1e-12);
    }
    assert!(pair.coast_mirrors_drive());
}

#[test]
fn the_papers_rounded_centre_distance_is_free_of_backlash() {
    let g = pair::from_json(PAPER).unwrap().geometry;
    // 80 / cos 13 deg = 82.10433 mm is rounded to 82.104 mm.
    assert_abs_diff_eq!(g.backlash(g.center_distance), 0.0, epsilon = 1e-15);
    assert!(g.gears.iter().all(|gear| gear.tooth_thinning < 0.2e-6));
}

#[test]
fn every_shipped_pair_is_accepted() {
    for text in [PAPER, UNMODIFIED, SPUR, HELICAL, INTERNAL] {
        let pair = pair::from_json(text).unwrap_or_else(|error| panic!("{error}"));
        // The paper's pair has no backlash, so that it must warn of its range of centre distance.
        let jams = pair
            .warnings
            .iter()
            .all(|w| w.contains("both flanks press"));
        assert!(jams, "{}: {:?}", pair.name, pair.warnings);
    }
}

#[test]
fn backlash_and_centre_distance_defaults_are_consistent() {
    for text in [SPUR, HELICAL, INTERNAL] {
        // The centre distance left out, the backlash kept: tooth thickness by thickness the pitch is
        // filled but for the backlash.
        let pair = pair::from_json(&patched(text, r#"{"center_distance_mm": null}"#)).unwrap();
        let g = &pair.geometry;
        let c = g.center_distance;
        let rw = [0, 1].map(|i| g.operating_pitch_radius(i, c));
        let filled: f64 = (0..2)
            .map(|i| {
                let profile = ToothProfile::new(&g.gears[i]).unwrap();
                2.0 * rw[i] * profile.half_thickness_angle(rw[i]).unwrap()
            })
            .sum();
        let pitch = 2.0 * std::f64::consts::PI * rw[0] / g.gears[0].z();
        let file: PairFile = serde_json::from_str(text).unwrap();
        let backlash = file.backlash_um.unwrap() * 1e-6;
        assert_abs_diff_eq!(pitch - filled, backlash, epsilon = 1e-12);
        let cos_phi = g.operating_pressure_angle(c).cos();
        assert_abs_diff_eq!(g.backlash(c), backlash * cos_phi, epsilon = 1e-12);
    }
}

#[test]
fn stated_defaults_are_those_that_are_filled_in() {
    let sparse = r#"{
        "name": "sparse", "meshing": "external",
        "normal_module_mm": 2.0, "normal_pressure_angle_deg": 20.0,
        "gear1": { "teeth": 30, "face_width_mm": 20.0 },
        "gear2": { "teeth": 40, "face_width_mm": 20.0 },
        "operating": { "nominal_torque_nm": 50.0, "maximum_torque_nm": 50.0,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0] }
    }"#;
    let pair = pair::from_json(sparse).unwrap();
    let [a, b] = &pair.geometry.gears;
    assert_abs_diff_eq!(pair.geometry.center_distance, 70e-3, epsilon = 1e-15);
    assert_abs_diff_eq!(a.tip_radius, 32e-3, epsilon = 1e-15);
    assert_abs_diff_eq!(a.root_radius(), 27.5e-3, epsilon = 1e-15);
    assert_abs_diff_eq!(a.held_radius, 13.75e-3, epsilon = 1e-15);
    assert_eq!((a.youngs_modulus, a.poisson_ratio), (206e9, 0.3));
    assert_eq!(
        (a.profile_shift, a.helix_angle, b.face_offset),
        (0.0, 0.0, 0.0)
    );
    assert_eq!(
        (a.tool_tip_radius_coefficient, a.tooth_thinning),
        (0.38, 0.0)
    );
    assert_eq!(pair.microgeometry, Default::default());
    assert_eq!(pair.refinement, gearmesh::pair::Refinement::Normal);
    assert!(pair.tip_corner_contact);
    assert!(pair.warnings.is_empty(), "{:?}", pair.warnings);
}

#[test]
fn a_ring_may_be_gear_1_and_its_default_tip_clears_the_pinion() {
    let file: PairFile = serde_json::from_str(INTERNAL).unwrap();
    let mut swapped = file.clone();
    std::mem::swap(&mut swapped.gear1, &mut swapped.gear2);
    swapped.gear1.tip_diameter_mm = None;
    swapped.gear1.tip_relief = None;
    swapped.gear2.tip_relief = None;
    let pair = pair::from_json(&serde_json::to_string(&swapped).unwrap()).unwrap();
    assert_eq!(pair.geometry.ring(), Some(0));
    assert_eq!(pair.geometry.gears[1].kind, GearKind::External);
    assert_eq!(pair.geometry.sc(), 1.0);
    // Few teeth in a small ring: an addendum of one module would reach the pinion's fillet.
    swapped.gear2.teeth = 18;
    swapped.gear1.teeth = 36;
    swapped.gear1.rim_diameter_mm = None;
    swapped.center_distance_mm = None;
    std::mem::swap(&mut swapped.gear1, &mut swapped.gear2);
    swapped.gear1.tip_diameter_mm = None;
    swapped.gear1.bore_diameter_mm = Some(12.0);
    let pair = pair::from_json(&serde_json::to_string(&swapped).unwrap()).unwrap();
    let g = &pair.geometry;
    let form = ToothProfile::new(&g.gears[0]).unwrap().form_roll();
    // Over the range of centre distance.
    let above = [-50e-6, 50e-6]
        .map(|offset| g.active_start_roll(0, g.center_distance + offset) - form)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    assert_abs_diff_eq!(above, 0.02 * 2e-3, epsilon = 1e-12);
}

#[test]
fn the_coast_flank_needs_its_own_table_with_a_lead_slope_or_shifted_faces() {
    assert!(pair::from_json(HELICAL).unwrap().coast_mirrors_drive());
    for patch in [
        r#"{"gear2": {"lead_slope_um": -4.0}}"#,
        r#"{"face_offset_mm": 2.0}"#,
    ] {
        let pair = pair::from_json(&patched(HELICAL, patch)).unwrap();
        assert!(!pair.coast_mirrors_drive(), "{patch}");
    }
}

#[test]
fn teeth_that_do_not_fit_the_centre_distance_are_noted() {
    let noted = |patch: &str, words: &str| {
        let pair = pair::from_json(&patched(HELICAL, patch)).unwrap_or_else(|e| panic!("{e}"));
        pair.warnings.iter().any(|note| note.contains(words))
    };
    // 0.384 is what the centre distance of 98 mm asks for; the file has 0.35.
    let large = r#"{"gear2": {"profile_shift": 0.15}}"#;
    assert!(noted(
        large,
        "x1 + x2 = 0.450, and 0.384 leaves no backlash there"
    ));
    assert!(!noted(
        r#"{"gear2": {"profile_shift": 0.1}}"#,
        "no backlash there"
    ));
    let loose = r#"{"gear2": {"profile_shift": -0.2}, "backlash_um": null}"#;
    assert!(noted(loose, "is out of proportion"));
    assert!(!noted(r#"{"backlash_um": null}"#, "is out of proportion"));
}
