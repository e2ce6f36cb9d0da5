//! What many samples say about one result.

use serde::{Deserialize, Serialize};

use super::samples::Sample;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Of the grid; 0: the pair as drawn.
    pub point: usize,
    pub torque_nm: f64,
    pub result: String,
    /// At the point itself.
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
    /// Of result `k`, called `result`, at torque `t` (`torque_nm`), of the `samples` that were solved (at least one); `drawn`
    /// is their point itself.
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
            let field = |k: usize| -> Vec<f64> {
                let fields = samples.iter().map(|sample| sample.fields[k]);
                fields.map(|field| change(field, drawn.fields[k])).collect()
            };
            let fields = 0..drawn.fields.len();
            fields.map(|k| correlation(&field(k), &values)).collect()
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
    let deviations = |values: &[f64]| -> Vec<f64> {
        let mean = mean(values);
        values.iter().map(|value| value - mean).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [a, b] = [a, b].map(deviations);
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    if scale > 0.0 {
        product(&a, &b) / scale
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(fields: &[f64], value: f64) -> Sample {
        Sample {
            point: 0,
            number: 0,
            fields: fields.to_vec(),
            outcome: Ok(vec![vec![value]]),
        }
    }

    /// Of samples with these fields and values, as drawn at `drawn` with the value 40.
    fn statistics<const N: usize>(drawn: [f64; N], samples: Vec<([f64; N], f64)>) -> Statistics {
        let samples = samples.iter().map(|(fields, value)| sample(fields, *value));
        let samples: Vec<Sample> = samples.collect();
        let samples: Vec<&Sample> = samples.iter().collect();
        Statistics::new("x", 0, (0, 100.0), &sample(&drawn, 40.0), &samples)
    }

    #[test]
    fn percentiles_and_correlations_of_a_line() {
        let values = (0..=100).map(f64::from);
        let found = statistics([0.0; 3], values.map(|v| ([2.0 * v, -v, 5.0], v)).collect());
        assert_eq!(
            (found.least, found.median, found.largest),
            (0.0, 50.0, 100.0)
        );
        assert_eq!((found.percentile_5, found.percentile_95), (5.0, 95.0));
        assert_eq!(found.nominal, 40.0);
        assert!((found.correlation[0] - 1.0).abs() < 1e-12);
        assert!((found.correlation[1] + 1.0).abs() < 1e-12);
        assert_eq!(found.correlation[2], 0.0);
    }

    #[test]
    fn a_cause_that_acts_alike_in_both_directions_shows_in_its_distance_from_the_drawing() {
        let values = (-50..=50).map(f64::from);
        let samples = values.map(|v| ([v, 7.0 + 0.1 * v], v * v)).collect();
        let found = statistics([0.0, 7.0], samples);
        for k in 0..2 {
            assert!(found.correlation[k].abs() < 1e-12);
            assert!(found.correlation_of_distance[k] > 0.9);
        }
    }
}
