//! Claims about the whole element with constant stiffness.

use super::testing::{
    FORMULATIONS, Noise, at, compressed, loop_work, moved, random_pose, smooth_laws, three_pairs,
    undamped,
};
use super::{Element, Formulation, LoadedFlank, Parameters, StiffnessModel};
use crate::gear::samples::paper_pair;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::{Rotation3, Vector3};

#[test]
fn the_papers_pair_at_100_newton_metres_has_a_normal_force_of_2660_newton() {
    for formulation in FORMULATIONS {
        let element = Element::new(
            &paper_pair(1.0),
            &undamped(formulation, LoadedFlank::Drive),
            None,
        )
        .unwrap();
        // Independent: T / (rb1 cos beta_b), and the force follows the torque linearly.
        let out = at(&element, &compressed(&element, 1.0, 5e-6));
        let normal = out.normal_force * 100.0 / out.moment[1].z.abs();
        assert_abs_diff_eq!(normal, 2660.4, epsilon = 0.1);
    }
}

#[test]
fn force_direction_and_torques_are_those_of_the_closed_form() {
    for formulation in FORMULATIONS {
        for hand in [1.0, -1.0] {
            for pair in three_pairs(hand) {
                for (s, flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
                    let element = Element::new(&pair, &undamped(formulation, flank), None).unwrap();
                    let (e, sc, c) = (pair.e(), pair.sc(), pair.center_distance);
                    let phi = pair.operating_pressure_angle(c);
                    let g1 = &pair.gears[0];
                    let r_w: Vec<f64> = (0..2).map(|i| pair.operating_pitch_radius(i, c)).collect();
                    let tan_beta_w = g1.helix_angle.tan() * r_w[0] / g1.reference_radius();
                    let f_tt = 4e-6 / phi.cos() * 4.35e8;
                    let direction = Vector3::new(e * phi.tan(), s * sc, -s * hand * tan_beta_w);
                    // Either direction of rotation, 3000 rpm of gear 1.
                    for speed in [314.0, -314.0] {
                        let mut inputs = compressed(&element, s, 4e-6);
                        inputs.gears[0].w.z = speed;
                        inputs.gears[1].w.z = -e * speed / g1_ratio(&pair);
                        let out = at(&element, &inputs);
                        // The magnitude carries the rounding of a pose 4 um into the flank.
                        assert_relative_eq!(out.tangential_force, f_tt, max_relative = 1e-9);
                        assert_relative_eq!(
                            out.force[1] / out.tangential_force,
                            direction,
                            epsilon = 1e-10
                        );
                        assert_relative_eq!(
                            out.moment[0].z / out.tangential_force,
                            -s * r_w[0],
                            max_relative = 1e-10
                        );
                        assert_relative_eq!(
                            out.moment[1].z / out.moment[0].z,
                            e * g1_ratio(&pair),
                            max_relative = 1e-10
                        );
                        assert_eq!(f64::from(out.flank), s);
                    }
                }
            }
        }
    }
}

fn g1_ratio(pair: &crate::gear::PairGeometry) -> f64 {
    pair.gears[1].z() / pair.gears[0].z()
}

#[test]
fn the_gears_push_each_other_with_opposite_wrenches() {
    let mut noise = Noise::new(7);
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            let element =
                Element::new(&pair, &undamped(formulation, LoadedFlank::Both), None).unwrap();
            let latch = element.latch(&element.nominal_inputs()).unwrap();
            let mut touching = 0;
            for _ in 0..50 {
                let inputs = random_pose(&element, &mut noise);
                let out = element.evaluate(&latch, &inputs).unwrap();
                let scale = out.force[0].norm();
                if scale == 0.0 {
                    continue;
                }
                touching += 1;
                assert!((out.force[0] + out.force[1]).norm() <= 1e-13 * scale);
                let arm = inputs.gears[1].p - inputs.gears[0].p;
                let total = out.moment[0] + out.moment[1] + arm.cross(&out.force[1]);
                assert!(total.norm() <= 1e-13 * (out.moment[0].norm() + out.moment[1].norm()));
            }
            assert!(touching > 30);
        }
    }
}

#[test]
fn rotating_and_moving_the_world_rotates_the_wrench() {
    let mut noise = Noise::new(11);
    for formulation in FORMULATIONS {
        for pair in three_pairs(-1.0) {
            let element =
                Element::new(&pair, &undamped(formulation, LoadedFlank::Both), None).unwrap();
            let start = element.nominal_inputs();
            for _ in 0..20 {
                let inputs = random_pose(&element, &mut noise);
                let r = Rotation3::new(noise.vector(3.0));
                let p = noise.vector(1.0);
                let here = element
                    .evaluate(&element.latch(&start).unwrap(), &inputs)
                    .unwrap();
                let there = element
                    .evaluate(
                        &element.latch(&moved(&start, &r, &p)).unwrap(),
                        &moved(&inputs, &r, &p),
                    )
                    .unwrap();
                // An ulp of a coordinate (1 m) times the stiffness, some of them.
                let rounding = 40.0 * f64::EPSILON * 6e8;
                for i in 0..2 {
                    let f = r * here.force[i];
                    assert!((there.force[i] - f).norm() <= 1e-12 * f.norm() + rounding);
                    let m = r * here.moment[i];
                    assert!((there.moment[i] - m).norm() <= 1e-12 * m.norm() + rounding);
                }
            }
        }
    }
}

fn with_table(parameters: Parameters) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        ..parameters
    }
}

/// Elements whose wrench must be a gradient: constant stiffness and all table effects, every flank.
fn conservative_elements() -> Vec<Element> {
    let mut elements = Vec::new();
    for hand in [1.0, -1.0] {
        for pair in three_pairs(hand) {
            for flank in [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both] {
                let constant = undamped(Formulation::Conjugate, flank);
                let table = with_table(constant);
                elements.push(Element::new(&pair, &constant, None).unwrap());
                elements.push(Element::with_laws(&pair, &table, &smooth_laws()).unwrap());
            }
        }
    }
    elements
}

#[test]
fn the_conjugate_wrench_is_the_negative_gradient_of_its_energy() {
    let mut noise = Noise::new(3);
    for element in conservative_elements() {
        let latch = element.latch(&element.nominal_inputs()).unwrap();
        let mut tried = 0;
        while tried < 6 {
            let inputs = random_pose(&element, &mut noise);
            let out = element.evaluate(&latch, &inputs).unwrap();
            if out.flank == 0 {
                continue;
            }
            tried += 1;
            for dof in 0..12 {
                let (i, axis) = (dof / 6, dof % 3);
                let translation = dof % 6 < 3;
                let step = if translation { 1e-7 } else { 2e-6 };
                let side = |h: f64| {
                    let mut x = inputs;
                    let mut direction = Vector3::zeros();
                    direction[axis] = h;
                    if translation {
                        x.gears[i].p += direction;
                    } else {
                        x.gears[i].r = Rotation3::new(direction).matrix() * x.gears[i].r;
                    }
                    element.evaluate(&latch, &x).unwrap().energy
                };
                // Fourth-order central difference.
                let slope = (8.0 * (side(step) - side(-step))
                    - (side(2.0 * step) - side(-2.0 * step)))
                    / (12.0 * step);
                let (load, scale) = if translation {
                    (out.force[i][axis], out.force[i].norm())
                } else {
                    (out.moment[i][axis], out.moment[i].norm())
                };
                assert!(
                    (load + slope).abs() <= 1e-7 * scale,
                    "dof {dof}: {load} against {}",
                    -slope
                );
            }
        }
    }
}

#[test]
fn closed_loops_in_every_pair_of_freedoms_do_no_work() {
    for pair in three_pairs(1.0) {
        let parameters = with_table(undamped(Formulation::Conjugate, LoadedFlank::Both));
        let element = Element::with_laws(&pair, &parameters, &smooth_laws()).unwrap();
        let mut start = compressed(&element, 1.0, 80e-6);
        start.gears[1].r =
            Rotation3::from_euler_angles(1e-3, -0.5e-3, 0.0).matrix() * start.gears[1].r;
        for i in 0..12 {
            for j in 0..i {
                let size = [i, j].map(|k| if k % 6 < 3 { 10e-6 } else { 5e-6 / 40e-3 });
                let (work, energy) = loop_work(&element, &start, i, j, size);
                assert!(
                    work.abs() < 1e-9 * energy,
                    "freedoms {i}, {j}: {work:.2e} J of {energy:.2e} J"
                );
            }
        }
    }
}

#[test]
fn the_papers_formulation_does_work_on_a_radial_loop() {
    // Area times d F_r / d s = k_tt tan(phi); a rectangle of 5 um by 10 um gives 8.15 mJ.
    let pair = paper_pair(1.0);
    let element = Element::new(
        &pair,
        &undamped(Formulation::Paper, LoadedFlank::Drive),
        None,
    )
    .unwrap();
    let start = compressed(&element, 1.0, 30e-6);
    let half = [2.5e-6 / 41.052e-3, 5e-6];
    let (work, _) = loop_work(&element, &start, 5, 6, half);
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let area = std::f64::consts::PI * 2.5e-6 * 5e-6;
    assert_relative_eq!(work.abs(), area * 4.35e8 * phi.tan(), max_relative = 1e-2);
    let conjugate = Element::new(
        &pair,
        &undamped(Formulation::Conjugate, LoadedFlank::Drive),
        None,
    )
    .unwrap();
    let (none, energy) = loop_work(&conjugate, &start, 5, 6, half);
    assert!(none.abs() < 1e-9 * energy);
}
