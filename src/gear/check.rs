//! What a pair out of a file must fulfil before anything is computed from it.

use super::{Gear, GearKind, PairGeometry};
use crate::words::shown;
use thiserror::Error;

/// A number that no gear of a checked pair file has.
#[derive(Debug, Error)]
#[error("geometry.{field} = {value}: {reason}; make this file again from the pair file")]
pub struct GeometryError {
    field: String,
    value: String,
    reason: String,
}

fn damaged(field: String, value: impl ToString, reason: impl Into<String>) -> GeometryError {
    GeometryError {
        field,
        value: shown(&value.to_string()),
        reason: reason.into(),
    }
}

impl PairGeometry {
    /// Refuses numbers that no checked pair file gives.
    ///
    /// # Errors
    /// The first such number, by field.
    pub fn check(&self) -> Result<(), GeometryError> {
        check_gear(&self.gears[0], "gear1")?;
        check_gear(&self.gears[1], "gear2")?;
        if self.gears.iter().all(|g| g.kind == GearKind::Ring) {
            return Err(damaged("gear2.kind".into(), "ring", "both gears are rings"));
        }
        let (distance, least) = (self.center_distance, self.base_radius_sum());
        if !(distance > least && distance.is_finite() && least > 0.0) {
            let reason =
                format!("it must be above {least}, where the base circles leave no pressure angle");
            return Err(damaged("center_distance_m".into(), distance, reason));
        }
        let offset = self.gears[1].face_offset;
        if self.face_overlap().1 <= 0.0 {
            let reason = "the faces do not overlap";
            return Err(damaged("gear2.face_offset_m".into(), offset, reason));
        }
        Ok(())
    }
}

fn check_gear(gear: &Gear, name: &str) -> Result<(), GeometryError> {
    let any = [f64::MIN_POSITIVE, f64::MAX];
    let ranges = [
        ("normal_module_m", gear.normal_module, any),
        ("face_width_m", gear.face_width, any),
        ("tip_radius_m", gear.tip_radius, any),
        ("dedendum_coefficient", gear.dedendum_coefficient, any),
        ("held_radius_m", gear.held_radius, any),
        ("youngs_modulus_pa", gear.youngs_modulus, any),
        ("foundation_n_per_m3", gear.foundation.unwrap_or(1.0), any),
        (
            "normal_pressure_angle_rad",
            gear.normal_pressure_angle,
            [1e-9, 0.8],
        ),
        ("helix_angle_rad", gear.helix_angle, [0.0, 1.4]),
        ("profile_shift", gear.profile_shift, [-10.0, 10.0]),
        ("face_offset_m", gear.face_offset, [-1e3, 1e3]),
        (
            "tool_tip_radius_coefficient",
            gear.tool_tip_radius_coefficient,
            [0.0, 2.0],
        ),
        ("tooth_thinning_m", gear.tooth_thinning, [-1.0, 1.0]),
        ("tip_chamfer_m", gear.tip_chamfer, [0.0, 1e3]),
        ("poisson_ratio", gear.poisson_ratio, [-1.0, 0.5]),
        ("teeth", gear.z(), [1.0, f64::MAX]),
    ];
    for (field, value, [low, high]) in ranges {
        if !(low..=high).contains(&value) {
            let reason = match [low, high] {
                range if range == any => "it must be positive".to_owned(),
                [_, f64::MAX] => format!("it must be at least {low}"),
                _ => format!("it must lie in [{low}, {high}]"),
            };
            return Err(damaged(format!("{name}.{field}"), value, reason));
        }
    }
    if gear.hand.abs() != 1.0 {
        let reason = "it must be 1 or -1";
        return Err(damaged(format!("{name}.hand"), gear.hand, reason));
    }
    let Some(body) = &gear.body else {
        return Ok(());
    };
    let ([w0, w1], [h0, h1]) = (body.web, body.hub);
    let is_nested = h0 <= w0 && w0 < w1 && w1 <= h1 && (h1 - h0).is_finite();
    let (hub, rim) = (body.hub_radius, body.rim_radius);
    let is_stepped = rim > hub || body.is_shaft() && rim == hub;
    if is_nested && is_stepped && hub > 0.0 && rim.is_finite() {
        return Ok(());
    }
    let reason = "rim, web and hub must follow each other from outside to inside, the web within the hub's ends";
    Err(damaged(format!("{name}.body"), format!("{body:?}"), reason))
}
