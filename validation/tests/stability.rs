//! The headline figures of docs/validation.md, by the code that finds them.

mod energy {
    use gearmesh::element::{Formulation, Interpolation};
    use gearmesh_validation::stability::energy::*;

    #[test]
    fn a_gear_in_six_freedoms_keeps_its_energy_in_the_conjugate_formulation_alone() {
        let drift = |formulation| {
            let parameters = choice(formulation, Interpolation::Spline);
            long_run(&Case::sampled(), parameters, 40_000).unwrap()
        };
        let conjugate = drift(Formulation::Conjugate);
        let paper = drift(Formulation::Paper);
        assert_eq!(conjugate.steps, 40_000);
        assert!(
            conjugate.error < 1e-5,
            "conjugate: {:.1e} of the kinetic energy",
            conjugate.error
        );
        assert!(paper.error > 1e-2, "paper: {:.1e}", paper.error);
    }
}

mod continuity {
    use gearmesh::element::{Formulation, Interpolation, LoadedFlank};
    use gearmesh_validation::stability::Real;
    use gearmesh_validation::stability::continuity::*;
    use nalgebra::Vector3;

    #[test]
    fn a_jump_a_kink_and_a_bend_are_told_apart() {
        // Beside a bend that is much larger over one step of the scan.
        let with = |extra: fn(f64) -> f64| {
            let force = move |x: f64| Ok(Vector3::new(2.0 + (40.0 * x).sin(), extra(x), 1.0));
            Course::of(&force, 500).unwrap()
        };
        assert_eq!(with(|x| x * x), Course::Smooth);
        assert_eq!(with(|x| (x - 0.3).max(0.0).powi(2)), Course::Smooth);
        assert!(
            matches!(with(|x| 0.4 * (x - 0.3217).max(0.0)), Course::Kink(k) if (k / 0.01 - 1.0).abs() < 0.1)
        );
        let step = |x: f64| if x > 0.7123 { 3e-4 } else { 0.0 };
        assert!(matches!(with(step), Course::Jump(j) if (j / 9.5e-5 - 1.0).abs() < 0.1));
    }

    #[test]
    fn on_shipped_tables_spline_and_shepard_jump_nowhere_and_the_linear_force_does_not_over_displacement()
     {
        use Interpolation::{Linear, Shepard, Spline};
        for real in Real::pairs().unwrap() {
            for (formulation, interpolation) in [
                (Formulation::Conjugate, Spline),
                (Formulation::Conjugate, Shepard),
                (Formulation::Paper, Spline),
                (Formulation::Conjugate, Linear),
            ] {
                let law = format!("{formulation:?} {interpolation:?}");
                let subject =
                    subject(&real, formulation, interpolation, LoadedFlank::Both).unwrap();
                for ((path, _), course) in PATHS.iter().zip(subject.course().unwrap()) {
                    println!("{} {law} {path}: {course}", real.name);
                    let linear_elsewhere = interpolation == Linear && *path != PATHS[0].0;
                    assert!(linear_elsewhere || !matches!(course, Course::Jump(_)));
                }
            }
        }
    }
}

mod cosimulation {
    use gearmesh::element::{Element, Parameters};
    use gearmesh::table::{Table, TableFile};
    use gearmesh_validation::data::last_that_holds;
    use gearmesh_validation::driver::{
        CoSimulation, Gear, INERTIA, Master, Scene, Scheme, Spin, State,
    };
    use gearmesh_validation::stability::cosimulation::*;
    use gearmesh_validation::{Result, in_repository};
    use std::sync::Arc;

    /// Angle omega H that packing chooses.
    const PACKED_ANGLE: f64 = 0.4;

    /// Energy that the coupling brings to the undamped shipped pair `name`, over that of the swing it starts with, after `steps` steps
    /// at the packed angle: gear 1 stands, gear 2 swings about its load by a fifth of the deflection.
    fn energy_brought(name: &str, scheme: impl Fn(f64) -> Scheme, steps: usize) -> Result<f64> {
        let file = TableFile::read(in_repository(&format!("resources/tables/{name}.json")))?;
        let (geometry, torque) = (file.geometry.clone(), file.nominal_torque_nm);
        let table = Arc::new(Table::from_file(file)?);
        let parameters = Parameters {
            damping: 0.0,
            nominal_torque: torque,
            center_distance_effect: table.effects.center_distance,
            misalignment_effect: table.effects.misalignment,
            ..Parameters::default()
        };
        let element = Element::new(&geometry, &parameters, Some(table))?;
        let [first, second] = geometry.gears.each_ref().map(|gear| gear.base_radius());
        // Pressed against the drive flank.
        let load = torque * second / first * geometry.e();
        let (still, loaded) = (Spin::speed(0.0), Spin::torque(load));
        let gears = [
            Gear::new(&geometry, 0, still),
            Gear::new(&geometry, 1, loaded),
        ];
        let scene = Scene::new(element, gears)?;
        let pressed = |approach: f64| {
            scene.with_spin(&scene.rest(), 1, geometry.e() * approach / second, 0.0)
        };
        let carries =
            |approach| Ok(scene.contact(0.0, &pressed(approach))?.moment[1].z.abs() >= load.abs());
        let [_, balance] = last_that_holds([1e-3, 0.0], 60, carries)?;
        let cosine = scene.element.line_of_action(geometry.center_distance);
        let stiffness = scene.contact(0.0, &pressed(balance))?.stiffness / cosine.powi(2);
        let mass = INERTIA / second.powi(2);
        let (start, still) = (pressed(1.2 * balance), pressed(balance));
        // The load has a potential, too.
        let energy = |t: f64, state: &State| -> Result<f64> {
            Ok(scene.energy(t, state)? - load * state[1].twist())
        };
        let h = PACKED_ANGLE * (mass / stiffness).sqrt();
        let (least, first) = (energy(0.0, &still)?, energy(0.0, &start)?);
        let swing = first - least;
        let mut run = CoSimulation::new(&scene, scheme(mass), start, h, 4)?;
        for _ in 0..steps {
            run.advance()?;
            if energy(run.time, &run.state)? > least + 100.0 * swing {
                return Ok(f64::INFINITY);
            }
        }
        Ok((energy(run.time, &run.state)? - first) / swing)
    }

    #[test]
    fn held_loads_are_stable_up_to_the_step_of_the_formulas_and_not_beyond() {
        for master in [Master::Sequential, Master::Parallel] {
            for &zeta in &ZETAS[1..] {
                let Some(expected) = expected_limit(master, zeta) else {
                    continue;
                };
                let o = system(zeta).unwrap();
                let at = |h| stable(&o, Scheme::held(master), h).unwrap();
                assert!(at(0.97 * expected), "{master:?}, zeta = {zeta}");
                assert!(!at(1.03 * expected), "{master:?}, zeta = {zeta}");
            }
        }
    }

    #[test]
    fn predicted_loads_take_energy_where_held_loads_bring_it() {
        for name in TABLES {
            for master in [Master::Sequential, Master::Parallel] {
                let found =
                    energy_brought(name, |mass| Scheme::predicted(master, mass), 10_000).unwrap();
                assert!((-1.01..0.0).contains(&found), "{name}, {master:?}: {found}");
                let held = energy_brought(name, |_| Scheme::held(master), 100).unwrap();
                assert!(held > 1.0, "{name}, {master:?}: {held}");
            }
        }
    }
}

mod masters {
    use gearmesh::element::Coupling;
    use gearmesh_validation::driver::Master;
    use gearmesh_validation::stability::cosimulation::TABLES;
    use gearmesh_validation::stability::masters::*;

    /// At 160 packed steps a mesh cycle, under a master that moves the bodies exactly.
    #[test]
    fn predicted_loads_of_a_known_master_are_stable_and_exact_whatever_hangs_on_the_gears() {
        let p = Packed::new(TABLES[2]).unwrap();
        let bodies = systems(&p)
            .into_iter()
            .filter(|b| b.name != "run-up and run-down");
        for bodies in bodies {
            let bar = if bodies.train { 5.0 } else { 1.0 };
            let case = Case::new(&p, bodies, 160.0).unwrap();
            for (master, coupling) in MASTERS {
                let stepping = Stepping::exact(coupling, master, ALIKE);
                let name = format!("{}, {master:?}", case.bodies.name);
                let found = case.errors(stepping).unwrap();
                let found = found.unwrap_or_else(|| panic!("{name}: unstable"));
                assert!(found.take_up < bar, "{name}: {found:?}");
                // Across the backlash the swings of the first impacts outlast the run.
                let crossing = case.bodies.name == "planetary across its backlash";
                let bar = if case.bodies.train { 2.0 } else { 1.0 };
                assert!(found.steady < bar || crossing, "{name}: {found:?}");
            }
        }
    }

    /// Masses from a fifth to ten times the packed one.
    #[test]
    fn without_being_told_the_master_loads_of_lighter_and_heavier_gears_settle_as_those_of_a_known_one()
     {
        let p = Packed::new(TABLES[2]).unwrap();
        for mass in of_masses(&p).unwrap() {
            let errors = |found: Option<Errors>| found.unwrap_or_else(|| panic!("{mass:?}"));
            let [known, found] = [mass.known, mass.automatic].map(errors);
            // Until the master is known held loads set the mesh swinging.
            assert!(found.take_up < known.take_up + 4.0, "{mass:?}");
            assert!(found.steady < known.steady + 2.0, "{mass:?}");
        }
    }

    /// At 160 packed steps a mesh cycle, under a master that moves the bodies exactly, and after what the first steps set swinging.
    #[test]
    fn in_steady_state_approaches_in_trains_are_within_two_percent_of_their_spread_whoever_is_told_the_master()
     {
        let p = Packed::new(TABLES[2]).unwrap();
        for bodies in systems(&p).into_iter().filter(|bodies| bodies.train) {
            let name = bodies.name;
            for (master, coupling, errors) in settling(&p, bodies).unwrap() {
                let [.., settled] = errors.unwrap();
                assert!(settled < 2.0, "{name}, {master:?}, {coupling:?}: {settled}");
            }
        }
    }

    /// At 20 and 160 packed steps a mesh cycle, for each way in which masters let loads act and move the bodies.
    #[test]
    fn without_being_told_the_master_loads_in_trains_are_stable_and_no_worse_than_held_ones() {
        let p = Packed::new(TABLES[2]).unwrap();
        let trains = || systems(&p).into_iter().filter(|bodies| bodies.train);
        let cases = [20.0, 160.0]
            .into_iter()
            .flat_map(|cycle| trains().map(move |bodies| (bodies, cycle)));
        for (bodies, cycle) in cases {
            let case = Case::new(&p, bodies, cycle).unwrap();
            for master in [Master::Sequential, Master::Parallel] {
                let ways = [0.0, 0.5, 1.0].map(|theta| (theta, ALIKE));
                let by_turns = [0.5, 1.0].map(|theta| (theta, BY_TURNS));
                for (theta, steps) in ways.into_iter().chain(by_turns) {
                    let errors = |coupling: Coupling| {
                        let stepping = Stepping {
                            coupling,
                            master,
                            theta,
                            steps,
                            derivatives: false,
                        };
                        case.errors(stepping).unwrap()
                    };
                    let name = format!(
                        "{}, {cycle}, {master:?}, {theta}, {steps:?}",
                        case.bodies.name
                    );
                    let Some(found) = errors(Coupling::Automatic) else {
                        // Explicit Euler's rule feeds the modes of bearings by itself: whatever the unit is told, they swing
                        // ten times what the mesh does, or farther than the run is followed.
                        let others = [Coupling::Held, Coupling::Sequential, Coupling::Parallel];
                        let runs_away = (others.iter()).all(|coupling| {
                            errors(*coupling).is_none_or(|errors| errors.steady > 1e3)
                        });
                        assert!(runs_away && theta == 0.0, "{name}: unstable");
                        continue;
                    };
                    if let Some(held) = errors(Coupling::Held) {
                        let (found, held) = (found.take_up, held.take_up);
                        assert!(found < 1.1 * held, "{name}: {found} {held}");
                    }
                }
            }
        }
    }

    /// Gears that stand take up their load, and nothing damps what they swing.
    #[test]
    fn a_swing_of_a_pair_that_nothing_damps_does_not_grow_in_ten_thousand_steps_under_a_master_that_is_not_known()
     {
        let p = Packed::with_damping(TABLES[2], 0.0).unwrap();
        for master in [Master::Sequential, Master::Parallel] {
            for theta in [0.0, 0.5, 1.0] {
                let stepping = Stepping {
                    coupling: Coupling::Automatic,
                    master,
                    theta,
                    steps: ALIKE,
                    derivatives: false,
                };
                let kept = swing_kept(&p, &Bodies::pair(&p), stepping, 10_000).unwrap();
                let kept = kept.unwrap_or_else(|| panic!("{master:?}, {theta}: unstable"));
                assert!(kept < 1.0, "{master:?}, {theta}: {kept}");
            }
        }
    }

    #[test]
    fn steps_of_unequal_lengths_do_not_keep_the_master_from_being_found() {
        let p = Packed::new(TABLES[2]).unwrap();
        let at_rest = |b: &Bodies| b.name != "planetary across its backlash";
        for bodies in systems(&p).into_iter().filter(at_rest) {
            let bar = if bodies.name == "run-up and run-down" {
                10.0
            } else {
                2.0
            };
            let case = Case::new(&p, bodies, 160.0).unwrap();
            for master in [Master::Sequential, Master::Parallel] {
                let stepping = Stepping::exact(Coupling::Automatic, master, BY_TURNS);
                let found = case.errors(stepping).unwrap();
                let found = found.unwrap_or_else(|| panic!("{}: unstable", case.bodies.name));
                assert!(
                    found.take_up < bar,
                    "{}, {master:?}: {found:?}",
                    case.bodies.name
                );
            }
        }
    }

    #[test]
    fn a_master_that_gives_derivatives_of_its_poses_gets_loads_as_good_as_one_that_does_not() {
        let p = Packed::new(TABLES[2]).unwrap();
        let case = Case::new(&p, Bodies::pair(&p), 160.0).unwrap();
        for master in [Master::Sequential, Master::Parallel] {
            for coupling in [
                Coupling::Automatic,
                Coupling::Sequential,
                Coupling::Parallel,
            ] {
                let fits = |coupling: Coupling| match master {
                    Master::Sequential => coupling != Coupling::Parallel,
                    Master::Parallel => coupling != Coupling::Sequential,
                };
                if !fits(coupling) {
                    continue;
                }
                let stepping = Stepping {
                    coupling,
                    master,
                    theta: 0.5,
                    steps: ALIKE,
                    derivatives: true,
                };
                let found = case.errors(stepping).unwrap();
                let found = found.unwrap_or_else(|| panic!("{master:?}, {coupling:?}: unstable"));
                assert!(found.take_up < 1.0, "{master:?}, {coupling:?}: {found:?}");
            }
        }
    }

    #[test]
    fn along_a_given_motion_automatic_loads_are_held_ones() {
        let p = Packed::new(TABLES[2]).unwrap();
        for steps in STEPS {
            assert_eq!(given(&p, steps, ALIKE).unwrap(), 0.0, "{steps}");
        }
    }
}
