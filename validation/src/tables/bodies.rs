//! The element on bodies that are no solids of revolution against static contact with the body at its angle, over a turn.

#[rustfmt::skip] // formatted where it stands
#[path = "../../../tests/common/element.rs"]
mod element;

use crate::data::{Data, rms};
use crate::in_repository;
use crate::setup::cache;
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use element::spun;
use gearmesh::element::{
    Element, Formulation, Inputs, LoadedFlank, Parameters, PhaseOffset, StiffnessModel,
};
use gearmesh::gear::Flank;
use gearmesh::table::Table;
use gearmesh_preprocessor::contact::{ElasticModels, ModelSettings};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::ContactResult;
use gearmesh_preprocessor::table::{Made, Recipe};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Places of the mesh cycle that are compared.
const PLACES: [f64; 2] = [0.1, 0.6];

/// A body for gear 2 of a shipped pair.
struct Case {
    pair: &'static str,
    body: &'static str,
    fields: Value,
    /// Whether the tables know misalignments, and with them the place of the force.
    is_tilted: bool,
}

fn cases() -> [Case; 3] {
    let holes = |circle: f64, diameter: f64| json!({ "count": 5, "circle_diameter_mm": circle, "diameter_mm": diameter, "angle_deg": 20 });
    [
        Case {
            pair: "fzg-c",
            body: "disc with five holes of 20 mm",
            fields: json!({ "web_holes": holes(60.0, 20.0) }),
            is_tilted: false,
        },
        Case {
            pair: "helical-25-47",
            body: "disc with five holes of 22 mm",
            fields: json!({ "web_holes": holes(88.0, 22.0) }),
            is_tilted: true,
        },
        Case {
            pair: "planet-ring-27-84",
            body: "ring of 206 mm on four pins of 8 mm",
            fields: json!({
                "rim_diameter_mm": 206,
                "rim_pins": { "count": 4, "circle_diameter_mm": 194, "diameter_mm": 8 },
            }),
            is_tilted: false,
        },
    ]
}

/// A pair whose gear 2 has a body that is no solid of revolution, with its tables.
struct Turning {
    models: ElasticModels,
    made: Made,
}

/// Static contact with the body at its angle: the mesh cycle, the place in it, and what it says.
type Known = (f64, f64, ContactResult);

/// Errors of an element against static contact, over the nominal force and half the face.
#[derive(Default)]
struct Errors {
    force: Vec<f64>,
    place: Vec<f64>,
}

impl Turning {
    fn new(case: &Case, refinement: Refinement, recipe: &Recipe) -> Result<Turning> {
        let path = in_repository(&format!("resources/pairs/{}.json", case.pair));
        let mut file: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        for (name, value) in case.fields.as_object().into_iter().flatten() {
            file["gear2"][name] = value.clone();
        }
        let pair = Pair {
            refinement,
            ..pair::from_json(&file.to_string())?
        };
        let settings = ModelSettings {
            cache: Some(cache()),
            ..ModelSettings::default()
        };
        let models = ElasticModels::new(&pair, &settings, &|_, _| ())?;
        let recipe = Recipe {
            center_distance: false,
            misalignment: case.is_tilted,
            ..*recipe
        };
        let made = recipe.compute(&models, &|_, _| ())?;
        Ok(Turning { models, made })
    }

    fn element(&self, flank: Flank, model: StiffnessModel, body_effect: bool) -> Result<Element> {
        let is_tilted = self.made.file.axes.misalignment.len() > 1;
        let parameters = Parameters {
            stiffness_model: model,
            body_effect,
            center_distance_effect: false,
            misalignment_effect: is_tilted,
            shuttling_effect: is_tilted,
            formulation: Formulation::Conjugate,
            loaded_flank: match flank {
                Flank::Drive => LoadedFlank::Drive,
                Flank::Coast => LoadedFlank::Coast,
            },
            damping: 0.0,
            ..Parameters::default()
        };
        let geometry = &self.models.pair.geometry;
        let contact = self.made.contact.as_ref();
        Ok(match contact.filter(|_| model == StiffnessModel::Contact) {
            Some(contact) => Element::with_contact(geometry, &parameters, contact)?,
            None => {
                let table = Table::from_file(self.made.file.clone())?;
                Element::new(geometry, &parameters, Some(Arc::new(table)))?
            }
        })
    }

    /// Under the nominal torque, over a turn of gear 2 in steps of so many mesh `cycles`.
    fn known(&self, flank: Flank, cycles: usize) -> Result<Vec<Known>> {
        let pair = &self.models.pair;
        let mut known = vec![];
        for cycle in (0..pair.geometry.gears[1].teeth).step_by(cycles) {
            let solver = self.models.solver.clone().after(flank, 1, cycle);
            for place in PLACES {
                let problem = solver.position(flank, place, 0.0)?;
                let torque = pair.operating.nominal_torque;
                let found = problem.solve_torque(torque, 0.0, None)?;
                known.push((f64::from(cycle), place, found));
            }
        }
        Ok(known)
    }

    /// Poses and phases of `element` at the transmission errors of static contact.
    fn poses(
        &self,
        element: &Element,
        flank: Flank,
        known: &[Known],
    ) -> Result<(PhaseOffset, Vec<Inputs>)> {
        let geometry = &self.models.pair.geometry;
        let start = element.nominal_inputs();
        let phase = element.phase_offset(&start)?;
        let (s, e) = (flank.sign(), geometry.e());
        let [z1, z2] = [0, 1].map(|i| geometry.gears[i].z());
        let along = element.line_of_action(geometry.center_distance);
        let mut poses = vec![];
        for (cycle, place, known) in known {
            let turn = s * TAU * (cycle + place) / z1;
            let pose = spun(&spun(&start, 0, turn), 1, -e * turn * z1 / z2);
            let present = s * element.evaluate(&phase, &pose)?.transmission_error * along;
            let more = (known.approach - present) / geometry.gears[1].base_radius();
            poses.push(spun(&pose, 1, s * e * more));
        }
        Ok((phase, poses))
    }

    fn errors(&self, element: &Element, flank: Flank, known: &[Known]) -> Result<Errors> {
        let geometry = &self.models.pair.geometry;
        let along = element.line_of_action(geometry.center_distance);
        let half_face = 0.5 * geometry.face_overlap().1;
        let (phase, poses) = self.poses(element, flank, known)?;
        let mut errors = Errors::default();
        for (pose, (.., known)) in poses.iter().zip(known) {
            let out = element.evaluate(&phase, pose)?;
            let force = out.tangential_force / along;
            errors.force.push(force / known.loa_force - 1.0);
            errors
                .place
                .push((out.contact_z - known.contact_z) / half_face);
        }
        Ok(errors)
    }
}

/// Errors over a turn of the body, and what the effect costs.
///
/// # Errors
/// Files that cannot be written; contact that cannot be solved.
pub fn report(context: &Context, data: &Data) -> Result<()> {
    let refinement = match context.quick {
        true => Refinement::Coarse,
        false => Refinement::Normal,
    };
    let mut rows = vec![];
    for case in cases() {
        let turning = Turning::new(&case, refinement, &Recipe::default())?;
        for (flank, name) in [(Flank::Drive, "drive"), (Flank::Coast, "coast")] {
            let known = turning.known(flank, 1)?;
            let [on, off] =
                [true, false].map(|effect| turning.element(flank, StiffnessModel::Table, effect));
            let (on, off) = (on?, off?);
            let [with, without] = [&on, &off].map(|el| turning.errors(el, flank, &known));
            let (with, without) = (with?, without?);
            let (phase, poses) = turning.poses(&on, flank, &known)?;
            let times = medians(&mut [
                Candidate::over(&poses, |pose| on.evaluate(&phase, pose)),
                Candidate::over(&poses, |pose| off.evaluate(&phase, pose)),
            ]);
            let cost = times[0] / times[1];
            let bodies = turning.made.file.bodies.as_ref();
            let orders = bodies.map_or(0, |bodies| bodies.flank(flank)[1].len());
            rows.push(format!(
                "{} | {} | {name} | {orders} | {:.2} | {:.2} | {:.2} | {:.2} | {cost:.1}",
                case.pair,
                case.body,
                100.0 * rms(without.force),
                100.0 * rms(with.force),
                100.0 * rms(without.place),
                100.0 * rms(with.place),
            ));
        }
    }
    let head = "pair | body of gear 2 | flank | orders | force on the mean body, % rms | force, % rms | \
                place on the mean body, % of half the face rms | place, % of half the face rms | time over that on the mean body";
    data.table("bodies", head, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the mean body the force is several times as far off.
    #[test]
    fn the_element_follows_a_body_over_its_turn_as_static_contact_does() {
        for case in cases() {
            let turning = Turning::new(&case, Refinement::Coarse, &Recipe::default()).unwrap();
            for flank in [Flank::Drive, Flank::Coast] {
                let known = turning.known(flank, 2).unwrap();
                let [with, without] = [true, false].map(|body_effect| {
                    let element = turning.element(flank, StiffnessModel::Table, body_effect);
                    let errors = turning.errors(&element.unwrap(), flank, &known);
                    errors.unwrap()
                });
                let [force, mean_body] = [with.force, without.force].map(rms);
                let text = format!("{} {flank:?}: {force:.5} {mean_body:.5}", case.pair);
                assert!(force < 3e-3 && mean_body > 5.0 * force, "{text}");
                assert!(rms(with.place) < 2e-3, "{text}");
            }
        }
    }

    #[test]
    fn contact_at_run_time_and_tooth_pairs_feel_the_body_as_tables_do() {
        let recipe = Recipe {
            contact: true,
            teeth: true,
            ..Recipe::default()
        };
        let turning = Turning::new(&cases()[0], Refinement::Coarse, &recipe).unwrap();
        let flank = Flank::Drive;
        let known = turning.known(flank, 3).unwrap();
        for model in [StiffnessModel::Contact, StiffnessModel::Teeth] {
            let [with, without] = [true, false].map(|body_effect| {
                let element = turning.element(flank, model, body_effect).unwrap();
                rms(turning.errors(&element, flank, &known).unwrap().force)
            });
            let text = format!("{model:?}: {with:.5} {without:.5}");
            assert!(with < 3e-3 && without > 5.0 * with, "{text}");
        }
    }
}
