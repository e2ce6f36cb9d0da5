//! Every interpolant on grids of one to four dimensions: time against error.

use super::{Sampled, points, thinned};
use crate::data::{Data, fixed, rms};
use crate::setup::Exact;
use crate::timing::{Candidate, medians};
use crate::{Context, Result, row};
use gearmesh::table::{FlankTable, Interpolation};

/// All there are, with their names in the FMU.
pub const INTERPOLATIONS: [(Interpolation, &str); 3] =
    [(Interpolation::Linear, "linear"), (Interpolation::Spline, "spline"), (Interpolation::Shepard, "shepard")];

/// Root mean square and maximum of the force error over the nominal force.
pub fn force_error(table: &FlankTable, points: &[Exact], nominal: f64) -> [f64; 2] {
    let error = |x: &Exact| (table.evaluate(&x.query, false).gradient[0] - x.force) / nominal;
    let errors: Vec<f64> = points.iter().map(error).collect();
    [rms(errors.iter().copied()), errors.iter().fold(0.0, |m, e| m.max(e.abs()))]
}

/// One table with its price, ns without and with gradient, and its error, rms and largest.
struct Outcome {
    name: &'static str,
    table: FlankTable,
    grid: String,
    time: [f64; 2],
    error: [f64; 2],
}

/// Steps through the samples that make the grids of each dimension.
const GRIDS: [&[[usize; 4]]; 4] = [
    &[[4, 0, 0, 0], [2, 0, 0, 0], [1, 0, 0, 0]],
    &[[4, 0, 0, 8], [2, 0, 0, 4], [2, 0, 0, 2], [1, 0, 0, 2], [1, 0, 0, 1]],
    &[[4, 0, 4, 8], [2, 0, 2, 4], [2, 0, 1, 4], [2, 0, 1, 2], [1, 0, 1, 2], [1, 0, 1, 1]],
    &[[4, 2, 4, 8], [2, 2, 2, 4], [2, 2, 1, 4], [2, 2, 1, 2], [1, 2, 1, 2], [1, 1, 1, 1]],
];

/// The chapter, with a table for each dimension.
pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid: samples } = Sampled::of(context)?;
    for dimensions in 1..=4 {
        let exact = setup.exact(&setup.ranges(dimensions), points(context))?;
        let mut outcomes = vec![];
        for &steps in GRIDS[dimensions - 1] {
            let grid = thinned(samples, steps);
            let [nc, nm, nu, np] = grid.axes.lengths();
            let lengths = format!("{nu} × {nc} × {nm} × {np}");
            for (interpolation, name) in INTERPOLATIONS {
                // A grid too coarse for a positive span is refused, as it is in an FMU.
                match FlankTable::new(&grid, interpolation) {
                    Ok(table) => {
                        let error = force_error(&table, &exact, setup.nominal_force());
                        outcomes.push(Outcome { name, table, grid: lengths.clone(), time: [0.0; 2], error });
                    }
                    Err(why) => eprintln!("    {lengths}: {why}"),
                }
            }
        }
        let evaluation =
            |table, hessian| Candidate::over(&exact, move |x| FlankTable::evaluate(table, &x.query, hessian));
        let mut candidates: Vec<_> =
            outcomes.iter().flat_map(|o| [false, true].map(|hessian| evaluation(&o.table, hessian))).collect();
        let times = medians(&mut candidates);
        drop(candidates);
        for (outcome, time) in outcomes.iter_mut().zip(times.chunks_exact(2)) {
            outcome.time = [time[0], time[1]];
        }
        write(data, dimensions, outcomes)?;
    }
    Ok(())
}

/// Those that no other one beats in both time with gradient and error are on the Pareto front.
fn write(data: &Data, dimensions: usize, outcomes: Vec<Outcome>) -> Result<()> {
    let mut order: Vec<&Outcome> = outcomes.iter().collect();
    order.sort_by(|a, b| a.time[1].total_cmp(&b.time[1]));
    let mut best = f64::INFINITY;
    order.retain(|o| {
        let better = o.error[0] < best;
        best = best.min(o.error[0]);
        better
    });
    let row = |o: &Outcome| {
        let on_front = order.iter().any(|other| std::ptr::eq(*other, o));
        let numbers = row![fixed(o.table.bytes() as f64 / 1e3, 0), fixed(o.time[0], 0), fixed(o.time[1], 0)];
        let errors = row![fixed(100.0 * o.error[0], 3), fixed(100.0 * o.error[1], 3)];
        [row![o.name, o.grid], numbers, errors, row![if on_front { "yes" } else { "" }]].concat()
    };
    let rows: Vec<_> = outcomes.iter().map(row).collect();
    let head = [
        "interpolation",
        "grid",
        "kB",
        "value, ns",
        "with gradient, ns",
        "rms error, %",
        "largest error, %",
        "Pareto front",
    ];
    data.table(&format!("interpolants-{dimensions}d"), &head, &rows)
}
