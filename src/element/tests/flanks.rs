//! Claims about drive and coast flank with laws of their own. The argument is a mirror: it knows nothing of tables,
//! signs of M or mesh positions, only that physics in a mirror is physics.

use super::*;
use nalgebra::Matrix3;

/// Mirror that contains the line of centres and the axes: it turns round every sense of rotation and keeps z.
fn mirror() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0))
}

/// `inputs` in the mirror. Angular velocities are axial vectors; the body's y axis turns over with the world, so
/// that the frames stay right-handed.
fn mirrored(inputs: &Inputs) -> Inputs {
    let s = mirror();
    let gear = |m: &Motion| Motion {
        p: s * m.p,
        r: s * m.r * s,
        v: s * m.v,
        w: -(s * m.w),
    };
    Inputs {
        gears: [gear(&inputs.gears[0]), gear(&inputs.gears[1])],
        carrier: gear(&inputs.carrier),
    }
}

/// A pose with velocities.
fn moving_pose(element: &Element, noise: &mut Noise) -> Inputs {
    let mut inputs = random_pose(element, noise);
    set_velocities(&mut inputs, noise, 0.01, 0.2);
    inputs
}

fn parameters(formulation: Formulation, flank: LoadedFlank) -> Parameters {
    Parameters {
        damping: 1e3,
        mesh_phase: 0.02,
        ..undamped(formulation, flank)
    }
}

fn assert_same_load(found: &Vector3<f64>, expected: &Vector3<f64>) {
    // An ulp of a coordinate (0.1 m) times the stiffness, some of them.
    let rounding = 40.0 * f64::EPSILON * 0.1 * 6e8;
    assert_relative_eq!(found, expected, epsilon = rounding, max_relative = 1e-9);
}

/// `b` is `a` in the mirror, the flanks exchanged.
fn assert_mirrored(a: &Outputs, b: &Outputs) {
    let s = mirror();
    for i in 0..2 {
        assert_same_load(&b.force[i], &(s * a.force[i]));
        assert_same_load(&b.moment[i], &-(s * a.moment[i]));
    }
    assert_relative_eq!(b.contact_point, s * a.contact_point, epsilon = 1e-9);
    assert_eq!(b.flank, -a.flank);
    assert_relative_eq!(b.misalignment, a.misalignment, epsilon = 1e-12);
    assert_relative_eq!(b.contact_z, a.contact_z, epsilon = 1e-9);
    assert_relative_eq!(b.energy, a.energy, max_relative = 1e-8);
    let turn = b.mesh_position - a.mesh_position;
    assert_relative_eq!(turn - turn.round(), 0.0, epsilon = 1e-11);
}

#[test]
fn in_a_mirror_the_drive_flank_is_the_coast_flank_of_a_pair_of_the_other_hand() {
    use LoadedFlank::{Both, Coast, Drive};
    let mut noise = Noise::new(17);
    for hand in [1.0, -1.0] {
        let images = formulations_and_pairs(-hand).into_iter();
        for ((formulation, pair), (_, image)) in
            formulations_and_pairs(hand).into_iter().zip(images)
        {
            for (flank, image_flank) in [(Drive, Coast), (Coast, Drive), (Both, Both)] {
                // Phases are taken from one flank: with both those of the body frames are alike in the mirror.
                let made = |pair, flank, drive: Smooth, coast: Smooth| {
                    let parameters = Parameters {
                        phase_reference: match flank {
                            Both => PhaseReference::Absolute,
                            _ => PhaseReference::FromInitialPose,
                        },
                        ..parameters(formulation, flank)
                    };
                    let (drive, coast) = (Arc::new(drive), Arc::new(coast));
                    let made = Element::with_laws(pair, &parameters, drive, Some(coast));
                    let element = made.unwrap();
                    let phase = nominal_phase(&element);
                    (element, phase)
                };
                let (here, phase) = made(&pair, flank, DRIVE, COAST);
                let (there, image_phase) = made(&image, image_flank, COAST, DRIVE);
                let mut seen = [0; 2];
                let enough = if flank == Both { 5 } else { 0 };
                while seen[0].min(seen[1]) < enough || seen[0] + seen[1] < 8 {
                    let inputs = moving_pose(&here, &mut noise);
                    let a = here.evaluate(&phase, &inputs).unwrap();
                    let b = there.evaluate(&image_phase, &mirrored(&inputs)).unwrap();
                    assert_eq!(b.flank, -a.flank);
                    if flank != Both {
                        let errors = [b.transmission_error, -a.transmission_error];
                        assert_relative_eq!(errors[0], errors[1], epsilon = 1e-15);
                    }
                    if a.flank != 0 {
                        seen[usize::from(a.flank < 0)] += 1;
                        assert_mirrored(&a, &b);
                    }
                }
            }
        }
    }
}

/// `m` of a gear with face width `b` as seen when the world is turned by pi about x and the frame is put into the
/// face that is z = 0 then, its z axis up again.
fn turned_over(m: &Motion, b: f64) -> Motion {
    let t = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    let other_face = m.r.column(2) * b;
    Motion {
        p: t * (m.p + other_face),
        r: t * m.r * t,
        v: t * (m.v + m.w.cross(&other_face)),
        w: t * m.w,
    }
}

#[test]
fn one_law_for_both_flanks_is_the_pair_turned_end_for_end() {
    let t = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    let mut noise = Noise::new(19);
    for pair in [1.0, -1.0].map(three_pairs).into_iter().flatten() {
        let b = pair.gears[0].face_width;
        let over = |inputs: &Inputs| Inputs {
            gears: [0, 1].map(|i| turned_over(&inputs.gears[i], b)),
            carrier: inputs.carrier,
        };
        for (flank, _, i) in SINGLE_FLANKS {
            // The paper's formulation looks at the z = 0 face alone, so the ends are not alike there.
            let [here, there] = [flank, SINGLE_FLANKS[1 - i].0].map(|flank| {
                let parameters = parameters(Formulation::Conjugate, flank);
                Element::with_laws(&pair, &parameters, Arc::new(DRIVE), None).unwrap()
            });
            let phase = nominal_phase(&here);
            let phase_over = there.phase_offset(&over(&here.nominal_inputs())).unwrap();
            let mut touching = 0;
            while touching < 8 {
                let inputs = moving_pose(&here, &mut noise);
                let turned = over(&inputs);
                let a = here.evaluate(&phase, &inputs).unwrap();
                let c = there.evaluate(&phase_over, &turned).unwrap();
                assert_eq!(c.flank, -a.flank);
                if a.flank == 0 {
                    continue;
                }
                touching += 1;
                for i in 0..2 {
                    let force = t * a.force[i];
                    // About the origin in the other face.
                    let arm = t * inputs.gears[i].p - turned.gears[i].p;
                    assert_same_load(&c.force[i], &force);
                    assert_same_load(&c.moment[i], &(t * a.moment[i] + arm.cross(&force)));
                }
                assert_relative_eq!(c.misalignment, -a.misalignment, epsilon = 1e-12);
                assert_relative_eq!(c.contact_z, b - a.contact_z, epsilon = 1e-9);
            }
        }
    }
}
