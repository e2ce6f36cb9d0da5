//! Results of a sample, and what many samples say about one of them.

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::columns::{Column, columns};

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
        let values: Vec<f64> = samples
            .iter()
            .map(|sample| sample.result(t, k).unwrap_or(f64::NAN))
            .collect();
        let sorted = ascending(&values);
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
            nominal: drawn.result(t, k).unwrap_or(f64::NAN),
            mean: mean(&values),
            least: quantile(&sorted, 0.0),
            percentile_5: quantile(&sorted, 0.05),
            median: quantile(&sorted, 0.5),
            percentile_95: quantile(&sorted, 0.95),
            largest: quantile(&sorted, 1.0),
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

/// The value below which this `share` of the `sorted` ones lies, between neighbours in proportion.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let below = at as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let means = [mean(a), mean(b)];
    let [mut aa, mut ab, mut bb] = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - means[0], b - means[1]);
        aa += a * a;
        ab += a * b;
        bb += b * b;
    }
    let scale = f64::sqrt(aa * bb);
    if scale > 0.0 { ab / scale } else { 0.0 }
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
}
