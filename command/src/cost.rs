//! What one evaluation of a packed unit costs on this machine.

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use gearmesh::element::{Parameters, PhaseReference, Workspace};
use gearmesh::fmi::resources;
use gearmesh_preprocessor::package;
use gearmesh_preprocessor::storage::uninterrupted;
use nalgebra::{Rotation3, Vector3};

use crate::Error;

/// Rounds, of which the fastest counts: others were interrupted.
const ROUNDS: usize = 11;
const ROUND: Duration = Duration::from_millis(1);
/// Positions over one mesh cycle, so that an evaluation meets another cell than the last one.
const POSITIONS: usize = 64;

/// Time of one evaluation of the FMU at `path` with the GUID `guid`, its start values and its nominal torque, s; None if no pose
/// bears that torque.
pub fn evaluation(path: &Path, guid: &str) -> Result<Option<f64>, Error> {
    let resources = uninterrupted(|| -> Result<_, Error> {
        let folder = tempfile::tempdir()?;
        package::unpack_resources(path, folder.path())?;
        Ok(resources::load(&folder.path().to_string_lossy(), guid)?)
    })?;
    // From any pose: where teeth stand counts for no cost.
    let parameters = Parameters {
        phase_reference: PhaseReference::FromInitialPose,
        ..resources.starts.settings.element
    };
    let element = resources.element(&parameters).map_err(|e| e.to_string())?;
    let nominal = element.nominal_inputs();
    let phase = element.phase_offset(&nominal)?;
    let turned = |spins: [f64; 2]| {
        let mut inputs = nominal;
        for (gear, spin) in inputs.gears.iter_mut().zip(spins) {
            gear.r = *Rotation3::from_axis_angle(&Vector3::z_axis(), spin).matrix();
        }
        inputs
    };
    let bears = |spin: &f64| {
        let outputs = element.evaluate(&phase, &turned([*spin, 0.0]));
        outputs.is_ok_and(|o| o.moment[0].z.abs() >= parameters.nominal_torque)
    };
    // Gear 1 ahead by a micrometre's worth of an angle to a hundredth of a radian, on either flank.
    let spins = (0..60).map(|i| 1e-6 * 1.17f64.powi(i));
    let Some(spin) = spins.flat_map(|spin| [spin, -spin]).find(bears) else {
        return Ok(None);
    };
    let geometry = &resources.unit.geometry;
    let [z1, z2] = [0, 1].map(|i| f64::from(geometry.gears[i].teeth));
    let pose = |i: usize| {
        let turn = std::f64::consts::TAU / z1 * i as f64 / POSITIONS as f64;
        turned([spin + turn, -turn * z1 / (geometry.e() * z2)])
    };
    let poses: Vec<_> = (0..POSITIONS).map(pose).collect();
    let mut next = poses.iter().cycle();
    let mut workspace = Workspace::default();
    let mut run = |count: usize| {
        let begin = Instant::now();
        for inputs in next.by_ref().take(count) {
            // Poses around one that was evaluated.
            let _ = black_box(element.evaluate_from(&phase, black_box(inputs), &mut workspace));
        }
        begin.elapsed()
    };
    let mut count = 1;
    while run(count) < ROUND {
        count *= 2;
    }
    let fastest = (0..ROUNDS).map(|_| run(count)).min();
    Ok(fastest.map(|time| time.as_secs_f64() / count as f64))
}
