//! The study as one HTML page: the spread in numbers and as cumulative distributions.

use super::samples::Sample;
use super::statistics::ascending;
use crate::Error;
use crate::report::chart::{Axes, Curve, line_chart};
use crate::report::page::Page;

/// Results that are drawn, with what stands at their axis.
const DRAWN: [(&str, &str); 5] = [
    ("peak_to_peak_ste_loa_um", "p-p STE (um)"),
    ("maximum_pressure_mpa", "largest flank pressure (MPa)"),
    ("face_load_factor", "K_Hbeta"),
    ("root_stress_1_mpa", "root stress of gear 1 (MPa)"),
    ("root_stress_2_mpa", "root stress of gear 2 (MPa)"),
];

/// The page of `samples` with the results `names`; `text` is what the command prints.
pub fn page(name: &str, text: &str, names: &[&str], samples: &[Sample]) -> Result<String, Error> {
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
    for (result, x) in DRAWN {
        let Some(k) = names.iter().position(|name| *name == result) else {
            continue;
        };
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
        let axes = Axes::new(x, "share of the samples (%)").starting_at_zero();
        charts.push(line_chart(&axes, &curves)?);
    }
    page.pictures(&charts);
    Ok(page.finish())
}
