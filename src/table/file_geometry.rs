//! The pair geometry as it stands in a tables file, so that packing and the element need no pair file.

use super::TableError;
use crate::gear::{Body, Gear, GearKind, PairGeometry};
use serde::{Deserialize, Serialize};

/// `external` or `ring`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    External,
    Ring,
}

/// One gear; the fields of [`Gear`] with their units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GearRecord {
    kind: Kind,
    teeth: u32,
    hand: f64,
    normal_module_m: f64,
    normal_pressure_angle_rad: f64,
    helix_angle_rad: f64,
    profile_shift: f64,
    face_width_m: f64,
    face_offset_m: f64,
    tip_radius_m: f64,
    /// Absent where the tips have none, so that files without chamfers stay what they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tip_chamfer_m: Option<f64>,
    dedendum_coefficient: f64,
    tool_tip_radius_coefficient: f64,
    held_radius_m: f64,
    /// Absent where the body is a full disc.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    body: Option<BodyRecord>,
    /// Absent where the held surface is rigid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    foundation_n_per_m3: Option<f64>,
    tooth_thinning_m: f64,
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
}

/// Rim, web and hub; the fields of [`Body`] with their units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyRecord {
    rim_radius_m: f64,
    web_z_m: [f64; 2],
    hub_radius_m: f64,
    hub_z_m: [f64; 2],
}

/// Geometry of the pair, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryRecord {
    gear1: GearRecord,
    gear2: GearRecord,
    center_distance_m: f64,
}

impl From<&PairGeometry> for GeometryRecord {
    fn from(pair: &PairGeometry) -> Self {
        let gear = |g: &Gear| GearRecord {
            kind: match g.kind {
                GearKind::External => Kind::External,
                GearKind::Ring => Kind::Ring,
            },
            teeth: g.teeth,
            hand: g.hand,
            normal_module_m: g.normal_module,
            normal_pressure_angle_rad: g.normal_pressure_angle,
            helix_angle_rad: g.helix_angle,
            profile_shift: g.profile_shift,
            face_width_m: g.face_width,
            face_offset_m: g.face_offset,
            tip_radius_m: g.tip_radius,
            tip_chamfer_m: (g.tip_chamfer != 0.0).then_some(g.tip_chamfer),
            dedendum_coefficient: g.dedendum_coefficient,
            tool_tip_radius_coefficient: g.tool_tip_radius_coefficient,
            held_radius_m: g.held_radius,
            body: g.body.map(|b| BodyRecord {
                rim_radius_m: b.rim_radius,
                web_z_m: b.web,
                hub_radius_m: b.hub_radius,
                hub_z_m: b.hub,
            }),
            foundation_n_per_m3: g.foundation,
            tooth_thinning_m: g.tooth_thinning,
            youngs_modulus_pa: g.youngs_modulus,
            poisson_ratio: g.poisson_ratio,
        };
        GeometryRecord {
            gear1: gear(&pair.gears[0]),
            gear2: gear(&pair.gears[1]),
            center_distance_m: pair.center_distance,
        }
    }
}

impl GeometryRecord {
    /// Refuses a `pair` that no checked pair file gives.
    ///
    /// # Errors
    /// As [`GeometryRecord::pair_geometry`].
    pub fn check(pair: &PairGeometry) -> Result<(), TableError> {
        GeometryRecord::from(pair).pair_geometry().map(drop)
    }

    /// The checked geometry.
    ///
    /// # Errors
    /// A number that no gear of a checked pair file has.
    pub fn pair_geometry(&self) -> Result<PairGeometry, TableError> {
        let gears = [
            self.gear1.gear("geometry.gear1")?,
            self.gear2.gear("geometry.gear2")?,
        ];
        let pair = PairGeometry {
            gears,
            center_distance: self.center_distance_m,
        };
        let rings = pair
            .gears
            .iter()
            .filter(|g| g.kind == GearKind::Ring)
            .count();
        if rings == 2 {
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
        Ok(pair)
    }
}

impl GearRecord {
    fn gear(&self, name: &str) -> Result<Gear, TableError> {
        let positive = [
            ("normal_module_m", self.normal_module_m),
            ("normal_pressure_angle_rad", self.normal_pressure_angle_rad),
            ("face_width_m", self.face_width_m),
            ("tip_radius_m", self.tip_radius_m),
            ("dedendum_coefficient", self.dedendum_coefficient),
            ("held_radius_m", self.held_radius_m),
            ("youngs_modulus_pa", self.youngs_modulus_pa),
        ];
        for (field, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(damaged(
                    &format!("{name}.{field}"),
                    value,
                    "it must be positive",
                ));
            }
        }
        let within = [
            ("hand", self.hand, -1.0, 1.0),
            (
                "normal_pressure_angle_rad",
                self.normal_pressure_angle_rad,
                0.0,
                0.8,
            ),
            ("helix_angle_rad", self.helix_angle_rad, 0.0, 1.4),
            ("profile_shift", self.profile_shift, -10.0, 10.0),
            ("face_offset_m", self.face_offset_m, -1e3, 1e3),
            (
                "tool_tip_radius_coefficient",
                self.tool_tip_radius_coefficient,
                0.0,
                2.0,
            ),
            ("tooth_thinning_m", self.tooth_thinning_m, -1.0, 1.0),
            ("tip_chamfer_m", self.tip_chamfer_m.unwrap_or(0.0), 0.0, 1e3),
            ("poisson_ratio", self.poisson_ratio, -1.0, 0.5),
        ];
        for (field, value, low, high) in within {
            if !(low..=high).contains(&value) {
                return Err(damaged(
                    &format!("{name}.{field}"),
                    value,
                    &format!("it must lie in [{low}, {high}]"),
                ));
            }
        }
        if self.hand.abs() != 1.0 {
            return Err(damaged(
                &format!("{name}.hand"),
                self.hand,
                "it must be 1 or -1",
            ));
        }
        if self.teeth == 0 {
            return Err(damaged(&format!("{name}.teeth"), 0, "a gear has teeth"));
        }
        if let Some(stiffness) = self.foundation_n_per_m3
            && !(stiffness > 0.0 && stiffness.is_finite())
        {
            return Err(damaged(
                &format!("{name}.foundation_n_per_m3"),
                stiffness,
                "it must be positive",
            ));
        }
        Ok(Gear {
            kind: match self.kind {
                Kind::External => GearKind::External,
                Kind::Ring => GearKind::Ring,
            },
            teeth: self.teeth,
            hand: self.hand,
            normal_module: self.normal_module_m,
            normal_pressure_angle: self.normal_pressure_angle_rad,
            helix_angle: self.helix_angle_rad,
            profile_shift: self.profile_shift,
            face_width: self.face_width_m,
            face_offset: self.face_offset_m,
            tip_radius: self.tip_radius_m,
            tip_chamfer: self.tip_chamfer_m.unwrap_or(0.0),
            dedendum_coefficient: self.dedendum_coefficient,
            tool_tip_radius_coefficient: self.tool_tip_radius_coefficient,
            held_radius: self.held_radius_m,
            body: self
                .body
                .as_ref()
                .map(|b| b.body(&format!("{name}.body")))
                .transpose()?,
            foundation: self.foundation_n_per_m3,
            tooth_thinning: self.tooth_thinning_m,
            youngs_modulus: self.youngs_modulus_pa,
            poisson_ratio: self.poisson_ratio,
        })
    }
}

impl BodyRecord {
    fn body(&self, name: &str) -> Result<Body, TableError> {
        let ([w0, w1], [h0, h1]) = (self.web_z_m, self.hub_z_m);
        let ordered = self.hub_radius_m > 0.0
            && self.rim_radius_m > self.hub_radius_m
            && self.rim_radius_m.is_finite()
            && h0 <= w0
            && w0 < w1
            && w1 <= h1
            && (h1 - h0).is_finite();
        if !ordered {
            return Err(damaged(
                name,
                format!("{self:?}"),
                "rim, web and hub must follow each other from outside to inside, the web within the hub's ends",
            ));
        }
        Ok(Body {
            rim_radius: self.rim_radius_m,
            web: self.web_z_m,
            hub_radius: self.hub_radius_m,
            hub: self.hub_z_m,
        })
    }
}

fn damaged(field: &str, value: impl ToString, reason: &str) -> TableError {
    TableError::field(
        field,
        value,
        reason,
        "make the tables again from the pair file",
    )
}
