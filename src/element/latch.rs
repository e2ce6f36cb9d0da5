//! Phase zeros from the initial pose.

use super::constants::FLANKS;
use super::error::ElementError;
use super::evaluate::{Pose, pose};
use super::motion::{Inputs, Latch};
use super::parameters::PhaseReference;
use super::scalar::{fraction, wrap};
use super::{Element, law::Law};
use crate::gear::teeth::Counts;

/// Base pitches by which the start pose stays short of contact, so that rounding does not decide whether the paper's
/// damper, which acts at once, is at work.
const ROUNDING: f64 = 2e-14;

/// The latch that `element` takes from `inputs`.
pub(crate) fn latch(element: &Element, inputs: &Inputs) -> Result<Latch, ElementError> {
    let Ok(pose) = pose(element, inputs)? else {
        return Err(ElementError::OutOfReach);
    };
    match element.parameters.phase_reference {
        PhaseReference::FromInitialPose => from_initial_pose(element, &pose),
        PhaseReference::Absolute => absolute(element, &pose),
    }
}

/// The phases with which the pose is the one where the reference flank is about to carry.
fn from_initial_pose(element: &Element, pose: &Pose<f64>) -> Result<Latch, ElementError> {
    let k = &element.constants;
    let i = element.reference_flank;
    let s = FLANKS[i].sign();
    let mesh_position = element.parameters.mesh_phase / k.pitch_angle;
    let law = element.laws[i].as_ref().ok_or(ElementError::OutOfReach)?;
    // The pair of teeth 0 touches where the mesh position is 0.
    let counts = [mesh_position.floor() as i64; 2];
    let touching = onset(element, law, pose, i, (mesh_position, counts));
    let elongation = touching - pose.lever * pose.misalignment(i);
    let per_tooth = k.per_tooth_angle;
    Ok(Latch {
        tooth_angle: s * (elongation + pose.coordinates.half_gap) / per_tooth
            - pose.coordinates.turn / per_tooth,
        mesh_position: s * (mesh_position - pose.mesh_position(k, i)),
    })
}

/// The largest elongation, m, at which flank `i` carries nothing: by bisection within half a base pitch about zero,
/// where the force rises.
fn onset(
    element: &Element,
    law: &Law,
    pose: &Pose<f64>,
    i: usize,
    (mesh_position, counts): (f64, Counts),
) -> f64 {
    let k = &element.constants;
    let offset = pose.coordinates.center_distance - k.center_distance;
    let carries = |delta: f64| {
        law.respond(
            [delta, offset, pose.misalignment(i), fraction(mesh_position)],
            counts,
        )
        .gradient[0]
            > 0.0
    };
    let quarter = 0.25 * k.base_pitch;
    let (mut free, mut pressed) = (-quarter, quarter);
    loop {
        let middle = 0.5 * (free + pressed);
        // Two neighbouring numbers, or nothing but rounding of the zero between them.
        if middle == free || middle == pressed || pressed - free < 1e-18 {
            return free - ROUNDING * k.base_pitch;
        }
        if carries(middle) {
            pressed = middle;
        } else {
            free = middle;
        }
    }
}

/// The phases of the body frames, unless the teeth overlap there by more than a load of the table brings about.
fn absolute(element: &Element, pose: &Pose<f64>) -> Result<Latch, ElementError> {
    let k = &element.constants;
    let per_tooth = k.per_tooth_angle;
    let x = wrap(pose.coordinates.turn / per_tooth) * per_tooth;
    let cos_phi = k.base_sum / pose.coordinates.center_distance;
    for (i, law) in element.laws.iter().enumerate() {
        let Some(law) = law else { continue };
        let s = FLANKS[i].sign();
        let misalignment = pose.misalignment(i);
        let elongation = s * x - pose.coordinates.half_gap;
        let position = fraction(pose.mesh_position(k, i));
        let counts = pose.counts(k, i, &Latch::default());
        let delta = elongation + pose.lever * misalignment;
        let force = law
            .respond(
                [
                    delta * element.law_scale(cos_phi),
                    pose.coordinates.center_distance - k.center_distance,
                    misalignment,
                    position,
                ],
                counts,
            )
            .gradient[0];
        if force > element.largest_force {
            let touching = onset(element, law, pose, i, (position, counts));
            return Err(ElementError::TeethOverlap {
                overlap_um: 1e6 * (delta - touching),
                force_kn: 1e-3 * force,
                largest_kn: 1e-3 * element.largest_force,
                turn_rad: -s * (delta - touching) / k.rb[0],
            });
        }
    }
    Ok(Latch::default())
}
