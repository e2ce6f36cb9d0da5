//! What `inspect` shows.

use super::*;
use std::process::Stdio;

#[test]
fn shipped_pairs_can_be_inspected_with_their_contact_ratios_nominal_force_and_thinning() {
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
    for entry in std::fs::read_dir(pairs!()).unwrap() {
        succeed(format!("inspect {}", entry.unwrap().path().display()));
    }
    let ring = succeed(concat!("inspect ", pairs!(), "planet-ring-27-84.json"));
    contains!(ring, "each thinned by 40.0 um at the operating pitch");
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
    contains!(shown, "removal -23.67 to -5.06 um on the active flank");
    contains!(shown, ", -23.67 um at the tip at mid-face");
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut child = command();
    let child = child.args(["inspect", PAPER]).stdout(Stdio::piped());
    let mut child = child.spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}
