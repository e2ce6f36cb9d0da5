//! Every interpolant on grids of four dimensions: time against error.

use super::{Sampled, points, thinned};
use crate::data::{Data, range, rms};
use crate::setup::Exact;
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use gearmesh::table::{FlankTable, Interpolation};

/// All there are, with their names in the FMU.
pub const INTERPOLATIONS: [(Interpolation, &str); 3] = [
    (Interpolation::Linear, "linear"),
    (Interpolation::Spline, "spline"),
    (Interpolation::Shepard, "shepard"),
];

/// Error of the force over the nominal force.
pub struct ForceError {
    pub rms: f64,
    pub largest: f64,
}

/// The error of `table` at `points`.
pub fn force_error(table: &FlankTable, points: &[Exact], nominal: f64) -> ForceError {
    let error = |x: &Exact| (table.evaluate(&x.query, false).gradient[0] - x.force).abs() / nominal;
    let errors: Vec<f64> = points.iter().map(error).collect();
    let [_, largest] = range(errors.iter().copied());
    ForceError {
        rms: rms(errors),
        largest,
    }
}

/// One table with its error and its price, ns without and with gradient.
struct Outcome {
    name: String,
    table: FlankTable,
    error: ForceError,
    time: [f64; 2],
}

/// Steps through the samples that make the grids.
const GRIDS: [[usize; 4]; 6] = [
    [4, 2, 4, 8],
    [2, 2, 2, 4],
    [2, 2, 1, 4],
    [2, 2, 1, 2],
    [1, 2, 1, 2],
    [1, 1, 1, 1],
];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled {
        setup,
        grid: samples,
    } = Sampled::of(context)?;
    let exact = setup.exact(&setup.ranges(4), points(context))?;
    let mut outcomes = vec![];
    for steps in GRIDS {
        let grid = thinned(samples, steps);
        let [nc, nm, nu, np] = grid.axes.lengths();
        for (interpolation, name) in INTERPOLATIONS {
            let name = format!("{name} | {nu} × {nc} × {nm} × {np}");
            // A grid too coarse for a positive span is refused, as it is in an FMU.
            match FlankTable::new(&grid, interpolation) {
                Ok(table) => {
                    let error = force_error(&table, &exact, setup.nominal_force());
                    outcomes.push(Outcome {
                        name,
                        table,
                        error,
                        time: [0.0; 2],
                    });
                }
                Err(why) => eprintln!("    {name}: {why}"),
            }
        }
    }
    let mut candidates = vec![];
    for Outcome { table, .. } in &outcomes {
        for hessian in [false, true] {
            let evaluate = move |x: &Exact| table.evaluate(&x.query, hessian);
            candidates.push(Candidate::over(&exact, evaluate));
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);
    for (outcome, time) in outcomes.iter_mut().zip(times.chunks_exact(2)) {
        outcome.time = [time[0], time[1]];
    }
    let row = |Outcome {
                   name,
                   table,
                   error,
                   time,
               }: &Outcome| {
        // Those that no other one beats in both time with gradient and error.
        let better = |o: &Outcome| o.time[1] < time[1] && o.error.rms <= error.rms;
        let front = if outcomes.iter().any(better) {
            ""
        } else {
            "yes"
        };
        let (kilobytes, [value, gradient]) = (table.bytes() as f64 / 1e3, time);
        let (rms, largest) = (100.0 * error.rms, 100.0 * error.largest);
        format!(
            "{name} | {kilobytes:.0} | {value:.0} | {gradient:.0} | {rms:.3} | {largest:.3} | {front}"
        )
    };
    let rows: Vec<_> = outcomes.iter().map(row).collect();
    let head = "interpolation | grid | kB | value, ns | with gradient, ns | rms error, % | largest error, % | Pareto front";
    data.table("interpolants-4d", head, &rows)
}
