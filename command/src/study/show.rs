//! What a study prints, and the same as an HTML page with charts.

use std::fmt::Write;
use std::path::Path;

use gearmesh::words::{count, fixed, rounded, shown};
use serde::Deserialize;

use super::Summary;
use super::best::Measure;
use super::samples::{Outcome, Sample, outcomes};
use super::statistics::{Statistics, ascending};
use super::variation::{Plan, Variation};
use crate::Error;
use crate::case::torque_in_words;
use crate::columns::{columns, table};
use crate::output::{self, Listing};
use crate::report::figure::{Curve, Figure, Height, Map, Style};
use crate::report::page::{Page, Section};

/// Points of a grid in the table of the best ones.
const BEST: usize = 10;

/// A study that was solved.
pub struct Shown<'a> {
    pub summary: &'a Summary<'a>,
    pub plan: &'a Plan,
    pub outcomes: &'a [Outcome],
    pub done: &'a [Sample],
    pub measure: &'a Measure,
}

impl Shown<'_> {
    /// Measure of every point of the grid that has one, best first.
    fn ranking(&self) -> Vec<(usize, f64)> {
        let points = 1..=self.plan.points();
        let mut all: Vec<(usize, f64)> = points
            .filter_map(|point| Some((point, self.measure.of(self.done, point)?)))
            .collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    }

    pub fn text(&self) -> String {
        let Summary { pair, seed, .. } = *self.summary;
        let points = match self.plan.points() {
            0 => String::new(),
            points => format!("{} of a grid, ", count(points, "point")),
        };
        let mut rows = Listing::default();
        for v in &self.summary.varied {
            let how = v
                .points
                .map_or("even".into(), |points| format!("{points} points"));
            rows.row(&v.field, format!("{} to {}, {how}", v.low, v.high));
        }
        let mut text = format!(
            "{}: {points}{}, {} refused, seed {seed}\n\n{rows}\n",
            shown(pair),
            count(self.summary.samples, "sample"),
            self.summary.refused
        );
        if let Some(best) = &self.summary.best {
            let _ = writeln!(
                text,
                "best by {}; as drawn: {}\n",
                best.measure,
                best.as_drawn.map_or("refused".into(), |v| fixed(v, 4))
            );
            let mut columns = columns! { |(point, value): &(usize, f64)|
                "", ["point", "", None] => *point;
                "", ["measure", "", 4] => *value;
            };
            for (k, (field, _)) in self.plan.fields.iter().enumerate() {
                columns.extend(columns! { |(point, _): &(usize, f64)| "", [field, "", None] => self.plan.values(*point, 0, 0)[k]; });
            }
            text += &table(&columns, self.ranking().into_iter().take(BEST));
            text.push('\n');
        }
        let spread = columns! { |s: &&Statistics|
            "", ["result", "", None] => s.result.clone();
            "", ["torque", "N m", None] => s.torque_nm;
            "", ["point", "", None] => match s.point { 0 => "as drawn", _ => "best" };
            "", ["itself", "", 3] => s.nominal;
            "", ["mean", "", 3] => s.mean;
            "", ["5 %", "", 3] => s.percentile_5;
            "", ["median", "", 3] => s.median;
            "", ["95 %", "", 3] => s.percentile_95;
            "", ["largest", "", 3] => s.largest;
        };
        let all = &self.summary.statistics;
        let columns = if self.summary.samples > 0 {
            &spread[..]
        } else {
            &spread[..4]
        };
        text += &table(columns, all);
        if self.summary.samples > 0 {
            text += &self.correlations();
        }
        if let Some((sample, error)) = self
            .done
            .iter()
            .find_map(|s| Some((s, s.outcome.as_ref().err()?)))
        {
            let _ = write!(text, "\nfirst that was refused: ");
            if sample.point > 0 {
                let _ = write!(text, "point {}, ", sample.point);
            }
            let _ = writeln!(text, "sample {}: {error}", sample.number);
        }
        for note in &self.summary.notes {
            let _ = write!(text, "\nnote: {note}\n");
        }
        text
    }

    /// Those of the last statistics, at their first torque, with the fields that are drawn.
    fn correlations(&self) -> String {
        let all = &self.summary.statistics;
        let point = all.last().map_or(0, |s| s.point);
        let statistics = all.iter().filter(|s| s.point == point);
        let statistics: Vec<&Statistics> = statistics.take(self.outcomes.len()).collect();
        let mut text = String::new();
        let mut correlations = |head: &str, values: fn(&Statistics) -> &[f64]| {
            let place = |v: &Variation| {
                self.plan
                    .fields
                    .iter()
                    .position(|(field, _)| *field == v.field)
            };
            let mut all = columns! { |v: &&Variation| "", [head, "", None] => v.field.clone(); };
            for (s, outcome) in statistics.iter().zip(self.outcomes) {
                if !outcome.head.is_empty() {
                    all.extend(columns! { |v: &&Variation| "", [outcome.head, "", 2] => place(v).map(|k| values(s)[k]); });
                }
            }
            text.push('\n');
            text += &table(&all, &self.plan.drawn);
        };
        correlations("correlation with", |s| &s.correlation);
        correlations("of the distance from drawn", |s| &s.correlation_of_distance);
        text + "\nThe first correlation is near zero for a field that acts alike in both directions; the second one, of how far the field\n\
             is from its value as drawn, shows it. What fields do together (slopes of both gears that cancel) shows in neither.\n"
    }

    /// `text` is what the command prints.
    pub fn page(&self, text: &str) -> Page {
        let note = "Drawn fields are drawn evenly from their interval; 5 % and 95 %: a twentieth of the samples lies below, above.";
        let mut sections = vec![Section::new("In numbers", note, vec![]).with_text(text.into())];
        if self.summary.best.is_some() {
            let note = format!(
                "Measure: {}. A curve has the best of all other fields.",
                self.measure.words
            );
            sections.push(Section::new("Grid", note, self.grid()));
        }
        if self.summary.torques_nm.len() > 1 {
            sections.push(bands(&self.summary.statistics));
        }
        if self.summary.samples > 0 {
            let note = "Share of the samples up to a value; the vertical line is the point itself.";
            sections.push(Section::new(
                "Cumulative distribution",
                note,
                self.distributions(),
            ));
        }
        Page {
            title: format!("Study: {}", self.summary.pair),
            sections,
        }
    }

    /// The measure over each axis of the grid, and over both of two.
    fn grid(&self) -> Vec<Figure> {
        let ranking = self.ranking();
        let axis = |(k, axis): (usize, &Variation)| {
            let best = |i: usize| {
                let found = ranking
                    .iter()
                    .find(|(point, _)| self.plan.indices(*point)[k] == i);
                (
                    axis.value(i),
                    found.map_or(f64::NAN, |(_, measure)| *measure),
                )
            };
            let points = (0..axis.points.unwrap_or(0)).map(best);
            let title = format!("Measure over {}", axis.field);
            let curve = vec![Curve::new("best", points)];
            Figure::lines(
                &title,
                [&axis.field, "measure"],
                Height::FromZero(0.0),
                curve,
            )
        };
        let mut figures: Vec<Figure> = self.plan.grid.iter().enumerate().map(axis).collect();
        if let [x, y] = &self.plan.grid[..] {
            let nodes = [x, y].map(|axis| {
                (0..axis.points.unwrap_or(0))
                    .map(|i| axis.value(i))
                    .collect::<Vec<_>>()
            });
            let values =
                (1..=self.plan.points()).map(|p| self.measure.of(self.done, p).unwrap_or(f64::NAN));
            let labels = [x.field.as_str(), &y.field, "measure"];
            let map = Map::on_nodes(labels, [&nodes[0], &nodes[1]], values, 0.0);
            figures.push(Figure::map("Measure over both; blue: refused", map));
        }
        figures
    }

    fn distributions(&self) -> Vec<Figure> {
        let mut charts = Vec::new();
        let point = self.summary.best.map_or(0, |best| best.point);
        let (itself, samples): (Vec<&Sample>, Vec<&Sample>) = self
            .done
            .iter()
            .filter(|s| s.point == point)
            .partition(|s| s.number == 0);
        let headed = self.outcomes.iter().enumerate();
        for (k, Outcome { head, unit, .. }) in headed.filter(|(_, o)| !o.head.is_empty()) {
            let mut curves = Vec::new();
            for (t, torque) in self.summary.torques_nm.iter().enumerate() {
                let values: Vec<f64> = samples.iter().filter_map(|s| s.result(t, k)).collect();
                let sorted = ascending(&values);
                // What does not vary is in the table.
                if sorted.first() == sorted.last() {
                    continue;
                }
                let share = |i: usize| 100.0 * (i as f64 + 0.5) / sorted.len() as f64;
                let points = sorted.iter().enumerate().map(|(i, v)| (*v, share(i)));
                curves.push(Curve::new(torque_in_words(*torque), points));
                let itself = itself.iter().filter_map(|s| s.result(t, k));
                let line = itself.flat_map(|v| [(v, 0.0), (v, 100.0)]);
                curves.push(Curve::new("point itself", line));
            }
            if !curves.is_empty() {
                let labels = [&*axis_label(head, unit), "share of the samples (%)"];
                let title = format!("Distribution of {head}");
                charts.push(Figure::lines(&title, labels, Height::FromZero(0.0), curves));
            }
        }
        charts
    }
}

fn axis_label(head: &str, unit: &str) -> String {
    match unit {
        "" => head.into(),
        unit => format!("{head} ({unit})"),
    }
}

/// The results over torque: the points themselves, and the band that nine tenths of their samples lie in.
fn bands(statistics: &[Statistics]) -> Section {
    let mut points: Vec<usize> = statistics.iter().map(|s| s.point).collect();
    points.dedup();
    let mut figures = Vec::new();
    for outcome in outcomes(true).iter().filter(|o| !o.head.is_empty()) {
        let Outcome { head, unit, .. } = outcome;
        let mut curves = Vec::new();
        for point in &points {
            let name = if *point == 0 {
                "as drawn"
            } else {
                "best of the grid"
            };
            let own = statistics
                .iter()
                .filter(|s| s.point == *point && s.result == outcome.name);
            let mut own: Vec<&Statistics> = own.collect();
            own.sort_by(|a, b| a.torque_nm.total_cmp(&b.torque_nm));
            let points =
                |value: fn(&Statistics) -> f64| own.iter().map(move |s| (s.torque_nm, value(s)));
            let line = Curve::new(name, points(|s| s.nominal));
            let band = Curve {
                style: Style::Band(own.iter().map(|s| s.percentile_5).collect()),
                ..Curve::new("5 to 95 %", points(|s| s.percentile_95))
            };
            let is_drawn = own.iter().any(|s| s.percentile_5 < s.percentile_95);
            curves.push(line);
            curves.extend(is_drawn.then_some(band));
        }
        if curves.iter().any(|curve| !curve.points.is_empty()) {
            let title = format!("Band of {head} over torque");
            let labels = ["torque on gear 1 (N m)", &*axis_label(head, unit)];
            figures.push(Figure::lines(&title, labels, Height::FromZero(0.0), curves));
        }
    }
    let note = "Lines: the point itself; areas: between the 5th and the 95th percentile of its samples within the tolerances.";
    Section::new("Bands over torque", note, figures)
}

/// The bands of the study in `folder`, which is one of the pair `name`.
///
/// # Errors
/// A folder without a study that is finished, or with one of another pair or of one torque.
pub fn bands_of(folder: &Path, name: &str) -> Result<Section, Error> {
    #[derive(Deserialize)]
    struct Known {
        pair: String,
        torques_nm: Vec<f64>,
        statistics: Vec<Statistics>,
    }
    let path = folder.join("study.json");
    let wrong = |what: String| format!("--study = {}: {what}", folder.display());
    let text = output::read_text(&path).map_err(wrong)?;
    let known: Known =
        serde_json::from_str(&text).map_err(|e| wrong(format!("study.json: {e}")))?;
    if known.pair != name {
        return Err(wrong(format!(
            "a study of {}; name one of {name}",
            shown(&known.pair)
        ))
        .into());
    }
    if known.torques_nm.len() < 2 || known.statistics.is_empty() {
        let torques: Vec<f64> = known.torques_nm.into_iter().map(rounded).collect();
        return Err(wrong(format!("no band over the torques {torques:?}; solve the study to its end with two --torques-nm or more")).into());
    }
    Ok(bands(&known.statistics))
}
