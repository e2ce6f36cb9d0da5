//! The headline figures of docs/stability.md, by the code that finds them.

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
        assert!(matches!(with(|x| 0.4 * (x - 0.3217).max(0.0)), Course::Kink(k) if (k / 0.01 - 1.0).abs() < 0.1));
        let step = |x: f64| if x > 0.7123 { 3e-4 } else { 0.0 };
        assert!(matches!(with(step), Course::Jump(j) if (j / 9.5e-5 - 1.0).abs() < 0.1));
    }

    #[test]
    fn on_shipped_tables_spline_and_shepard_jump_nowhere_and_the_linear_force_does_not_over_displacement() {
        use Interpolation::{Linear, Shepard, Spline};
        for real in Real::pairs().unwrap() {
            for (formulation, interpolation) in [
                (Formulation::Conjugate, Spline),
                (Formulation::Conjugate, Shepard),
                (Formulation::Paper, Spline),
                (Formulation::Conjugate, Linear),
            ] {
                let law = format!("{formulation:?} {interpolation:?}");
                let subject = subject(&real, formulation, interpolation, LoadedFlank::Both).unwrap();
                for ((path, _), course) in PATHS.iter().zip(subject.course().unwrap()) {
                    println!("{} {law} {path}: {course}", real.name);
                    let linear_elsewhere = interpolation == Linear && *path != PATHS[0].0;
                    assert!(
                        linear_elsewhere || !matches!(course, Course::Jump(_)),
                        "{}, {law}, {path}: {course}",
                        real.name
                    );
                }
            }
        }
    }
}

mod cosimulation {
    use gearmesh_validation::driver::{Extrapolation, Master};
    use gearmesh_validation::stability::cosimulation::*;

    #[test]
    fn held_loads_are_stable_up_to_the_step_of_the_formulas_and_not_beyond() {
        for master in [Master::Sequential, Master::Parallel] {
            for zeta in ZETAS {
                let Some(expected) = expected_limit(master, zeta) else {
                    continue;
                };
                let o = system(zeta).unwrap();
                let at = |h| stable(&o, (master, Extrapolation::Hold), h).unwrap();
                assert!(at(0.97 * expected), "{master:?}, zeta = {zeta}");
                assert!(!at(1.03 * expected), "{master:?}, zeta = {zeta}");
            }
        }
    }

    #[test]
    fn input_derivatives_bear_ten_times_the_step_at_usual_damping() {
        let o = system(0.03).unwrap();
        let hold = expected_limit(Master::Sequential, 0.03).unwrap();
        assert!(stable(&o, (Master::Sequential, Extrapolation::Inputs), 10.0 * hold).unwrap());
        assert!(stable(&o, (Master::Sequential, Extrapolation::Outputs), 6.0 * hold).unwrap());
    }
}

mod energy {
    use gearmesh::element::{Formulation, Interpolation};
    use gearmesh_validation::stability::energy::*;

    use Formulation::{Conjugate, Paper};
    use Interpolation::{Linear, Shepard, Spline};

    #[test]
    fn closed_loops_give_nothing_but_in_the_papers_formulation() {
        let case = Case::sampled();
        for interpolation in [Spline, Linear, Shepard] {
            let element = case.element(choice(Conjugate, interpolation)).unwrap();
            let (ratio, Loop { work, energy }) = loops(&element).unwrap();
            assert!(ratio < 1e-9 && work.abs() < 1e-9 * energy, "{interpolation:?}: {ratio}, {work} J");
        }
        let paper = case.element(choice(Paper, Spline)).unwrap();
        let (ratio, Loop { work, .. }) = loops(&paper).unwrap();
        assert!(ratio > 1e-2 && work.abs() > 1e-3, "{ratio}, {work} J");
    }

    #[test]
    fn a_run_in_six_freedoms_keeps_its_energy() {
        let case = Case::sampled();
        for interpolation in [Spline, Shepard] {
            let element = case.element(choice(Conjugate, interpolation)).unwrap();
            let curve = long_run(case.geometry(), element, 20_000).unwrap();
            assert!(worst(&curve) < 1e-6, "{interpolation:?}: {}", worst(&curve));
        }
    }
}

mod oscillator {
    use gearmesh_validation::stability::oscillator::*;

    fn imported(depth: f64, zeta: f64) -> Case {
        Case::imported(depth, zeta).unwrap()
    }

    #[test]
    fn branches_end_where_the_literature_has_the_jumps_and_are_as_high_as_there() {
        let case = imported(0.2, 0.03);
        let rising = sweep(&case, 0.85, 0.91).unwrap();
        let falling = sweep(&case, 0.92, 0.68).unwrap();
        for (curve, frequency, rms) in [(&rising, 0.895, 0.529), (&falling, 0.70, 1.539)] {
            let found = jump(curve);
            assert!((found - frequency).abs() < 0.0051, "{found} for {frequency}");
            let found = at(curve, 0.85);
            assert!((found - rms).abs() < 1e-3, "{found} for {rms}");
        }
    }

    #[test]
    fn the_parametric_tongue_is_as_wide_as_damping_and_depth_say() {
        let case = imported(0.2, 0.03);
        let half = (0.2_f64.powi(2) / 4.0 - 4.0 * 0.03_f64.powi(2)).sqrt();
        for side in [-1.0, 1.0] {
            assert!(growth(&case, 2.0 + 0.93 * side * half).unwrap() > 0.0);
            assert!(growth(&case, 2.0 + 1.07 * side * half).unwrap() < 0.0);
        }
    }

    #[test]
    fn free_motion_with_contact_loss_has_the_period_of_the_closed_form() {
        let case = imported(0.0, 0.0);
        for a in [1.5, 4.0] {
            let found = free_period(&case, a).unwrap();
            assert!((found / exact_period(a) - 1.0).abs() < 1e-6, "{a}: {found}");
        }
    }
}

mod rattle {
    use gearmesh_validation::stability::rattle::*;

    #[test]
    fn period_one_rattle_is_stable_between_the_edges_of_the_bouncing_ball() {
        for wanted in [0.5, 0.8] {
            let speed = impact_speed(wanted);
            let damping = damping_for(wanted, speed).unwrap();
            let measured = restitution(damping, speed).unwrap();
            assert!((measured - wanted).abs() < 1e-4, "{measured}");
            let [lower, _, upper] = expected_edges(measured);
            for (gamma, stable) in
                [(0.99 * lower, false), (1.01 * lower, true), (0.995 * upper, true), (1.01 * upper, false)]
            {
                let found = period_one(damping, measured, gamma).unwrap();
                assert_eq!(found, stable, "r = {wanted}, Gamma = {gamma}");
            }
        }
    }
}
