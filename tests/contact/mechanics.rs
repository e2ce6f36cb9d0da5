//! Energy, monotony, equilibrium and refusals.

use super::*;

const SHIPPED: [&str; 4] = [PAPER, HELICAL, RING, SPUR];
/// With a wheel of plastic.
const PLASTIC: &str = include_str!("../data/plastic_reference.json");

fn shipped() -> impl Iterator<Item = (Pair, ContactSolver)> {
    SHIPPED.iter().map(|text| {
        let pair = pair::from_json(text).unwrap();
        let solver = coarse_solver(&pair, ContactSettings::default());
        (pair, solver)
    })
}

/// Positions, misalignments and torques up to the limits of `pair`.
fn points(pair: &Pair) -> [[f64; 3]; 4] {
    let (tilt, most) = (
        pair.operating.misalignment[1],
        pair.operating.maximum_torque,
    );
    [
        [0.0, 0.0, 0.5 * most],
        [0.23, 0.3 * tilt, 0.2 * most],
        [0.5, -0.6 * tilt, most],
        [0.81, tilt, 0.05 * most],
    ]
}

#[test]
fn tangents_are_the_derivatives_of_load_and_moment() {
    for (pair, solver) in shipped() {
        for [tau, m, torque] in points(&pair) {
            let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
            let here = problem.solve_torque(torque, m, None).unwrap();
            let solve = |d: f64, m: f64| problem.solve_approach(d, m, Some(&here)).unwrap();
            let d = 1e-4 * (here.approach - problem.no_load_approach(m));
            let dm = d / 10e-3;
            let slopes = |d: f64, dm: f64, step: f64| {
                let [a, b] = [1.0, -1.0].map(|side| solve(here.approach + side * d, m + side * dm));
                [a.loa_force - b.loa_force, a.moment - b.moment].map(|by| by / (2.0 * step))
            };
            let (by_approach, by_misalignment) = (slopes(d, 0.0, d), slopes(0.0, dm, dm));
            let t = &here.tangent;
            for (exact, numeric, lever) in [
                (t.force_by_approach, by_approach[0], 1.0),
                (t.force_by_misalignment, by_approach[1], 1e-2),
                (t.force_by_misalignment, by_misalignment[0], 1e-2),
                (t.moment_by_misalignment, by_misalignment[1], 1e-4),
            ] {
                let error = (exact - numeric).abs() / (lever * t.force_by_approach);
                assert!(error < 2e-3, "{} {tau}: {exact} {numeric}", pair.name);
            }
        }
    }
}

#[test]
fn forces_of_segments_change_with_approach_and_misalignment_by_their_slopes() {
    let plastic: Value = serde_json::from_str(PLASTIC).unwrap();
    let soft = pair::from_json(&plastic["cases"]["plastic"]["pair"].to_string()).unwrap();
    let torque = 0.5 * soft.operating.nominal_torque;
    let soft_solver = coarse_solver(&soft, with_stations(8));
    let mut solved: Vec<_> = shipped()
        .map(|(pair, solver)| (points(&pair)[1], solver))
        .collect();
    solved.push(([0.25, 0.0, torque], soft_solver.clone()));
    solved.push(([0.55, 0.0, torque], soft_solver));
    for ([tau, m, torque], solver) in solved {
        let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
        let here = problem.solve_torque(torque, m, None).unwrap();
        let d = 1e-4 * (here.approach - problem.no_load_approach(m));
        let dm = d / 10e-3;
        for (number, [d, dm], step) in [(0, [d, 0.0], d), (1, [0.0, dm], dm)] {
            let [a, b] = [1.0, -1.0].map(|side| {
                let (approach, tilt) = (here.approach + side * d, m + side * dm);
                problem.solve_approach(approach, tilt, Some(&here)).unwrap()
            });
            let largest = here.segments.iter().map(|s| s.slopes[number].abs());
            let largest = largest.fold(0.0, f64::max);
            for (i, segment) in here.segments.iter().enumerate() {
                let found = (a.segments[i].force - b.segments[i].force) / (2.0 * step);
                let error = (segment.slopes[number] - found) / largest;
                assert!(error.abs() < 5e-3, "{tau} {number} {i}: {error}");
            }
        }
    }
}

#[test]
fn load_rises_with_the_approach_from_zero_at_first_touch() {
    for (pair, solver) in shipped() {
        for [tau, m, torque] in points(&pair) {
            let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
            let first = problem.no_load_approach(m);
            let top = problem.solve_torque(torque, m, None).unwrap().approach;
            let mut last = problem.solve_approach(first, m, None).unwrap();
            assert_eq!(last.loa_force, 0.0);
            for i in 1..=40 {
                let approach = first + (top - first) * f64::from(i) / 40.0;
                let next = problem.solve_approach(approach, m, Some(&last)).unwrap();
                assert!(next.loa_force > last.loa_force, "{} {tau}", pair.name);
                last = next;
            }
            let rb = pair.geometry.gears[0].base_radius();
            assert!((last.loa_force * rb / torque - 1.0).abs() < 1e-8);
        }
    }
}

#[test]
fn forces_balance_the_load_and_meet_the_contact_conditions_whatever_the_start() {
    let mut most = 0;
    for (pair, solver) in shipped() {
        let rb = pair.geometry.gears[0].base_radius();
        for [tau, m, torque] in points(&pair) {
            for offset in pair.operating.center_distance_offset {
                let problem = solver.position(Flank::Drive, tau, offset).unwrap();
                let cold = problem.solve_torque(torque, m, None).unwrap();
                let far = problem.solve_torque(1e-4 * torque, -m, None).unwrap();
                let warm = problem.solve_torque(torque, m, Some(&far)).unwrap();
                for result in [&cold, &far, &warm] {
                    assert!(result.kkt_residual < 1e-8, "{:e}", result.kkt_residual);
                    assert!(result.segments.iter().all(|s| s.force >= 0.0));
                    most = most.max(result.iterations);
                }
                assert!((cold.loa_force * rb / torque - 1.0).abs() < 1e-12);
                assert!((cold.approach - warm.approach).abs() < 1e-9 * cold.approach.abs());
                let shared: f64 = cold.load_share.iter().map(|(_, share)| share).sum();
                assert!((shared - 1.0).abs() < 1e-12);
            }
        }
    }
    assert!(most <= 20, "{most} Newton steps");
}

#[test]
fn ste_is_continuous_over_the_mesh_position() {
    for tip_corner_contact in [true, false] {
        for text in SHIPPED {
            let pair = pair::from_json(text).unwrap();
            // A spur pair without tip corners hands over at once, as its line contact does; only a
            // helical one is continuous then.
            if !tip_corner_contact && pair.geometry.base_helix_angle() == 0.0 {
                continue;
            }
            let settings = ContactSettings {
                tip_corner_contact,
                ..with_stations(12)
            };
            let solver = coarse_solver(&pair, settings);
            let ste = |tau: f64| {
                let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
                let result = problem.solve_torque(pair.operating.nominal_torque, 0.0, None);
                result.unwrap().approach
            };
            for i in 0..60 {
                let tau = f64::from(i) / 60.0;
                let step = ste(tau + 1e-7) - ste(tau);
                assert!(step.abs() < 1e-10, "{} {tau}: {step}", pair.name);
            }
        }
    }
}

#[test]
fn a_pressure_is_that_of_a_line_however_short_the_piece_that_the_end_of_the_path_cuts_off() {
    let gear = |teeth: u32, shift: f64| json!({ "teeth": teeth, "profile_shift": shift, "face_width_mm": 4.0 });
    let file = json!({
        "name": "small", "meshing": "external", "normal_module_mm": 0.3, "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": 10.0, "gear1": gear(12, 0.3), "gear2": gear(40, 0.0),
        "operating": {
            "nominal_torque_nm": 0.3, "maximum_torque_nm": 0.45,
            "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0],
        },
    });
    let pair = pair::from_json(&file.to_string()).unwrap();
    let settings = ContactSettings {
        tip_corner_contact: false,
        ..ContactSettings::default()
    };
    let solver = coarse_solver(&pair, settings);
    let at = |tau: f64| {
        let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
        problem.solve_torque(0.3, 0.0, None).unwrap()
    };
    // Contact lines come in at the first place of the passage and go out at the last; within it they are longer and longer.
    let [first, last] = solver.passage(0.0).unwrap();
    let whole = [at(first + 0.1), at(last - 0.1)];
    for beyond in (-9..-1).map(|power| 10.0f64.powi(power)) {
        for (place, whole) in [first + beyond, last - beyond].into_iter().zip(&whole) {
            let result = at(place);
            let ratio = result.max_pressure / whole.max_pressure;
            assert!((0.3..1.5).contains(&ratio), "{beyond}: {ratio}");
            let edge = |result: &ContactResult| result.edge_load.map_or(0.0, |edge| edge.line_load);
            let mean = 0.3 / pair.geometry.gears[0].base_radius() / 4e-3;
            assert!(edge(&result) < 5.0 * mean, "{beyond}: {}", edge(&result));
        }
    }
}

#[test]
fn unusable_numbers_are_refused_by_name() {
    let (pair, solver) = shipped().next().unwrap();
    let position = |tau, offset| solver.position(Flank::Drive, tau, offset).err();
    let problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
    let under = |torque, m| problem.solve_torque(torque, m, None).err();
    let much = 20.0 * pair.operating.maximum_torque;
    for (error, parts) in [
        (position(f64::NAN, 0.0), &["mesh_position"][..]),
        (position(0.0, f64::INFINITY), &["center_distance_offset"]),
        (position(0.0, 0.02), &["leaves no path of contact"]),
        (under(-1.0, 0.0), &["torque"]),
        (under(1.0, f64::NAN), &["misalignment"]),
        (
            problem.solve_approach(f64::NAN, 0.0, None).err(),
            &["approach"],
        ),
        (
            under(much, 0.0),
            &[
                "torque = 4000 N m",
                "misalignment = 0 mrad",
                "tip edges were followed",
                "lower torque or misalignment",
                "operating.maximum_torque_nm",
            ],
        ),
    ] {
        let text = error.unwrap().to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}

#[test]
fn loads_that_no_tooth_can_carry_and_teeth_that_the_elastic_model_does_not_know_are_refused() {
    let pair = pair::from_json(PAPER).unwrap();
    let settings = ContactSettings {
        followed_approach: Some(0.1),
        ..ContactSettings::default()
    };
    let problem = coarse_solver(&pair, settings).position(Flank::Drive, 0.2, 0.0);
    let carried = problem.unwrap().solve_torque(1e6, 1e-3, None);
    let alone = Settings::new(Refinement::Coarse, 0);
    let solver = solver(&pair, &alone, None, ContactSettings::default());
    let apart = solver.position(Flank::Drive, 0.5, 80e-6);
    for (error, parts) in [
        (
            carried.err(),
            &[
                "torque = 1000000 N m, misalignment = 1 mrad",
                "a contact pressure of",
            ][..],
        ),
        (
            apart.err(),
            &[
                "center distance offset = 80 um",
                "1 teeth apart",
                "operating.center_distance_offset_um",
            ],
        ),
    ] {
        let text = error.unwrap().to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}
