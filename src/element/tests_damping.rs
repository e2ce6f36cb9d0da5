//! Claims about the damper: it takes energy at every state, and nothing else changes.

use super::kinematics::{Coordinates, Map};
use super::testing::{FORMULATIONS, Noise, random_pose, smooth_laws, three_pairs, undamped};
use super::*;
use crate::gear::samples::paper_pair;
use approx::assert_relative_eq;

/// A pose in mesh with velocities of any direction.
fn moving(element: &Element, noise: &mut Noise, speed: f64) -> Inputs {
    let mut inputs = random_pose(element, noise);
    for m in &mut inputs.gears {
        m.v = noise.vector(speed);
        m.w = noise.vector(20.0 * speed);
    }
    inputs
}

/// Power that the contact gives to the gears, W.
fn power(out: &Outputs, inputs: &Inputs) -> f64 {
    (0..2)
        .map(|i| out.force[i].dot(&inputs.gears[i].v) + out.moment[i].dot(&inputs.gears[i].w))
        .sum()
}

#[test]
fn loads_are_minus_the_transpose_of_rates() {
    let mut noise = Noise::new(31);
    for formulation in FORMULATIONS {
        for pair in three_pairs(-1.0) {
            let element = Element::new(&pair, &undamped(formulation, LoadedFlank::Both), None);
            let element = element.unwrap();
            for _ in 0..20 {
                let inputs = moving(&element, &mut noise, 0.1);
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
                let work: f64 = (0..2)
                    .map(|i| {
                        let m = &inputs.gears[i];
                        loads[i].linear.dot(&m.v) + loads[i].angular.dot(&m.w)
                    })
                    .sum();
                let scale: f64 = terms.iter().map(|t| t.abs()).sum();
                assert!((terms.iter().sum::<f64>() + work).abs() <= 1e-13 * scale);
            }
        }
    }
}

#[test]
fn the_damper_never_gives_energy_and_leaves_gradient_and_balance_alone() {
    let mut noise = Noise::new(32);
    for (formulation, damping) in [
        (Formulation::Conjugate, 3e3),
        (Formulation::Conjugate, 1e6),
        (Formulation::Paper, 1e5),
    ] {
        for pair in three_pairs(1.0) {
            let make = |damping| {
                let parameters = Parameters {
                    damping,
                    stiffness_model: StiffnessModel::Table,
                    ..undamped(formulation, LoadedFlank::Both)
                };
                Element::with_laws(&pair, &parameters, &smooth_laws()).unwrap()
            };
            let (free, damped) = (make(0.0), make(damping));
            let latch = free.latch(&free.nominal_inputs()).unwrap();
            let (mut loaded, mut cut_off) = (0, 0);
            while loaded < 300 {
                let inputs = moving(&free, &mut noise, 0.3);
                let elastic = free.evaluate(&latch, &inputs).unwrap();
                let out = damped.evaluate(&latch, &inputs).unwrap();
                assert_eq!(out.flank, elastic.flank);
                assert_eq!(out.energy, elastic.energy);
                if out.flank == 0 {
                    continue;
                }
                loaded += 1;
                let taken = power(&out, &inputs) - power(&elastic, &inputs);
                let flow = out.force[0].norm() * inputs.gears[0].v.norm()
                    + elastic.force[0].norm() * inputs.gears[1].v.norm()
                    + out.moment[0].norm() * inputs.gears[0].w.norm()
                    + elastic.moment[1].norm() * inputs.gears[1].w.norm();
                assert!(
                    taken <= 1e-13 * flow,
                    "{formulation:?}: {taken} W of {flow} W"
                );
                assert!(out.tangential_force >= 0.0);
                cut_off += usize::from(out.tangential_force == 0.0);
                let arm = inputs.gears[1].p - inputs.gears[0].p;
                let total = out.moment[0] + out.moment[1] + arm.cross(&out.force[1]);
                assert!((out.force[0] + out.force[1]).norm() <= 1e-13 * out.force[0].norm());
                assert!(total.norm() <= 1e-12 * (out.moment[0].norm() + out.moment[1].norm()));
            }
            assert!(cut_off > 0 || damping < 1e5);
        }
    }
}

#[test]
fn the_damping_force_has_a_continuous_slope_while_the_flanks_part_faster_and_faster() {
    let element = Element::new(
        &paper_pair(1.0),
        &Parameters {
            damping: 1e5,
            ..undamped(Formulation::Conjugate, LoadedFlank::Drive)
        },
        None,
    )
    .unwrap();
    let force = |rate: f64| {
        element
            .damper
            .force(1000.0, rate, element.constants.cos_phi)
    };
    let coefficient = 1e5 / element.constants.cos_phi.powi(2);
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
fn one_flank_alone_refuses_to_meet_the_tooth_behind_and_names_the_remedy() {
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            let pitch = std::f64::consts::TAU / pair.gears[0].z();
            for (s, flank, name) in [
                (1.0, LoadedFlank::Drive, "loadedFlank = drive"),
                (-1.0, LoadedFlank::Coast, "loadedFlank = coast"),
            ] {
                let element = testing::constant(&pair, formulation, flank);
                let latch = element.latch(&element.nominal_inputs()).unwrap();
                let (mut free, mut refused) = (0, 0);
                for n in 1..100 {
                    let back = -s * 0.01 * f64::from(n) * pitch;
                    let inputs = testing::spun(&element.nominal_inputs(), 0, back);
                    match element.evaluate(&latch, &inputs) {
                        Ok(out) if n < 45 => {
                            free += 1;
                            assert_eq!(out.force[0], Vector3::zeros());
                        }
                        Ok(_) => {}
                        Err(error) => {
                            refused += 1;
                            let text = error.to_string();
                            assert!(text.contains(name) && text.contains("both"), "{text}");
                        }
                    }
                }
                assert_eq!(free, 44);
                assert!(refused > 15, "{refused}");
                // With both flanks the other flank takes over as soon as the backlash is used up.
                let both = testing::constant(&pair, formulation, LoadedFlank::Both);
                let latch = both.latch(&both.nominal_inputs()).unwrap();
                let mut before = 0.0;
                for n in 0..1000 {
                    let back = -1e-5 * pitch * f64::from(n);
                    let inputs = testing::spun(&both.nominal_inputs(), 0, back);
                    let force = both.evaluate(&latch, &inputs).unwrap().tangential_force;
                    let step = 1e-5 * pitch * pair.gears[0].base_radius() * 6e8;
                    assert!((force - before).abs() <= step);
                    before = force;
                }
                assert!(before > 1e3);
            }
        }
    }
}

#[test]
fn the_initial_pose_is_about_to_carry_even_with_tilted_gears() {
    let mut noise = Noise::new(33);
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            for flank in [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both] {
                let parameters = Parameters {
                    stiffness_model: StiffnessModel::Table,
                    ..undamped(formulation, flank)
                };
                let element = Element::with_laws(&pair, &parameters, &smooth_laws()).unwrap();
                for _ in 0..10 {
                    let inputs = random_pose(&element, &mut noise);
                    let latch = element.latch(&inputs).unwrap();
                    let out = element.evaluate(&latch, &inputs).unwrap();
                    if flank != LoadedFlank::Both {
                        assert!(out.tangential_force <= 1e-6, "{}", out.tangential_force);
                    }
                    let s = if flank == LoadedFlank::Coast {
                        -1.0
                    } else {
                        1.0
                    };
                    let a_little = s * 0.5e-6 / pair.gears[0].base_radius();
                    let pressed = testing::spun(&inputs, 0, a_little);
                    assert!(element.evaluate(&latch, &pressed).unwrap().tangential_force > 0.0);
                }
            }
        }
    }
}
