//! The page: sections of text, tables and figures, in HTML by `templates/page.html`.

use std::path::Path;

use askama::Template;

use super::figure::Figure;
use crate::Error;
use crate::output;

#[derive(Template, Default)]
#[template(path = "page.html")]
pub struct Page {
    pub title: String,
    pub sections: Vec<Section>,
}

#[derive(Default)]
pub struct Section {
    pub heading: String,
    pub note: String,
    pub text: String,
    /// Rows of cells, heads and units first.
    pub table: Vec<Vec<String>>,
    pub figures: Vec<Figure>,
}

impl Section {
    pub fn new(heading: &str, note: impl Into<String>, figures: Vec<Figure>) -> Section {
        Section {
            heading: heading.into(),
            note: note.into(),
            figures,
            ..Section::default()
        }
    }

    pub fn anchor(&self) -> String {
        slug(&self.heading)
    }

    pub fn with_text(self, text: String) -> Section {
        Section { text, ..self }
    }
}

/// Small letters and digits of `title` with hyphens between words: an anchor, the name of a file.
fn slug(title: &str) -> String {
    // A sign distinguishes two charts.
    let title = title.replace(" -", " minus ").to_lowercase();
    let words = title.split(|c: char| !c.is_alphanumeric());
    words
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join("-")
}

impl Page {
    /// Writes the page to `path`, and every figure as SVG and CSV into the folder `figures`.
    pub fn write(&self, path: &Path, figures: Option<&Path>) -> Result<(), Error> {
        if let Some(folder) = figures {
            for figure in self.sections.iter().flat_map(|section| &section.figures) {
                let file = |end: &str| folder.join(slug(&figure.title) + end);
                output::write_whole(&file(".svg"), figure.svg()?.as_bytes())?;
                output::write_whole(&file(".csv"), &figure.csv()?)?;
            }
        }
        Ok(output::write_whole(path, self.render()?.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_cannot_break_out_of_the_page() {
        let mut section = Section::new("a & b", "\"c\"", vec![]).with_text("<u>".into());
        section.table = [["<i>"], [""], ["1 < 2"]]
            .map(|row| row.map(Into::into).into())
            .into();
        let (title, sections) = ("<script>".into(), vec![section]);
        let html = Page { title, sections }.render().unwrap();
        for tag in ["<script>", "<i>", "<u>"] {
            assert!(!html.contains(tag), "{html}");
        }
        assert!(
            html.contains("a &#38; b") && html.contains("1 &#60; 2"),
            "{html}"
        );
        assert_eq!(slug("STE at 100 N m, 0.5 mrad"), "ste-at-100-n-m-0-5-mrad");
        assert_ne!(slug("at -3.00 mrad"), slug("at +3.00 mrad"));
    }
}
