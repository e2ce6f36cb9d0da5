//! Numbers in another unit are told apart from numbers that are meant.

use super::*;
use crate::pair;

fn refusal(text: &str, patch: &str) -> Refusal {
    match pair::from_json(&patched(text, patch)) {
        Err(PairError::Refused(refusal)) => refusal,
        other => panic!("{patch}: {other:?}"),
    }
}

/// What is put over the paper's pair, the field that must be named, and what its value must be said to be.
#[rustfmt::skip]
const IMPOSSIBLE: &[[&str; 3]] = &[
    [r#"{"normal_module_mm": 0.004}"#, "normal_module_mm", "0.004 m is 4 mm"],
    [r#"{"gear1": {"face_width_mm": 0.025}}"#, "gear1.face_width_mm", "0.025 m is 25 mm"],
    [r#"{"gear2": {"face_width_mm": 1e-1}}"#, "gear2.face_width_mm", "0.1 m is 100 mm"],
    [r#"{"normal_pressure_angle_deg": 0.349}"#, "normal_pressure_angle_deg", "0.349 rad is 19.996 deg"],
    [r#"{"center_distance_mm": 0.082104}"#, "center_distance_mm", "0.082104 m is 82.104 mm"],
    [r#"{"helix_angle_deg": 0.2269, "center_distance_mm": 82.15, "backlash_um": 20}"#, "helix_angle_deg", "0.2269 rad is 13 deg"],
    [r#"{"helix_angle_deg": -0.2269, "backlash_um": 50}"#, "helix_angle_deg", "-0.2269 rad is -13 deg"],
    [r#"{"center_distance_mm": 82.3, "backlash_um": 0.15}"#, "backlash_um", "0.15 mm is 150 um"],
    [r#"{"face_offset_mm": 24.999}"#, "face_offset_mm", "gear 2's z = 0 face minus gear 1's"],
    [r#"{"gear1": {"tip_diameter_mm": 0.090315}}"#, "gear1.tip_diameter_mm", "0.090315 m is 90.315 mm"],
    [r#"{"gear1": {"tip_diameter_mm": 45.1575}}"#, "gear1.tip_diameter_mm", "looks like the radius, the diameter is 90.315 mm"],
    [r#"{"gear1": {"tip_relief": {"start": {"diameter_mm": 0.084}}}}"#, "gear1.tip_relief.start", "0.084 m is 84 mm"],
    [r#"{"gear1": {"bore_diameter_mm": 0.03}}"#, "gear1.bore_diameter_mm", "0.03 m is 30 mm"],
    [r#"{"gear1": {"youngs_modulus_gpa": 206000}}"#, "gear1.youngs_modulus_gpa", "206000 MPa is 206 GPa"],
    [r#"{"gear1": {"youngs_modulus_gpa": 2.06e11}}"#, "gear1.youngs_modulus_gpa", "206000000000 Pa is 206 GPa"],
    [r#"{"operating": {"maximum_torque_nm": 200000}}"#, "operating.maximum_torque_nm", "200000 N mm is 200 N m"],
];

#[rustfmt::skip]
const RIM: [&str; 3] = [r#"{"gear2": {"rim_diameter_mm": 96}}"#, "gear2.rim_diameter_mm", "the diameter is 192 mm"];

#[test]
fn an_impossible_number_is_refused_with_the_unit_it_is_probably_in() {
    let paper = IMPOSSIBLE.iter().map(|case| (PAPER, case));
    for (text, [patch, field, told]) in paper.chain([(INTERNAL, &RIM)]) {
        let refusal = refusal(text, patch);
        assert_eq!(refusal.field, *field, "{refusal}");
        assert!(refusal.remedy.contains(told), "{refusal}");
    }
}

#[test]
fn a_sliver_of_face_is_not_blamed_on_the_torque() {
    for patch in [
        r#"{"face_offset_mm": 24.999}"#,
        r#"{"operating": {"maximum_torque_nm": 500}, "gear1": {"face_width_mm": 0.4}}"#,
    ] {
        let refusal = refusal(PAPER, patch);
        assert_eq!(refusal.field, "face_offset_mm", "{refusal}");
        assert!(refusal.to_string().contains("in common"), "{refusal}");
        assert!(!refusal.to_string().contains("N mm"), "{refusal}");
    }
}

#[test]
fn a_limit_as_it_is_shown_is_allowed() {
    // 0.1 * 1.5 is 0.15000000000000002.
    let refusal = refusal(
        PAPER,
        r#"{"normal_module_mm": 1.5, "gear1": {"face_width_mm": 0.15}}"#,
    );
    assert_ne!(refusal.field, "gear1.face_width_mm", "{refusal}");
}

#[test]
fn a_pair_given_in_metres_is_told_of_its_module_and_not_of_its_backlash() {
    let metres = r#"{"normal_module_mm": 0.00175, "backlash_um": 90}"#;
    let refusal = refusal(PAPER, metres);
    assert_eq!(refusal.field, "normal_module_mm");
    assert!(refusal.remedy.contains("0.00175 m is 1.75 mm"), "{refusal}");
}

#[test]
fn a_centre_distance_out_of_place_is_told_of_the_one_that_the_gears_ask_for() {
    for mm in [150.07, 78.5] {
        let refusal = refusal(
            PAPER,
            &format!(r#"{{"center_distance_mm": {mm}, "backlash_um": 90}}"#),
        );
        assert_eq!(refusal.field, "center_distance_mm", "{refusal}");
        assert!(refusal.remedy.contains("82.1043 mm"), "{refusal}");
    }
}

/// What is put over the paper's pair, and the words of the note on it.
#[rustfmt::skip]
const ODD: &[[&str; 3]] = &[
    [r#"{"helix_angle_deg": 0.2269, "center_distance_mm": null, "gear1": {"tip_diameter_mm": null}, "gear2": {"tip_diameter_mm": null}}"#, "helix_angle_deg", "0.2269 rad is 13 deg"],
    [r#"{"gear1": {"tip_relief": {"amount_um": 0.012}}}"#, "gear1.tip_relief.amount_um", "0.012 mm is 12 um"],
    [r#"{"gear2": {"lead_crowning_um": 0.0045}}"#, "gear2.lead_crowning_um", "0.0045 mm is 4.5 um"],
    [r#"{"backlash_um": 0.09}"#, "backlash_um", "0.09 mm is 90 um"],
    [r#"{"backlash_um": 0.13}"#, "backlash_um", "0.13 mm is 130 um"],
    [r#"{"face_offset_mm": -24}"#, "face_offset_mm", "leaves only 1 mm of the faces"],
    [r#"{"operating": {"nominal_torque_nm": 0.12}}"#, "operating.nominal_torque_nm", "0.12 kN m is 120 N m"],
    [r#"{"operating": {"misalignment_mrad": [-0.001, 0.001]}}"#, "operating.misalignment_mrad", "0.001 rad is 1 mrad"],
    [r#"{"operating": {"center_distance_offset_um": [0, 0.05]}}"#, "operating.center_distance_offset_um", "0.05 mm is 50 um"],
    [r#"{"gear1": {"bore_diameter_mm": 1.2}}"#, "gear1.bore_diameter_mm", "1.2 inch is 30.48 mm"],
];

#[test]
fn an_odd_number_is_accepted_with_a_note_on_the_unit_it_may_be_in() {
    for [patch, field, told] in ODD {
        let pair =
            pair::from_json(&patched(PAPER, patch)).unwrap_or_else(|e| panic!("{patch}: {e}"));
        let noted = |note: &String| note.contains(field) && note.contains(told);
        assert!(
            pair.warnings.iter().any(noted),
            "{patch}: {:?}",
            pair.warnings
        );
    }
}

#[test]
fn numbers_that_are_usual_get_no_note() {
    for text in [PAPER, SPUR, HELICAL, INTERNAL] {
        let pair = pair::from_json(text).unwrap();
        assert!(
            !pair.warnings.iter().any(|note| note.contains("odd")),
            "{:?}",
            pair.warnings
        );
    }
}
