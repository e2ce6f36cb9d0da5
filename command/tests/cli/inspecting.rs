//! What `inspect` shows and refuses.

use super::*;

#[test]
fn inspecting_the_papers_pair_shows_its_contact_ratios_and_nominal_force() {
    let output = gearmesh(&["inspect", &paper()]);
    assert!(output.status.success(), "{}", stderr(&output));
    let value = |name: &str| -> f64 {
        let line = stdout(&output)
            .lines()
            .find(|line| line.trim_start().starts_with(name))
            .unwrap_or_else(|| panic!("no line {name} in\n{}", stdout(&output)));
        let text = line.trim_start()[name.len()..].trim();
        text.split_whitespace().next().unwrap().parse().unwrap()
    };
    // Table 1 of the paper; the force from the geometry, see docs/paper-comparison.md.
    assert!((value("transverse contact ratio") - 1.540).abs() < 1e-3);
    assert!((value("overlap ratio") - 0.448).abs() < 1e-3);
    assert!((value("total contact ratio") - 1.988).abs() < 1e-3);
    assert!((value("normal force at nominal torque") - 2660.4).abs() < 0.1);
}

#[test]
fn every_shipped_pair_file_can_be_inspected() {
    let folder = pair_file("");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let output = gearmesh(&["inspect", path.to_str().unwrap()]);
        assert!(
            output.status.success(),
            "{}: {}",
            path.display(),
            stderr(&output)
        );
        seen += 1;
    }
    assert!(seen >= 2);
}

#[test]
fn files_that_a_pair_names_are_sought_in_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(pair_file("palermo2013.json")).unwrap();
    let mut pair: serde_json::Value = serde_json::from_str(&text).unwrap();
    pair["gear1"]["topography_file"] = "flank.csv".into();
    let file = folder.path().join("pair.json");
    std::fs::write(&file, pair.to_string()).unwrap();
    let mut topography = "z_mm,diameter_mm,removal_um\n".to_owned();
    for z in [0.0, 12.5, 25.0] {
        for diameter in [77.5, 82.0, 90.315] {
            topography += &format!("{z},{diameter},2.0\n");
        }
    }
    std::fs::write(folder.path().join("flank.csv"), topography).unwrap();
    succeed(&["inspect", file.to_str().unwrap()]);
}

#[test]
fn an_unknown_field_is_refused_by_name_in_one_line_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.json");
    let text = std::fs::read_to_string(pair_file("palermo2013.json")).unwrap();
    std::fs::write(&file, text.replace("helix_angle_deg", "helix_deg")).unwrap();

    let output = gearmesh(&["inspect", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(stdout(&output), "");
    let error = stderr(&output);
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("`helix_deg`"), "{error}");
}

#[test]
fn an_error_is_one_line_on_standard_error_with_field_value_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.json");
    let text = std::fs::read_to_string(pair_file("palermo2013.json")).unwrap();
    let wrong = text.replace("\"normal_module_mm\": 4.0", "\"normal_module_mm\": -4.0");
    assert_ne!(text, wrong);
    std::fs::write(&file, wrong).unwrap();

    let output = gearmesh(&["inspect", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(stdout(&output), "");
    let error = stderr(&output);
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("normal_module_mm"), "{error}");
    assert!(error.contains("-4"), "{error}");
    // Field = value: problem; remedy.
    assert!(error.contains(';'), "{error}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let output = gearmesh(&["inspect", "no-such-pair.json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("no-such-pair.json"));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    use std::process::Stdio;
    let mut child = Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args(["inspect", &paper()])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn an_option_that_does_not_exist_is_an_error() {
    let output = gearmesh(&["solve", &paper(), "--compliance", "analytical"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stdout(&output), "");
    assert!(
        stderr(&output).contains("'--compliance'"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_topography_is_shown_with_its_least_and_largest_removal_and_that_at_the_tip() {
    let folder = tempfile::tempdir().unwrap();
    let [csv, pair] = ["flank.csv", "pair.json"].map(|name| folder.path().join(name));
    // Of the wrong sign; the active profile of gear 1 goes from 5.06 to 23.67 mm of roll.
    let mut rows = "roll_mm,z_mm,removal_um\n".to_owned();
    for roll in [5, 10, 15, 20, 24] {
        for z in [0.0, 12.5, 25.0] {
            rows += &format!("{roll},{z},{}\n", -roll);
        }
    }
    std::fs::write(&csv, rows).unwrap();
    let text = std::fs::read_to_string(pair_file("palermo2013-unmodified.json")).unwrap();
    let field = format!("\"teeth\": 20, \"topography_file\": {csv:?},");
    std::fs::write(&pair, text.replacen("\"teeth\": 20,", &field, 1)).unwrap();
    let output = gearmesh(&["inspect", pair.to_str().unwrap()]);
    let shown = "removal -23.67 to -5.06 um on the active flank, -23.67 um at the tip at mid-face";
    assert!(
        stdout(&output).contains(shown),
        "{}{}",
        stdout(&output),
        stderr(&output)
    );
}

#[test]
fn what_teeth_are_thinned_by_is_shown() {
    let output = gearmesh(&[
        "inspect",
        pair_file("planet-ring-27-84.json").to_str().unwrap(),
    ]);
    let shown = "each thinned by 40.0 um at the operating pitch circle";
    assert!(stdout(&output).contains(shown), "{}", stdout(&output));
}
