//! Contact at run time against the solve that tables come from, and against itself.

use super::*;

const PAIRS: [&str; 3] = [PAPER, SPUR, RING];
const FLANKS: [Flank; 3] = [Flank::Drive, Flank::Drive, Flank::Coast];

fn ready(text: &str, flank: Flank) -> Ready {
    Ready::new(text, flank, |pair| {
        coarse_solver(pair, with_stations(16)).at_run_time()
    })
}

/// A point of the pair's range: approach, centre distance offset, misalignment, mesh position, and the problem there with its solution.
fn point(ready: &Ready, random: &mut Random) -> ([f64; 4], PositionProblem, ContactResult) {
    let operating = &ready.pair.operating;
    // Differences stay within the range of the condensed model, whose ends are held beyond it.
    let offset = random.within(operating.center_distance_offset.map(|end| 0.999 * end));
    let misalignment = random.within(operating.misalignment);
    let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
    let tau = random.within([0.0, 1.0]);
    let problem = ready.solver.position(ready.flank, tau, offset).unwrap();
    let result = problem.solve_torque(torque, misalignment, None).unwrap();
    let at = [result.approach, offset, misalignment, tau];
    (at, problem, result)
}

/// The root mean square and the largest of `errors` are within `bounds`.
fn assert_small(errors: &[f64], bounds: [f64; 2]) {
    let (rms, most) = (rms(errors), most(errors));
    assert!(rms < bounds[0] && most < bounds[1], "{rms} {most}");
}

/// Random points of the whole range, solved again by the elastic models; root stress at some of them.
#[test]
fn the_solve_at_run_time_and_its_root_stress_are_those_of_the_elastic_models() {
    for (text, flank) in PAIRS.into_iter().zip(FLANKS) {
        let mut ready = ready(text, flank);
        let models = root_models(&ready.pair, flank);
        let roots = condensed_roots(&ready.solver, flank, &models).unwrap();
        Arc::make_mut(&mut ready.condensed).roots = Some(roots);
        let file = ContactFile {
            setup: Arc::new(ready.solver.setup().clone()),
            drive: ready.condensed.clone(),
            coast: None,
            error: None,
        };
        let file = ContactFile::from_bytes(&file.to_bytes()).unwrap();
        let contact = RuntimeContact::new(file.setup, file.drive, flank).with_root_stress();
        let mut random = Random::new(3);
        let half_face = 0.5 * ready.pair.geometry.face_overlap().1;
        let (mut loads, mut stresses) = (vec![], vec![]);
        for n in 0..60 {
            let (at, problem, result) = point(&ready, &mut random);
            let found = ask(&contact, at, [0; 2]);
            let force = found.gradient[0] / result.loa_force - 1.0;
            let lever = (found.gradient[2] - result.moment) / (result.loa_force * half_face);
            loads.push(force.abs().max(lever.abs()));
            if n < 25 {
                let direct = PositionRoots::new(&problem, &models).largest(&result);
                let ratios = found.root_stress.into_iter().zip(direct.unwrap());
                stresses.extend(ratios.map(|(found, direct)| found / direct - 1.0));
            }
        }
        assert_small(&loads, [1e-3, 5e-3]);
        assert_small(&stresses, [3e-3, 0.01]);
    }
}

#[test]
fn flanks_that_close_by_a_hair_are_solved_as_far_as_rounding_lets_them() {
    let contact = ready(PAPER, Flank::Coast).alike();
    for i in 0..12 {
        let tau = 0.03 + f64::from(i) / 12.0;
        let force = |approach: f64| ask(&contact, [approach, 0.0, 0.0, tau], [0; 2]).gradient[0];
        let [_, touching] = bracket([0.0, 20e-6], 60, |approach| force(approach) == 0.0);
        // A thousandth of the force of a micrometre would be far too much.
        let found = force(touching);
        assert!((0.0..1e-3).contains(&found), "{tau}: {found} at {touching}");
    }
}

#[test]
fn a_warm_start_changes_nothing_but_rounding_and_cycles_follow_on_each_other() {
    let ready = ready(PAPER, Flank::Drive);
    let contact = ready.alike();
    let mut random = Random::new(5);
    let mut warm = Warm::default();
    let assert_same = |found: &ContactPotential, cold: &ContactPotential, epsilon: f64| {
        for (k, lever) in [(0, 1.0), (2, 1e-2)] {
            let scale = lever * cold.gradient[0];
            assert!((found.gradient[k] - cold.gradient[k]).abs() <= epsilon * scale);
        }
    };
    for _ in 0..30 {
        let (at, ..) = point(&ready, &mut random);
        // Warm from wherever the last point was.
        let walked = contact.potential(at, [0; 2], &mut warm).unwrap();
        let cold = ask(&contact, at, [0; 2]);
        assert_same(&walked, &cold, 1e-11);
        let [approach, offset, misalignment, position] = at;
        let next = [approach, offset, misalignment, position + 1.0];
        assert_same(&ask(&contact, next, [0; 2]), &cold, 1e-9);
    }
    // A path in steps as small as those of a simulation, along which forces are moved on from pose to pose.
    let (mut at, ..) = point(&ready, &mut random);
    for _ in 0..40 {
        at = [1.002 * at[0], at[1], 0.999 * at[2], at[3] + 2e-3];
        let walked = contact.potential(at, [0; 2], &mut warm).unwrap();
        assert_same(&walked, &ask(&contact, at, [0; 2]), 1e-11);
    }
    // Out of contact there is nothing.
    let apart = contact.potential([-1e-4, 0.0, 0.0, 0.3], [0; 2], &mut warm);
    assert_eq!(apart.unwrap(), ContactPotential::default());
    assert_eq!(warm, Warm::default());
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
    let solver = coarse_solver(&pair, contact_settings(&pair)).at_run_time();
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
        let mut force = || {
            let found = contact.potential(at, [0; 2], &mut warm);
            found.unwrap().gradient[0]
        };
        let first = force();
        for _ in 0..3 {
            assert_relative_eq!(force(), first, max_relative = 1e-9);
        }
    }
}

#[test]
fn few_stations_at_run_time_say_what_many_do() {
    for (text, bound) in [(PAPER, 1e-3), (RING, 2e-3)] {
        let pair = pair::from_json(text).unwrap();
        let solver = |stations| coarse_solver(&pair, with_stations(stations));
        let (few, many) = (solver(40).at_run_time(), solver(160));
        assert!(few.settings().stations < 24);
        let operating = &pair.operating;
        let nominal = operating.nominal_torque / pair.geometry.gears[0].base_radius();
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let mut random = Random::new(9);
        let (mut forces, mut moments) = (vec![], vec![]);
        for _ in 0..30 {
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let [a, b] = [&many, &few].map(|s| s.position(Flank::Drive, tau, 0.0).unwrap());
            let exact = a.solve_torque(torque, misalignment, None).unwrap();
            let found = b.solve_approach(exact.approach, misalignment, None);
            let found = found.unwrap();
            forces.push((found.loa_force - exact.loa_force) / nominal);
            moments.push((found.moment - exact.moment) / (nominal * half_face));
        }
        for errors in [forces, moments] {
            assert_small(&errors, [bound, f64::INFINITY]);
        }
    }
}
