//! How segments deflect under each other's forces through teeth and bodies, as solves need it.

use nalgebra::{DMatrix, DVector};

use super::setup::ContactSetup;

/// Influence of segments on each other and what completes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// Displacement of segment i per force on segment j, m/N, less what the local contact has taken over.
    pub bulk: DMatrix<f64>,
    /// Reference lengths of the local contact, per gear, m.
    pub lengths: [Vec<f64>; 2],
    /// How `bulk` changes with the places along the profile; `None`: contact stays where undeformed flanks come closest.
    pub motion: Option<Motion>,
}

/// Change of the bulk matrix A with the places xi of contact along the profile (m towards the tip of gear 1, from where the undeformed flanks
/// come closest): A_ij + xi_i B_ij + xi_j B_ji, and xi_i² C_i more on the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// B: by how much flank i is tilted per force on segment j, 1/N, positive where it opens towards the tip of gear 1.
    pub tilt: DMatrix<f64>,
    /// C: half the second derivative, 1/(N m), of the deflection of segment i where it and its contact line, evenly loaded, move alike. Loads and
    /// places are smooth along a line, so that one number a segment is enough. Not negative: what lets contact move on by itself lies beyond the step.
    pub bend: DVector<f64>,
    /// Distance to the places beside, at which it was taken, m.
    pub step: f64,
}

/// Distance to the places at which the motion is taken, over the normal module: about an element, so that what its size leaves of a moving load
/// cancels, and small beside the height of a tooth.
const STEP_OVER_MODULE: f64 = 0.1;

impl Motion {
    /// None, of `segments` segments of the pair `setup`.
    pub fn still(segments: usize, setup: &ContactSetup) -> Motion {
        Motion {
            tilt: DMatrix::zeros(segments, segments),
            bend: DVector::zeros(segments),
            step: STEP_OVER_MODULE * setup.geometry.gears[0].normal_module,
        }
    }
}
