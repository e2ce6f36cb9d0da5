//! Poses that have no meaning are refused here.

use super::constants::Constants;
use super::error::ElementError;
use super::motion::{Inputs, Motion};

/// Departure from an orthonormal right-handed matrix above which an orientation is refused.
const ROTATION_TOLERANCE: f64 = 1e-6;

/// All inputs finite, both orientations rotations; the carrier only if `with_carrier`.
pub(crate) fn inputs(inputs: &Inputs, with_carrier: bool) -> Result<(), ElementError> {
    motion("gear1", &inputs.gears[0])?;
    motion("gear2", &inputs.gears[1])?;
    if with_carrier {
        motion("carrier", &inputs.carrier)?;
    }
    Ok(())
}

fn motion(body: &'static str, m: &Motion) -> Result<(), ElementError> {
    // One comparison on the usual path: a sum is finite only if all its terms are.
    let total = m.p.sum() + m.v.sum() + m.w.sum() + m.r.sum();
    if !total.is_finite() {
        let quantity = [
            ("position", m.p.sum()),
            ("orientation", m.r.sum()),
            ("velocity", m.v.sum()),
            ("angular velocity", m.w.sum()),
        ]
        .into_iter()
        .find(|(_, sum)| !sum.is_finite())
        .map_or("their sum", |(name, _)| name);
        return Err(ElementError::NotFinite { body, quantity });
    }
    let (x, y, z) = (m.r.column(0), m.r.column(1), m.r.column(2));
    let third = x.cross(&y) - z;
    let departures = [
        x.norm_squared() - 1.0,
        y.norm_squared() - 1.0,
        x.dot(&y),
        third.x,
        third.y,
        third.z,
    ];
    // The largest one is not above their sum, as a rule far below the limit.
    let mut sum = 0.0;
    for d in &departures {
        sum += d.abs();
    }
    if sum > ROTATION_TOLERANCE {
        let departure = departures
            .iter()
            .fold(0.0, |most: f64, d| most.max(d.abs()));
        if departure > ROTATION_TOLERANCE {
            return Err(ElementError::NotARotation { body, departure });
        }
    }
    Ok(())
}

/// The axes of `body` and `reference`, whose unit vectors have the product `cosine`, run alike.
pub(crate) fn tilt(
    body: &'static str,
    reference: &'static str,
    cosine: f64,
    limit: f64,
) -> Result<(), ElementError> {
    if cosine < limit.cos() {
        return Err(ElementError::Tilt {
            body,
            reference,
            tilt_deg: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            limit_deg: limit.to_degrees(),
        });
    }
    Ok(())
}

/// Whether there is a line of action at the centre distance `c`; false: no tooth is within reach of another.
///
/// # Errors
/// Base circles without a common tangent, except for an internal pair pulled apart so far that its
/// teeth have already left each other.
pub(crate) fn has_line_of_action(k: &Constants, c: f64) -> Result<bool, ElementError> {
    if c > k.base_sum {
        return Ok(true);
    }
    let apart = k.e < 0.0 && k.reach.none > k.base_sum * (1.0 + 1e-6);
    // The direction O1 -> O2 must be more than rounding.
    if apart && c > 1e-6 * k.center_distance {
        return Ok(false);
    }
    Err(ElementError::NoLineOfAction {
        center_distance_mm: 1e3 * c,
        limit_mm: 1e3 * k.base_sum,
        nominal_m: k.center_distance,
    })
}
