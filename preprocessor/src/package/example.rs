//! Input signals that show the unit at work: both gears turn through some mesh cycles under nominal torque.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

use super::PackageError;
use gearmesh::element::LoadedFlank;
use gearmesh::fmi::Refusal;
use gearmesh::fmi::inputs::{ANGLES, ANGULAR_VELOCITY, BODY_INPUTS, INPUTS, QUATERNION};
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::Resources;
use gearmesh::fmi::variables::{STOP_TIME, VARIABLES, index};

/// Mesh cycles in the default experiment; the torque rises over the first.
pub(super) const CYCLES: usize = 4;

/// Rows per mesh cycle: linear interpolation between them leaves a thousandth of the transmission error's swing.
const ROWS: usize = 64;

/// The signals as CSV over time, with a column for each input, so that no host has to guess one. Gear 1 turns
/// at a constant speed; gear 2 follows behind by what the contact yields at rest under nominal torque, so that
/// `gear1.moment[3]` shows that torque and `mesh.transmissionError` its curve. `None` where no pose
/// within a quarter of a pitch bears that torque.
///
/// # Errors
/// Start values that make no mesh, with the reason that a host would get.
pub(super) fn signals(resources: &Arc<Resources>) -> Result<Option<String>, PackageError> {
    let mut unit = Instance::new(resources.clone(), Interface::CoSimulation);
    unit.exit_initialization().map_err(refused)?;
    let inputs: Vec<u32> = VARIABLES[..INPUTS]
        .iter()
        .map(|v| v.value_reference)
        .collect();
    let moment = VARIABLES[index::GEAR1_MOMENT_3].value_reference;
    let geometry = &resources.unit.geometry;
    let starts = &resources.starts.inputs;
    let parameters = &resources.starts.settings.element;
    let wanted = parameters.nominal_torque;
    let [z1, z2] = [0, 1].map(|i| geometry.gears[i].z());
    let turn = CYCLES as f64 * TAU / z1;
    let steps = CYCLES * ROWS;
    // By how much gear 2 stands behind in its own sense on the flank that carries.
    let sense = match parameters.loaded_flank {
        LoadedFlank::Coast => -1.0,
        LoadedFlank::Drive | LoadedFlank::Both => 1.0,
    };
    let mut rows = Vec::with_capacity(steps + 1);
    for i in 0..=steps {
        let spin1 = turn * i as f64 / steps as f64;
        let spin2 = |behind: f64| geometry.e() * (sense * behind - z1 / z2 * spin1);
        let mut torque = |behind: f64| -> Result<f64, PackageError> {
            let values = turned(starts, [spin1, spin2(behind)]);
            unit.set_real(&inputs, &values).map_err(refused)?;
            let mut torque = 0.0;
            unit.get_real(&[moment], |x| torque = -sense * x)
                .map_err(refused)?;
            Ok(torque)
        };
        // From a thousandth of a pitch up: far beyond the load of a table its continuation bends.
        let (mut low, mut high) = (0.0, 1e-3 * TAU / z2);
        while torque(high)? < wanted {
            (low, high) = (high, 2.0 * high);
            if high > 0.25 * TAU / z2 {
                return Ok(None);
            }
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if torque(middle)? < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Cubic step over the first cycle.
        let rise = (i as f64 / ROWS as f64).min(1.0);
        rows.push([spin1, spin2(high * rise * rise * (3.0 - 2.0 * rise))]);
    }
    Ok(Some(table(starts, &rows)))
}

/// `rows` of both spins, evenly over the default experiment, as text.
fn table(starts: &[f64], rows: &[[f64; 2]]) -> String {
    let steps = rows.len() - 1;
    let interval = STOP_TIME / steps as f64;
    let mut out = String::from("time");
    for v in &VARIABLES[..INPUTS] {
        let _ = write!(out, ",{}", v.name);
    }
    out.push('\n');
    for (i, spins) in rows.iter().enumerate() {
        let mut values = turned(starts, *spins);
        // Slopes of the polygon that hosts make of the rows, mean of both sides.
        let (before, after) = (i.saturating_sub(1), (i + 1).min(steps));
        let span = (after - before) as f64 * interval;
        for gear in 0..2 {
            values[gear * BODY_INPUTS + ANGULAR_VELOCITY + 2] +=
                (rows[after][gear] - rows[before][gear]) / span;
        }
        let _ = write!(out, "{:?}", i as f64 * STOP_TIME / steps as f64);
        for value in values {
            let _ = write!(out, ",{value}");
        }
        out.push('\n');
    }
    out
}

/// `starts` with both gears turned on by `spins`, in angles and in quaternions.
pub(super) fn turned(starts: &[f64], spins: [f64; 2]) -> Vec<f64> {
    let mut inputs = starts.to_vec();
    for (gear, spin) in spins.into_iter().enumerate() {
        let first = gear * BODY_INPUTS;
        inputs[first + ANGLES + 2] += spin;
        // About the gear's own axis: from the right.
        let (sin, cos) = (0.5 * spin).sin_cos();
        let quaternion = &mut inputs[first + QUATERNION..first + QUATERNION + 4];
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| quaternion[k]);
        quaternion.copy_from_slice(&[
            w * cos - z * sin,
            x * cos + y * sin,
            y * cos - x * sin,
            z * cos + w * sin,
        ]);
    }
    inputs
}

fn refused(refusal: Refusal) -> PackageError {
    PackageError::Refused {
        reason: refusal.message,
    }
}
