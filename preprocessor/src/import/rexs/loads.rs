//! The load of a stage: the torque of its gears, and the flanks that bear it.

use gearmesh::words::rounded;

use super::account::Head;
use super::draft::Draft;
use super::given::first;
use super::model::{Attribute, Component, Result};
use super::teeth::Basic;

impl<'a> Draft<'a> {
    /// What the stage says of gear `i` under load: as it stands, then in the only load case.
    pub(super) fn gear_data(&self, i: usize) -> Vec<&'a Component> {
        let model = self.model;
        let mut relations = model.relations.iter();
        let id = relations.find_map(|r| {
            let is_own = r.kind == GEAR_DATA
                && r.role("stage") == Some(&self.stage.id)
                && r.role("gear") == Some(&self.gears[i].id);
            r.role(GEAR_DATA).filter(|_| is_own)
        });
        let Some(id) = id else { return Vec::new() };
        let only = match &model.load_cases[..] {
            [only] => &only.components[..],
            _ => &[],
        };
        let loaded = only.iter().filter(|c| c.id == id);
        model.component(id).into_iter().chain(loaded).collect()
    }

    /// The torque on gear 1 of the pair, N m, of the gear that has one; none where no load or several are given.
    pub(super) fn torque(&mut self, basic: &Basic) -> Result<Option<f64>> {
        let field = "operating.nominal_torque_nm";
        for i in [0, 1] {
            let given = first(&self.gear_data(i), &["torque"])?;
            let Some(given) = given.filter(|given| given.value != 0.0) else {
                continue;
            };
            let ratio = (basic.teeth[0] / basic.teeth[i]).abs();
            let torque = rounded(given.value.abs() * ratio);
            let (head, more) = match i {
                0 => (Head::Taken, ""),
                _ => (Head::Derived, " by the ratio of the teeth"),
            };
            let line = format!(
                "{field} = {torque} from {}: {}{more}",
                given.origin, given.value
            );
            self.account.add(head, line);
            return Ok(Some(torque));
        }
        Ok(None)
    }

    /// The flank that bears the load, `left` or `right`, and where from. Flanks of one name mesh.
    pub(super) fn loaded_flank(&self) -> Option<(&'static str, String)> {
        // Where they contradict each other, gear 1 counts.
        [0, 1].into_iter().find_map(|gear| {
            self.gear_data(gear).into_iter().find_map(|c| {
                let attribute = c.attribute("loaded_tooth_flank")?;
                let shown = attribute.shown();
                let side = ["left", "right"].into_iter().find(|side| *side == shown)?;
                attribute.is_taken.set(true);
                Some((side, format!("loaded_tooth_flank of {} {}", c.kind, c.id)))
            })
        })
    }

    /// Lists the load cases, of which one at most is taken.
    pub(super) fn list_load_cases(&mut self) {
        if let Some(problem) = &self.model.unread_spectrum {
            let line = format!("load_spectrum: not in the form of REXS: {problem}");
            self.account.add(Head::Left, line);
        }
        let cases = &self.model.load_cases;
        if let [_, _, ..] = cases[..] {
            let torques = cases.iter().take(MOST_LISTED).map(|case| {
                let torques = case
                    .components
                    .iter()
                    .filter(|c| c.kind.ends_with(GEAR_DATA));
                let torques = torques.filter_map(|c| {
                    let value = c.attribute("torque").map(Attribute::shown)?;
                    Some(format!("torque = {value} of {} {}", c.kind, c.id))
                });
                let torques: Vec<String> = torques.collect();
                format!("load case {} ({})", case.id, torques.join(", "))
            });
            let listed = torques.collect::<Vec<_>>().join(", ");
            let more = match cases.len().saturating_sub(MOST_LISTED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let line = format!("{listed}{more}: of several load cases none is taken");
            self.account.add(Head::Left, line);
        }
    }
}

/// Load cases in the account; a spectrum may have hundreds.
const MOST_LISTED: usize = 5;

/// Kind of the relation, role of the component and end of its kind.
pub(super) const GEAR_DATA: &str = "stage_gear_data";
