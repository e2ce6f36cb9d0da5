//! Phase zeros from the initial pose.

use super::constants::FLANKS;
use super::error::ElementError;
use super::evaluate::{Pose, pose};
use super::motion::{Inputs, Latch};
use super::parameters::PhaseReference;
use super::scalar::{Scalar, fraction, lift, wrap};
use super::{Element, law::Law};
use crate::gear::teeth::Counts;

/// Base pitches by which the start pose stays short of contact, so that rounding does not decide whether the paper's
/// damper, which acts at once, is at work.
const ROUNDING: f64 = 2e-14;

/// The latch that `element` takes from `inputs`.
pub(crate) fn latch<T: Scalar>(
    element: &Element,
    inputs: &Inputs,
) -> Result<Latch<T>, ElementError> {
    let Ok(pose) = pose(element, inputs)? else {
        return Err(ElementError::OutOfReach);
    };
    match element.parameters.phase_reference {
        PhaseReference::FromInitialPose => from_initial_pose(element, &pose),
        PhaseReference::Absolute => absolute(element, &pose),
    }
}

/// The phases with which the pose is the one where the reference flank is about to carry.
fn from_initial_pose<T: Scalar>(
    element: &Element,
    pose: &Pose<T>,
) -> Result<Latch<T>, ElementError> {
    /// Of the central differences, m and rad: small against a tooth, large against the 1e-16 m to which the onset is
    /// known.
    const STEP: f64 = 1e-6;
    let k = &element.constants;
    let i = element.reference_flank;
    let s = FLANKS[i].sign();
    let mesh_position = element.parameters.mesh_phase / k.pitch_angle;
    let law = element.laws[i].as_ref().ok_or(ElementError::OutOfReach)?;
    // The pair of teeth 0 touches where the mesh position is 0.
    let counts = [mesh_position.floor() as i64; 2];
    let touching = |[offset, misalignment]: [f64; 2], start| {
        let at = [offset, misalignment, fraction(mesh_position)];
        onset(element, law, at, counts, start)
    };
    let q = [
        pose.coordinates.center_distance - k.center_distance,
        pose.misalignment(i),
    ];
    let at = q.map(T::re);
    let found = touching(at, 0.0)?;
    let mut slopes = [0.0; 2];
    for (axis, slope) in slopes.iter_mut().enumerate() {
        if !T::CARRIES || !law.follows()[axis] {
            continue;
        }
        let beside = |step: f64| {
            let mut x = at;
            x[axis] += step;
            touching(x, found + STEP)
        };
        *slope = (beside(STEP)? - beside(-STEP)?) / (2.0 * STEP);
    }
    let elongation = lift(found, &slopes, &q) - pose.lever * q[1];
    Ok(Latch {
        tooth_angle: (elongation + pose.coordinates.half_gap) * (s * k.tooth_angle_per)
            - pose.coordinates.turn * k.tooth_angle_per,
        mesh_position: (-pose.mesh_position(k, i) + mesh_position) * s,
    })
}

/// The largest elongation, m, at which a flank carries nothing at this centre distance offset (m), misalignment and mesh position,
/// within half a base pitch about zero, where the force rises; `start` (m) is looked at first.
///
/// Energy, force and stiffness are those of a power of the distance to the onset, the more so the nearer it is: they tell the
/// distance, so that a few evaluations are enough. Where they mislead, bisection goes on.
fn onset(
    element: &Element,
    law: &Law,
    [offset, misalignment, mesh_position]: [f64; 3],
    counts: Counts,
    start: f64,
) -> Result<f64, ElementError> {
    /// First step, m, in search of a load: reliefs are larger, so that none is met by chance far inside.
    const FIRST: f64 = 1e-6;
    /// To which the onset is found, m: a hundredth of the rounding of microns.
    const NEAR: f64 = 1e-17;
    /// Evaluations after which bisection takes over.
    const MOST: usize = 20;
    let quarter = 0.25 * element.constants.base_pitch;
    let (mut free, mut pressed) = (-quarter, quarter);
    let (mut next, mut step) = (start, FIRST);
    for tried in 0.. {
        let w = law.respond([next, offset, misalignment, mesh_position], counts, false)?;
        let force = w.gradient[0];
        let guess = if force > 0.0 {
            pressed = next;
            let way = w.energy / force / (1.0 - w.energy / force * (w.stiffness / force));
            // Not a number under a law without energy.
            pressed
                - if way > 0.0 {
                    (0.99 * way).max(3.0 * NEAR)
                } else {
                    f64::NAN
                }
        } else {
            free = next;
            step *= 4.0;
            if pressed < quarter {
                pressed
            } else {
                free + step
            }
        };
        let middle = 0.5 * (free + pressed);
        // Two neighbouring numbers, or nothing but rounding of the zero between them.
        if middle == free || middle == pressed || pressed - free < 4.0 * NEAR {
            break;
        }
        let helps = free < guess && guess < pressed && tried < MOST;
        next = if helps { guess } else { middle };
    }
    Ok(free - ROUNDING * element.constants.base_pitch)
}

/// The phases of the body frames, unless the teeth overlap there by more than a load of the table brings about.
fn absolute<T: Scalar>(element: &Element, pose: &Pose<T>) -> Result<Latch<T>, ElementError> {
    let k = &element.constants;
    let latch = Latch {
        tooth_angle: T::from(0.0),
        mesh_position: T::from(0.0),
    };
    let q = &pose.coordinates;
    let per_tooth = k.per_tooth_angle;
    let x = wrap(q.turn.re() / per_tooth) * per_tooth;
    let offset = q.center_distance.re() - k.center_distance;
    let scale = element.law_scale(k.base_sum / q.center_distance.re());
    for (i, law) in element.laws.iter().enumerate() {
        let Some(law) = law else { continue };
        let s = FLANKS[i].sign();
        let misalignment = pose.misalignment(i).re();
        let delta = s * x - q.half_gap.re() + pose.lever.re() * misalignment;
        let position = fraction(pose.mesh_position(k, i).re());
        let counts = pose.counts(k, i, &latch);
        let at = [delta * scale, offset, misalignment, position];
        let force = law.respond(at, counts, false)?.gradient[0];
        if force > element.largest_force {
            let touching = onset(element, law, [offset, misalignment, position], counts, 0.0)?;
            return Err(ElementError::TeethOverlap {
                overlap_um: 1e6 * (delta - touching),
                force_kn: 1e-3 * force,
                largest_kn: 1e-3 * element.largest_force,
                turn_rad: -s * (delta - touching) / k.rb[0],
            });
        }
    }
    Ok(latch)
}
