//! Stress in the tooth roots over mesh cycles, against independent finite elements and beside ISO 6336-3.

use super::*;
use gearmesh::contact::Segment;
use gearmesh_preprocessor::NominalRootStress;

/// Two equal gears of opposite hand, 20 teeth, module 3 mm.
fn pair(helix_deg: f64) -> Pair {
    let gears = [1.0, -1.0].map(|hand| Gear {
        face_width: 18e-3,
        held_radius: 12e-3,
        ..gears::with_module(
            gears::gear(GearKind::External, 20, hand, helix_deg, 0.0),
            3e-3,
        )
    });
    pair_of(PairGeometry {
        center_distance: 2.0 * gears[0].reference_radius(),
        gears,
    })
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
        center_distance_offset: 0.0,
        positions: 8,
    };
    let case = |&(torque, misalignment): &(f64, f64)| LoadCase {
        torque,
        misalignment,
    };
    let cases: Vec<LoadCase> = cases.iter().map(case).collect();
    let cycles = MeshCycle::solve_all(&solver, &[None, None], &input, &cases, &|_| ()).unwrap();
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

/// From `validation/reference/root_stress.py`, which says how.
const DATA: &str = include_str!("../data/root_stress.json");

/// Pieces of the contact line.
const SEGMENTS: usize = 60;

fn gear(of: &Value) -> Gear {
    let number = |name: &str, default: f64| of.get(name).map_or(default, |v| v.as_f64().unwrap());
    let kind = match of.get("ring") {
        Some(_) => GearKind::Ring,
        None => GearKind::External,
    };
    let (teeth, helix) = (number("z", 0.0) as u32, number("beta", 0.0));
    Gear {
        normal_module: 1e-3 * number("m", 0.0),
        normal_pressure_angle: number("alpha", 0.0).to_radians(),
        face_width: 1e-3 * number("b", 10.0),
        tip_radius: 1e-3 * number("tip", 0.0),
        tool_tip_radius_coefficient: number("rho", 0.38),
        held_radius: 1e-3 * number("held", 0.0),
        ..gears::gear(kind, teeth, 1.0, helix, number("x", 0.0))
    }
}

fn model(gear: &Gear, refinement: Refinement, plane_strain: bool) -> RootStress {
    let settings = Settings {
        plane_strain,
        ..Settings::new(refinement, 1)
    };
    let model = RootStress::new(gear, &settings.for_root_stress(), None, &|_, _| true);
    model.unwrap().0
}

/// The contact line of `load` as segments with their forces, N; plane strain: one.
fn segments(gear: &Gear, load: &Value, plane_strain: bool) -> Vec<(Segment, f64)> {
    // Straight over the face.
    let ends = |name: &str| [0, 1].map(|i| load[name][i].as_f64().unwrap());
    let between = |ends: [f64; 2], share: f64| ends[0] + share * (ends[1] - ends[0]);
    let roll = ends("radius_mm").map(|r| gear.roll_length(1e-3 * r));
    let density = ends("load_n_per_mm").map(|q| 1e3 * q);
    let count = if plane_strain { 1 } else { SEGMENTS };
    let length = gear.face_width / count as f64;
    let segment = |i: usize| {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|part| (i as f64 + part) / count as f64);
        let segment = Segment {
            tooth: 0,
            z: [low, high].map(|share| share * gear.face_width),
            roll: [low, high].map(|share| between(roll, share)),
        };
        (segment, between(density, middle) * length)
    };
    (0..count).map(segment).collect()
}

/// Stress within three percent, and its place, in `case` at `refinement` under each of its loads.
fn check(case: &Value, refinement: Refinement) {
    let plane_strain = case["plane_strain"] == true;
    let gear = gear(&case["gear"]);
    let model = model(&gear, refinement, plane_strain);
    for load in case["loads"].as_array().unwrap() {
        let known = |key: &str| load[key].as_f64().unwrap();
        let (segments, forces): (Vec<_>, Vec<_>) =
            segments(&gear, load, plane_strain).into_iter().unzip();
        let field = model.of_tooth(0, &model.spread(&segments), &forces);
        let field = field.unwrap();
        let (largest, tangent) = (field.largest(), field.at_tangent().unwrap());
        let mut pairs = vec![
            ("largest", largest.stress, known("largest_mpa")),
            ("at the tangent", tangent.stress, known("at_tangent_mpa")),
        ];
        for place in load["along_face_mpa"].as_array().into_iter().flatten() {
            let [z, stress] = [0, 1].map(|i| place[i].as_f64().unwrap());
            let after = field.z().partition_point(|at| *at < 1e-3 * z).max(1);
            let [low, high] = [after - 1, after].map(|number| field.largest_at(number));
            let share = (1e-3 * z - low.z) / (high.z - low.z);
            let found = low.stress + share * (high.stress - low.stress);
            pairs.push(("along the face", found, stress));
        }
        for (what, found, known) in pairs {
            let (name, radii, found) = (&case["name"], &load["radius_mm"], 1e-6 * found);
            let error = found / known - 1.0;
            let row = format!(
                "| {name} | {refinement:?} | {radii} | {what} | {known:.1} | {found:.1} | {:+.2} |",
                100.0 * error
            );
            println!("{row}");
            assert!(error.abs() < 0.03, "{row}");
        }
        // The maximum is flat.
        let away = largest.tangent.to_degrees() - known("place_tangent_deg");
        assert!(away.abs() < 6.0, "{case}: {away}");
    }
}

/// The `count` cases in plane strain or not.
fn check_all(plane_strain: bool, count: usize, refinements: &[Refinement]) {
    let data: Value = serde_json::from_str(DATA).unwrap();
    let all = data["cases"].as_array().unwrap().iter();
    let cases: Vec<_> = all
        .filter(|case| case["plane_strain"] == plane_strain)
        .collect();
    assert_eq!(cases.len(), count);
    for case in cases {
        refinements
            .iter()
            .for_each(|refinement| check(case, *refinement));
    }
}

#[test]
fn in_plane_strain_within_three_percent_of_independent_finite_elements() {
    check_all(true, 3, &[Refinement::Normal, Refinement::Fine]);
}

#[test]
fn solid_within_three_percent_of_independent_finite_elements() {
    check_all(false, 2, &[Refinement::Normal]);
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
            let model = model(gear, Refinement::Normal, true);
            let segment = Segment {
                tooth: 0,
                z: [0.0, gear.face_width],
                roll: [roll; 2],
            };
            let force = torque / pair.gears[0].base_radius();
            let field = model.of_tooth(0, &model.spread(&[segment]), &[force]);
            let field = field.unwrap();
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
