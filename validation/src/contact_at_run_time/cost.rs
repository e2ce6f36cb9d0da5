//! What contact at run time costs, and how far it is from the full solve on that solve's stations.

use crate::data::{Data, fixed, largest, rms};
use crate::setup::Setup;
use crate::timing::timed;
use crate::{Context, Result, row};
use gearmesh::contact::Warm;
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use std::sync::Arc;

/// Steps of a path along the mesh cycle.
const STEPS: usize = 2000;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let points = if context.quick { 20 } else { 200 };
    let mut rows = vec![];
    for name in super::PAIRS.into_iter().take(if context.quick { 1 } else { 4 }) {
        let (setup, file) = Setup::packed(name)?;
        let file = Arc::new(file);
        let contact = file.flank(Flank::Drive).ok_or("no drive flank")?;
        let operating = &setup.pair.operating;
        let mut random = Random::new(1);
        let (mut errors, mut cold) = (vec![], 0.0);
        for _ in 0..points {
            let offset = random.within(operating.center_distance_offset);
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let full = setup.solver.position(Flank::Drive, tau, offset)?.solve_torque(torque, misalignment, None)?;
            let at = [full.approach, offset, misalignment, tau];
            let (found, seconds) = timed(|| contact.potential(at, [0; 2], &mut Warm::default()));
            cold += seconds / points as f64;
            errors.push((found?.gradient[0] - full.loa_force) / setup.nominal_force());
        }
        // A step of a simulation turns the gears by a thousandth of a mesh cycle.
        let at_nominal =
            setup.solver.position(Flank::Drive, 0.0, 0.0)?.solve_torque(operating.nominal_torque, 0.0, None)?;
        let mut warm = Warm::default();
        let (done, seconds) = timed(|| {
            (0..STEPS).try_for_each(|i| {
                let at = [at_nominal.approach, 0.0, 0.0, i as f64 * 1e-3];
                contact.potential(at, [0; 2], &mut warm).map(|_| ())
            })
        });
        done?;
        let megabytes = file.to_bytes().len() as f64 / 1e6;
        let worst = largest(errors.iter().copied()).abs();
        rows.push(row![
            name,
            file.setup.settings.stations,
            fixed(megabytes, 1),
            fixed(100.0 * rms(errors), 3),
            fixed(100.0 * worst, 2),
            fixed(1e6 * cold, 0),
            fixed(1e6 * seconds / STEPS as f64, 0),
        ]);
    }
    let head = ["pair", "segments", "condensed, MB", "force error rms, %", "largest, %", "cold, us", "warm, us"];
    data.table("cost", &head, &rows)
}
