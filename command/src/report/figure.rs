//! Charts as data: one description gives the picture, the CSV file, and a comparison of two variants.

use super::draw;
use crate::Error;

/// A chart with its title, which also names its files.
#[derive(Debug, Clone)]
pub struct Figure {
    pub title: String,
    pub plot: Plot,
}

#[derive(Debug, Clone)]
pub enum Plot {
    Lines(Lines),
    Map(Map),
}

/// Curves over one quantity.
#[derive(Debug, Clone)]
pub struct Lines {
    /// What stands at the axes, with the unit.
    pub labels: [String; 2],
    pub height: Height,
    pub curves: Vec<Curve>,
}

/// The vertical axis; what is smaller than the height given, in its unit, is no more than rounding.
#[derive(Debug, Clone, Copy)]
pub enum Height {
    /// As high as the curves, at least this.
    Curves(f64),
    /// From zero, at least to this.
    FromZero(f64),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    pub label: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Style {
    Solid,
    /// Of the other variant.
    Dashed,
    /// The area down to these heights.
    Band(Vec<f64>),
}

impl Curve {
    /// Points that are no numbers are left out.
    pub fn new(label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
        let points = points.into_iter();
        Curve {
            label: label.into(),
            points: points.filter(|(_, y)| y.is_finite()).collect(),
            style: Style::Solid,
        }
    }
}

/// Values over two quantities in shades.
#[derive(Debug, Clone)]
pub struct Map {
    /// What stands at the axes and at the scale, with its unit.
    pub labels: [String; 3],
    /// Ends of the axes.
    pub ends: [[f64; 2]; 2],
    pub patches: Vec<Patch>,
    /// Top of the scale, which begins at 0.
    pub top: f64,
}

/// A piece of a map with one value.
#[derive(Debug, Clone)]
pub struct Patch {
    /// Corners in order, in the units of the axes.
    pub corners: [(f64, f64); 4],
    /// None: contact at a tip edge, drawn apart from the scale, over everything.
    pub value: Option<f64>,
}

impl Patch {
    pub fn middle(&self) -> (f64, f64) {
        let [a, _, b, _] = self.corners;
        (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1))
    }
}

impl Map {
    /// `values` in cells around the even nodes of both axes, all of a row after each other; the scale reaches to
    /// the largest, at least to `top`.
    pub fn on_nodes(
        labels: [&str; 3],
        [columns, rows]: [&[f64]; 2],
        values: impl IntoIterator<Item = f64>,
        top: f64,
    ) -> Map {
        let [columns, rows] = [columns, rows].map(cells_around);
        let cells = rows
            .windows(2)
            .flat_map(|y| columns.windows(2).map(move |x| (x, y)));
        let patch = |((x, y), value): ((&[f64], &[f64]), f64)| Patch {
            corners: [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])],
            value: value.is_finite().then_some(value),
        };
        let patches: Vec<Patch> = cells.zip(values).map(patch).collect();
        Map {
            labels: labels.map(Into::into),
            ends: [&columns, &rows].map(|ends| {
                let [a, b] = [ends[0], ends[ends.len() - 1]];
                [a.min(b), a.max(b)]
            }),
            top: patches.iter().filter_map(|p| p.value).fold(top, f64::max),
            patches,
        }
    }
}

/// Ends of cells halfway between `nodes`, the outermost as wide as their neighbours.
fn cells_around(nodes: &[f64]) -> Vec<f64> {
    let n = nodes.len();
    let step = |i: usize| nodes.get(i + 1).map_or(1.0, |next| next - nodes[i]);
    let last = step(n.saturating_sub(2));
    let starts = (0..n).map(|i| nodes[i] - 0.5 * step(i.saturating_sub(1)));
    starts.chain([nodes[n - 1] + 0.5 * last]).collect()
}

impl Figure {
    pub fn lines(title: &str, labels: [&str; 2], height: Height, curves: Vec<Curve>) -> Figure {
        let labels = labels.map(Into::into);
        Figure {
            title: title.into(),
            plot: Plot::Lines(Lines {
                labels,
                height,
                curves,
            }),
        }
    }

    pub fn map(title: impl Into<String>, map: Map) -> Figure {
        Figure {
            title: title.into(),
            plot: Plot::Map(map),
        }
    }

    /// The picture.
    pub fn svg(&self) -> askama::Result<String> {
        let drawn = match &self.plot {
            Plot::Lines(lines) => draw::lines(lines),
            Plot::Map(map) => draw::map(map),
        };
        drawn.map_err(|error| askama::Error::custom(error.to_string()))
    }

    /// Every point of the curves, or the middle of every patch with its value.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        match &self.plot {
            Plot::Lines(Lines { labels, curves, .. }) => {
                writer.write_record(["curve", &labels[0], &labels[1]])?;
                for curve in curves {
                    let points = curve.points.iter();
                    let mut all: Vec<_> =
                        points.map(|(x, y)| (curve.label.clone(), x, y)).collect();
                    if let Style::Band(low) = &curve.style {
                        let low = curve.points.iter().zip(low);
                        all.extend(
                            low.map(|((x, _), y)| (curve.label.clone() + ", lower end", x, y)),
                        );
                    }
                    for point in all {
                        writer.serialize(point)?;
                    }
                }
            }
            Plot::Map(map) => {
                writer.write_record(&map.labels)?;
                for patch in &map.patches {
                    writer.serialize((patch.middle(), patch.value))?;
                }
            }
        }
        Ok(writer.into_inner()?)
    }

    /// Adds what `other` shows, of the variant `name`: curves dashed in the same chart; of a map it stays apart, on
    /// the same scale, and is returned.
    pub fn compare(&mut self, other: Figure, name: &str) -> Option<Figure> {
        match (&mut self.plot, other.plot) {
            (Plot::Lines(own), Plot::Lines(more)) => {
                own.curves
                    .extend(more.curves.into_iter().map(|curve| Curve {
                        label: format!("{} ({name})", curve.label),
                        style: Style::Dashed,
                        ..curve
                    }));
                None
            }
            (Plot::Map(own), Plot::Map(mut map)) => {
                map.top = own.top.max(map.top);
                own.top = map.top;
                Some(Figure::map(format!("{} ({name})", other.title), map))
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
        let map = Map::on_nodes(["x", "y", "v"], nodes, (0..6).map(f64::from), 0.0);
        assert_eq!((map.ends, map.top), ([[0.5, 3.5], [5.0, 25.0]], 5.0));
        assert_eq!(map.patches.len(), 6);
        assert_eq!(map.patches[4].value, Some(4.0));
        assert_eq!(map.patches[4].middle(), (2.0, 20.0));
        let csv = String::from_utf8(Figure::map("", map).csv().unwrap()).unwrap();
        assert!(
            csv.starts_with("x,y,v\n1.0,10.0,0.0\n2.0,10.0,1.0\n"),
            "{csv}"
        );
    }

    #[test]
    fn a_comparison_is_in_the_same_chart_on_the_same_scale() {
        let lines = |y: f64| {
            let curve = Curve::new("STE", [(0.0, y), (1.0, f64::NAN)]);
            Figure::lines("", ["x", "y"], Height::FromZero(0.0), vec![curve])
        };
        let mut figure = lines(1.0);
        assert!(figure.compare(lines(2.0), "other").is_none());
        let csv = String::from_utf8(figure.csv().unwrap()).unwrap();
        assert_eq!(csv, "curve,x,y\nSTE,0.0,1.0\nSTE (other),0.0,2.0\n");
        let map = |value| {
            Figure::map(
                "p",
                Map::on_nodes(["", "", ""], [&[0.0], &[0.0]], [value], 0.0),
            )
        };
        let mut figure = map(1.0);
        let other = figure.compare(map(3.0), "other").unwrap();
        let (Plot::Map(a), Plot::Map(b)) = (&figure.plot, &other.plot) else {
            panic!("{figure:?}");
        };
        assert_eq!(
            (a.top, b.top, other.title.as_str()),
            (3.0, 3.0, "p (other)")
        );
    }
}
