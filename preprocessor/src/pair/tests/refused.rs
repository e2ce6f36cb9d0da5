use super::*;
use crate::pair;

/// A large mate whose tips reach the fillets of gear 1.
const LARGE_MATE: &str = r#"{
    "gear1": {"teeth": 18, "profile_shift": 0, "tip_diameter_mm": null, "tip_relief": null},
    "gear2": {"teeth": 150, "profile_shift": 0, "tip_diameter_mm": 684.9, "tip_relief": null},
    "center_distance_mm": null
}"#;

/// File, what is put over it, and the field, value and words of the problem that must be named.
#[rustfmt::skip]
const CASES: &[[&str; 5]] = &[
    [PAPER, r#"{"name": "a/b"}"#,
        "name", "\"a/b\"", "file name"],
    [PAPER, r#"{"name": " "}"#,
        "name", "\" \"", "file name"],
    [PAPER, r#"{"normal_module_mm": -4}"#,
        "normal_module_mm", "-4", "outside"],
    [PAPER, r#"{"normal_pressure_angle_deg": 0.35}"#,
        "normal_pressure_angle_deg", "0.35", "outside"],
    [PAPER, r#"{"helix_angle_deg": 90}"#,
        "helix_angle_deg", "90", "outside"],
    [PAPER, r#"{"center_distance_mm": 0}"#,
        "center_distance_mm", "0", "above 0"],
    [PAPER, r#"{"center_distance_mm": 70}"#,
        "center_distance_mm", "70", "base circles"],
    [PAPER, r#"{"center_distance_mm": 82.0}"#,
        "center_distance_mm", "82", "jam"],
    [INTERNAL, r#"{"center_distance_mm": 57.3, "backlash_um": null}"#,
        "center_distance_mm", "57.3", "jam"],
    [PAPER, r#"{"center_distance_mm": 90}"#,
        "center_distance_mm", "90", "contact ratio"],
    [PAPER, r#"{"backlash_um": -10}"#,
        "backlash_um", "-10", "outside"],
    [PAPER, r#"{"center_distance_mm": 150.07, "backlash_um": 20}"#,
        "center_distance_mm", "150.07", "backlash of"],
    [PAPER, r#"{"center_distance_mm": 82.3, "backlash_um": 20}"#,
        "backlash_um", "20", "alone give"],
    [PAPER, r#"{"face_offset_mm": 25}"#,
        "face_offset_mm", "25", "do not overlap"],
    [PAPER, r#"{"face_offset_mm": -30}"#,
        "face_offset_mm", "-30", "do not overlap"],
    [PAPER, r#"{"gear1": {"teeth": 3}}"#,
        "gear1.teeth", "3", "outside"],
    [PAPER, r#"{"gear2": {"profile_shift": 5}}"#,
        "gear2.profile_shift", "5", "outside"],
    [PAPER, r#"{"gear1": {"profile_shift": -1.5, "tip_diameter_mm": null, "tip_relief": null}, "gear2": {"profile_shift": -1.5}, "center_distance_mm": null}"#,
        "gear1.profile_shift", "-1.5", "centre distance without backlash"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"drive_flank": {"cumulative_pitch_um": [1, 2]}}}}"#,
        "gear1.tooth_errors.drive_flank.cumulative_pitch_um", "2 numbers", "teeth"],
    [PAPER, r#"{"gear2": {"tooth_errors": {"coast_flank": {"pitch_class": 12}}}}"#,
        "gear2.tooth_errors.coast_flank.pitch_class", "12", "class"],
    [PAPER, r#"{"gear2": {"tooth_errors": {"coast_flank": {}}}}"#,
        "gear2.tooth_errors.coast_flank", "{}", "says nothing"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"drive_flank": {"cumulative_pitch_um": [], "pitch_class": 6}}}}"#,
        "gear1.tooth_errors.drive_flank", "two sources", "both"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"runout_um": -5}}}"#,
        "gear1.tooth_errors.runout_um", "-5", "outside"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 999}]}}}"#,
        "gear1.tooth_errors.teeth[0].tooth", "999", "no tooth"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 1}, {"tooth": 1}]}}}"#,
        "gear1.tooth_errors.teeth[1].tooth", "1", "twice"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 1, "compliance_factor": 0.5}]}}}"#,
        "gear1.tooth_errors.teeth[0].compliance_factor", "0.5", "outside"],
    [PAPER, r#"{"gear1": {"face_width_mm": 0}}"#,
        "gear1.face_width_mm", "0", "above 0"],
    [PAPER, r#"{"gear1": {"addendum_coefficient": 1}}"#,
        "gear1.addendum_coefficient", "1", "same"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": null, "addendum_coefficient": -1}}"#,
        "gear1.addendum_coefficient", "-1", "above 0"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": -90}}"#,
        "gear1.tip_diameter_mm", "-90", "above 0"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": 110}}"#,
        "gear1.tip_diameter_mm", "110", "pointed"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": 70}}"#,
        "gear1.tip_diameter_mm", "70", "no involute"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": 93}}"#,
        "gear1.tip_diameter_mm", "93", "tip clearance"],
    [PAPER, r#"{"gear2": {"dedendum_coefficient": 0}}"#,
        "gear2.dedendum_coefficient", "0", "above 0"],
    [PAPER, r#"{"gear2": {"tool_tip_radius_coefficient": -0.1}}"#,
        "gear2.tool_tip_radius_coefficient", "-0.1", "outside"],
    [PAPER, r#"{"gear2": {"tool_tip_radius_coefficient": 0.6}}"#,
        "gear2.tool_tip_radius_coefficient", "0.6", "round"],
    [PAPER, r#"{"gear2": {"bore_diameter_mm": 80}}"#,
        "gear2.bore_diameter_mm", "80", "root diameter"],
    // Root diameter 72.104 mm, module 4 mm; of the ring 174 mm.
    [PAPER, r#"{"gear2": {"bore_diameter_mm": 1e-9}}"#,
        "gear2.bore_diameter_mm", "0.000000001", "thousandth of the root diameter"],
    [PAPER, r#"{"gear2": {"bore_diameter_mm": 70.2}}"#,
        "gear2.bore_diameter_mm", "70.2", "half a normal module below"],
    [PAPER, r#"{"gear2": {"bore_diameter_mm": null, "rim_diameter_mm": 120}}"#,
        "gear2.rim_diameter_mm", "120", "bore"],
    [PAPER, r#"{"gear2": {"rim_diameter_mm": 120}}"#,
        "gear2.rim_diameter_mm", "120", "bore_diameter_mm"],
    [INTERNAL, r#"{"gear2": {"rim_diameter_mm": 170}}"#,
        "gear2.rim_diameter_mm", "170", "root diameter"],
    [INTERNAL, r#"{"gear1": {"bore_diameter_mm": null, "rim_diameter_mm": 100}}"#,
        "gear1.rim_diameter_mm", "100", "one ring"],
    [INTERNAL, r#"{"gear2": {"rim_diameter_mm": null, "bore_diameter_mm": 190}}"#,
        "gear2.bore_diameter_mm", "190", "outer rim"],
    [PAPER, r#"{"gear1": {"youngs_modulus_gpa": 0}}"#,
        "gear1.youngs_modulus_gpa", "0", "above 0"],
    [PAPER, r#"{"gear1": {"poisson_ratio": 0.5}}"#,
        "gear1.poisson_ratio", "0.5", "outside"],
    // Undercut and interference.
    [SPUR, r#"{"gear1": {"teeth": 9, "profile_shift": 0.0, "tip_diameter_mm": null, "bore_diameter_mm": 10, "tip_relief": null}, "gear2": {"teeth": 40, "profile_shift": 0.0, "tip_diameter_mm": null, "tip_relief": null}, "center_distance_mm": null}"#,
        "gear1.profile_shift", "0", "undercut reaches"],
    [SPUR, LARGE_MATE,
        "gear2.tip_diameter_mm", "684.9", "tip interference"],
    [INTERNAL, r#"{"gear2": {"tip_diameter_mm": 164}}"#,
        "gear2.tip_diameter_mm", "164", "tip interference"],
    [INTERNAL, r#"{"gear2": {"tip_diameter_mm": 150}}"#,
        "gear2.tip_diameter_mm", "150", "base circle"],
    [INTERNAL, r#"{"gear1": {"teeth": 84}, "center_distance_mm": null}"#,
        "gear2.teeth", "84", "more teeth"],
    [INTERNAL, r#"{"gear1": {"teeth": 81, "tip_diameter_mm": null, "profile_shift": 0, "tip_relief": null}, "gear2": {"tip_diameter_mm": null, "profile_shift": 0, "tip_relief": null}, "center_distance_mm": null, "backlash_um": null, "operating": {"center_distance_offset_um": [0, 0]}}"#,
        "gear2.teeth", "84", "tooth difference"],
    // Contact.
    [SPUR, r#"{"gear1": {"tip_diameter_mm": 77, "tip_relief": null}, "gear2": {"tip_diameter_mm": 112, "tip_relief": null}}"#,
        "gear2.tip_diameter_mm", "112", "contact ratio"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": 81}}"#,
        "gear1.tip_diameter_mm", "81", "addendum"],
    // Microgeometry.
    [PAPER, r#"{"gear1": {"tip_relief": {"amount_um": -7}}}"#,
        "gear1.tip_relief.amount_um", "-7", "adds material"],
    [PAPER, r#"{"gear1": {"tip_relief": {"amount_um": 700}}}"#,
        "gear1.tip_relief.amount_um", "700", "exceeds"],
    [PAPER, r#"{"gear1": {"tip_relief": {"start": {"diameter_mm": 95}}}}"#,
        "gear1.tip_relief.start", r#"{"diameter_mm": 95}"#, "outside the active profile"],
    [PAPER, r#"{"gear2": {"root_relief": {"amount_um": 5, "start": {"diameter_mm": 70}}}}"#,
        "gear2.root_relief.start", r#"{"diameter_mm": 70}"#, "outside the active profile"],
    [PAPER, r#"{"gear2": {"root_relief": {"amount_um": -5}}}"#,
        "gear2.root_relief.amount_um", "-5", "adds material"],
    [PAPER, r#"{"gear1": {"lead_crowning_um": -1}}"#,
        "gear1.lead_crowning_um", "-1", "adds material"],
    [PAPER, r#"{"gear1": {"profile_crowning_um": -1}}"#,
        "gear1.profile_crowning_um", "-1", "adds material"],
    [PAPER, r#"{"gear1": {"lead_slope_um": 300}}"#,
        "gear1.lead_slope_um", "300", "exceeds"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": 5, "length_mm": 20}}}"#,
        "gear1.end_relief.length_mm", "20", "half of the face"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": -5, "length_mm": 2}}}"#,
        "gear1.end_relief.amount_um", "-5", "adds material"],
    [PAPER, r#"{"gear1": {"tip_relief": {"amount_um": 200, "start": {"diameter_mm": 90.31499}}}}"#,
        "gear1.tip_relief.start", r#"{"diameter_mm": 90.31499}"#, "for 200 um, steeper than one in ten"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": 50, "length_mm": 0.4}}}"#,
        "gear1.end_relief.length_mm", "0.4", "steeper than one in ten under 50 um"],
    [PAPER, r#"{"gear1": {"face_width_mm": 10000}}"#,
        "gear1.face_width_mm", "10000", "outside 0.2 to 400"],
    [PAPER, r#"{"gear1": {"drive_flank": {"lead_slope_um": 300}}}"#,
        "gear1.drive_flank.lead_slope_um", "300", "exceeds"],
    [PAPER, r#"{"gear2": {"coast_flank": {"tip_relief": {"amount_um": 5, "start": {"diameter_mm": 95}}}}}"#,
        "gear2.coast_flank.tip_relief.start", r#"{"diameter_mm": 95}"#, "outside the active profile"],
    [PAPER, r#"{"gear1": {"upper_end_relief": {"amount_um": 5, "length_mm": 20}}}"#,
        "gear1.upper_end_relief.length_mm", "20", "half of the face"],
    [PAPER, r#"{"gear1": {"topography_file": "no such.csv"}}"#,
        "gear1.topography_file", "no such.csv", "cannot be read"],
    [PAPER, r#"{"gear1": {"tip_form_diameter_mm": 91}}"#,
        "gear1.tip_form_diameter_mm", "91", "end of the involute"],
    [PAPER, r#"{"gear1": {"tip_form_diameter_mm": 84}}"#,
        "gear1.tip_form_diameter_mm", "84", "end of the involute"],
    // Operating range.
    [PAPER, r#"{"operating": {"maximum_torque_nm": 1e6}}"#,
        "operating.maximum_torque_nm", "1000000", "no tooth"],
    [PAPER, r#"{"operating": {"nominal_torque_nm": 0}}"#,
        "operating.nominal_torque_nm", "0", "outside 1e-9 to 1e9"],
    [PAPER, r#"{"operating": {"nominal_torque_nm": 1e-40}}"#,
        "operating.nominal_torque_nm", "1e-40", "outside 1e-9 to 1e9"],
    [PAPER, r#"{"operating": {"maximum_torque_nm": 50}}"#,
        "operating.maximum_torque_nm", "50", "nominal"],
    [PAPER, r#"{"operating": {"misalignment_mrad": [3, -3]}}"#,
        "operating.misalignment_mrad", "[3, -3]", "reversed"],
    [PAPER, r#"{"operating": {"misalignment_mrad": [1, 3]}}"#,
        "operating.misalignment_mrad", "[1, 3]", "contain zero"],
    [PAPER, r#"{"operating": {"misalignment_mrad": [-3000, 3]}}"#,
        "operating.misalignment_mrad", "[-3000, 3]", "beyond"],
    [PAPER, r#"{"operating": {"center_distance_offset_um": [-100, -50]}}"#,
        "operating.center_distance_offset_um", "[-100, -50]", "contain zero"],
    [PAPER, r#"{"operating": {"center_distance_offset_um": [-6000, 100]}}"#,
        "operating.center_distance_offset_um", "-6000", "base circles"],
];

#[test]
fn every_refusal_names_field_value_problem_and_remedy() {
    for [text, patch, field, value, problem] in CASES {
        let error = match pair::from_json(&patched(text, patch)) {
            Err(error) => error,
            Ok(_) => panic!("accepted: {patch}"),
        };
        let message = error.to_string();
        let PairError::Refused(refusal) = &error else {
            panic!("{patch}: {message}");
        };
        assert_eq!(refusal.field, *field, "{patch}: {message}");
        assert_eq!(refusal.value, *value, "{patch}: {message}");
        assert!(refusal.problem.contains(problem), "{patch}: {message}");
        let verbs = ["give", "choose", "check", "shorten", "narrow"];
        assert!(
            verbs.iter().any(|verb| refusal.remedy.starts_with(verb)),
            "{patch}: {message}"
        );
        for part in [&refusal.field, &refusal.value, &refusal.remedy] {
            assert!(message.contains(part.as_str()), "{patch}: {message}");
        }
    }
}

#[test]
fn following_the_remedy_of_an_interference_lifts_it() {
    // The limits that the messages name, a hundredth of a millimetre on the good side.
    let remedy = |text: &str| match pair::from_json(text) {
        Err(PairError::Refused(refusal)) => refusal.remedy,
        other => panic!("{other:?}"),
    };
    let limit = |remedy: &str| -> f64 {
        let words: Vec<&str> = remedy.split_whitespace().collect();
        let mm = words.iter().position(|w| w.starts_with("mm")).unwrap();
        words[mm - 1].parse().unwrap()
    };
    let large = patched(SPUR, LARGE_MATE);
    for (text, bad, side) in [(large.as_str(), 684.9, -0.01), (INTERNAL, 164.0, 0.01)] {
        let with = |mm: f64| {
            patched(
                text,
                &format!(r#"{{"gear2": {{"tip_diameter_mm": {mm}}}}}"#),
            )
        };
        let named = limit(&remedy(&with(bad)));
        pair::from_json(&with(named + side)).unwrap();
    }
    let pointed = r#"{"gear1": {"tip_diameter_mm": 110}}"#;
    let named = limit(&remedy(&patched(PAPER, pointed)));
    let again = patched(
        PAPER,
        &format!(r#"{{"gear1": {{"tip_diameter_mm": {}}}}}"#, named - 0.01),
    );
    // No longer pointed; now the tip is simply too long for the mate.
    assert!(remedy(&again).starts_with("shorten"));
}

#[test]
fn a_missing_file_is_named() {
    let error = pair::read("no such pair.json").unwrap_err();
    assert!(error.to_string().contains("no such pair.json"));
}
