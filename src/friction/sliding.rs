//! How the load of a mesh slides: the moments of the line loads over the distance from the pitch point.

use serde::{Deserialize, Serialize};

use super::{FrictionLaw, SegmentContact};
use crate::gear::PairGeometry;

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

    /// Share, share_z, distance and weight, in the order of their tables.
    pub fn to_array(&self) -> [f64; 4] {
        [self.share, self.share_z, self.distance, self.weight]
    }

    /// Mean of the distances of `all`, m.
    pub fn mean_distance(all: &[Sliding]) -> f64 {
        all.iter().map(|s| s.distance).sum::<f64>() / all.len() as f64
    }
}

/// Adds up [`Sliding`] of one pair, segment by segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingSums {
    law: FrictionLaw,
    base_radius: [f64; 2],
    kappa: [f64; 2],
    cos_beta_b: f64,
    /// (1 - nu1²)/E1 + (1 - nu2²)/E2, 1/Pa.
    plane_compliance: f64,
    /// Distance from the pitch point over the difference of both angles of roll, m.
    per_roll_angle: f64,
    /// Rolling speed over the angle of roll while those at the pitch point add up to 1 m/s, m/s.
    rolling_per_angle: f64,
    transition: f64,
}

impl SlidingSums {
    /// Those of `pair`, weighted by `law`.
    pub fn new(pair: &PairGeometry, law: &FrictionLaw) -> SlidingSums {
        let g = &pair.gears;
        let base_radius = g.each_ref().map(|g| g.base_radius());
        let softness = |g: &crate::gear::Gear| (1.0 - g.poisson_ratio.powi(2)) / g.youngs_modulus;
        SlidingSums {
            law: *law,
            base_radius,
            kappa: g.each_ref().map(|g| g.kappa()),
            cos_beta_b: pair.base_helix_angle().cos(),
            plane_compliance: g.iter().map(softness).sum(),
            per_roll_angle: g[0].kappa() / (1.0 / base_radius[0] + pair.e() / base_radius[1]),
            rolling_per_angle: base_radius[0] / pair.rolling_speed_per_spin(pair.center_distance),
            transition: TRANSITION_OVER_PITCH * pair.base_pitch(),
        }
    }

    /// Adds to `sum` the part `share` of the normal force at the lengths of `roll` (m) on gear 1 and gear 2 and at `lever` = z - z_ref
    /// (m), under `line_load` (N/m, along the contact line).
    ///
    /// The distance from the pitch point follows from the lengths of roll, so that it is that of the flank and the tip edge where
    /// contact has left the path.
    pub fn add(&self, sum: &mut Sliding, share: f64, roll: [f64; 2], lever: f64, line_load: f64) {
        let angles = [0, 1].map(|i| roll[i] / self.base_radius[i]);
        let weight = if self.law.is_local() {
            let curvature: f64 = (0..2).map(|i| self.kappa[i] / roll[i]).sum();
            self.law.weight(&SegmentContact {
                line_load,
                radius: (self.cos_beta_b * curvature).recip(),
                plane_compliance: self.plane_compliance,
                rolling: angles.map(|angle| self.rolling_per_angle * angle),
            })
        } else {
            1.0
        };
        let s = (angles[0] - angles[1]) * self.per_roll_angle;
        sum.add(weight * share, s, lever, self.transition);
    }
}
