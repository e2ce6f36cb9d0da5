//! How the load of a mesh slides, the moments of the line loads over the distance from the pitch point, and the power that it
//! loses.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{FrictionLaw, SegmentContact};
use crate::gear::{Gear, PairGeometry, PairNumbers};

/// Over the base pitch: distance from the pitch point within which the direction of friction turns,
/// s / sqrt(s² + this²). Of the order of the width of contact, within which flanks neither roll nor slide.
const TRANSITION_OVER_PITCH: f64 = 0.02;

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
    /// Share, share_z, distance and weight, in the order of their tables.
    pub fn to_array(&self) -> [f64; 4] {
        [self.share, self.share_z, self.distance, self.weight]
    }

    /// Mirrored at mid-face.
    #[must_use]
    pub fn mirrored(&self) -> Sliding {
        Sliding {
            share_z: -self.share_z,
            ..*self
        }
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
    numbers: PairNumbers,
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
        let numbers = PairNumbers::new(pair);
        let [first, second] = numbers.base_radius;
        SlidingSums {
            law: *law,
            plane_compliance: pair.gears.iter().map(Gear::plane_compliance).sum(),
            per_roll_angle: numbers.kappa[0] / (1.0 / first + numbers.e / second),
            rolling_per_angle: first / pair.rolling_speed_per_spin(pair.center_distance),
            transition: TRANSITION_OVER_PITCH * numbers.base_pitch,
            numbers,
        }
    }

    /// Adds to `sum` the part `share` of the normal force at the lengths of `roll` (m) on gear 1 and gear 2 and at `lever` = z - z_ref
    /// (m), under `line_load` (N/m, along the contact line).
    ///
    /// The distance from the pitch point follows from the lengths of roll, so that it is that of the flank and the tip edge where
    /// contact has left the path.
    pub fn add(&self, sum: &mut Sliding, share: f64, roll: [f64; 2], lever: f64, line_load: f64) {
        let angles = [0, 1].map(|i| roll[i] / self.numbers.base_radius[i]);
        let weight = if self.law.is_local() {
            let curvature: f64 = (0..2).map(|i| self.numbers.kappa[i] / roll[i]).sum();
            self.law.weight(&SegmentContact {
                line_load,
                radius: (self.numbers.cos_beta_b * curvature).recip(),
                plane_compliance: self.plane_compliance,
                rolling: angles.map(|angle| self.rolling_per_angle * angle),
            })
        } else {
            1.0
        };
        let s = (angles[0] - angles[1]) * self.per_roll_angle;
        let (weight, sign) = (weight * share, s / s.hypot(self.transition));
        sum.weight += weight;
        sum.share += weight * sign;
        sum.share_z += weight * sign * lever;
        sum.distance += weight * s.abs();
    }
}

/// Loss factor of Ohlendorf at `center_distance` (m): the share of the power that is lost at mu = 1 while the
/// tooth pairs in contact share the load evenly,
/// H_V = pi |1/z1 + e/z2| / cos beta_b (1 - eps_a + eps_1² + eps_2²), eps_1 and eps_2 the parts of the
/// transverse contact ratio in recess and approach, 1 <= eps_a <= 2.
pub fn ohlendorf(pair: &PairGeometry, center_distance: f64) -> f64 {
    let path = pair.path_of_contact(center_distance);
    let [recess, approach] = [path.end, -path.start].map(|part| part / pair.base_pitch());
    let teeth = 1.0 / pair.gears[0].z() + pair.e() / pair.gears[1].z();
    PI * teeth.abs() / pair.base_helix_angle().cos()
        * (1.0 - recess - approach + recess * recess + approach * approach)
}

/// Loss factor of a load that slides by `distance` (m, [`Sliding::distance`]) on the mean: the share of the power
/// that is lost at mu = 1.
pub fn loss_factor_of(pair: &PairGeometry, distance: f64) -> f64 {
    pair.sliding_per_spin() * distance
        / (pair.gears[0].base_radius() * pair.base_helix_angle().cos())
}

/// Friction of a mesh cycle at one load and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loss {
    /// Coefficient of friction, the mean over the cycle weighted with load times sliding, as the loss is: times the loss factor by
    /// the share of the load and the transmitted power it is the power lost.
    pub coefficient: f64,
    /// Mean power lost, W.
    pub power: f64,
    /// 1 - lost over transmitted power.
    pub efficiency: f64,
}

impl Loss {
    /// Of a mesh cycle under `torque` (N m, > 0) on gear 1, which turns with `spin` (rad/s) against the line of
    /// centres: how it slides with every segment counted alike, and weighted by `law`.
    pub fn new(
        pair: &PairGeometry,
        law: &FrictionLaw,
        [even, weighted]: [&[Sliding]; 2],
        torque: f64,
        spin: f64,
    ) -> Loss {
        let [even, weighted] = [even, weighted].map(Sliding::mean_distance);
        let rolling = spin.abs() * pair.rolling_speed_per_spin(pair.center_distance);
        let force = torque / pair.gears[0].base_radius();
        let mu = law.coefficient(pair).at(force, rolling);
        let lost = mu * loss_factor_of(pair, weighted);
        Loss {
            coefficient: mu * if law.is_local() { weighted / even } else { 1.0 },
            power: lost * torque * spin.abs(),
            efficiency: 1.0 - lost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::testing::{FZG, c14};

    #[test]
    fn ohlendorfs_factor_of_four_pairs_is_that_of_the_literature() {
        for (name, pair, _, listed, _) in FZG.map(|data| data.pair()) {
            let found = ohlendorf(&pair, pair.center_distance);
            // 0.1986 belongs to tips that were not shortened (contact ratio 1.46).
            let bound = if name == "C14" { 0.02 } else { 1e-3 };
            assert!((found / listed - 1.0).abs() < bound, "{name}: {found}");
        }
        let mut long = c14();
        long.gears[0].tip_radius = 0.5 * 82.64e-3;
        long.gears[1].tip_radius = 0.5 * 118.54e-3;
        let found = ohlendorf(&long, long.center_distance);
        assert!(
            (found / 0.1986 - 1.0).abs() < 1e-3,
            "C14 with full tips: {found}"
        );
    }
}
