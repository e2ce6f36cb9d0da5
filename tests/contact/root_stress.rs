//! Stress in the tooth roots over mesh cycles.

use super::*;

/// Two equal gears of opposite hand, 20 teeth, module 3 mm.
fn pair(helix_deg: f64) -> Pair {
    let gear =
        r#"{ "teeth": 20, "profile_shift": 0.0, "face_width_mm": 18.0, "bore_diameter_mm": 24.0 }"#;
    let text = format!(
        r#"{{ "name": "roots", "meshing": "external", "normal_module_mm": 3.0,
             "normal_pressure_angle_deg": 20.0, "helix_angle_deg": {helix_deg},
             "gear1": {gear}, "gear2": {gear},
             "operating": {{ "nominal_torque_nm": 100.0, "maximum_torque_nm": 150.0,
               "center_distance_offset_um": [-20.0, 20.0], "misalignment_mrad": [-1.0, 1.0] }} }}"#
    );
    pair::from_json(&text).unwrap()
}

/// Roots of both gears at each of `cases` (torque, misalignment in rad).
fn solve(pair: &Pair, flank: Flank, cases: &[(f64, f64)]) -> Vec<[GearRoots; 2]> {
    // Under tip edges the arm is that about gear 1, which tells the gears apart.
    let settings = ContactSettings {
        tip_corner_contact: false,
        ..with_stations(16)
    };
    let solver = coarse_solver(pair, settings);
    let models = root_models(pair, Flank::Drive);
    let input = CycleInput {
        flank,
        torque: 100.0,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions: 8,
    };
    let case = |&(torque, misalignment): &(f64, f64)| LoadCase {
        torque,
        misalignment,
    };
    let cases: Vec<LoadCase> = cases.iter().map(case).collect();
    let cycles = MeshCycle::solve_all(&solver, &input, &cases, &|_| ()).unwrap();
    let roots = |cycle: &MeshCycle| cycle.root_stress(&solver, &input, &models).unwrap();
    cycles.iter().map(roots).collect()
}

#[test]
fn misalignment_moves_the_largest_stress_to_the_closing_side_whatever_hand_and_flank() {
    for helix in [0.0, 15.0] {
        let pair = pair(helix);
        for flank in [Flank::Drive, Flank::Coast] {
            let both = solve(&pair, flank, &[(100.0, 1e-3), (100.0, -1e-3)]);
            for (roots, side) in both.iter().zip([1.0, -1.0]) {
                for gear in roots {
                    let top = gear.largest().unwrap().largest;
                    assert!(side * (top.z - 9e-3) > 2e-3, "{helix} {flank:?} {}", top.z);
                }
            }
        }
    }
}

#[test]
fn equal_gears_see_the_same_stress_half_a_turn_apart_and_the_coast_flank_mirrors_it() {
    for helix in [0.0, 15.0] {
        let pair = pair(helix);
        let [drive, coast] = [Flank::Drive, Flank::Coast]
            .map(|flank| solve(&pair, flank, &[(100.0, 0.0)]).remove(0));
        let over = |gear: &GearRoots| gear.over_cycle(8, |tooth| Some(tooth.largest.stress));
        let (first, second, mirrored) = (over(&drive[0]), over(&drive[1]), over(&coast[0]));
        for i in 0..8 {
            // The pitch point of gear 1 at tau is that of gear 2 at -tau.
            assert_relative_eq!(first[i], second[(8 - i) % 8], max_relative = 1e-6);
            assert_relative_eq!(first[i], mirrored[i], max_relative = 1e-6);
        }
        let (a, b) = (drive[0].largest().unwrap(), drive[1].largest().unwrap());
        assert_relative_eq!(a.largest.stress, b.largest.stress, max_relative = 1e-3);
        assert_abs_diff_eq!(a.largest.radius, b.largest.radius, epsilon = 1e-5);
    }
}

#[test]
fn the_field_holds_the_largest_stress_and_no_load_leaves_none() {
    let pair = pair(0.0);
    let [idle, loaded] = &solve(&pair, Flank::Drive, &[(0.0, 0.0), (100.0, 0.0)])[..] else {
        panic!()
    };
    for (idle, loaded) in idle.iter().zip(loaded) {
        assert!(idle.largest().is_none() && idle.teeth.is_empty() && idle.field.is_empty());
        let stress = loaded.field.iter().flatten().map(|point| point.stress);
        let (found, top) = (stress.fold(0.0, f64::max), loaded.largest().unwrap());
        let top = top.largest.stress;
        // The largest is between the points.
        assert!(found <= top && found > 0.97 * top, "{found} {top}");
        let ascends = |rows: &[Vec<RootPoint>]| rows[0][0].z < rows[1][0].z;
        assert!(loaded.field.windows(2).all(ascends));
    }
}
