//! Pairs in contact on finite-element compliance in plane strain, against two-dimensional
//! finite-element analyses that include the contact, and solid faces between plane strain and stress.

use super::*;
use crate::contact::{CycleInput, LoadCase, MeshCycle};
use crate::gear::Pair;
use crate::pair;
use crate::static_contact::{ContactSolver, contact_settings};
use crate::theoretical_pair_stiffness;
use approx::assert_relative_eq;
use gearmesh::contact::ContactSettings;
use gearmesh::gear::Flank;
use std::sync::Arc;

/// Face of the plane-strain pairs, mm; any.
const FACE: f64 = 10.0;

/// A spur pair, alpha 20°, under `torque` N m at most; `gears` are what the pair file says of each.
fn pair_of(module: f64, torque: f64, gears: [String; 2]) -> Pair {
    let [gear1, gear2] = gears;
    pair::from_json(&format!(
        r#"{{"name": "spur", "meshing": "external", "normal_module_mm": {module},
             "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0, "gear1": {gear1}, "gear2": {gear2},
             "operating": {{"nominal_torque_nm": {torque}, "maximum_torque_nm": {torque},
                 "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0]}}}}"#
    ))
    .unwrap()
}

/// A gear of such a pair: on a bore of `bore_ratio` times the root circle, cut by a tool of these coefficients of dedendum and tip radius.
fn gear(module: f64, teeth: u32, shift: f64, tool: [f64; 2], bore_ratio: f64) -> String {
    let [dedendum, radius] = tool;
    let bore = bore_ratio * module * (f64::from(teeth) + 2.0 * (shift - dedendum));
    format!(
        r#"{{"teeth": {teeth}, "profile_shift": {shift:?}, "face_width_mm": {FACE}, "dedendum_coefficient": {dedendum},
             "tool_tip_radius_coefficient": {radius}, "bore_diameter_mm": {bore}}}"#
    )
}

/// Torque, N m, that loads gear 1 by `line_load` N/mm on the line of action.
fn torque(module: f64, teeth: u32, line_load: f64) -> f64 {
    let base_diameter = module * f64::from(teeth) * 20f64.to_radians().cos();
    0.5e-3 * line_load * FACE * base_diameter
}

/// A pair without shift loaded by `line_load` N/mm on the line of action at most.
fn spur_pair(teeth: [u32; 2], module: f64, tool: f64, bore_ratio: f64, line_load: f64) -> Pair {
    let gears = teeth.map(|z| gear(module, z, 0.0, [1.25, tool], bore_ratio));
    pair_of(module, torque(module, teeth[0], line_load), gears)
}

fn models(pair: &Pair, plane_strain: bool) -> [Arc<FiniteElementCompliance>; 2] {
    let settings = Settings {
        plane_strain,
        ..Settings::for_pair(pair)
    };
    let models = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true);
    models.unwrap().gears
}

fn solver(pair: &Pair, plane_strain: bool, stations: usize) -> ContactSolver {
    let [first, second] = models(pair, plane_strain);
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
        center_distance_offset: 0.0,
        positions,
    };
    let load = LoadCase {
        torque: pair.operating.maximum_torque,
        misalignment: 0.0,
    };
    let cycle = MeshCycle::solve(solver, &input, load).unwrap();
    (1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste())
}

#[test]
fn pair_stiffness_at_the_pitch_point_is_that_of_two_dimensional_finite_elements() {
    // Teeth, module mm, N/mm, bore over root radius, N/(mm um). Left out is 16/24, module 4.5 mm, at 300
    // N/mm: published 14.98, found here 15.22 without shift (16.55 with that of the FZG gears of these
    // numbers); undercut teeth, whose bore and tool are not stated.
    for (teeth, module, load, bore, expected) in [
        ([17, 43], 1.0, 100.0, 1.0 / 1.4, 15.79),
        ([17, 43], 1.0, 100.0, 0.5, 13.67),
        ([17, 43], 1.0, 20.0, 1.0 / 1.4, 14.74),
        ([17, 43], 1.0, 235.0, 1.0 / 1.4, 16.41),
        ([17, 43], 1.0, 320.0, 1.0 / 1.4, 16.65),
        ([50, 50], 3.0, 113.0, 1.0 / 1.4, 15.91),
        ([50, 50], 3.0, 113.0, 0.5, 13.98),
        ([28, 28], 3.175, 250.0, 1.0 / 1.4, 16.04),
        ([28, 28], 3.175, 250.0, 0.5, 13.93),
        ([19, 48], 3.175, 300.0, 1.0 / 1.4, 15.93),
        ([100, 100], 1.0, 100.0, 1.0 / 1.4, 16.60),
    ] {
        let pair = spur_pair(teeth, module, 0.38, bore, load);
        let found = load / approach_at_pitch_point(&pair, &solver(&pair, true, 1));
        assert_relative_eq!(found, expected, max_relative = 1e-2);
    }
}

/// ISO/TR 6336-30, example 1. The standard's c'_th is the stiffness of a pair of spur teeth of the virtual numbers, 18.9 and 114.5, with a
/// dedendum of 1.2 on solid discs, from Weber and Banaschek's formulas; its c' is 0.8 of it, which measurements ask for, times 0.9
/// for this dedendum of 1.4. docs/validation.md sets the numbers printed here (`-- --nocapture`) beside each other.
#[test]
fn a_tooth_pair_is_as_stiff_as_iso_6336_says_once_dedendum_and_body_are_the_same() {
    let example = include_str!("../../../tests/data/iso-tr-6336-30-example-1.json");
    let example = pair::from_json(example).unwrap();
    let theoretical = 1e-9 * theoretical_pair_stiffness(&example.geometry);
    // N/mm: the mean over the face of the example at its torque.
    let load = 1300.0;
    // What the standard leaves out is the body: close to the teeth it is held in the first, half-way down in the others.
    let [held, standard, real] = [(1.2, 0.85), (1.2, 0.5), (1.4, 0.5)].map(|(dedendum, bore)| {
        let gears = [(19, 0.145), (115, 0.0)].map(|(z, x)| gear(8.0, z, x, [dedendum, 0.3], bore));
        let pair = pair_of(8.0, torque(8.0, 19, load), gears);
        let found = load / approach_at_pitch_point(&pair, &solver(&pair, true, 1));
        let share = found / theoretical;
        println!("dedendum {dedendum}, bore {bore} of the root: {found:.2} N/(mm um), {share:.3}");
        found
    });
    for (found, expected) in [
        (held, theoretical),
        // Measurements asked the standard for C_M = 0.8, which is what a body of usual size takes off.
        (standard, 0.8 * theoretical),
        // C_B = 1 + 0.5 (1.2 - 1.4).
        (real, 0.9 * standard),
    ] {
        assert!((found / expected - 1.0).abs() < 0.06, "{found} {expected}");
    }
}

#[test]
fn ste_is_that_of_two_dimensional_finite_elements() {
    for (teeth, module, tool, load, bore, mean, peak_to_peak) in [
        ([28, 28], 3.175, 0.3, 250.0, 1.0 / 1.4, 12.222, 5.854),
        ([28, 28], 3.175, 0.3, 250.0, 0.5, 14.529, 5.949),
        ([50, 50], 3.0, 0.38, 177.0, 1.0 / 1.4, 8.110, 3.803),
        ([50, 50], 3.0, 0.38, 177.0, 0.5, 9.639, 3.818),
        ([17, 43], 1.0, 0.38, 100.0, 1.0 / 1.4, 4.947, 2.373),
        ([17, 43], 1.0, 0.38, 100.0, 0.5, 5.890, 2.427),
    ] {
        let pair = spur_pair(teeth, module, tool, bore, load);
        let found = ste(&pair, &solver(&pair, true, 1), 20);
        assert_relative_eq!(found.0, mean, max_relative = 1e-2);
        assert_relative_eq!(found.1, peak_to_peak, max_relative = 2e-2);
    }
}

#[test]
fn face_of_six_modules_lies_between_plane_strain_and_plane_stress() {
    let gear =
        r#"{"teeth": 20, "profile_shift": 0.0, "face_width_mm": 25.0, "bore_diameter_mm": 30.0}"#;
    let pair = pair_of(4.0, 100.0, [gear.into(), gear.into()]);
    let plane = solver(&pair, true, 1);
    let (mean, peak_to_peak) = ste(&pair, &plane, 32);
    let at_pitch_point = approach_at_pitch_point(&pair, &plane);
    assert_relative_eq!(at_pitch_point, 8.816, max_relative = 1e-2);
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
    pair.refinement = crate::gear::Refinement::Coarse;
    let torque = 1.5 * pair.operating.nominal_torque;
    pair.operating.maximum_torque = torque;
    pair.operating.misalignment = [-3e-3, 3e-3];
    let [first, second] = models(&pair, false);
    let contact = contact_settings(&pair);
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
        // Teeth deflect by 37 um at the end of the face. The load there falls off over some five segments;
        // segments a quarter longer follow it within a hundredth.
        let end = |r: &crate::static_contact::ContactResult| r.approach + 3e-3 * 10e-3;
        assert_relative_eq!(end(&fine), end(&coarse), max_relative = 1e-2);
    }
}

/// A pair of a published plastic wheel: teeth 51/52, module 1 mm, 52 mm apart, the wheel's E 2282 MPa, held at a radius of 18.1 mm;
/// `mate` is the Young's modulus of the other gear, GPa. The wheel is gear 2, or gear 1 where the gears are `swapped`.
fn plastic_pair(mate: f64, torque: f64, swapped: bool) -> Pair {
    let gear = |teeth: u32, shift: f64, bore: f64, modulus: f64| {
        format!(
            r#"{{"teeth": {teeth}, "profile_shift": {shift:?}, "face_width_mm": {FACE}, "tool_tip_radius_coefficient": 0.2,
                 "bore_diameter_mm": {bore}, "youngs_modulus_gpa": {modulus}, "poisson_ratio": 0.3}}"#
        )
    };
    let mut gears = [gear(51, -0.203, 30.0, mate), gear(52, 0.0117, 36.2, 2.282)];
    if swapped {
        gears.reverse();
    }
    let [gear1, gear2] = gears;
    pair::from_json(&format!(
        r#"{{"name": "plastic", "meshing": "external", "normal_module_mm": 1.0, "center_distance_mm": 52.0,
             "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0, "gear1": {gear1}, "gear2": {gear2},
             "operating": {{"nominal_torque_nm": {torque}, "maximum_torque_nm": {torque},
                 "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0]}}}}"#
    ))
    .unwrap()
}

/// Geometrically linear plane finite elements of a general program, converged to 0.01 %: one tooth of the wheel against a rigid one where
/// the radii of curvature are 8.240 and 10.787 mm.
#[test]
fn contact_on_a_soft_tooth_moves_to_where_finite_elements_find_it() {
    let rigid = 1e6;
    let pair = plastic_pair(rigid, 10.0, false);
    let [first, second] = models(&pair, true);
    let (base, c) = (
        pair.geometry.gears[0].base_radius(),
        pair.geometry.center_distance,
    );
    let place = (8.240e-3 - pair.geometry.roll_at(0, c, 0.0)) / pair.geometry.base_pitch();
    let approaches = |bent_teeth: bool| {
        let contact = ContactSettings {
            stations: 1,
            bent_teeth,
            ..ContactSettings::default()
        };
        let solver = ContactSolver::new(&pair, [first.clone(), second.clone()], contact).unwrap();
        let alone = solver.tooth_pair(Flank::Drive, place, 0.0).unwrap();
        [8.732, 43.66].map(|line_load| {
            let result = alone.solve_torque(line_load * FACE * base, 0.0, None);
            let result = result.unwrap();
            let segment = result.segments.iter().find(|s| s.force > 0.0).unwrap();
            let arc = |roll: f64| 0.5 * roll * roll / pair.geometry.gears[1].base_radius();
            let moved = arc(segment.roll[1]) - arc(10.787e-3);
            (1e6 * result.approach, 1e3 * moved)
        })
    };
    let (held, free) = (approaches(false), approaches(true));
    for (found, expected) in held.iter().zip([38.0, 181.5]) {
        assert_relative_eq!(found.0, expected, max_relative = 5e-3);
        assert!(found.1.abs() < 1e-3);
    }
    for (found, (approach, moved)) in free.iter().zip([(36.55, -0.066), (154.0, -0.266)]) {
        assert_relative_eq!(found.0, approach, max_relative = 3e-3);
        assert_relative_eq!(found.1, moved, max_relative = 6e-2);
    }
}

#[test]
fn nothing_depends_on_which_gear_of_a_soft_pair_is_called_gear_1() {
    let torque = 3.0;
    let cycles = [false, true].map(|swapped| {
        let teeth_ratio = if swapped { 52.0 / 51.0 } else { 1.0 };
        let pair = plastic_pair(206.0, torque * teeth_ratio, swapped);
        let [first, second] = models(&pair, true);
        let contact = ContactSettings {
            stations: 1,
            ..ContactSettings::default()
        };
        let solver = ContactSolver::new(&pair, [first, second], contact).unwrap();
        ste(&pair, &solver, 64)
    });
    let [(mean, swing), (swapped_mean, swapped_swing)] = cycles;
    assert_relative_eq!(mean, swapped_mean, max_relative = 1e-4);
    assert_relative_eq!(swing, swapped_swing, max_relative = 3e-3);
    assert!(swing > 1.0, "{swing}");
}
