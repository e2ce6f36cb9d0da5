//! An HTML page of sections with text, tables and charts, by `templates/page.html`. Charts are data: one description gives the
//! picture, the CSV file, and a comparison of two variants.

mod draw;

use std::io::{self, Read};
use std::path::Path;

use askama::Template;
use gearmesh::words::hex;
use gearmesh_preprocessor::storage;
use sha2::{Digest, Sha256};
use time::OffsetDateTime;

use crate::error::Result;
use crate::output;

#[derive(Template, Default)]
#[template(path = "page.html")]
pub struct Page {
    pub title: String,
    /// What was computed, by which version, and when.
    pub origin: String,
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
    let words: Vec<&str> = words.filter(|w| !w.is_empty()).collect();
    words.join("-")
}

/// SHA-256 of the file at `path`.
fn digest(path: &Path) -> io::Result<[u8; 32]> {
    let mut file = storage::open(path)?;
    let (mut hash, mut bytes) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(hash.finalize().into()),
            count => hash.update(&bytes[..count]),
        }
    }
}

/// The version of gearmesh, today's date (UTC), and the file that a page is about with its SHA-256.
pub fn origin(file: &Path) -> Result<String> {
    let digest = digest(file).map_err(|error| output::unreadable(file, &error))?;
    let hash = hex(&digest[..8]);
    let date = OffsetDateTime::now_utc().date();
    let (version, file) = (env!("CARGO_PKG_VERSION"), file.display());
    Ok(format!(
        "gearmesh {version}, {date}. {file}, SHA-256 {hash}..."
    ))
}

impl Page {
    /// Writes the page to `path`, and every figure as SVG and CSV into the folder `figures`.
    pub fn write(&self, path: &Path, figures: Option<&Path>) -> Result<()> {
        if let Some(folder) = figures {
            for figure in self.sections.iter().flat_map(|section| &section.figures) {
                // No `with_extension`: a title may have a dot.
                let name = slug(&figure.title);
                let [svg, csv] = ["svg", "csv"].map(|end| folder.join(format!("{name}.{end}")));
                output::write_whole(&svg, figure.svg()?.as_bytes())?;
                output::write_whole(&csv, &figure.csv()?)?;
            }
        }
        output::write_whole(path, self.render()?.as_bytes())
    }
}

#[derive(Debug, Clone)]
pub struct Figure {
    pub title: String,
    /// What stands at both axes and, of a map, at its scale, with the units.
    pub labels: Vec<String>,
    pub plot: Plot,
}

#[derive(Debug, Clone)]
pub enum Plot {
    Lines(Height, Vec<Curve>),
    Map(Map),
}

/// The vertical axis; what is smaller than the height given, in its unit, is no more than rounding.
#[derive(Debug, Clone, Copy)]
pub enum Height {
    /// As high as the curves, at least this.
    Curves(f64),
    /// From zero, at least to this.
    FromZero(f64),
    /// A drawing: both axes to the same scale.
    ToScale,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Style {
    Solid,
    /// Of the other variant, which has this name.
    Dashed(String),
    /// The area down to these heights.
    Band(Vec<f64>),
    /// Every point by itself.
    Dots,
}

impl Curve {
    /// Points that are NaN are left out.
    pub fn new(label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
        let points = points.into_iter();
        Curve {
            label: label.into(),
            points: points.filter(|(_, y)| y.is_finite()).collect(),
            style: Style::Solid,
        }
    }
}

#[derive(Debug, Clone)]
pub struct Map {
    pub ends: [[f64; 2]; 2],
    /// Names of the low and the high end of the second axis; empty: none.
    pub end_names: [&'static str; 2],
    pub patches: Vec<Patch>,
    /// Top of the scale, which begins at 0.
    pub top: f64,
}

#[derive(Debug, Clone)]
pub struct Patch {
    /// Where it is in the CSV file.
    pub node: [f64; 2],
    pub ends: [[f64; 2]; 2],
    /// None: contact at a tip edge, drawn apart from the scale, over everything.
    pub value: Option<f64>,
}

impl Patch {
    /// Around its node; a value that is NaN is none.
    pub fn new(ends: [[f64; 2]; 2], value: Option<f64>) -> Patch {
        Patch {
            node: ends.map(|[a, b]| 0.5 * (a + b)),
            ends,
            value: value.filter(|value| value.is_finite()),
        }
    }
}

/// Ends of a range that holds nothing.
const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Map {
    /// `values` row by row in cells around the nodes of both axes; the scale reaches to the largest, at least to `top`.
    pub fn on_nodes(
        [columns, rows]: [&[f64]; 2],
        values: impl IntoIterator<Item = f64>,
        top: f64,
    ) -> Map {
        let axes = [columns, rows].map(cells);
        let [x, y] = &axes;
        let cells = y.iter().flat_map(|y| x.iter().map(move |x| [*x, *y]));
        let patches: Vec<Patch> = cells
            .zip(values)
            .map(|(ends, value)| Patch::new(ends, Some(value)))
            .collect();
        let ends = axes.map(|cells| {
            cells
                .into_iter()
                .flatten()
                .fold(NOTHING, |[low, high], end| [low.min(end), high.max(end)])
        });
        let top = patches.iter().filter_map(|p| p.value).fold(top, f64::max);
        Map {
            ends,
            end_names: [""; 2],
            patches,
            top,
        }
    }

    /// The same cut to `low..high` along its first axis.
    pub fn cut(mut self, low: f64, high: f64) -> Map {
        self.ends[0] = [low, high];
        for patch in &mut self.patches {
            patch.ends[0] = patch.ends[0].map(|x| x.clamp(low, high));
        }
        self
    }
}

/// Ends of cells that meet halfway between `nodes`, the outermost as wide as their neighbours.
fn cells(nodes: &[f64]) -> Vec<[f64; 2]> {
    let step = |i: usize| nodes.get(i + 1).map_or(1.0, |next| next - nodes[i]);
    nodes
        .iter()
        .enumerate()
        .map(|(i, node)| {
            let before = 0.5 * step(i.saturating_sub(1));
            let next = nodes.get(i + 1);
            let high = next.map_or(node + before, |next| next - 0.5 * step(i));
            [node - before, high]
        })
        .collect()
}

/// Charts: `"title", [label of x, of y], height => curves;` or `"title", [label of x, of y, of the scale] => map;` for each.
macro_rules! charts {
    (@ $height:expr, $curves:expr) => { $crate::page::Plot::Lines($height, $curves) };
    (@ $map:expr) => { $crate::page::Plot::Map($map) };
    ($($title:expr, $labels:expr $(, $height:expr)? => $drawn:expr;)*) => {
        vec![$($crate::page::Figure::new($title, &$labels, charts!(@ $($height,)? $drawn))),*]
    };
}
pub(crate) use charts;

impl Figure {
    pub fn new(title: impl Into<String>, labels: &[&str], plot: Plot) -> Figure {
        Figure {
            title: title.into(),
            labels: labels.iter().map(|label| label.to_string()).collect(),
            plot,
        }
    }

    /// Every point of the curves, or the node of every patch with its value.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        match &self.plot {
            Plot::Lines(_, curves) => {
                writer.write_record(["curve", &self.labels[0], &self.labels[1]])?;
                for curve in curves {
                    let label = &curve.label;
                    let name = match &curve.style {
                        Style::Dashed(variant) => &format!("{label} ({variant})"),
                        _ => label,
                    };
                    for (x, y) in &curve.points {
                        writer.serialize((name, x, y))?;
                    }
                    if let Style::Band(low) = &curve.style {
                        for ((x, _), y) in curve.points.iter().zip(low) {
                            writer.serialize((format!("{label}, lower end"), x, y))?;
                        }
                    }
                }
            }
            Plot::Map(map) => {
                writer.write_record(&self.labels)?;
                for patch in &map.patches {
                    writer.serialize((patch.node, patch.value))?;
                }
            }
        }
        Ok(writer.into_inner()?)
    }

    /// Adds the curves of `other`, of the variant `name`, dashed; a map is returned on the same scale.
    pub fn compare(&mut self, mut other: Figure, name: &str) -> Option<Figure> {
        match (&mut self.plot, &mut other.plot) {
            (Plot::Lines(_, own), Plot::Lines(_, more)) => {
                for mut curve in more.drain(..) {
                    curve.style = Style::Dashed(name.into());
                    own.push(curve);
                }
                None
            }
            (Plot::Map(own), Plot::Map(map)) => {
                map.top = own.top.max(map.top);
                own.top = map.top;
                other.title += &format!(" ({name})");
                Some(other)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_map_and_carry_their_values_row_by_row() {
        let nodes = [&[1.0, 2.0, 3.0][..], &[10.0, 20.0]];
        let map = Map::on_nodes(nodes, (0..6).map(f64::from), 0.0);
        assert_eq!((map.ends, map.top), ([[0.5, 3.5], [5.0, 25.0]], 5.0));
        assert_eq!(map.patches[4].ends, [[1.5, 2.5], [15.0, 25.0]]);
        assert_eq!(map.patches[4].value, Some(4.0));
        let map = map.cut(1.0, 3.0);
        assert_eq!(map.patches[0].ends[0], [1.0, 1.5]);
        let figure = Figure::new("", &["x", "y", "v"], Plot::Map(map));
        let csv = figure.csv().unwrap();
        assert!(csv.starts_with(b"x,y,v\n1.0,10.0,0.0\n2.0,10.0,1.0\n"));
    }

    #[test]
    fn a_comparison_is_in_the_same_chart_on_the_same_scale() {
        let lines = |y: f64| {
            let curve = Curve::new("STE", [(0.0, y), (1.0, f64::NAN)]);
            charts! { "", ["x", "y"], Height::FromZero(0.0) => vec![curve]; }.remove(0)
        };
        let mut figure = lines(1.0);
        assert!(figure.compare(lines(2.0), "other").is_none());
        let csv = figure.csv().unwrap();
        assert_eq!(csv, b"curve,x,y\nSTE,0.0,1.0\nSTE (other),0.0,2.0\n");
        let map = |value| {
            let map = Map::on_nodes([&[0.0]; 2], [value], 0.0);
            Figure::new("p", &[""; 3], Plot::Map(map))
        };
        let mut figure = map(1.0);
        let other = figure.compare(map(3.0), "other").unwrap();
        assert_eq!(other.title, "p (other)");
        for Figure { plot, .. } in [figure, other] {
            assert!(matches!(plot, Plot::Map(Map { top: 3.0, .. })));
        }
    }

    #[test]
    fn a_name_cannot_break_out_of_the_page() {
        let mut section = Section::new("a & b", "\"c\"", vec![]).with_text("<u>".into());
        section.table = [["<i>"], [""], ["1 < 2"]]
            .map(|row| row.map(Into::into).into())
            .into();
        let (title, sections) = ("<script>".into(), vec![section]);
        let origin = "<b>".into();
        let page = Page {
            title,
            origin,
            sections,
        };
        let html = page.render().unwrap();
        for tag in ["<script>", "<b>", "<i>", "<u>"] {
            assert!(!html.contains(tag), "{html}");
        }
        let escaped = ["a &#38; b", "1 &#60; 2"];
        assert!(escaped.iter().all(|text| html.contains(text)), "{html}");
        assert_eq!(slug("STE at 100 N m, 0.5 mrad"), "ste-at-100-n-m-0-5-mrad");
        assert_ne!(slug("at -3.00 mrad"), slug("at +3.00 mrad"));
    }
}
