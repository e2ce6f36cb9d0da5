//! Modifications of the flanks.

use gearmesh::words::rounded;
use serde_json::{Map, Value, json};

use super::account::Head;
use super::draft::Draft;
use super::given::{first, um};
use super::model::{Attribute, Component, Result};
use super::teeth::Fields;

impl<'a> Draft<'a> {
    /// Modifications of both flanks of gear `i`.
    pub(super) fn modifications(&mut self, i: usize, fields: &mut Fields) -> Result<()> {
        let left = self.flank(i, "left")?;
        let right = self.flank(i, "right")?;
        if left == right {
            fields.extend(left);
            return Ok(());
        }
        let gear = i + 1;
        let (head, side, line) = match self.loaded_flank() {
            Some((side, origin)) => {
                let line =
                    format!("gear{gear}: the {side} flank is the drive flank, from {origin}");
                (Head::Taken, side, line)
            }
            None => {
                let line = format!(
                    "gear{gear}: the left flank is the drive flank; turn the two if the stage is driven the other way"
                );
                (Head::Assumed, "left", line)
            }
        };
        self.account.add(head, line);
        let [drive, coast] = match side {
            "left" => [left, right],
            _ => [right, left],
        };
        fields.insert("drive_flank".into(), drive.into());
        fields.insert("coast_flank".into(), coast.into());
        Ok(())
    }

    /// Modifications of the flank of gear `i` on this `side` in fields of the pair file.
    pub(super) fn flank(&mut self, i: usize, side: &str) -> Result<Fields> {
        let (model, gear, name) = (self.model, self.gears[i], ["gear1", "gear2"][i]);
        let mut fields = Map::new();
        let mut flanks = model
            .relations
            .iter()
            .filter(|r| r.kind == "flank" && r.names(&gear.id));
        let Some(flank) = flanks.find_map(|r| model.component(r.role(side)?)) else {
            return Ok(fields);
        };
        for c in model.related(&flank.id, |_| true) {
            let Component { id, kind, .. } = c;
            let left = format!("{kind} {id} of the flank {}", flank.id);
            let words = ["relief", "modification", "deviation", "profile_twist"];
            if let Some((field, value)) = self.modification(&format!("{name}.{kind}"), c)? {
                self.account.add(
                    Head::Taken,
                    format!("{name}.{field} from {kind} {id}: {value}"),
                );
                fields.insert(field.into(), value);
            } else if ["profile_slope", "helix_slope"].contains(&&**kind) {
                // Its sign depends on which face and flank it counts from.
                self.account.add(
                    Head::Warning,
                    format!(
                        "{left} left out: enter it with the sign of docs/pair-file.md: {}",
                        values(c)
                    ),
                );
            } else if words.iter().any(|word| kind.contains(word)) {
                self.account.add(Head::Left, left.clone());
                self.account
                    .add(Head::Warning, format!("{left} left out: {}", values(c)));
            }
        }
        Ok(fields)
    }

    /// Field and value of the modification `c`; none of another kind, and where its amount is not given.
    pub(super) fn modification(
        &mut self,
        path: &str,
        c: &'a Component,
    ) -> Result<Option<(&'a str, Value)>> {
        let kind = &*c.kind;
        let (field, depth, mut value, assumed) = match kind {
            "profile_crowning" | "helix_crowning" => {
                let (field, ends) = match kind {
                    "profile_crowning" => ("profile_crowning_um", ["at_root", "at_tip"]),
                    _ => (
                        "lead_crowning_um",
                        ["amount_datum_face", "amount_non_datum_face"],
                    ),
                };
                let [a, b] = ends.map(|end| mm(c, &format!("{kind}_{end}")));
                let [a, b] = [a?, b?].map(|mm| mm.map(um));
                if let (Some(um), None) | (None, Some(um)) = (a, b) {
                    let line = format!("{path}: {um} um at both ends; the file gives one end");
                    self.account.add(Head::Assumed, line);
                }
                let [a, b] = [a.or(b), b.or(a)].map(|um| um.unwrap_or(0.0));
                if a != b {
                    self.account.add(
                        Head::Assumed,
                        format!("{path}: the mean of {a} and {b} um at its two ends"),
                    );
                }
                return Ok(Some((field, json!(rounded(0.5 * (a + b))))));
            }
            "tip_relief" | "root_relief" => {
                let diameter = mm(c, &format!("{kind}_datum_diameter"))?;
                let length =
                    mm(c, &format!("{kind}_datum_length"))?.filter(|_| kind == "tip_relief");
                let start = match (diameter, length) {
                    (Some(d), _) => json!({ "diameter_mm": d.abs() }),
                    (None, Some(length)) => json!({ "from_tip_mm": length }),
                    (None, None) => json!("pitch_point"),
                };
                let assumed = start.is_string().then_some("starts at the pitch point");
                let depth = mm(c, &format!("{kind}_depth"))?;
                (kind, depth, json!({ "start": start }), assumed)
            }
            "end_relief_datum_face" | "end_relief_non_datum_face" => {
                let side = &kind["end_relief_".len()..];
                let field = match side {
                    "datum_face" => "lower_end_relief",
                    _ => "upper_end_relief",
                };
                let length = mm(c, &format!("end_relief_length_{side}"))?;
                let depth =
                    mm(c, &format!("end_relief_depth_{side}"))?.filter(|_| length.is_some());
                let assumed = Some("the datum face is that at z = 0");
                (field, depth, json!({ "length_mm": length }), assumed)
            }
            _ => return Ok(None),
        };
        let Some(depth) = depth else { return Ok(None) };
        if let Some(assumed) = assumed {
            self.account
                .add(Head::Assumed, format!("{path}: {assumed}"));
        }
        let shape = c.attribute("shape_of_relief").map(Attribute::shown);
        value["amount_um"] = json!(um(depth));
        value["shape"] = match shape.as_deref().unwrap_or("none") {
            shape @ ("linear" | "parabolic") => shape,
            "circular" => "arc",
            other => {
                self.account.add(
                    Head::Assumed,
                    format!("{path}.shape = linear ({other} in the file)"),
                );
                "linear"
            }
        }
        .into();
        Ok(Some((field, value)))
    }
}

/// The attribute `name` of `component`, mm.
fn mm(component: &Component, name: &str) -> Result<Option<f64>> {
    Ok(first(&[component], &[name])?.map(|given| given.value))
}

/// Attributes of `component` with their values.
fn values(component: &Component) -> String {
    let all = component.attributes.iter();
    let all = all.map(|a| format!("{} = {} {}", a.id, a.shown(), a.unit));
    all.collect::<Vec<_>>().join(", ")
}
