//! Friction of the flanks: from load and sliding to loads that never do work on the gears.
//!
//! With the row of [`Map::friction_row`], r the mean sliding speed and N the normal force,
//!
//! ```text
//! k = factor mu(F_bt, v_sum) N r / sqrt(r^2 + v_t^2),    power = -k r <= 0,
//! ```
//!
//! v_t the speed of transition ([`Parameters::friction_transition_speed`]): below it friction grows with the
//! speed, so that a pair under load at rest creeps with less than v_t instead of sticking. Through the pitch point
//! share and distance are smooth functions of the mesh position.

use super::constants::Constants;
use super::dual::Scalar;
use super::flank::FlankLoad;
use super::kinematics::{Map, Spatial};
use super::parameters::Parameters;
use crate::friction::{Coefficient, FrictionLaw, LOWEST_ROLLING_SPEED};
use crate::gear::PairGeometry;
use crate::table::FrictionRecord;

/// Over the largest weight of a table: least one that the sliding distance is divided by, a hundred times what samples are
/// rounded to.
const LEAST_WEIGHT: f64 = 1e-4;

/// Likewise without a table, where nothing is rounded.
const NO_WEIGHT: f64 = 1e-12;

/// Friction of one element.
#[derive(Clone)]
pub(crate) struct Friction {
    coefficient: Coefficient,
    /// Speed of transition, squared, m²/s².
    transition: f64,
    /// Sum of the rolling speeds at the pitch point over the spin of gear 1, m.
    rolling_per_spin: f64,
    /// Loss factor over the mean sliding distance, 1/m.
    loss_per_distance: f64,
    /// Least weight that the sliding distance is divided by.
    least_weight: f64,
}

/// Friction of one flank at one state.
pub(crate) struct FlankFriction<T> {
    /// Wrench on gear 2 of a unit friction.
    pub row: Spatial<T>,
    /// k, N.
    pub force: T,
    /// r, m/s.
    pub speed: T,
    /// Coefficient in force, weights of the segments included.
    pub coefficient: T,
    /// Part of the transmitted power that is lost at a coefficient of 1.
    pub loss_factor: T,
}

impl Friction {
    /// Of `pair` with the coefficient of `law` and the sliding in `record`, or that of the elastic law.
    pub(crate) fn new(
        pair: &PairGeometry,
        p: &Parameters,
        law: &FrictionLaw,
        record: Option<&FrictionRecord>,
    ) -> Friction {
        let mut coefficient = law.coefficient(pair);
        coefficient.scale *= p.friction_factor;
        let least_weight = record.map_or(NO_WEIGHT, |record| {
            let weights = record.drive.weight.iter().flatten().copied();
            LEAST_WEIGHT * weights.fold(0.0, f64::max)
        });
        Friction {
            coefficient,
            transition: p.friction_transition_speed.powi(2),
            rolling_per_spin: pair.rolling_speed_per_spin(pair.center_distance),
            loss_per_distance: crate::friction::loss_factor_of(pair, 1.0),
            least_weight,
        }
    }

    /// Friction of a flank under `load` > 0, of share, axial share, distance and weight as given, while gear 2 moves against gear 1 with
    /// `twist` and gear 1 turns with `spin` (rad/s) against the line of centres.
    #[inline(always)]
    pub(crate) fn on_flank<T: Scalar>(
        &self,
        k: &Constants,
        map: &Map<T>,
        load: &FlankLoad<T>,
        [share, share_z, distance, weight]: [T; 4],
        twist: &Spatial<T>,
        spin: T,
    ) -> FlankFriction<T> {
        let row = map.friction_row(k, load.sign, [share, share_z, distance]);
        let rolling = spin * spin * self.rolling_per_spin.powi(2) + LOWEST_ROLLING_SPEED.powi(2);
        let c = &self.coefficient;
        let mut mu = T::from(c.scale);
        if c.by_load != 0.0 {
            mu *= load.elastic.powf(c.by_load);
        }
        if c.by_speed != 0.0 {
            mu *= rolling.powf(-0.5 * c.by_speed);
        }
        // Where all flanks just roll, as those of a spur pair with one tooth pair at the pitch point, both are zero to
        // rounding; on the way there the distance vanishes before the weight.
        let divisor = match weight.re() > self.least_weight {
            true => weight,
            false => T::from(self.least_weight),
        };
        let speed = -row.power(twist);
        let sign = speed / (speed * speed + self.transition).sqrt();
        FlankFriction {
            force: mu * load.elastic * k.per_cos_beta_b * sign,
            row,
            speed,
            coefficient: mu * weight,
            loss_factor: distance / divisor * self.loss_per_distance,
        }
    }
}
