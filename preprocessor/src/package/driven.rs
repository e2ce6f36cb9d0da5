//! An FMU that is driven: input signals that show it at work, and what its communication step costs in accuracy.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

use super::dynamics::Blank;
use super::starts::{CONTACT, SEQUENTIAL, TABLE};
use gearmesh::element::{Coupling, LoadedFlank};
use gearmesh::fmi::Refusal;
use gearmesh::fmi::inputs::{ANGLES, ANGULAR_VELOCITY, BODY_INPUTS, QUATERNION};
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{INPUTS, Kind, STOP_TIME, VARIABLES, index};
use gearmesh::root::bisection;
use gearmesh::table::TableFile;

/// Mesh cycles in the default experiment; the torque rises over the first.
pub(super) const CYCLES: usize = 4;

/// Rows per mesh cycle: linear interpolation between them leaves a thousandth of the transmission error's swing.
const ROWS: usize = 64;

/// An instance of an FMU whose gears are turned on from their start pose.
pub(crate) struct Driven {
    pub(crate) unit: Instance,
    starts: [f64; INPUTS],
    /// Torque on gear 1 on the flank that carries, N m.
    nominal_torque: f64,
}

impl Driven {
    /// Initialised at its start values.
    pub(crate) fn new(resources: &Arc<Resources>) -> Result<Self, Refusal> {
        let mut unit = Instance::new(resources.clone(), Interface::CoSimulation);
        unit.setup(0.0, None)?;
        unit.exit_initialization()?;
        let element = &resources.settings.element;
        let sense = match element.loaded_flank {
            LoadedFlank::Coast => -1.0,
            LoadedFlank::Drive | LoadedFlank::Both => 1.0,
        };
        Ok(Self {
            unit,
            starts: std::array::from_fn(|i| resources.starts[i]),
            nominal_torque: sense * element.nominal_torque,
        })
    }

    /// All inputs with both gears turned on by `angles`, in angles and in quaternions, and spinning at `rates`.
    fn turned(&self, angles: [f64; 2], rates: [f64; 2]) -> [f64; INPUTS] {
        let mut inputs = self.starts;
        for gear in 0..2 {
            let body = &mut inputs[gear * BODY_INPUTS..][..BODY_INPUTS];
            body[ANGLES + 2] += angles[gear];
            body[ANGULAR_VELOCITY + 2] += rates[gear];
            // About the gear's own axis: from the right.
            let (sin, cos) = (0.5 * angles[gear]).sin_cos();
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| body[QUATERNION + k]);
            body[QUATERNION..QUATERNION + 4].copy_from_slice(&[
                w * cos - z * sin,
                x * cos + y * sin,
                y * cos - x * sin,
                z * cos + w * sin,
            ]);
        }
        inputs
    }

    /// Turns the gears.
    pub(crate) fn turn(&mut self, angles: [f64; 2], rates: [f64; 2]) -> Result<(), Refusal> {
        let references = VARIABLES[..INPUTS].iter().map(|v| v.value_reference);
        let references: Vec<u32> = references.collect();
        let inputs = self.turned(angles, rates);
        self.unit.set(Kind::Real, &references, &inputs)
    }

    /// Values of these variables.
    pub(crate) fn read<const N: usize>(
        &mut self,
        outputs: [usize; N],
    ) -> Result<[f64; N], Refusal> {
        let mut values = Vec::with_capacity(N);
        let references = outputs.map(|i| VARIABLES[i].value_reference);
        self.unit.get(Kind::Real, &references, |x| {
            values.extend_from_slice(x);
        })?;
        Ok(std::array::from_fn(|k| values[k]))
    }
}

/// The signals as CSV over time, with a column for each input, so that no host has to guess one. Gear 1 turns
/// at a constant speed; gear 2 follows behind by what the contact yields at rest under nominal torque, so that
/// `gear1.moment[3]` shows that torque and `mesh.transmissionError` its curve. `None` where no pose
/// within a quarter of a pitch bears that torque.
///
/// # Errors
/// Start values that make no mesh, with the reason that a host would get.
pub(super) fn example_signals(resources: &Arc<Resources>) -> Result<Option<String>, Refusal> {
    let mut driven = Driven::new(resources)?;
    let geometry = &resources.unit.geometry;
    let [z1, z2] = [0, 1].map(|i| geometry.gears[i].z());
    let turn = CYCLES as f64 * TAU / z1;
    let steps = CYCLES * ROWS;
    let sense = driven.nominal_torque.signum();
    let mut rows = Vec::with_capacity(steps + 1);
    for i in 0..=steps {
        let spin1 = turn * i as f64 / steps as f64;
        // Gear 2 stands behind in its own sense on the flank that carries.
        let spin2 = |behind: f64| geometry.e() * (sense * behind - z1 / z2 * spin1);
        let mut torque = |behind: f64| -> Result<f64, Refusal> {
            driven.turn([spin1, spin2(behind)], [0.0; 2])?;
            let [moment] = driven.read([index::GEAR1_MOMENT_3])?;
            Ok(-moment / driven.nominal_torque)
        };
        // From a thousandth of a pitch up: far beyond the load of a table its continuation bends.
        let (mut low, mut high) = (0.0, 1e-3 * TAU / z2);
        while torque(high)? < 1.0 {
            (low, high) = (high, 2.0 * high);
            if high > 0.25 * TAU / z2 {
                return Ok(None);
            }
        }
        let behind = bisection([low, high], 50, |x| {
            torque(x).is_ok_and(|share| share < 1.0)
        });
        // Cubic step over the first cycle.
        let rise = (i as f64 / ROWS as f64).min(1.0);
        rows.push([spin1, spin2(behind * rise * rise * (3.0 - 2.0 * rise))]);
    }
    Ok(Some(table(&driven, &rows)))
}

/// `rows` of both spins, evenly over the default experiment, as text.
fn table(driven: &Driven, rows: &[[f64; 2]]) -> String {
    let steps = rows.len() - 1;
    let interval = STOP_TIME / steps as f64;
    let names = VARIABLES[..INPUTS].iter().map(|v| format!(",{}", v.name));
    let mut out = format!("time{}\n", names.collect::<String>());
    for (i, spins) in rows.iter().enumerate() {
        // Slopes of the polygon that hosts make of the rows, mean of both sides.
        let (before, after) = (i.saturating_sub(1), (i + 1).min(steps));
        let span = (after - before) as f64 * interval;
        let rates = [0, 1].map(|gear| (rows[after][gear] - rows[before][gear]) / span);
        let _ = write!(out, "{:?}", i as f64 * STOP_TIME / steps as f64);
        for value in driven.turned(*spins, rates) {
            let _ = write!(out, ",{value}");
        }
        out.push('\n');
    }
    out
}

/// The torque rises to the nominal one over this time, s.
const RISE: f64 = 2e-3;
/// Length of the run, s.
const DURATION: f64 = 12e-3;
/// Tooth pitches a second at which errors of a step are measured.
pub const MESH_FREQUENCY: f64 = 750.0;
/// Steps of the solution that counts as exact, to one step of the FMU.
const FINER: usize = 20;

/// Root mean square errors of `mesh.transmissionError` over the standard deviation of its exact course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepError {
    /// Over the run, in which the load rises.
    pub run: f64,
    /// Over its second half, after that; None where that varies by less than a hundredth of the run.
    pub steady: Option<f64>,
}

/// Errors at the communication step `step` (s). Both gears spin as steel discs at `MESH_FREQUENCY` and carry the nominal torque, which rises
/// over `RISE`;
/// exact is the same motion in steps a twentieth as long. An FMU that starts with `stiffnessModel = contact` is measured on its
/// tables. `None` where a step is refused, or an FMU with contact has no tables.
pub fn step_error(unit: &UnitFile, tables: Option<&TableFile>, step: f64) -> Option<StepError> {
    let [model, coupling] = [index::STIFFNESS_MODEL, index::COUPLING].map(|i| VARIABLES[i].name);
    let mut unit = unit.clone();
    if unit.starts.get(model) == Some(&CONTACT) {
        tables?;
        unit.starts.insert(model.to_owned(), TABLE);
    }
    let mut exact = unit.clone();
    exact.starts.insert(coupling.to_owned(), SEQUENTIAL);
    let [unit, exact] = [unit, exact].map(|unit| {
        let resources = Resources::new(unit, tables.cloned(), None);
        resources.ok().map(Arc::new)
    });
    let unit = unit?;
    // Held loads need steps so short that a prediction over them is exact.
    let finer = match unit.settings.coupling {
        Coupling::Held => 1,
        Coupling::Sequential | Coupling::Parallel | Coupling::Automatic => FINER,
    };
    let found = transmission_error(unit, step).ok()?;
    let exact = transmission_error(exact?, step / finer as f64).ok()?;
    let exact: Vec<f64> = exact.into_iter().step_by(finer).collect();
    let second = exact.len() / 2;
    let steady = exact.get(second..)?;
    let varies = spread(steady) > LEAST_VARIATION * spread(&exact);
    let found_steady = found.get(second..).filter(|_| varies);
    Some(StepError {
        run: relative_error(&found, &exact)?,
        steady: found_steady.and_then(|found| relative_error(found, steady)),
    })
}

/// Share of the spread of the run below which the second half is only the decaying transient, as with constant stiffness, and no error is given.
const LEAST_VARIATION: f64 = 0.01;

/// Standard deviation.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    f64::sqrt(squares.sum::<f64>() / values.len() as f64)
}

/// Error of `found`, rms over that of `exact` about its mean; None where that does not vary.
fn relative_error(found: &[f64], exact: &[f64]) -> Option<f64> {
    let squares = found.iter().zip(exact).map(|(a, b)| (a - b).powi(2));
    let error = f64::sqrt(squares.sum::<f64>() / exact.len() as f64);
    Some(error / spread(exact)).filter(|error| error.is_finite())
}

/// `mesh.transmissionError`, m, at every communication point; the gears move exactly under loads that act as the FMU's `coupling`
/// says, and one step late where they are held.
fn transmission_error(resources: Arc<Resources>, step: f64) -> Result<Vec<f64>, Refusal> {
    let mut driven = Driven::new(&resources)?;
    let sequential = resources.settings.coupling == Coupling::Sequential;
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
    use super::*;
    use crate::package::starts::HELD;
    use crate::package::{Starts, shipped_tables};

    /// Of the shipped pair of the paper with this `coupling` and what packing gives it.
    fn error(coupling: f64, step: f64) -> f64 {
        let tables = shipped_tables("palermo2013");
        let geometry = tables.geometry.clone();
        let starts = Starts::of_tables(&tables).unwrap();
        let mut starts = starts.of_variables(&geometry);
        starts.insert("coupling".into(), coupling);
        let unit = UnitFile {
            version: gearmesh::fmi::resources::UNIT_VERSION,
            guid: String::new(),
            name: "pair".into(),
            starts,
            geometry,
        };
        step_error(&unit, Some(&tables), step).unwrap().run
    }

    #[test]
    fn predicted_loads_converge_at_second_order_and_err_less_than_held_ones_in_a_tenth_of_their_step()
     {
        // Steps so short that terms of the fourth order, (omega H)^2 smaller, are a tenth at most.
        let [coarse, fine] = [8e-6, 4e-6].map(|step| error(SEQUENTIAL, step));
        let order = (coarse / fine).log2();
        assert!((1.7..2.6).contains(&order), "{coarse} {fine}: {order}");
        let held = error(HELD, 0.8e-6);
        assert!(coarse < 0.3 * held, "{coarse} {held}");
    }
}
