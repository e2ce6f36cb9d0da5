//! A pair file in the making, and the fields that both gears have in common.

use gearmesh::words::rounded;

use super::account::{Account, Head};
use super::given::{Given, agreed, first, near, vector};
use super::model::{Component, Model, Result, refused};

/// Versions whose names of attributes are known.
pub(super) const VERSIONS: [[u32; 2]; 2] = [[1, 4], [2, 0]];

/// A pair file in the making.
pub(super) struct Draft<'a> {
    pub model: &'a Model,
    pub stage: &'a Component,
    pub gears: [&'a Component; 2],
    /// Each gear and its flanks.
    pub teeth: [Vec<&'a Component>; 2],
    pub account: Account,
}

impl<'a> Draft<'a> {
    pub(super) fn taken(&mut self, field: &str, given: &Given) {
        self.account.add(
            Head::Taken,
            format!("{field} from {}: {}", given.origin, given.value),
        );
    }

    /// Components of one of `kinds` related to gear `i` or its flanks.
    pub(super) fn beside(&self, i: usize, kinds: &[&str]) -> Vec<&'a Component> {
        self.teeth[i]
            .iter()
            .flat_map(|c| self.model.related(&c.id, |k| kinds.contains(&k)))
            .collect()
    }

    pub(super) fn required(
        &mut self,
        field: &str,
        parts: &[&Component],
        name: &str,
    ) -> Result<f64> {
        let Some(given) = agreed(field, parts, &[name])? else {
            let ids: Vec<&str> = parts.iter().map(|c| &*c.id).collect();
            return refused(format!(
                "none of the components {} has `{name}`",
                ids.join(", ")
            ));
        };
        self.taken(field, &given);
        Ok(given.value)
    }

    /// Whether gear `i` is a ring: by its kind, or by negative teeth as in ISO 21771.
    pub(super) fn is_ring(&self, i: usize) -> bool {
        let teeth = first(&self.teeth[i], &["number_of_teeth"]);
        self.gears[i].kind == "ring_gear"
            || teeth.is_ok_and(|z| z.is_some_and(|given| given.value < 0.0))
    }

    pub(super) fn check_version(&mut self) {
        let version = &self.model.version;
        let mut numbers = version.split('.').map(|part| part.parse::<u32>().ok());
        let [major, minor] = [(); 2].map(|()| numbers.next().flatten());
        let known = major.map(|major| [major, minor.unwrap_or(0)]);
        if !known.is_some_and(|version| VERSIONS[0] <= version && version <= VERSIONS[1]) {
            let line = format!(
                "the file has version {version:?}; names of versions 1.4 to 2.0 are known, and others may be left out"
            );
            self.account.add(Head::Warning, line);
        }
    }

    /// The helix angle on gear 1, degrees, > 0 right-handed. External gears have opposite hands; for a ring both signs are in use.
    pub(super) fn helix(&mut self, is_internal: bool) -> Result<f64> {
        let name = "helix_angle_reference_diameter";
        let field = "helix_angle_deg (> 0: right-handed)";
        let [one, two] = [0, 1].map(|i| agreed(field, &self.teeth[i], &[name]));
        match (one?, two?) {
            (None, None) => {
                self.account.add(Head::Assumed, "helix_angle_deg = 0");
                Ok(0.0)
            }
            (None, Some(two)) => {
                let value = if is_internal { two.value } else { -two.value };
                self.account.add(
                    Head::Derived,
                    format!("helix_angle_deg = {value} from {}", two.origin),
                );
                Ok(value)
            }
            (Some(one), two) => {
                if let Some(two) = two {
                    let fits =
                        near(two.value, -one.value) || is_internal && near(two.value, one.value);
                    if !fits {
                        return refused(format!(
                            "helix_angle_deg: {} = {}, and {} = {}; the gears of an external stage have the same angle and opposite \
                             hands, those of an internal one the same angle",
                            one.origin, one.value, two.origin, two.value
                        ));
                    }
                }
                self.taken(field, &one);
                Ok(one.value)
            }
        }
    }

    /// The centre distance, mm: that of the stage, else from the positions of the gears.
    pub(super) fn center_distance(&mut self) -> Result<Option<f64>> {
        let given = first(&[self.stage], &["center_distance"])?;
        let positions = self.distance_of_positions()?;
        match (given, positions) {
            (Some(given), positions) => {
                self.taken("center_distance_mm", &given);
                let mm = given.value.abs();
                if let Some(other) = positions.filter(|other| (other - mm).abs() > 1e-3) {
                    let line = format!(
                        "center_distance_mm = {mm} of the stage, but the positions of the gears are {other} mm apart"
                    );
                    self.account.add(Head::Warning, line);
                }
                Ok(Some(mm))
            }
            (None, Some(mm)) => {
                let line = format!(
                    "center_distance_mm = {mm} from support_vector and u_axis_vector of both gears"
                );
                self.account.add(Head::Derived, line);
                Ok(Some(mm))
            }
            (None, None) => Ok(None),
        }
    }

    /// Distance of the axes, mm; none where positions or a direction are missing, or on one axis.
    pub(super) fn distance_of_positions(&self) -> Result<Option<f64>> {
        let [mut points, mut axes] = [[None; 2]; 2];
        for i in 0..2 {
            for c in [vec![self.gears[i]], self.beside(i, &["shaft"])].concat() {
                points[i] = points[i].or(vector(c, "support_vector")?);
                axes[i] = axes[i].or(vector(c, "u_axis_vector")?);
            }
        }
        let ([Some(a), Some(b)], Some(axis)) = (points, axes[0].or(axes[1])) else {
            return Ok(None);
        };
        let [a, b, axis] = [a, b, axis].map(nalgebra::Vector3::from);
        let distance = axis
            .try_normalize(1e-9)
            .map(|axis| (b - a).cross(&axis).norm());
        Ok(distance.map(rounded).filter(|mm| *mm > 0.0))
    }
}
