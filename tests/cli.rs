//! The command line as a user meets it: exit status, standard output and standard error.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn gearmesh(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args(arguments)
        .output()
        .expect("the command starts")
}

fn pair_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("resources/pairs")
        .join(name)
}

/// Coarse finite elements, computed once for all tests.
const QUICK: [&str; 4] = [
    "--refinement",
    "coarse",
    "--cache-dir",
    concat!(env!("CARGO_TARGET_TMPDIR"), "/elastic-models"),
];

fn paper() -> String {
    pair_file("palermo2013.json").display().to_string()
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

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

fn solve_json(arguments: &[&str]) -> serde_json::Value {
    let pair = paper();
    let output = gearmesh(&[&["solve", &pair, "--json"], &QUICK[..], arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_str(stdout(&output)).expect("JSON")
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let array = value.as_array().expect("an array");
    array
        .iter()
        .map(|v| v.as_f64().expect("a number"))
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_solve_reports_every_agreed_key_for_every_position() {
    let json = solve_json(&[
        "--torque-nm",
        "100",
        "--positions",
        "12",
        "--speed-rpm",
        "500,1500",
    ]);
    let positions = numbers(&json["mesh_position"]);
    assert_eq!(positions.len(), 12);
    assert!((positions[3] - 0.25).abs() < 1e-15);
    for key in [
        "ste_loa_um",
        "contact_z_mm",
        "maximum_pressure_mpa",
        "edge_line_load_n_per_mm",
    ] {
        assert_eq!(numbers(&json[key]).len(), 12, "{key}");
    }
    for share in json["load_share"].as_array().unwrap() {
        assert!((numbers(share).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let ste = numbers(&json["ste_loa_um"]);
    let number = |key: &str| json[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    assert!((number("mean_ste_loa_um") - mean(&ste)).abs() < 1e-9);
    let span =
        ste.iter().copied().fold(f64::MIN, f64::max) - ste.iter().copied().fold(f64::MAX, f64::min);
    assert!((number("peak_to_peak_ste_loa_um") - span).abs() < 1e-9);
    assert!(json["harmonics_loa_um"].as_array().unwrap().len() == 10);
    assert_eq!(json["torque_nm"], 100.0);
    assert!(number("face_load_factor") > 1.0 && number("face_load_factor") < 2.0);
    assert!((number("transverse_contact_ratio") - 1.540).abs() < 1e-3);
    assert!((number("overlap_ratio") - 0.448).abs() < 1e-3);
    assert!(number("solve_seconds") > 0.0);
    // The constant coefficient that the pair file has by default; arms of tip edges differ from the base radius.
    for coefficient in numbers(&json["friction_coefficient"]) {
        assert!((coefficient / 0.05 - 1.0).abs() < 1e-4);
    }
    let lost = 0.05 * number("loss_factor");
    for (speed, (loss, efficiency)) in [500.0, 1500.0].into_iter().zip(
        numbers(&json["loss_w"])
            .into_iter()
            .zip(numbers(&json["efficiency"])),
    ) {
        let transmitted = 100.0 * speed * std::f64::consts::TAU / 60.0;
        assert!((loss / (lost * transmitted) - 1.0).abs() < 1e-9);
        assert!((1.0 - efficiency - lost).abs() < 1e-12);
    }
    assert!((number("loss_factor_ohlendorf") / number("loss_factor") - 1.0).abs() < 0.2);
}

/// Rows of a CSV file by column name.
fn rows(path: &Path) -> Vec<std::collections::HashMap<String, f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let columns = reader.headers().unwrap().clone();
    let row = |row: csv::StringRecord| {
        let number = |(name, value): (&str, &str)| Some((name.to_owned(), value.parse().ok()?));
        columns.iter().zip(&row).filter_map(number).collect()
    };
    reader.records().map(|r| row(r.unwrap())).collect()
}

#[test]
fn root_stress_is_told_where_asked_for_and_agrees_in_json_and_csv() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    let to = ["--positions", "8", "--output", out.to_str().unwrap()];
    let plain = solve_json(&to);
    assert!(plain.get("root_stress_mpa").is_none());
    assert!(!out.join("root-stress.csv").exists());

    let json = solve_json(&[&to[..], &["--root-stress"]].concat());
    assert_eq!(plain["ste_loa_um"], json["ste_loa_um"]);
    let all = rows(&out.join("root-stress.csv"));
    let field = rows(&out.join("root-stress-field.csv"));
    for gear in [1, 2] {
        let own = |all: &[std::collections::HashMap<String, f64>]| -> Vec<_> {
            let of_gear = all.iter().filter(|row| row["gear"] == f64::from(gear));
            of_gear.cloned().collect()
        };
        let i = gear as usize - 1;
        let largest = &json["largest_root_stress"][i];
        let top = largest["stress_mpa"].as_f64().unwrap();
        let over = json["root_stress_mpa"][i].as_array().unwrap().iter();
        let over: Vec<f64> = over.map(|s| s.as_f64().unwrap()).collect();
        assert_eq!(over.len(), 8);
        assert_eq!(over.iter().copied().fold(0.0, f64::max), top);
        let stresses = own(&all).into_iter().map(|row| row["root_stress_mpa"]);
        assert_eq!(stresses.fold(0.0, f64::max), top);
        let points = own(&field).into_iter().map(|row| row["root_stress_mpa"]);
        let of_field = points.fold(0.0, f64::max);
        assert!(of_field <= top && of_field > 0.97 * top, "{of_field} {top}");
        // The nominal stress knows nothing of uneven load along the face.
        let nominal = json["iso_6336_3"][i]["sigma_f0_mpa"].as_f64().unwrap();
        assert!(
            top > 0.7 * nominal && top < 2.0 * nominal,
            "{top} {nominal}"
        );
    }
}

#[test]
fn a_matrix_of_loads_is_solved_on_one_model_and_written_as_csv_files_that_agree() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    let loads = ["--torque-nm", "50,100", "--misalignment-mrad", "-0.5,0,0.5"];
    let to = ["--positions", "12", "--output", out.to_str().unwrap()];
    let json = solve_json(&[&loads[..], &to].concat());
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 6);

    let summary = rows(&out.join("summary.csv"));
    assert_eq!(summary.len(), 6);
    let cycle = rows(&out.join("mesh-cycle.csv"));
    let strips = rows(&out.join("load-distribution.csv"));
    let face = rows(&out.join("face-load.csv"));
    for (case, row) in cases.iter().zip(&summary) {
        let key = |row: &std::collections::HashMap<String, f64>| {
            (row["torque_nm"], row["misalignment_mrad"])
        };
        assert_eq!(case["torque_nm"].as_f64().unwrap(), row["torque_nm"]);
        assert_eq!(
            case["mean_ste_loa_um"].as_f64().unwrap(),
            row["mean_ste_loa_um"]
        );
        let of_load =
            |all: &[_]| -> Vec<_> { all.iter().filter(|r| key(r) == key(row)).cloned().collect() };
        // Every position carries the torque: its strips sum to the force on the line of action.
        let at = |tau: f64| {
            let here = |r: &&std::collections::HashMap<String, f64>| r["mesh_position"] == tau;
            let strips = of_load(&strips);
            let here: Vec<_> = strips.iter().filter(here).cloned().collect();
            here.iter().map(|r| r["force_n"]).sum::<f64>()
        };
        let (first, other) = (at(0.0), at(0.5));
        assert!(
            first > 0.0 && (first / other - 1.0).abs() < 0.02,
            "{first} {other}"
        );
        // So does the load along the face.
        let face = of_load(&face);
        let mean = face.iter().map(|r| r["face_load_n_per_mm"]).sum::<f64>() / face.len() as f64;
        let largest = face
            .iter()
            .map(|r| r["face_load_n_per_mm"])
            .fold(0.0, f64::max);
        assert!((largest / mean - row["face_load_factor"]).abs() < 1e-9);
        // No strip bears load and is open.
        for strip in of_load(&strips) {
            assert!(
                strip["force_n"] == 0.0 || strip["gap_um"] == 0.0,
                "{strip:?}"
            );
        }
        assert_eq!(of_load(&cycle).len(), 12);
    }
    // Misalignment gathers the load, and the middle one of the three spreads it best.
    let factor = |i: usize| summary[i]["face_load_factor"];
    assert!(factor(3) > factor(4) && factor(5) > factor(4));

    // Stiffness: the slope of the mean STE between both torques lies between those at its ends.
    let stiffness = rows(&out.join("stiffness.csv"));
    assert_eq!(stiffness.len(), 6 * 12);
    let ste = |i: usize| summary[i]["mean_ste_loa_um"];
    let base_radius = 38.456e-3;
    let secant = 50.0 / base_radius / ((ste(4) - ste(1)) * 1e-6);
    let tangent = |i: usize| summary[i]["mean_mesh_stiffness_loa_n_per_m"];
    assert!(
        tangent(1) < 1.05 * secant && 0.95 * secant < tangent(4),
        "{secant}"
    );
    let row = &stiffness[0];
    assert!(row["stiffness_normal_n_per_m"] > row["stiffness_loa_n_per_m"]);
}

#[test]
fn a_bow_of_the_shafts_acts_as_crowning_and_a_slope_as_misalignment() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shafts.csv");
    // 0.4 mrad about mid-face, which is at 12.5 mm.
    std::fs::write(&file, "# bearings\nz_mm, closing_um\n0, -5\n25, 5\n").unwrap();
    let mean = |more: &[&str]| {
        let json = solve_json(&[&["--positions", "4"], more].concat());
        numbers(&json["ste_loa_um"])
    };
    let (slope, tilted) = (
        mean(&["--deflection", file.to_str().unwrap()]),
        mean(&["--misalignment-mrad", "0.4"]),
    );
    for (a, b) in slope.iter().zip(&tilted) {
        assert!((a - b).abs() < 1e-3 * b, "{a} {b}");
    }
    let (straight, bent) = (mean(&[]), mean(&["--bow-um", "6"]));
    // Less of the face bears, so the teeth give way more.
    for (a, b) in bent.iter().zip(&straight) {
        assert!(*a > b + 0.2, "{a} {b}");
    }
    std::fs::write(&file, "z_mm,closing_um\n0,1\n0,2\n").unwrap();
    let output = gearmesh(&["solve", &paper(), "--deflection", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("shafts.csv") && stderr(&output).contains("z of the"));
}

#[test]
fn a_study_goes_on_where_it_was_and_depends_on_nothing_but_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let study = |out: &str, samples: &str, more: &[&str]| {
        let pair = paper();
        let asked = [
            "study",
            &pair,
            "--positions",
            "6",
            "--samples",
            samples,
            "-o",
            out,
            "--vary",
            "gear1.lead_slope_um=+-6",
            "--vary",
            "misalignment_mrad=-0.2..0.2",
        ];
        gearmesh(&[&asked, &QUICK[..], more].concat())
    };
    let (whole, parts) = (path("whole"), path("parts"));
    let output = study(&whole, "10", &[]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("10 samples, 0 refused"),
        "{}",
        stdout(&output)
    );
    assert!(study(&parts, "3", &[]).status.success());
    assert!(study(&parts, "10", &[]).status.success());
    let table = |folder: &str| std::fs::read(Path::new(folder).join("samples.csv")).unwrap();
    assert_eq!(table(&whole), table(&parts));

    // The pair as drawn is sample 0; slope and misalignment gather the load at an end of the face.
    let samples = rows(&Path::new(&whole).join("samples.csv"));
    assert_eq!(samples.len(), 11);
    assert_eq!(samples[0]["gear1.lead_slope_um"], 0.0);
    let factors = samples.iter().map(|s| s["face_load_factor"]);
    assert!(factors.fold(0.0, f64::max) > 1.03 * samples[0]["face_load_factor"]);
    let summary = std::fs::read_to_string(Path::new(&whole).join("study.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let of = |name: &str| summary["statistics"][0][name].as_f64().unwrap();
    assert!(of("least") <= of("median") && of("median") <= of("percentile_95"));
    let page = std::fs::read_to_string(Path::new(&whole).join("study.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 3);

    let output = study(&whole, "10", &["--seed", "2"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("another study"),
        "{}",
        stderr(&output)
    );
    assert!(
        study(&whole, "10", &["--seed", "2", "--restart"])
            .status
            .success()
    );
    assert_ne!(table(&whole), table(&parts));
}

#[test]
fn a_study_refuses_what_it_cannot_vary_before_it_computes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("study");
    for (vary, said) in [
        ("gear1.lead_slop_um=0..1", "lead_slop_um"),
        ("gear1.bore_diameter_mm=28..30", "teeth"),
        ("gear1.lead_crowning_um=-5..5", "lead_crowning_um"),
        ("misalignment_mrad=0..90", "misalignment-mrad"),
    ] {
        let output = gearmesh(&[
            "study",
            &paper(),
            "--vary",
            vary,
            "-o",
            out.to_str().unwrap(),
        ]);
        assert_eq!(output.status.code(), Some(1), "{vary}");
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
        assert!(!out.exists());
    }
    let output = gearmesh(&["study", &paper(), "-o", out.to_str().unwrap()]);
    assert!(
        stderr(&output).contains("--iso-1328-class"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_range_that_cannot_be_covered_is_refused_on_the_coarse_model_with_its_corner() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (file, tables, cache) = (path("pair.json"), path("tables.json"), path("cache"));
    let text = std::fs::read_to_string(paper()).unwrap();
    let mut pair: serde_json::Value = serde_json::from_str(&text).unwrap();
    pair["operating"]["maximum_torque_nm"] = 15.5e3.into();
    std::fs::write(&file, pair.to_string()).unwrap();
    let output = gearmesh(&[
        "tables",
        &file,
        "-o",
        &tables,
        "--refinement",
        "fine",
        "--cache-dir",
        &cache,
        "-q",
    ]);
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(error.contains("operating range"), "{error}");
    assert!(
        error.contains("torque = 15500 N m, misalignment = "),
        "{error}"
    );
    // The fine model was not begun: only the coarse one, which both gears share, is there.
    assert_eq!(std::fs::read_dir(&cache).unwrap().count(), 1);
}

#[test]
fn the_error_is_estimated_from_another_refinement() {
    let output = succeed(&[&["solve", &paper(), "--estimate-error"], &QUICK[..]].concat());
    let text = stdout(&output);
    let estimate = text.split("estimated error").nth(1).expect(text);
    assert!(estimate.contains("finite elements, normal"), "{estimate}");
    let percent = |name: &str| -> f64 {
        let line = estimate.lines().find(|line| line.contains(name));
        let words = line.expect(name).split_whitespace();
        words.rev().nth(1).unwrap().parse().unwrap()
    };
    // docs/finite-elements.md: coarse is 0.3 % and some percent of a small swing away.
    let (mean, swing) = (percent("mean STE"), percent("peak-to-peak STE"));
    assert!(mean != 0.0 && mean.abs() < 1.0, "{mean}");
    assert!(swing != 0.0 && swing.abs() < 10.0, "{swing}");
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
fn harmonics_that_the_positions_cannot_tell_apart_are_null() {
    let json = solve_json(&["--positions", "4"]);
    let harmonics = json["harmonics_loa_um"].as_array().unwrap();
    assert!(harmonics[0].is_f64());
    assert!(harmonics[1..].iter().all(serde_json::Value::is_null));
}

#[test]
fn the_sign_of_the_misalignment_moves_the_contact_to_that_side() {
    let at = |m: &str| {
        mean(&numbers(
            &solve_json(&["--positions", "8", "--misalignment-mrad", m])["contact_z_mm"],
        ))
    };
    // Mid-face is at 12.5 mm; M > 0 closes the side of larger z.
    assert!(at("-1") < 12.0);
    assert!(at("1") > 13.0);
}

#[test]
fn the_coast_flank_of_a_symmetric_pair_is_as_stiff_as_the_drive_flank() {
    let ste = |flank: &str| {
        solve_json(&["--positions", "8", "--flank", flank])["mean_ste_loa_um"]
            .as_f64()
            .unwrap()
    };
    assert!((ste("drive") - ste("coast")).abs() < 1e-6);
}

#[test]
fn the_table_for_people_shows_the_numbers_of_the_json() {
    let pair = paper();
    let output = gearmesh(&[&["solve", &pair, "--positions", "8"], &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let json = solve_json(&["--positions", "8"]);
    let mean = json["mean_ste_loa_um"].as_f64().unwrap();
    assert!(
        stdout(&output).contains(&format!("{mean:.4} um")),
        "{}",
        stdout(&output)
    );
}

#[test]
fn a_torque_that_cannot_be_is_refused_by_name() {
    for torque in ["-5", "nan"] {
        let flag = format!("--torque-nm={torque}");
        let output = gearmesh(&[&["solve", &paper(), &flag], &QUICK[..]].concat());
        assert_eq!(output.status.code(), Some(1), "{torque}");
        assert!(stderr(&output).contains("torque"), "{}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), 1);
    }
}

#[test]
fn the_report_is_one_file_that_asks_for_nothing_from_a_network() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    let figures = folder.path().join("figures");
    let (page, drawn) = (file.to_str().unwrap(), figures.to_str().unwrap());
    let pair = paper();
    let asked = [
        "report",
        &pair,
        "--positions",
        "8",
        "-o",
        page,
        "--figures",
        drawn,
    ];
    let output = gearmesh(&[&asked, &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let html = std::fs::read_to_string(&file).unwrap();
    assert!(html.matches("<svg").count() >= 8);
    // Light and dark, in the page and in every file of a picture.
    assert!(html.contains("prefers-color-scheme:dark"));
    for reference in ["src=", "href=", "url(", "@import"] {
        assert!(!html.contains(reference), "{reference}");
    }
    // The name space of SVG is a name, not an address to be loaded.
    let addresses = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http"), "an address in the page");
    let files = |folder| std::fs::read_dir(folder).unwrap().count();
    assert_eq!(
        files(folder.path()),
        2,
        "the page and the folder of figures"
    );
    assert_eq!(files(&figures), html.matches("<svg").count());
    for figure in std::fs::read_dir(&figures).unwrap() {
        let svg = std::fs::read_to_string(figure.unwrap().path()).unwrap();
        assert!(svg.contains("prefers-color-scheme:dark") && svg.contains("fill:var(--paper)"));
    }
}

#[test]
fn the_report_shows_the_torques_asked_for_and_the_pressure_that_solve_gives() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    let pair = paper();
    let asked = ["report", &pair, "--torques-nm", "55,90", "-o"];
    let page = file.to_str().unwrap();
    let output = gearmesh(&[&asked[..], &[page], &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let html = std::fs::read_to_string(&file).unwrap();
    assert!(html.contains("<td>55.0</td>") && html.contains("<td>90.0</td>"));
    assert!(!html.contains("<td>100.0</td>"));
    let json = solve_json(&["--torque-nm", "90"]);
    let pressures = numbers(&json["maximum_pressure_mpa"]);
    let largest = pressures.into_iter().fold(0.0, f64::max);
    assert!(
        html.contains(&format!("<td>{largest:.0}</td>")),
        "{largest}"
    );
}

#[test]
fn a_report_that_cannot_be_written_is_a_failure_that_names_the_file() {
    let page = "/no/such/folder/report.html";
    let pair = paper();
    let output = gearmesh(
        &[
            &["report", &pair, "--positions", "2", "-o", page],
            &QUICK[..],
        ]
        .concat(),
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("/no/such/folder/report.html"));
}

/// Options that make tables in a moment: load and mesh position only.
const SMALL: [&str; 6] = [
    QUICK[0],
    QUICK[1],
    QUICK[2],
    QUICK[3],
    "--no-center-distance",
    "--no-misalignment",
];

fn succeed(arguments: &[&str]) -> Output {
    let output = gearmesh(arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        stderr(&output)
    );
    output
}

fn guid(inspection: &Output) -> String {
    let line = stdout(inspection)
        .lines()
        .find(|line| line.contains("GUID"));
    line.expect("a line with the GUID")
        .split_whitespace()
        .last()
        .unwrap()
        .to_owned()
}

#[test]
fn building_is_tabulating_and_packing() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (tables, packed, built) = (path("tables.json"), path("packed.fmu"), path("bü ilt.fmu"));
    let pair = paper();
    succeed(&[&["tables", &pair, "-o", &tables], &SMALL[..]].concat());
    succeed(&["pack", "--tables", &tables, "-o", &packed]);
    succeed(&[&["build", &pair, "-o", &built], &SMALL[..]].concat());

    let inspection = succeed(&["inspect", &tables]);
    assert!(
        stdout(&inspection).contains("1 misalignment x"),
        "{}",
        stdout(&inspection)
    );
    assert!(
        stdout(&inspection).contains("rms"),
        "{}",
        stdout(&inspection)
    );
    // The GUID is that of the contents.
    let [a, b] = [&packed, &built].map(|fmu| guid(&succeed(&["inspect", fmu])));
    assert_eq!(a, b);
    // Nothing but the three files.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn tables_that_were_altered_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let tables = folder.path().join("tables.json");
    let fmu = folder.path().join("out.fmu");
    let (tables, fmu) = (tables.to_str().unwrap(), fmu.to_str().unwrap());
    succeed(&[&["tables", &paper(), "-o", tables], &SMALL[..]].concat());
    let text = std::fs::read_to_string(tables).unwrap();
    let altered = text.replacen(
        "\"maximum_torque_nm\": 200",
        "\"maximum_torque_nm\": 201",
        1,
    );
    let altered = altered.replacen("\"maximum_torque_nm\":200", "\"maximum_torque_nm\":201", 1);
    assert_ne!(text, altered);
    std::fs::write(tables, altered).unwrap();

    let output = gearmesh(&["pack", "--tables", tables, "-o", fmu]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("checksum"), "{}", stderr(&output));
    assert!(!Path::new(fmu).exists());
}

#[test]
fn an_error_bound_that_cannot_be_is_refused_by_name() {
    let output = gearmesh(&["tables", &paper(), "-o", "unused.json", "--max-error", "0"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("--max-error"),
        "{}",
        stderr(&output)
    );
    assert!(!Path::new("unused.json").exists());
}

#[test]
fn a_finite_element_model_is_kept_and_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let solve = || {
        let output = succeed(&[
            "solve",
            &paper(),
            "--refinement",
            "coarse",
            "--positions",
            "4",
            "--json",
            "--cache-dir",
            cache.to_str().unwrap(),
        ]);
        let json: serde_json::Value = serde_json::from_str(stdout(&output)).unwrap();
        assert_eq!(stderr(&output), "");
        numbers(&json["ste_loa_um"])
    };
    let first = solve();
    // Both gears are equal but for hand: one model.
    let kept: Vec<_> = std::fs::read_dir(&cache)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert_eq!(kept.len(), 1);
    // A file that is written anew is another one.
    let number = || std::fs::metadata(&kept[0]).unwrap().ino();
    let written = number();
    assert_eq!(first, solve());
    assert_eq!(number(), written);
    // Three-dimensional teeth on a held bore give way by some micrometres, not by none.
    assert!(mean(&first) > 5.0 && mean(&first) < 20.0);
}

/// `gearmesh tables` of the paper's pair after `change`, the smallest there are, in `folder`; returns what it
/// says about its elastic models.
fn elastic_model_of_tables(folder: &Path, change: impl Fn(&mut serde_json::Value)) -> String {
    let text = std::fs::read_to_string(paper()).unwrap();
    let mut pair: serde_json::Value = serde_json::from_str(&text).unwrap();
    pair["compliance"] = serde_json::json!({ "refinement": "coarse" });
    change(&mut pair);
    let file = folder.join("pair.json");
    std::fs::write(&file, pair.to_string()).unwrap();
    let tables = folder.join("tables.json");
    let output = succeed(&[
        "tables",
        file.to_str().unwrap(),
        "-o",
        tables.to_str().unwrap(),
        "--no-center-distance",
        "--no-misalignment",
        "--stations",
        "8",
        "--cache-dir",
        folder.join("cache").to_str().unwrap(),
    ]);
    let line = stdout(&output)
        .lines()
        .find(|line| line.contains("elastic model"));
    format!("{}{}", line.unwrap(), stderr(&output))
}

#[test]
fn an_elastic_model_serves_every_change_that_does_not_touch_it() {
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("cache");
    let count = || std::fs::read_dir(&kept).unwrap().count();
    let of = |change: fn(&mut serde_json::Value)| elastic_model_of_tables(folder.path(), change);
    let place = format!("kept in {}", kept.display());

    assert!(of(|_| ()).contains(&place));
    assert_eq!(count(), 1);
    let unchanged: [fn(&mut serde_json::Value); 4] = [
        |pair| pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into(),
        |pair| pair["gear2"]["lead_crowning_um"] = 0.0.into(),
        |pair| pair["operating"]["maximum_torque_nm"] = 170.0.into(),
        |pair| pair["operating"]["misalignment_mrad"] = serde_json::json!([-1.0, 2.0]),
    ];
    for change in unchanged {
        let said = of(change);
        assert!(
            said.contains("read from") && !said.contains("note"),
            "{said}"
        );
        assert_eq!(count(), 1);
    }
    let changed: [fn(&mut serde_json::Value); 2] = [
        |pair| {
            pair["gear1"]["bore_diameter_mm"] = 31.0.into();
            pair["gear2"]["bore_diameter_mm"] = 31.0.into();
        },
        |pair| pair["compliance"]["refinement"] = "normal".into(),
    ];
    for (change, files) in changed.into_iter().zip(2..) {
        assert!(of(change).contains("computed"));
        assert_eq!(count(), files);
    }

    for entry in std::fs::read_dir(&kept).unwrap() {
        std::fs::write(entry.unwrap().path(), b"not a model").unwrap();
    }
    let said = of(|_| ());
    assert!(said.contains("computed"), "{said}");
    assert!(
        said.contains("note") && said.contains("the file is cut off"),
        "{said}"
    );
    assert!(of(|_| ()).contains("read from"));
    // Nothing but the files asked for lies beside the tables.
    assert!(!folder.path().join(".gearmesh-compliance").exists());
    let cache = |more: &[&str]| {
        let arguments = [&["cache", "--cache-dir", kept.to_str().unwrap()], more].concat();
        stdout(&succeed(&arguments)).to_owned()
    };
    let listed = cache(&[]);
    assert!(
        listed.contains("20 teeth, module 4 mm") && listed.contains("of 1000.0 MB"),
        "{listed}"
    );
    assert!(cache(&["--clear"]).contains("removed 3 models"));
    assert_eq!(count(), 0);
}

/// Samples of another program: 0.05 um per N m on top of 1 um, `bent` instead at one of them.
fn samples(bent: Option<f64>) -> String {
    let mut text = String::from(
        "torque_nm,mesh_position,center_distance_offset_um,misalignment_mrad,ste_loa_um,contact_z_mm\n",
    );
    for torque in [0.0, 50.0, 100.0, 150.0, 200.0] {
        for position in 0..8 {
            let ste = match bent {
                Some(ste) if torque == 100.0 && position == 3 => ste,
                _ => 1.0 + 0.05 * torque,
            };
            text += &format!("{torque},{},0,0,{ste},12.5\n", f64::from(position) / 8.0);
        }
    }
    text
}

#[test]
fn samples_of_another_program_become_an_fmu() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, tables, fmu) = (path("samples.csv"), path("tables.json"), path("out.fmu"));
    std::fs::write(&csv, samples(None)).unwrap();
    succeed(&["import", &csv, "--pair", &paper(), "-o", &tables]);
    succeed(&["pack", "--tables", &tables, "-o", &fmu]);
    let inspection = succeed(&["inspect", &fmu]);
    assert!(
        stdout(&inspection).contains("samples.csv"),
        "{}",
        stdout(&inspection)
    );
}

#[test]
fn a_sample_that_yields_under_more_torque_is_refused_by_file_and_point() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, tables) = (path("samples.csv"), path("tables.json"));
    std::fs::write(&csv, samples(Some(2.0))).unwrap();
    let output = gearmesh(&["import", &csv, "--pair", &paper(), "-o", &tables]);
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(
        error.contains("samples.csv") && error.contains("0.375"),
        "{error}"
    );
    assert!(!Path::new(&tables).exists());
}
