//! Rings in the signs of ISO 21771 and DIN 3960.

use super::*;

/// Fields of a ring whose numbers have the sign of its teeth.
const LENGTHS: [&str; 9] = [
    "tip_diameter_mm",
    "tip_form_diameter_mm",
    "root_form_diameter_mm",
    "root_diameter_mm",
    "span_measurement_mm",
    "span_teeth",
    "dimension_over_balls_mm",
    "diameter_mm",
    "roll_length_mm",
];

/// One ring in many ways, as quantities of gear 2 put over a base.
const QUANTITIES: &str = r#"internal | {"tip_form_diameter_mm": 165.4}
internal | {"root_diameter_mm": 173.8}
internal | {"root_diameter_mm": [173.7, 173.9]}
internal | {"profile_shift": null, "profile_shift_iso_21771": -0.2}
internal | {"profile_shift": null, "normal_tooth_thickness_mm": 2.85}
internal | {"root_form_diameter_mm": 172.4}
internal | {"tip_relief": {"amount_um": 8, "start": {"diameter_mm": null, "roll_length_mm": 25}}}
internal | {"tip_relief": {"amount_um": 8, "start": {"diameter_mm": null, "roll_angle_deg": 19}}}
internal | {"tip_relief": {"amount_um": 8, "start": {"diameter_mm": null, "from_tip_mm": 1}}}
internal | {"tip_relief": {"amount_um": 8}, "root_relief": {"amount_um": 3, "start": {"diameter_mm": 170}}}
internal | {"coast_flank": {"tip_relief": {"amount_um": 5, "start": {"diameter_mm": 167.5}}}}
internal | {"tip_diameter_mm": null, "addendum_coefficient": 0.8}
internal | {"rim_foundation_n_per_mm3": 100, "lead_slope_um": -4}
between balls | {}
between balls | {"dimension_over_balls_mm": [204.84, 204.86]}
span | {}
span | {"span_measurement_mm": [79.08, 79.11]}
helical | {}"#;

fn base(name: &str) -> String {
    if name == "internal" {
        return INTERNAL.into();
    }
    let mut all = drawings::drawings().into_iter();
    let is_named = |d: &Value| {
        d["file"]["name"]
            .as_str()
            .is_some_and(|title| title.contains(name))
    };
    let found = all.find(|d| is_named(d) && d["file"]["meshing"] == "internal");
    found.unwrap()["file"].to_string()
}

/// Turns the sign of numbers under one of `fields`.
fn turn(value: &mut Value, is_turned: bool, fields: &[&str]) {
    match value {
        Value::Object(map) => {
            for (name, value) in map {
                turn(value, fields.contains(&&**name), fields);
            }
        }
        Value::Array(values) if is_turned => {
            values.iter_mut().for_each(|v| turn(v, true, fields));
            values.reverse();
        }
        Value::Number(number) if is_turned => {
            *value = match number.as_i64() {
                Some(whole) => (-whole).into(),
                None => (-number.as_f64().unwrap()).into(),
            }
        }
        _ => {}
    }
}

/// The file in the signs of ISO 21771, with the lengths negative as in DIN 3960 or not.
fn signed(text: &str, ring: &str, are_negative: bool) -> String {
    let mut file: Value = serde_json::from_str(text).unwrap();
    turn(&mut file[ring], false, &["teeth", "profile_shift"]);
    if are_negative {
        turn(&mut file[ring], false, &LENGTHS);
        turn(&mut file, false, &["center_distance_mm"]);
    }
    file.to_string()
}

/// The file with its gears exchanged.
fn exchanged(text: &str) -> String {
    let mut file: Value = serde_json::from_str(text).unwrap();
    let [one, two] = ["gear1", "gear2"].map(|gear| file[gear].take());
    (file["gear1"], file["gear2"]) = (two, one);
    file.to_string()
}

#[test]
fn a_ring_in_the_signs_of_iso_21771_is_the_same_pair_bit_for_bit_in_every_quantity() {
    for [name, patch] in rows(QUANTITIES) {
        let own = patched(&base(name), &format!("{{\"gear2\": {patch}}}"));
        let right = format!("{:?}", pair(&own, "{}"));
        for are_negative in [true, false] {
            let signed = signed(&own, "gear2", are_negative);
            assert!(signed.contains("\"teeth\":-"), "{signed}");
            assert_eq!(format!("{:?}", pair(&signed, "{}")), right, "{signed}");
        }
        // The ring as gear 1: negative teeth name it, as its rim does.
        if name == "internal" {
            let own = exchanged(&own);
            let right = format!("{:?}", pair(&own, "{}"));
            let mut signed = signed(&own, "gear1", true);
            assert_eq!(format!("{:?}", pair(&signed, "{}")), right, "{signed}");
            let rim = patched(&signed, r#"{"gear1": {"rim_diameter_mm": -192}}"#);
            let unsigned = patched(&signed, r#"{"gear1": {"rim_diameter_mm": 192}}"#);
            assert_eq!(
                format!("{:?}", pair(&rim, "{}")),
                format!("{:?}", pair(&unsigned, "{}"))
            );
            signed = patched(&signed, r#"{"gear1": {"rim_diameter_mm": null}}"#);
            assert_eq!(pair(&signed, "{}").geometry.ring(), Some(0));
        }
    }
}

#[test]
fn mixed_signs_are_refused_with_field_value_and_what_to_give() {
    for (patch, field, value, words) in [
        (
            r#"{"gear2": {"tip_diameter_mm": -165.2}}"#,
            "gear2.tip_diameter_mm",
            "-165.2",
            "give 165.2, or -84 teeth",
        ),
        (
            r#"{"center_distance_mm": -57}"#,
            "center_distance_mm",
            "-57",
            "give 57, or -84 teeth",
        ),
        (
            r#"{"gear2": {"teeth": -84, "profile_shift": -0.2, "tip_diameter_mm": -165.2}}"#,
            "gear2.tip_relief.start",
            "167",
            "one sign",
        ),
        (
            r#"{"gear2": {"teeth": -84, "profile_shift": -0.2, "root_diameter_mm": [-173.9, -173.7]}}"#,
            "gear2.root_diameter_mm",
            "[-173.9, -173.7]",
            "one sign",
        ),
        (
            r#"{"gear1": {"teeth": -27}}"#,
            "gear1.teeth",
            "-27",
            "give 27",
        ),
    ] {
        let refusal = refusal(INTERNAL, patch);
        let message = refusal.to_string();
        assert_eq!(
            (&*refusal.field, &*refusal.value),
            (field, value),
            "{message}"
        );
        assert!(message.contains(words), "{message}");
    }
    // What is refused later has the value of the file.
    let patch = r#"{"gear2": {"tip_diameter_mm": -174}}"#;
    let refusal = refusal(&patched(&signed(INTERNAL, "gear2", true), patch), "{}");
    assert_eq!(
        (&*refusal.field, &*refusal.value),
        ("gear2.tip_diameter_mm", "-174")
    );
    assert!(refusal.remedy.contains("without the signs"), "{refusal}");
}

#[test]
fn a_draft_varies_a_ring_in_the_signs_of_its_file() {
    let text = signed(&base("between balls"), "gear2", true);
    let mut draft = PairDraft {
        fields: serde_json::from_str(&text).unwrap(),
        folder: PathBuf::new(),
    };
    let field = "gear2.dimension_over_balls_mm";
    let (middle, before) = (draft.number(field).unwrap(), draft.pair().unwrap());
    assert!(middle < 0.0);
    draft.set(field, middle - 0.01).unwrap();
    let after = draft.pair().unwrap();
    let thinning =
        |pair: &Pair| pair.geometry.gears[1].tooth_thinning - pair.geometry.gears[1].profile_shift;
    assert_ne!(thinning(&before), thinning(&after));
}
