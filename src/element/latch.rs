//! Phase zeros from the initial pose.

use super::error::ElementError;
use super::motion::{Inputs, Latch};
use super::parameters::{LoadedFlank, PhaseReference};
use super::scalar::wrap;
use super::{Element, geometry::FLANKS};

/// Overlap of flanks at the initial pose, over the base pitch, above which an absolute phase is refused.
const LARGEST_OVERLAP: f64 = 0.02;

/// What a formulation sees of the teeth's angular position.
pub(crate) struct Phase {
    /// Tooth angle without latch, rad, 2 pi per pitch; the drive flank is compressed by
    /// (tooth_angle - half_gap) rb1/z1.
    pub tooth_angle: f64,
    /// Half the gap, rad of tooth angle.
    pub half_gap: f64,
    /// Mesh position of both flanks without latch.
    pub mesh_position: [f64; 2],
}

/// The latch that `element` takes from `inputs`.
pub(crate) fn latch(element: &Element, inputs: &Inputs) -> Result<Latch, ElementError> {
    let phase = element.phase(inputs)?;
    let parameters = &element.parameters;
    let k = &element.constants;
    match parameters.phase_reference {
        PhaseReference::FromInitialPose => {
            let i = element.reference_flank;
            let s = FLANKS[i].sign();
            Ok(Latch {
                tooth_angle: s * phase.half_gap - phase.tooth_angle,
                mesh_position: s * (parameters.mesh_phase / k.pitch_angle - phase.mesh_position[i]),
            })
        }
        PhaseReference::Absolute => {
            let x = wrap(phase.tooth_angle);
            let overlap = match parameters.loaded_flank {
                LoadedFlank::Drive => x - phase.half_gap,
                LoadedFlank::Coast => -x - phase.half_gap,
                LoadedFlank::Both => x.abs() - phase.half_gap,
            };
            if overlap > LARGEST_OVERLAP * std::f64::consts::TAU {
                let sign = if parameters.loaded_flank == LoadedFlank::Coast
                    || (parameters.loaded_flank == LoadedFlank::Both && x < 0.0)
                {
                    1.0
                } else {
                    -1.0
                };
                return Err(ElementError::TeethOverlap {
                    overlap_mm: 1e3 * overlap * k.rb[0] / k.z[0],
                    turn_rad: sign * overlap / k.z[0],
                });
            }
            Ok(Latch::default())
        }
    }
}
