//! Claims about the damper.

use super::*;
use crate::element::kinematics::{Coordinates, Map};

/// What damper and friction take is what the bodies lose: loads come back through the transpose of the map of the rates.
#[test]
fn loads_are_minus_the_transpose_of_rates() {
    let mut noise = Noise::new(31);
    for formulation in [Formulation::Conjugate, Formulation::Paper] {
        for pair in three_pairs(1.0) {
            let element = constant(&pair, formulation, LoadedFlank::Both);
            for _ in 0..20 {
                let mut inputs = random_pose(&element, &mut noise);
                set_velocities(&mut inputs, &mut noise, 0.1, 2.0);
                let map = Map::<f64>::new(&element.constants, formulation, &inputs.gears).unwrap();
                let slopes = Coordinates {
                    turn: noise.next(),
                    half_gap: noise.next(),
                    center_distance: noise.next(),
                    misalignment: [1e-2 * noise.next(), 1e-2 * noise.next()],
                    mesh_angle: 1e-2 * noise.next(),
                    axial: noise.next(),
                };
                let r = map.rates(&map.twist(&inputs.gears));
                let terms = [
                    slopes.turn * r.turn,
                    slopes.half_gap * r.half_gap,
                    slopes.center_distance * r.center_distance,
                    slopes.misalignment[0] * r.misalignment[0],
                    slopes.misalignment[1] * r.misalignment[1],
                    slopes.mesh_angle * r.mesh_angle,
                    slopes.axial * r.axial,
                ];
                let loads = map.on_gears(&map.wrench(&slopes));
                let work = loads.iter().zip(&inputs.gears);
                let work = work.map(|(load, m)| load.linear.dot(&m.v) + load.angular.dot(&m.w));
                let sum = terms.iter().sum::<f64>() + work.sum::<f64>();
                assert!(sum.abs() <= 1e-13 * terms.map(f64::abs).iter().sum::<f64>());
            }
        }
    }
}

#[test]
fn the_damping_force_has_a_continuous_slope_while_the_flanks_part_faster_and_faster() {
    let element = damped(Formulation::Conjugate, 1e5);
    let cos_phi = element.constants.cos_phi;
    let force = |rate: f64| element.damping(1000.0, rate, cos_phi);
    let coefficient = 1e5 / cos_phi.powi(2);
    // Small rates feel c, large ones cannot take off more than the flanks press with.
    assert_relative_eq!(force(-1e-3), -1e-3 * coefficient, max_relative = 1e-12);
    assert_eq!(force(-1.0), -1000.0);
    let step = 1e-5;
    let slope = |rate: f64| (force(rate + step) - force(rate - step)) / (2.0 * step);
    for n in -40..40 {
        let rate = 5e-4 * f64::from(n);
        let change = (slope(rate + step) - slope(rate - step)).abs();
        assert!(change <= 5e-3 * coefficient, "{rate}: {change}");
        assert!(slope(rate) >= 0.0);
    }
}

#[test]
fn a_static_tilt_of_turning_gears_makes_no_damping_force() {
    for formulation in FORMULATIONS {
        let element = damped(formulation, 1e5);
        let mut inputs = compressed(&element, 1.0, 20e-6);
        let tilt = Rotation3::from_euler_angles(1e-3, 1e-3, 0.0);
        inputs.gears[0].r = tilt.matrix() * inputs.gears[0].r;
        let still = at(&element, &inputs);
        let speed = 3000.0 * TAU / 60.0;
        for (m, speed) in inputs.gears.iter_mut().zip([speed, -speed]) {
            m.w = m.r.column(2) * speed;
        }
        let turning = at(&element, &inputs);
        // The printed (20) would give 838 N. What is left is the change of C' tilt^2 along the way.
        let difference = (turning.tangential_force - still.tangential_force).abs();
        assert!(difference < 20.0, "{formulation:?}: {difference} N");
    }
}

#[test]
fn damping_never_pulls_and_the_conjugate_one_sets_in_without_a_jump() {
    let rates = [-1.0, -0.01, 0.01, 1.0].into_iter();
    for (formulation, rate) in rates.flat_map(|rate| FORMULATIONS.map(|f| (f, rate))) {
        let element = damped(formulation, 1e5);
        let k = &element.constants;
        let force = |delta: f64| {
            let mut inputs = compressed(&element, 1.0, delta);
            inputs.gears[0].w.z = rate / k.base_radius[0];
            at(&element, &inputs).tangential_force
        };
        assert_eq!(force(-1e-12), 0.0);
        let mut before = 0.0;
        for i in 0..2000 {
            let now = force(5e-9 * f64::from(i));
            assert!(now >= 0.0);
            // 10 um in 2000 steps; the damper of 1e5 N at 1 m/s comes in over 10 % of the nominal load.
            let step = 0.02 * 1.2e5 * rate.abs().max(0.03);
            // The paper's damper is whole from the first touch on.
            let is_paper = formulation == Formulation::Paper;
            assert!(is_paper || (now - before).abs() < step, "{rate} {i}");
            before = now;
        }
        let full = (4.35e8 * 10e-6 + 1e5 * rate) / k.cos_phi;
        assert_relative_eq!(force(10e-6), full.max(0.0), max_relative = 1e-9);
    }
}
