//! By which measure and requirements the points of a study are judged.

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use gearmesh::words::shown;
use serde::Serialize;

use crate::error::Result;
use crate::limits;
use crate::statistics::{Outcome, Sample};

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
        let mut all = Vec::new();
        for sample in self.counting(done, point) {
            let mut sum = 0.0;
            for (t, weight) in self.weights.iter().enumerate() {
                sum += weight * sample.result(t, self.result)?;
            }
            all.push(sum);
        }
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
