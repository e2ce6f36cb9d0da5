//! Claims about friction: it takes energy at every state, balances, and is not there when it is off.

use super::*;
use crate::friction::FrictionLaw;
use crate::gear::PairGeometry;
use crate::table::TableFile;

fn off(parameters: &Parameters) -> Parameters {
    Parameters {
        friction: false,
        ..*parameters
    }
}

#[test]
fn friction_never_gives_energy_and_acts_on_both_gears_alike() {
    let mut noise = Noise::new(71);
    let mut loaded = 0;
    for (formulation, pair) in formulations_and_pairs(-1.0) {
        for (law, own) in LAWS.into_iter().zip([true, false, true]) {
            let parameters = rubbing(formulation, LoadedFlank::Both);
            let table = rubbing_table(&pair, law, own);
            let with = Element::new(&pair, &parameters, Some(table.clone())).unwrap();
            let without = Element::new(&pair, &off(&parameters), Some(table)).unwrap();
            let phase = nominal_phase(&with);
            for n in 0..60 {
                let mut inputs = random_pose(&with, &mut noise);
                // From creep to some m/s; translation alone, rotation alone and both.
                let speed = 10f64.powf(3.0 * noise.next() - 2.0);
                let v = if n % 3 == 0 { 0.0 } else { speed };
                let w = if n % 3 == 1 { 0.0 } else { 100.0 * speed };
                set_velocities(&mut inputs, &mut noise, v, w);
                let rubbed = with.evaluate(&phase, &inputs).unwrap();
                let free = without.evaluate(&phase, &inputs).unwrap();
                let work = power(&rubbed, &inputs) - power(&free, &inputs);
                let scale = power(&free, &inputs).abs() + work.abs();
                assert!(rubbed.friction_power <= 0.0);
                assert!(
                    (rubbed.friction_power - work).abs() <= 1e-12 * scale,
                    "{work}"
                );
                assert_eq!(rubbed.force[0], -rubbed.force[1]);
                // Moments about gear 1's origin.
                let arm = inputs.gears[1].p - inputs.gears[0].p;
                let sum = rubbed.moment[0] + rubbed.moment[1] + arm.cross(&rubbed.force[1]);
                let moments = rubbed.moment[0].norm() + rubbed.moment[1].norm();
                assert!(sum.norm() <= 1e-12 * moments + 1e-300);
                // What friction is not.
                let rest = |out: &Outputs| {
                    [
                        out.transmission_error,
                        out.normal_force,
                        out.stiffness,
                        out.energy,
                    ]
                };
                assert_eq!(rest(&rubbed), rest(&free));
                assert_eq!(free.friction_power, 0.0);
                loaded += i32::from(rubbed.friction_power < 0.0);
            }
        }
    }
    assert!(loaded > 300, "{loaded} states of 1080 rubbed");
}

#[test]
fn effects_that_are_off_change_no_bit_and_a_table_without_them_is_refused_by_name() {
    let pair = paper_pair(1.0);
    let table = rubbing_table(&pair, LAWS[0], false);
    let mut bare = (*table.file).clone();
    bare.friction = None;
    bare.root_stress = None;
    bare.seal();
    let text = bare.to_json();
    assert!(!text.contains("friction") && !text.contains("root_stress"));
    let bare = Arc::new(Table::from_file(TableFile::from_json(&text).unwrap()).unwrap());
    let mut noise = Noise::new(72);
    for formulation in FORMULATIONS {
        let plain = off(&rubbing(formulation, LoadedFlank::Both));
        let stressed = Parameters {
            root_stress: true,
            ..plain
        };
        let [one, two, with] = [(plain, &table), (plain, &bare), (stressed, &table)]
            .map(|(p, table)| Element::new(&pair, &p, Some(table.clone())).unwrap());
        assert!(one.friction.is_none());
        let phase = nominal_phase(&one);
        for _ in 0..50 {
            let inputs = random_pose(&one, &mut noise);
            let [a, b, mut c] = [&one, &two, &with].map(|e| e.evaluate(&phase, &inputs).unwrap());
            assert_eq!(a, b);
            // Nothing else depends on the stress.
            c.root_stress = [0.0; 2];
            assert_eq!(a, c);
        }
        for (parameters, parts) in [
            (
                rubbing(formulation, LoadedFlank::Both),
                ["friction = true", "gearmesh tables --friction"],
            ),
            (
                stressed,
                ["rootStress = true", "gearmesh tables --root-stress"],
            ),
        ] {
            let text = refusal(Element::new(&pair, &parameters, Some(bare.clone())));
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}

/// Gears that turn in their ratio, the drive flank compressed by `delta`.
fn turning(element: &Element, pair: &PairGeometry, delta: f64, spin: f64) -> Inputs {
    let mut inputs = compressed(element, 1.0, delta);
    let ratio = -pair.e() * pair.gears[0].z() / pair.gears[1].z();
    inputs.gears[0].w.z = spin;
    inputs.gears[1].w.z = ratio * spin;
    inputs
}

#[test]
fn loss_is_coefficient_times_load_times_sliding_in_either_sense() {
    for pair in three_pairs(1.0) {
        for law in LAWS {
            let table = rubbing_table(&pair, law, false);
            let parameters = Parameters {
                friction_factor: 1.3,
                friction_transition_speed: 1e-6,
                ..rubbing(Formulation::Conjugate, LoadedFlank::Drive)
            };
            let element = Element::new(&pair, &parameters, Some(table)).unwrap();
            let phase = nominal_phase(&element);
            let at = |spin: f64| {
                let inputs = turning(&element, &pair, 8e-6, spin);
                element.evaluate(&phase, &inputs).unwrap()
            };
            let [ahead, back] = [300.0, -300.0].map(at);
            assert!(ahead.flank == 1 && ahead.friction_power < -1.0);
            let powers = [ahead, back].map(|out| out.friction_power);
            assert_relative_eq!(powers[0], powers[1], max_relative = 1e-9);
            // Friction brakes: the driver gives more than it would without, the driven gear less.
            let force = ahead.normal_force * pair.base_helix_angle().cos();
            let transmitted = force * pair.gears[0].base_radius() * 300.0;
            let lost = ahead.friction_coefficient * ahead.loss_factor * transmitted;
            assert_relative_eq!(-ahead.friction_power, lost, max_relative = 1e-6);
            let mu = law.coefficient(&pair);
            let rolling = 300.0 * pair.rolling_speed_per_spin(pair.center_distance);
            if !law.is_local() {
                let expected = 1.3 * mu.at(force, rolling);
                assert_relative_eq!(ahead.friction_coefficient, expected, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn flanks_that_just_roll_have_a_loss_factor_of_zero() {
    let pair = paper_pair(1.0);
    let mut file = (*rubbing_table(&pair, LAWS[2], false).file).clone();
    let record = file.friction.as_mut().unwrap();
    // One contact line, which passes the pitch point at mesh position 0.
    let nodes = record.axes.mesh_position.clone();
    let s = |k: usize| 1e-2 * (TAU * nodes[k % nodes.len()]).sin().abs();
    let drive = &mut record.drive;
    for (k, weight) in drive.weight.as_mut().unwrap().iter_mut().enumerate() {
        *weight = 4.0 * s(k);
        drive.distance_m[k] = *weight * s(k);
    }
    let parameters = rubbing(Formulation::Conjugate, LoadedFlank::Drive);
    let element = Element::new(&pair, &parameters, Some(sealed(file))).unwrap();
    let phase = nominal_phase(&element);
    let at = |cycles: f64| {
        let mut inputs = turning(&element, &pair, 8e-6, 300.0);
        for (motion, z) in inputs.gears.iter_mut().zip([20.0, -20.0]) {
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), cycles * TAU / z);
            motion.r = turn.matrix() * motion.r;
        }
        element.evaluate(&phase, &inputs).unwrap()
    };
    let from_pitch_point = |out: &Outputs| out.mesh_position - out.mesh_position.round();
    let to_it = -from_pitch_point(&at(0.0));
    for beyond in [0.0, 1e-16, -1e-14, 1e-12, -1e-10, 1e-8, 1e-6] {
        let out = at(to_it + beyond);
        assert!((from_pitch_point(&out) - beyond).abs() < 1e-14);
        assert!(
            out.loss_factor.abs() < 1e-3,
            "{beyond}: {}",
            out.loss_factor
        );
        assert!(out.friction_power.abs() < 1e-6);
    }
}

#[test]
fn at_rest_under_load_friction_vanishes_and_creep_meets_it_viscously() {
    let pair = paper_pair(1.0);
    let table = rubbing_table(&pair, FrictionLaw::default(), false);
    let parameters = rubbing(Formulation::Conjugate, LoadedFlank::Drive);
    let element = Element::new(&pair, &parameters, Some(table)).unwrap();
    let phase = nominal_phase(&element);
    let at = |spin: f64| {
        let inputs = turning(&element, &pair, 8e-6, spin);
        element.evaluate(&phase, &inputs).unwrap()
    };
    let rest = at(0.0);
    assert_eq!(rest.friction_power, 0.0);
    // Braking torque per mean sliding speed r: full / sqrt(r^2 + v_t^2).
    let torque = |out: &Outputs, spin: f64| -out.friction_power / spin;
    let (slow, fast) = (1e-3, 1e3);
    let distance = rest.loss_factor / crate::friction::loss_factor_of(&pair, 1.0);
    let r = slow * pair.sliding_per_spin() * distance;
    let share = r / r.hypot(parameters.friction_transition_speed);
    assert!(share < 0.5, "creep below the speed of transition: {share}");
    let ratio = torque(&at(slow), slow) / torque(&at(fast), fast);
    assert_relative_eq!(ratio, share, max_relative = 1e-3);
}
