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
