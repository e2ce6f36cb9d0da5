//! How far what is interpolated is from static contact, measured at random operating points.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Part of its range by which a coordinate counts as on a limit that it lies beyond: poses reach limits within rounding.
const ROUNDING: f64 = 1e-9;

/// Whether `x` lies beyond the ends of `range` (same unit) by more than rounding; NaN does.
pub fn is_beyond([low, high]: [f64; 2], x: f64) -> bool {
    let rounding = ROUNDING * (high - low);
    !(low - rounding..=high + rounding).contains(&x)
}

/// Error of the default interpolant at operating points that are no nodes, relative to the nominal force.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterpolationError {
    /// Number of random operating points.
    pub points: usize,
    /// Force error, root of the mean square, over the nominal force.
    pub force_rms: f64,
    /// Largest force error over the nominal force.
    pub force_maximum: f64,
    /// Error of the shuttling moment, root of the mean square, over nominal force times half the face.
    pub moment_rms: f64,
    /// Largest error of the shuttling moment, likewise.
    pub moment_maximum: f64,
    /// Force errors at the points of [`LOW_LOADS`] over the force that acts there, root of the mean square and largest; absent
    /// where no point has such a load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_load_force: Option<[f64; 2]>,
}

/// Forces over the nominal one at which errors are also given relative to the force that acts.
pub const LOW_LOADS: [f64; 2] = [0.1, 0.25];

impl InterpolationError {
    /// Of errors of force and shuttling moment at random points, each relative to its nominal one, and of the forces there over the
    /// nominal one.
    pub fn of(errors: &[[f64; 3]]) -> Self {
        let [force, moment] = [0, 1].map(|k| rms_and_largest(errors, k));
        let [least, most] = LOW_LOADS;
        let low = errors
            .iter()
            .filter(|[.., acting]| (least..=most).contains(acting));
        let low: Vec<[f64; 1]> = low.map(|[error, _, acting]| [error / acting]).collect();
        InterpolationError {
            points: errors.len(),
            force_rms: force[0],
            force_maximum: force[1],
            moment_rms: moment[0],
            moment_maximum: moment[1],
            low_load_force: (!low.is_empty()).then(|| rms_and_largest(&low, 0)),
        }
    }

    /// Both flanks together: the larger of each.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        InterpolationError {
            points: self.points + other.points,
            force_rms: self.force_rms.max(other.force_rms),
            force_maximum: self.force_maximum.max(other.force_maximum),
            moment_rms: self.moment_rms.max(other.moment_rms),
            moment_maximum: self.moment_maximum.max(other.moment_maximum),
            low_load_force: match (self.low_load_force, other.low_load_force) {
                (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].max(b[1])]),
                (a, b) => a.or(b),
            },
        }
    }
}

/// Root of the mean square of the `k`th of each of `errors`, and the largest.
fn rms_and_largest<const N: usize>(errors: &[[f64; N]], k: usize) -> [f64; 2] {
    let errors = errors.iter().map(|e| e[k]);
    let mean_square = errors.clone().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    [mean_square.sqrt(), errors.map(f64::abs).fold(0.0, f64::max)]
}

/// Error at operating points that are no nodes, relative to the largest stress of the gear over the mesh cycle at
/// nominal torque, nominal centre distance and parallel axes; of both gears and flanks the larger one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootStressError {
    /// Number of random operating points.
    pub points: usize,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub maximum: f64,
}

impl RootStressError {
    /// Of relative errors of gear 1 and gear 2 at random points.
    pub fn of(errors: &[[f64; 2]]) -> Self {
        let [gear1, gear2] = [0, 1].map(|k| rms_and_largest(errors, k));
        RootStressError {
            points: errors.len(),
            rms: gear1[0].max(gear2[0]),
            maximum: gear1[1].max(gear2[1]),
        }
    }

    /// Both flanks together.
    #[must_use]
    pub fn with(self, other: RootStressError) -> RootStressError {
        RootStressError {
            points: self.points + other.points,
            rms: self.rms.max(other.rms),
            maximum: self.maximum.max(other.maximum),
        }
    }
}

impl fmt::Display for InterpolationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "error at {} random points: force {:.2} % rms, {:.2} % at most, of the nominal force; shuttling \
             moment {:.2} % rms, {:.2} % at most, of that force at an end of the face",
            self.points,
            1e2 * self.force_rms,
            1e2 * self.force_maximum,
            1e2 * self.moment_rms,
            1e2 * self.moment_maximum
        )?;
        let Some([rms, largest]) = self.low_load_force.map(|errors| errors.map(|e| 1e2 * e)) else {
            return Ok(());
        };
        let [least, most] = LOW_LOADS;
        write!(
            f,
            "; at {least} to {most} of the nominal force {rms:.2} % rms, {largest:.2} % at most, of the force that acts"
        )
    }
}

impl fmt::Display for RootStressError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "error at {} random points: {:.2} % rms, {:.2} % at most, of the largest stress at nominal torque",
            self.points,
            1e2 * self.rms,
            1e2 * self.maximum
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_under_low_loads_are_relative_to_the_force_that_acts() {
        let error = InterpolationError::of(&[
            [0.01, 0.0, 1.0],
            [0.03125, 0.0, 0.25],
            [-0.015625, 0.0, 0.125],
            [0.01, 0.0, 0.02],
        ]);
        assert_eq!(error.low_load_force, Some([0.125, 0.125]));
        assert!(
            error
                .to_string()
                .ends_with("12.50 % rms, 12.50 % at most, of the force that acts")
        );
        let other = InterpolationError::of(&[[0.01, 0.0, 1.0]]);
        assert_eq!(other.low_load_force, None);
        assert_eq!(other.with(error).low_load_force, error.low_load_force);
    }
}
