//! Energy, monotony, equilibrium and refusals.

use super::*;
use gearmesh::pair::Refinement;
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings};

const SHIPPED: [&str; 4] = [PAPER, HELICAL, RING, SPUR];

fn shipped() -> impl Iterator<Item = (Pair, ContactSolver)> {
    SHIPPED.iter().map(|text| {
        let pair = pair::from_json(text).unwrap();
        let solver = coarse_solver(&pair, ContactSettings::default());
        (pair, solver)
    })
}

/// Positions, and misalignments and torques as fractions of the pair's limits.
const POINTS: [(f64, f64, f64); 4] = [
    (0.0, 0.0, 0.5),
    (0.23, 0.3, 0.2),
    (0.5, -0.6, 1.0),
    (0.81, 1.0, 0.05),
];

fn at(pair: &Pair, point: (f64, f64, f64)) -> (f64, f64, f64) {
    let o = &pair.operating;
    (
        point.0,
        point.1 * o.misalignment[1],
        point.2 * o.maximum_torque,
    )
}

#[test]
fn tangents_are_the_derivatives_of_load_and_moment() {
    for (pair, solver) in shipped() {
        for point in POINTS {
            let (tau, m, torque) = at(&pair, point);
            let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
            let here = problem.solve_torque(torque, m, None).unwrap();
            let solve = |d: f64, m: f64| problem.solve_approach(d, m, Some(&here)).unwrap();
            let d = 1e-4 * (here.approach - problem.no_load_approach(m));
            let (a, b) = (solve(here.approach + d, m), solve(here.approach - d, m));
            let by_approach = (a.loa_force - b.loa_force) / (2.0 * d);
            let moment_by_approach = (a.moment - b.moment) / (2.0 * d);
            let dm = d / 10e-3;
            let (a, b) = (solve(here.approach, m + dm), solve(here.approach, m - dm));
            let by_misalignment = (a.loa_force - b.loa_force) / (2.0 * dm);
            let moment_by_misalignment = (a.moment - b.moment) / (2.0 * dm);
            let t = &here.tangent;
            let scale = t.force_by_approach;
            for (exact, numeric, scale) in [
                (t.force_by_approach, by_approach, scale),
                (t.force_by_misalignment, moment_by_approach, 1e-2 * scale),
                (t.force_by_misalignment, by_misalignment, 1e-2 * scale),
                (
                    t.moment_by_misalignment,
                    moment_by_misalignment,
                    1e-4 * scale,
                ),
            ] {
                let error = (exact - numeric).abs() / scale;
                assert!(error < 2e-3, "{} {point:?}: {exact} {numeric}", pair.name);
            }
        }
    }
}

#[test]
fn load_rises_with_the_approach_from_zero_at_first_touch() {
    for (pair, solver) in shipped() {
        for point in POINTS {
            let (tau, m, torque) = at(&pair, point);
            let problem = solver.position(Flank::Drive, tau, 0.0).unwrap();
            let first = problem.no_load_approach(m);
            let top = problem.solve_torque(torque, m, None).unwrap().approach;
            let mut last = problem.solve_approach(first, m, None).unwrap();
            assert_eq!(last.loa_force, 0.0);
            for i in 1..=40 {
                let approach = first + (top - first) * f64::from(i) / 40.0;
                let next = problem.solve_approach(approach, m, Some(&last)).unwrap();
                assert!(next.loa_force > last.loa_force, "{} {point:?}", pair.name);
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
        for point in POINTS {
            let (tau, m, torque) = at(&pair, point);
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
            let settings = ContactSettings {
                tip_corner_contact,
                stations: 12,
                ..Default::default()
            };
            let solver = coarse_solver(&pair, settings);
            let ste = |tau: f64| {
                solver
                    .position(Flank::Drive, tau, 0.0)
                    .unwrap()
                    .solve_torque(pair.operating.nominal_torque, 0.0, None)
                    .unwrap()
                    .approach
            };
            // A spur pair without tip corners hands over at once, as its line contact does; only a
            // helical one is continuous then.
            if !tip_corner_contact && pair.geometry.base_helix_angle() == 0.0 {
                continue;
            }
            for i in 0..60 {
                let tau = f64::from(i) / 60.0;
                let step = ste(tau + 1e-7) - ste(tau);
                assert!(step.abs() < 1e-10, "{} {tau}: {step}", pair.name);
            }
        }
    }
}

#[test]
fn unusable_numbers_are_refused_by_name() {
    let (pair, solver) = shipped().next().unwrap();
    let message = |error: ContactError| error.to_string();
    let problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
    for (error, name) in [
        (
            solver.position(Flank::Drive, f64::NAN, 0.0).err(),
            "mesh_position",
        ),
        (
            solver.position(Flank::Drive, 0.0, f64::INFINITY).err(),
            "center_distance_offset",
        ),
        (problem.solve_torque(-1.0, 0.0, None).err(), "torque"),
        (
            problem.solve_torque(1.0, f64::NAN, None).err(),
            "misalignment",
        ),
        (
            problem.solve_approach(f64::NAN, 0.0, None).err(),
            "approach",
        ),
    ] {
        let text = message(error.unwrap());
        assert!(text.contains(name), "{text}");
    }
    let far = solver.position(Flank::Drive, 0.0, 0.02).err().unwrap();
    assert!(matches!(far, ContactError::OutOfMesh { .. }), "{far}");
    let much = problem.solve_torque(20.0 * pair.operating.maximum_torque, 0.0, None);
    assert!(
        matches!(
            much,
            Err(ContactError::Unsolved {
                failure: Failure::BeyondReach { .. },
                ..
            })
        ),
        "{much:?}"
    );
    let text = message(much.unwrap_err());
    for part in [
        "torque = 4000 N m",
        "misalignment = 0 mrad",
        "lower torque or misalignment",
        "operating.maximum_torque_nm",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn loads_that_no_tooth_can_carry_are_refused_with_their_torque() {
    let (pair, _) = shipped().next().unwrap();
    let settings = ContactSettings {
        reach: Some(0.1),
        ..ContactSettings::default()
    };
    let solver = coarse_solver(&pair, settings);
    let problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
    let error = problem.solve_torque(1e6, 1e-3, None).unwrap_err();
    assert!(
        matches!(
            error,
            ContactError::Unsolved {
                failure: Failure::Overload { .. },
                ..
            }
        ),
        "{error}"
    );
    let text = error.to_string();
    assert!(
        text.starts_with("torque = 1000000 N m, misalignment = 1 mrad"),
        "{text}"
    );
}

#[test]
fn teeth_that_the_elastic_model_does_not_know_are_refused_with_the_center_distance() {
    let (pair, _) = shipped().next().unwrap();
    let alone = Settings::new(Refinement::Coarse, 0);
    let [first, second] = PairCompliance::new(&pair.geometry, &alone, None, &|_, _, _| true)
        .unwrap()
        .gears;
    let solver = ContactSolver::new(&pair, [first, second], ContactSettings::default()).unwrap();
    let text = match solver.position(Flank::Drive, 0.5, 80e-6) {
        Err(error) => error.to_string(),
        Ok(_) => String::from("accepted"),
    };
    for part in [
        "center distance offset = 80 um",
        "1 teeth apart",
        "operating.center_distance_offset_um",
    ] {
        assert!(text.contains(part), "{text}");
    }
}
