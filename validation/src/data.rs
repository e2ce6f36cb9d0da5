//! Tables in docs/data, and the small statistics that fill them.

use crate::Result;
use gearmesh_preprocessor::storage::write_whole;
use std::path::PathBuf;

/// A folder of CSV files.
pub struct Data(pub PathBuf);

impl Data {
    /// Writes NAME.csv, whole or not at all. A `|` separates the cells of the heading and of each row.
    pub fn table(&self, name: &str, head: &str, rows: &[String]) -> Result<()> {
        let mut text = csv::Writer::from_writer(vec![]);
        for row in [head].into_iter().chain(rows.iter().map(String::as_str)) {
            text.write_record(row.split('|').map(str::trim))?;
        }
        std::fs::create_dir_all(&self.0)?;
        let path = self.0.join(format!("{name}.csv"));
        Ok(write_whole(&path, &text.into_inner()?)?)
    }
}

/// `x` relative to `reference`, in %, to be printed with its sign.
pub fn percent(x: f64, reference: f64) -> f64 {
    100.0 * (x / reference - 1.0)
}

/// Largest of some numbers by magnitude, with its sign.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |m: f64, v: f64| if v.abs() > m.abs() { v } else { m };
    values.into_iter().fold(0.0, larger)
}

/// Root of the mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|x| x * x)).sqrt()
}

/// Mean of some numbers.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let add = |(sum, n), x| (sum + x, n + 1);
    let (sum, n) = values.into_iter().fold((0.0, 0), add);
    sum / f64::from(n)
}

/// Least and largest of some numbers.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    let widen = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    values.into_iter().fold(start, widen)
}

/// `n` numbers from `low` to `high`, evenly spaced.
pub fn even([low, high]: [f64; 2], n: usize) -> Vec<f64> {
    let at = |i: usize| low + (high - low) * i as f64 / (n - 1) as f64;
    (0..n).map(at).collect()
}

/// What so many bisections leave between the values inside, where `holds`, and outside.
pub fn last_that_holds(
    [mut inside, mut outside]: [f64; 2],
    bisections: usize,
    mut holds: impl FnMut(f64) -> Result<bool>,
) -> Result<[f64; 2]> {
    for _ in 0..bisections {
        let middle = 0.5 * (inside + outside);
        *(if holds(middle)? {
            &mut inside
        } else {
            &mut outside
        }) = middle;
    }
    Ok([inside, outside])
}
