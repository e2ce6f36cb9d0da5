//! What a study prints, and the same as an HTML page with the results as cumulative distributions.

use std::fmt::Write;

use gearmesh::words::{count, shown};
use gearmesh_preprocessor::pair;

use super::Bench;
use super::samples::{Sample, Solved};
use super::statistics::{Statistics, ascending};
use super::variation::Variation;
use crate::Error;
use crate::columns::{Column, Text, columns, table};
use crate::output::Listing;
use crate::report::chart::{Curve, Height, line_chart};
use crate::report::page::Page;

/// Spread of the results of `done` and their correlation with the varied fields.
pub fn text(
    bench: &Bench,
    seed: u64,
    done: &[Sample],
    outcomes: &[Column<Solved>],
    statistics: &[Statistics],
) -> String {
    let refused = done.iter().filter(|s| s.outcome.is_err()).count();
    let samples = count(done.len() - 1, "sample");
    let mut rows = Listing::default();
    for v in bench.variations {
        rows.row(&v.field, format!("{} to {}, even", v.low, v.high));
    }
    let mut text = format!(
        "{}: {samples}, {refused} refused, seed {seed}\n\n{rows}\n",
        shown(&bench.pair.name)
    );
    let spread = columns! { |s: &&Statistics|
        "", ["result", "", None] => s.result.clone();
        "", ["as drawn", "", 3] => s.nominal;
        "", ["mean", "", 3] => s.mean;
        "", ["5 %", "", 3] => s.percentile_5;
        "", ["median", "", 3] => s.median;
        "", ["95 %", "", 3] => s.percentile_95;
        "", ["largest", "", 3] => s.largest;
    };
    text += &table(&spread, statistics);
    let mut correlations = |head: &str, values: fn(&Statistics) -> &[f64]| {
        let mut all =
            columns! { |(_, v): &(usize, &Variation)| "", [head, "", None] => v.field.clone(); };
        for (s, outcome) in statistics.iter().zip(outcomes) {
            if let Some(text) = &outcome.text {
                all.extend(columns! { |(k, _): &(usize, &Variation)| "", [&text.head, "", 2] => values(s)[*k]; });
            }
        }
        text.push('\n');
        text += &table(&all, bench.variations.iter().enumerate());
    };
    correlations("correlation with", |s| &s.correlation);
    correlations("of the distance from drawn", |s| &s.correlation_of_distance);
    text.push_str(
        "\nThe first correlation is near zero for a field that acts alike in both directions; the second one, of how far the field\n\
         is from its value as drawn, shows it. What fields do together (slopes of both gears that cancel) shows in neither.\n",
    );
    for sample in done {
        if let Err(error) = &sample.outcome {
            let _ = write!(
                text,
                "\nfirst that was refused: sample {}: {error}\n",
                sample.number
            );
            break;
        }
    }
    if let Some(note) = pair::note_on_teeth(&bench.pair.teeth) {
        let _ = write!(text, "\nnote: {note}\n");
    }
    text
}

/// The page of `samples` with the results `outcomes`; `text` is what the command prints.
pub fn page(
    name: &str,
    text: &str,
    outcomes: &[Column<Solved>],
    samples: &[Sample],
) -> Result<String, Error> {
    let mut page = Page::new(&format!("Tolerance study: {name}"));
    page.section(
        "In numbers",
        "Every field is drawn evenly from its interval; 5 % and 95 %: a twentieth of the samples lies below, above.",
    );
    page.preformatted(text);
    page.section(
        "Cumulative distribution",
        "Share of the samples up to a value; the vertical line is the pair as drawn.",
    );
    let mut charts = Vec::new();
    for (k, outcome) in outcomes.iter().enumerate() {
        let Some(Text { head, unit, .. }) = &outcome.text else {
            continue;
        };
        let (drawn, others): (Vec<&Sample>, Vec<&Sample>) =
            samples.iter().partition(|s| s.number == 0);
        let values: Vec<f64> = others.iter().filter_map(|s| s.result(k)).collect();
        let sorted = ascending(&values);
        // What does not vary is in the table.
        if sorted.first() == sorted.last() {
            continue;
        }
        let share = |i: usize| 100.0 * (i as f64 + 0.5) / sorted.len() as f64;
        let drawn = drawn.iter().filter_map(|s| s.result(k));
        let curve = |label: &str, points| Curve {
            label: label.into(),
            points,
        };
        let curves = [
            curve(
                "samples",
                sorted
                    .iter()
                    .enumerate()
                    .map(|(i, v)| (*v, share(i)))
                    .collect(),
            ),
            curve(
                "as drawn",
                drawn.flat_map(|v| [(v, 0.0), (v, 100.0)]).collect(),
            ),
        ];
        let labels = [&format!("{head} ({unit})"), "share of the samples (%)"];
        charts.push(line_chart(labels, Height::FromZero(0.0), &curves)?);
    }
    page.pictures(&charts);
    Ok(page.finish())
}
