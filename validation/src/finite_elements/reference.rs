//! Whole contact against an independent finite-element program without any Hertz formula, `validation/reference/contact.py`
//! (`tests/data/contact_reference.json` says how it works): relief, crowning, misalignment, centre distance, helix, wide faces, tip edges
//! that bear load; and against a second one.

use super::gear1::solve_torque_of_gear1;
use crate::data::{Data, largest, mean, percent, range};
use crate::setup::{models, solver};
use crate::{Context, Result, in_repository};
use gearmesh::gear::Flank;
use gearmesh_preprocessor::finite_element::Settings;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::contact_settings;
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Cases {
    cases: BTreeMap<String, Case>,
}

/// A pair with the data of a reference.
#[derive(Deserialize)]
pub struct Case {
    pub title: String,
    pair: serde_json::Value,
    #[serde(default)]
    plane_strain: bool,
    /// Either gear turns half of the approach, as it does here; else gear 2 is held, and gear 1 turns under its own torque.
    #[serde(default)]
    both_turn: bool,
    center_distance_offset_um: f64,
    /// Torque, N m, and misalignment, mrad.
    loads: Vec<[f64; 2]>,
    positions: Vec<Position>,
}

impl Case {
    /// The cases in tests/data/`file`.json, by name.
    pub fn all(file: &str) -> Result<BTreeMap<String, Self>> {
        let path = in_repository(&format!("tests/data/{file}.json"));
        let all: Cases = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        Ok(all.cases)
    }

    /// By how much the data, um, tell tilts to both sides apart that are mirror images, as they are where a cycle of equal
    /// gears begins.
    fn mirror_error(&self, [torque, misalignment]: [f64; 2]) -> f64 {
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

    /// Every load at every position.
    pub fn compare(&self) -> Result<Vec<Compared>> {
        let pair = pair::from_json(&self.pair.to_string())?;
        let settings = Settings {
            plane_strain: self.plane_strain,
            ..Settings::for_pair(&pair)
        };
        let mut contact = contact_settings(&pair);
        if self.plane_strain {
            contact.stations = 1;
        }
        let solver = solver(&pair, &models(&pair, &settings)?, contact)?;
        let mut all: Vec<_> = (self.loads.iter())
            .map(|load| Compared {
                load: *load,
                mirror_error: self.mirror_error(*load),
                ..Compared::default()
            })
            .collect();
        for at in &self.positions {
            let place = [at.mesh_position, 1e-6 * self.center_distance_offset_um];
            for (i, c) in all.iter_mut().enumerate() {
                let load = [c.load[0], 1e-3 * c.load[1]];
                let result = match self.both_turn {
                    true => {
                        let problem = solver.position(Flank::Drive, place[0], place[1])?;
                        problem.solve_torque(load[0], load[1], None)?
                    }
                    false => solve_torque_of_gear1(&solver, place, load)?,
                };
                c.ste.push([1e6 * result.approach, at.ste_um[i]]);
                let z = at.contact_z_mm.get(i);
                c.contact_z
                    .extend(z.map(|there| [1e3 * result.contact_z, *there]));
                let z = at.centroid_z_mm.get(i);
                c.centroid_z
                    .extend(z.map(|there| [1e3 * result.load_centroid(), *there]));
                let pressure = at.flank_pressure_mpa.get(i).copied().flatten();
                c.pressure
                    .extend(pressure.map(|there| [1e-6 * result.max_pressure, there]));
            }
        }
        Ok(all)
    }
}

/// By load; data do not tell everything everywhere.
#[derive(Deserialize)]
struct Position {
    mesh_position: f64,
    ste_um: Vec<f64>,
    /// Where the resultant crosses the pitch plane.
    #[serde(default)]
    contact_z_mm: Vec<f64>,
    #[serde(default)]
    centroid_z_mm: Vec<f64>,
    #[serde(default)]
    flank_pressure_mpa: Vec<Option<f64>>,
}

/// Found here and expected at every position of one load.
#[derive(Default)]
pub struct Compared {
    /// Torque, N m, and misalignment, mrad.
    pub load: [f64; 2],
    /// um.
    ste: Vec<[f64; 2]>,
    /// mm.
    contact_z: Vec<[f64; 2]>,
    centroid_z: Vec<[f64; 2]>,
    /// MPa.
    pressure: Vec<[f64; 2]>,
    /// Of the expected transmission error, as it shows itself, um.
    mirror_error: f64,
}

/// Largest differences that the mean and the peak-to-peak transmission error of a load may have, %.
pub const AIM: [f64; 2] = [0.7, 2.0];

impl Compared {
    /// Mean and peak-to-peak transmission error, found and expected, um.
    fn ste(&self) -> [[f64; 2]; 2] {
        let column = |i: usize| self.ste.iter().map(move |both| both[i]);
        let swing = |i| {
            let [low, high] = range(column(i));
            high - low
        };
        [[0, 1].map(|i| mean(column(i))), [0, 1].map(swing)]
    }

    /// Largest difference of the transmission error at a position, %.
    pub fn of_each(&self) -> f64 {
        of_each(&self.ste)
    }

    /// Largest difference of the flank pressure, %.
    fn of_pressure(&self) -> f64 {
        of_each(&self.pressure)
    }

    /// What differs by more than the parts `aim`, %, of the mean and the peak-to-peak transmission error, by more than 0.05 um of
    /// the latter beside the error of the data, by more than 0.05 mm in the place of the load, or by more than 3 % in the pressure.
    pub fn missed(&self, aim: [f64; 2]) -> Vec<String> {
        let [[here, there], [swing, swing_there]] = self.ste();
        let most = f64::max(1e-2 * aim[1] * swing_there, 0.05) + self.mirror_error;
        [
            ("mean, %", percent(here, there), aim[0]),
            ("peak to peak, um", swing - swing_there, most),
            ("z_c, mm", off(&self.contact_z), 0.05),
            ("centroid, mm", off(&self.centroid_z), 0.05),
            ("flank pressure, %", self.of_pressure(), 3.0),
        ]
        .into_iter()
        .filter(|(_, off, most)| off.abs() > *most)
        .map(|(what, off, _)| format!("{what}: {off:+.3}"))
        .collect()
    }
}

fn off(both: &[[f64; 2]]) -> f64 {
    largest(both.iter().map(|[a, b]| a - b))
}

fn of_each(both: &[[f64; 2]]) -> f64 {
    100.0 * largest(both.iter().map(|[a, b]| a / b - 1.0))
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    compared(context, data, "reference", "contact_reference")?;
    compared(context, data, "plastic", "plastic_reference")
}

/// The table `name` of the cases in `file`.
fn compared(context: &Context, data: &Data, name: &str, file: &str) -> Result<()> {
    let count = if context.quick { 1 } else { usize::MAX };
    let mut rows = vec![];
    for (case_name, case) in Case::all(file)?.iter().take(count) {
        eprintln!("    {case_name}: {}", case.title);
        for c in case.compare()? {
            let [torque, misalignment] = c.load;
            for missed in c.missed(AIM) {
                eprintln!("    aim missed at {torque} N m, {misalignment} mrad: {missed}");
            }
            let [[here, there], [swing, swing_there]] = c.ste();
            let [of_mean, of_swing] = [percent(here, there), percent(swing, swing_there)];
            let (of_each, off_swing) = (c.of_each(), swing - swing_there);
            let of_z = match c.contact_z[..] {
                [] => off(&c.centroid_z),
                _ => off(&c.contact_z),
            };
            let load = format!(
                "{} | {} | {torque} | {misalignment}",
                case.title,
                c.ste.len()
            );
            let expected = format!("{there:.3} / {swing_there:.3}");
            let errors = format!(
                "{of_mean:+.2} | {of_swing:+.2} ({off_swing:+.3} um) | {of_each:+.2} | {of_z:+.3}"
            );
            let row = format!("{load} | {expected} | {errors} |");
            rows.push(match c.pressure.len() {
                0 => row,
                n => format!("{row} {:+.1} ({n})", c.of_pressure()),
            });
        }
    }
    let head = "case | positions | N m | mrad | mean / p-p | mean % | p-p % | largest % | z_c, mm | flank pressure %";
    data.table(name, head, &rows)
}
