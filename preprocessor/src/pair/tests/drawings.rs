//! Pairs typed from the quantities of their drawings alone.

use approx::{assert_abs_diff_eq, assert_relative_eq};

use super::dimension::Dimension;
use super::drawing::{Measure, generating_profile_shift, lead};
use super::*;
use gearmesh::gear::Gear;
use serde_json::json;

/// Twelve drawings. Their dimensions were computed in the signs of ISO 21771 (ring: negative tooth numbers) from profile
/// shifts, with the involute equations of that standard solved by bisection in another program; no file has a profile shift.
const DRAWINGS: &str = include_str!("drawings.json");

pub fn drawings() -> Vec<Value> {
    serde_json::from_str(DRAWINGS).unwrap()
}

fn read(file: &Value) -> Pair {
    pair(&file.to_string(), "{}")
}

fn thickness(gear: &Gear) -> f64 {
    Measure::Thickness.of(gear).unwrap()
}

fn middle(value: &Value) -> Option<f64> {
    let dimension: Option<Dimension> = serde_json::from_value(value.clone()).ok();
    dimension.map(Dimension::middle)
}

#[test]
fn drawings_without_profile_shifts_give_the_teeth_that_they_were_computed_from() {
    for drawing in drawings() {
        let (file, expected) = (&drawing["file"], &drawing["expected"]);
        let pair = read(file);
        for (i, gear) in pair.geometry.gears.iter().enumerate() {
            let s = 1e3 * thickness(gear);
            let right = expected["normal_tooth_thickness_mm"][i].as_f64().unwrap();
            assert_abs_diff_eq!(s, right, epsilon = 2e-3);
            let x = gear.kappa() * generating_profile_shift(gear, 1e-3 * s);
            let right = &expected["generating_profile_shift_iso"][i];
            assert_abs_diff_eq!(x, right.as_f64().unwrap(), epsilon = 2e-3);
            let given = &file[format!("gear{}", i + 1)];
            let root = middle(&given["root_diameter_mm"]).unwrap();
            assert_abs_diff_eq!(2e3 * gear.root_radius(), root, epsilon = 0.011);
            shown_as_given(gear, given);
        }
        if let Some(helix) = expected["helix_angle_deg"].as_f64() {
            let gear = &pair.geometry.gears[0];
            let shown = gear.hand * gear.helix_angle.to_degrees();
            assert_abs_diff_eq!(shown, helix, epsilon = 1e-4);
        }
    }
}

/// The measures of a drawing come out of the gear that was read from it.
fn shown_as_given(gear: &Gear, given: &Value) {
    let mm = |name: &str| middle(&given[name]);
    if let Some(w) = mm("span_measurement_mm") {
        let k = given["span_teeth"].as_u64().unwrap() as u32;
        assert_abs_diff_eq!(1e3 * Measure::Span(k).of(gear).unwrap(), w, epsilon = 3e-3);
    }
    if let (Some(m), Some(ball)) = (mm("dimension_over_balls_mm"), mm("ball_diameter_mm")) {
        let over = Measure::Balls(1e-3 * ball).of(gear).unwrap();
        assert_abs_diff_eq!(1e3 * over, m, epsilon = 3e-3);
    }
    if let Some(mm) = mm("lead_mm") {
        assert_relative_eq!(1e3 * lead(gear), mm, max_relative = 1e-6);
    }
}

#[test]
fn spans_are_those_of_published_tables() {
    // m_n 3, 20 degrees, z 24, x 0.4: 4 teeth, with 25 degrees of helix 5 (gear technical reference of KHK); m 2, z 20: 3.
    for (drawing, k, mm, digits) in [
        (0, 4, 32.8266, 1e-4),
        (1, 5, 42.0085, 1e-4),
        (2, 3, 15.321, 1e-3),
    ] {
        let gear = &read(&drawings()[drawing]["file"]).geometry.gears[0];
        let w = 1e3 * Measure::Span(k).of(gear).unwrap();
        assert_abs_diff_eq!(w, mm, epsilon = digits);
        assert_eq!(Gauges::usual(gear).span_teeth, k);
    }
}

#[test]
fn dimensions_over_balls_of_published_examples_give_their_profile_shifts() {
    // Spur gear, helical gear and ring of module 1 mm and 20 degrees in the gear technical reference of KHK.
    for (meshing, helix, i, ball, over, shift) in [
        ("external", 0.0, 0, 1.7, 22.2941, 0.0),
        ("external", 15.0, 0, 2.0, 24.5696, 0.4),
        ("internal", 0.0, 1, 1.7, 37.5951, 0.0),
    ] {
        let mut file = json!({
            "name": "published", "meshing": meshing, "normal_module_mm": 1.0,
            "normal_pressure_angle_deg": 20.0, "helix_angle_deg": helix,
            "gear1": {"teeth": 20, "face_width_mm": 10.0}, "gear2": {"teeth": 40, "face_width_mm": 10.0},
            "operating": {"nominal_torque_nm": 1.0, "maximum_torque_nm": 2.0,
                "center_distance_offset_um": [-5.0, 5.0], "misalignment_mrad": [-1.0, 1.0]},
        });
        let drawing = &mut file[["gear1", "gear2"][i]];
        drawing["ball_diameter_mm"] = json!(ball);
        drawing["dimension_over_balls_mm"] = json!(over);
        let gear = &read(&file).geometry.gears[i];
        let x = generating_profile_shift(gear, thickness(gear));
        assert_abs_diff_eq!(x, shift, epsilon = 1e-4);
    }
}

#[test]
fn usual_gauges_touch_between_root_and_tip() {
    for drawing in drawings() {
        for gear in &read(&drawing["file"]).geometry.gears {
            let gauges = Gauges::usual(gear);
            let (root, tip) = (gear.root_radius(), gear.tip_radius);
            let span = Measure::Span(gauges.span_teeth);
            for measure in [span, Measure::Balls(gauges.ball_diameter)] {
                let Some(value) = measure.of(gear) else {
                    assert!(matches!(measure, Measure::Span(_)) && gear.helix_angle > 0.0);
                    continue;
                };
                let radius = measure.contact_radius(gear, value).unwrap();
                let within = root.min(tip)..root.max(tip);
                assert!(within.contains(&radius), "{}", drawing["file"]["name"]);
            }
        }
    }
}

#[test]
fn the_profile_shift_of_a_ring_has_the_sign_of_its_field() {
    let ours = pair(INTERNAL, "{}");
    let iso = r#"{"gear2": {"profile_shift": null, "profile_shift_iso_21771": -0.2}}"#;
    let iso = pair(INTERNAL, iso);
    assert_eq!(ours, iso);
    let external = r#"{"gear1": {"profile_shift": null, "profile_shift_iso_21771": 0.2}}"#;
    assert_eq!(ours, pair(INTERNAL, external));
}

#[test]
fn normal_backlash_is_that_of_the_flanks() {
    let normal = r#"{"backlash_um": null, "normal_backlash_um": [60, 100]}"#;
    let g = pair(HELICAL, normal).geometry;
    let j = g.backlash(g.center_distance) * g.base_helix_angle().cos();
    assert_relative_eq!(j, 80e-6, max_relative = 1e-9);
}

#[test]
fn a_relief_starts_where_any_of_its_forms_says() {
    let diameter = pair(SPUR, "{}");
    let gear = &diameter.geometry.gears[0];
    let relief = |pair: &Pair| pair.microgeometry.drive[0].tip_relief.unwrap();
    let start = relief(&diameter).start_roll;
    let angle = (start / gear.base_radius()).to_degrees();
    let from_tip = 1e3 * (gear.tip_form_roll() - start);
    for (name, value) in [
        ("roll_length_mm", 1e3 * start),
        ("roll_angle_deg", angle),
        ("from_tip_mm", from_tip),
    ] {
        let patch = format!(
            r#"{{"gear1": {{"tip_relief": {{"start": {{"diameter_mm": null, "{name}": {value}}}}}}}}}"#
        );
        let found = relief(&pair(SPUR, &patch)).start_roll;
        assert_relative_eq!(found, start, max_relative = 1e-9);
        let error = refusal(SPUR, &patch.replace(&value.to_string(), "300")).to_string();
        let words = [name, "lengths of roll"];
        assert!(words.iter().all(|w| error.contains(w)), "{error}");
    }
}

#[test]
fn a_draft_varies_the_middle_of_limits() {
    let mut draft = PairDraft {
        fields: drawings()[5]["file"].clone(),
        folder: PathBuf::new(),
    };
    let s_n = "gear1.normal_tooth_thickness_mm";
    let thickness = |draft: &PairDraft| thickness(&draft.pair().unwrap().geometry.gears[0]);
    let (middle, before) = (draft.number(s_n).unwrap(), thickness(&draft));
    draft.set(s_n, middle - 0.01).unwrap();
    assert_abs_diff_eq!(before - thickness(&draft), 10e-6, epsilon = 1e-9);
}
