//! How the load of a mesh slides: the moments of the line loads over the distance from the pitch point.

use serde::{Deserialize, Serialize};

/// Over the base pitch: distance from the pitch point within which the direction of friction turns,
/// s / sqrt(s² + this²). Of the order of the width of contact, within which flanks neither roll nor slide.
pub const TRANSITION_OVER_PITCH: f64 = 0.02;

/// Sums over the normal forces f of a mesh at the distances s from the pitch point along the line of action (positive in
/// the sense in which contact moves while gear 1 turns in the sense of its loaded flank), over F_bt / cos beta_b;
/// m the weights of the friction law ([`super::FrictionLaw::weight`]). They hold for either sense of rotation.
///
/// With mu the coefficient without these weights, N = mu F_bt / cos beta_b, the friction on gear 1 is the force -N `share`
/// across the line of action at the axial position `share_z` / `share` from mid-face and the moment -N
/// `distance` about its axis, both times the sign of the relative spin; the loss N |omega_rel| `distance`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Sliding {
    /// Sum of m f: 1 for laws of the whole mesh, but for arms of tip edges that differ from the base radius.
    pub weight: f64,
    /// Sum of m f sign(s).
    pub share: f64,
    /// Sum of m f sign(s) (z - z_ref), m.
    pub share_z: f64,
    /// Sum of m f |s|, m: over the same sum with m = 1 it is the coefficient of the loss, over `weight` the mean distance
    /// as friction weighs it.
    pub distance: f64,
}

impl Sliding {
    /// Adds the part `weight` of the force at `s` and `lever` = z - z_ref (m); `transition` (m) see
    /// [`TRANSITION_OVER_PITCH`].
    pub fn add(&mut self, weight: f64, s: f64, lever: f64, transition: f64) {
        let sign = s / s.hypot(transition);
        self.weight += weight;
        self.share += weight * sign;
        self.share_z += weight * sign * lever;
        self.distance += weight * s.abs();
    }

    /// Mean of `all`.
    pub fn mean(all: &[Sliding]) -> Sliding {
        let n = all.len() as f64;
        let of = |part: fn(&Sliding) -> f64| all.iter().map(part).sum::<f64>() / n;
        Sliding {
            weight: of(|s| s.weight),
            share: of(|s| s.share),
            share_z: of(|s| s.share_z),
            distance: of(|s| s.distance),
        }
    }
}
