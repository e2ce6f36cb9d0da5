//! Friction of the flanks: from load and sliding to loads that never do work on the gears.
//!
//! With the row of [`Map::slide`], r the mean sliding speed and N the normal force,
//!
//! ```text
//! k = factor mu(F_bt, v_sum) N r / sqrt(r^2 + v_t^2),    power = -k r <= 0,
//! ```
//!
//! v_t the speed of transition ([`super::Parameters::friction_transition_speed`]): below it friction grows with the
//! speed, so that a pair under load at rest creeps with less than v_t instead of sticking. Through the pitch point
//! share and distance are smooth functions of the mesh position.

use super::constants::{Constants, FLANKS};
use super::flank::FlankLoad;
use super::map::{Coordinates, Map, Spatial};
use super::parameters::Parameters;
use super::scalar::{Scalar, lift};
use crate::friction::{Coefficient, FrictionLaw, LOWEST_ROLLING_SPEED};
use crate::gear::PairGeometry;
use crate::table::{LoadJet, Table};
use std::sync::Arc;

/// Over the largest weight of a table: least one that the sliding distance is divided by, a hundred times what samples are
/// rounded to.
const LEAST_WEIGHT: f64 = 1e-4;

/// Friction of one element.
#[derive(Clone)]
pub(crate) struct Friction {
    table: Arc<Table>,
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
pub(crate) struct Rubbing<T> {
    /// Wrench on gear 2 of a unit friction.
    row: Spatial<T>,
    /// Coefficient of the mesh and normal force at full sliding, N.
    full: T,
    /// r, m/s.
    speed: T,
    /// Coefficient in force, weights of the strips included.
    coefficient: T,
    /// Loss factor.
    loss_factor: T,
    /// Relative change of the coefficient with the spin, s.
    by_spin: f64,
}

/// Slopes of friction by the velocities: of the loads along `row`s, see [`Rubbing::by_velocities`].
pub(crate) struct VelocitySlopes {
    /// Minus the slopes of r: wrench on gear 2 of a unit friction.
    pub row: Spatial<f64>,
    /// dk/dr, N s/m.
    pub by_speed: f64,
    /// dk/dspin at fixed r, N s.
    pub by_spin: f64,
    /// d power/dr, N.
    pub power_by_speed: f64,
    /// d power/dspin, N m.
    pub power_by_spin: f64,
    /// d coefficient/dspin, s.
    pub coefficient_by_spin: f64,
}

impl Friction {
    /// Of `pair` with the sliding in `table`; `None` if it is off.
    pub(crate) fn new(pair: &PairGeometry, p: &Parameters, table: &Arc<Table>) -> Option<Friction> {
        let record = table.file().friction.as_ref().filter(|_| p.friction)?;
        let law: FrictionLaw = record.law;
        let weights = record.drive.weight.iter().flatten().copied();
        let mut coefficient = law.coefficient(pair);
        coefficient.scale *= p.friction_factor;
        Some(Friction {
            table: table.clone(),
            coefficient,
            transition: p.friction_transition_speed.powi(2),
            rolling_per_spin: pair.rolling_speed_per_spin(pair.center_distance),
            loss_per_distance: crate::friction::loss_factor_of(pair, 1.0),
            least_weight: LEAST_WEIGHT * weights.fold(0.0, f64::max),
        })
    }

    /// Friction of flank `i` under `load` > 0 while gear 2 moves against gear 1 with `twist`.
    #[inline(always)]
    pub(crate) fn rub<T: Scalar>(
        &self,
        k: &Constants,
        map: &Map<T>,
        center_distance: T,
        (i, load): (usize, &FlankLoad<T>),
        (twist, rates): (&Spatial<T>, &Coordinates<T>),
    ) -> Option<Rubbing<T>> {
        let (table, mirrored) = self.table.sliding(FLANKS[i])?;
        let offset = center_distance - k.center_distance;
        let q = load.table_coordinates(self.table.effects(), offset, mirrored);
        let jets: [LoadJet; 4] = table.evaluate(q.map(T::re));
        let of = |row: usize| lift(jets[row].value, &jets[row].gradient, &q);
        let (share, distance, weight) = (of(0), of(2), of(3));
        let share_z = if mirrored { -of(1) } else { of(1) };
        let row = map.slide(k, load.sign, [share, share_z, distance]);
        // Of gear 1 against the line of centres.
        let spin = -rates.mesh_angle;
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
        let by_spin = -c.by_speed * spin.re() * self.rolling_per_spin.powi(2) / rolling.re();
        Some(Rubbing {
            speed: -row.power(twist),
            row,
            full: mu * load.elastic * k.per_cos_beta_b,
            coefficient: mu * weight,
            loss_factor: distance / divisor * self.loss_per_distance,
            by_spin,
        })
    }

    /// r / sqrt(r² + v_t²).
    #[inline(always)]
    fn sign<T: Scalar>(&self, r: T) -> T {
        r / (r * r + self.transition).sqrt()
    }

    /// Wrench of friction on gear 2, and its power, W, <= 0.
    #[inline(always)]
    pub(crate) fn loads<T: Scalar>(&self, rubbing: &Rubbing<T>) -> (Spatial<T>, T) {
        let k = rubbing.full * self.sign(rubbing.speed);
        (rubbing.row.times(k), -k * rubbing.speed)
    }

    /// Slopes by the velocities.
    pub(crate) fn by_velocities<T: Scalar>(&self, rubbing: &Rubbing<T>) -> VelocitySlopes {
        let (full, r) = (rubbing.full.re(), rubbing.speed.re());
        let root = (r * r + self.transition).sqrt();
        let k = full * r / root;
        let by_speed = full * self.transition / root.powi(3);
        let by_spin = k * rubbing.by_spin;
        VelocitySlopes {
            row: rubbing.row.re(),
            by_speed,
            by_spin,
            power_by_speed: -(by_speed * r + k),
            power_by_spin: -by_spin * r,
            coefficient_by_spin: rubbing.coefficient.re() * rubbing.by_spin,
        }
    }
}

impl<T: Scalar> Rubbing<T> {
    /// Coefficient in force and loss factor.
    pub(crate) fn shown(&self) -> [T; 2] {
        [self.coefficient, self.loss_factor]
    }
}
