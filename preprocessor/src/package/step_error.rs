//! What the communication step of a unit costs in accuracy.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::example::turned;
use super::mass::Blank;
use super::starts::{CONTACT, SEQUENTIAL, TABLE};
use gearmesh::element::{Coupling, LoadedFlank};
use gearmesh::fmi::Refusal;
use gearmesh::fmi::inputs::{ANGULAR_VELOCITY, BODY_INPUTS, INPUTS};
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::TableFile;

/// The torque rises to the nominal one over this time, s.
const RISE: f64 = 2e-3;
/// Length of the run, s.
const DURATION: f64 = 12e-3;
/// Tooth pitches a second.
const MESH_FREQUENCY: f64 = 750.0;
/// Steps of the solution that counts as exact, to one step of the unit.
const FINER: usize = 20;

/// Root mean square error of `mesh.transmissionError` at the communication step `step` (s) over the standard deviation of its
/// exact course. Both gears spin as steel discs at `MESH_FREQUENCY` and carry the nominal torque, which rises over `RISE`;
/// exact is the same motion in steps a twentieth as long. A unit that starts with `stiffnessModel = contact` is measured on its
/// tables. `None` where a step is refused, or a unit with contact has no tables.
pub fn step_error(unit: &UnitFile, tables: Option<&TableFile>, step: f64) -> Option<f64> {
    let mut unit = unit.clone();
    let start = |unit: &mut UnitFile, i: usize, value: f64| {
        unit.starts.insert(VARIABLES[i].name.to_owned(), value);
    };
    let model = unit.starts.get(VARIABLES[index::STIFFNESS_MODEL].name);
    if model == Some(&CONTACT) {
        tables?;
        start(&mut unit, index::STIFFNESS_MODEL, TABLE);
    }
    let mut exact = unit.clone();
    start(&mut exact, index::COUPLING, SEQUENTIAL);
    let resources = |unit: UnitFile| {
        Resources::new(unit, tables.cloned(), None)
            .ok()
            .map(Arc::new)
    };
    let unit = resources(unit)?;
    // Held loads need steps so short that a prediction over them is exact.
    let finer = match unit.starts.settings.coupling {
        Coupling::Held => 1,
        Coupling::Sequential | Coupling::Parallel => FINER,
    };
    let found = transmission_error(unit, step).ok()?;
    let exact = transmission_error(resources(exact)?, step / finer as f64).ok()?;
    let exact: Vec<f64> = exact.into_iter().step_by(finer).collect();
    let count = found.len().min(exact.len()) as f64;
    let mean = exact.iter().sum::<f64>() / exact.len() as f64;
    let square = |differences: &mut dyn Iterator<Item = f64>| -> f64 {
        differences.map(|d| d * d).sum::<f64>() / count
    };
    let error = square(&mut found.iter().zip(&exact).map(|(a, b)| a - b));
    let spread = square(&mut exact.iter().map(|x| x - mean));
    Some((error / spread).sqrt()).filter(|error| error.is_finite())
}

/// `mesh.transmissionError`, m, at every communication point; the gears move exactly under loads that act as the unit's `coupling`
/// says, and one step late where they are held.
fn transmission_error(resources: Arc<Resources>, step: f64) -> Result<Vec<f64>, Refusal> {
    let starts = resources.starts.inputs;
    let settings = &resources.starts.settings;
    let sequential = settings.coupling == Coupling::Sequential;
    let sense = match settings.element.loaded_flank {
        LoadedFlank::Coast => -1.0,
        LoadedFlank::Drive | LoadedFlank::Both => 1.0,
    };
    let nominal = sense * settings.element.nominal_torque;
    let geometry = resources.unit.geometry.clone();
    let [z1, z2] = [0, 1].map(|i| geometry.gears[i].z());
    let inertia = [0, 1].map(|i| Blank::new(&geometry.gears[i]).axial_inertia);
    let share = [1.0, geometry.e() * z2 / z1];
    let reference = |i: usize| VARIABLES[i].value_reference;
    let inputs: Vec<u32> = (0..INPUTS).map(reference).collect();
    let outputs = [
        index::GEAR1_MOMENT_3,
        index::GEAR2_MOMENT_3,
        index::MESH_TRANSMISSION_ERROR,
    ]
    .map(reference);
    let mut unit = Instance::new(resources, Interface::CoSimulation);
    unit.setup(0.0, None)?;
    unit.exit_initialization()?;
    let speed = MESH_FREQUENCY * TAU / z1;
    let (mut angle, mut rate) = ([0.0; 2], [speed, -geometry.e() * z1 / z2 * speed]);
    let mut late = [0.0; 2];
    let count = (DURATION / step).ceil() as usize;
    let mut errors = Vec::with_capacity(count);
    for n in 0..count {
        let time = n as f64 * step;
        let mut values = turned(&starts, angle);
        for (gear, rate) in rate.into_iter().enumerate() {
            values[gear * BODY_INPUTS + ANGULAR_VELOCITY + 2] += rate;
        }
        unit.set_real(&inputs, &values)?;
        unit.do_step(unit.time(), step)?;
        let mut row = Vec::with_capacity(outputs.len());
        unit.get_real(&outputs, |x| row.push(x))?;
        let moments = [row[0], row[1]];
        errors.push(row[2]);
        let acting = if sequential { moments } else { late };
        late = moments;
        let torque = nominal * ((time + 0.5 * step) / RISE).min(1.0);
        for i in 0..2 {
            let acceleration = (acting[i] + share[i] * torque) / inertia[i];
            angle[i] += step * rate[i] + 0.5 * step * step * acceleration;
            rate[i] += step * acceleration;
        }
    }
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearmesh::table::TableFile;
    use std::collections::BTreeMap;

    /// The shipped pair of the paper with this `coupling` and what packing gives it.
    fn error(coupling: f64, step: f64) -> f64 {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../resources/tables/palermo2013.json"
        );
        let tables = TableFile::read(path).unwrap();
        let geometry = tables.geometry.clone();
        let starts = super::super::Starts::of_tables(&tables).unwrap();
        let mut starts: BTreeMap<String, f64> = starts
            .of_variables(&geometry)
            .unwrap()
            .into_iter()
            .map(|(i, value)| (VARIABLES[i].name.to_owned(), value))
            .collect();
        starts.insert("coupling".into(), coupling);
        let unit = UnitFile {
            version: gearmesh::fmi::resources::UNIT_VERSION,
            guid: String::new(),
            name: "pair".into(),
            starts,
            geometry,
        };
        step_error(&unit, Some(&tables), step).unwrap()
    }

    #[test]
    fn predicted_loads_converge_at_second_order_and_err_less_than_held_ones_in_a_tenth_of_their_step()
     {
        let [coarse, fine] = [16e-6, 8e-6].map(|step| error(SEQUENTIAL, step));
        let order = (coarse / fine).log2();
        assert!((1.7..2.6).contains(&order), "{coarse} {fine}: {order}");
        let held = error(1.0, 0.8e-6);
        assert!(fine < 0.3 * held, "{fine} {held}");
    }
}
