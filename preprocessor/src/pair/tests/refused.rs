//! Files that are refused, and what is said of them: field, value, problem and remedy.

use super::accepted::{SHAFT, WEBBED};
use super::*;

/// A file, a field of it that gets this value (JSON), and words of the message.
const SINGLE: &[(&str, &str, &str, &str)] = &[
    (PAPER, "name", r#""a/b""#, "file name"),
    (PAPER, "name", r#"" ""#, "file name"),
    (PAPER, "normal_module_mm", "-4", "outside"),
    (PAPER, "normal_pressure_angle_deg", "0.35", "outside"),
    (PAPER, "helix_angle_deg", "90", "outside"),
    (PAPER, "center_distance_mm", "0", "above 0"),
    (PAPER, "center_distance_mm", "70", "base circles"),
    (PAPER, "center_distance_mm", "82.0", "jam"),
    (PAPER, "center_distance_mm", "90", "contact ratio"),
    (PAPER, "backlash_um", "-10", "outside"),
    (PAPER, "face_offset_mm", "25", "do not overlap"),
    (PAPER, "face_offset_mm", "-30", "do not overlap"),
    (PAPER, "gear1.teeth", "3", "outside"),
    (PAPER, "gear2.profile_shift", "5", "outside"),
    (PAPER, "gear1.face_width_mm", "0", "above 0"),
    (PAPER, "gear1.face_width_mm", "10000", "outside 0.2 to 400"),
    (PAPER, "gear1.addendum_coefficient", "1", "same"),
    (PAPER, "gear1.tip_diameter_mm", "-90", "above 0"),
    (PAPER, "gear1.tip_diameter_mm", "110", "pointed"),
    (PAPER, "gear1.tip_diameter_mm", "70", "no involute"),
    (PAPER, "gear1.tip_diameter_mm", "93", "tip clearance"),
    (PAPER, "gear1.tip_diameter_mm", "81", "addendum"),
    (PAPER, "gear2.dedendum_coefficient", "0", "above 0"),
    (
        PAPER,
        "gear2.tool_tip_radius_coefficient",
        "-0.1",
        "outside",
    ),
    (PAPER, "gear2.tool_tip_radius_coefficient", "0.6", "round"),
    // Root diameter 72.104 mm, module 4 mm; of the ring 174 mm.
    (PAPER, "gear2.bore_diameter_mm", "80", "root diameter"),
    (
        PAPER,
        "gear2.bore_diameter_mm",
        "1e-9",
        "thousandth of the root",
    ),
    (
        PAPER,
        "gear2.bore_diameter_mm",
        "70.2",
        "half a normal module",
    ),
    (PAPER, "gear2.rim_diameter_mm", "120", "bore_diameter_mm"),
    (PAPER, "gear1.youngs_modulus_gpa", "0", "above 0"),
    (PAPER, "gear1.poisson_ratio", "0.5", "outside"),
    (
        PAPER,
        "gear1.tip_form_diameter_mm",
        "91",
        "end of the involute",
    ),
    (
        PAPER,
        "gear1.tip_form_diameter_mm",
        "84",
        "end of the involute",
    ),
    (INTERNAL, "gear2.rim_diameter_mm", "170", "root diameter"),
    (INTERNAL, "gear2.tip_diameter_mm", "164", "tip interference"),
    (INTERNAL, "gear2.tip_diameter_mm", "150", "base circle"),
    (INTERNAL, "gear2.web_thickness_mm", "5", "ring"),
    (INTERNAL, "gear2.rim_foundation_n_per_mm3", "0", "outside"),
    (
        INTERNAL,
        "gear2.rim_foundation_n_per_mm3",
        "1e10",
        "outside",
    ),
    // Microgeometry.
    (PAPER, "gear1.tip_relief.amount_um", "-7", "adds material"),
    (PAPER, "gear1.tip_relief.amount_um", "700", "exceeds"),
    (
        PAPER,
        "gear1.tip_relief.start",
        r#"{"diameter_mm": 95}"#,
        "outside the active",
    ),
    (PAPER, "gear1.lead_crowning_um", "-1", "adds material"),
    (PAPER, "gear1.profile_crowning_um", "-1", "adds material"),
    (PAPER, "gear1.lead_slope_um", "300", "exceeds"),
    (PAPER, "gear1.drive_flank.lead_slope_um", "300", "exceeds"),
    (
        PAPER,
        "gear1.topography_file",
        r#""no such.csv""#,
        "cannot be read",
    ),
    // Operating range.
    (PAPER, "operating.maximum_torque_nm", "1e6", "no tooth"),
    (PAPER, "operating.maximum_torque_nm", "50", "nominal"),
    (
        PAPER,
        "operating.nominal_torque_nm",
        "0",
        "outside 1e-9 to 1e9",
    ),
    (
        PAPER,
        "operating.nominal_torque_nm",
        "1e-40",
        "outside 1e-9 to 1e9",
    ),
    (PAPER, "operating.misalignment_mrad", "[3, -3]", "reversed"),
    (
        PAPER,
        "operating.misalignment_mrad",
        "[1, 3]",
        "contain zero",
    ),
    (PAPER, "operating.misalignment_mrad", "[-3000, 3]", "beyond"),
    (
        PAPER,
        "operating.center_distance_offset_um",
        "[-100, -50]",
        "contain zero",
    ),
    // Teeth that differ.
    (
        PAPER,
        "gear2.tooth_errors.coast_flank.pitch_class",
        "12",
        "class",
    ),
    (
        PAPER,
        "gear2.tooth_errors.coast_flank",
        "{}",
        "says nothing",
    ),
    (PAPER, "gear1.tooth_errors.runout_um", "-5", "outside"),
    // Friction.
    (PAPER, "friction.coefficient", "1.5", "outside 0 to 1"),
    // Numbers in another unit.
    (PAPER, "normal_module_mm", "0.004", "0.004 m is 4 mm"),
    (PAPER, "gear1.face_width_mm", "0.025", "0.025 m is 25 mm"),
    (
        PAPER,
        "normal_pressure_angle_deg",
        "0.349",
        "0.349 rad is 19.996 deg",
    ),
    (
        PAPER,
        "center_distance_mm",
        "0.082104",
        "0.082104 m is 82.104 mm",
    ),
    (
        PAPER,
        "face_offset_mm",
        "24.999",
        "gear 2's z = 0 face minus gear 1's",
    ),
    (
        PAPER,
        "gear1.tip_diameter_mm",
        "0.090315",
        "0.090315 m is 90.315 mm",
    ),
    (
        PAPER,
        "gear1.tip_diameter_mm",
        "45.1575",
        "mm in radius is 90.315 mm in diameter",
    ),
    (
        PAPER,
        "gear1.tip_relief.start",
        r#"{"diameter_mm": 0.084}"#,
        "0.084 m is 84 mm",
    ),
    (PAPER, "gear1.bore_diameter_mm", "0.03", "0.03 m is 30 mm"),
    (
        PAPER,
        "gear1.youngs_modulus_gpa",
        "206000",
        "206000 MPa is 206 GPa",
    ),
    (
        PAPER,
        "gear1.youngs_modulus_gpa",
        "2.06e11",
        "206000000000 Pa is 206 GPa",
    ),
    (
        PAPER,
        "operating.maximum_torque_nm",
        "200000",
        "200000 N mm is 200 N m",
    ),
    (
        INTERNAL,
        "gear2.rim_diameter_mm",
        "96",
        "is 192 mm in diameter",
    ),
];

/// The same of the pair with rim, web and hub.
const BODIES: &[(&str, &str, &str)] = &[
    ("gear2.web_offset_mm", "2", "not both"),
    ("gear2.hub_width_mm", "20", "not both"),
    ("gear1.rim_thickness_mm", "1.9", "half a normal module"),
    ("gear1.rim_thickness_mm", "-6", "half a normal module"),
    ("gear1.web_thickness_mm", "26", "face width"),
    ("gear1.web_thickness_mm", "0.3", "tenth"),
    ("gear1.web_offset_mm", "11", "beyond the face"),
    ("gear1.hub_diameter_mm", "61", "no web"),
    ("gear1.hub_diameter_mm", "30.5", "wall"),
    ("gear1.hub_width_mm", "0", "above 0"),
    ("gear1.hub_width_mm", "401", "hundred"),
    ("gear1.hub_offset_mm", "20", "beyond the hub"),
    ("gear1.rim_foundation_n_per_mm3", "5", "no ring"),
];

/// A large mate whose tips reach the fillets of gear 1.
const LARGE_MATE: &str = r#"{
    "gear1": {"teeth": 18, "profile_shift": 0, "tip_diameter_mm": null, "tip_relief": null},
    "gear2": {"teeth": 150, "profile_shift": 0, "tip_diameter_mm": 684.9, "tip_relief": null},
    "center_distance_mm": null
}"#;

/// A file, what is put over it, and the field, value and words of the message.
#[rustfmt::skip]
const SEVERAL: &[[&str; 5]] = &[
    [PAPER, r#"{"center_distance_mm": 150.07, "backlash_um": 20}"#, "center_distance_mm", "150.07", "ask for 82.1043 mm"],
    [PAPER, r#"{"center_distance_mm": 78.5, "backlash_um": 90}"#, "center_distance_mm", "78.5", "ask for 82.1043 mm"],
    [PAPER, r#"{"center_distance_mm": 82.3, "backlash_um": 20}"#, "backlash_um", "20", "alone give"],
    [PAPER, r#"{"center_distance_mm": 82.3, "backlash_um": 0.15}"#, "backlash_um", "0.15", "0.15 mm is 150 um"],
    [INTERNAL, r#"{"center_distance_mm": 57.3, "backlash_um": null}"#, "center_distance_mm", "57.3", "jam"],
    [PAPER, r#"{"gear1": {"profile_shift": -1.5, "tip_diameter_mm": null, "tip_relief": null}, "gear2": {"profile_shift": -1.5}, "center_distance_mm": null}"#,
        "gear1.profile_shift", "-1.5", "centre distance without backlash"],
    [PAPER, r#"{"normal_module_mm": 0.00175, "backlash_um": 90}"#, "normal_module_mm", "0.00175", "0.00175 m is 1.75 mm"],
    [PAPER, r#"{"helix_angle_deg": 0.2269, "center_distance_mm": 82.15, "backlash_um": 20}"#, "helix_angle_deg", "0.2269", "0.2269 rad is 13 deg"],
    [PAPER, r#"{"helix_angle_deg": -0.2269, "backlash_um": 50}"#, "helix_angle_deg", "-0.2269", "-0.2269 rad is -13 deg"],
    [PAPER, r#"{"operating": {"maximum_torque_nm": 500}, "gear1": {"face_width_mm": 0.4}}"#, "face_offset_mm", "0", "in common"],
    [PAPER, r#"{"operating": {"center_distance_offset_um": [-6000, 100]}}"#, "operating.center_distance_offset_um", "-6000", "base circles"],
    [PAPER, r#"{"gear1": {"tip_diameter_mm": null, "addendum_coefficient": -1}}"#, "gear1.addendum_coefficient", "-1", "above 0"],
    [PAPER, r#"{"gear2": {"bore_diameter_mm": null, "rim_diameter_mm": 120}}"#, "gear2.rim_diameter_mm", "120", "bore"],
    [INTERNAL, r#"{"gear1": {"bore_diameter_mm": null, "rim_diameter_mm": 100}}"#, "gear1.rim_diameter_mm", "100", "one ring"],
    [INTERNAL, r#"{"gear2": {"rim_diameter_mm": null, "bore_diameter_mm": 190}}"#, "gear2.bore_diameter_mm", "190", "outer rim"],
    // Undercut, interference and contact.
    [SPUR, r#"{"gear1": {"teeth": 9, "profile_shift": 0.0, "tip_diameter_mm": null, "bore_diameter_mm": 10, "tip_relief": null}, "gear2": {"teeth": 40, "profile_shift": 0.0, "tip_diameter_mm": null, "tip_relief": null}, "center_distance_mm": null}"#,
        "gear1.profile_shift", "0", "undercut reaches"],
    [SPUR, LARGE_MATE, "gear2.tip_diameter_mm", "684.9", "tip interference"],
    [INTERNAL, r#"{"gear1": {"teeth": 84}, "center_distance_mm": null}"#, "gear2.teeth", "84", "more teeth"],
    [INTERNAL, r#"{"gear1": {"teeth": 81, "tip_diameter_mm": null, "profile_shift": 0, "tip_relief": null}, "gear2": {"tip_diameter_mm": null, "profile_shift": 0, "tip_relief": null}, "center_distance_mm": null, "backlash_um": null, "operating": {"center_distance_offset_um": [0, 0]}}"#,
        "gear2.teeth", "84", "tooth difference"],
    [SPUR, r#"{"gear1": {"tip_diameter_mm": 77, "tip_relief": null}, "gear2": {"tip_diameter_mm": 112, "tip_relief": null}}"#,
        "gear2.tip_diameter_mm", "112", "contact ratio"],
    // Microgeometry.
    [PAPER, r#"{"gear2": {"root_relief": {"amount_um": 5, "start": {"diameter_mm": 70}}}}"#, "gear2.root_relief.start", r#"{"diameter_mm": 70}"#, "outside the active profile"],
    [PAPER, r#"{"gear2": {"coast_flank": {"tip_relief": {"amount_um": 5, "start": {"diameter_mm": 95}}}}}"#, "gear2.coast_flank.tip_relief.start", r#"{"diameter_mm": 95}"#, "outside the active profile"],
    [PAPER, r#"{"gear1": {"tip_relief": {"amount_um": 200, "start": {"diameter_mm": 90.31499}}}}"#, "gear1.tip_relief.start", r#"{"diameter_mm": 90.31499}"#, "for 200 um, steeper than one in ten"],
    [PAPER, r#"{"gear2": {"root_relief": {"amount_um": -5}}}"#, "gear2.root_relief.amount_um", "-5", "adds material"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": 5, "length_mm": 20}}}"#, "gear1.end_relief.length_mm", "20", "half of the face"],
    [PAPER, r#"{"gear1": {"upper_end_relief": {"amount_um": 5, "length_mm": 20}}}"#, "gear1.upper_end_relief.length_mm", "20", "half of the face"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": -5, "length_mm": 2}}}"#, "gear1.end_relief.amount_um", "-5", "adds material"],
    [PAPER, r#"{"gear1": {"end_relief": {"amount_um": 50, "length_mm": 0.4}}}"#, "gear1.end_relief.length_mm", "0.4", "steeper than one in ten under 50 um"],
    // Teeth that differ.
    [PAPER, r#"{"gear1": {"tooth_errors": {"drive_flank": {"cumulative_pitch_um": [1, 2]}}}}"#, "gear1.tooth_errors.drive_flank.cumulative_pitch_um", "2 numbers", "teeth"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"drive_flank": {"cumulative_pitch_um": [], "pitch_class": 6}}}}"#, "gear1.tooth_errors.drive_flank", "two sources", "both"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 999}]}}}"#, "gear1.tooth_errors.teeth[0].tooth", "999", "no tooth"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 1}, {"tooth": 1}]}}}"#, "gear1.tooth_errors.teeth[1].tooth", "1", "twice"],
    [PAPER, r#"{"gear1": {"tooth_errors": {"teeth": [{"tooth": 1, "compliance_factor": 0.5}]}}}"#, "gear1.tooth_errors.teeth[0].compliance_factor", "0.5", "outside"],
    // Friction.
    [PAPER, r#"{"friction": { "law": "schlenk", "roughness_ra_um": [0.4, 0.3] }}"#, "friction.dynamic_viscosity_mpa_s", "none", "asks for it"],
    [PAPER, r#"{"friction": { "law": "xu_kahraman", "dynamic_viscosity_mpa_s": 10.0 }}"#, "friction.roughness_ra_um", "none", "asks for it"],
    [PAPER, r#"{"friction": { "roughness_ra_um": [0.4, 300.0] }}"#, "friction.roughness_ra_um", "300", "outside 0.01 to 20"],
];

/// The JSON that sets a field, such as `gear1.teeth`.
fn setting(field: &str, value: &str) -> String {
    let names = field.rsplit('.');
    names.fold(value.to_owned(), |inner, name| {
        format!("{{\"{name}\": {inner}}}")
    })
}

fn check(text: &str, patch: &str, field: &str, value: &str, words: &str) {
    let refusal = refusal(text, patch);
    let message = refusal.to_string();
    let number = |text: &str| text.parse::<f64>().ok();
    let is_same = number(value).is_some() && number(value) == number(&refusal.value);
    assert_eq!(refusal.field, field, "{patch}: {message}");
    assert!(
        is_same || refusal.value == value || format!("\"{}\"", refusal.value) == value,
        "{patch}: {message}"
    );
    assert!(message.contains(words), "{patch}: {message}");
    let verbs = ["give", "choose", "check", "shorten", "narrow", "leave"];
    assert!(
        verbs.iter().any(|verb| refusal.remedy.starts_with(verb)),
        "{patch}: {message}"
    );
    for part in [&refusal.field, &refusal.value, &refusal.remedy] {
        assert!(message.contains(part.as_str()), "{patch}: {message}");
    }
}

#[test]
fn every_refusal_names_field_value_problem_and_remedy() {
    for (text, field, value, words) in SINGLE {
        check(text, &setting(field, value), field, value, words);
    }
    for [text, patch, field, value, words] in SEVERAL {
        check(text, patch, field, value, words);
    }
}

#[test]
fn bodies_that_cannot_be_are_refused_with_field_value_and_remedy() {
    let webbed = patched(PAPER, WEBBED);
    for (field, value, words) in BODIES {
        check(&webbed, &setting(field, value), field, value, words);
    }
    #[rustfmt::skip]
    let without = [
        (r#"{"web_thickness_mm": null}"#, "gear1.rim_thickness_mm", "6", "not both"),
        (r#"{"rim_thickness_mm": null}"#, "gear1.web_thickness_mm", "5", "not both"),
        (r#"{"hub_diameter_mm": null}"#, "gear1.hub_width_mm", "32", "not given"),
        (r#"{"hub_width_mm": 4, "hub_offset_mm": null}"#, "gear1.hub_width_mm", "4", "beyond the hub"),
        (r#"{"rim_thickness_mm": 22, "hub_diameter_mm": null, "hub_width_mm": null, "hub_offset_mm": null}"#,
            "gear1.rim_thickness_mm", "22", "no web"),
    ];
    for (patch, field, value, words) in without {
        check(&webbed, &setting("gear1", patch), field, value, words);
    }
    let cut = patched(PAPER, SHAFT);
    #[rustfmt::skip]
    let shafts = [
        (r#"{"shaft": {"lower": {"diameter_mm": 71}}}"#, "gear1.shaft.lower.diameter_mm", "71", "root circle"),
        (r#"{"shaft": {"upper": {"diameter_mm": 0.5}}}"#, "gear1.shaft.upper.diameter_mm", "0.5", "wall"),
        (r#"{"bore_diameter_mm": 29.5}"#, "gear1.shaft.upper.diameter_mm", "30", "bore"),
        (r#"{"shaft": {"upper": {"length_mm": 0}}}"#, "gear1.shaft.upper.length_mm", "0", "modules"),
        (r#"{"shaft": {"held": null}}"#, "gear1.shaft", "no `held`", "two pieces"),
        (r#"{"shaft": {"upper": null}}"#, "gear1.shaft.held", "upper", "no `upper` piece"),
        (r#"{"rim_thickness_mm": 5}"#, "gear1.rim_thickness_mm", "5", "cut from it"),
    ];
    for (patch, field, value, words) in shafts {
        check(&cut, &setting("gear1", patch), field, value, words);
    }
    let ring = r#"{"gear2": {"shaft": {"lower": {"diameter_mm": 9, "length_mm": 9}}}}"#;
    check(INTERNAL, ring, "gear2.shaft", "a shaft", "ring");
}

#[test]
fn following_the_remedy_of_an_interference_lifts_it() {
    // The limits that the messages name, a hundredth of a millimetre on the good side.
    let tip = |gear: &str, mm: f64| setting(&format!("{gear}.tip_diameter_mm"), &mm.to_string());
    let limit = |remedy: &str| -> f64 {
        let words: Vec<&str> = remedy.split_whitespace().collect();
        let mm = words.iter().position(|w| w.starts_with("mm")).unwrap();
        words[mm - 1].parse().unwrap()
    };
    let large = patched(SPUR, LARGE_MATE);
    for (text, bad, side) in [(large.as_str(), 684.9, -0.01), (INTERNAL, 164.0, 0.01)] {
        let named = limit(&refusal(text, &tip("gear2", bad)).remedy);
        pair(text, &tip("gear2", named + side));
    }
    let named = limit(&refusal(PAPER, &tip("gear1", 110.0)).remedy);
    // No longer pointed; now the tip is simply too long for the mate.
    let again = refusal(PAPER, &tip("gear1", named - 0.01));
    assert!(again.remedy.starts_with("shorten"), "{again}");
}

#[test]
fn a_limit_as_it_is_shown_is_allowed() {
    // 0.1 * 1.5 is 0.15000000000000002.
    let patch = r#"{"normal_module_mm": 1.5, "gear1": {"face_width_mm": 0.15}}"#;
    assert_ne!(refusal(PAPER, patch).field, "gear1.face_width_mm");
}

#[test]
fn a_file_that_cannot_be_read_is_named_with_the_reason() {
    let error = read("no such pair.json").unwrap_err();
    assert!(error.to_string().contains("no such pair.json"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pair.json");
    let long = " ".repeat((4 << 20) + 1);
    for (bytes, words) in [
        (&b"PK\x03\x04\xff"[..], "an archive, such as an FMU"),
        (&b"\xff\xfe{"[..], "no text in UTF-8"),
        (long.as_bytes(), "longer than 4 MiB"),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(
            error.contains(words) && error.contains("pair.json"),
            "{error}"
        );
    }
}

/// Field and message of text that is no pair file.
fn form(text: &str) -> (String, String) {
    match from_json(text) {
        Err(PairError::Form { field, message }) => (field, message),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_misspelt_field_leads_to_its_neighbour() {
    for (name, given) in [
        ("helix_angle_deg", "helix_deg"),
        ("normal_module_mm", "modul_mm"),
        ("normal_module_mm", "m_n"),
        ("center_distance_mm", "centre_distance_mm"),
        ("face_width_mm", "facewidth_mm"),
        ("face_width_mm", "b"),
        ("teeth", "z"),
        ("teeth", "theeth"),
        ("lead_crowning_um", "lead_crown_um"),
        ("amount_um", "amout_um"),
        ("nominal_torque_nm", "torque_nm"),
        ("misalignment_mrad", "misalignment_mm"),
    ] {
        let text = PAPER.replace(&format!("\"{name}\""), &format!("\"{given}\""));
        let (field, message) = form(&text);
        assert!(field.ends_with(given), "{field}: {message}");
        let words = format!("did you mean `{name}`?");
        assert!(message.contains(&words), "{field}: {message}");
    }
}

/// Field that gets this value, and words of the message.
const FORMS: &[(&str, &str, &str)] = &[
    // In the wrong place, or with no more than the unit in common.
    ("face_width_mm", "25", "`gear1` and `gear2`"),
    ("nominal_torque_nm", "25", "`operating`"),
    ("gear1.helix_angle_deg", "25", "outside of the gears"),
    ("gear1.colour", "4", "`teeth`, `profile_shift`"),
    (
        "gear1.root_dia_mm",
        "70",
        "did you mean `root_diameter_mm`?",
    ),
    ("gear1.reference_diameter_mm", "70", "; there are `teeth`"),
    ("gear1.outside_diameter_mm", "90", "`tip_diameter_mm`"),
    // Of another kind.
    ("gear2.teeth", "-20", "`-20`; a whole number"),
    ("gear2.teeth", "4294967296", "`4294967296`; a whole number"),
    ("gear2.teeth", "20.5", "`20.5`; a whole number"),
    (
        "normal_module_mm",
        r#""4 mm""#,
        "\"4 mm\" is text; a bare number",
    ),
    ("normal_module_mm", r#""4.0""#, "without quotes: 4.0"),
    ("normal_module_mm", r#""4,5""#, "without quotes: 4.5"),
    ("normal_module_mm", "true", "`true`; a bare number"),
    ("meshing", r#""extern""#, "did you mean `external`?"),
    ("meshing", r#""outer""#, "`external`, `internal`"),
    ("meshing", "1", "\"meshing\":1"),
    ("gear1", "20", "`20`; fields in braces, { ... } is expected"),
    ("gear1.tip_relief.start", r#""tip""#, "`pitch_point`"),
    (
        "gear1.tip_relief.start",
        "47.2",
        "such as { \"diameter_mm\": 88.0 }",
    ),
    (
        "gear1.tip_relief.shape",
        r#""parabola""#,
        "did you mean `parabolic`?",
    ),
    (
        "gear1.tip_relief.shape",
        r#""round""#,
        "there are `linear`, `parabolic`, `arc`",
    ),
    (
        "gear1.span_measurement_mm",
        r#""32,8""#,
        "`\"32,8\"`; a bare number",
    ),
    ("gear1.span_measurement_mm", "[1, 2, 3]", "[lower, upper]"),
    (
        "gear2.tooth_errors.drive_flank.pitch_class",
        r#""6""#,
        "without quotes: 6",
    ),
    (
        "gear2.tooth_errors.drive_flank.pitch_class",
        "600",
        "a whole number, 0 to 255",
    ),
    (
        "operating.misalignment_mrad",
        "[1]",
        "[lowest, highest] is expected",
    ),
    (
        "operating.misalignment_mrad",
        "1",
        "[lowest, highest] is expected",
    ),
    ("tip_corner_contact", r#""on""#, "true or false is expected"),
];

#[test]
fn a_value_of_another_form_is_refused_by_field_and_value_without_the_words_of_a_parser() {
    for (name, value, words) in FORMS {
        let (field, message) = form(&patched(PAPER, &setting(name, value)));
        assert_eq!(field, *name, "{message}");
        assert!(message.contains(words), "{message}");
        for jargon in [
            "f64",
            "u32",
            "u8",
            "struct",
            "variant",
            "JSON",
            "invalid type",
            "EOF",
        ] {
            assert!(!message.contains(jargon), "{message}");
        }
    }
    let (field, message) = form(&patched(PAPER, r#"{"gear2": {"teeth": null}}"#));
    assert_eq!(field, "gear2.teeth");
    assert!(message.contains("required and missing"), "{message}");
}

#[test]
fn text_that_is_no_json_is_refused_by_line_and_column_with_the_text_there() {
    #[rustfmt::skip]
    let cases = [
        (PAPER.replacen("4.0,", "NaN,", 1), "\"normal_module_mm\": NaN"),
        (PAPER.replacen("4.0,", "1e999,", 1), "out of range"),
        (PAPER.replacen("4.0,", "4.0", 1), "expected `,`"),
        (PAPER.replacen("\"meshing\"", "meshing", 1), "in double quotes is expected"),
        (PAPER.replacen("\"normal_module_mm\": 4.0", "\"normal_module_mm\": 4,0", 1), "a decimal point, no comma (line 5, column 25: \"normal_module_mm\": 4,0"),
        (PAPER.replacen("90.315", "90,315", 1), "\"tip_diameter_mm\": 90,315"),
        (PAPER.replacen("[-3.0, 3.0]", "[-3,0, 3,0]", 1), "decimal point"),
        (format!("{PAPER} {{}}"), "after the closing bracket"),
        (PAPER[..100].to_owned(), "double quote"),
        (PAPER[..PAPER.len() - 2].to_owned(), "may have been cut"),
        ("/* open".to_owned(), "no fields"),
        (String::new(), "gearmesh new"),
        ("{\n  /* one\n two */ // three\n  \"name\": 7 }".to_owned(), "line 4, column 11"),
    ];
    for (text, words) in cases {
        let (field, message) = form(&text);
        assert!(message.contains(words), "{field}: {message}");
    }
}

#[test]
fn names_are_cut_in_messages() {
    let name = setting("name", &format!("\"{}\"", "齿".repeat(1_000_000)));
    let error = from_json(&patched(PAPER, &name)).unwrap_err().to_string();
    assert!(error.chars().count() < 600, "{error}");
    let error = from_json(&PAPER.replace("meshing", &"x".repeat(1_000_000)));
    assert!(error.unwrap_err().to_string().len() < 1000);
}
