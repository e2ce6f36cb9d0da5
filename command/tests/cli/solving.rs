//! One mesh cycle: keys, files, loads, signs.

use super::*;

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
    // The constant coefficient that the pair file has by default.
    for coefficient in numbers(&json["friction_coefficient"]) {
        assert!((coefficient - 0.05).abs() < 1e-15);
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

#[test]
fn coefficient_times_loss_factor_times_power_is_the_loss_with_every_law() {
    let folder = tempfile::tempdir().unwrap();
    let pair = folder.path().join("pair.json");
    let text = std::fs::read_to_string(paper()).unwrap();
    let oil = r#""dynamic_viscosity_mpa_s": 20, "roughness_ra_um": [0.4, 0.4]"#;
    for law in ["constant", "schlenk", "xu_kahraman"] {
        let friction = format!(r#"{{ "friction": {{ "law": "{law}", {oil} }},"#);
        std::fs::write(&pair, text.replacen('{', &friction, 1)).unwrap();
        let asked = [
            "solve",
            pair.to_str().unwrap(),
            "--positions",
            "8",
            "--json",
        ];
        let at = ["--torque-nm", "100", "--speed-rpm", "1000"];
        let output = succeed(&[&asked[..], &at, &QUICK[..]].concat());
        let json: serde_json::Value = serde_json::from_str(stdout(&output)).unwrap();
        let of = |key: &str| numbers(&json[key])[0];
        let transmitted = 100.0 * 1000.0 * std::f64::consts::TAU / 60.0;
        let factor = json["loss_factor"].as_f64().unwrap();
        let product = of("friction_coefficient") * factor * transmitted;
        assert!(
            (of("loss_w") / product - 1.0).abs() < 1e-9,
            "{law}: {product}"
        );
    }
}

#[test]
fn values_that_rest_on_few_loaded_segments_are_noted_where_they_are_printed() {
    let said = "the largest flank pressure";
    let tilted = [
        "--misalignment-mrad",
        "20",
        "--torque-nm",
        "20",
        "--positions",
        "4",
    ];
    let solve = |more: &[&str]| {
        let pair = paper();
        let asked = [&["solve", &pair], &tilted[..], &QUICK[..], more].concat();
        stdout(&succeed(&asked)).to_owned()
    };
    let text = solve(&[]);
    assert!(text.contains(said) && text.contains("--stations"), "{text}");
    let notes = |text: &str| -> Vec<String> {
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        serde_json::from_value(json["notes"].clone()).unwrap()
    };
    assert!(notes(&solve(&["--json"]))[0].contains(said));
    assert!(!solve(&["--stations", "240"]).contains(said));
}

#[test]
fn results_that_leave_tooth_errors_out_say_so_and_stay_those_of_equal_teeth() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (pair, page, study) = (path("pair.json"), path("page.html"), path("study"));
    let text = std::fs::read_to_string(paper()).unwrap();
    let errors = r#""teeth": 20, "tooth_errors": { "runout_um": 5.0 },"#;
    std::fs::write(&pair, text.replacen("\"teeth\": 20,", errors, 1)).unwrap();

    let said = "solve, report, study and tables take them as all alike";
    let solve = |more: &[&str]| {
        let asked = ["solve", &pair, "--positions", "4"];
        succeed(&[&asked[..], &QUICK[..], more].concat())
    };
    for loads in [&[][..], &["--torque-nm", "50,100"]] {
        let text = solve(loads);
        assert_eq!(stdout(&text).matches(said).count(), 1, "{}", stdout(&text));
    }
    let json: serde_json::Value = serde_json::from_str(stdout(&solve(&["--json"]))).unwrap();
    assert!(json["notes"][0].as_str().unwrap().contains(said));
    let alike = solve_json(&["--positions", "4"]);
    assert_eq!(alike["notes"], serde_json::json!([]));
    assert_eq!(json["ste_loa_um"], alike["ste_loa_um"]);

    let asked = ["report", &pair, "--positions", "4", "-o", &page];
    succeed(&[&asked[..], &QUICK[..]].concat());
    assert!(std::fs::read_to_string(&page).unwrap().contains(said));

    let study = |vary: &str| {
        let asked = [
            "study",
            &pair,
            "--positions",
            "4",
            "--samples",
            "2",
            "-o",
            &study,
        ];
        gearmesh(&[&asked[..], &["--vary", vary], &QUICK[..]].concat())
    };
    let output = study("torque_nm=90..110");
    assert!(stdout(&output).contains(said), "{}", stderr(&output));
    for file in ["study/study.json", "study/study.html"] {
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        assert!(text.contains(said), "{file}");
    }
    let refused = study("gear1.tooth_errors.runout_um=0..10");
    assert_eq!(refused.status.code(), Some(1));
    let message = stderr(&refused);
    assert!(
        message.contains("--vary gear1.tooth_errors.runout_um")
            && message.contains("all teeth as alike"),
        "{message}"
    );
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
fn the_error_is_estimated_from_another_refinement() {
    let pair = paper();
    let asked = ["solve", &pair, "--estimate-error", "--root-stress"];
    let output = succeed(&[&asked[..], &QUICK[..]].concat());
    let text = stdout(&output);
    let (solved, estimate) = text.split_once("estimated error").expect(text);
    assert!(
        solved.contains("time for the model of the fillets"),
        "{solved}"
    );
    assert!(
        estimate.contains("time for its model of the fillets"),
        "{estimate}"
    );
    assert!(estimate.contains("finite elements, normal"), "{estimate}");
    let percent = |name: &str| -> f64 {
        let line = estimate.lines().find(|line| line.contains(name));
        let words = line.expect(name).split_whitespace();
        words.rev().nth(1).unwrap().parse().unwrap()
    };
    // docs/validation.md: coarse is 0.3 % and some percent of a small swing away.
    let (mean, swing) = (percent("mean STE"), percent("p-p STE"));
    assert!(mean != 0.0 && mean.abs() < 1.0, "{mean}");
    assert!(swing != 0.0 && swing.abs() < 10.0, "{swing}");
    // docs/root-stress.md: coarse is within some percent.
    for gear in ["root stress 1", "root stress 2"] {
        let stress = percent(gear);
        assert!(stress != 0.0 && stress.abs() < 5.0, "{gear}: {stress}");
    }
}

#[test]
fn an_error_of_nothing_is_none() {
    let pair = pair_file("palermo2013-unmodified.json");
    let pair = pair.to_str().unwrap();
    let asked = ["solve", pair, "--estimate-error", "--torque-nm"];
    let more = ["--positions", "4"];
    let of = |torques| {
        let output = succeed(&[&asked[..], &[torques], &more, &QUICK].concat());
        let text = stdout(&output).split_once("estimated error").unwrap().1;
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        let pressure = text.lines().find(|line| line.contains("p_max"));
        pressure.expect(text).to_owned()
    };
    assert!(of("0").contains("none to tell"));
    // A load that is none does not hide the other.
    assert!(!of("0,100").contains("none to tell"));
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
        assert!(!output.status.success(), "{torque}");
        let named = format!("'{torque}' for '--torque-nm <TORQUE_NM>': give 0 or a value from");
        assert!(stderr(&output).contains(&named), "{}", stderr(&output));
    }
}

#[test]
fn a_centre_distance_at_which_tips_meet_roots_is_refused() {
    let refused = gearmesh(
        &[
            &["solve", &paper(), "--center-distance-offset-um", "-2500"],
            &QUICK[..],
        ]
        .concat(),
    );
    assert!(!refused.status.success());
    let message = stderr(&refused);
    assert!(message.contains("center_distance_offset"), "{message}");
    assert!(message.contains("root of its mate"), "{message}");
}

#[test]
fn a_negative_value_is_refused_by_its_option_not_taken_for_one() {
    let refused = gearmesh(&["solve", &paper(), "--torque-nm", "-10"]);
    assert!(!refused.status.success());
    let message = stderr(&refused);
    assert!(message.contains("'-10' for '--torque-nm"), "{message}");
    assert!(message.contains("--flank coast"), "{message}");
}

#[test]
fn no_model_is_kept_where_none_shall_be_whatever_the_environment_says() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args([
            "solve",
            &paper(),
            "--refinement",
            "coarse",
            "--positions",
            "1",
        ])
        .arg("--no-cache")
        .env("GEARMESH_CACHE_DIR", folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}
