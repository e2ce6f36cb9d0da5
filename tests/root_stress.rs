//! Stress in the tooth root against independent finite elements and beside ISO 6336-3.
//!
//! `tests/data/root_stress.json` comes from `scripts/root_stress_reference.py`, which says how.

#[path = "common/gears.rs"]
mod gears;

use gearmesh::compliance::Segment;
use gearmesh::gear::{Gear, GearKind, PairGeometry};
use gearmesh::pair::Refinement;
use gearmesh_preprocessor::NominalRootStress;
use gearmesh_preprocessor::finite_element::{RootStress, Settings};
use serde_json::Value;

const DATA: &str = include_str!("data/root_stress.json");

/// Pieces of the contact line.
const SEGMENTS: usize = 60;

fn gear(of: &Value, plane_strain: bool) -> Gear {
    let number = |name: &str, default: f64| of.get(name).map_or(default, |v| v.as_f64().unwrap());
    let face_width = number("b", 10.0);
    let kind = match of.get("ring") {
        Some(_) => GearKind::Ring,
        None => GearKind::External,
    };
    let (teeth, helix) = (number("z", 0.0) as u32, number("beta", 0.0));
    Gear {
        normal_module: 1e-3 * number("m", 0.0),
        normal_pressure_angle: number("alpha", 0.0).to_radians(),
        face_width: 1e-3 * if plane_strain { 10.0 } else { face_width },
        tip_radius: 1e-3 * number("tip", 0.0),
        dedendum_coefficient: number("dedendum", 1.25),
        tool_tip_radius_coefficient: number("rho", 0.38),
        held_radius: 1e-3 * number("held", 0.0),
        ..gears::gear(kind, teeth, 1.0, helix, number("x", 0.0))
    }
}

/// Ends of a quantity that is straight over the face.
fn ends(of: &Value, name: &str) -> [f64; 2] {
    [0, 1].map(|i| of[name][i].as_f64().unwrap())
}

/// The contact line of `load` as segments with their forces, N (plane strain: one, N per m).
fn segments(gear: &Gear, load: &Value, plane_strain: bool) -> Vec<(Segment, f64)> {
    let roll = ends(load, "radius_mm").map(|r| gear.roll_length(1e-3 * r));
    let density = ends(load, "load_n_per_mm").map(|q| 1e3 * q);
    let between = |ends: [f64; 2], share: f64| ends[0] + share * (ends[1] - ends[0]);
    if plane_strain {
        let segment = Segment {
            tooth: 0,
            z: [0.0, gear.face_width],
            roll,
        };
        return vec![(segment, density[0])];
    }
    let step = gear.face_width / SEGMENTS as f64;
    (0..SEGMENTS)
        .map(|i| {
            let share = [0.0, 0.5, 1.0].map(|part| (i as f64 + part) / SEGMENTS as f64);
            let segment = Segment {
                tooth: 0,
                z: [share[0] * gear.face_width, share[2] * gear.face_width],
                roll: [between(roll, share[0]), between(roll, share[2])],
            };
            (segment, between(density, share[1]) * step)
        })
        .collect()
}

/// Largest errors of the stress in `case` at `refinement`: all, and those of the larger half of its loads.
fn check(case: &Value, refinement: Refinement, bound: f64) {
    let plane_strain = case["plane_strain"].as_bool().unwrap();
    let gear = gear(&case["gear"], plane_strain);
    let settings = Settings {
        plane_strain,
        ..Settings::new(refinement, 1)
    };
    let model = RootStress::new(&gear, &settings.for_root_stress(), None, &|_, _| true);
    let (model, _) = model.unwrap();
    for load in case["loads"].as_array().unwrap() {
        let (segments, forces): (Vec<_>, Vec<_>) =
            segments(&gear, load, plane_strain).into_iter().unzip();
        let segments = model.spread(&segments);
        let field = model.of_tooth(0, &segments, &forces).unwrap();
        let largest = field.largest();
        let mut pairs = vec![
            (
                "largest",
                largest.stress,
                load["largest_mpa"].as_f64().unwrap(),
            ),
            (
                "at the tangent",
                field.at_tangent().unwrap().stress,
                load["at_tangent_mpa"].as_f64().unwrap(),
            ),
        ];
        for place in load
            .get("along_face_mpa")
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
        {
            let z = 1e-3 * place[0].as_f64().unwrap();
            let after = field.z().partition_point(|at| *at < z).max(1);
            let [low, high] = [after - 1, after].map(|number| field.largest_at(number));
            let share = (z - low.z) / (high.z - low.z);
            let stress = low.stress + share * (high.stress - low.stress);
            pairs.push(("along the face", stress, place[1].as_f64().unwrap()));
        }
        for (what, found, known) in pairs {
            let error = 1e-6 * found / known - 1.0;
            println!(
                "| {} | {refinement:?} | {} | {what} | {known:.1} | {:.1} | {:+.2} |",
                case["name"].as_str().unwrap(),
                load["radius_mm"],
                1e-6 * found,
                100.0 * error
            );
            assert!(error.abs() < bound, "{case}: {what} {found} {known}");
        }
        let place = load["place_tangent_deg"].as_f64().unwrap();
        // The maximum is flat.
        let away = largest.tangent.to_degrees() - place;
        assert!(away.abs() < 6.0, "{case}: {away}");
    }
}

fn cases(plane_strain: bool) -> Vec<Value> {
    let data: Value = serde_json::from_str(DATA).unwrap();
    let all = data["cases"].as_array().unwrap().iter();
    all.filter(|case| case["plane_strain"] == plane_strain)
        .cloned()
        .collect()
}

#[test]
fn in_plane_strain_within_three_percent_of_independent_finite_elements() {
    let cases = cases(true);
    assert_eq!(cases.len(), 3);
    for case in &cases {
        check(case, Refinement::Normal, 0.03);
        check(case, Refinement::Fine, 0.03);
    }
}

#[test]
fn solid_within_three_percent_of_independent_finite_elements() {
    let cases = cases(false);
    assert_eq!(cases.len(), 2);
    for case in &cases {
        check(case, Refinement::Normal, 0.03);
    }
}

/// The terms of ISO 6336-3 against finite elements of the same tooth: plane strain, load at the outer point of single
/// pair contact. docs/root-stress.md has the numbers printed here.
#[test]
fn the_nominal_stress_of_iso_6336_is_within_an_eighth_of_finite_elements() {
    for (teeth, shift) in [
        ([20, 20], [0.0, 0.0]),
        ([17, 43], [0.3, 0.1]),
        ([25, 80], [0.5, 0.0]),
    ] {
        let gear = |i: usize| gears::gear(GearKind::External, teeth[i], 1.0, 0.0, shift[i]);
        let gears = [gear(0), gear(1)];
        let sum = gears[0].reference_radius() + gears[1].reference_radius();
        let pair = PairGeometry {
            center_distance: sum + (shift[0] + shift[1]) * gears[0].normal_module,
            gears,
        };
        for (i, gear) in pair.gears.iter().enumerate() {
            let torque = 100.0;
            let nominal = NominalRootStress::new(&pair, i, torque).unwrap();
            let ratio = pair.transverse_contact_ratio(pair.center_distance);
            let roll = gear.tip_form_roll() - (ratio - 1.0) * pair.base_pitch();
            let settings = Settings {
                plane_strain: true,
                ..Settings::new(Refinement::Normal, 1)
            };
            let model = RootStress::new(gear, &settings.for_root_stress(), None, &|_, _| true);
            let (model, _) = model.unwrap();
            let segment = Segment {
                tooth: 0,
                z: [0.0, gear.face_width],
                roll: [roll; 2],
            };
            // Normal force per face width.
            let force = torque / pair.gears[0].base_radius() / gear.face_width;
            let field = model
                .of_tooth(0, &model.spread(&[segment]), &[force])
                .unwrap();
            let found = [field.largest(), field.at_tangent().unwrap()];
            let [largest, tangent] = found.map(|point| point.stress / nominal.stress);
            println!(
                "| {}/{} | {} | {:.3} | {:.3} | {largest:.3} | {tangent:.3} |",
                teeth[i],
                teeth[1 - i],
                shift[i],
                nominal.form_factor,
                nominal.correction_factor
            );
            assert!((largest - 1.0).abs() < 0.125, "{largest}");
            assert!(tangent <= largest && tangent > 0.85 * largest, "{tangent}");
        }
    }
}
