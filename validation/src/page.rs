//! Pages of docs/ with generated parts: tables and figures.

use crate::plot::Plot;
use crate::{Result, in_repository};
use gearmesh_preprocessor::storage::write_whole;
use std::path::{Path, PathBuf};

/// Rows of a table beyond which it goes to a CSV file beside the page.
const MOST_ROWS: usize = 24;

/// A page whose parts lie between `<!-- begin: NAME -->` and `<!-- end: NAME -->`.
pub struct Page {
    name: String,
    folder: PathBuf,
    text: String,
}

/// A row of cells, from whatever can be displayed.
#[macro_export]
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($cell.to_string()),*] };
}

impl Page {
    /// The page `name` of `folder`; one that is missing there begins as the one in docs/.
    pub fn open(name: &str, folder: &Path) -> Result<Self> {
        let file = format!("{name}.md");
        let known = Some(folder.join(&file)).filter(|path| path.exists());
        let text = std::fs::read_to_string(known.unwrap_or_else(|| in_repository("docs").join(&file)))?;
        Ok(Self { name: name.into(), folder: folder.into(), text })
    }

    /// Replaces the part `name` and saves the page.
    pub fn part(&mut self, name: &str, content: &str) -> Result<()> {
        let [begin, end] = ["begin", "end"].map(|what| format!("<!-- {what}: {name} -->"));
        let missing = || format!("{}.md has no part {name}", self.name);
        let (before, rest) = self.text.split_once(&begin).ok_or_else(missing)?;
        let (_, after) = rest.split_once(&end).ok_or_else(missing)?;
        self.text = format!("{before}{begin}\n{}\n{end}{after}", content.trim_end());
        std::fs::create_dir_all(&self.folder)?;
        Ok(write_whole(&self.folder.join(format!("{}.md", self.name)), self.text.as_bytes())?)
    }

    /// Replaces the part `name` by a table, whose first column is text; a long one becomes a CSV file and a link to it.
    pub fn table(&mut self, name: &str, head: &[&str], rows: &[Vec<String>]) -> Result<()> {
        if rows.len() > MOST_ROWS {
            let line = |cells: &[String]| cells.iter().map(|c| format!("\"{c}\"")).collect::<Vec<_>>().join(",");
            let head: Vec<String> = head.iter().map(|cell| cell.to_string()).collect();
            let text: String =
                [line(&head)].into_iter().chain(rows.iter().map(|r| line(r))).map(|l| l + "\n").collect();
            let file = self.file(&format!("{name}.csv"))?;
            write_whole(&self.folder.join(&file), text.as_bytes())?;
            return self.part(name, &format!("[{} rows]({file}): {}", rows.len(), head.join(", ")));
        }
        let rule: Vec<_> = (0..head.len()).map(|i| if i == 0 { "---" } else { "---:" }).collect();
        let lines = [head.join(" | "), rule.join(" | ")].into_iter().chain(rows.iter().map(|row| row.join(" | ")));
        self.part(name, &lines.map(|line| format!("| {line} |\n")).collect::<String>())
    }

    /// Draws a figure of the page; the page itself links to it.
    pub fn plot(&mut self, name: &str, plot: &Plot) -> Result<()> {
        let file = self.file(&format!("{name}.svg"))?;
        Ok(write_whole(&self.folder.join(file), plot.svg()?.as_bytes())?)
    }

    /// `name` in the folder of the page's files, which is made: img, or the folder of the page's name.
    pub fn file(&self, name: &str) -> Result<String> {
        let own = ["stability", "finite-elements"].contains(&self.name.as_str());
        let folder = if own { &self.name } else { "img" };
        std::fs::create_dir_all(self.folder.join(folder))?;
        Ok(format!("{folder}/{name}"))
    }

    /// Writes a figure drawn elsewhere.
    pub fn picture(&mut self, name: &str, svg: &str) -> Result<()> {
        let file = self.file(&format!("{name}.svg"))?;
        Ok(write_whole(&self.folder.join(file), svg.as_bytes())?)
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
    if met { "met" } else { "**missed**" }
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
