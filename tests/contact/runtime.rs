//! Contact at run time against the solve that tables come from, and against itself.

use super::*;
use gearmesh_preprocessor::finite_element::{Settings, pair_root_stress};

const PAIRS: [&str; 3] = [PAPER, SPUR, RING];

/// A pair, its solver on coarse finite elements and its condensed model on `flank`.
fn condensed(text: &str, flank: Flank) -> (Pair, ContactSolver, CondensedFlank) {
    let pair = pair::from_json(text).unwrap();
    let solver = coarse_solver(&pair, with_stations(16)).at_run_time();
    let [low, high] = pair.operating.center_distance_offset;
    let condensed = condensed_flank(&solver, flank, &[low, 0.5 * (low + high), high]).unwrap();
    (pair, solver, condensed)
}

/// A pair, its solver on coarse finite elements and its contact at run time on `flank`.
fn ready(text: &str, flank: Flank) -> (Pair, ContactSolver, RuntimeContact) {
    let (pair, solver, condensed) = condensed(text, flank);
    let setup = Arc::new(solver.setup().clone());
    let contact = RuntimeContact::new(setup, Arc::new(condensed), flank);
    (pair, solver, contact)
}

/// A point of the pair's range: approach, centre distance offset, misalignment, mesh position, and the solution.
fn point(
    pair: &Pair,
    solver: &ContactSolver,
    flank: Flank,
    random: &mut Random,
) -> ([f64; 4], ContactResult) {
    // Differences stay within the range of the condensed model, whose ends are held beyond it.
    let offset = random.within(pair.operating.center_distance_offset.map(|end| 0.999 * end));
    let misalignment = random.within(pair.operating.misalignment);
    let torque = random.within([0.1, 1.0]) * pair.operating.maximum_torque;
    let tau = random.within([0.0, 1.0]);
    let problem = solver.position(flank, tau, offset).unwrap();
    let result = problem.solve_torque(torque, misalignment, None).unwrap();
    ([result.approach, offset, misalignment, tau], result)
}

#[test]
fn the_solve_at_run_time_is_that_of_the_tables() {
    for (text, flank) in PAIRS
        .into_iter()
        .zip([Flank::Drive, Flank::Drive, Flank::Coast])
    {
        let (pair, solver, contact) = ready(text, flank);
        let mut random = Random::new(3);
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let (mut square, mut largest, n) = (0.0, 0.0f64, 60);
        for _ in 0..n {
            let (at, result) = point(&pair, &solver, flank, &mut random);
            let found = contact.potential(at, [0; 2], &mut Warm::default()).unwrap();
            let force = found.gradient[0] / result.loa_force - 1.0;
            let lever = (found.gradient[2] - result.moment) / (result.loa_force * half_face);
            let error = force.abs().max(lever.abs());
            square += error * error;
            largest = largest.max(error);
        }
        let rms = (square / f64::from(n)).sqrt();
        println!("{}: rms {rms:.2e}, largest {largest:.2e}", pair.name);
        assert!(
            rms < 1e-3 && largest < 5e-3,
            "{}: {rms} {largest}",
            pair.name
        );
    }
}

/// Random points of the whole range, solved again by both elastic models at every point.
#[test]
fn root_stress_at_run_time_is_that_of_the_elastic_models() {
    for (text, flank) in PAIRS
        .into_iter()
        .zip([Flank::Drive, Flank::Drive, Flank::Coast])
    {
        let (mut pair, solver, condensed) = condensed(text, flank);
        pair.refinement = gearmesh::pair::Refinement::Coarse;
        let elastic = Settings::for_pair(&pair);
        let models = pair_root_stress(&pair.geometry, flank, &elastic, None, &|_, _, _| true);
        let models = models.unwrap().map(|(model, _)| model);
        let roots = condensed_roots(&solver, flank, &models).unwrap();
        let condensed = Arc::new(CondensedFlank {
            roots: Some(roots),
            ..condensed
        });
        let file = ContactFile {
            setup: Arc::new(solver.setup().clone()),
            drive: condensed,
            coast: None,
            error: None,
        };
        let file = ContactFile::from_bytes(&file.to_bytes()).unwrap();
        let contact = RuntimeContact::new(file.setup, file.drive, flank).with_root_stress();
        let mut random = Random::new(5);
        let (mut square, mut largest, n) = (0.0, 0.0f64, 25);
        for _ in 0..n {
            let (at, result) = point(&pair, &solver, flank, &mut random);
            let problem = solver.position(flank, at[3], at[1]).unwrap();
            let direct = PositionRoots::new(&problem, &models);
            let direct = direct.largest(&result).unwrap();
            let found = contact.potential(at, [0; 2], &mut Warm::default()).unwrap();
            for (found, known) in found.root_stress.iter().zip(direct) {
                let error = found / known - 1.0;
                square += error * error;
                largest = largest.max(error.abs());
            }
        }
        let rms = (square / f64::from(2 * n)).sqrt();
        println!("{}: rms {rms:.2e}, largest {largest:.2e}", pair.name);
        assert!(rms < 0.003 && largest < 0.01, "{rms} {largest}");
    }
}

#[test]
fn flanks_that_close_by_a_hair_are_solved_as_far_as_rounding_lets_them() {
    let (_, _, contact) = ready(PAIRS[0], Flank::Coast);
    for i in 0..12 {
        let tau = 0.03 + f64::from(i) / 12.0;
        let of = |approach: f64| {
            let at = [approach, 0.0, 0.0, tau];
            contact.potential(at, [0; 2], &mut Warm::default())
        };
        let (mut apart, mut touching) = (0.0, 20e-6);
        while touching - apart > f64::EPSILON * touching {
            let middle = 0.5 * (apart + touching);
            match of(middle).unwrap().gradient[0] > 0.0 {
                true => touching = middle,
                false => apart = middle,
            }
        }
        // A thousandth of the force of a micrometre would be far too much.
        let force = of(touching).unwrap().gradient[0];
        assert!(
            (0.0..1e-3).contains(&force),
            "{tau}: {force} N at {touching} m"
        );
    }
}

#[test]
fn a_warm_start_changes_nothing_but_rounding_and_cycles_follow_on_each_other() {
    let (pair, solver, contact) = ready(PAIRS[0], Flank::Drive);
    let mut random = Random::new(5);
    let mut warm = Warm::default();
    for _ in 0..30 {
        let (at, _) = point(&pair, &solver, Flank::Drive, &mut random);
        // Warm from wherever the last point was.
        let walked = contact.potential(at, [0; 2], &mut warm).unwrap();
        let cold = contact.potential(at, [0; 2], &mut Warm::default()).unwrap();
        let mut next = at;
        next[3] += 1.0;
        let later = contact
            .potential(next, [0; 2], &mut Warm::default())
            .unwrap();
        for k in [0, 2] {
            let scale = cold.gradient[0] * [1.0, 0.0, 1e-2, 0.0][k];
            assert!((walked.gradient[k] - cold.gradient[k]).abs() <= 1e-11 * scale);
            assert!((later.gradient[k] - cold.gradient[k]).abs() <= 1e-9 * scale);
        }
    }
    // A path in steps as small as those of a simulation, along which forces are moved on from pose to pose.
    let (mut at, _) = point(&pair, &solver, Flank::Drive, &mut random);
    for _ in 0..40 {
        at = [1.002 * at[0], at[1], 0.999 * at[2], at[3] + 2e-3];
        let walked = contact.potential(at, [0; 2], &mut warm).unwrap();
        let cold = contact.potential(at, [0; 2], &mut Warm::default()).unwrap();
        for k in [0, 2] {
            let scale = cold.gradient[0] * [1.0, 0.0, 1e-2, 0.0][k];
            assert!((walked.gradient[k] - cold.gradient[k]).abs() <= 1e-11 * scale);
        }
    }
    // Out of contact there is nothing.
    let apart = contact
        .potential([-1e-4, 0.0, 0.0, 0.3], [0; 2], &mut warm)
        .unwrap();
    assert_eq!(
        (apart, warm),
        (ContactPotential::default(), Warm::default())
    );
}

#[test]
fn far_beyond_the_centre_distances_of_the_nodes_loads_are_still_numbers() {
    for text in PAIRS {
        let (_, _, contact) = ready(text, Flank::Drive);
        for i in 0..40 {
            let nearer = 5e-5 * f64::from(i);
            // As at turned gears that are held: what is nearer closes the gap.
            let at = [0.34 * nearer, -nearer, 1e-4, 0.07 * f64::from(i)];
            let Ok(found) = contact.potential(at, [0; 2], &mut Warm::default()) else {
                panic!("{at:?}");
            };
            let numbers = found.gradient.iter().chain([&found.energy]);
            assert!(numbers.into_iter().all(|v| v.is_finite()), "{found:?}");
        }
    }
}

#[test]
fn a_pose_that_is_solved_is_solved_again_from_its_own_forces() {
    // At some poses rounding leaves no whole step that lessens anything.
    let text = r#"{ "name": "again", "meshing": "external", "normal_module_mm": 2.0, "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": 20.0, "backlash_um": 50, "face_offset_mm": -1.0,
        "gear1": { "teeth": 19, "face_width_mm": 20, "profile_shift": 0.2, "lead_crowning_um": 5,
            "tip_relief": { "amount_um": 15, "start": "pitch_point", "shape": "linear" },
            "drive_flank": { "lead_slope_um": 6, "bias_um": 4 },
            "tooth_errors": { "drive_flank": { "pitch_class": 6, "seed": 2 }, "runout_um": 8 } },
        "gear2": { "teeth": 41, "face_width_mm": 17, "profile_shift": 0.1,
            "tooth_errors": { "drive_flank": { "pitch_class": 5 } } },
        "operating": { "nominal_torque_nm": 60, "maximum_torque_nm": 120,
            "center_distance_offset_um": [0, 0], "misalignment_mrad": [-1.5, 1.0] } }"#;
    let pair = pair::from_json(text).unwrap();
    let solver = coarse_solver(&pair, ContactSettings::for_pair(&pair)).at_run_time();
    let contact = contact_file(&pair, &solver).unwrap();
    let contact = contact.flank(Flank::Drive).unwrap();
    let mut random = Random::new(2);
    for _ in 0..6000 {
        let at = [
            random.within([0.0, 15e-6]),
            0.0,
            random.within([-5e-4, 5e-4]),
            random.within([0.0, 100.0]),
        ];
        let mut warm = Warm::default();
        let first = contact.potential(at, [0; 2], &mut warm).unwrap();
        for _ in 0..3 {
            let again = contact.potential(at, [0; 2], &mut warm).unwrap();
            let difference = again.gradient[0] - first.gradient[0];
            assert!(difference.abs() <= 1e-9 * first.gradient[0].abs());
        }
    }
}

#[test]
fn few_stations_at_run_time_say_what_many_do() {
    let pairs = [(PAPER, 1e-3), (RING, 2e-3)];
    for (text, bound) in pairs {
        let pair = pair::from_json(text).unwrap();
        let solver = |stations| coarse_solver(&pair, with_stations(stations));
        let (few, many) = (solver(40).at_run_time(), solver(160));
        assert!(few.settings().stations < 24);
        let operating = &pair.operating;
        let nominal = operating.nominal_torque / pair.geometry.gears[0].base_radius();
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let (mut random, poses) = (Random::new(9), 30);
        let mut squares = [0.0; 2];
        for _ in 0..poses {
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let [a, b] = [&many, &few].map(|s| s.position(Flank::Drive, tau, 0.0).unwrap());
            let exact = a.solve_torque(torque, misalignment, None).unwrap();
            let found = b
                .solve_approach(exact.approach, misalignment, None)
                .unwrap();
            squares[0] += ((found.loa_force - exact.loa_force) / nominal).powi(2);
            squares[1] += ((found.moment - exact.moment) / (nominal * half_face)).powi(2);
        }
        let rms = squares.map(|sum| (sum / f64::from(poses)).sqrt());
        println!("{}: {rms:?}", pair.name);
        assert!(rms.iter().all(|rms| *rms < bound), "{}: {rms:?}", pair.name);
    }
}
