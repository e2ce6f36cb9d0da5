//! Pairs in contact on finite-element compliance in plane strain, against two-dimensional
//! finite-element analyses that include the contact, and solid faces between plane strain and stress.

use super::*;
use crate::contact::{CycleInput, MeshCycle};
use crate::pair;
use approx::assert_relative_eq;
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::{Flank, ProfileRelief, ReliefShape};
use gearmesh::pair::Pair;
use serde_json::json;

/// A spur pair, alpha 20°, without shift, under the torque `torque` N m at most; bore over root radius.
fn spur_pair(teeth: [f64; 2], module: f64, face: f64, tool: f64, bore: f64, torque: f64) -> Pair {
    let gear = |z: f64| {
        json!({
            "teeth": z as u32,
            "profile_shift": 0.0,
            "face_width_mm": face,
            "tool_tip_radius_coefficient": tool,
            "bore_diameter_mm": bore * module * (z - 2.5),
        })
    };
    let pair = json!({
        "name": "plane",
        "meshing": "external",
        "normal_module_mm": module,
        "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": 0.0,
        "gear1": gear(teeth[0]),
        "gear2": gear(teeth[1]),
        "operating": {
            "nominal_torque_nm": torque,
            "maximum_torque_nm": torque,
            "center_distance_offset_um": [0.0, 0.0],
            "misalignment_mrad": [0.0, 0.0],
        },
    });
    pair::from_json(&pair.to_string()).unwrap()
}

/// The same of any face under `load` N/mm on the line of action.
fn plane_pair(teeth: [f64; 2], module: f64, tool: f64, bore: f64, load: f64) -> Pair {
    let (face, cosine) = (10.0, 20f64.to_radians().cos());
    let torque = load * face * 0.5e-3 * module * teeth[0] * cosine;
    spur_pair(teeth, module, face, tool, bore, torque)
}

/// Numbers of a published table, row by row.
fn published(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

fn solver(pair: &Pair, plane_strain: bool, stations: usize) -> ContactSolver {
    let settings = Settings {
        plane_strain,
        ..Settings::for_pair(pair)
    };
    let [first, second] = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)
        .unwrap()
        .gears;
    let contact = ContactSettings {
        stations,
        tip_corner_contact: false,
        ..ContactSettings::default()
    };
    ContactSolver::new(pair, [first, second], contact).unwrap()
}

/// Approach at the pitch point, um, under the pair's maximum torque.
fn approach_at_pitch_point(pair: &Pair, solver: &ContactSolver) -> f64 {
    let position = solver.position(Flank::Drive, 0.0, 0.0).unwrap();
    let result = position
        .solve_torque(pair.operating.maximum_torque, 0.0, None)
        .unwrap();
    1e6 * result.approach
}

/// Mean and peak-to-peak STE, um, over `positions` under the pair's maximum torque. On the path only,
/// the STE of a spur pair jumps where a tooth pair comes in, and it rises towards the jump: with ever more
/// positions the peak-to-peak value grows by 1 to 3 %.
fn ste(pair: &Pair, solver: &ContactSolver, positions: usize) -> (f64, f64) {
    let input = CycleInput {
        flank: Flank::Drive,
        torque: pair.operating.maximum_torque,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions,
    };
    let cycle = MeshCycle::solve(solver, &input).unwrap();
    (1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste())
}

#[test]
fn pair_stiffness_at_the_pitch_point_is_that_of_two_dimensional_finite_elements() {
    // Stiffness in N/(mm um). Left out is 16/24: published 14.98, found here 15.22 without shift (16.55 with that of the
    // FZG gears of these numbers); undercut teeth, whose bore and tool are not stated.
    let table = published(include_str!("../../../tests/data/plane_pair_stiffness.csv"));
    for row in table.iter().filter(|row| row[0] != 16.0) {
        let [z1, z2, module, load, bore, expected] = row[..] else {
            panic!("{row:?}")
        };
        let pair = plane_pair([z1, z2], module, 0.38, bore, load);
        let found = load / approach_at_pitch_point(&pair, &solver(&pair, true, 1));
        assert_relative_eq!(found, expected, max_relative = 1e-2);
    }
}

#[test]
fn ste_is_that_of_two_dimensional_finite_elements() {
    let table = published(include_str!("../../../tests/data/plane_ste.csv"));
    for row in table.iter().filter(|row| row[3] == 20.0) {
        let [z1, z2, module, _, tool, load, bore, mean, peak_to_peak] = row[..] else {
            panic!("{row:?}")
        };
        let pair = plane_pair([z1, z2], module, tool, bore, load);
        let found = ste(&pair, &solver(&pair, true, 1), 20);
        assert_relative_eq!(found.0, mean, max_relative = 1e-2);
        assert_relative_eq!(found.1, peak_to_peak, max_relative = 2e-2);
    }
}

/// 20/20 teeth, module 4 mm, face 25 mm, bore 30 mm, 100 N m.
fn thick_pair() -> Pair {
    spur_pair([20.0; 2], 4.0, 25.0, 0.38, 30.0 / 70.0, 100.0)
}

#[test]
fn face_of_six_modules_lies_between_plane_strain_and_plane_stress() {
    let pair = thick_pair();
    let plane = solver(&pair, true, 1);
    let (mean, peak_to_peak) = ste(&pair, &plane, 32);
    assert_relative_eq!(
        approach_at_pitch_point(&pair, &plane),
        8.816,
        max_relative = 1e-2
    );
    assert_relative_eq!(mean, 7.427, max_relative = 1e-2);
    assert_relative_eq!(peak_to_peak, 2.926, max_relative = 2e-2);
    // The published values of plane stress are 9.450 at the pitch point, 7.932 in the mean.
    let solid = approach_at_pitch_point(&pair, &solver(&pair, false, 40));
    let share = (solid - 8.816) / (9.450 - 8.816);
    assert!((0.25..0.55).contains(&share), "{share:.3} of the way");
}

#[test]
fn a_ring_carries_its_torque_on_the_end_of_its_face() {
    // Flat flanks, and all load on a few millimetres: contacts as wide as a quarter of the tooth is high.
    let text = include_str!("../../../resources/pairs/planet-ring-27-84.json");
    let mut pair = pair::from_json(text).unwrap();
    pair.refinement = gearmesh::pair::Refinement::Coarse;
    let torque = 1.5 * pair.operating.nominal_torque;
    pair.operating.maximum_torque = torque;
    pair.operating.misalignment = [-3e-3, 3e-3];
    let settings = Settings::for_pair(&pair);
    let [first, second] = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)
        .unwrap()
        .gears;
    let contact = ContactSettings::for_pair(&pair);
    let mut longer = contact;
    longer.stations = contact.stations * 4 / 5;
    let solvers = [contact, longer].map(|settings| {
        ContactSolver::new(&pair, [first.clone(), second.clone()], settings).unwrap()
    });
    for mesh_position in [0.0, 0.25, 0.5, 0.75, 0.875] {
        let [fine, coarse] = solvers.each_ref().map(|solver| {
            let position = solver.position(Flank::Drive, mesh_position, 0.0).unwrap();
            position.solve_torque(torque, 3e-3, None).unwrap()
        });
        assert!(fine.kkt_residual < 1e-8, "{}", fine.kkt_residual);
        // Teeth give way by 37 um at the end of the face. The load there falls off over some five strips;
        // strips a quarter longer follow it within a hundredth.
        let end = |r: &gearmesh::contact::ContactResult| r.approach + 3e-3 * 10e-3;
        assert_relative_eq!(end(&fine), end(&coarse), max_relative = 1e-2);
    }
}

/// [`thick_pair`] with linear tip relief of `amount` (m) over the last fifth of the path of contact on both gears.
fn relieved_pair(amount: f64) -> Pair {
    let mut pair = thick_pair();
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let starts = [
        path.end - 0.2 * path.length(),
        path.start + 0.2 * path.length(),
    ];
    for (i, xi) in starts.into_iter().enumerate() {
        pair.microgeometry.drive[i].tip_relief = Some(ProfileRelief {
            amount,
            start_roll: g.roll_at(i, c, xi),
            end_roll: g.gears[i].roll_length(g.gears[i].tip_radius),
            shape: ReliefShape::Linear,
        });
    }
    pair
}

#[test]
fn ste_of_steeply_relieved_flanks_is_that_of_direct_contact() {
    // Direct nodal contact in plane strain, nodes 0.012 mm apart, no Hertz formula and no nominal line.
    for (amount, torque, mean, peak_to_peak) in
        [(25e-6, 100.0, 9.009, 1.286), (8e-6, 50.0, 4.516, 0.921)]
    {
        let mut pair = relieved_pair(amount);
        pair.operating.maximum_torque = torque;
        let found = ste(&pair, &solver(&pair, true, 1), 32);
        assert_relative_eq!(found.0, mean, max_relative = 7e-3);
        assert_relative_eq!(found.1, peak_to_peak, max_relative = 2e-2);
    }
}
