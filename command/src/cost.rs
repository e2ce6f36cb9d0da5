//! What one evaluation of a packed unit costs on this machine.

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use gearmesh::element::{Element, Inputs, Parameters, PhaseOffset, PhaseReference, Workspace};
use gearmesh::fmi::resources::{self, Resources};
use gearmesh_preprocessor::package;
use gearmesh_preprocessor::storage::uninterrupted;
use nalgebra::{Rotation3, Vector3};

use crate::Error;

/// Rounds, of which the fastest counts: others were interrupted.
const ROUNDS: usize = 11;
/// Least duration of a round.
const ROUND: Duration = Duration::from_millis(1);
/// Positions over one mesh cycle, so that an evaluation meets another cell than the last one.
const POSITIONS: usize = 64;

/// Time of one evaluation of the FMU at `path`, whose GUID is `guid`, with its start values and under its nominal torque, s;
/// `None` if no pose bears that torque.
///
/// # Errors
/// Resources that no instance could be made of.
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
    let phase = element.phase_offset(&element.nominal_inputs())?;
    let Some(spin) = loaded(&element, &phase, &parameters) else {
        return Ok(None);
    };
    let poses = poses(&element, &resources, spin);
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

/// Spin of gear 1 (rad) from the nominal pose that makes it bear the nominal torque.
fn loaded(element: &Element, phase: &PhaseOffset, parameters: &Parameters) -> Option<f64> {
    let bears = |spin: f64| {
        let outputs = element.evaluate(phase, &turned(element, [spin, 0.0]));
        let moment = outputs.ok()?.moment[0].z;
        (moment.abs() >= parameters.nominal_torque).then_some(spin)
    };
    // From a micrometre's worth of an angle to a hundredth of a radian, on either flank.
    let spins = (0..60).map(|i| 1e-6 * 1.17f64.powi(i));
    spins.flat_map(|spin| [spin, -spin]).find_map(bears)
}

/// The nominal pose, gears turned by `spins` (rad).
fn turned(element: &Element, spins: [f64; 2]) -> Inputs {
    let mut inputs = element.nominal_inputs();
    for (gear, spin) in inputs.gears.iter_mut().zip(spins) {
        gear.r = *Rotation3::from_axis_angle(&Vector3::z_axis(), spin).matrix();
    }
    inputs
}

/// Poses over one mesh cycle, gear 1 ahead by `spin` (rad).
fn poses(element: &Element, resources: &Resources, spin: f64) -> Vec<Inputs> {
    let geometry = &resources.unit.geometry;
    let [z1, z2] = [0, 1].map(|i| f64::from(geometry.gears[i].teeth));
    let pose = |i: usize| {
        let turn = std::f64::consts::TAU / z1 * i as f64 / POSITIONS as f64;
        turned(element, [spin + turn, -turn * z1 / (geometry.e() * z2)])
    };
    (0..POSITIONS).map(pose).collect()
}
