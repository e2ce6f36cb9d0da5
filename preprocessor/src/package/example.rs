//! Input signals that show the FMU at work: both gears turn through some mesh cycles under nominal torque.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

use gearmesh::element::LoadedFlank;
use gearmesh::fmi::Refusal;
use gearmesh::fmi::inputs::{ANGLES, ANGULAR_VELOCITY, BODY_INPUTS, QUATERNION};
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::Resources;
use gearmesh::fmi::variables::{INPUTS, Kind, STOP_TIME, VARIABLES, index};
use gearmesh::root::bisection;

/// Mesh cycles in the default experiment; the torque rises over the first.
pub(super) const CYCLES: usize = 4;

/// Rows per mesh cycle: linear interpolation between them leaves a thousandth of the transmission error's swing.
const ROWS: usize = 64;

/// An instance of an FMU whose gears are turned on from their start pose.
pub(super) struct Driven {
    pub unit: Instance,
    starts: [f64; INPUTS],
    /// Torque on gear 1 on the flank that carries, N m.
    pub nominal_torque: f64,
}

impl Driven {
    /// # Errors
    /// Start values that make no mesh, with the reason that a host would get.
    pub fn new(resources: &Arc<Resources>) -> Result<Self, Refusal> {
        let mut unit = Instance::new(resources.clone(), Interface::CoSimulation);
        unit.setup(0.0, None)?;
        unit.exit_initialization()?;
        let element = &resources.starts.settings.element;
        let sense = match element.loaded_flank {
            LoadedFlank::Coast => -1.0,
            LoadedFlank::Drive | LoadedFlank::Both => 1.0,
        };
        Ok(Self {
            unit,
            starts: resources.starts.inputs,
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
    pub fn turn(&mut self, angles: [f64; 2], rates: [f64; 2]) -> Result<(), Refusal> {
        let references: Vec<u32> = VARIABLES[..INPUTS]
            .iter()
            .map(|v| v.value_reference)
            .collect();
        self.unit
            .set(Kind::Real, &references, &self.turned(angles, rates))
    }

    /// Values of these variables.
    pub fn read<const N: usize>(&mut self, outputs: [usize; N]) -> Result<[f64; N], Refusal> {
        let mut values = Vec::with_capacity(N);
        let references = outputs.map(|i| VARIABLES[i].value_reference);
        self.unit.get(Kind::Real, &references, |x| values.push(x))?;
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
pub(super) fn signals(resources: &Arc<Resources>) -> Result<Option<String>, Refusal> {
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
