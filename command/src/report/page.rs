//! The HTML around the pictures.

use std::fmt::Write;

use super::picture;

pub struct Page {
    title: String,
    body: String,
    /// Heading of the section that is being written, for the names of its pictures.
    heading: String,
    figures: Vec<Figure>,
}

/// A picture of the page as a file of its own.
pub struct Figure {
    /// File name without a folder: the section's heading in small letters and a number from 1.
    pub file: String,
    pub svg: String,
}

/// Text with the characters that HTML reserves replaced.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

impl Page {
    pub fn new(title: &str) -> Page {
        Page {
            title: title.into(),
            body: String::new(),
            heading: title.into(),
            figures: Vec::new(),
        }
    }

    /// Adds a heading and a paragraph that says what follows.
    pub fn section(&mut self, heading: &str, note: &str) {
        self.heading = heading.into();
        let _ = writeln!(
            self.body,
            "<h2>{}</h2>\n<p class=\"note\">{}</p>",
            escape(heading),
            escape(note)
        );
    }

    pub fn preformatted(&mut self, text: &str) {
        let _ = writeln!(self.body, "<pre>{}</pre>", escape(text));
    }

    pub fn pictures(&mut self, svgs: &[String]) {
        let name: String = self.heading.to_lowercase().replace(' ', "-");
        self.figures
            .extend(svgs.iter().enumerate().map(|(i, svg)| Figure {
                file: format!("{name}-{}.svg", i + 1),
                svg: picture::document(svg),
            }));
        let _ = writeln!(self.body, "<div class=\"row\">{}</div>", svgs.join("\n"));
    }

    /// Adds a table; `rows` begin with that of the heads.
    pub fn table(&mut self, rows: &[Vec<String>]) {
        let mut text = String::new();
        for (i, row) in rows.iter().enumerate() {
            let tag = if i == 0 { "th" } else { "td" };
            let cells = row
                .iter()
                .map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
            let _ = writeln!(text, "<tr>{}</tr>", cells.collect::<String>());
        }
        let _ = writeln!(self.body, "<div class=\"wide\"><table>{text}</table></div>");
    }

    pub fn figures(&self) -> &[Figure] {
        &self.figures
    }

    pub fn finish(self) -> String {
        format!(
            include_str!("page.html"),
            title = escape(&self.title),
            pictures = picture::STYLE,
            body = self.body
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_cannot_break_out_of_the_page() {
        let mut page = Page::new("<script>");
        page.section("a & b", "\"c\"");
        page.table(&[vec!["<i>".into()], vec!["1 < 2".into()]]);
        let html = page.finish();
        assert!(!html.contains("<script>") && !html.contains("<i>"));
        assert!(html.contains("a &amp; b") && html.contains("1 &lt; 2"));
    }

    #[test]
    fn every_picture_is_a_file_named_after_its_section() {
        let mut page = Page::new("Pair");
        page.section("Load share", "");
        page.pictures(&["<svg>1</svg>".into(), "<svg>2</svg>".into()]);
        let files: Vec<&str> = page.figures().iter().map(|f| f.file.as_str()).collect();
        assert_eq!(files, ["load-share-1.svg", "load-share-2.svg"]);
        assert!(page.figures()[1].svg.ends_with("2</svg>"));
    }
}
