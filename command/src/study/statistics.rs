//! What many samples say about one result.

use serde::Serialize;

/// Spread of one result over the samples that were solved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistics {
    /// Name of the result, with its unit.
    pub result: &'static str,
    /// The pair as drawn.
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
    /// Of `values`, one per sample (at least one), with the varied `fields` of each sample; `nominal` and `drawn` are value and
    /// fields of the pair as drawn.
    pub fn new(
        result: &'static str,
        (nominal, drawn): (f64, &[f64]),
        values: &[f64],
        fields: &[&[f64]],
    ) -> Statistics {
        let sorted = ascending(values);
        let share = |share: f64| {
            let at = share * (sorted.len() - 1) as f64;
            let below = at as usize;
            let above = (below + 1).min(sorted.len() - 1);
            sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
        };
        let with = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let fields = |k: usize| fields.iter().map(move |f| of(f[k], drawn[k]));
            let correlations = (0..drawn.len()).map(|k| fields(k).collect::<Vec<_>>());
            correlations
                .map(|field| correlation(&field, values))
                .collect()
        };
        Statistics {
            result,
            nominal,
            mean: mean(values),
            least: share(0.0),
            percentile_5: share(0.05),
            median: share(0.5),
            percentile_95: share(0.95),
            largest: share(1.0),
            correlation: with(&|field, _| field),
            correlation_of_distance: with(&|field, drawn| (field - drawn).abs()),
        }
    }
}

/// `values` in order.
pub fn ascending(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Pearson's coefficient.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sum = |of: fn(f64, f64) -> f64| -> f64 {
        a.iter()
            .zip(b)
            .map(|(x, y)| of(x - mean_a, y - mean_b))
            .sum()
    };
    let scale = (sum(|x, _| x * x) * sum(|_, y| y * y)).sqrt();
    if scale > 0.0 {
        sum(|x, y| x * y) / scale
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_and_correlations_of_a_line() {
        let values: Vec<f64> = (0..=100).map(f64::from).collect();
        let fields: Vec<[f64; 3]> = values.iter().map(|v| [2.0 * v, -v, 5.0]).collect();
        let fields: Vec<&[f64]> = fields.iter().map(|f| &f[..]).collect();
        let found = Statistics::new("x", (40.0, &[0.0; 3]), &values, &fields);
        assert_eq!(
            (found.least, found.median, found.largest),
            (0.0, 50.0, 100.0)
        );
        assert_eq!((found.percentile_5, found.percentile_95), (5.0, 95.0));
        assert!((found.correlation[0] - 1.0).abs() < 1e-12);
        assert!((found.correlation[1] + 1.0).abs() < 1e-12);
        assert_eq!(found.correlation[2], 0.0);
    }

    #[test]
    fn a_cause_that_acts_alike_in_both_directions_shows_in_its_distance_from_the_drawing() {
        let fields: Vec<[f64; 2]> = (-50..=50)
            .map(|v| [f64::from(v), 7.0 + 0.1 * f64::from(v)])
            .collect();
        let values: Vec<f64> = fields.iter().map(|f| f[0] * f[0]).collect();
        let fields: Vec<&[f64]> = fields.iter().map(|f| &f[..]).collect();
        let found = Statistics::new("x", (0.0, &[0.0, 7.0]), &values, &fields);
        for k in 0..2 {
            assert!(found.correlation[k].abs() < 1e-12);
            assert!(found.correlation_of_distance[k] > 0.9);
        }
    }
}
