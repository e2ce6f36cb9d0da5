//! From pair file or samples to tables and FMU.

use super::*;

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
fn plane_strain_has_no_root_stress_however_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let unit = folder.path().join("unit.fmu");
    let (pair, path) = (paper(), unit.to_str().unwrap());
    let output = gearmesh(&[
        "build",
        &pair,
        "-o",
        path,
        "--plane-strain",
        "--set",
        "rootStress=true",
    ]);
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(
        error.contains("leave out `rootStress` or --plane-strain"),
        "{error}"
    );
    assert!(!unit.exists());
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
    let made = succeed(&[&["build", &pair, "-o", &built], &SMALL[..]].concat());
    for said in [
        "teeth: each thinned by 0.1 um",
        "note: at a centre distance offset of -100 um",
    ] {
        assert!(stdout(&made).contains(said), "{}", stdout(&made));
    }

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
    let [packed, built] = [&packed, &built].map(|fmu| succeed(&["inspect", fmu]));
    assert!(stdout(&built).contains("time of one evaluation"));
    assert!(stdout(&built).contains("table: error at"));
    let [a, b] = [&packed, &built].map(guid);
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
    assert!(!output.status.success());
    assert!(
        stderr(&output).contains("--max-error"),
        "{}",
        stderr(&output)
    );
    assert!(!Path::new("unused.json").exists());
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
fn tooth_pairs_one_by_one_are_what_their_unit_starts_with_and_refuse_teeth_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (pair, fmu) = (path("pair.json"), path("teeth.fmu"));
    let text = std::fs::read_to_string(paper()).unwrap();
    let with = |errors: &str| {
        let errors = format!("\"teeth\": 20, \"tooth_errors\": {errors},");
        let differ = text.replacen("\"teeth\": 20,", &errors, 1);
        assert_ne!(differ, text);
        std::fs::write(&pair, differ).unwrap();
    };
    let arguments = [&["build", &pair, "-o", &fmu, "--teeth"], &SMALL[..]].concat();

    with(r#"{ "teeth": [{ "tooth": 3, "compliance_factor": 1.5 }] }"#);
    let refused = gearmesh(&arguments);
    assert_eq!(refused.status.code(), Some(1));
    let message = stderr(&refused);
    assert!(message.contains("compliance_factor") && message.contains("tooth 3"));
    assert!(!Path::new(&fmu).exists());

    with(r#"{ "drive_flank": { "pitch_class": 6 }, "runout_um": 5.0 }"#);
    let built = succeed(&arguments);
    assert!(stdout(&built).contains("`stiffnessModel = teeth`, which takes the tooth errors"));
    let inspection = succeed(&["inspect", &fmu]);
    let shown = stdout(&inspection);
    assert!(
        shown.contains("teeth: error at 1000 random points"),
        "{shown}"
    );
    let mut starts = shown
        .lines()
        .filter(|line| line.contains("start: stiffnessModel"));
    assert!(starts.any(|line| line.ends_with(" teeth")), "{shown}");
    assert!(
        shown.contains("tooth pairs one by one") && shown.contains("um/kN"),
        "{shown}"
    );
}

#[test]
fn what_is_read_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let pair = folder.path().join("pair.json");
    std::fs::copy(paper(), &pair).unwrap();
    let before = std::fs::read(&pair).unwrap();
    let pair = pair.to_str().unwrap();
    // By another name, too.
    let link = folder.path().join("link.json");
    std::os::unix::fs::symlink(pair, &link).unwrap();
    for output in [pair, link.to_str().unwrap()] {
        for command in [
            &["pack", "--pair", pair][..],
            &["tables", pair],
            &["build", pair],
            &["report", pair],
            &["import", "none.csv", "--pair", pair],
        ] {
            let refused = gearmesh(&[command, &["-o", output]].concat());
            assert!(!refused.status.success(), "{command:?}");
            let message = stderr(&refused);
            assert!(message.contains("which is read"), "{command:?}: {message}");
            assert_eq!(std::fs::read(pair).unwrap(), before);
        }
    }
}

#[test]
fn a_page_is_not_written_over_the_tables_it_is_about() {
    let folder = tempfile::tempdir().unwrap();
    let tables = folder.path().join("tables.json");
    std::fs::write(&tables, "tables").unwrap();
    let path = tables.to_str().unwrap();
    let refused = gearmesh(&["report", &paper(), "--tables", path, "-o", path]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        stderr(&refused).contains("which is read"),
        "{}",
        stderr(&refused)
    );
    assert_eq!(std::fs::read(&tables).unwrap(), b"tables");
}

#[test]
fn a_pair_file_in_place_of_tables_is_told_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("unit.fmu");
    let refused = gearmesh(&["pack", "--tables", &paper(), "-o", fmu.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        stderr(&refused).contains("`--pair`"),
        "{}",
        stderr(&refused)
    );
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn packing_and_inspecting_say_what_the_unit_runs_on() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("unit.fmu");
    let fmu = fmu.to_str().unwrap();
    let packed = succeed(&["pack", "--pair", &paper(), "-o", fmu]);
    let inspected = succeed(&["inspect", fmu]);
    for said in [stdout(&packed), stdout(&inspected)] {
        let (_, version) = said.split_once("linux64 (glibc 2.").expect(said);
        let (minor, _) = version.split_once(" or later)").expect(said);
        let minor: u32 = minor.parse().expect(said);
        assert!((2..100).contains(&minor), "{said}");
    }
    let last = stdout(&packed).lines().last().unwrap();
    assert!(
        last.starts_with("linux64 only: for Windows as well"),
        "{last}"
    );
}

#[test]
fn the_error_of_contact_at_run_time_is_that_of_the_unit() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("unit.fmu");
    let (fmu, pair) = (fmu.to_str().unwrap(), paper());
    let force_rms = |stations: &str| -> f64 {
        let set = ["--set", "stiffnessModel=contact", "--stations", stations];
        let built = succeed(&[&["build", &pair, "-o", fmu], &SMALL[..], &set].concat());
        let inspected = succeed(&["inspect", fmu]);
        let of = |text: &str, head: &str| {
            let line = text.lines().find(|line| line.contains(head)).expect(text);
            let (_, error) = line.split_once("force ").expect(line);
            error.split_whitespace().next().unwrap().parse().unwrap()
        };
        let told: f64 = of(stdout(&built), "contact at run time:");
        assert_eq!(told, of(stdout(&inspected), "contact: error at"));
        told
    };
    let [one, usual] = ["1", "22"].map(force_rms);
    // One station knows neither crowning nor tilt.
    assert!(one > 3.0 && usual < 0.5, "{one} % and {usual} %");
}

#[test]
fn a_tilt_far_beyond_what_the_teeth_give_way_has_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (file, tables) = (path("pair.json"), path("tables.json"));
    let gear = |teeth: u32| serde_json::json!({ "teeth": teeth, "face_width_mm": 20.0 });
    let pair = serde_json::json!({
        "name": "wide tilt", "meshing": "external", "normal_module_mm": 2.0,
        "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 12.0,
        "gear1": gear(20), "gear2": gear(30),
        "operating": {
            "nominal_torque_nm": 20.0, "maximum_torque_nm": 40.0,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [-20.0, 20.0],
        },
    });
    std::fs::write(&file, pair.to_string()).unwrap();
    let output = gearmesh(&[&["tables", &file, "-o", &tables, "-q"], &QUICK[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let text = std::fs::read_to_string(tables).unwrap();
    let made: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        made["axes"]["misalignment_rad"].as_array().unwrap().len(),
        33
    );
    let rms = made["interpolation_error"]["force_rms"].as_f64().unwrap();
    assert!(rms < 5e-3, "{rms}");
}

#[test]
fn an_internal_pair_with_few_teeth_between_becomes_an_fmu() {
    let folder = tempfile::tempdir().unwrap();
    for (k, teeth) in [["30", "50"], ["40", "52"], ["60", "68"]]
        .iter()
        .enumerate()
    {
        let path = |name: &str| {
            folder
                .path()
                .join(format!("{k}{name}"))
                .to_str()
                .unwrap()
                .to_owned()
        };
        let (pair, fmu) = (path("pair.json"), path("unit.fmu"));
        let numbers = [
            "--module-mm",
            "2",
            "--face-width-mm",
            "20",
            "20",
            "--torque-nm",
            "50",
        ];
        let new = [
            "new",
            "--internal",
            "-o",
            &pair,
            "--teeth",
            teeth[0],
            teeth[1],
        ];
        let output = gearmesh(&[&new[..], &numbers].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let output = gearmesh(&["pack", "--pair", &pair, "-o", &fmu]);
        assert!(output.status.success(), "{teeth:?}: {}", stderr(&output));
    }
}

#[test]
fn a_new_pair_without_a_number_is_told_which_one() {
    let of = |more: [&str; 2]| {
        let mut numbers = vec!["--module-mm", "2", "--torque-nm", "50"];
        numbers.retain(|word| *word != "2" || more[0] != "--module-mm");
        numbers.retain(|word| *word != more[0]);
        let new = ["new", "--teeth", "20", "30", "--face-width-mm", "20", "20"];
        let refused = gearmesh(&[&new[..], &numbers, &more].concat());
        assert!(!refused.status.success());
        stderr(&refused).to_owned()
    };
    let error = of(["--module-mm", "nan"]);
    assert!(
        error.contains("'nan' for '--module-mm <MODULE_MM>': give a finite number"),
        "{error}"
    );
    let error = of(["--pressure-angle-deg", "0"]);
    assert!(error.contains("`normal_pressure_angle_deg` = 0"), "{error}");
}

#[test]
fn a_disk_that_fills_is_told_without_the_temporary_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pair.json");
    // No file may grow, as on a full disk; the signal that tells so is ignored.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_gearmesh"))
        .args([
            "new",
            "--teeth",
            "20",
            "30",
            "--module-mm",
            "2",
            "--face-width-mm",
            "20",
            "20",
        ])
        .args(["--torque-nm", "50", "-o"])
        .arg(&file)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(
        error.contains("pair.json") && !error.contains(".gearmesh-"),
        "{error}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
