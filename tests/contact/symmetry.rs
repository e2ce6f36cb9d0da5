//! Mirrors and renumbering must change nothing.

use super::*;

/// A pair file with both gears' entries, external 20 / 31 or internal 20 / 61, every modification on.
pub(super) fn text(meshing: &str, helix_deg: f64, swap: bool) -> String {
    let gear = |teeth: u32, held: &str, diameter: f64, relief: f64, slope: f64| {
        json!({
            "teeth": teeth, "profile_shift": 0.2, "face_width_mm": 18.0, held: diameter,
            "tip_relief": { "amount_um": relief, "start": "pitch_point", "shape": "parabolic" },
            "lead_crowning_um": 3.0, "lead_slope_um": slope,
        })
    };
    let wheel = match meshing {
        "external" => gear(31, "bore_diameter_mm", 30.0, 9.0, -1.0),
        _ => gear(61, "rim_diameter_mm", 215.0, 9.0, -1.0),
    };
    // The same load on the line of action, whichever gear the torque is given on.
    let ratio = if swap {
        number(&wheel["teeth"]) / 20.0
    } else {
        1.0
    };
    let mut gears = [gear(20, "bore_diameter_mm", 24.0, 6.0, 2.0), wheel];
    gears.rotate_left(usize::from(swap));
    json!({
        "name": "symmetry", "meshing": meshing, "normal_module_mm": 3.0,
        "normal_pressure_angle_deg": 20.0, "helix_angle_deg": helix_deg,
        "gear1": gears[0], "gear2": gears[1],
        "operating": {
            "nominal_torque_nm": 200.0, "maximum_torque_nm": 2000.0 * ratio,
            "center_distance_offset_um": [-50.0, 50.0], "misalignment_mrad": [-1.0, 1.0],
        },
    })
    .to_string()
}

/// Mesh position, force on the line of action in N and misalignment in rad.
const CASES: [[f64; 3]; 3] = [
    [0.1, 3000.0, 0.4e-3],
    [0.55, 8000.0, -0.7e-3],
    [0.9, 800.0, 0.0],
];

/// The pair `text` in such a case, contact on tip edges followed or not.
fn solve(text: &str, flank: Flank, edges: bool, [tau, force, tilt]: [f64; 3]) -> ContactResult {
    let pair = pair::from_json(text).unwrap();
    let settings = ContactSettings {
        tip_corner_contact: edges,
        ..with_stations(16)
    };
    let problem = coarse_solver(&pair, settings).position(flank, tau, 20e-6);
    let torque = force * pair.geometry.gears[0].base_radius();
    problem.unwrap().solve_torque(torque, tilt, None).unwrap()
}

fn drive(text: &str, case: [f64; 3]) -> ContactResult {
    solve(text, Flank::Drive, true, case)
}

fn coast(text: &str, case: [f64; 3]) -> ContactResult {
    solve(text, Flank::Coast, true, case)
}

fn assert_same(a: &ContactResult, b: &ContactResult, z_b: f64) {
    let epsilon = 1e-9 * a.approach.abs().max(1e-6);
    assert_abs_diff_eq!(a.approach, b.approach, epsilon = epsilon);
    assert_abs_diff_eq!(a.contact_z, z_b, epsilon = 1e-9);
    assert_relative_eq!(a.max_pressure, b.max_pressure, max_relative = 1e-7);
}

#[test]
fn contact_on_the_path_does_not_depend_on_which_gear_is_numbered_1() {
    // On a tip edge it does: there the ratio of the torques is not that of the base radii, and the torque given
    // is the one on gear 1. An internal pair presses the ring in the sense in which it turns: the flank changes its name.
    let cases = [
        ("external", -15.0, Flank::Drive),
        ("internal", 15.0, Flank::Coast),
    ];
    for (meshing, swapped_helix, flank) in cases {
        let [first, second] =
            [(15.0, false), (swapped_helix, true)].map(|(helix, swap)| text(meshing, helix, swap));
        for case @ [tau, force, m] in CASES {
            let a = solve(&first, Flank::Drive, false, case);
            let b = solve(&second, flank, false, [-tau, force, m]);
            assert_same(&a, &b, b.contact_z);
        }
    }
}

#[test]
fn a_left_handed_pair_is_the_mirror_image_of_a_right_handed_one() {
    for meshing in ["external", "internal"] {
        // The mirror contains the axes: it turns over hand and flank and keeps z.
        let [right, left] = [15.0, -15.0].map(|helix| text(meshing, helix, false));
        for case in CASES {
            let (a, b) = (drive(&right, case), coast(&left, case));
            assert_same(&a, &b, b.contact_z);
        }
    }
}

#[test]
fn without_lead_slope_the_coast_flank_is_the_drive_flank_seen_from_the_other_end() {
    for meshing in ["external", "internal"] {
        let symmetric = text(meshing, 15.0, false)
            .replace(r#""lead_slope_um":2.0"#, r#""lead_slope_um":0.0"#)
            .replace(r#""lead_slope_um":-1.0"#, r#""lead_slope_um":0.0"#);
        assert!(pair::from_json(&symmetric).unwrap().coast_mirrors_drive());
        for case @ [tau, force, m] in CASES {
            let (a, b) = (drive(&symmetric, case), coast(&symmetric, [tau, force, -m]));
            assert_same(&a, &b, 18e-3 - b.contact_z);
        }
    }
}

#[test]
fn a_spur_pair_is_its_own_mirror_image_under_misalignment() {
    let width = pair::from_json(SPUR).unwrap().geometry.face_overlap().1;
    for [tau, force, _] in CASES {
        let [a, b] = [0.5e-3, -0.5e-3].map(|m| drive(SPUR, [tau, force, m]));
        assert_same(&a, &b, width - b.contact_z);
        // M > 0 closes the side of larger z.
        assert!(a.contact_z > 0.5 * width);
    }
}

#[test]
fn samples_of_a_spur_pair_are_solved_at_misalignments_of_one_sign_and_mirrored_to_the_other() {
    let axes = Axes {
        displacement_fraction: vec![0.3, 1.0],
        center_distance_offset: vec![20e-6],
        misalignment: vec![-0.5e-3, -0.2e-3, 0.0, 0.5e-3],
        mesh_position: vec![0.1, 0.7],
    };
    let sloped = SPUR.replace(r#""teeth": 16,"#, r#""teeth": 16, "lead_slope_um": 5.0,"#);
    for (text, rows) in [(SPUR, 3), (&sloped, 4), (HELICAL, 4)] {
        let pair = pair::from_json(text).unwrap();
        let solver = coarse_solver(&pair, with_stations(16));
        assert_eq!(solver.is_mirrored_at_mid_face(), rows == 3);
        let watched = WatchedSolver::new(&solver, None);
        let torque = pair.operating.maximum_torque;
        let grid = sweep(&watched, Flank::Drive, &axes, torque, QUIET).unwrap();
        assert_eq!(watched.quality().solves, rows * 2 * 2);
        let moment = grid.moment.as_ref().unwrap();
        let top_moment = moment.iter().fold(0.0f64, |top, m| top.max(m.abs()));
        for (i, (force, moment)) in grid.loa_force.iter().zip(moment).enumerate() {
            let q = grid.query([0, i / 4, i / 2 % 2, i % 2]);
            let problem = solver.position(Flank::Drive, q.mesh_position, q.center_distance_offset);
            let exact = problem
                .unwrap()
                .solve_approach(q.delta, q.misalignment, None);
            let exact = Resultant::from(&exact.unwrap());
            assert_abs_diff_eq!(*force, exact.loa_force, epsilon = 1e-5 * grid.top_force());
            assert_abs_diff_eq!(*moment, exact.moment, epsilon = 1e-5 * top_moment);
        }
    }
}

#[test]
fn sliding_of_a_spur_pair_is_mirrored_as_it_is_solved_at_the_other_sign() {
    let solver = coarse_solver(&pair::from_json(SPUR).unwrap(), with_stations(16));
    // Whoever deflects flanks solves at both signs.
    let both = solver.clone().with_deflection(Deflection::default());
    assert!(solver.is_mirrored_at_mid_face() && !both.is_mirrored_at_mid_face());
    let axes = LoadAxes {
        center_distance_offset_m: vec![0.0],
        misalignment_rad: vec![-0.5e-3, 0.0, 0.5e-3],
        loa_force_n: vec![1000.0, 4000.0],
        mesh_position: vec![0.1, 0.7],
    };
    let [found, solved] =
        [solver, both].map(|solver| sweep_sliding(&solver, Flank::Drive, &axes, QUIET).unwrap());
    let columns = found.columns().into_iter().zip(solved.columns());
    for ((name, found), (_, solved)) in columns {
        let largest = solved.iter().fold(0.0f64, |top, x| top.max(x.abs()));
        for (found, solved) in found.iter().zip(solved) {
            assert_abs_diff_eq!(found, solved, epsilon = 1e-5 * largest);
        }
        // The same force and position at the misalignment of the other sign.
        assert!(name != "share_z_m" || solved[0] * solved[8] < 0.0);
    }
}

#[test]
fn positions_one_base_pitch_apart_are_the_same() {
    let pair = text("external", 15.0, false);
    for [tau, force, m] in CASES {
        let [a, b] = [tau, tau + 7.0].map(|tau| drive(&pair, [tau, force, m]));
        assert_same(&a, &b, b.contact_z);
    }
}
