//! Claims about phases, backlash and misalignment.

use super::*;
use crate::gear::involute;
use std::f64::consts::PI;

/// `turn` of gear 1 with gear 2 following.
fn rolled(element: &Element, turn: f64) -> Inputs {
    let k = &element.constants;
    let follow = -k.e * turn * k.z[0] / k.z[1];
    spun(&spun(&element.nominal_inputs(), 0, turn), 1, follow)
}

#[test]
fn a_million_revolutions_and_a_distant_origin_change_only_the_inputs_rounding() {
    for (formulation, pair) in formulations_and_pairs(1.0) {
        let element = constant(&pair, formulation, LoadedFlank::Both);
        let inputs = compressed(&element, 1.0, 5e-6);
        let near = at(&element, &inputs).tangential_force;
        // The angle itself is rounded to an ulp of 2 pi 1e6 (9e-10 rad), taken as given here.
        let turns = TAU * 1e6;
        let far = spun(&inputs, 0, turns);
        let ulp = turns * f64::EPSILON * element.constants.base_radius[0] * 6e8;
        assert_abs_diff_eq!(at(&element, &far).tangential_force, near, epsilon = ulp);
        // 1000 km: an ulp is 1.2e-10 m.
        let shift = |inputs: &Inputs| {
            moved(
                inputs,
                &Rotation3::identity(),
                &Vector3::new(1e6, -3e5, 2e5),
            )
        };
        let phase = element
            .phase_offset(&shift(&element.nominal_inputs()))
            .unwrap();
        let there = element.evaluate(&phase, &shift(&inputs)).unwrap();
        assert_abs_diff_eq!(there.tangential_force, near, epsilon = 1.2e-10 * 6e8);
    }
}

#[test]
fn the_way_from_flank_to_flank_is_the_backlash() {
    for (formulation, pair) in formulations_and_pairs(1.0) {
        let phi = pair.operating_pressure_angle(pair.center_distance);
        for (backlash, on_loa) in [
            (None, pair.backlash(pair.center_distance)),
            (Some(150e-6), 150e-6 * phi.cos()),
            (Some(0.0), 0.0),
        ] {
            let parameters = Parameters {
                backlash,
                ..undamped(formulation, LoadedFlank::Both)
            };
            let element = made(&pair, &parameters);
            let press = |delta: f64| at(&element, &compressed(&element, 1.0, delta));
            assert_eq!(press(1e-9).flank, 1);
            assert_eq!(press(-on_loa - 1e-9).flank, -1);
            for part in [0.001, 0.5, 0.999].iter().filter(|_| on_loa > 0.0) {
                let out = press(-part * on_loa);
                assert_eq!((out.flank, out.force[1]), (0, Vector3::zeros()));
            }
            let [coast, drive] = [-on_loa - 5e-6, 5e-6].map(press);
            assert_relative_eq!(coast.moment[0].z, -drive.moment[0].z, max_relative = 1e-6);
            let error = -(on_loa + 5e-6) / phi.cos();
            assert_relative_eq!(coast.transmission_error, error, max_relative = 1e-9);
        }
    }
}

#[test]
fn absolute_phase_zero_is_a_tooth_pair_that_touches_at_the_pitch_point_at_mid_face() {
    for hand in [1.0, -1.0] {
        // Not the ring as gear 1.
        for (formulation, pair) in formulations_and_pairs(hand) {
            let g = &pair.gears;
            if g[0].kappa() < 0.0 {
                continue;
            }
            let phi = pair.operating_pressure_angle(pair.center_distance);
            // Angle of the loaded flank at the pitch radius from the tooth (ring: space) centre.
            let flank_angle = |i: usize, sigma: f64| {
                let tan_beta_b = g[i].base_helix_angle().tan();
                sigma * g[i].kappa() * (g[i].half_base_angle() - involute(phi))
                    + g[i].hand * pair.z_ref() * tan_beta_b / g[i].base_radius()
            };
            for (flank, s, _) in SINGLE_FLANKS {
                let parameters = Parameters {
                    phase_reference: PhaseReference::Absolute,
                    ..undamped(formulation, flank)
                };
                let element = made(&pair, &parameters);
                // The pitch point: at 0 (ring as gear 2: pi) from O1, at pi from O2.
                let from_first = if pair.e() > 0.0 { 0.0 } else { PI };
                let first = spun(&element.nominal_inputs(), 0, from_first - flank_angle(0, s));
                let inputs = spun(&first, 1, PI - flank_angle(1, pair.e() * s));
                let phase = element.phase_offset(&inputs).unwrap();
                assert_eq!(phase, PhaseOffset::default());
                let out = element.evaluate(&phase, &inputs).unwrap();
                assert_abs_diff_eq!(out.transmission_error, 0.0, epsilon = 1e-15);
                let from_zero = out.mesh_position - out.mesh_position.round();
                assert_abs_diff_eq!(from_zero, 0.0, epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn overlapping_teeth_at_an_absolute_start_are_refused_with_the_turn_that_helps() {
    // Both gears with a tooth on the line of centres: half a pitch of overlap.
    let parameters = Parameters {
        phase_reference: PhaseReference::Absolute,
        backlash: Some(20e-6),
        ..undamped(Formulation::Conjugate, LoadedFlank::Both)
    };
    let element = made(&paper_pair(1.0), &parameters);
    let start = element.nominal_inputs();
    let text = element.start(&start).unwrap_err().to_string();
    let turn = text.split("turn gear 1 by ").nth(1).expect("a remedy");
    let turn = turn.split(' ').next().unwrap().parse().unwrap();
    let turned = spun(&start, 0, turn);
    let phase = element.start(&turned).unwrap();
    let out = element.evaluate(&phase, &turned).unwrap();
    assert!(out.tangential_force * element.constants.base_radius[0] < 100.0);
}

#[test]
fn mesh_position_runs_with_the_loaded_flank_and_starts_at_the_mesh_phase() {
    for (formulation, pair) in formulations_and_pairs(1.0) {
        let pitch = TAU / pair.gears[0].z();
        for (flank, s, _) in SINGLE_FLANKS {
            let parameters = Parameters {
                mesh_phase: 0.3 * pitch,
                ..undamped(formulation, flank)
            };
            let element = made(&pair, &parameters);
            for (turn, expected) in [(0.0, 0.3), (0.25, 0.55), (1.25, 0.55), (0.8, 0.1)] {
                let out = at(&element, &rolled(&element, s * turn * pitch));
                assert_abs_diff_eq!(out.mesh_position, expected, epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn mesh_position_runs_ahead_by_what_gear_1_turns_into_the_mate() {
    for pair in three_pairs(-1.0) {
        for (flank, s, _) in SINGLE_FLANKS {
            let element = constant(&pair, Formulation::Conjugate, flank);
            let touching = at(&element, &element.nominal_inputs()).mesh_position;
            let radii = [0, 1].map(|i| pair.gears[i].base_radius());
            // Gear 1 takes this part of the approach, gear 2 the rest.
            for part in [0.0, 0.5, 1.0] {
                let approach = 8e-6;
                let mut inputs = spun(&element.nominal_inputs(), 0, s * part * approach / radii[0]);
                inputs = spun(
                    &inputs,
                    1,
                    pair.e() * s * (1.0 - part) * approach / radii[1],
                );
                let out = at(&element, &inputs);
                let delta =
                    s * out.transmission_error * element.line_of_action(out.center_distance);
                assert_abs_diff_eq!(delta, approach, epsilon = 1e-12);
                let ahead = out.mesh_position - touching;
                let ahead = ahead - ahead.round();
                assert_abs_diff_eq!(ahead, part * approach / pair.base_pitch(), epsilon = 1e-9);
            }
        }
    }
}

#[test]
fn misalignment_is_the_growth_of_penetration_with_z() {
    let mut noise = Noise::new(9);
    for (i, pair) in three_pairs(1.0).into_iter().enumerate() {
        // The same gears twice as wide have their reference plane 12.5 mm higher.
        let mut wide = pair.clone();
        for g in &mut wide.gears {
            g.face_width *= 2.0;
        }
        for (flank, s, _) in SINGLE_FLANKS {
            let [low, high] = [&pair, &wide].map(|p| constant(p, Formulation::Conjugate, flank));
            for _ in 0..10 {
                let mut inputs = low.nominal_inputs();
                let tilt =
                    Rotation3::from_euler_angles(1e-3 * noise.next(), 1e-3 * noise.next(), 0.0);
                inputs.gears[i % 2].r = *tilt.matrix();
                let [a, b] = [&low, &high].map(|e| at(e, &inputs));
                let [d0, d1] = [&a, &b].map(|out| {
                    s * out.transmission_error * low.line_of_action(out.center_distance)
                });
                // First order in the tilt: C tilt^2 = 0.1 um remains.
                assert_abs_diff_eq!(d1 - d0, a.misalignment * 12.5e-3, epsilon = 2e-7);
            }
        }
    }
}

#[test]
fn the_papers_transmission_error_is_negative_on_a_loaded_flank_misaligned_by_3_milliradian() {
    let pair = paper_pair(1.0);
    let element = constant(&pair, Formulation::Paper, LoadedFlank::Drive);
    // Tilt gear 1 about the off-line of action so that M = +3 mrad, and press by 5 um at mid-face.
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let across = Vector3::z().cross(&Vector3::new(phi.sin(), phi.cos(), 0.0));
    let mut inputs = compressed(&element, 1.0, 5e-6 - 3e-3 * 12.5e-3);
    inputs.gears[0].r = Rotation3::new(across * 3e-3).matrix() * inputs.gears[0].r;
    let out = at(&element, &inputs);
    assert_abs_diff_eq!(out.misalignment, 3e-3, epsilon = 1e-7);
    assert!(out.transmission_error < -30e-6);
    assert_eq!(out.flank, 1);
    let force = 5e-6 / phi.cos() * 4.35e8;
    assert_relative_eq!(out.tangential_force, force, max_relative = 0.02);
}

#[test]
fn one_flank_alone_refuses_to_meet_the_tooth_behind_and_names_the_remedy() {
    for (formulation, pair) in formulations_and_pairs(1.0) {
        let pitch = TAU / pair.gears[0].z();
        for (flank, s, i) in SINGLE_FLANKS {
            let element = constant(&pair, formulation, flank);
            let phase = nominal_phase(&element);
            let (mut free, mut refused) = (0, 0);
            for n in 1..100 {
                let back = -s * 0.01 * f64::from(n) * pitch;
                let inputs = spun(&element.nominal_inputs(), 0, back);
                match element.evaluate(&phase, &inputs) {
                    Ok(out) if n < 45 => {
                        free += 1;
                        assert_eq!(out.force[0], Vector3::zeros());
                    }
                    Ok(_) => {}
                    Err(error) => {
                        refused += 1;
                        let name = ["loadedFlank = drive", "loadedFlank = coast"][i];
                        let text = error.to_string();
                        assert!(text.contains(name) && text.contains("both"), "{text}");
                    }
                }
            }
            assert_eq!(free, 44);
            assert!(refused > 15, "{refused}");
        }
    }
}

#[test]
fn the_initial_pose_is_about_to_carry_even_with_tilted_gears() {
    let mut noise = Noise::new(33);
    for (formulation, pair) in formulations_and_pairs(1.0) {
        for flank in [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both] {
            let element = smooth(&pair, formulation, flank);
            let s = if flank == LoadedFlank::Coast {
                -1.0
            } else {
                1.0
            };
            for _ in 0..10 {
                let inputs = random_pose(&element, &mut noise);
                let phase = element.phase_offset(&inputs).unwrap();
                let force = |x: &Inputs| element.evaluate(&phase, x).unwrap().tangential_force;
                assert!(flank == LoadedFlank::Both || force(&inputs) <= 1e-6);
                let a_little = s * 0.5e-6 / pair.gears[0].base_radius();
                assert!(force(&spun(&inputs, 0, a_little)) > 0.0);
            }
        }
    }
}
