//! The report: Markdown with its plots beside it.

use gearmesh::storage::write_whole;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Anything that goes wrong.
pub type Error = Box<dyn std::error::Error + Send + Sync>;

/// A Markdown text and the folder it goes to.
pub struct Document {
    text: String,
    folder: PathBuf,
}

impl Document {
    /// Begins `folder`/speed-accuracy.md, with plots in `folder`/img.
    pub fn new(folder: &Path, title: &str) -> Result<Self, Error> {
        std::fs::create_dir_all(folder.join("img"))?;
        Ok(Document {
            text: format!("# {title}\n"),
            folder: folder.to_owned(),
        })
    }

    /// A section.
    pub fn section(&mut self, title: &str) {
        eprintln!("{title}");
        let _ = write!(self.text, "\n## {title}\n");
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = write!(self.text, "\n{text}\n");
    }

    /// A table; the first column is text, the others are numbers.
    pub fn table<const N: usize>(&mut self, head: [&str; N], rows: &[[String; N]]) {
        self.text.push('\n');
        let mut line = |cells: &[&str]| {
            let _ = writeln!(self.text, "| {} |", cells.join(" | "));
        };
        line(&head);
        let rule: Vec<&str> = (0..N)
            .map(|i| if i == 0 { "---" } else { "---:" })
            .collect();
        line(&rule);
        for row in rows {
            line(&row.each_ref().map(String::as_str));
        }
    }

    /// The plot `svg` as img/`name`.svg.
    pub fn plot(&mut self, name: &str, caption: &str, svg: &str) -> Result<(), Error> {
        let file = format!("img/{name}.svg");
        write_whole(&self.folder.join(&file), svg.as_bytes())?;
        let _ = write!(self.text, "\n![{caption}]({file})\n\n*{caption}*\n");
        Ok(())
    }

    /// Writes the text as far as it goes.
    pub fn save(&self) -> Result<PathBuf, Error> {
        let path = self.folder.join("speed-accuracy.md");
        write_whole(&path, self.text.as_bytes())?;
        Ok(path)
    }
}
