//! What a study prints.

use gearmesh_preprocessor::pair;
use std::fmt::Write;

use gearmesh::words::{count, fixed, shown};

use super::Bench;
use super::samples::{Outcome, Sample};
use super::statistics::Statistics;
use crate::output::Listing;

/// Spread of the results of `done` and their correlation with the varied fields.
pub fn text(
    bench: &Bench,
    seed: u64,
    done: &[Sample],
    outcomes: &[Outcome],
    statistics: &[Statistics],
) -> String {
    let refused = done.iter().filter(|s| s.outcome.is_err()).count();
    let mut text = format!(
        "{}: {}, {refused} refused, seed {seed}\n",
        shown(&bench.pair.name),
        count(done.len() - 1, "sample")
    );
    let mut rows = Listing::default();
    for v in bench.variations {
        rows.row(&v.field, format!("{} to {}, even", v.low, v.high));
    }
    let _ = write!(text, "\n{rows}\n");
    let mut line = |first: &str, cells: &mut dyn Iterator<Item = String>| {
        let cells: String = cells.map(|cell| format!(" {cell:>9}")).collect();
        let _ = writeln!(text, "{first:<26}{cells}");
    };
    let heads = ["as drawn", "mean", "5 %", "median", "95 %", "largest"];
    line("", &mut heads.into_iter().map(String::from));
    for s in statistics {
        let low = [s.nominal, s.mean, s.percentile_5];
        let values = low
            .into_iter()
            .chain([s.median, s.percentile_95, s.largest]);
        let digits = |value: f64| if value.abs() < 100.0 { 3 } else { 0 };
        line(
            s.result,
            &mut values.map(|value| fixed(value, digits(value))),
        );
    }
    let heads = outcomes.iter().map(|outcome| outcome.head);
    let correlated: Vec<(&Statistics, &str)> = (statistics.iter().zip(heads))
        .filter_map(|(s, head)| Some((s, head?.0)))
        .collect();
    let mut correlations = |head: &str, of: fn(&Statistics) -> &[f64]| {
        let heads = correlated.iter().map(|(_, head)| head.to_string());
        line(&format!("\n{head:<26}"), &mut heads.into_iter());
        for (k, v) in bench.variations.iter().enumerate() {
            line(
                &v.field,
                &mut correlated.iter().map(|(s, _)| fixed(of(s)[k], 2)),
            );
        }
    };
    correlations("correlation with", |s| &s.correlation);
    correlations("of the distance from drawn", |s| &s.correlation_of_distance);
    text.push_str(
        "\nThe first correlation is near zero for a field that acts alike in both directions; the second one, of how far the field\n\
         is from its value as drawn, shows it. What fields do together (slopes of both gears that cancel) shows in neither.\n",
    );
    let first = done
        .iter()
        .find_map(|s| Some((s.number, s.outcome.as_ref().err()?)));
    if let Some((number, error)) = first {
        let _ = write!(text, "\nfirst that was refused: sample {number}: {error}\n");
    }
    if let Some(note) = pair::note_on_teeth(&bench.pair.teeth) {
        let _ = write!(text, "\nnote: {note}\n");
    }
    text
}
