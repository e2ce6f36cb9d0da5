//! What tables cost to make, and how far the levels of refinement are from each other.

use super::{PAIR, at, interpolants, points};
use crate::data::{Data, fixed};
use crate::setup::ste;
use crate::timing::timed;
use crate::{Context, Result, row};
use gearmesh::pair::Refinement;
use gearmesh::table::{FlankTable, Interpolation};

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let mut levels = vec![("coarse", timed(|| at(PAIR, Refinement::Coarse)))];
    if !context.quick {
        levels.push(("normal", timed(|| at(PAIR, Refinement::Normal))));
    }
    let mut setups = vec![];
    let mut rows = vec![];
    for (name, (setup, seconds)) in levels {
        let setup = setup?;
        let mut row = row![format!("{name}, {} threads", rayon::current_num_threads()), fixed(seconds, 2)];
        for counts in [[12, 1, 1, 1], [12, 1, 1, 32], [12, 1, 9, 32], [12, 5, 9, 16]] {
            let (grid, seconds) = timed(|| setup.samples(counts));
            let solves = grid?.loa_force.len() * (counts[0] + 1) / counts[0];
            row.push(format!("{seconds:.2} ({solves})"));
        }
        rows.push(row);
        setups.push((name, setup));
    }
    let head = ["refinement", "models, s", "12, s", "12 × 32, s", "12 × 9 × 32, s", "12 × 5 × 9 × 16, s"];
    data.table("sweeps", &head, &rows)?;

    let (_, best) = &setups[setups.len() - 1];
    let nominal = best.pair.operating.nominal_torque;
    let torques = [0.7 * nominal, nominal, 1.3 * nominal];
    let exact = best.exact(&best.ranges(3), points(context))?;
    let mut rows = vec![];
    for (name, setup) in &setups {
        let mut row = row![name];
        for torque in torques {
            let [mean, swing] = ste(&setup.solver, torque, 32)?;
            row.push(format!("{mean:.2} / {swing:.3}"));
        }
        let table = FlankTable::new(&setup.samples([12, 1, 9, 32])?, Interpolation::Spline)?;
        row.extend(interpolants::force_error(&table, &exact, best.nominal_force()).map(|e| fixed(100.0 * e, 2)));
        rows.push(row);
    }
    let [a, b, c] = torques.map(|t| format!("{t:.0} N m"));
    data.table("refinements", &["refinement", &a, &b, &c, "rms error, %", "largest, %"], &rows)
}
