//! Claims about the whole element with constant stiffness.

use super::*;

#[test]
fn force_direction_and_torques_are_those_of_the_closed_form() {
    let pairs = [1.0, -1.0].map(formulations_and_pairs);
    for (formulation, pair) in pairs.into_iter().flatten() {
        for (flank, s, _) in SINGLE_FLANKS {
            let element = constant(&pair, formulation, flank);
            let (e, c) = (pair.e(), pair.center_distance);
            // In a ring the pinion meshes on the far side of its own axis, where its flanks move the other way.
            let sc = if pair.gears[1].kappa() < 0.0 {
                -1.0
            } else {
                1.0
            };
            let phi = pair.operating_pressure_angle(c);
            let g1 = &pair.gears[0];
            let r_w = pair.operating_pitch_radius(0, c);
            let ratio = pair.gears[1].z() / g1.z();
            let tan_beta_w = g1.helix_angle.tan() * r_w / g1.reference_radius();
            let f_tt = 4e-6 / phi.cos() * 4.35e8;
            let direction = Vector3::new(e * phi.tan(), s * sc, -s * g1.hand * tan_beta_w);
            // Either direction of rotation, 3000 rpm of gear 1.
            for speed in [314.0, -314.0] {
                let mut inputs = compressed(&element, s, 4e-6);
                inputs.gears[0].w.z = speed;
                inputs.gears[1].w.z = -e * speed / ratio;
                let out = at(&element, &inputs);
                // The magnitude carries the rounding of a pose 4 um into the flank.
                let force = out.tangential_force;
                assert_relative_eq!(force, f_tt, max_relative = 1e-9);
                assert_relative_eq!(out.force[1] / force, direction, epsilon = 1e-10);
                let [m1, m2] = out.moment.map(|m| m.z);
                assert_relative_eq!(m1 / force, -s * r_w, max_relative = 1e-10);
                assert_relative_eq!(m2 / m1, e * ratio, max_relative = 1e-10);
                assert_eq!(f64::from(out.flank), s);
            }
        }
    }
}

#[test]
fn rotating_and_moving_the_world_rotates_the_wrench() {
    let mut noise = Noise::new(11);
    for (formulation, pair) in formulations_and_pairs(-1.0) {
        let element = constant(&pair, formulation, LoadedFlank::Both);
        let start = element.nominal_inputs();
        for _ in 0..20 {
            let inputs = random_pose(&element, &mut noise);
            let r = Rotation3::new(noise.vector(3.0));
            let p = noise.vector(1.0);
            let here = at(&element, &inputs);
            let phase = element.phase_offset(&moved(&start, &r, &p)).unwrap();
            let there = element.evaluate(&phase, &moved(&inputs, &r, &p)).unwrap();
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

/// Elements whose wrench must be a gradient: constant stiffness, all table effects, and bodies in series, every flank.
fn conservative_elements() -> Vec<Element> {
    let mut elements = Vec::new();
    for pair in [1.0, -1.0].map(three_pairs).into_iter().flatten() {
        for flank in [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both] {
            elements.push(constant(&pair, Formulation::Conjugate, flank));
            elements.push(smooth(&pair, Formulation::Conjugate, flank));
            let bodies = body_orders(0.01);
            elements.push(with_bodies(&pair, bodies, Formulation::Conjugate, flank));
        }
    }
    elements
}

#[test]
fn the_conjugate_wrench_is_the_negative_gradient_of_its_energy() {
    let mut noise = Noise::new(3);
    for element in conservative_elements() {
        let phase = nominal_phase(&element);
        let mut tried = 0;
        while tried < 6 {
            let inputs = random_pose(&element, &mut noise);
            let out = element.evaluate(&phase, &inputs).unwrap();
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
                    let direction = Vector3::ith(axis, h);
                    if translation {
                        x.gears[i].p += direction;
                    } else {
                        x.gears[i].r = Rotation3::new(direction).matrix() * x.gears[i].r;
                    }
                    element.evaluate(&phase, &x).unwrap().energy
                };
                // Fourth-order central difference.
                let [near, far] = [1.0, 2.0].map(|n| side(n * step) - side(-n * step));
                let slope = (8.0 * near - far) / (12.0 * step);
                let load = if translation {
                    out.force[i]
                } else {
                    out.moment[i]
                };
                let error = (load[axis] + slope).abs();
                assert!(error <= 1e-7 * load.norm(), "{dof}: {load} and {slope}");
            }
        }
    }
}

#[test]
fn the_papers_formulation_does_work_on_a_radial_loop() {
    // Area times d F_r / d s = k_tt tan(phi); a rectangle of 5 um by 10 um gives 8.15 mJ.
    let pair = paper_pair(1.0);
    let [paper, conjugate] = FORMULATIONS.map(|f| constant(&pair, f, LoadedFlank::Drive));
    let start = compressed(&paper, 1.0, 30e-6);
    let half = [2.5e-6 / 41.052e-3, 5e-6];
    let (work, _) = loop_work(&paper, &start, 5, 6, half);
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let area = std::f64::consts::PI * 2.5e-6 * 5e-6;
    assert_relative_eq!(work.abs(), area * 4.35e8 * phi.tan(), max_relative = 1e-2);
    let (none, energy) = loop_work(&conjugate, &start, 5, 6, half);
    assert!(none.abs() < 1e-9 * energy);
}
