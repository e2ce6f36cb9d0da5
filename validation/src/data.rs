//! Tables in docs/data, and the small statistics that fill them.

use crate::Result;
use gearmesh_preprocessor::storage::write_whole;
use std::path::PathBuf;

/// A row of cells, from whatever can be displayed.
#[macro_export]
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($cell.to_string()),*] };
}

/// A folder of CSV files.
pub struct Data(pub PathBuf);

impl Data {
    /// Writes NAME.csv, whole or not at all.
    pub fn table(&self, name: &str, head: &[&str], rows: &[Vec<String>]) -> Result<()> {
        let mut text = csv::Writer::from_writer(vec![]);
        text.write_record(head)?;
        for row in rows {
            text.write_record(row)?;
        }
        std::fs::create_dir_all(&self.0)?;
        Ok(write_whole(&self.0.join(format!("{name}.csv")), &text.into_inner()?)?)
    }
}

/// `x` with so many digits after the point.
pub fn fixed(x: f64, digits: usize) -> String {
    format!("{x:.digits$}")
}

/// Relative difference of `a` to `b`, with sign, in %.
pub fn percent(a: f64, b: f64) -> String {
    format!("{:+.2}", 100.0 * (a / b - 1.0))
}

/// Whether a bar is met, in a word.
pub fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "missed" }
}

/// Largest of some numbers by magnitude, with its sign.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m })
}

/// Root of the mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0), |(sum, n), x| (sum + x * x, n + 1));
    (sum / f64::from(n)).sqrt()
}

/// Least and largest of some numbers.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// Mean of some numbers.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// `n` numbers from `low` to `high`, evenly spaced.
pub fn even([low, high]: [f64; 2], n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
}
