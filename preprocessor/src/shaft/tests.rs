use super::*;
use crate::pair;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use gearmesh::gear::{Gear, GearKind};

/// Two shafts, one overhung and one between its bearings, for the helical pair of the examples.
pub const ON_SHAFTS: &str = r#"{
    "gear1": { "shaft": {
        "start_mm": -70, "torque_end": "lower",
        "sections": [ { "diameter_mm": 25, "length_mm": 50 }, { "diameter_mm": 30, "length_mm": 60 } ],
        "bearings": [
            { "z_mm": -60, "radial_stiffness_n_per_um": 200, "axial_stiffness_n_per_um": 100 },
            { "z_mm": -15, "radial_stiffness_n_per_um": 300, "tilt_stiffness_nm_per_mrad": 2 } ] } },
    "gear2": { "shaft": {
        "start_mm": -40, "torque_end": "upper",
        "sections": [ { "diameter_mm": 35, "length_mm": 120 } ],
        "bearings": [
            { "z_mm": -30, "radial_stiffness_n_per_um": 300, "axial_stiffness_n_per_um": 100 },
            { "z_mm": 60, "radial_stiffness_n_per_um": 300 } ] } }
}"#;

fn on_shafts() -> Pair {
    let helical = include_str!("../../../resources/pairs/helical-25-47.json");
    let mut file: serde_json::Value = serde_json::from_str(helical).unwrap();
    let more: serde_json::Value = serde_json::from_str(ON_SHAFTS).unwrap();
    for gear in ["gear1", "gear2"] {
        file[gear]["shaft"] = more[gear]["shaft"].clone();
    }
    pair::from_json(&file.to_string()).unwrap()
}

fn shafts_of(pair: &Pair, flank: Flank) -> Shafts {
    Shafts::new(&pair.geometry, &pair.shafts, flank, 0.0).unwrap()
}

#[test]
fn a_force_here_opens_the_flanks_there_as_much_as_the_other_way_round() {
    let pair = on_shafts();
    for flank in [Flank::Drive, Flank::Coast] {
        let flexibility = shafts_of(&pair, flank).flexibility;
        let asymmetry = (&flexibility - flexibility.transpose()).amax();
        assert!(asymmetry < 1e-9 * flexibility.amax(), "{asymmetry:e}");
        assert!(flexibility.clone().symmetric_eigenvalues().min() > -1e-9 * flexibility.amax());
    }
}

#[test]
fn bearings_bear_the_force_of_the_mesh() {
    let pair = on_shafts();
    let g = &pair.geometry;
    let phi = g.operating_pressure_angle(g.center_distance);
    for (flank, s) in [(Flank::Drive, 1.0), (Flank::Coast, -1.0)] {
        let state = shafts_of(&pair, flank).under_even(1000.0);
        let (h, tan_beta_b) = (g.gears[0].hand, g.base_helix_angle().tan());
        // On gear 2; external.
        let on_second = [
            1000.0 * phi.sin(),
            s * 1000.0 * phi.cos(),
            -s * h * 1000.0 * tan_beta_b,
        ];
        for (i, bearings) in state.bearings.iter().enumerate() {
            for (axis, force) in on_second.iter().enumerate() {
                let sum: f64 = bearings.iter().map(|b| b.linear[axis]).sum();
                // Bearings hold the shaft against it.
                let right = [*force, -force][i];
                assert_relative_eq!(sum, right, max_relative = 1e-6);
            }
        }
    }
}

#[test]
fn bearings_share_a_wrench_on_the_gear_as_they_share_the_load_of_the_mesh() {
    let pair = on_shafts();
    let g = &pair.geometry;
    for (flank, s) in [(Flank::Drive, 1.0), (Flank::Coast, -1.0)] {
        let shafts = shafts_of(&pair, flank);
        let state = shafts.under_even(1000.0);
        for i in 0..2 {
            let gear = &g.gears[i];
            let shares = BearingShares::new(pair.shafts[i].as_ref().unwrap(), gear).unwrap();
            // At the pitch point, on the middle of the common face.
            let (low, width) = g.face_overlap();
            let at = low + 0.5 * width - gear.face_offset;
            let phi = g.operating_pressure_angle(g.center_distance);
            let radius = g.operating_pitch_radius(i, g.center_distance) * [1.0, -1.0][i];
            let lean = s * g.gears[0].hand * g.base_helix_angle().tan();
            let force = [phi.sin(), s * phi.cos(), -lean].map(|n| [-1000.0, 1000.0][i] * n);
            let [fx, fy, fz] = force;
            let moment = [-at * fy, at * fx - radius * fz, radius * fy];
            let found = shares.radial_forces(force, moment);
            for (found, right) in found.zip(&state.bearings[i]) {
                let right = right.linear[0].hypot(right.linear[1]);
                // The load is spread over the face, and a third bearing or one that resists tilting feels that.
                assert_relative_eq!(found, right, max_relative = 2e-3);
            }
        }
    }
}

#[test]
fn a_rigid_shaft_on_bearings_closes_the_flanks_as_its_poses_do() {
    // Each bearing alone carries half; the gear sits in the middle, so that the shaft moves without tilting.
    let gear = |teeth| Gear {
        held_radius: 10e-3,
        ..samples(teeth)
    };
    let geometry = PairGeometry {
        gears: [gear(20), gear(30)],
        center_distance: 0.1,
    };
    let bearing = |z| crate::gear::Bearing {
        z,
        radial_stiffness: 1e8,
        axial_stiffness: 0.0,
        tilt_stiffness: 0.0,
        free_radius: 0.0,
    };
    let shaft = Shaft {
        start: -0.05,
        sections: vec![crate::gear::ShaftSection {
            radii: [0.0, 20e-3],
            length: 0.125,
        }],
        bearings: vec![bearing(-0.05), bearing(0.075)],
        torque_at_upper_end: false,
        youngs_modulus: 1e17,
        poisson_ratio: 0.3,
        seat: [0.0, 25e-3],
        seat_radius: 30e-3,
    };
    let shafts = Shafts::new(&geometry, &[Some(shaft), None], Flank::Drive, 0.0).unwrap();
    let state = shafts.under_even(2000.0);
    // Radially 2000 N on two bearings, along the line of action.
    assert_relative_eq!(state.approach, 1e-5, max_relative = 1e-5);
    assert_abs_diff_eq!(state.misalignment, 0.0, epsilon = 1e-10);
}

fn samples(teeth: u32) -> Gear {
    crate::samples::gear(GearKind::External, teeth, 1.0, 0.0, 0.0)
}

#[test]
fn the_default_range_of_misalignment_holds_what_even_loads_cause_on_both_flanks() {
    let pair = on_shafts();
    let maximum = pair.operating.maximum_torque;
    let [low, high] = misalignment_range(&pair.geometry, &pair.shafts, maximum).unwrap();
    for flank in [Flank::Drive, Flank::Coast] {
        let force = maximum / pair.geometry.gears[0].base_radius();
        let found = shafts_of(&pair, flank).under_even(force).misalignment;
        assert!(low < found && found < high, "{low} {found} {high}");
    }
    assert!(low <= -LEAST_MARGIN && high >= LEAST_MARGIN);
}

#[test]
fn the_mean_of_states_is_that_of_each_number() {
    let pair = on_shafts();
    let shafts = shafts_of(&pair, Flank::Drive);
    let states = [100.0, 200.0, 600.0].map(|force| shafts.under_even(force));
    let (mean, right) = (ShaftState::mean(&states).unwrap(), shafts.under_even(300.0));
    assert_relative_eq!(mean.closing[0], right.closing[0], max_relative = 1e-9);
    assert_relative_eq!(
        mean.bearings[1][0].linear[1],
        right.bearings[1][0].linear[1],
        max_relative = 1e-9
    );
    assert_relative_eq!(
        mean.axes[0][5].1.linear[0],
        right.axes[0][5].1.linear[0],
        max_relative = 1e-9
    );
    assert_relative_eq!(mean.misalignment, right.misalignment, max_relative = 1e-9);
}

/// Shafts with their gears by finite elements (validation/reference/shafts.py).
const FINITE_ELEMENTS: &str = include_str!("../../../tests/data/shafts.json");

#[test]
fn shafts_bend_and_twist_as_solids_of_finite_elements_do() {
    let cases: Vec<serde_json::Value> = serde_json::from_str(FINITE_ELEMENTS).unwrap();
    for case in cases {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let list = |name: &str| case[name].as_array().unwrap().clone();
        let sections = list("sections");
        let section = |s: &serde_json::Value| crate::gear::ShaftSection {
            radii: [0.0, 0.5e-3 * number(&s[2])],
            length: 1e-3 * (number(&s[1]) - number(&s[0])),
        };
        let bearing = |b: &serde_json::Value| crate::gear::Bearing {
            z: 1e-3 * number(&b[0]),
            radial_stiffness: 1e6 * number(&b[1]),
            axial_stiffness: 0.0,
            tilt_stiffness: 0.0,
            free_radius: 0.0,
        };
        let face = 1e-3 * number(&case["face"]);
        let shaft = Shaft {
            start: 1e-3 * number(&sections[0][0]),
            sections: sections.iter().map(section).collect(),
            bearings: list("bearings").iter().map(bearing).collect(),
            torque_at_upper_end: case["torque_end"] == "upper",
            youngs_modulus: 206e9,
            poisson_ratio: 0.3,
            seat: [0.0, face],
            seat_radius: 0.5e-3 * number(&case["root"]),
        };
        let gear = samples(20);
        const COUNT: usize = 40;
        let places: Vec<f64> = (0..=COUNT)
            .map(|i| face * i as f64 / COUNT as f64)
            .collect();
        let beam = Beam::new(&shaft, &gear, &places).unwrap();
        let mut loads = vec![AtNode::default(); beam.z.len()];
        for (i, z) in places.iter().enumerate() {
            let share = if i % COUNT == 0 { 0.5 } else { 1.0 } / COUNT as f64;
            let load = &mut loads[nearest(&beam.z, *z)];
            load.linear[0] = 1000.0 * share;
            load.angular[2] = 1000.0 * share;
        }
        let (nodes, _) = beam.solve(&loads);
        let at = |z: &serde_json::Value| nodes[nearest(&beam.z, 1e-3 * number(z))];
        let found: Vec<AtNode> = list("z_mm").iter().map(at).collect();
        let (across, twist) = (list("across_um_per_kn"), list("twist_mrad_per_knm"));
        // (across, twist) at the ends and the middle of the face, um/kN and mrad/(kN m).
        let right = |k: usize| [number(&across[k]), number(&twist[k])];
        let of_beam = |k: usize| [1e6 * found[k].linear[0], 1e3 * found[k].angular[2]];
        for k in 0..5 {
            let ([a, b], [c, d]) = (of_beam(k), right(k));
            assert!(
                (a / c - 1.0).abs() < 0.06 && (b / d - 1.0).abs() < 0.03,
                "{}: {a} {c} {b} {d}",
                case["name"]
            );
        }
        let tilt = |at: &dyn Fn(usize) -> [f64; 2]| at(4)[0] - at(0)[0];
        let bow = |at: &dyn Fn(usize) -> [f64; 2]| at(2)[0] - 0.5 * (at(0)[0] + at(4)[0]);
        let middle = right(2)[0];
        if case["name"].as_str().unwrap().starts_with("textbook") {
            assert_relative_eq!(tilt(&of_beam), tilt(&right), max_relative = 0.015);
        }
        for shape in [tilt, bow] {
            let (found, right) = (shape(&of_beam), shape(&right));
            assert!(
                (found - right).abs() < 0.015 * middle,
                "{}: {found} {right}",
                case["name"]
            );
        }
    }
}

#[test]
fn the_tilt_of_a_plain_shaft_is_four_fifths_to_all_of_the_standards() {
    // ISO 6336-1:2006, equation for f_sh and Figure 13 a without stiffening: 0.023 um mm/N, K' = 0.8; s/l = 0.1.
    let (l, s, d, b, load) = (0.3, 0.03, 0.05, 0.04, 1e5);
    let bearing = |z| crate::gear::Bearing {
        z,
        radial_stiffness: 1e12,
        axial_stiffness: 0.0,
        tilt_stiffness: 0.0,
        free_radius: 0.0,
    };
    let middle = 0.5 * b;
    let shaft = Shaft {
        start: middle - s - 0.5 * l,
        sections: vec![crate::gear::ShaftSection {
            radii: [0.0, 0.5 * d],
            length: l,
        }],
        bearings: vec![bearing(middle - s - 0.5 * l), bearing(middle - s + 0.5 * l)],
        torque_at_upper_end: false,
        youngs_modulus: 206e9,
        poisson_ratio: 0.3,
        seat: [0.0, b],
        seat_radius: 0.0,
    };
    let gear = |teeth| Gear {
        face_width: b,
        ..samples(teeth)
    };
    let geometry = PairGeometry {
        gears: [gear(20), gear(30)],
        center_distance: 0.1,
    };
    let shafts = Shafts::new(&geometry, &[Some(shaft), None], Flank::Drive, 0.0).unwrap();
    let tilt = shafts.under_even(load * b).misalignment.abs() * b;
    let standard = 0.023e-9 * 0.8 * load * (l * s / (d * d)) * (b / d).powi(2);
    let ratio = tilt / standard;
    assert!((0.8..1.0).contains(&ratio), "{ratio}");
}

/// The intermediate shaft of Budynas, Nisbett, Shigley's Mechanical Engineering Design, 9th ed., Example 7-2 with Figure 7-10, at z from
/// its left end: under its two spur gears on rigid bearings, of steel with Poisson's ratio `nu`. Each place of Table 7-3 with what it
/// states for the planes xz and xy, slopes in degrees and deflections in inches, and what is found.
fn textbook_shaft(nu: f64) -> Vec<(&'static str, [f64; 2], [f64; 2])> {
    const INCH: f64 = 25.4e-3;
    const POUND: f64 = 4.448_221_615;
    let [a, g, j, b] = [0.75, 2.75, 8.5, 10.75].map(|z| z * INCH);
    let section = |(diameter, length): (f64, f64)| crate::gear::ShaftSection {
        radii: [0.0, 0.5 * diameter * INCH],
        length: length * INCH,
    };
    let bearing = |z| crate::gear::Bearing {
        z,
        radial_stiffness: 1e12,
        axial_stiffness: 0.0,
        tilt_stiffness: 0.0,
        free_radius: 0.0,
    };
    let sections = [
        (1.0, 1.25),
        (1.4, 0.5),
        (1.625, 1.75),
        (2.0, 4.0),
        (1.625, 2.25),
        (1.4, 0.5),
        (1.0, 1.25),
    ];
    let shaft = Shaft {
        start: 0.0,
        sections: sections.map(section).into(),
        bearings: vec![bearing(a), bearing(b)],
        torque_at_upper_end: false,
        youngs_modulus: 30e6 * POUND / (INCH * INCH),
        poisson_ratio: nu,
        seat: [g, g],
        seat_radius: 0.0,
    };
    let beam = Beam::new(&shaft, &samples(20), &[g, j]).unwrap();
    let node = |z: f64| nearest(&beam.z, z);
    let mut loads = vec![AtNode::default(); beam.z.len()];
    for (z, [xz, xy]) in [(g, [540.0, -197.0]), (j, [-2431.0, -885.0])] {
        loads[node(z)].linear = [xz * POUND, xy * POUND, 0.0];
    }
    let (nodes, _) = beam.solve(&loads);
    let slope = |z: f64| {
        let [x, y, _] = nodes[node(z)].angular;
        [y, x].map(|angle| angle.abs().to_degrees())
    };
    let deflection = |z: f64| {
        let [x, y, _] = nodes[node(z)].linear;
        [x, y].map(|displacement| displacement.abs() / INCH)
    };
    vec![
        ("left bearing", [0.02263, 0.01770], slope(a)),
        ("right bearing", [0.05711, 0.02599], slope(b)),
        ("left gear", [0.02067, 0.01162], slope(g)),
        ("right gear", [0.02155, 0.01149], slope(j)),
        ("left gear moves", [0.000_756_8, 0.000_515_3], deflection(g)),
        (
            "right gear moves",
            [0.001_587_0, 0.000_753_5],
            deflection(j),
        ),
    ]
}

#[test]
fn a_stepped_shaft_bends_as_in_a_textbook_where_shear_and_shoulders_do_not_deflect() {
    // Towards Poisson's ratio -1 the shear modulus has no bound: shoulders are rigid, and deflection by shear is a ninth of steel's, since
    // Cowper's factor falls too. What the textbook's beams leave out altogether.
    for (place, stated, found) in textbook_shaft(-1.0 + 1e-9) {
        for plane in 0..2 {
            let ratio = found[plane] / stated[plane];
            assert!((ratio - 1.0).abs() < 0.02, "{place}: {ratio}");
        }
    }
}

#[test]
fn shear_and_shoulders_let_the_shaft_of_the_textbook_deflect_more() {
    // As the finite elements of this shaft say, under each gear alone.
    let most = [1.07, 1.05, 1.07, 1.02, 1.11, 1.2];
    for ((place, stated, found), most) in textbook_shaft(0.3).into_iter().zip(most) {
        let [stated, found] = [stated, found].map(|[xz, xy]| xz.hypot(xy));
        let ratio = found / stated;
        assert!((1.01..most).contains(&ratio), "{place}: {ratio}");
    }
}
