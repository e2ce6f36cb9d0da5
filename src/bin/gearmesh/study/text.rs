//! What a study prints.

use std::fmt::Write;

use gearmesh::words::{count, fixed, shown};

use super::Bench;
use super::samples::Sample;
use super::statistics::Statistics;
use crate::output::Listing;

/// Results whose correlation is printed, with what stands above it.
const CORRELATED: [(&str, &str); 5] = [
    ("peak_to_peak_ste_loa_um", "p-p STE"),
    ("maximum_pressure_mpa", "pressure"),
    ("face_load_factor", "K_Hbeta"),
    ("root_stress_1_mpa", "root 1"),
    ("root_stress_2_mpa", "root 2"),
];

/// Spread of the results of `done` and their correlation with the varied fields.
pub fn text(bench: &Bench, seed: u64, done: &[Sample], statistics: &[Statistics]) -> String {
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
    let heads = ["as drawn", "mean", "5 %", "median", "95 %", "largest"];
    let _ = write!(text, "{:<26}", "");
    for head in heads {
        let _ = write!(text, " {head:>9}");
    }
    text.push('\n');
    for s in statistics {
        let _ = write!(text, "{:<26}", s.result);
        for value in [
            s.nominal,
            s.mean,
            s.percentile_5,
            s.median,
            s.percentile_95,
            s.largest,
        ] {
            let digits = if value.abs() < 100.0 { 3 } else { 0 };
            let _ = write!(text, " {:>9}", fixed(value, digits));
        }
        text.push('\n');
    }
    let correlated: Vec<(&Statistics, &str)> = (statistics.iter())
        .filter_map(|s| {
            let known = CORRELATED.iter().find(|(result, _)| *result == s.result);
            Some((s, known?.1))
        })
        .collect();
    let mut correlations = |head: &str, of: fn(&Statistics) -> &[f64]| {
        let _ = write!(text, "\n{head:<26}");
        for (_, result) in &correlated {
            let _ = write!(text, " {result:>9}");
        }
        text.push('\n');
        for (k, v) in bench.variations.iter().enumerate() {
            let _ = write!(text, "{:<26}", v.field);
            for (s, _) in &correlated {
                let _ = write!(text, " {:>9}", fixed(of(s)[k], 2));
            }
            text.push('\n');
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
    if let Some(note) = bench.pair.note_on_teeth() {
        let _ = write!(text, "\nnote: {note}\n");
    }
    text
}
