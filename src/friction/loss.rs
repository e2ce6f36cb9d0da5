//! Power lost to friction between the teeth.

use std::f64::consts::PI;

use super::{FrictionLaw, Sliding};
use crate::gear::PairGeometry;

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
