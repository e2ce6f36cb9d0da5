//! Whole contact against validation/reference/contact.py: relief, crowning, misalignment, centre distance, helix, wide faces.

use crate::data::{Data, largest, mean, percent, range};
use crate::setup::{models, solver};
use crate::{Context, Result, in_repository};
use gear1::solve_torque_of_gear1;
use gearmesh::gear::Flank;
use gearmesh_preprocessor::finite_element::Settings;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::contact_settings;
use serde::Deserialize;
use std::collections::BTreeMap;

#[path = "../../../tests/common/gear1.rs"]
mod gear1;

#[derive(Deserialize)]
struct Cases {
    cases: BTreeMap<String, Case>,
}

#[derive(Deserialize)]
struct Case {
    title: String,
    pair: serde_json::Value,
    #[serde(default)]
    plane_strain: bool,
    /// Either gear turns half of the approach, as it does here; else gear 2 is held.
    #[serde(default)]
    both_turn: bool,
    center_distance_offset_um: f64,
    /// Torque, N m, and misalignment, mrad.
    loads: Vec<[f64; 2]>,
    positions: Vec<Position>,
}

impl Case {
    /// By how much the data, um, tell tilts to both sides apart that are mirror images, as they are where a cycle of equal
    /// gears begins.
    fn mirror_error(&self, torque: f64, misalignment: f64) -> f64 {
        let first = &self.positions[0];
        let ste = |misalignment| {
            let load = self
                .loads
                .iter()
                .position(|load| *load == [torque, misalignment])?;
            Some(first.ste_um[load])
        };
        match (ste(misalignment), ste(-misalignment)) {
            (Some(a), Some(b)) if first.mesh_position == 0.0 => (a - b).abs(),
            _ => 0.0,
        }
    }
}

/// By load.
#[derive(Deserialize)]
struct Position {
    mesh_position: f64,
    ste_um: Vec<f64>,
    /// Where the resultant crosses the pitch plane; where the data do not tell it, they tell the centroid.
    #[serde(default)]
    contact_z_mm: Vec<f64>,
    #[serde(default)]
    centroid_z_mm: Vec<f64>,
    flank_pressure_mpa: Vec<Option<f64>>,
}

/// Found here and expected at every position of one load.
#[derive(Default, Clone)]
struct Compared {
    ste: Vec<[f64; 2]>,
    contact_z: Vec<[f64; 2]>,
    pressure: Vec<[f64; 2]>,
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    compared(
        context,
        data,
        "reference",
        "tests/data/contact_reference.json",
    )?;
    compared(
        context,
        data,
        "plastic",
        "tests/data/plastic_reference.json",
    )
}

/// The table `name` of the cases in `file`.
fn compared(context: &Context, data: &Data, name: &str, file: &str) -> Result<()> {
    let reference: Cases = serde_json::from_str(&std::fs::read_to_string(in_repository(file))?)?;
    let count = if context.quick { 1 } else { usize::MAX };
    let mut rows = vec![];
    for (case_name, case) in reference.cases.iter().take(count) {
        eprintln!("    {case_name}: {}", case.title);
        for ([torque, misalignment], c) in case.loads.iter().zip(compare(case)?) {
            let column = |i: usize| c.ste.iter().map(move |both| both[i]);
            let [here, there] = [0, 1].map(|i| mean(column(i)));
            let [swing, swing_there] = [0, 1]
                .map(|i| range(column(i)))
                .map(|[low, high]| high - low);
            let of_z = largest(c.contact_z.iter().map(|[a, b]| a - b));
            let of_pressure = 100.0 * largest(c.pressure.iter().map(|[a, b]| a / b - 1.0));
            let of_each = 100.0 * largest(c.ste.iter().map(|[a, b]| a / b - 1.0));
            let [of_mean, of_swing] = [percent(here, there), percent(swing, swing_there)];
            let off = swing - swing_there;
            let bound =
                f64::max(0.02 * swing_there, 0.05) + case.mirror_error(*torque, *misalignment);
            let missed = [
                of_mean.abs() > 0.7,
                off.abs() > bound,
                of_z.abs() > 0.05,
                of_pressure.abs() > 3.0,
            ];
            if missed.contains(&true) {
                eprintln!(
                    "    aim missed: {} at {torque} N m, {misalignment} mrad",
                    case.title
                );
            }
            let load = format!(
                "{} | {} | {torque} | {misalignment}",
                case.title,
                c.ste.len()
            );
            let expected = format!("{there:.3} / {swing_there:.3}");
            let errors = format!(
                "{of_mean:+.2} | {of_swing:+.2} ({off:+.3} um) | {of_each:+.2} | {of_z:+.3}"
            );
            let row = format!("{load} | {expected} | {errors} |");
            rows.push(match c.pressure.len() {
                0 => row,
                n => format!("{row} {of_pressure:+.1} ({n})"),
            });
        }
    }
    let head = "case | positions | N m | mrad | mean / p-p | mean % | p-p % | largest % | z_c, mm | flank pressure %";
    data.table(name, head, &rows)
}

/// Every load of a case.
fn compare(case: &Case) -> Result<Vec<Compared>> {
    let pair = pair::from_json(&case.pair.to_string())?;
    let settings = Settings {
        plane_strain: case.plane_strain,
        ..Settings::for_pair(&pair)
    };
    let mut contact = contact_settings(&pair);
    if case.plane_strain {
        contact.stations = 1;
    }
    let solver = solver(&pair, &models(&pair, &settings)?, contact)?;
    let mut all = vec![Compared::default(); case.loads.len()];
    for at in &case.positions {
        let place = [at.mesh_position, 1e-6 * case.center_distance_offset_um];
        for (i, ([torque, misalignment], c)) in case.loads.iter().zip(&mut all).enumerate() {
            let load = [*torque, 1e-3 * misalignment];
            let result = match case.both_turn {
                true => {
                    let problem = solver.position(Flank::Drive, place[0], place[1])?;
                    problem.solve_torque(load[0], load[1], None)?
                }
                false => solve_torque_of_gear1(&solver, place, load)?,
            };
            c.ste.push([1e6 * result.approach, at.ste_um[i]]);
            c.contact_z.push(match at.contact_z_mm.get(i) {
                Some(there) => [1e3 * result.contact_z, *there],
                None => [1e3 * result.load_centroid(), at.centroid_z_mm[i]],
            });
            c.pressure
                .extend(at.flank_pressure_mpa[i].map(|there| [1e-6 * result.max_pressure, there]));
        }
    }
    Ok(all)
}
