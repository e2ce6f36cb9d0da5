//! Every interpolant on grids of four dimensions: time against error.

use super::{Sampled, points, thinned};
use crate::data::{Data, range, rms};
use crate::setup::Exact;
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use gearmesh::table::{FlankTable, Interpolation};

/// All there are, with their names in the FMU.
const INTERPOLATIONS: [(Interpolation, &str); 3] = [
    (Interpolation::Linear, "linear"),
    (Interpolation::Spline, "spline"),
    (Interpolation::Shepard, "shepard"),
];

/// Error of the force over the nominal force.
struct ForceError {
    rms: f64,
    largest: f64,
}

/// The error of `table` at `points`.
fn force_error(table: &FlankTable, points: &[Exact], nominal: f64) -> ForceError {
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
    steps: [usize; 4],
    table: FlankTable,
    error: ForceError,
    time: [f64; 2],
}

/// The grid of the table of ratios.
const RATIOS: [usize; 4] = [1, 1, 1, 2];
/// Steps through the samples that make the grids.
const GRIDS: [[usize; 4]; 7] = [
    [4, 2, 4, 8],
    [2, 2, 2, 4],
    [2, 2, 1, 4],
    [2, 2, 1, 2],
    [1, 2, 1, 2],
    RATIOS,
    [1, 1, 1, 1],
];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let sampled = Sampled::of(context)?;
    let (setup, samples) = (&sampled.setup, &sampled.grid);
    let exact = setup.exact(points(context))?;
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
                    let time = [0.0; 2];
                    outcomes.push(Outcome {
                        name,
                        steps,
                        table,
                        error,
                        time,
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
    let row = |o: &Outcome| {
        // Those that no other one beats in both time with gradient and error.
        let better = |other: &Outcome| other.time[1] < o.time[1] && other.error.rms <= o.error.rms;
        let front = if outcomes.iter().any(better) {
            ""
        } else {
            "yes"
        };
        let (kilobytes, [value, gradient]) = (o.table.bytes() as f64 / 1e3, o.time);
        let errors = format!(
            "{:.3} | {:.3}",
            100.0 * o.error.rms,
            100.0 * o.error.largest
        );
        format!(
            "{} | {kilobytes:.0} | {value:.0} | {gradient:.0} | {errors} | {front}",
            o.name
        )
    };
    let rows: Vec<_> = outcomes.iter().map(row).collect();
    let head = "interpolation | grid | kB | value, ns | with gradient, ns | rms error, % | largest error, % | Pareto front";
    data.table("interpolants-4d", head, &rows)?;

    let of_grid: Vec<_> = outcomes.iter().filter(|o| o.steps == RATIOS).collect();
    let [linear, spline, shepard] = of_grid[..] else {
        return Err("a grid of the table of ratios was refused".into());
    };
    let rows = [
        (
            "spline over linear kernel, 4-D with gradient",
            2,
            spline.time[1] / linear.time[1],
        ),
        (
            "rms error, linear over spline, same 4-D grid",
            0,
            linear.error.rms / spline.error.rms,
        ),
        (
            "shepard over spline kernel, 4-D with gradient",
            1,
            shepard.time[1] / spline.time[1],
        ),
        (
            "rms error, shepard over spline, same 4-D grid",
            2,
            shepard.error.rms / spline.error.rms,
        ),
    ]
    .map(|(name, digits, value)| format!("{name} | {value:.digits$}"));
    data.table("ratios", "quantity | measured", &rows)
}
