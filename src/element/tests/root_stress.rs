//! Claims about root stress: it is that of the static contact under the elastic force, and not there when it is off.

use super::*;

fn stressed(formulation: Formulation, loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        root_stress: true,
        ..undamped(formulation, loaded_flank)
    }
}

#[test]
fn root_stress_is_that_of_the_table_under_the_elastic_force_whatever_the_damper_does() {
    let mut noise = Noise::new(81);
    for (formulation, pair) in formulations_and_pairs(-1.0) {
        for (own, coast) in [(false, 1.0), (true, -0.7)] {
            let table = rubbing_table(&pair, LAWS[0], own);
            for (flank, s, _) in SINGLE_FLANKS {
                let parameters = stressed(formulation, flank);
                let free = Element::new(&pair, &parameters, Some(table.clone())).unwrap();
                let mut damped = free.clone();
                damped.set_damping(1e4);
                for _ in 0..5 {
                    let mut inputs = compressed(&free, s, 6e-6 + 1e-6 * noise.next());
                    inputs.gears[0].v = noise.vector(1e-2);
                    let out = at(&free, &inputs);
                    let braked = at(&damped, &inputs);
                    assert_ne!(out.normal_force, braked.normal_force);
                    assert_eq!(out.root_stress, braked.root_stress);
                    let force = out.normal_force * pair.base_helix_angle().cos();
                    let offset = out.center_distance - pair.center_distance;
                    let (k, side) = match flank {
                        LoadedFlank::Coast if own => (coast, 1.0),
                        // The mirror image of the drive flank.
                        LoadedFlank::Coast => (1.0, -1.0),
                        _ => (1.0, 1.0),
                    };
                    let at = [force, offset, side * out.misalignment, out.mesh_position];
                    for (found, known) in out.root_stress.iter().zip(stress_by_formula(at, k)) {
                        assert!(*found > 1e6);
                        assert_relative_eq!(*found, known, max_relative = 1e-3);
                    }
                }
            }
        }
    }
}

#[test]
fn of_two_loaded_flanks_the_larger_stress_counts_and_without_load_there_is_none() {
    let mut noise = Noise::new(82);
    let (mut both, mut none) = (0, 0);
    for pair in three_pairs(1.0) {
        let table = rubbing_table(&pair, LAWS[0], true);
        let element = |flank| {
            let parameters = Parameters {
                backlash: Some(0.0),
                ..stressed(Formulation::Conjugate, flank)
            };
            Element::new(&pair, &parameters, Some(table.clone())).unwrap()
        };
        let [drive, coast, together] =
            [LoadedFlank::Drive, LoadedFlank::Coast, LoadedFlank::Both].map(element);
        let phase = nominal_phase(&together);
        for n in 0..120 {
            let mut inputs = together.nominal_inputs();
            if n % 2 == 0 {
                inputs = random_pose(&together, &mut noise);
            } else {
                // Closer together and hardly turned: both flanks are pressed.
                inputs.gears[1].p.x -= pair.e() * 2e-5;
                inputs.gears[0].p += noise.vector(2e-6);
            }
            let Ok(out) = together.evaluate(&phase, &inputs) else {
                continue;
            };
            let alone = [&drive, &coast].map(|e| e.evaluate(&phase, &inputs));
            let [Ok(a), Ok(b)] = alone else { continue };
            for i in 0..2 {
                let largest = a.root_stress[i].max(b.root_stress[i]);
                assert_eq!(out.root_stress[i], largest);
            }
            both += i32::from(a.root_stress[0] > 0.0 && b.root_stress[0] > 0.0);
            if out.normal_force == 0.0 {
                assert_eq!(out.root_stress, [0.0; 2]);
                none += 1;
            }
        }
    }
    assert!(both > 20 && none > 0, "{both} {none}");
}
