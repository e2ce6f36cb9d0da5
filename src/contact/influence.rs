//! How segments give way to each other's forces, divided between bulk and local contact.

use nalgebra::DMatrix;

use super::local::{
    Piece,
    constants::{SMOOTHING_OVER_LAYER, SMOOTHING_OVER_REFERENCE},
    divide,
};
use super::{candidates::Candidate, transverse::PairNumbers};
use crate::compliance::{BeyondModel, Strip, ToothCompliance};

/// Influence of segments on each other and what completes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// Displacement of segment i per force on segment j, m/N, less what the local contact has taken over.
    pub bulk: DMatrix<f64>,
    /// Reference lengths of the local contact, per gear, m.
    pub lengths: [Vec<f64>; 2],
}

impl Influence {
    /// Of `candidates`, as the gears see them in `seen`, by the elastic models `compliance`; the local contact asks for the
    /// reference length `reference`, m.
    pub fn new(
        numbers: &PairNumbers,
        compliance: [&dyn ToothCompliance; 2],
        candidates: &[Candidate],
        seen: &[[Strip; 2]],
        reference: f64,
    ) -> Result<Influence, BeyondModel> {
        let n = candidates.len();
        let mut bulk = DMatrix::zeros(n, n);
        let mut lengths = [Vec::new(), Vec::new()];
        for (i, model) in compliance.iter().enumerate() {
            let segments: Vec<Strip> = seen.iter().map(|both| both[i]).collect();
            // The models know forces along the normal of their own flank. Where a tip edge bears, the force acts along that of
            // its mate. What turns the body and bends the tooth is its component along the circumference, by the arm that of
            // the force along the own normal; measured: within a tenth of what the direction does to the transmission error.
            let mut own = model.bulk(&segments)?;
            for (r, c) in candidates.iter().enumerate() {
                own.row_mut(r).scale_mut(c.arms[i]);
                own.column_mut(r).scale_mut(c.arms[i]);
            }
            bulk += own;
            lengths[i] = model.reference_lengths(&segments);
        }
        // Rounding must not break the symmetry that the energy rests on.
        let mut bulk = 0.5 * (&bulk + bulk.transpose());
        let cos_beta_b = numbers.cos_beta_b;
        let pieces: Vec<Piece> = candidates
            .iter()
            .map(|c| Piece {
                line: c.tooth_pair,
                at: c.middle() / cos_beta_b,
                length: c.length(cos_beta_b),
            })
            .collect();
        let layers = compliance.map(|model| model.lengthwise_resolution() / cos_beta_b);
        divide(
            &mut bulk,
            &mut lengths,
            numbers
                .plane_compliance
                .map(|p| 2.0 * p / std::f64::consts::PI),
            &pieces,
            reference,
            (SMOOTHING_OVER_LAYER * layers[0].max(layers[1]))
                .max(SMOOTHING_OVER_REFERENCE * reference),
        );
        Ok(Influence { bulk, lengths })
    }
}
