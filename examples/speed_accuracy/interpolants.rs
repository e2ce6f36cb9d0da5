//! Every interpolant on grids of one to four dimensions: time against error.

use crate::document::{Document, Error};
use crate::plot::{Series, log_log};
use crate::setting::{Exact, Setting, thinned};
use crate::timing::{Candidate, medians};
use gearmesh::table::{FlankGrid, FlankTable, Interpolation};
use std::hint::black_box;

/// All there are, with their names in the FMU.
pub const INTERPOLATIONS: [(Interpolation, &str); 3] = [
    (Interpolation::Linear, "linear"),
    (Interpolation::Spline, "spline"),
    (Interpolation::Shepard, "shepard"),
];

/// Root mean square and maximum of the force error over the nominal force.
pub fn force_error(table: &FlankTable, points: &[Exact], nominal: f64) -> [f64; 2] {
    let errors: Vec<f64> = points
        .iter()
        .map(|x| (table.evaluate(&x.query, false).gradient[0] - x.force) / nominal)
        .collect();
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    [
        (squares / errors.len() as f64).sqrt(),
        errors.iter().fold(0.0, |m, e| m.max(e.abs())),
    ]
}

/// One table with its price and its error.
pub struct Outcome {
    pub interpolation: usize,
    pub dimensions: usize,
    pub lengths: [usize; 4],
    pub bytes: usize,
    /// ns: value, with gradient.
    pub time: [f64; 2],
    /// rms, maximum.
    pub error: [f64; 2],
    pub minimum_slope: f64,
}

/// Steps through the samples that make the grids of each dimension.
const GRIDS: [&[[usize; 4]]; 4] = [
    &[[4, 0, 0, 0], [2, 0, 0, 0], [1, 0, 0, 0]],
    &[
        [4, 0, 0, 8],
        [2, 0, 0, 4],
        [2, 0, 0, 2],
        [1, 0, 0, 2],
        [1, 0, 0, 1],
    ],
    &[
        [4, 0, 4, 8],
        [2, 0, 2, 4],
        [2, 0, 1, 4],
        [2, 0, 1, 2],
        [1, 0, 1, 2],
        [1, 0, 1, 1],
    ],
    &[
        [4, 2, 4, 8],
        [2, 2, 2, 4],
        [2, 2, 1, 4],
        [2, 2, 1, 2],
        [1, 2, 1, 2],
        [1, 1, 1, 1],
    ],
];

/// Times and errors of all.
pub fn measure(
    setting: &Setting,
    samples: &FlankGrid,
    points: usize,
) -> Result<Vec<Outcome>, Error> {
    let mut outcomes = vec![];
    for dimensions in 1..=4 {
        let exact = setting.exact(&setting.ranges(dimensions), points)?;
        let mut tables = vec![];
        for &steps in GRIDS[dimensions - 1] {
            let grid = thinned(samples, steps);
            for (i, (interpolation, _)) in INTERPOLATIONS.iter().enumerate() {
                // A grid too coarse for a positive span is refused, as it is in an FMU.
                match FlankTable::new(&grid, *interpolation) {
                    Ok(table) => tables.push((i, grid.axes.lengths(), table)),
                    Err(why) => eprintln!("  {dimensions}-D, {:?}: {why}", grid.axes.lengths()),
                }
            }
        }
        let exact = &exact;
        let mut candidates = vec![];
        for (_, _, table) in &tables {
            for hessian in [false, true] {
                candidates.push(Candidate::new(exact.len(), move || {
                    for x in exact {
                        black_box(table.evaluate(black_box(&x.query), hessian));
                    }
                }));
            }
        }
        let times = medians(&mut candidates);
        drop(candidates);
        for (k, (interpolation, lengths, table)) in tables.iter().enumerate() {
            outcomes.push(Outcome {
                interpolation: *interpolation,
                dimensions,
                lengths: *lengths,
                bytes: table.bytes(),
                time: [times[2 * k], times[2 * k + 1]],
                error: force_error(table, exact, setting.nominal_force()),
                minimum_slope: table.checks().minimum_slope,
            });
        }
    }
    Ok(outcomes)
}

/// Indices of those that no other one beats in both time with gradient and error, by time.
fn front(outcomes: &[&Outcome]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..outcomes.len()).collect();
    order.sort_by(|&i, &j| outcomes[i].time[1].total_cmp(&outcomes[j].time[1]));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = outcomes[i].error[0] < best;
        best = best.min(outcomes[i].error[0]);
        better
    });
    order
}

/// The section with a table and a plot per dimension.
pub fn report(document: &mut Document, outcomes: &[Outcome]) -> Result<(), Error> {
    document.section("Time against error");
    document.paragraph(
        "The tables' samples come from the contact solver of the reference pair on coarse \
         finite elements; errors are those of the force, over the nominal force, at random operating points \
         (torques from 0 to the maximum, other coordinates over their ranges) against direct solutions \
         there. *Value* is force, shuttling moment, tangent stiffness and the two side terms dW/dC and \
         dW/dPMC, which is what an evaluation of the loads needs; *with gradient* adds the derivatives \
         of all of them by the four coordinates. Points come in random order, so that each one finds \
         another cell. Grids are written as displacements × centre distances × misalignments × mesh \
         positions. The **bold** ones are on the Pareto front of their dimension: none of the others is \
         both faster with gradient and more accurate. Least slope is a lower bound of dF/du of the \
         samples over the top force; negative where the samples had to be corrected to be monotone. Grids so coarse that top-load minus \
         no-load approach is not positive between their nodes are refused by the table and missing here.",
    );
    for dimensions in 1..=4 {
        let these: Vec<&Outcome> = outcomes
            .iter()
            .filter(|o| o.dimensions == dimensions)
            .collect();
        let front = front(&these);
        let rows: Vec<[String; 8]> = these
            .iter()
            .enumerate()
            .map(|(i, o)| {
                let name = INTERPOLATIONS[o.interpolation].1;
                let [nc, nm, nu, np] = o.lengths;
                [
                    if front.contains(&i) {
                        format!("**{name}**")
                    } else {
                        name.to_owned()
                    },
                    format!("{nu} × {nc} × {nm} × {np}"),
                    format!("{:.0}", o.bytes as f64 / 1e3),
                    format!("{:.0}", o.time[0]),
                    format!("{:.0}", o.time[1]),
                    format!("{:.3}", 100.0 * o.error[0]),
                    format!("{:.3}", 100.0 * o.error[1]),
                    format!("{:.3}", o.minimum_slope),
                ]
            })
            .collect();
        document.paragraph(&format!(
            "### {dimensions}-D{}",
            [
                "",
                ": + mesh position",
                ": + misalignment",
                ": + centre distance"
            ][dimensions - 1]
        ));
        document.table(
            [
                "interpolation",
                "grid",
                "kB",
                "value, ns",
                "with gradient, ns",
                "rms error, %",
                "largest error, %",
                "least slope",
            ],
            &rows,
        );
        let series: Vec<Series> = INTERPOLATIONS
            .iter()
            .enumerate()
            .map(|(i, (_, name))| Series {
                label: (*name).to_owned(),
                points: these
                    .iter()
                    .filter(|o| o.interpolation == i)
                    .map(|o| (o.time[1], 100.0 * o.error[0]))
                    .collect(),
                joined: false,
            })
            .collect();
        let front: Vec<(f64, f64)> = front
            .iter()
            .map(|&i| (these[i].time[1], 100.0 * these[i].error[0]))
            .collect();
        let svg = log_log(
            "time of one evaluation with gradient, ns",
            "rms force error, % of nominal",
            &series,
            &front,
        )?;
        document.plot(
            &format!("speed-accuracy-{dimensions}d"),
            &format!("Time against error in {dimensions}-D"),
            &svg,
        )?;
    }
    Ok(())
}
