//! Pieces of the page: tables, plots, numbers.

use crate::plot::{Line, Plot};
use std::path::Path;

/// Result of an experiment.
pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// A table; the first column is text, the others are numbers.
pub fn table<const N: usize>(head: [&str; N], rows: &[[String; N]]) -> String {
    let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | "));
    let rule: Vec<&str> = (0..N)
        .map(|i| if i == 0 { "---" } else { "---:" })
        .collect();
    let body: String = rows
        .iter()
        .map(|row| line(&row.each_ref().map(String::as_str)))
        .collect();
    format!("{}{}{body}\n", line(&head), line(&rule))
}

/// Draws a plot into `folder` and returns the link to it.
pub fn plot(
    folder: &Path,
    name: &str,
    title: &str,
    axes: [&str; 2],
    lines: Vec<Line>,
) -> Outcome<String> {
    let [x, y] = axes;
    Plot {
        title,
        x,
        y,
        logarithmic: false,
        lines,
    }
    .save(&folder.join(format!("{name}.svg")))?;
    Ok(link(name, title))
}

/// Link to a picture of the page.
pub fn link(name: &str, title: &str) -> String {
    format!("![{title}](finite-elements/{name}.svg)\n\n")
}

/// One line of a plot.
pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Line {
    Line {
        name: name.into(),
        points,
    }
}

/// Relative difference of `a` to `b`, with sign, in %.
pub fn percent(a: f64, b: f64) -> String {
    format!("{:+.2}", 100.0 * (a / b - 1.0))
}

/// Whether a bar is met, in a word.
pub fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "**missed**" }
}

/// Largest of some numbers by magnitude, with its sign.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m })
}
