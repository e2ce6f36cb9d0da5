//! The study as one HTML page: the spread in numbers and as cumulative distributions.

use super::samples::{Outcome, Sample};
use super::statistics::ascending;
use crate::Error;
use crate::report::chart::{Curve, Height, line_chart};
use crate::report::page::Page;

/// The page of `samples` with the results `outcomes`; `text` is what the command prints.
pub fn page(
    name: &str,
    text: &str,
    outcomes: &[Outcome],
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
        let Some((_, x)) = outcome.head else { continue };
        let of = |drawn: bool| -> Vec<f64> {
            let chosen = samples.iter().filter(|s| (s.number == 0) == drawn);
            chosen
                .filter_map(|s| Some(s.outcome.as_ref().ok()?[k]))
                .collect()
        };
        let sorted = ascending(&of(false));
        // What does not vary is in the table.
        if sorted.first() == sorted.last() {
            continue;
        }
        let share = |i: usize| 100.0 * (i as f64 + 0.5) / sorted.len() as f64;
        let curves = [
            Curve {
                label: "samples".into(),
                points: sorted
                    .iter()
                    .enumerate()
                    .map(|(i, v)| (*v, share(i)))
                    .collect(),
            },
            Curve {
                label: "as drawn".into(),
                points: of(true)
                    .iter()
                    .flat_map(|v| [(*v, 0.0), (*v, 100.0)])
                    .collect(),
            },
        ];
        let labels = [x, "share of the samples (%)"];
        charts.push(line_chart(labels, Height::FromZero(0.0), &curves)?);
    }
    page.pictures(&charts);
    Ok(page.finish())
}
