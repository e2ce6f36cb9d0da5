//! Contact at run time, on teeth from a formula.

use super::Run;
use gearmesh::contact::{ContactSettings, Segment, Warm};
use gearmesh::gear::Flank;
use gearmesh_preprocessor::compliance::{BeyondModel, ToothCompliance};
use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::static_contact::ContactSolver;
use nalgebra::DMatrix;
use std::hint::black_box;
use std::sync::Arc;

/// Teeth whose segments feel each other less the farther apart they lie along the face; elastic models would take a minute to count.
struct Fading;

impl ToothCompliance for Fading {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        let felt = |a: &Segment, b: &Segment| match a.tooth == b.tooth {
            true => 4e-9 * (-200.0 * (a.z[0] - b.z[0]).abs()).exp(),
            false => 0.0,
        };
        let n = segments.len();
        Ok(DMatrix::from_fn(n, n, |i, j| {
            felt(&segments[i], &segments[j])
        }))
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        vec![0.4e-3; segments.len()]
    }
}

/// A contact solve at run time, a thousandth of a mesh cycle after the last one.
pub fn at_run_time() -> Run {
    /// Along the face: fewer than in an FMU, which are counted four times as long.
    const STATIONS: usize = 6;
    /// Of the poses, m, rad and mesh cycles.
    const APPROACH: f64 = 15e-6;
    const MISALIGNMENT: f64 = 0.4e-3;
    const TURN: f64 = 1e-3;
    let pair = pair::from_json(include_str!("../../resources/pairs/palermo2013.json"))
        .expect("a shipped pair");
    let settings = ContactSettings {
        stations: STATIONS,
        ..ContactSettings::default()
    };
    let models: [Arc<dyn ToothCompliance>; 2] = [Arc::new(Fading), Arc::new(Fading)];
    let solver = ContactSolver::new(&pair, models, settings).expect("legal settings");
    let file = contact_file(&pair, &solver).expect("a mesh");
    let contact = file.flank(Flank::Drive).expect("every file has it");
    let mut warm = Warm::default();
    Box::new(move |i| {
        let pose = [APPROACH, 0.0, MISALIGNMENT, TURN * i as f64];
        let solved = contact.potential(black_box(pose), [0; 2], &mut warm);
        black_box(solved.expect("loads"));
    })
}
