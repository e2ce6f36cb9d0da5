//! The headline figures of docs/validation.md, by the code that finds them.

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
    use gearmesh_validation::driver::{Master, Way};
    use gearmesh_validation::stability::cosimulation::*;

    #[test]
    fn held_loads_are_stable_up_to_the_step_of_the_formulas_and_not_beyond() {
        for master in [Master::Sequential, Master::Parallel] {
            for &zeta in &ZETAS[1..] {
                let Some(expected) = expected_limit(master, zeta) else {
                    continue;
                };
                let o = system(zeta).unwrap();
                let at = |h| stable(&o, Way::held(master), h).unwrap();
                assert!(at(0.97 * expected), "{master:?}, zeta = {zeta}");
                assert!(!at(1.03 * expected), "{master:?}, zeta = {zeta}");
            }
        }
    }

    /// With more damping one step of the integrator inside differs from the exact solution by some percent.
    #[test]
    fn predicted_loads_are_stable_up_to_the_multipliers_of_the_exact_prediction() {
        for (master, masses) in [
            (Master::Sequential, &MASSES[..]),
            (Master::Parallel, &MASSES[2..]),
        ] {
            for zeta in [0.0, 0.03] {
                let o = system(zeta).unwrap();
                for &factor in masses {
                    let most = longest(factor).min(1.5);
                    let expected = expected_prediction(master, zeta, factor, most);
                    let at =
                        |h| stable(&o, Way::predicted(master, 0.5 * factor * mass()), h).unwrap();
                    let case = format!("{master:?}, zeta = {zeta}, mass x {factor}: {expected}");
                    assert!(at(0.97 * expected), "{case}");
                    assert!(expected == most || !at(1.03 * expected), "{case}");
                }
            }
        }
    }

    #[test]
    fn predicted_loads_take_energy_where_held_loads_bring_it() {
        for name in TABLES {
            for master in [Master::Sequential, Master::Parallel] {
                let found =
                    energy_brought(name, |mass| Way::predicted(master, mass), 10_000).unwrap();
                assert!((-1.01..0.0).contains(&found), "{name}, {master:?}: {found}");
                let held = energy_brought(name, |_| Way::held(master), 100).unwrap();
                assert!(held > 1.0, "{name}, {master:?}: {held}");
            }
        }
    }
}
