//! The pair geometry as it stands in a tables file, so that packing and the element need no pair file.

use super::TableError;
use crate::gear::{Body, Gear, GearKind, PairGeometry};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Geometry of the pair, SI: that of [`PairGeometry`] with the units in the names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryRecord {
    #[serde(with = "GearFields")]
    gear1: Gear,
    #[serde(with = "GearFields")]
    gear2: Gear,
    center_distance_m: f64,
}

/// The fields of [`Gear`] with their units.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Gear", deny_unknown_fields)]
struct GearFields {
    kind: GearKind,
    teeth: u32,
    hand: f64,
    #[serde(rename = "normal_module_m")]
    normal_module: f64,
    #[serde(rename = "normal_pressure_angle_rad")]
    normal_pressure_angle: f64,
    #[serde(rename = "helix_angle_rad")]
    helix_angle: f64,
    profile_shift: f64,
    #[serde(rename = "face_width_m")]
    face_width: f64,
    #[serde(rename = "face_offset_m")]
    face_offset: f64,
    #[serde(rename = "tip_radius_m")]
    tip_radius: f64,
    #[serde(rename = "tip_chamfer_m", default, skip_serializing_if = "is_zero")]
    tip_chamfer: f64,
    dedendum_coefficient: f64,
    tool_tip_radius_coefficient: f64,
    #[serde(rename = "held_radius_m")]
    held_radius: f64,
    #[serde(default, skip_serializing_if = "Option::is_none", with = "body")]
    body: Option<Body>,
    #[serde(
        rename = "foundation_n_per_m3",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    foundation: Option<f64>,
    #[serde(rename = "tooth_thinning_m")]
    tooth_thinning: f64,
    #[serde(rename = "youngs_modulus_pa")]
    youngs_modulus: f64,
    poisson_ratio: f64,
}

/// The fields of [`Body`] with their units.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Body", deny_unknown_fields)]
struct BodyFields {
    #[serde(rename = "rim_radius_m")]
    rim_radius: f64,
    #[serde(rename = "web_z_m")]
    web: [f64; 2],
    #[serde(rename = "hub_radius_m")]
    hub_radius: f64,
    #[serde(rename = "hub_z_m")]
    hub: [f64; 2],
    #[serde(default, skip_serializing_if = "crate::gear::is_held_at_its_bore")]
    held_ends: [bool; 2],
}

/// Left out of files, so that those without chamfers stay what they were.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

mod body {
    use super::{Body, BodyFields, Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct There(#[serde(with = "BodyFields")] Body);

    pub fn serialize<S: Serializer>(body: &Option<Body>, to: S) -> Result<S::Ok, S::Error> {
        body.map(There).serialize(to)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Option<Body>, D::Error> {
        Ok(Option::deserialize(from)?.map(|There(body)| body))
    }
}

impl From<&PairGeometry> for GeometryRecord {
    fn from(pair: &PairGeometry) -> Self {
        let [gear1, gear2] = pair.gears.clone();
        GeometryRecord {
            gear1,
            gear2,
            center_distance_m: pair.center_distance,
        }
    }
}

impl GeometryRecord {
    /// The checked geometry.
    ///
    /// # Errors
    /// As [`GeometryRecord::check`].
    pub fn pair_geometry(&self) -> Result<PairGeometry, TableError> {
        let pair = PairGeometry {
            gears: [self.gear1.clone(), self.gear2.clone()],
            center_distance: self.center_distance_m,
        };
        Self::check(&pair)?;
        Ok(pair)
    }

    /// Refuses a `pair` that no checked pair file gives.
    ///
    /// # Errors
    /// A number that no gear of a checked pair file has.
    pub fn check(pair: &PairGeometry) -> Result<(), TableError> {
        check_gear(&pair.gears[0], "geometry.gear1")?;
        check_gear(&pair.gears[1], "geometry.gear2")?;
        if pair.gears.iter().all(|g| g.kind == GearKind::Ring) {
            return Err(damaged(
                "geometry.gear2.kind",
                "ring",
                "both gears are rings",
            ));
        }
        let reach = pair.base_radius_sum();
        if !(pair.center_distance > reach && pair.center_distance.is_finite() && reach > 0.0) {
            return Err(damaged(
                "geometry.center_distance_m",
                pair.center_distance,
                &format!(
                    "it must be above {reach}, where the base circles leave no pressure angle"
                ),
            ));
        }
        let (_, width) = pair.face_overlap();
        if width <= 0.0 {
            return Err(damaged(
                "geometry.gear2.face_offset_m",
                pair.gears[1].face_offset,
                "the faces do not overlap",
            ));
        }
        Ok(())
    }
}

fn check_gear(gear: &Gear, name: &str) -> Result<(), TableError> {
    let positive = [f64::MIN_POSITIVE, f64::MAX];
    let limits = [
        ("normal_module_m", gear.normal_module, positive),
        ("face_width_m", gear.face_width, positive),
        ("tip_radius_m", gear.tip_radius, positive),
        ("dedendum_coefficient", gear.dedendum_coefficient, positive),
        ("held_radius_m", gear.held_radius, positive),
        ("youngs_modulus_pa", gear.youngs_modulus, positive),
        (
            "foundation_n_per_m3",
            gear.foundation.unwrap_or(1.0),
            positive,
        ),
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
    for (field, value, range) in limits {
        let [low, high] = range;
        if !(low..=high).contains(&value) {
            let reason = if range == positive {
                "it must be positive".to_owned()
            } else if high == f64::MAX {
                format!("it must be at least {low}")
            } else {
                format!("it must lie in [{low}, {high}]")
            };
            return Err(damaged(&format!("{name}.{field}"), value, &reason));
        }
    }
    if gear.hand.abs() != 1.0 {
        let name = format!("{name}.hand");
        return Err(damaged(&name, gear.hand, "it must be 1 or -1"));
    }
    let Some(body) = &gear.body else {
        return Ok(());
    };
    let ([w0, w1], [h0, h1]) = (body.web, body.hub);
    let ordered = body.hub_radius > 0.0
        && (body.rim_radius > body.hub_radius
            || body.is_shaft() && body.rim_radius == body.hub_radius)
        && body.rim_radius.is_finite()
        && h0 <= w0
        && w0 < w1
        && w1 <= h1
        && (h1 - h0).is_finite();
    if ordered {
        return Ok(());
    }
    Err(damaged(
        &format!("{name}.body"),
        format!("{body:?}"),
        "rim, web and hub must follow each other from outside to inside, the web within the hub's ends",
    ))
}

fn damaged(field: &str, value: impl ToString, reason: &str) -> TableError {
    TableError::field(
        field,
        value,
        reason,
        "make the tables again from the pair file",
    )
}
