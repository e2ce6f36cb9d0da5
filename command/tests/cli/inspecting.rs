//! What `inspect` shows and refuses.

use super::*;
use std::io::Write;
use std::process::Stdio;

#[test]
fn inspecting_the_papers_pair_shows_its_contact_ratios_and_nominal_force() {
    let shown = succeed!("inspect {PAPER}");
    // Table 1 of the paper; the force from the geometry, see docs/paper-comparison.md.
    for (name, expected, within) in [
        ("transverse contact ratio", 1.540, 1e-3),
        ("overlap ratio", 0.448, 1e-3),
        ("total contact ratio", 1.988, 1e-3),
        ("normal force at nominal torque", 2660.4, 0.1),
    ] {
        let (_, row) = line(&shown, name).split_once(name).unwrap();
        let value: f64 = row.split_whitespace().next().unwrap().parse().unwrap();
        assert!((value - expected).abs() < within, "{name}: {value}");
    }
}

#[test]
fn every_shipped_pair_file_can_be_inspected() {
    for entry in std::fs::read_dir(pairs!()).unwrap() {
        succeed(format!("inspect {}", entry.unwrap().path().display()));
    }
}

#[test]
fn what_teeth_are_thinned_by_is_shown() {
    let shown = succeed(concat!("inspect ", pairs!(), "planet-ring-27-84.json"));
    contains!(
        shown,
        "each thinned by 40.0 um at the operating pitch circle"
    );
}

#[test]
fn a_topography_in_the_folder_of_the_pair_is_shown_with_its_least_and_largest_removal() {
    let folder = Folder::new();
    // Of the wrong sign; the active profile of gear 1 goes from 5.06 to 23.67 mm of roll.
    let mut flank = String::from("z_mm,roll_mm,removal_um\n");
    for z in [0.0, 12.5, 25.0] {
        for roll in [5.0, 10.0, 15.0, 20.0, 24.0] {
            flank += &format!("{z},{roll},-{roll}\n");
        }
    }
    folder.write("flank.csv", flank);
    let pair = folder.pair(|pair| {
        pair["gear1"]["topography_file"] = "flank.csv".into();
        for field in ["tip_relief", "lead_crowning_um"] {
            pair["gear1"].as_object_mut().unwrap().remove(field);
        }
    });
    let shown = succeed!("inspect {pair}");
    contains!(
        shown,
        "removal -23.67 to -5.06 um on the active flank, -23.67 um at the tip at mid-face"
    );
}

#[test]
fn a_wrong_pair_file_is_refused_in_one_line_with_field_value_and_remedy() {
    let folder = Folder::new();
    let pair = folder.pair(|pair| pair["helix_deg"] = 13.0.into());
    refused!("inspect {pair}"; "`helix_deg`");
    let pair = folder.pair(|pair| pair["normal_module_mm"] = (-4.0).into());
    // Field = value: problem; remedy.
    refused!("inspect {pair}"; "normal_module_mm", "-4", ";");
    refused!("inspect no-such-pair.json"; "no-such-pair.json");
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut child = command();
    let child = child.args(["inspect", PAPER]).stdout(Stdio::piped());
    let mut child = child.spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn an_option_that_does_not_exist_is_an_error() {
    refused!("solve {PAPER} --compliance analytical"; "'--compliance'");
}

#[test]
fn an_archive_that_unfolds_without_bound_is_refused() {
    let folder = Folder::new();
    let path = folder.path("bomb.fmu");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("resources/unit.json", options).unwrap();
    // 300 MB of blanks in less than one.
    for _ in 0..300 {
        archive.write_all(&[b' '; 1 << 20]).unwrap();
    }
    archive.finish().unwrap();
    assert!(std::fs::metadata(&path).unwrap().len() < 1 << 20);
    let words = ["resources/unit.json unfolds into more than 256 MB"];
    refused(format!("inspect {path}"), &words);
}

#[test]
fn a_file_without_end_is_refused_by_its_length() {
    let folder = Folder::new();
    let path = folder.path("long.json");
    let file = std::fs::File::create(&path).unwrap();
    // A hole: nothing of it lies on the disk.
    file.set_len(1 << 40).unwrap();
    for command in ["inspect", "solve", "pack -o x.fmu --tables"] {
        refused!("{command} {path}"; "longer than");
    }
}
