//! Claims about phases, backlash, damping and the hard poses.

use super::geometry::FLANKS;
use super::testing::{Noise, compressed, moved, paper_pair, random_pose, spun, three_pairs};
use super::*;
use crate::gear::involute;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::Rotation3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const FORMULATIONS: [Formulation; 2] = [Formulation::Paper, Formulation::Conjugate];

fn parameters(formulation: Formulation, loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        formulation,
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

fn element(pair: &PairGeometry, formulation: Formulation, flank: LoadedFlank) -> Element {
    Element::new(pair, &parameters(formulation, flank), None).unwrap()
}

fn at(element: &Element, inputs: &Inputs) -> Outputs {
    let latch = element.latch(&element.nominal_inputs()).unwrap();
    element.evaluate(&latch, inputs).unwrap()
}

#[test]
fn a_million_revolutions_and_a_distant_origin_change_only_the_inputs_rounding() {
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            let element = element(&pair, formulation, LoadedFlank::Both);
            let inputs = compressed(&element, 1.0, 5e-6);
            let near = at(&element, &inputs).tangential_force;
            // The angle itself is rounded to an ulp of 2 pi 1e6 (9e-10 rad), taken as given here.
            let turns = TAU * 1e6;
            let far = spun(&inputs, 0, turns);
            let ulp = turns * f64::EPSILON * element.constants.rb[0] * 6e8;
            assert_abs_diff_eq!(at(&element, &far).tangential_force, near, epsilon = ulp);
            // 1000 km: an ulp is 1.2e-10 m.
            let offset = Vector3::new(1e6, -3e5, 2e5);
            let start = element.nominal_inputs();
            let latch = element
                .latch(&moved(&start, &Rotation3::identity(), &offset))
                .unwrap();
            let there = element
                .evaluate(&latch, &moved(&inputs, &Rotation3::identity(), &offset))
                .unwrap();
            assert_abs_diff_eq!(there.tangential_force, near, epsilon = 1.2e-10 * 6e8);
        }
    }
}

#[test]
fn the_elongation_is_the_closed_form_for_parallel_axes() {
    let mut noise = Noise::new(21);
    for hand in [1.0, -1.0] {
        for pair in three_pairs(hand) {
            for (s, flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
                let element = element(&pair, Formulation::Conjugate, flank);
                let start = element.nominal_inputs();
                let latch = element.latch(&start).unwrap();
                for _ in 0..20 {
                    // All freedoms at parallel axes; small, so that no pitch is wrapped.
                    let (turn1, turn2) = (0.02 * noise.next(), 0.02 * noise.next());
                    let mut inputs = spun(&spun(&start, 0, turn1), 1, turn2);
                    let shift = noise.vector(2e-4);
                    inputs.gears[1].p += shift;
                    let (e, g) = (pair.e(), &pair.gears);
                    let c0 = pair.center_distance;
                    let (x, y) = (c0 + shift.x, shift.y);
                    let (c, gamma) = (x.hypot(y), y.atan2(x));
                    let inv = |c: f64| involute(pair.operating_pressure_angle(c));
                    let expected = s
                        * (g[0].base_radius() * (turn1 - gamma)
                            + e * g[1].base_radius() * (turn2 - gamma)
                            + hand * pair.base_helix_angle().tan() * shift.z)
                        - e * pair.base_radius_sum() * (inv(c) - inv(c0));
                    let out = element.evaluate(&latch, &inputs).unwrap();
                    let delta = s * out.transmission_error * pair.base_radius_sum() / c;
                    assert_abs_diff_eq!(delta, expected, epsilon = 1e-15);
                }
            }
        }
    }
}

#[test]
fn the_way_from_flank_to_flank_is_the_backlash() {
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            let phi = pair.operating_pressure_angle(pair.center_distance);
            for (given, on_loa) in [
                (None, pair.backlash(pair.center_distance)),
                (Some(150e-6), 150e-6 * phi.cos()),
                (Some(0.0), 0.0),
            ] {
                let element = Element::new(
                    &pair,
                    &Parameters {
                        backlash: given,
                        ..parameters(formulation, LoadedFlank::Both)
                    },
                    None,
                )
                .unwrap();
                let press = |delta: f64| at(&element, &compressed(&element, 1.0, delta));
                assert_eq!(press(1e-9).flank, 1);
                assert_eq!(press(-on_loa - 1e-9).flank, -1);
                if on_loa > 0.0 {
                    for part in [0.001, 0.5, 0.999] {
                        let out = press(-part * on_loa);
                        assert_eq!(out.flank, 0);
                        assert_eq!(out.force[1], Vector3::zeros());
                    }
                }
                let coast = press(-on_loa - 5e-6);
                let drive = press(5e-6);
                assert_relative_eq!(coast.moment[0].z, -drive.moment[0].z, max_relative = 1e-6);
                assert_relative_eq!(
                    coast.transmission_error,
                    -(on_loa + 5e-6) / phi.cos(),
                    max_relative = 1e-9
                );
            }
        }
    }
}

#[test]
fn both_flanks_press_when_the_teeth_run_out_of_backlash() {
    for pair in three_pairs(-1.0) {
        let element = element(&pair, Formulation::Conjugate, LoadedFlank::Both);
        let latch = element.latch(&element.nominal_inputs()).unwrap();
        // Closer for external gears, farther for internal ones.
        let mut inputs = element.nominal_inputs();
        inputs.gears[1].p.x -= pair.e() * 0.15e-3;
        let half = -0.5 * pair.backlash(inputs.gears[1].p.x);
        assert!(half > 0.0);
        // In the middle of the tooth space: latched on the drive flank, so go back by its share.
        let latched = element.evaluate(&latch, &inputs).unwrap();
        let delta = latched.transmission_error * pair.base_radius_sum() / latched.center_distance;
        let middle = spun(&inputs, 0, (half - delta) / element.constants.rb[0]);
        let out = element.evaluate(&latch, &middle).unwrap();
        let k = 4.35e8 / element.constants.cos_phi.powi(2);
        let sin_phi = pair.operating_pressure_angle(out.center_distance).sin();
        // Two forces on the lines of action: tangential parts cancel, radial ones add.
        let expected = pair.e() * 2.0 * k * half * sin_phi;
        assert_relative_eq!(out.force[1].x, expected, max_relative = 1e-7);
        assert!(out.force[1].y.abs() < 1e-6 * expected.abs());
        assert!(out.moment[0].z.abs() < 1e-6 * expected.abs() * 0.04);
    }
}

#[test]
fn absolute_phase_zero_is_a_tooth_pair_that_touches_at_the_pitch_point_at_mid_face() {
    for formulation in FORMULATIONS {
        for hand in [1.0, -1.0] {
            let pairs = three_pairs(hand);
            for pair in &pairs[..2] {
                let g = &pair.gears;
                let phi = pair.operating_pressure_angle(pair.center_distance);
                let z = pair.z_ref();
                // Angle of the loaded flank at the pitch radius from the tooth (ring: space) centre.
                let flank_angle = |i: usize, sigma: f64| {
                    let half = g[i].half_base_angle() - involute(phi);
                    sigma * g[i].kappa() * half
                        + g[i].hand * z * g[i].base_helix_angle().tan() / g[i].base_radius()
                };
                for (s, flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
                    let element = Element::new(
                        pair,
                        &Parameters {
                            phase_reference: PhaseReference::Absolute,
                            ..parameters(formulation, flank)
                        },
                        None,
                    )
                    .unwrap();
                    // The pitch point: at 0 (ring as gear 2: pi) from O1, at pi from O2.
                    let from_first = if pair.e() > 0.0 { 0.0 } else { PI };
                    let inputs = spun(
                        &spun(&element.nominal_inputs(), 0, from_first - flank_angle(0, s)),
                        1,
                        PI - flank_angle(1, pair.e() * s),
                    );
                    let latch = element.latch(&inputs).unwrap();
                    assert_eq!(latch, Latch::default());
                    let out = element.evaluate(&latch, &inputs).unwrap();
                    assert_abs_diff_eq!(out.transmission_error, 0.0, epsilon = 1e-15);
                    let from_zero = out.mesh_position - out.mesh_position.round();
                    assert_abs_diff_eq!(from_zero, 0.0, epsilon = 1e-12);
                }
            }
        }
    }
}

#[test]
fn overlapping_teeth_at_an_absolute_start_are_refused_with_the_turn_that_helps() {
    // Both gears with a tooth on the line of centres: half a pitch of overlap.
    let element = Element::new(
        &paper_pair(1.0),
        &Parameters {
            phase_reference: PhaseReference::Absolute,
            backlash: Some(20e-6),
            ..parameters(Formulation::Conjugate, LoadedFlank::Both)
        },
        None,
    )
    .unwrap();
    let start = element.nominal_inputs();
    match element.latch(&start) {
        Err(ElementError::TeethOverlap { turn_rad, .. }) => {
            let turned = spun(&start, 0, turn_rad);
            let latch = element.latch(&turned).unwrap();
            let out = element.evaluate(&latch, &turned).unwrap();
            assert!(out.tangential_force < 1e-3);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn mesh_position_runs_with_the_loaded_flank_and_starts_at_the_mesh_phase() {
    for formulation in FORMULATIONS {
        for pair in three_pairs(1.0) {
            let pitch = TAU / pair.gears[0].z();
            for (s, flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
                let element = Element::new(
                    &pair,
                    &Parameters {
                        mesh_phase: 0.3 * pitch,
                        ..parameters(formulation, flank)
                    },
                    None,
                )
                .unwrap();
                for (turn, expected) in [(0.0, 0.3), (0.25, 0.55), (1.25, 0.55), (0.8, 0.1)] {
                    let inputs = spun(&element.nominal_inputs(), 0, s * turn * pitch);
                    let position = at(&element, &inputs).mesh_position;
                    assert_abs_diff_eq!(position, expected, epsilon = 1e-12);
                }
            }
        }
    }
}

#[test]
fn misalignment_is_the_growth_of_elongation_with_z() {
    let mut noise = Noise::new(9);
    for (i, pair) in three_pairs(1.0).into_iter().enumerate() {
        // The same gears twice as wide have their reference plane 12.5 mm higher.
        let mut wide = pair.clone();
        for g in &mut wide.gears {
            g.face_width *= 2.0;
        }
        for (s, flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
            let low = element(&pair, Formulation::Conjugate, flank);
            let high = element(&wide, Formulation::Conjugate, flank);
            for _ in 0..10 {
                let mut inputs = low.nominal_inputs();
                let tilt =
                    Rotation3::from_euler_angles(1e-3 * noise.next(), 1e-3 * noise.next(), 0.0);
                inputs.gears[i % 2].r = *tilt.matrix();
                let delta = |e: &Element| {
                    let out = at(e, &inputs);
                    (
                        s * out.transmission_error * e.line_of_action(out.center_distance),
                        out.misalignment,
                    )
                };
                let (d0, m) = delta(&low);
                let (d1, _) = delta(&high);
                // First order in the tilt: C tilt^2 = 0.1 um remains.
                assert_abs_diff_eq!(d1 - d0, m * 12.5e-3, epsilon = 2e-7);
            }
        }
    }
}

#[test]
fn the_papers_transmission_error_is_negative_on_a_loaded_flank_misaligned_by_3_milliradian() {
    let pair = paper_pair(1.0);
    let element = element(&pair, Formulation::Paper, LoadedFlank::Drive);
    // Tilt gear 1 about the off-line of action so that M = +3 mrad, and press by 5 um at mid-face.
    let phi = pair.operating_pressure_angle(pair.center_distance);
    let loa = Vector3::new(phi.sin(), phi.cos(), 0.0);
    let across = Vector3::z().cross(&loa);
    let tilt = Rotation3::new(across * 3e-3);
    let mut inputs = spun(
        &element.nominal_inputs(),
        0,
        (5e-6 - 3e-3 * 12.5e-3) / pair.gears[0].base_radius(),
    );
    inputs.gears[0].r = tilt.matrix() * inputs.gears[0].r;
    let out = at(&element, &inputs);
    assert_abs_diff_eq!(out.misalignment, 3e-3, epsilon = 1e-7);
    assert!(out.transmission_error < -30e-6);
    assert_eq!(out.flank, 1);
    assert_relative_eq!(
        out.tangential_force,
        5e-6 / phi.cos() * 4.35e8,
        max_relative = 0.02
    );
}

#[test]
fn a_static_tilt_of_turning_gears_makes_no_damping_force() {
    for formulation in FORMULATIONS {
        let pair = paper_pair(1.0);
        let element = Element::new(
            &pair,
            &Parameters {
                damping: 1e5,
                ..parameters(formulation, LoadedFlank::Drive)
            },
            None,
        )
        .unwrap();
        let mut inputs = compressed(&element, 1.0, 20e-6);
        let tilt = Rotation3::from_euler_angles(1e-3, 1e-3, 0.0);
        inputs.gears[0].r = tilt.matrix() * inputs.gears[0].r;
        let still = at(&element, &inputs);
        let speed = 3000.0 * TAU / 60.0;
        for i in 0..2 {
            let a = inputs.gears[i].r.column(2).into_owned();
            inputs.gears[i].w = a * if i == 0 { speed } else { -speed };
        }
        let turning = at(&element, &inputs);
        // The printed (20) would give 838 N. What is left is the change of C' tilt^2 along the way.
        let difference = (turning.tangential_force - still.tangential_force).abs();
        assert!(difference < 20.0, "{formulation:?}: {difference} N");
    }
}

#[test]
fn damping_never_pulls_and_sets_in_without_a_jump() {
    let pair = paper_pair(1.0);
    let element = Element::new(
        &pair,
        &Parameters {
            damping: 1e5,
            ..parameters(Formulation::Conjugate, LoadedFlank::Drive)
        },
        None,
    )
    .unwrap();
    for rate in [-1.0, -0.01, 0.01, 1.0] {
        let force = |delta: f64| {
            let mut inputs = compressed(&element, 1.0, delta);
            inputs.gears[0].w.z = rate / pair.gears[0].base_radius();
            at(&element, &inputs).tangential_force
        };
        assert_eq!(force(-1e-12), 0.0);
        let mut before = 0.0;
        for i in 0..2000 {
            let now = force(5e-9 * f64::from(i));
            assert!(now >= 0.0);
            // 10 um in 2000 steps; the damper of 1e5 N at 1 m/s comes in over 10 % of the nominal load.
            assert!(
                (now - before).abs() < 0.02 * 1.2e5 * rate.abs().max(0.03),
                "{rate} {i}"
            );
            before = now;
        }
        let full =
            4.35e8 * 10e-6 / element.constants.cos_phi + 1e5 * rate / element.constants.cos_phi;
        assert_relative_eq!(force(10e-6), full.max(0.0), max_relative = 1e-9);
    }
}

#[test]
fn carrier_gears_and_world_turned_alike_change_nothing_and_the_carriers_turning_is_taken_off() {
    let pair = paper_pair(1.0);
    let element = Element::new(
        &pair,
        &Parameters {
            damping: 1e5,
            ..parameters(Formulation::Paper, LoadedFlank::Drive)
        },
        None,
    )
    .unwrap();
    let inputs = compressed(&element, 1.0, 5e-6);
    let fixed = at(&element, &inputs);
    // The whole stage turns about an axis of its own: rigid-body velocities on all bodies.
    let (w, centre) = (Vector3::new(0.0, 0.0, 200.0), Vector3::new(0.3, -0.2, 0.0));
    let mut turning = inputs;
    let [g1, g2] = &mut turning.gears;
    for m in [g1, g2, &mut turning.carrier] {
        m.w += w;
        m.v += w.cross(&(m.p - centre));
    }
    let out = at(&element, &turning);
    assert_relative_eq!(
        out.tangential_force,
        fixed.tangential_force,
        max_relative = 1e-9
    );
    assert_abs_diff_eq!(out.transmission_error_rate, 0.0, epsilon = 1e-12);
}

#[test]
fn poses_without_meaning_are_refused_by_name() {
    for formulation in FORMULATIONS {
        let pair = paper_pair(1.0);
        let element = element(&pair, formulation, LoadedFlank::Both);
        let good = element.nominal_inputs();
        let latch = element.latch(&good).unwrap();
        let refused = |change: &dyn Fn(&mut Inputs)| {
            let mut inputs = good;
            change(&mut inputs);
            element.evaluate(&latch, &inputs).unwrap_err().to_string()
        };
        let text = refused(&|x| x.gears[1].v.y = f64::NAN);
        assert!(
            text.contains("gear2") && text.contains("velocity"),
            "{text}"
        );
        let text = refused(&|x| x.gears[0].r *= 1.01);
        assert!(
            text.contains("gear1") && text.contains("no rotation"),
            "{text}"
        );
        let text = refused(&|x| {
            x.gears[1].r = *Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2).matrix();
        });
        assert!(
            text.contains("gear2") && text.contains("90.000 deg"),
            "{text}"
        );
        let text = refused(&|x| x.gears[1].p.x = 0.0);
        assert!(text.contains("centre distance 0.0"), "{text}");
    }
}

#[test]
fn gears_out_of_reach_feel_nothing_and_get_there_along_a_gradient() {
    for pair in three_pairs(1.0) {
        let element = element(&pair, Formulation::Conjugate, LoadedFlank::Both);
        let latch = element.latch(&element.nominal_inputs()).unwrap();
        let out_of_mesh = [
            Vector3::x() * (pair.e() * 12e-3),
            Vector3::z() * 26e-3,
            Vector3::z() * -26e-3,
        ];
        for shift in out_of_mesh {
            let mut inputs = compressed(&element, 1.0, 5e-6);
            inputs.gears[1].p += shift;
            let out = element.evaluate(&latch, &inputs).unwrap();
            assert_eq!(out.force[1], Vector3::zeros());
            assert!(out.out_of_range);
        }
        // Half out along the axis: the force is still the slope of the energy.
        let mut inputs = compressed(&element, 1.0, 100e-6);
        let turn_back = 18e-3 * element.constants.tan_beta_b / element.constants.rb[0];
        inputs.gears[1].p.z += 18e-3;
        inputs = spun(&inputs, 0, -turn_back * element.constants.hand);
        let energy = |dz: f64| {
            let mut x = inputs;
            x.gears[1].p.z += dz;
            element.evaluate(&latch, &x).unwrap().energy
        };
        let out = element.evaluate(&latch, &inputs).unwrap();
        assert!(out.out_of_range && out.flank == 1);
        let slope = (energy(1e-7) - energy(-1e-7)) / 2e-7;
        assert_relative_eq!(out.force[1].z, -slope, max_relative = 1e-6);
    }
}

#[test]
fn the_reference_flank_is_the_loaded_one() {
    let mut noise = Noise::new(2);
    for pair in three_pairs(1.0) {
        for (flank, index) in [
            (LoadedFlank::Drive, 0),
            (LoadedFlank::Coast, 1),
            (LoadedFlank::Both, 0),
        ] {
            let element = element(&pair, Formulation::Conjugate, flank);
            assert_eq!(element.reference_flank, index);
            for _ in 0..20 {
                let out = at(&element, &random_pose(&element, &mut noise));
                if flank != LoadedFlank::Both && out.flank != 0 {
                    assert_eq!(f64::from(out.flank), FLANKS[index].sign());
                }
            }
        }
    }
}
