//! What contact at run time costs, and how far it is from the full solve on that solve's segments.

use super::PAIRS;
use crate::data::{Data, largest, rms};
use crate::setup::{Setup, shipped};
use crate::timing::timed;
use crate::{Context, Result};
use gearmesh::contact::Warm;
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use std::sync::Arc;

/// Steps of a path along the mesh cycle.
const STEPS: usize = 2000;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (pairs, points) = if context.quick { (1, 20) } else { (4, 200) };
    let mut rows = vec![];
    for name in &PAIRS[..pairs] {
        let setup = Setup::new(shipped(name)?, None)?;
        let file = Arc::new(setup.contact_file()?);
        let contact = file.flank(Flank::Drive).ok_or("no drive flank")?;
        let mut random = Random::new(1);
        let (mut errors, mut cold) = (vec![], 0.0);
        for _ in 0..points {
            let (torque, query) = setup.draw(&mut random);
            let full = setup.solve(torque, &query)?;
            let [_, offset, misalignment, tau] = query.coordinates();
            let pose = [full.approach, offset, misalignment, tau];
            let (found, seconds) = timed(|| contact.potential(pose, [0; 2], &mut Warm::default()));
            cold += seconds / points as f64;
            errors.push((found?.gradient[0] - full.loa_force) / setup.nominal_force());
        }
        // A step of a simulation turns the gears by a thousandth of a mesh cycle.
        let approach = setup.nominal(0.0)?.approach;
        let mut warm = Warm::default();
        let (done, seconds) = timed(|| {
            (0..STEPS).try_for_each(|i| {
                let pose = [approach, 0.0, 0.0, i as f64 * 1e-3];
                contact.potential(pose, [0; 2], &mut warm).map(|_| ())
            })
        });
        done?;
        let segments = file.setup.settings.stations;
        let megabytes = file.to_bytes().len() as f64 / 1e6;
        let worst = 100.0 * largest(errors.iter().copied()).abs();
        let (rms, cold, warm) = (
            100.0 * rms(errors),
            1e6 * cold,
            1e6 * seconds / STEPS as f64,
        );
        rows.push(format!(
            "{name} | {segments} | {megabytes:.1} | {rms:.3} | {worst:.2} | {cold:.0} | {warm:.0}"
        ));
    }
    let head =
        "pair | segments | condensed, MB | force error rms, % | largest, % | cold, us | warm, us";
    data.table("cost", head, &rows)
}
