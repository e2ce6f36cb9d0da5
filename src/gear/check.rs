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

fn ensure(
    is_fine: bool,
    field: &str,
    value: impl ToString,
    reason: impl ToString,
) -> Result<(), GeometryError> {
    let error = || GeometryError {
        field: field.to_owned(),
        value: shown(&value.to_string()),
        reason: reason.to_string(),
    };
    is_fine.then_some(()).ok_or_else(error)
}

impl PairGeometry {
    /// Refuses numbers that no checked pair file gives.
    ///
    /// # Errors
    /// The first such number, by field.
    pub fn check(&self) -> Result<(), GeometryError> {
        check_gear(&self.gears[0], "gear1")?;
        check_gear(&self.gears[1], "gear2")?;
        let has_external = self.gears.iter().any(|g| g.kind == GearKind::External);
        ensure(has_external, "gear2.kind", "ring", "both gears are rings")?;
        let (distance, least) = (self.center_distance, self.base_radius_sum());
        let is_mesh = distance > least && distance.is_finite() && least > 0.0;
        let reason =
            format!("it must be above {least}, where the base circles leave no pressure angle");
        ensure(is_mesh, "center_distance_m", distance, reason)?;
        let (offset, overlap) = (self.gears[1].face_offset, self.face_overlap().1);
        let reason = "the faces do not overlap";
        ensure(overlap > 0.0, "gear2.face_offset_m", offset, reason)
    }
}

fn check_gear(gear: &Gear, name: &str) -> Result<(), GeometryError> {
    let any = [f64::MIN_POSITIVE, f64::MAX];
    let (alpha_n, round) = (gear.normal_pressure_angle, gear.tool_tip_radius_coefficient);
    for (field, value, [low, high]) in [
        ("normal_module_m", gear.normal_module, any),
        ("face_width_m", gear.face_width, any),
        ("tip_radius_m", gear.tip_radius, any),
        ("dedendum_coefficient", gear.dedendum_coefficient, any),
        ("held_radius_m", gear.held_radius, any),
        ("youngs_modulus_pa", gear.youngs_modulus, any),
        ("foundation_n_per_m3", gear.foundation.unwrap_or(1.0), any),
        ("normal_pressure_angle_rad", alpha_n, [1e-9, 0.8]),
        ("helix_angle_rad", gear.helix_angle, [0.0, 1.4]),
        ("profile_shift", gear.profile_shift, [-10.0, 10.0]),
        ("face_offset_m", gear.face_offset, [-1e3, 1e3]),
        ("tool_tip_radius_coefficient", round, [0.0, 2.0]),
        ("tooth_thinning_m", gear.tooth_thinning, [-1.0, 1.0]),
        ("tip_chamfer_m", gear.tip_chamfer, [0.0, 1e3]),
        ("poisson_ratio", gear.poisson_ratio, [-1.0, 0.5]),
        ("teeth", gear.z(), [1.0, f64::MAX]),
    ] {
        let reason = match [low, high] {
            range if range == any => "it must be positive".to_owned(),
            [_, f64::MAX] => format!("it must be at least {low}"),
            _ => format!("it must lie in [{low}, {high}]"),
        };
        let is_within = (low..=high).contains(&value);
        ensure(is_within, &format!("{name}.{field}"), value, reason)?;
    }
    let (hand, field) = (gear.hand, format!("{name}.hand"));
    ensure(hand.abs() == 1.0, &field, hand, "it must be 1 or -1")?;
    let Some(body) = &gear.body else {
        return Ok(());
    };
    let ([w0, w1], [h0, h1]) = (body.web, body.hub);
    let is_nested = h0 <= w0 && w0 < w1 && w1 <= h1 && (h1 - h0).is_finite();
    let (hub, rim) = (body.hub_radius, body.rim_radius);
    let is_stepped = rim > hub || body.is_shaft() && rim == hub;
    let is_fine = is_nested && is_stepped && hub > 0.0 && rim.is_finite();
    let reason = "rim, web and hub must follow each other from outside to inside, the web within the hub's ends";
    ensure(
        is_fine,
        &format!("{name}.body"),
        format!("{body:?}"),
        reason,
    )
}
