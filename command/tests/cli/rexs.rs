//! Pair files from REXS files.

use super::*;

fn rexs(name: &str) -> String {
    format!("{}/tests/rexs/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_stage_of_a_rexs_file_becomes_a_pair_file_that_says_what_it_took_assumed_and_left() {
    let folder = tempfile::tempdir().unwrap();
    let pair = folder.path().join("pair.json").display().to_string();
    let file = rexs("stage.rexs");
    let output = gearmesh(&["new", "--rexs", &file, "--torque-nm", "90", "-o", &pair]);
    assert!(output.status.success(), "{}", stderr(&output));
    let listed = stdout(&output);
    for line in [
        "taken: gear1.teeth from number_of_teeth of cylindrical_gear 11",
        "taken: gear1.lower_end_relief from end_relief_datum_face 34",
        "taken: gear2.dedendum_coefficient from addendum_coefficient_reference_profile of rack_shaped_tool 41",
        "assumed: gear2: the left flank is the drive flank",
        "left: triangular_tip_relief 33 of the flank 24",
        "left: gear2.root_diameter_mm = 70: does not fit",
        "left: cylindrical_gear 11: u_coordinate_on_shaft",
    ] {
        assert!(listed.contains(line), "{line}: {listed}");
    }
    let shown = gearmesh(&["inspect", &pair, "--json"]);
    let shown: serde_json::Value = serde_json::from_str(stdout(&shown)).unwrap();
    let near = |pointer: &str, value: f64, within: f64| {
        let shown = shown.pointer(pointer).and_then(|v| v.as_f64()).unwrap();
        assert!((shown - value).abs() < within, "{pointer} = {shown}");
    };
    near("/center_distance_mm", 82.104, 1e-9);
    near("/gear1/span_measurement_mm", 30.68, 1e-6);
    near("/gear2/dimension_over_balls_mm", 91.9, 1e-6);
    let drive = "/gear1/reliefs/drive_flank";
    let relief = format!("{drive}/tip_relief/start/diameter_mm");
    near(&relief, 86.0, 1e-6);
    near(&format!("{drive}/lower_end_relief/length_mm"), 3.0, 1e-9);
    near(&format!("{drive}/lead_slope_um"), 0.0, 1e-9);
    near("/gear2/reliefs/drive_flank/lead_crowning_um", 4.0, 1e-9);
    near("/gear1/lead_mm", 1117.2538, 1e-3);
    assert_eq!(shown["gear2"]["hand"], "left");
}

#[test]
fn a_ring_in_rexs_json_keeps_the_sign_of_iso_21771() {
    let output = gearmesh(&["new", "--rexs", &rexs("stages.rexsj"), "--stage", "1"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    for field in [
        "\"profile_shift_iso_21771\": -0.2",
        "\"teeth\": 84",
        "\"root_diameter_mm\": 173.8",
        "\"meshing\": \"internal\"",
    ] {
        assert!(text.contains(field), "{field}: {text}");
    }
}

#[test]
fn a_rexs_file_that_lacks_or_leaves_open_what_is_needed_is_refused_by_name() {
    for (arguments, problem) in [
        (
            &["stages.rexsj"][..],
            "2 cylindrical stages: 1 (Planet and ring), 4 (Second)",
        ),
        (&["stages.rexsj", "--stage", "7"], "--stage = 7"),
        (&["stages.rexsj", "--stage", "4"], "gear2.face_width_mm"),
        (&["../../Cargo.toml"], "no REXS file"),
    ] {
        let file = rexs(arguments[0]);
        let mut all = vec!["new", "--rexs", &file];
        all.extend(&arguments[1..]);
        let output = gearmesh(&all);
        assert!(!output.status.success());
        assert!(stderr(&output).contains(problem), "{}", stderr(&output));
    }
}
