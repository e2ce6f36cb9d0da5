//! What a study prints, and the same as an HTML page with charts.

use std::collections::BTreeMap;
use std::path::Path;

use gearmesh::words::{count, fixed, shown};
use serde::Serialize;

use super::judgement::{Best, Nearest, Violations};
use super::setup::Setup;
use super::variation::Variation;
use crate::bands::{bands, is_headed, label};
use crate::case::torque_in_words;
use crate::columns::{Listing, columns, table};
use crate::error::Result;
use crate::output;
use crate::page::{Curve, Figure, Height, Map, Page, Section, Style, charts};
use crate::statistics::{Sample, Statistics, ascending};

const CORRELATIONS: &str = "
The first correlation is near zero for a field that acts alike in both directions; the second one, of how far the field
is from its value as drawn, shows it. What fields do together (slopes of both gears that cancel) shows in neither.
";

/// Points in the table of the best ones.
const BEST: usize = 10;

/// What is known of a study before it is solved.
pub struct Known {
    pub pair: String,
    pub identity: String,
    /// What is to be known of the results, one sentence each; empty where there is nothing.
    pub notes: Vec<&'static str>,
}

/// What study.json holds, and with the setup and all samples what is shown.
#[derive(Serialize)]
pub struct Summary<'a> {
    #[serde(skip)]
    pub setup: &'a Setup,
    #[serde(skip)]
    pub done: Vec<Sample>,
    pub pair: &'a str,
    pub identity: &'a str,
    pub seed: u64,
    pub distribution: &'static str,
    pub varied: Vec<&'a Variation>,
    /// What is varied, one by one, in the order of the correlations.
    pub fields: Vec<&'a str>,
    pub torques_nm: &'a [f64],
    pub samples: usize,
    pub refused: usize,
    /// By the measure that was chosen, of the points that meet all requirements.
    pub best: Option<Best>,
    /// Where no point meets them.
    pub nearest: Option<Nearest>,
    /// Whether the points that the optimizer tried gathered in one place; None without it.
    pub search_ended: Option<bool>,
    /// Of the pair as drawn at each torque, then of the best point.
    pub statistics: Vec<Statistics>,
    /// Of the same points.
    pub violations: Vec<Violations>,
    pub notes: &'a [&'static str],
}

impl<'a> Summary<'a> {
    /// Of the samples that are `done`, without what follows from them.
    pub fn new(
        setup: &'a Setup,
        known: &'a Known,
        done: Vec<Sample>,
        samples: usize,
    ) -> Summary<'a> {
        Summary {
            setup,
            pair: &known.pair,
            identity: &known.identity,
            seed: setup.seed,
            distribution: "even",
            varied: setup.plan.all().collect(),
            fields: setup
                .plan
                .fields
                .iter()
                .map(|(field, _)| &**field)
                .collect(),
            torques_nm: &setup.torques,
            samples,
            refused: done.iter().filter(|s| s.outcome.is_err()).count(),
            done,
            best: None,
            nearest: None,
            search_ended: None,
            statistics: Vec::new(),
            violations: Vec::new(),
            notes: &known.notes,
        }
    }
}

impl Summary<'_> {
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        output::write_whole(path, text.as_bytes())
    }

    pub fn text(&self) -> String {
        let plan = &self.setup.plan;
        let points = match plan.points() {
            0 => String::new(),
            points if plan.is_optimized() => format!("{} tried, ", count(points, "point")),
            points => format!("{} of a grid, ", count(points, "point")),
        };
        let mut rows = Listing::default();
        for v in plan.all() {
            let how = v.points.map(|points| format!("{points} points"));
            let how = how.unwrap_or(if v.optimized { "optimized" } else { "even" }.into());
            rows.row(v.label(), format!("{} to {}, {how}", v.low, v.high));
        }
        let samples = match (self.samples, plan.points()) {
            (0, 1..) => String::new(),
            (samples, 0) => count(samples, "sample") + ", ",
            (samples, _) => count(samples, "sample") + " each, ",
        };
        let mut text = format!(
            "{}: {points}{samples}{} refused, seed {}\n\n{rows}\n",
            shown(self.pair),
            self.refused,
            self.seed
        );
        if let Some(best) = &self.best {
            text += &self.best_points(best);
        }
        if let Some(nearest) = &self.nearest {
            text += &self.nearest_point(nearest);
        }
        if !self.violations.is_empty() {
            let violations = columns! { |v: &&Violations|
                "", ["requirement", "", None] => v.requirement.clone();
                "", ["point", "", None] => match v.point { 0 => "as drawn", _ => "best" };
                "", ["samples", "", None] => v.samples;
                "", ["violate it", "", None] => v.violated;
            };
            text += &format!("{}\n", table(&violations, &self.violations));
        }
        let spread = columns! { |s: &&Statistics|
            "", ["result", "", None] => s.result.clone();
            "", ["torque", "N m", None] => s.torque_nm;
            "", ["point", "", None] => match s.point { 0 => "as drawn", _ => "best" };
            "", ["without tolerances", "", 3] => s.nominal;
            "", ["mean", "", 3] => s.mean;
            "", ["5 %", "", 3] => s.percentile_5;
            "", ["median", "", 3] => s.median;
            "", ["95 %", "", 3] => s.percentile_95;
            "", ["largest", "", 3] => s.largest;
        };
        let shown = if self.samples > 0 { spread.len() } else { 4 };
        text += &table(&spread[..shown], &self.statistics);
        if self.samples > 0 {
            text += &self.correlations();
        }
        let mut refusals = (self.done.iter()).filter_map(|s| Some((s, s.outcome.as_ref().err()?)));
        if let Some((Sample { point, number, .. }, error)) = refusals.next() {
            let point = match point {
                0 => String::new(),
                point => format!("point {point}, "),
            };
            text += &format!("\nfirst that was refused: {point}sample {number}: {error}\n");
        }
        let notes = self.notes.iter().map(|note| format!("\nnote: {note}\n"));
        text + &notes.collect::<String>()
    }

    /// The best points, and whether others may be better.
    fn best_points(&self, best: &Best) -> String {
        let plan = &self.setup.plan;
        let as_drawn = best.as_drawn.map_or("refused".into(), |v| fixed(v, 4));
        let mut columns = columns! { |(point, value): &(usize, f64)|
            "", ["point", "", None] => *point;
            "", ["measure", "", 4] => *value;
        };
        for (k, axis) in plan.axes.iter().enumerate() {
            columns.extend(columns! { |(point, _): &(usize, f64)|
                "", [axis.label(), "", None] => plan.at(*point)[k];
            });
        }
        let ranking = self.setup.ranking(&self.done);
        let mut text = format!(
            "best by {}; as drawn: {as_drawn}\n\n{}",
            best.measure,
            table(&columns, ranking.into_iter().take(BEST))
        );
        if let Some(drawn) = self.setup.drawn_below(&self.done, best.value) {
            let more = match plan.is_optimized() {
                true => "give more --points, or other ranges",
                false => "give other ranges, or more points in them",
            };
            text += &format!(
                "\nnote: no point tried is better than the drawing ({} as drawn, {} at point {}), and best.json holds that point, not \
                 the drawing; {more}\n",
                fixed(drawn, 4),
                fixed(best.value, 4),
                best.point
            );
        }
        let axes = plan.axes.iter().zip(plan.at(best.point));
        let ends = axes.filter(|(axis, value)| *value == axis.low || *value == axis.high);
        let ends: Vec<String> = ends.map(|(axis, _)| axis.label()).collect();
        if !ends.is_empty() {
            text += &format!(
                "\nnote: the best point is at an end of {}; a wider range may hold a better one\n",
                ends.join(" and ")
            );
        }
        if self.search_ended == Some(false) {
            text += "\nnote: the optimizer had not settled when it had tried as many points as --points allows; the same command \
                     with more of them goes on\n";
        }
        text + "\n"
    }

    /// The point that comes nearest to the requirements, where none meets them.
    fn nearest_point(&self, Nearest { point, violates }: &Nearest) -> String {
        let plan = &self.setup.plan;
        let rows = plan.axes.iter().zip(plan.at(*point));
        let mut fields = Listing::default();
        rows.for_each(|(axis, value)| fields.row(axis.label(), value.to_string()));
        format!(
            "no point meets all requirements; point {point} comes nearest and violates {violates}:\n\n{fields}\n"
        )
    }

    /// Those of the last statistics, at their first torque, with the fields that are drawn.
    fn correlations(&self) -> String {
        let all = &self.statistics;
        let point = all.last().map_or(0, |s| s.point);
        let statistics = all.iter().filter(|s| s.point == point);
        let statistics: Vec<&Statistics> = statistics.take(self.setup.outcomes.len()).collect();
        let over_fields =
            self.correlation_table("correlation with", &statistics, |s| &s.correlation);
        let head = "of the distance from drawn";
        let of_distance = self.correlation_table(head, &statistics, |s| &s.correlation_of_distance);
        format!("\n{over_fields}\n{of_distance}{CORRELATIONS}")
    }

    /// A row for each field that is drawn; of each of the `statistics` a column of `values`.
    fn correlation_table(
        &self,
        head: &str,
        statistics: &[&Statistics],
        values: fn(&Statistics) -> &[f64],
    ) -> String {
        let fields = &self.setup.plan.fields;
        let mut all = columns! { |v: &&Variation| "", [head, "", None] => v.field.clone(); };
        for (s, outcome) in statistics.iter().zip(&self.setup.outcomes) {
            // What has no head stays out.
            all.extend(columns! { |v: &&Variation|
                "", [&outcome.head, "", 2] => fields.iter().zip(values(s)).find(|(f, _)| f.0 == v.field).map(|(_, c)| *c);
            });
        }
        table(&all, &self.setup.plan.drawn)
    }

    pub fn page(&self, text: &str, origin: String) -> Page {
        let note = match self.samples {
            0 => "",
            _ => {
                "Drawn fields are drawn evenly from their interval; 5 % and 95 %: a twentieth of the samples lies below, above."
            }
        };
        let mut sections = vec![Section::new("In numbers", note, vec![]).with_text(text.into())];
        let measure = &self.setup.measure.words;
        if self.search_ended.is_some() {
            let note = format!("Measure: {measure}. Each dot is a point that the optimizer tried.");
            sections.push(Section::new("Points tried", note, self.tried()));
        } else if !self.setup.plan.axes.is_empty() {
            let met = match self.setup.requirements[..] {
                [] => "",
                _ => " that meet all requirements",
            };
            let note = format!(
                "Measure: {measure}. A curve has the best of all other fields, of the points{met}."
            );
            sections.push(Section::new("Grid", note, self.grid()));
        }
        if self.torques_nm.len() > 1 {
            sections.push(bands(&self.statistics));
        }
        if self.samples > 0 {
            let note = "Share of the samples up to a value; a vertical line is the point itself, or the limit of a requirement.";
            let heading = "Cumulative distribution";
            sections.push(Section::new(heading, note, self.distributions()));
        }
        Page {
            title: format!("Study: {}", self.pair),
            origin,
            sections,
        }
    }

    fn grid(&self) -> Vec<Figure> {
        let plan = &self.setup.plan;
        let name = self.setup.measured();
        let ranking = self.setup.ranking(&self.done);
        let mut figures = Vec::new();
        for (k, axis) in plan.axes.iter().enumerate() {
            let points = axis.nodes().into_iter().enumerate().map(|(i, x)| {
                let best = ranking
                    .iter()
                    .find(|(point, _)| plan.indices(*point)[k] == i);
                (x, best.map_or(f64::NAN, |best| best.1))
            });
            figures.extend(charts! {
                format!("Measure over {}", axis.label()), [&axis.label(), name], Height::FromZero(0.0)
                    => vec![Curve::new("best", points)];
            });
        }
        if let [x, y] = &plan.axes[..] {
            let points = 1..=plan.points();
            let map = Map::on_nodes(
                [&x.nodes(), &y.nodes()],
                points.map(|p| {
                    let own = ranking.iter().find(|(point, _)| *point == p);
                    own.map_or(f64::NAN, |own| own.1)
                }),
                0.0,
            );
            figures.extend(charts! {
                "Measure over both; blue: refused or violates a requirement", [&x.label(), &y.label(), name] => map;
            });
        }
        figures
    }

    /// The points that the optimizer tried, in their order and over each axis.
    fn tried(&self) -> Vec<Figure> {
        let Setup { plan, measure, .. } = self.setup;
        let name = self.setup.measured();
        let ranking = self.setup.ranking(&self.done);
        let meeting: BTreeMap<usize, f64> = ranking.into_iter().collect();
        let points: Vec<usize> = (1..=plan.points()).collect();
        let (met, violating): (Vec<usize>, Vec<usize>) =
            points.iter().partition(|point| meeting.contains_key(point));
        let dots = |x: &dyn Fn(usize) -> f64| {
            let all = [("tried", &met), ("violates a requirement", &violating)].into_iter();
            let all = all.filter(|(_, points)| !points.is_empty());
            let curves = all.map(|(label, points)| {
                let points = points.iter().map(|&point| {
                    let value = measure.of(&self.done, point).unwrap_or(f64::NAN);
                    (x(point), value)
                });
                Curve {
                    style: Style::Dots,
                    ..Curve::new(label, points)
                }
            });
            curves.collect::<Vec<_>>()
        };
        let mut least = f64::NAN;
        let best = points.iter().map(|point| {
            least = least.min(meeting.get(point).copied().unwrap_or(f64::NAN));
            (*point as f64, least)
        });
        let mut curves = dots(&|point| point as f64);
        curves.push(Curve::new("best so far", best));
        let mut figures = charts! {
            "Measure of the points in their order", ["point", name], Height::FromZero(0.0) => curves;
        };
        for (k, axis) in plan.axes.iter().enumerate() {
            figures.extend(charts! {
                format!("Measure of the points over {}", axis.label()), [&axis.label(), name], Height::FromZero(0.0)
                    => dots(&|point| plan.at(point)[k]);
            });
        }
        figures
    }

    fn distributions(&self) -> Vec<Figure> {
        let mut figures = Vec::new();
        let point = self.best.as_ref().map_or(0, |best| best.point);
        let samples = self.done.iter().filter(|s| s.point == point);
        let (itself, samples): (Vec<&Sample>, Vec<&Sample>) = samples.partition(|s| s.number == 0);
        for (k, outcome) in self.setup.outcomes.iter().enumerate().filter(is_headed) {
            let mut curves = Vec::new();
            for (t, torque) in self.torques_nm.iter().enumerate() {
                let values: Vec<f64> = samples.iter().filter_map(|s| s.result(t, k)).collect();
                let sorted = ascending(&values);
                // What does not vary is in the table.
                if sorted.first() == sorted.last() {
                    continue;
                }
                let percent = 100.0 / sorted.len() as f64;
                let points = sorted.iter().enumerate();
                let points = points.map(|(i, v)| (*v, percent * (i as f64 + 0.5)));
                curves.push(Curve::new(torque_in_words(*torque), points));
                let itself = itself.iter().filter_map(|s| s.result(t, k));
                let line = itself.flat_map(|v| [(v, 0.0), (v, 100.0)]);
                curves.push(Curve::new("point itself", line));
            }
            if !curves.is_empty() {
                let limits = self.setup.requirements.iter().filter(|r| r.result == k);
                curves.extend(limits.map(|r| {
                    let ends = [0.0, 100.0].map(|share| (r.limit(), share));
                    Curve::new(format!("limit {}", r.limit()), ends)
                }));
                figures.extend(charts! {
                    format!("Distribution of {}", outcome.head), [&label(outcome), "share of the samples (%)"], Height::FromZero(0.0)
                        => curves;
                });
            }
        }
        figures
    }
}
