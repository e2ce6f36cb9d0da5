//! Claims about a turning carrier, and poses and parameters at and beyond the limits.

use super::*;
use crate::element::engagement::radial_share;
use crate::gear::samples::{gear, thinned};
use crate::gear::teeth::Counts;
use crate::gear::{GearKind, PairGeometry};
use crate::table::{Potential, Query};
use std::f64::consts::FRAC_PI_2;

#[test]
fn carrier_gears_and_world_turned_alike_change_nothing_and_the_carriers_turning_is_taken_off() {
    let element = damped(Formulation::Paper, 1e5);
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
    let (force, alone) = (out.tangential_force, fixed.tangential_force);
    assert_relative_eq!(force, alone, max_relative = 1e-9);
    assert_abs_diff_eq!(out.transmission_error_rate, 0.0, epsilon = 1e-12);
}

#[test]
fn poses_without_meaning_are_refused_by_name() {
    for formulation in FORMULATIONS {
        let pair = paper_pair(1.0);
        let element = constant(&pair, formulation, LoadedFlank::Both);
        let good = element.nominal_inputs();
        let phase = element.phase_offset(&good).unwrap();
        let across = *Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2).matrix();
        type Change<'a> = (&'a dyn Fn(&mut Inputs), [&'a str; 2]);
        let changes: [Change<'_>; 4] = [
            (&|x| x.gears[1].v.y = f64::NAN, ["gear2", "velocity"]),
            (&|x| x.gears[0].r *= 1.01, ["gear1", "no rotation"]),
            (&|x| x.gears[1].r = across, ["gear2", "90.000 deg"]),
            (&|x| x.gears[1].p.x = 0.0, ["centre distance 0.0", "mm"]),
        ];
        for (change, parts) in changes {
            let mut inputs = good;
            change(&mut inputs);
            let text = element.evaluate(&phase, &inputs).unwrap_err().to_string();
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}

#[test]
fn gears_out_of_mesh_feel_nothing_and_get_there_along_a_gradient() {
    for pair in three_pairs(1.0) {
        let element = constant(&pair, Formulation::Conjugate, LoadedFlank::Both);
        let phase = element.phase_offset(&element.nominal_inputs()).unwrap();
        let out_of_mesh = [
            Vector3::x() * (pair.e() * 12e-3),
            Vector3::z() * 26e-3,
            Vector3::z() * -26e-3,
        ];
        for shift in out_of_mesh {
            let mut inputs = compressed(&element, 1.0, 5e-6);
            inputs.gears[1].p += shift;
            let out = element.evaluate(&phase, &inputs).unwrap();
            assert_eq!(out.force[1], Vector3::zeros());
            assert!(out.out_of_range);
        }
        // Half out along the axis: the force is still the slope of the energy.
        let mut inputs = compressed(&element, 1.0, 100e-6);
        let turn_back = 18e-3 * element.constants.tan_beta_b / element.constants.base_radius[0];
        inputs.gears[1].p.z += 18e-3;
        inputs = spun(&inputs, 0, -turn_back * element.constants.hand);
        let energy = |dz: f64| {
            let mut x = inputs;
            x.gears[1].p.z += dz;
            element.evaluate(&phase, &x).unwrap().energy
        };
        let out = element.evaluate(&phase, &inputs).unwrap();
        assert!(out.out_of_range && out.flank == 1);
        let slope = (energy(1e-7) - energy(-1e-7)) / 2e-7;
        assert_relative_eq!(out.force[1].z, -slope, max_relative = 1e-6);
    }
}

/// Gear 1 of `z1` teeth in a ring of `z2`, module 4 mm.
fn internal_pair(z1: u32, z2: u32) -> PairGeometry {
    let pair = PairGeometry {
        gears: [
            gear(GearKind::External, z1, 1.0, 0.0, 0.0),
            gear(GearKind::Ring, z2, 1.0, 0.0, 0.0),
        ],
        center_distance: 2e-3 * f64::from(z2 - z1),
    };
    thinned(pair, 60e-6)
}

#[test]
fn an_internal_pair_with_few_teeth_between_stays_in_mesh_until_the_base_circles_touch() {
    // Between them half of the path lasts to the end, part of it, and nothing.
    let mut shares = vec![];
    for (z1, z2) in [
        (60, 68),
        (40, 52),
        (30, 50),
        (30, 56),
        (20, 50),
        (30, 60),
        (20, 61),
    ] {
        let pair = internal_pair(z1, z2);
        let element = constant(&pair, Formulation::Conjugate, LoadedFlank::Both);
        let k = &element.constants;
        let phase = element.phase_offset(&element.nominal_inputs()).unwrap();
        let energy = |x: &Inputs| element.evaluate(&phase, x).unwrap().energy;
        let inputs = compressed(&element, 1.0, 5e-6);
        let nominal = element.evaluate(&phase, &inputs).unwrap();
        assert!(!nominal.out_of_range && nominal.flank == 1);
        // Down to the base circles, closest near them, and as far the other way.
        let room = pair.center_distance - k.base_radius_sum;
        let steps = (1..400).map(|i| room * (1.0 - f64::from(i) / 400.0).powi(3));
        let mut least = 1.0_f64;
        for c in steps
            .map(|left| k.base_radius_sum + left)
            .chain([pair.center_distance + room])
        {
            let (share, by_c) = radial_share(k, c);
            least = least.min(share);
            // Never steeper than over a fiftieth of the way.
            assert!(
                (0.0..=1.0).contains(&share) && by_c * k.radial_engagement.per_span * room < 94.0,
                "{z1}/{z2} {c}: {by_c}"
            );
            let mut x = inputs;
            x.gears[1].p.x = x.gears[0].p.x + (x.gears[1].p.x - x.gears[0].p.x).signum() * c;
            // Nearer the axes the flanks part; gear 1 follows until they press again.
            let gap = element.evaluate(&phase, &x).unwrap().transmission_error;
            let x = spun(&x, 0, (5e-6 - gap.min(0.0)) / k.base_radius[0]);
            let out = element.evaluate(&phase, &x).unwrap();
            assert!(share == 0.0 || out.flank == 1, "{z1}/{z2} {c}: {gap}");
            let mut loads = out.force.iter().chain(&out.moment);
            assert!(loads.all(|load| load.iter().all(|f| f.is_finite())));
            let moved = |dx: f64| {
                let mut x = x;
                x.gears[1].p.x += dx;
                energy(&x)
            };
            let h = 1e-4 * (c - k.base_radius_sum);
            // Nearer to the base circles the difference is rounding.
            if c - k.base_radius_sum > 1e-3 * room {
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                let epsilon = 1e-5 * (nominal.tangential_force + out.tangential_force);
                assert_abs_diff_eq!(out.force[1].x, -slope, epsilon = epsilon);
            }
        }
        shares.push(least);
    }
    assert!(shares[..4].iter().all(|&share| share == 1.0), "{shares:?}");
    assert!(
        shares[3..].windows(2).all(|w| w[1] < w[0]) && shares[6] == 0.0,
        "{shares:?}"
    );
}

#[test]
fn a_gear_that_takes_the_common_face_along_is_out_of_range() {
    for pair in three_pairs(1.0) {
        let element = constant(&pair, Formulation::Conjugate, LoadedFlank::Both);
        let phase = element.phase_offset(&element.nominal_inputs()).unwrap();
        let (_, width) = pair.face_overlap();
        for sign in [-1.0, 1.0] {
            let moved = |part: f64| {
                let mut inputs = compressed(&element, 1.0, 5e-6);
                inputs.gears[1].p.z += sign * part * width;
                element.evaluate(&phase, &inputs).unwrap().out_of_range
            };
            assert!(!moved(0.04));
            // A narrower face within the other one keeps its width, not its place.
            let widest = pair.gears.each_ref().map(|gear| gear.face_width);
            assert!(moved(0.06 + (widest[0] - widest[1]).abs() / width));
        }
    }
}

/// The law of one flank that covers misalignments in this range alone.
struct Covered(Smooth, [f64; 2]);

impl Elasticity for Covered {
    fn evaluate(&self, q: &Query, counts: Counts, hessian: bool) -> Result<Potential, String> {
        let [low, high] = self.1;
        let mut w = self.0.evaluate(q, counts, hessian)?;
        w.out_of_range = !(low..=high).contains(&q.misalignment);
        Ok(w)
    }
}

#[test]
fn only_a_flank_that_carries_says_whether_a_pose_is_out_of_range() {
    let pair = paper_pair(1.0);
    let range = [-1e-3, 3e-3];
    let law = || Arc::new(Covered(DRIVE, range));
    for formulation in FORMULATIONS {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            ..undamped(formulation, LoadedFlank::Both)
        };
        let element = Element::with_laws(&pair, &parameters, law(), Some(law())).unwrap();
        let phi = pair.operating_pressure_angle(pair.center_distance);
        for s in [1.0, -1.0] {
            // About the normal of the line of action of either flank, whose misalignment this is.
            let across = Vector3::z().cross(&Vector3::new(phi.sin(), s * phi.cos(), 0.0));
            for m in [-2e-3, -0.9e-3, 2e-3, 2.9e-3, 3.2e-3] {
                let mut inputs = compressed(&element, s, 30e-6 - m * pair.z_ref());
                inputs.gears[0].r = Rotation3::new(across * m).matrix() * inputs.gears[0].r;
                let out = at(&element, &inputs);
                assert_eq!(f64::from(out.flank), s);
                assert_abs_diff_eq!(out.misalignment, m, epsilon = 5e-5);
                assert_eq!(out.out_of_range, !(range[0]..range[1]).contains(&m), "{m}");
            }
        }
    }
}

#[test]
fn parameters_without_a_meaning_are_refused_by_name() {
    let pair = paper_pair(1.0);
    let pitch = pair.base_pitch();
    let table = sealed(spring_file(&pair, [100.0, 200.0], [10, 1, 1, 12]));
    let refused =
        |parameters: Parameters| refusal(Element::new(&pair, &parameters, Some(table.clone())));
    let good = Parameters::default();
    let with_table = Parameters {
        stiffness_model: StiffnessModel::Table,
        center_distance_effect: false,
        misalignment_effect: false,
        damping_onset: 1.0,
        ..good
    };
    let backlash = |j: f64| Parameters {
        backlash: Some(j),
        ..good
    };
    let torque = |nominal_torque: f64| Parameters {
        nominal_torque,
        ..with_table
    };
    let (mut friction, mut root_stress) = (good, good);
    (friction.friction, root_stress.root_stress) = (true, true);
    let beyond = Parameters {
        load_dependent: false,
        damping_onset: 1e-9,
        ..torque(1e6)
    };
    let onset = Parameters {
        damping_onset: 0.0,
        ..good
    };
    made(&pair, &backlash(0.4 * pitch));
    Element::new(&pair, &torque(200.0), Some(table.clone())).unwrap();
    let by_table = "stiffnessModel = table";
    for (parameters, start, remedy) in [
        (backlash(0.6 * pitch), "backlash = ", "half a pitch"),
        (backlash(110.0), "backlash = 110 m: ", "half a pitch"),
        (backlash(-1.0), "backlash = -1 m: ", "zero or above"),
        (onset, "dampingOnset = 0: ", "a share"),
        (friction, "friction = true: ", by_table),
        (root_stress, "rootStress = true: ", by_table),
        (torque(1e300), "nominalTorque = 1e300 N m: ", "dampingOnset"),
        (beyond, "nominalTorque", "choose"),
    ] {
        let text = refused(parameters);
        assert!(text.contains(start) && text.contains(remedy), "{text}");
    }
}
