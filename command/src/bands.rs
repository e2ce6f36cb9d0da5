//! The results of a study over torque, for its own page and for that of a report.

use std::path::Path;

use gearmesh::words::{rounded, shown};
use serde::Deserialize;

use crate::error::Result;
use crate::output;
use crate::page::{Curve, Height, Section, Style, charts};
use crate::statistics::{Outcome, Statistics, outcomes};

pub fn is_headed((_, outcome): &(usize, &Outcome)) -> bool {
    !outcome.head.is_empty()
}

/// What an axis with `outcome` is called.
pub fn label(Outcome { head, unit, .. }: &Outcome) -> String {
    match *unit {
        "" => head.clone(),
        unit => format!("{head} ({unit})"),
    }
}

/// The results over torque: the points themselves, and the band that nine tenths of their samples lie in.
pub fn bands(statistics: &[Statistics]) -> Section {
    let mut points: Vec<usize> = statistics.iter().map(|s| s.point).collect();
    points.dedup();
    let mut figures = Vec::new();
    for (_, outcome) in outcomes(true).iter().enumerate().filter(is_headed) {
        let mut curves = Vec::new();
        for point in &points {
            let name = match point {
                0 => "as drawn",
                _ => "best",
            };
            let mut own: Vec<&Statistics> = statistics
                .iter()
                .filter(|s| s.point == *point && s.result == outcome.name)
                .collect();
            own.sort_by(|a, b| a.torque_nm.total_cmp(&b.torque_nm));
            let points =
                |value: fn(&Statistics) -> f64| own.iter().map(move |s| (s.torque_nm, value(s)));
            curves.push(Curve::new(name, points(|s| s.nominal)));
            let is_drawn = own.iter().any(|s| s.percentile_5 < s.percentile_95);
            curves.extend(is_drawn.then(|| Curve {
                style: Style::Band(own.iter().map(|s| s.percentile_5).collect()),
                ..Curve::new("5 to 95 %", points(|s| s.percentile_95))
            }));
        }
        if curves.iter().any(|curve| !curve.points.is_empty()) {
            figures.extend(charts! {
                format!("Band of {} over torque", outcome.head), ["torque on gear 1 (N m)", &label(outcome)], Height::FromZero(0.0)
                    => curves;
            });
        }
    }
    let note = "Lines: the point itself; areas: between the 5th and the 95th percentile of its samples within the tolerances.";
    Section::new("Bands over torque", note, figures)
}

/// The bands of the study in `folder`, if it is a finished one of the pair `name` with several torques.
pub fn bands_of(folder: &Path, name: &str) -> Result<Section> {
    #[derive(Deserialize)]
    struct Known {
        pair: String,
        torques_nm: Vec<f64>,
        statistics: Vec<Statistics>,
    }
    let path = folder.join("study.json");
    let wrong = |what: String| format!("--study = {}: {what}", folder.display());
    let text = output::read_text(&path).map_err(wrong)?;
    let known = serde_json::from_str(&text);
    let known: Known = known.map_err(|e| wrong(format!("study.json: {e}")))?;
    if known.pair != name && Some(&*known.pair) != name.strip_suffix("-best") {
        let other = shown(&known.pair);
        return Err(wrong(format!("this is a study of {other}; give one of {name}")).into());
    }
    if known.torques_nm.len() < 2 || known.statistics.is_empty() {
        let torques: Vec<f64> = known.torques_nm.into_iter().map(rounded).collect();
        return Err(wrong(format!(
            "no band over the torques {torques:?}; solve the study to its end with two --torques-nm or more"
        ))
        .into());
    }
    Ok(bands(&known.statistics))
}
