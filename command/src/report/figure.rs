//! Charts as data: one description gives the picture, the CSV file, and a comparison of two variants.

use super::draw;
use crate::Error;

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

impl Map {
    /// `values` row by row in cells around the nodes of both axes; the scale reaches to the largest, at least to `top`.
    pub fn on_nodes(
        [columns, rows]: [&[f64]; 2],
        values: impl IntoIterator<Item = f64>,
        top: f64,
    ) -> Map {
        let axes = [columns, rows].map(cells);
        let [x, y] = &axes;
        let pairs = y.iter().flat_map(|y| x.iter().map(move |x| [*x, *y]));
        let patch = |(ends, value): ([[f64; 2]; 2], f64)| Patch {
            node: ends.map(|[low, high]| 0.5 * (low + high)),
            ends,
            value: value.is_finite().then_some(value),
        };
        let patches: Vec<Patch> = pairs.zip(values).map(patch).collect();
        let ends = axes.map(|cells| {
            let ends = || cells.iter().flatten().copied();
            let [low, high] = [f64::INFINITY, f64::NEG_INFINITY];
            [ends().fold(low, f64::min), ends().fold(high, f64::max)]
        });
        let top = patches.iter().filter_map(|p| p.value).fold(top, f64::max);
        Map { ends, patches, top }
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
    let cell = |(i, node): (usize, &f64)| {
        let before = 0.5 * step(i.saturating_sub(1));
        let next = nodes.get(i + 1);
        let high = next.map_or(node + before, |next| next - 0.5 * step(i));
        [node - before, high]
    };
    nodes.iter().enumerate().map(cell).collect()
}

/// Charts of curves, `"title", [label of x, of y], height => curves;` for each.
macro_rules! charts {
    ($($title:expr, $labels:expr, $height:expr => $curves:expr;)*) => {
        vec![$($crate::report::figure::Figure::lines($title, $labels, $height, $curves)),*]
    };
}
pub(crate) use charts;

impl Figure {
    pub fn lines(
        title: impl Into<String>,
        labels: [&str; 2],
        height: Height,
        curves: Vec<Curve>,
    ) -> Figure {
        Figure::new(title.into(), &labels, Plot::Lines(height, curves))
    }

    pub fn map(title: impl Into<String>, labels: [&str; 3], map: Map) -> Figure {
        Figure::new(title.into(), &labels, Plot::Map(map))
    }

    fn new(title: String, labels: &[&str], plot: Plot) -> Figure {
        let labels = labels.iter().map(|label| label.to_string()).collect();
        Figure {
            title,
            labels,
            plot,
        }
    }

    pub fn svg(&self) -> askama::Result<String> {
        let drawn = match &self.plot {
            Plot::Lines(height, curves) => draw::lines(&self.labels, *height, curves),
            Plot::Map(map) => draw::map(&self.labels, map),
        };
        drawn.map_err(|error| askama::Error::custom(error.to_string()))
    }

    /// Every point of the curves, or the node of every patch with its value.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        match &self.plot {
            Plot::Lines(_, curves) => {
                writer.write_record(["curve", &self.labels[0], &self.labels[1]])?;
                for Curve {
                    label,
                    points,
                    style,
                } in curves
                {
                    let name = match style {
                        Style::Dashed(variant) => &format!("{label} ({variant})"),
                        _ => label,
                    };
                    for (x, y) in points {
                        writer.serialize((name, x, y))?;
                    }
                    if let Style::Band(low) = style {
                        for ((x, _), y) in points.iter().zip(low) {
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
        let csv = Figure::map("", ["x", "y", "v"], map).csv().unwrap();
        assert!(csv.starts_with(b"x,y,v\n1.0,10.0,0.0\n2.0,10.0,1.0\n"));
    }

    #[test]
    fn a_comparison_is_in_the_same_chart_on_the_same_scale() {
        let lines = |y: f64| {
            let curve = Curve::new("STE", [(0.0, y), (1.0, f64::NAN)]);
            Figure::lines("", ["x", "y"], Height::FromZero(0.0), vec![curve])
        };
        let mut figure = lines(1.0);
        assert!(figure.compare(lines(2.0), "other").is_none());
        let csv = figure.csv().unwrap();
        assert_eq!(csv, b"curve,x,y\nSTE,0.0,1.0\nSTE (other),0.0,2.0\n");
        let map = |value| Figure::map("p", [""; 3], Map::on_nodes([&[0.0]; 2], [value], 0.0));
        let mut figure = map(1.0);
        let other = figure.compare(map(3.0), "other").unwrap();
        assert_eq!(other.title, "p (other)");
        for Figure { plot, .. } in [figure, other] {
            assert!(matches!(plot, Plot::Map(Map { top: 3.0, .. })));
        }
    }
}
