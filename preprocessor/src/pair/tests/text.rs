//! What may stand in a pair file beside its fields, and what is said of text that is none.

use super::*;
use crate::pair;

fn form(text: &str) -> (String, String) {
    match pair::from_json(text) {
        Err(PairError::Form { field, message }) => (field, message),
        other => panic!("{other:?}"),
    }
}

#[test]
fn comments_a_byte_order_mark_and_last_commas_change_nothing() {
    let commented = PAPER
        .replace("{\n", "{ // of the drawing, with a \" in it\n")
        .replace("\"gear1\"", "/* the pinion\n, on two lines */ \"gear1\"")
        .replace(
            "\"lead_crowning_um\": 4.5\n",
            "\"lead_crowning_um\": 4.5, # measured\n",
        );
    assert_ne!(commented, PAPER);
    let pair = pair::from_json(&format!("\u{feff}{commented}")).unwrap();
    assert_eq!(pair, pair::from_json(PAPER).unwrap());
    // In a text they are no comments.
    let url = r#"{"source": "https://example.org /* 1 */"}"#;
    pair::from_json(&patched(PAPER, url)).unwrap();
}

#[test]
fn lines_and_columns_are_those_of_the_file_with_its_comments() {
    let (field, message) = form("{\n  /* one\n two */ // three\n  \"name\": 7 }");
    assert_eq!(field, "name");
    assert!(message.contains("line 4, column 11"), "{message}");
}

#[test]
fn a_misspelt_field_is_told_of_its_neighbour() {
    #[rustfmt::skip]
    let slips = [
        ("helix_angle_deg", "helix_deg", "helix_angle_deg"),
        ("normal_module_mm", "modul_mm", "normal_module_mm"),
        ("normal_module_mm", "m_n", "normal_module_mm"),
        ("center_distance_mm", "centre_distance_mm", "center_distance_mm"),
        ("face_width_mm", "facewidth_mm", "face_width_mm"),
        ("face_width_mm", "b", "face_width_mm"),
        ("teeth", "z", "teeth"),
        ("teeth", "theeth", "teeth"),
        ("lead_crowning_um", "lead_crown_um", "lead_crowning_um"),
        ("amount_um", "amout_um", "amount_um"),
        ("nominal_torque_nm", "torque_nm", "nominal_torque_nm"),
        ("misalignment_mrad", "misalignment_mm", "misalignment_mrad"),
    ];
    for (name, given, meant) in slips {
        let (field, message) =
            form(&PAPER.replace(&format!("\"{name}\""), &format!("\"{given}\"")));
        assert!(field.ends_with(given), "{field}: {message}");
        assert!(
            message.contains(&format!("did you mean `{meant}`?")),
            "{field}: {message}"
        );
    }
}

#[test]
fn a_field_in_the_wrong_place_is_told_of_the_right_one() {
    #[rustfmt::skip]
    let cases = [
        (r#"{"face_width_mm": 25}"#, "`gear1` and `gear2`"),
        (r#"{"nominal_torque_nm": 25}"#, "`operating`"),
        (r#"{"gear1": {"helix_angle_deg": 25}}"#, "outside of the gears"),
    ];
    for (patch, told) in cases {
        let (_, message) = form(&patched(PAPER, patch));
        assert!(message.contains(told), "{patch}: {message}");
    }
    let (field, message) = form(&patched(PAPER, r#"{"gear1": {"colour": 4}}"#));
    assert_eq!(field, "gear1.colour");
    assert!(message.contains("`teeth`, `profile_shift`"), "{message}");
}

#[test]
fn a_unit_in_common_does_not_make_a_name() {
    let told = |name: &str| {
        form(&patched(
            PAPER,
            &format!(r#"{{"gear1": {{"{name}": 70}}}}"#),
        ))
        .1
    };
    let root = told("root_dia_mm");
    assert!(root.contains("did you mean `root_diameter_mm`?"), "{root}");
    let reference = told("reference_diameter_mm");
    assert!(!reference.contains("did you mean"), "{reference}");
    let outside = told("outside_diameter_mm");
    assert!(outside.contains("`tip_diameter_mm`"), "{outside}");
}

#[test]
fn a_file_that_is_no_text_is_told_by_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let told = |bytes: &[u8]| {
        let path = folder.path().join("pair.fmu");
        std::fs::write(&path, bytes).unwrap();
        pair::read(&path).unwrap_err().to_string()
    };
    assert!(told(b"PK\x03\x04\xff").contains("an archive, such as an FMU"));
    assert!(told(b"\xff\xfe{").contains("no text in UTF-8"));
}

#[test]
fn a_decimal_comma_is_told_by_field_and_number() {
    #[rustfmt::skip]
    let cases = [
        ("\"normal_module_mm\": 4.0", "\"normal_module_mm\": 4,0", "normal_module_mm", "write 4.0 with a point"),
        ("\"tip_diameter_mm\": 90.315", "\"tip_diameter_mm\": 90,315", "gear1.tip_diameter_mm", "write 90.315 with a point"),
        ("\"normal_module_mm\": 4.0", "\"normal_module_mm\": \"4,5\"", "normal_module_mm", "without quotes: 4.5"),
        ("[-3.0, 3.0]", "[-3,0, 3,0]", "operating.misalignment_mrad", "decimal point"),
    ];
    for (good, bad, name, told) in cases {
        let text = PAPER.replacen(good, bad, 1);
        assert_ne!(text, PAPER);
        let (field, message) = form(&text);
        assert_eq!(field, name, "{message}");
        assert!(message.contains(told), "{message}");
    }
}

/// What is put over the paper's pair, the field, and what must be said.
#[rustfmt::skip]
const MISTYPED: &[[&str; 3]] = &[
    [r#"{"gear2": {"teeth": -20}}"#, "gear2.teeth", "`-20`; a whole number, 0 to 4294967295 is expected"],
    [r#"{"gear2": {"teeth": 4294967296}}"#, "gear2.teeth", "`4294967296`; a whole number, 0 to 4294967295 is expected"],
    [r#"{"gear2": {"tooth_errors": {"drive_flank": {"pitch_class": 6, "seed": 18446744073709551615}}}}"#, "gear2.tooth_errors.drive_flank.seed", "`18446744073709551615`; a whole number, 0 to 4294967295 is expected"],
    [r#"{"gear2": {"teeth": 20.5}}"#, "gear2.teeth", "`20.5`; a whole number, 0 to 4294967295 is expected"],
    [r#"{"gear2": {"teeth": null}}"#, "gear2.teeth", "required and missing"],
    [r#"{"normal_module_mm": "4 mm"}"#, "normal_module_mm", "\"4 mm\" is text; write a bare number"],
    [r#"{"normal_module_mm": "4.0"}"#, "normal_module_mm", "write it without quotes: 4.0"],
    [r#"{"normal_module_mm": true}"#, "normal_module_mm", "`true`; a number is expected"],
    [r#"{"meshing": "extern"}"#, "meshing", "did you mean \"external\"?"],
    [r#"{"meshing": "outer"}"#, "meshing", "`external`, `internal`"],
    [r#"{"gear1": 20}"#, "gear1", "`20`; fields in braces, { ... } is expected"],
    [r#"{"gear1": {"tip_relief": {"start": "tip"}}}"#, "gear1.tip_relief.start", "`pitch_point`"],
    [r#"{"gear1": {"tip_relief": {"shape": "parabola"}}}"#, "gear1.tip_relief.shape", "did you mean \"parabolic\"?"],
    [r#"{"gear1": {"tip_relief": {"start": 47.2}}}"#, "gear1.tip_relief.start", "give { \"diameter_mm\": 47.2 }"],
    [r#"{"gear1": {"tip_relief": {"start": "diameter_mm"}}}"#, "gear1.tip_relief.start.diameter_mm", "such as { \"diameter_mm\": 88.0 }"],
    [r#"{"meshing": 1}"#, "meshing", "`1`; one of the names of this field in double quotes"],
    [r#"{"gear2": {"tooth_errors": {"drive_flank": {"pitch_class": "6"}}}}"#, "gear2.tooth_errors.drive_flank.pitch_class", "write it without quotes: 6"],
    [r#"{"gear2": {"tooth_errors": {"drive_flank": {"pitch_class": 600}}}}"#, "gear2.tooth_errors.drive_flank.pitch_class", "a whole number, 0 to 255 is expected"],
    [r#"{"operating": {"misalignment_mrad": [1]}}"#, "operating.misalignment_mrad", "[lowest, highest]"],
    [r#"{"operating": {"misalignment_mrad": 1}}"#, "operating.misalignment_mrad", "[lowest, highest] is expected"],
    [r#"{"tip_corner_contact": "on"}"#, "tip_corner_contact", "true or false is expected"],
];

#[test]
fn a_value_of_another_kind_is_told_without_the_words_of_a_parser() {
    for [patch, field, told] in MISTYPED {
        let (at, message) = form(&patched(PAPER, patch));
        assert_eq!(at, *field, "{message}");
        assert!(message.contains(told), "{message}");
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
}

#[test]
fn text_that_is_no_json_is_told_by_line_and_column() {
    #[rustfmt::skip]
    let cases = [
        (PAPER.replacen("4.0,", "NaN,", 1), "normal_module_mm", "no value that JSON knows"),
        (PAPER.replacen("4.0,", "1e999,", 1), "normal_module_mm", "out of range"),
        (PAPER.replacen("4.0,", "4.0", 1), ".", "expected `,`"),
        (PAPER.replacen("\"meshing\"", "meshing", 1), ".", "in double quotes is expected"),
        (format!("{PAPER} {{}}"), ".", "after the closing bracket"),
        (PAPER[..100].to_owned(), ".", "double quote"),
        (PAPER[..PAPER.len() - 2].to_owned(), ".", "may have been cut"),
        ("/* open".to_owned(), ".", "no fields"),
        (String::new(), ".", "gearmesh new"),
    ];
    for (text, field, told) in cases {
        let (at, message) = form(&text);
        assert!(message.contains(told), "{at}: {message}");
        assert!(at == field || field == ".", "{at}: {message}");
    }
}

#[test]
fn a_name_has_a_hundred_characters_of_any_script_and_is_cut_in_messages() {
    let named = |name: &str| patched(PAPER, &format!(r#"{{"name": "{name}"}}"#));
    pair::from_json(&named(&"齿".repeat(100))).unwrap();
    let error = pair::from_json(&named(&"齿".repeat(1_000_000)))
        .unwrap_err()
        .to_string();
    assert!(error.chars().count() < 600, "{error}");
    let error = pair::from_json(&PAPER.replace("meshing", &"x".repeat(1_000_000)));
    assert!(error.unwrap_err().to_string().len() < 1000);
}

#[test]
fn a_file_without_end_is_refused_by_its_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.json");
    std::fs::write(&path, " ".repeat((4 << 20) + 1)).unwrap();
    let error = pair::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("long.json") && error.contains("longer than 4 MiB"),
        "{error}"
    );
}
