//! Results of a sample, what many samples say about one of them, and by which measure and requirements points are judged.

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use gearmesh::words::shown;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::columns::{Column, columns};
use crate::error::Result;
use crate::limits;

/// A result of a mesh cycle: in samples.csv; with a head also in correlations and charts.
pub type Outcome = Column<'static, Case>;

/// The results of a sample at a torque, the last two only with `root_stress`.
pub fn outcomes(root_stress: bool) -> Vec<Outcome> {
    let mut all = columns! { |c: &Case|
        "peak_to_peak_ste_loa_um", ["p-p STE", "um", None] => 1e6 * c.cycle.peak_to_peak_ste();
        "mean_ste_loa_um" => 1e6 * c.cycle.mean_ste();
        "harmonic_1_loa_um", ["1st harm.", "um", None] => c.cycle.harmonics()[0].map(|h| 1e6 * h.amplitude);
        "maximum_pressure_mpa", ["pressure", "MPa", None] => 1e-6 * c.cycle.max_pressure();
        "edge_line_load_n_per_mm" => c.cycle.edge_load().map_or(0.0, |edge| 1e-3 * edge.line_load);
        "face_load_factor", ["K_Hbeta", "", None] => c.face_load.face_load_factor();
        "root_stress_1_mpa", ["root 1", "MPa", None] => c.root_stress(0);
        "root_stress_2_mpa", ["root 2", "MPa", None] => c.root_stress(1);
    };
    all.truncate(if root_stress { 8 } else { 6 });
    all
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Of the grid, or tried by the optimizer, from 1 on; 0: the pair as drawn.
    pub point: usize,
    /// From 1 on; 0: the point itself.
    pub number: usize,
    pub fields: Vec<f64>,
    /// Those of [`outcomes`] at each torque, or why there are none.
    pub outcome: Result<Vec<Vec<f64>>, String>,
}

impl Sample {
    pub fn result(&self, t: usize, k: usize) -> Option<f64> {
        Some(self.outcome.as_ref().ok()?[t][k])
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// 0: the pair as drawn.
    pub point: usize,
    pub torque_nm: f64,
    pub result: String,
    pub nominal: f64,
    pub mean: f64,
    pub least: f64,
    /// A twentieth of the samples lies below.
    pub percentile_5: f64,
    pub median: f64,
    /// A twentieth of the samples lies above.
    pub percentile_95: f64,
    pub largest: f64,
    /// Correlation of each varied field with the result, in their order: -1 to 1; 0 where either is constant.
    pub correlation: Vec<f64>,
    /// The same of how far each field is from its value as drawn: what acts alike in both directions shows here alone.
    pub correlation_of_distance: Vec<f64>,
}

impl Statistics {
    /// Of result `k`, called `result`, at torque `t` over the solved `samples` (at least one) of the point `drawn`.
    pub fn new(
        result: &str,
        k: usize,
        (t, torque_nm): (usize, f64),
        drawn: &Sample,
        samples: &[&Sample],
    ) -> Statistics {
        let value = |sample: &Sample| sample.result(t, k).unwrap_or(f64::NAN);
        let values: Vec<f64> = samples.iter().map(|sample| value(sample)).collect();
        let sorted = ascending(&values);
        let share = |share: f64| {
            let at = share * (sorted.len() - 1) as f64;
            let below = at as usize;
            let above = (below + 1).min(sorted.len() - 1);
            sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
        };
        let correlations = |change: fn(f64, f64) -> f64| {
            drawn
                .fields
                .iter()
                .enumerate()
                .map(|(k, drawn)| {
                    let changes = samples.iter().map(|s| change(s.fields[k], *drawn));
                    correlation(&changes.collect::<Vec<_>>(), &values)
                })
                .collect()
        };
        Statistics {
            point: drawn.point,
            torque_nm,
            result: result.into(),
            nominal: value(drawn),
            mean: mean(&values),
            least: share(0.0),
            percentile_5: share(0.05),
            median: share(0.5),
            percentile_95: share(0.95),
            largest: share(1.0),
            correlation: correlations(|field, _| field),
            correlation_of_distance: correlations(|field, drawn| (field - drawn).abs()),
        }
    }
}

pub fn ascending(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [a, b] = [a, b].map(|values| -> Vec<f64> {
        let mean = mean(values);
        values.iter().map(|value| value - mean).collect()
    });
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    match scale > 0.0 {
        true => product(&a, &b) / scale,
        false => 0.0,
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Best point of a grid or of the optimizer")]
pub struct BestArgs {
    /// Result that shall be least, by its column in samples.csv, such as peak_to_peak_ste_loa_um or maximum_pressure_mpa
    #[arg(long, value_name = "RESULT", default_value = "harmonic_1_loa_um")]
    best: String,

    /// Weights of the torques in its mean, with commas between them, one for each torque [default: all alike]
    #[arg(long, value_name = "WEIGHTS", value_delimiter = ',', value_parser = limits::within(0.0..=1e6))]
    weights: Vec<f64>,

    /// Which of the samples of a point count: the point itself, the mean of all, or the worst [default: the worst]
    #[arg(long, value_enum, default_value_t = Judged::Worst, hide_default_value = true)]
    judged_by: Judged,

    /// A result and its limit, such as "maximum_pressure_mpa<1200" or "edge_line_load_n_per_mm<=0" (with quotes: shells read <
    /// as a file); repeatable. Samples that violate it are marked, and a point is the best one only if all its samples that count
    /// hold it at every torque
    #[arg(long, value_name = "RESULT<LIMIT", value_parser = Required::parse)]
    require: Vec<Required>,
}

/// `RESULT<LIMIT` of the command line, also with `<=`, `>` or `>=`.
#[derive(Debug, Clone, PartialEq)]
pub struct Required {
    name: String,
    /// Whether the result shall lie below the limit.
    is_most: bool,
    /// Whether it may be the limit.
    with_limit: bool,
    limit: f64,
}

impl Required {
    fn parse(text: &str) -> Result<Required, String> {
        Required::of(text).ok_or_else(|| {
            format!(
                "`{text}`: give RESULT<LIMIT, RESULT<=LIMIT, RESULT>LIMIT or RESULT>=LIMIT with a finite number, such as \
                 \"maximum_pressure_mpa<1200\""
            )
        })
    }

    fn of(text: &str) -> Option<Required> {
        let at = text.find(['<', '>'])?;
        let (name, rest) = text.split_at(at);
        let limit = rest[1..].strip_prefix('=');
        let name = name.trim();
        (!name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')).then_some(
            Required {
                name: name.into(),
                is_most: rest.starts_with('<'),
                with_limit: limit.is_some(),
                limit: limits::finite(limit.unwrap_or(&rest[1..])).ok()?,
            },
        )
    }
}

/// A limit of one of the results.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    pub result: usize,
    pub required: Required,
}

impl Requirement {
    pub fn words(&self) -> String {
        let Required {
            name,
            is_most,
            with_limit,
            limit,
        } = &self.required;
        let sign = if *is_most { "<" } else { ">" };
        let equal = if *with_limit { "=" } else { "" };
        format!("{name}{sign}{equal}{limit}")
    }

    pub fn limit(&self) -> f64 {
        self.required.limit
    }

    /// By how much `value` misses the limit, in parts of it, or in its unit where it is 0; None where it holds. What is no
    /// number holds nothing.
    fn missed_by(&self, value: f64) -> Option<f64> {
        let Required {
            is_most,
            with_limit,
            limit,
            ..
        } = self.required;
        let beyond = if is_most {
            value - limit
        } else {
            limit - value
        };
        let scale = if limit == 0.0 { 1.0 } else { limit.abs() };
        match beyond.is_nan() {
            true => Some(f64::INFINITY),
            false => (beyond > 0.0 || (beyond == 0.0 && !with_limit)).then_some(beyond / scale),
        }
    }

    /// By how much `sample` misses it at the torque where it does most; None where it holds at all, or was refused.
    pub fn missed(&self, sample: &Sample) -> Option<f64> {
        let torques = sample.outcome.as_ref().ok()?;
        let missed = torques
            .iter()
            .filter_map(|all| self.missed_by(all[self.result]));
        missed.reduce(f64::max)
    }
}

/// How many samples of a point violate a requirement.
#[derive(Debug, Serialize)]
pub struct Violations {
    /// 0: the pair as drawn.
    pub point: usize,
    pub requirement: String,
    /// Solved ones, the point itself included.
    pub samples: usize,
    pub violated: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Judged {
    Drawn,
    Mean,
    Worst,
}

#[derive(Debug)]
pub struct Measure {
    pub result: usize,
    weights: Vec<f64>,
    judged: Judged,
    pub words: String,
}

/// Which of `outcomes` has this `name`, as `option` gives it.
fn result_named(option: &str, name: &str, outcomes: &[Outcome]) -> Result<usize> {
    if let Some(result) = outcomes.iter().position(|o| o.name == name) {
        return Ok(result);
    }
    let names: Vec<&str> = outcomes.iter().map(|o| &*o.name).collect();
    let roots = match name.starts_with("root_stress") {
        true => " (root stress: with --root-stress)",
        false => "",
    };
    let (name, names) = (shown(name), names.join(", "));
    refuse!("{option} = {name}: no result of this study; give one of {names}{roots}");
}

impl BestArgs {
    pub fn requirements(&self, outcomes: &[Outcome]) -> Result<Vec<Requirement>> {
        self.require
            .iter()
            .map(|required| {
                Ok(Requirement {
                    result: result_named("--require", &required.name, outcomes)?,
                    required: required.clone(),
                })
            })
            .collect()
    }

    pub fn measure(&self, outcomes: &[Outcome], torques: &[f64]) -> Result<Measure> {
        let result = result_named("--best", &self.best, outcomes)?;
        let mut weights = self.weights.clone();
        if weights.is_empty() {
            weights.resize(torques.len(), 1.0);
        }
        let sum: f64 = weights.iter().sum();
        let [given, needed] = [weights.len(), torques.len()];
        if given != needed || sum == 0.0 {
            refuse!(
                "--weights: {given} for {needed} torques with the sum {sum}; give one for each torque, not all 0"
            );
        }
        let judged = match self.judged_by {
            Judged::Drawn => "of the point itself",
            Judged::Mean => "mean of the samples",
            Judged::Worst => "worst of the samples",
        };
        let over = match torques {
            [_] => "",
            _ => ", weighted over the torques",
        };
        Ok(Measure {
            result,
            weights: weights.iter().map(|weight| weight / sum).collect(),
            judged: self.judged_by,
            words: format!("{}, {judged}{over}", self.best),
        })
    }
}

impl Measure {
    /// The samples of `point` that count.
    pub fn counting<'s>(
        &self,
        done: &'s [Sample],
        point: usize,
    ) -> impl Iterator<Item = &'s Sample> {
        let is_drawn = self.judged == Judged::Drawn;
        let samples = done.iter().filter(move |s| s.point == point);
        samples.filter(move |s| s.number == 0 || !is_drawn)
    }

    /// That of `point`; None where a sample that counts was refused.
    pub fn of(&self, done: &[Sample], point: usize) -> Option<f64> {
        let samples = self.counting(done, point);
        let measure = |sample: &Sample| -> Option<f64> {
            let torques = self.weights.iter().enumerate();
            let results = torques.map(|(t, weight)| Some(weight * sample.result(t, self.result)?));
            results.sum()
        };
        let all: Vec<f64> = samples.map(measure).collect::<Option<_>>()?;
        match self.judged {
            Judged::Mean => Some(all.iter().sum::<f64>() / all.len() as f64),
            _ => all.into_iter().reduce(f64::max),
        }
    }
}

/// The point that misses the requirements by least, where none meets them all.
#[derive(Debug, Serialize)]
pub struct Nearest {
    pub point: usize,
    /// Requirements, in words.
    pub violates: String,
}

/// The point whose measure is least, of those that meet all requirements.
#[derive(Debug, Serialize)]
pub struct Best {
    pub point: usize,
    pub measure: String,
    pub value: f64,
    /// The same of the pair as drawn.
    pub as_drawn: Option<f64>,
    pub fields: BTreeMap<String, f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(number: usize, fields: &[f64], results: [f64; 2]) -> Sample {
        Sample {
            point: 3,
            number,
            fields: fields.into(),
            outcome: Ok(results.map(|result| vec![result]).into()),
        }
    }

    #[test]
    fn a_line_shows_in_the_correlation_and_a_cause_alike_in_both_directions_in_that_of_the_distance()
     {
        let at = |v: f64| sample(1, &[2.0 * v, -v, 5.0, 7.0 + 0.1 * v], [v, v * v]);
        let all: Vec<Sample> = (-50..=50).map(|v| at(f64::from(v))).collect();
        let all: Vec<&Sample> = all.iter().collect();
        let drawn = &sample(0, &[0.0, 0.0, 5.0, 7.0], [40.0; 2]);
        let [line, both] = [0, 1].map(|t| Statistics::new("x", 0, (t, 100.0), drawn, &all));
        let percentiles = [line.percentile_5, line.median, line.percentile_95];
        assert_eq!(
            (line.least, percentiles, line.largest),
            (-50.0, [-45.0, 0.0, 45.0], 50.0)
        );
        assert_eq!((line.nominal, line.correlation[2]), (40.0, 0.0));
        for (k, sign) in [(0, 1.0), (1, -1.0), (3, 1.0)] {
            assert!((line.correlation[k] - sign).abs() < 1e-12);
            assert!(both.correlation[k].abs() < 1e-12);
            assert!(both.correlation_of_distance[k] > 0.9);
        }
    }

    #[test]
    fn the_measure_is_weighted_over_torques_and_judges_the_sample_that_counts() {
        let results = [[1.0, 2.0], [5.0, 2.0], [3.0, 4.0]];
        let mut done = [0, 1, 2].map(|number| sample(number, &[], results[number]));
        let value = |done: &[Sample], judged| {
            let (weights, words) = (vec![0.25, 0.75], String::new());
            let measure = Measure {
                result: 0,
                weights,
                judged,
                words,
            };
            measure.of(done, 3)
        };
        assert_eq!(value(&done, Judged::Drawn), Some(1.75));
        assert_eq!(value(&done, Judged::Worst), Some(3.75));
        assert_eq!(value(&done, Judged::Mean), Some((1.75 + 2.75 + 3.75) / 3.0));
        done[2].outcome = Err("refused".into());
        assert_eq!(value(&done, Judged::Worst), None);
        assert_eq!(value(&done, Judged::Drawn), Some(1.75));
    }

    #[test]
    fn requirements_are_read_in_four_forms_and_hold_at_every_torque() {
        let requirement = |text: &str| Requirement {
            result: 0,
            required: Required::of(text).unwrap(),
        };
        let both = |results| sample(0, &[], results);
        for (text, holds, misses) in [
            ("p<1200", [1100.0, 1199.9], [1100.0, 1200.0]),
            ("p <= 1200", [1200.0, 3.0], [1200.1, 3.0]),
            ("p>-0.5", [0.0, 1.0], [0.0, -0.5]),
            ("p>=0", [0.0, 0.0], [0.0, -1e-9]),
        ] {
            let requirement = requirement(text);
            assert_eq!(requirement.words(), text.replace(' ', ""));
            assert_eq!(requirement.missed(&both(holds)), None, "{text}");
            assert!(requirement.missed(&both(misses)).is_some(), "{text}");
        }
        // The torque where it misses most counts, in parts of the limit.
        let missed = requirement("p<200").missed(&both([300.0, 250.0]));
        assert_eq!(missed, Some(0.5));
        assert!(
            requirement("p<200")
                .missed(&both([f64::NAN, 0.0]))
                .is_some()
        );
        for wrong in [
            "p", "<3", "p=3", "p<", "p<x", "p<<3", "p<nan", "p=<3", "p<3<4",
        ] {
            assert_eq!(Required::of(wrong), None, "{wrong}");
        }
    }
}
