//! What the communication step of an FMU costs in accuracy.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::coupling::Blank;
use super::example::Driven;
use super::starts::{CONTACT, SEQUENTIAL, TABLE};
use gearmesh::element::Coupling;
use gearmesh::fmi::Refusal;
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::TableFile;

/// The torque rises to the nominal one over this time, s.
const RISE: f64 = 2e-3;
/// Length of the run, s.
const DURATION: f64 = 12e-3;
/// Tooth pitches a second.
const MESH_FREQUENCY: f64 = 750.0;
/// Steps of the solution that counts as exact, to one step of the FMU.
const FINER: usize = 20;

/// Root mean square error of `mesh.transmissionError` at the communication step `step` (s) over the standard deviation of its
/// exact course. Both gears spin as steel discs at `MESH_FREQUENCY` and carry the nominal torque, which rises over `RISE`;
/// exact is the same motion in steps a twentieth as long. An FMU that starts with `stiffnessModel = contact` is measured on its
/// tables. `None` where a step is refused, or an FMU with contact has no tables.
pub fn step_error(unit: &UnitFile, tables: Option<&TableFile>, step: f64) -> Option<f64> {
    let name = |i: usize| VARIABLES[i].name.to_owned();
    let mut unit = unit.clone();
    if unit.starts.get(&name(index::STIFFNESS_MODEL)) == Some(&CONTACT) {
        tables?;
        unit.starts.insert(name(index::STIFFNESS_MODEL), TABLE);
    }
    let mut exact = unit.clone();
    exact.starts.insert(name(index::COUPLING), SEQUENTIAL);
    let resources = |unit: UnitFile| {
        let resources = Resources::new(unit, tables.cloned(), None);
        resources.ok().map(Arc::new)
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
    let mean = exact.iter().sum::<f64>() / exact.len() as f64;
    let squares = |(error, spread), (found, exact): (&f64, &f64)| {
        (
            error + (found - exact).powi(2),
            spread + (exact - mean).powi(2),
        )
    };
    let (error, spread) = found.iter().zip(&exact).fold((0.0, 0.0), squares);
    Some((error / spread).sqrt()).filter(|error: &f64| error.is_finite())
}

/// `mesh.transmissionError`, m, at every communication point; the gears move exactly under loads that act as the FMU's `coupling`
/// says, and one step late where they are held.
fn transmission_error(resources: Arc<Resources>, step: f64) -> Result<Vec<f64>, Refusal> {
    let mut driven = Driven::new(&resources)?;
    let sequential = resources.starts.settings.coupling == Coupling::Sequential;
    let geometry = &resources.unit.geometry;
    let [z1, z2] = [0, 1].map(|i| geometry.gears[i].z());
    let inertia = [0, 1].map(|i| Blank::new(&geometry.gears[i]).axial_inertia);
    let share = [1.0, geometry.e() * z2 / z1];
    let speed = MESH_FREQUENCY * TAU / z1;
    let (mut angle, mut rate) = ([0.0; 2], [speed, -geometry.e() * z1 / z2 * speed]);
    let mut late = [0.0; 2];
    let mut errors = Vec::new();
    for n in 0..(DURATION / step).ceil() as usize {
        driven.turn(angle, rate)?;
        driven.unit.do_step(driven.unit.time(), step)?;
        let [moment1, moment2, error] = driven.read([
            index::GEAR1_MOMENT_3,
            index::GEAR2_MOMENT_3,
            index::MESH_TRANSMISSION_ERROR,
        ])?;
        errors.push(error);
        let now = [moment1, moment2];
        let before = std::mem::replace(&mut late, now);
        let acting = if sequential { now } else { before };
        let torque = driven.nominal_torque * ((n as f64 + 0.5) * step / RISE).min(1.0);
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
    use super::super::starts::HELD;
    use super::*;

    /// The shipped pair of the paper with this `coupling` and what packing gives it.
    fn error(coupling: f64, step: f64) -> f64 {
        let tables = super::super::shipped_tables("palermo2013");
        let geometry = tables.geometry.clone();
        let starts = super::super::Starts::of_tables(&tables).unwrap();
        let mut starts = starts.of_variables(&geometry);
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
        let held = error(HELD, 0.8e-6);
        assert!(fine < 0.3 * held, "{fine} {held}");
    }
}
