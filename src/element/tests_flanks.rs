//! Claims about drive and coast flank with laws of their own. The argument is a mirror: it knows nothing of tables,
//! signs of M or mesh positions, only that physics in a mirror is physics.

use super::testing::{
    COAST, DRIVE, FORMULATIONS, Noise, random_pose, smooth_laws, three_pairs, undamped,
};
use super::*;
use approx::assert_relative_eq;
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
    for m in &mut inputs.gears {
        m.v = noise.vector(0.01);
        m.w = noise.vector(0.2);
    }
    inputs
}

fn parameters(formulation: Formulation, flank: LoadedFlank) -> Parameters {
    Parameters {
        damping: 1e3,
        mesh_phase: 0.02,
        ..undamped(formulation, flank)
    }
}

/// `b` is `a` in the mirror, the flanks exchanged.
fn assert_mirrored(a: &Outputs, b: &Outputs) {
    let s = mirror();
    // An ulp of a coordinate (0.1 m) times the stiffness, some of them.
    let rounding = 40.0 * f64::EPSILON * 0.1 * 6e8;
    for i in 0..2 {
        let (force, moment) = (s * a.force[i], -(s * a.moment[i]));
        assert_relative_eq!(b.force[i], force, epsilon = rounding, max_relative = 1e-9);
        assert_relative_eq!(b.moment[i], moment, epsilon = rounding, max_relative = 1e-9);
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
    let mut noise = Noise::new(17);
    let laws = FlankLaws {
        drive: Arc::new(DRIVE),
        coast: Some(Arc::new(COAST)),
    };
    let exchanged = FlankLaws {
        drive: Arc::new(COAST),
        coast: Some(Arc::new(DRIVE)),
    };
    for formulation in FORMULATIONS {
        for hand in [1.0, -1.0] {
            for (pair, image) in three_pairs(hand).into_iter().zip(three_pairs(-hand)) {
                for (flank, other) in [
                    (LoadedFlank::Drive, LoadedFlank::Coast),
                    (LoadedFlank::Coast, LoadedFlank::Drive),
                ] {
                    let here = parameters(formulation, flank);
                    let here = Element::with_laws(&pair, &here, &laws).unwrap();
                    let there = parameters(formulation, other);
                    let there = Element::with_laws(&image, &there, &exchanged).unwrap();
                    let latch = here.latch(&here.nominal_inputs()).unwrap();
                    let image_latch = there.latch(&there.nominal_inputs()).unwrap();
                    let mut touching = 0;
                    while touching < 8 {
                        let inputs = moving_pose(&here, &mut noise);
                        let a = here.evaluate(&latch, &inputs).unwrap();
                        let b = there.evaluate(&image_latch, &mirrored(&inputs)).unwrap();
                        assert_relative_eq!(
                            b.transmission_error,
                            -a.transmission_error,
                            epsilon = 1e-15
                        );
                        assert_eq!(b.flank, -a.flank);
                        if a.flank != 0 {
                            touching += 1;
                            assert_mirrored(&a, &b);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn with_both_flanks_and_absolute_phases_the_mirror_exchanges_them_too() {
    let mut noise = Noise::new(18);
    let drive: Arc<dyn Elasticity> = Arc::new(DRIVE);
    let coast: Arc<dyn Elasticity> = Arc::new(COAST);
    let laws = |drive: &Arc<dyn Elasticity>, coast: &Arc<dyn Elasticity>| FlankLaws {
        drive: drive.clone(),
        coast: Some(coast.clone()),
    };
    for formulation in FORMULATIONS {
        let both = Parameters {
            phase_reference: PhaseReference::Absolute,
            ..parameters(formulation, LoadedFlank::Both)
        };
        for (pair, image) in three_pairs(1.0).into_iter().zip(three_pairs(-1.0)) {
            let here = Element::with_laws(&pair, &both, &laws(&drive, &coast)).unwrap();
            let there = Element::with_laws(&image, &both, &laws(&coast, &drive)).unwrap();
            let mut seen = [0; 2];
            while seen[0] < 5 || seen[1] < 5 {
                let inputs = moving_pose(&here, &mut noise);
                let latch = Latch::default();
                let a = here.evaluate(&latch, &inputs).unwrap();
                let b = there.evaluate(&latch, &mirrored(&inputs)).unwrap();
                if a.flank != 0 {
                    seen[usize::from(a.flank < 0)] += 1;
                    assert_mirrored(&a, &b);
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
    for hand in [1.0, -1.0] {
        for pair in three_pairs(hand) {
            let b = pair.gears[0].face_width;
            let over = |inputs: &Inputs| Inputs {
                gears: [0, 1].map(|i| turned_over(&inputs.gears[i], b)),
                carrier: inputs.carrier,
            };
            for (flank, other) in [
                (LoadedFlank::Drive, LoadedFlank::Coast),
                (LoadedFlank::Coast, LoadedFlank::Drive),
            ] {
                // The paper's formulation looks at the z = 0 face alone, so the ends are not alike there.
                let make = |flank| {
                    let parameters = parameters(Formulation::Conjugate, flank);
                    Element::with_laws(&pair, &parameters, &smooth_laws()).unwrap()
                };
                let (here, there) = (make(flank), make(other));
                let start = here.nominal_inputs();
                let latch = here.latch(&start).unwrap();
                let latch_over = there.latch(&over(&start)).unwrap();
                let mut touching = 0;
                while touching < 8 {
                    let inputs = moving_pose(&here, &mut noise);
                    let turned = over(&inputs);
                    let a = here.evaluate(&latch, &inputs).unwrap();
                    let c = there.evaluate(&latch_over, &turned).unwrap();
                    assert_eq!(c.flank, -a.flank);
                    if a.flank == 0 {
                        continue;
                    }
                    touching += 1;
                    let rounding = 40.0 * f64::EPSILON * 0.1 * 6e8;
                    for i in 0..2 {
                        let force = t * a.force[i];
                        // About the origin in the other face.
                        let arm = t * inputs.gears[i].p - turned.gears[i].p;
                        let moment = t * a.moment[i] + arm.cross(&force);
                        assert_relative_eq!(
                            c.force[i],
                            force,
                            epsilon = rounding,
                            max_relative = 1e-9
                        );
                        assert_relative_eq!(
                            c.moment[i],
                            moment,
                            epsilon = rounding,
                            max_relative = 1e-9
                        );
                    }
                    assert_relative_eq!(c.misalignment, -a.misalignment, epsilon = 1e-12);
                    assert_relative_eq!(c.contact_z, b - a.contact_z, epsilon = 1e-9);
                }
            }
        }
    }
}
