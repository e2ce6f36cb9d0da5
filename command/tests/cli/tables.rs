//! From pair file or samples to tables and FMU.

use super::*;
use serde_json::json;

#[test]
fn a_range_that_cannot_be_covered_is_refused_on_the_coarse_model_with_its_corner() {
    let folder = Folder::new();
    let pair = folder.pair(|pair| {
        pair["operating"]["maximum_torque_nm"] = 15.5e3.into();
        pair["operating"]["misalignment_mrad"] = vec![-6.0, 6.0].into();
    });
    let [tables, cache] = folder.paths(["tables.json", "cache"]);
    refused!("tables {pair} -o {tables} --refinement fine --cache-dir {cache} -q"; "operating range", "torque = 15500 N m, misalignment = ");
    // The fine model was not begun: only the coarse one, which both gears share, is there.
    assert_eq!(folder.count("cache"), 1);
}

#[test]
fn building_is_tabulating_and_packing() {
    let folder = Folder::new();
    let [tables, packed, built] = folder.paths(["tables.json", "packed.fmu", "bü%20ilt.fmu"]);
    succeed!("tables {PAPER} -o {tables} {SMALL} {QUICK}");
    succeed!("pack --tables {tables} -o {packed}");
    let made = succeed!("build {PAPER} -o {built} {SMALL} {QUICK}");
    let [tabulated, packed, built] = [tables, packed, built].map(|file| succeed!("inspect {file}"));
    contains!(
        made,
        "thinned by 0.1 um",
        "note: at a centre distance offset"
    );
    contains!(tabulated, "1 misalignment x", "rms");
    contains!(built, "table: error at");
    // The GUID is that of the contents.
    assert_eq!(line(&packed, "GUID"), line(&built, "GUID"));
    // Nothing but the three files.
    assert_eq!(folder.count(""), 3);
}

/// Samples of another program: 0.05 um per N m on top of 1 um, `bent` instead at one of them.
fn samples(bent: f64) -> String {
    let mut text = String::from(
        "torque_nm,mesh_position,center_distance_offset_um,misalignment_mrad,ste_loa_um,contact_z_mm\n",
    );
    for torque in [0.0, 50.0, 100.0, 150.0, 200.0] {
        for position in 0..8 {
            let ste = match (torque, position) {
                (100.0, 3) => bent,
                _ => 1.0 + 0.05 * torque,
            };
            text += &format!("{torque},{},0,0,{ste},12.5\n", f64::from(position) / 8.0);
        }
    }
    text
}

#[test]
fn samples_of_another_program_become_an_fmu_and_one_that_yields_under_more_torque_is_refused() {
    let folder = Folder::new();
    let [tables, fmu] = folder.paths(["tables.json", "out.fmu"]);
    let csv = folder.write("samples.csv", samples(2.0));
    let import = format!("import {csv} --pair {PAPER} -o {tables}");
    refused(&import, &["samples.csv", "0.375"]);
    assert!(!folder.exists("tables.json"));

    folder.write("samples.csv", samples(6.0));
    succeed(import);
    succeed!("pack --tables {tables} -o {fmu}");
    assert!(succeed!("inspect {fmu}").contains("samples.csv"));
}

#[test]
fn tooth_pairs_one_by_one_are_what_their_unit_starts_with_and_refuse_teeth_of_their_own() {
    let folder = Folder::new();
    let fmu = folder.path("teeth.fmu");
    let with = |errors: Value| {
        let pair = folder.pair(|pair| pair["gear1"]["tooth_errors"] = errors);
        format!("build {pair} -o {fmu} --teeth {SMALL} {QUICK}")
    };
    let weak = with(json!({ "teeth": [{ "tooth": 3, "compliance_factor": 1.5 }] }));
    refused(weak, &["compliance_factor", "tooth 3"]);
    assert!(!folder.exists("teeth.fmu"));

    let errors = json!({ "drive_flank": { "pitch_class": 6 }, "runout_um": 5.0 });
    let built = succeed(with(errors));
    assert!(built.contains("`stiffnessModel = teeth`, which takes the tooth errors"));
    let shown = succeed!("inspect {fmu}");
    contains!(shown, "teeth: error at 1000 random points");
    contains!(shown, "tooth pairs one by one", "um/kN");
    let start = line(&shown, "start: stiffnessModel");
    assert!(start.ends_with(" teeth"), "{start}");
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn packing_and_inspecting_say_what_the_unit_runs_on() {
    let folder = Folder::new();
    let fmu = folder.path("unit.fmu");
    let packed = succeed!("pack --pair {PAPER} -o {fmu}");
    for shown in [&packed, &succeed!("inspect {fmu}")] {
        let (_, version) = shown.split_once("linux64 (glibc 2.").expect(shown);
        let (minor, _) = version.split_once(" or later)").expect(shown);
        assert!((2..100).contains(&minor.parse::<u32>().unwrap()), "{shown}");
    }
    contains!(packed, "\nlinux64 only: for Windows as well");
}

#[test]
fn the_error_of_contact_at_run_time_is_that_of_the_unit() {
    let folder = Folder::new();
    let fmu = folder.path("unit.fmu");
    let force_rms = |stations: usize| -> f64 {
        let options = format!("--set stiffnessModel=contact --stations {stations}");
        let built = succeed!("build {PAPER} -o {fmu} {SMALL} {QUICK} {options}");
        let inspected = succeed!("inspect {fmu}");
        let error = |text: &str, head: &str| -> f64 {
            let (_, error) = line(text, head).split_once("force ").unwrap();
            error.split_whitespace().next().unwrap().parse().unwrap()
        };
        let built = error(&built, "contact at run time:");
        let inspected = error(&inspected, "contact: error at");
        assert_eq!(built, inspected);
        built
    };
    let [one, usual] = [1, 22].map(force_rms);
    // One station knows neither crowning nor tilt.
    assert!(one > 3.0 && usual < 0.5, "{one} % and {usual} %");
}

#[test]
fn a_tilt_far_beyond_the_deflection_of_the_teeth_has_tables() {
    let folder = Folder::new();
    let gear = |teeth: u32| json!({ "teeth": teeth, "face_width_mm": 20.0 });
    let pair = json!({
        "name": "wide tilt", "meshing": "external", "normal_module_mm": 2.0,
        "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 12.0,
        "gear1": gear(20), "gear2": gear(30),
        "operating": {
            "nominal_torque_nm": 20.0, "maximum_torque_nm": 40.0,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [-20.0, 20.0],
        },
    });
    let pair = folder.write("pair.json", pair.to_string());
    let tables = folder.path("tables.json");
    succeed!("tables {pair} -o {tables} -q {QUICK}");
    let made = super::json(folder.read("tables.json"));
    // Half as many again as usual, and four beyond the limits.
    assert_eq!(numbers(&made["axes"]["misalignment_rad"]).len(), 25 + 4);
    let rms = number(&made["interpolation_error"]["force_rms"]);
    assert!(rms < 5e-3, "{rms}");
}

#[test]
fn tables_have_more_centre_distances_where_little_deflection_asks_for_closer_ones() {
    let folder = Folder::new();
    let [pair, tables] = folder.paths(["pair.json", "tables.json"]);
    let small = "--module-mm 0.2 --face-width-mm 2 2 --torque-nm 0.005";
    for (teeth, count) in [("17 17", 9), ("30 30", 5)] {
        succeed!("new --teeth {teeth} {small} --name small -o {pair}");
        let shown = succeed!("tables {pair} --no-misalignment -o {tables} {QUICK}");
        contains!(shown, &format!("x {count} centre distances x"));
        let words = "centre distances: 9, as the spline through fewer of them falls";
        assert_eq!(shown.contains(words), count == 9, "{shown}");
        std::fs::remove_file(&pair).unwrap();
    }
}
