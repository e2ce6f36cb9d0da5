//! The best point of a grid by a measure that the user chooses.

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::samples::{Outcome, Sample};
use super::variation::Plan;
use crate::Error;
use crate::limits;

/// What makes a point of the grid the best.
#[derive(Debug, Args)]
#[command(next_help_heading = "Best point of a grid")]
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
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Judged {
    Drawn,
    Mean,
    Worst,
}

pub struct Measure {
    result: usize,
    weights: Vec<f64>,
    judged: Judged,
    pub words: String,
}

impl BestArgs {
    /// # Errors
    /// A result that there is not; weights that do not fit `torques`.
    pub fn measure(
        &self,
        outcomes: &[Outcome<'static>],
        torques: &[f64],
    ) -> Result<Measure, Error> {
        let names: Vec<&str> = outcomes.iter().map(|o| &*o.name).collect();
        let Some(result) = names.iter().position(|name| *name == self.best) else {
            let (best, names) = (&self.best, names.join(", "));
            refuse!("--best = {best}: no result of this study; give one of {names}");
        };
        let mut weights = self.weights.clone();
        if weights.is_empty() {
            weights.resize(torques.len(), 1.0);
        }
        let sum: f64 = weights.iter().sum();
        if weights.len() != torques.len() || sum == 0.0 {
            refuse!(
                "--weights: {} for {} torques with the sum {sum}; give one for each torque, not all 0",
                weights.len(),
                torques.len()
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
    /// That of `point`; None where a sample that counts was refused.
    pub fn of(&self, done: &[Sample], point: usize) -> Option<f64> {
        let samples = done.iter().filter(|s| s.point == point);
        let samples = samples.filter(|s| s.number == 0 || self.judged != Judged::Drawn);
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

#[derive(Debug, Serialize)]
pub struct Best {
    pub point: usize,
    /// In words.
    pub measure: String,
    pub value: f64,
    /// The same of the pair as drawn.
    pub as_drawn: Option<f64>,
    pub fields: BTreeMap<String, f64>,
}

impl Best {
    /// The point of the grid whose `measure` is least; None where there is no grid.
    ///
    /// # Errors
    /// A grid of which no point could be solved.
    pub fn of(measure: &Measure, plan: &Plan, done: &[Sample]) -> Result<Option<Best>, Error> {
        if plan.grid.is_empty() {
            return Ok(None);
        }
        let values =
            (1..=plan.points()).filter_map(|point| Some((point, measure.of(done, point)?)));
        let least = values.min_by(|a, b| a.1.total_cmp(&b.1));
        let (point, value) =
            least.ok_or("no point of the grid could be solved; samples.csv says why")?;
        let fields = plan.fields.iter().map(|(field, _)| field.clone());
        Ok(Some(Best {
            point,
            measure: measure.words.clone(),
            value,
            as_drawn: measure.of(done, 0),
            fields: fields.zip(plan.values(point, 0, 0)).collect(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measure_is_weighted_over_torques_and_judges_the_sample_that_counts() {
        let sample = |number: usize, results: [f64; 2]| Sample {
            point: 3,
            number,
            fields: vec![],
            outcome: Ok(results.map(|result| vec![9.0, result]).into()),
        };
        let results = [[1.0, 2.0], [5.0, 2.0], [3.0, 4.0]];
        let mut done = [0, 1, 2].map(|number| sample(number, results[number]));
        let value = |done: &[Sample], judged| {
            let measure = Measure {
                result: 1,
                weights: vec![0.25, 0.75],
                judged,
                words: String::new(),
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
}
