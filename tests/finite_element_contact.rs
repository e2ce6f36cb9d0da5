//! Whole contact against an independent finite-element program without any Hertz formula
//! (`tests/data/finite_element_contact.json` says how it works), tip edges that bear load included.
#![cfg(feature = "preprocess")]

use gearmesh::compliance::finite_element::{PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use serde_json::Value;

/// Pair and reference data of a case.
fn case(name: &str) -> (Pair, Value) {
    let text = include_str!("data/finite_element_contact.json");
    let all: Value = serde_json::from_str(text).unwrap();
    let mut case = all["cases"][name].clone();
    // The ring's tip is longer than pair files may have it: it all but touches the pinion's fillet.
    let long_tip = case["pair"]["gear2"]["tip_diameter_mm"] == 175.2;
    if long_tip {
        case["pair"]["gear2"]["tip_diameter_mm"] = 174.8.into();
    }
    let mut pair = Pair::from_json(&case["pair"].to_string()).unwrap();
    if long_tip {
        pair.geometry.gears[1].tip_radius = 87.6e-3;
    }
    (pair, case)
}

/// Compares the transmission error at every position and torque.
fn agrees(name: &str, stations: usize) {
    let (pair, case) = case(name);
    let plane_strain = case["plane_strain"].as_bool().unwrap();
    let settings = Settings {
        plane_strain,
        ..Settings::for_pair(&pair)
    };
    let compliance = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true).unwrap();
    let [first, second] = compliance.gears;
    let contact = ContactSettings {
        stations,
        ..ContactSettings::default()
    };
    let solver = ContactSolver::new(&pair, [first, second], contact).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().unwrap();
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let torques = numbers(&case["torque_nm"]);
    let mut sums = vec![[0.0; 2]; torques.len()];
    for at in case["positions"].as_array().unwrap() {
        let mesh_position = at["mesh_position"].as_f64().unwrap();
        let problem = solver.position(Flank::Drive, mesh_position, 0.0).unwrap();
        for ((torque, expected), sum) in torques.iter().zip(numbers(&at["ste_um"])).zip(&mut sums) {
            let result = problem.solve_torque(*torque, 0.0, None).unwrap();
            let found = 1e6 * result.approach;
            let error = found / expected - 1.0;
            assert!(
                error.abs() < 0.02,
                "{name} at {mesh_position}, {torque} N m: {found:.3} instead of {expected:.3} um"
            );
            sum[0] += found;
            sum[1] += expected;
        }
    }
    for (torque, [found, expected]) in torques.iter().zip(sums) {
        let error = found / expected - 1.0;
        assert!(
            error.abs() < 0.01,
            "{name} at {torque} N m: mean {error:+.4}"
        );
    }
}

#[test]
fn spur_pair_in_plane_strain_agrees_at_every_position_and_load() {
    agrees("a", 1);
}

#[test]
fn shifted_spur_pair_in_plane_strain_agrees_at_every_position_and_load() {
    agrees("d2", 1);
}

#[test]
fn internal_pair_in_plane_strain_agrees_at_every_position_and_load() {
    agrees("e2", 1);
}

#[test]
fn solid_spur_pair_agrees_at_every_position_and_load() {
    agrees("b", 20);
}
