//! Files that are refused, and what is said of them: field, value, problem and remedy.

use super::*;

/// A large mate whose tips reach the fillets of gear 1.
pub const LARGE_MATE: &str = r#"{
    "gear1": {"teeth": 18, "profile_shift": 0, "tip_diameter_mm": null, "tip_relief": null},
    "gear2": {"teeth": 150, "profile_shift": 0, "tip_diameter_mm": 684.9, "tip_relief": null},
    "center_distance_mm": null
}"#;

/// The JSON that sets a field, such as `gear1.teeth`.
pub fn setting(field: &str, value: &str) -> String {
    let names = field.rsplit('.');
    names.fold(value.to_owned(), |inner, name| {
        format!("{{\"{name}\": {inner}}}")
    })
}

#[test]
fn every_refusal_names_field_value_problem_and_remedy() {
    for [base, patch, field, value, words] in rows(include_str!("refused.txt")) {
        let patch = match patch {
            "" => setting(field, value),
            patch => patch.to_owned(),
        };
        let refusal = refusal(&named(base), &patch);
        let message = refusal.to_string();
        let case = format!("{base}, {patch}: {message}");
        let number = |text: &str| text.parse::<f64>().ok();
        let is_same = number(value).is_some() && number(value) == number(&refusal.value);
        assert_eq!(refusal.field, field, "{case}");
        let values = ["", &refusal.value, &format!("\"{}\"", refusal.value)];
        assert!(is_same || values.contains(&value), "{case}");
        assert!(message.contains(words), "{case}");
        let mut verbs = "give choose check shorten narrow leave".split(' ');
        assert!(verbs.any(|verb| refusal.remedy.starts_with(verb)), "{case}");
        for part in [&refusal.field, &refusal.value, &refusal.remedy] {
            assert!(message.contains(part.as_str()), "{case}");
        }
    }
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
fn a_refused_module_gives_no_limits_to_other_fields() {
    let text = patched(PAPER, r#"{"normal_module_mm": 0, "backlash_um": 50}"#);
    let Err(PairError::Refused(refusals)) = from_json(&text) else {
        panic!("not refused");
    };
    let fields = refusals.all().iter().map(|refusal| &refusal.field[..]);
    assert_eq!(fields.collect::<Vec<_>>(), ["normal_module_mm"]);
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
        let parts = [words, "pair.json"];
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

/// Fields and messages of text that is no pair file.
fn forms(text: &str) -> Vec<(String, String)> {
    match from_json(text) {
        Err(PairError::Form(all)) => all
            .into_iter()
            .map(|one| (one.field, one.message))
            .collect(),
        other => panic!("{other:?}"),
    }
}

/// The first of them.
fn form(text: &str) -> (String, String) {
    forms(text).swap_remove(0)
}

#[test]
fn all_fields_of_another_form_are_named_at_once_with_their_lines() {
    let text = r#"{
  "name": "many slips",
  "meshing": "extern",
  "modul_mm": "4",
  "normal_pressure_angle_deg": 20,
  "helix_angle": 13,
  "gear1": {
    "teeth": 20.5, "face_width_mm": 25,
    "tip_relief": { "amount_um": "10", "start": "pitch", "shape": "parabolic" },
    "colour": "blue"
  },
  "gear2": {
    "teeth": 30,
    "face_width_mm": [25],
    "shaft": { "start_mm": -50, "torque_end": "left", "sections": [ { "diameter": 30, "length_mm": 80 }, 7 ],
      "bearings": [ { "z_mm": "a", "radial_stiffness_n_per_um": 100 } ] }
  },
  "operating": { "nominal_torque_nm": 100, "maximum_torque_nm": true, "center_distance_offset_um": 5, "misalignment_mrad": [-1, 1] }
}"#;
    let found = forms(text);
    let fields: Vec<&str> = found.iter().map(|(field, _)| field.as_str()).collect();
    for field in [
        "meshing",
        "modul_mm",
        "normal_module_mm",
        "helix_angle",
        "gear1.teeth",
        "gear1.tip_relief.amount_um",
        "gear1.colour",
        "gear2.face_width_mm",
        "gear2.shaft.torque_end",
        "gear2.shaft.sections[0].diameter",
        "gear2.shaft.bearings[0].z_mm",
        "operating.maximum_torque_nm",
        "operating.center_distance_offset_um",
    ] {
        let of = found.iter().find(|(found, _)| found == field);
        let (_, message) = of.unwrap_or_else(|| panic!("{field} is not among {fields:?}"));
        let name = field.rsplit(['.', ']']).next().unwrap();
        let lines: Vec<usize> = (text.lines().enumerate())
            .filter(|(_, line)| line.contains(name))
            .map(|(k, _)| k + 1)
            .collect();
        // What was misspelt has the right name by then.
        let is_placed = lines
            .iter()
            .any(|line| message.contains(&format!("line {line}")));
        assert!(is_placed || lines.is_empty(), "{field}: {message}");
    }
    // What follows from another slip is not named.
    assert!(
        found
            .iter()
            .all(|(_, message)| !message.contains("missing")),
        "{found:#?}"
    );
}

#[test]
fn a_misspelt_field_leads_to_its_neighbour() {
    for (name, misspelt) in [
        ("helix_angle_deg", &["helix_deg"][..]),
        ("normal_module_mm", &["modul_mm", "m_n"]),
        ("center_distance_mm", &["centre_distance_mm"]),
        ("face_width_mm", &["facewidth_mm", "b"]),
        ("teeth", &["z", "theeth"]),
        ("lead_crowning_um", &["lead_crown_um"]),
        ("amount_um", &["amout_um"]),
        ("nominal_torque_nm", &["torque_nm"]),
        ("misalignment_mrad", &["misalignment_mm"]),
    ] {
        for given in misspelt {
            let text = PAPER.replace(&format!("\"{name}\""), &format!("\"{given}\""));
            let (field, message) = form(&text);
            let hint = format!("did you mean `{name}`?");
            let is_right = field.ends_with(given) && message.contains(&hint);
            assert!(is_right, "{field}: {message}");
        }
    }
}

#[test]
fn a_value_of_another_form_is_refused_by_field_and_value_without_the_words_of_a_parser() {
    let jargon = "f64|u32|u8|struct|variant|JSON|invalid type|EOF";
    for [name, value, words] in rows(include_str!("forms.txt")) {
        let (field, message) = form(&patched(PAPER, &setting(name, value)));
        assert_eq!(field, name, "{message}");
        assert!(message.contains(words), "{message}");
        let mut jargon = jargon.split('|');
        assert!(!jargon.any(|word| message.contains(word)), "{message}");
    }
    let table = r#"{"gear1": {"youngs_modulus_over_temperature": [20, 2.8]}}"#;
    let (field, message) = form(&patched(PAPER, table));
    assert_eq!(field, "gear1.youngs_modulus_over_temperature[0]");
    assert!(message.contains("[°C, GPa]"), "{message}");
    let (field, message) = form(&patched(PAPER, r#"{"gear2": {"teeth": null}}"#));
    assert_eq!(field, "gear2.teeth");
    assert!(message.contains("required and missing"), "{message}");
}

#[test]
fn a_number_that_is_not_whole_is_refused_at_its_own_line_also_at_the_end_of_its_braces() {
    let given = [
        ("rim_pins", 2.5, "whole number, 0 to"),
        ("rim_supports", -3.0, "whole number, 0 to"),
    ];
    for (field, count, words) in given {
        let group = format!("\"{field}\": {{\n\"count\": {count:?}\n}},\n\"face_width_mm\"");
        let text = PAPER.replacen("\"face_width_mm\"", &group, 1);
        let line = 1 + text.lines().position(|l| l.contains("\"count\"")).unwrap();
        let (path, message) = form(&text);
        assert_eq!(path, format!("gear1.{field}.count"));
        let shown = format!("`{count}`; a {words}");
        assert!(message.contains(&shown), "{message}");
        assert!(message.contains(&format!("(line {line}, ")), "{message}");
    }
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
        (PAPER.replacen("\"face_width_mm\"", "\"youngs_modulus_over_temperature\": [[20, 2,8]], \"face_width_mm\"", 1), "more than two numbers; a pair [°C, GPa]"),
        (format!("{PAPER} {{}}"), "after the closing bracket"),
        ("<?xml version=\"1.0\"?>\n<model/>".to_owned(), "this is XML and no pair file; `gearmesh new --rexs`"),
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

/// Faults of fields, of gears and of the pair; those of one line are found together.
const TOGETHER: &str = r#"paper | {"normal_pressure_angle_deg": 5, "gear1": {"teeth": 2, "poisson_ratio": 0.7, "lead_crowning_um": -1}, "gear2": {"profile_shift": 9, "tip_relief": {"amount_um": -3}}, "operating": {"misalignment_mrad": [1, 2], "maximum_torque_nm": 1}, "friction": {"coefficient": 2}} | normal_pressure_angle_deg gear1.teeth gear1.poisson_ratio gear1.lead_crowning_um gear2.profile_shift gear2.tip_relief.amount_um operating.misalignment_mrad operating.maximum_torque_nm friction.coefficient
paper | {"gear1": {"teeth": 2}, "gear2": {"tip_diameter_mm": 110}, "friction": {"law": "schlenk"}} | gear1.teeth gear2.tip_diameter_mm friction.dynamic_viscosity_mpa_s
paper | {"gear1": {"tip_diameter_mm": 110}, "gear2": {"root_diameter_mm": 10}} | gear1.tip_diameter_mm gear2.root_diameter_mm
paper | {"center_distance_mm": 70, "face_offset_mm": 25, "operating": {"nominal_torque_nm": 1e6, "maximum_torque_nm": 1e6}} | center_distance_mm face_offset_mm
paper | {"center_distance_mm": 70, "operating": {"nominal_torque_nm": 1e6, "maximum_torque_nm": 1e6}} | center_distance_mm operating.nominal_torque_nm
paper | {"gear1": {"rim_thickness_mm": 6}, "gear2": {"web_thickness_mm": 6}} | gear1.rim_thickness_mm gear2.web_thickness_mm
paper | {"gear1": {"bore_diameter_mm": 72}, "gear2": {"bore_diameter_mm": 100}} | gear1.bore_diameter_mm gear2.bore_diameter_mm
paper | {"gear1": {"tip_relief": {"start": {"diameter_mm": 50}}}, "gear2": {"tip_relief": {"start": {"diameter_mm": 50}}, "topography_file": "none.csv"}} | gear1.tip_relief.start gear2.tip_relief.start gear2.topography_file
bearings | {"gear1": {"tip_relief": {"start": {"diameter_mm": 50}}, "shaft": {"poisson_ratio": 0.7, "start_mm": 1e6}}} | gear1.tip_relief.start gear1.shaft.poisson_ratio gear1.shaft.start_mm
paper | {"center_distance_mm": 90, "gear1": {"tip_relief": null, "drive_flank": {"topography_file": "none.csv"}}, "gear2": {"tip_relief": null}} | center_distance_mm gear1.drive_flank.topography_file"#;

#[test]
fn all_refusals_that_can_be_found_come_at_once_and_each_once() {
    for [base, patch, fields] in rows(TOGETHER) {
        let refusals = refusals(&named(base), patch);
        let mut found: Vec<&str> = refusals.iter().map(|r| &*r.field).collect();
        let mut expected: Vec<&str> = fields.split(' ').collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{patch}: {refusals:#?}");
    }
}

#[test]
fn names_are_titles_with_any_characters_of_one_line() {
    for name in [
        "a/b",
        r"C:\\gears\\1",
        "Stufe 2, Rad ∅ 90°",
        "歯車/齿轮",
        "a: \\\"b\\\" <c> | d?*",
    ] {
        pair(PAPER, &setting("name", &format!("\"{name}\"")));
    }
}

#[test]
fn a_long_list_of_refusals_ends() {
    let wrong = vec!["1e6"; 20].join(",");
    let list = |gear: &str| {
        format!(
            "{{\"{gear}\": {{\"tooth_errors\": {{\"drive_flank\": {{\"cumulative_pitch_um\": [{wrong}]}}}}}}}}"
        )
    };
    let both = patched(&patched(PAPER, &list("gear1")), &list("gear2"));
    let message = from_json(&both).unwrap_err().to_string();
    assert_eq!(message.lines().count(), 21, "{message}");
    assert!(message.ends_with("and 20 more"), "{message}");
}
