//! The plots of all pages, as SVG.

use crate::Result;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

/// Okabe and Ito's colours, told apart by eyes that see no red or no green, too.
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    Line,
    Marks,
    /// Marks joined by a line.
    Both,
    /// From the lower edge of the plot upwards.
    Bars,
}

/// Points that belong together.
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

impl Series {
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, style: Style::Line }
    }
}

/// What to draw.
pub struct Plot<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    /// Which axes are logarithmic; of these, points that are not above zero are left out.
    pub logarithmic: [bool; 2],
    pub series: Vec<Series>,
}

impl Plot<'_> {
    /// The figure.
    pub fn svg(&self) -> Result<String> {
        let shown = |&(x, y): &(f64, f64)| {
            [x, y].into_iter().zip(self.logarithmic).all(|(v, log)| v.is_finite() && (!log || v > 0.0))
        };
        let all = || self.series.iter().flat_map(|s| &s.points).filter(|p| shown(p));
        let range = |pick: fn(&(f64, f64)) -> f64, log: bool| {
            let [low, high] = crate::page::range(all().map(pick));
            let margin = 0.04 * (high - low).max(1e-12);
            if log { low / 1.4..high * 1.4 } else { low - margin..high + margin }
        };
        let [x, y] = [range(|p| p.0, self.logarithmic[0]), range(|p| p.1, self.logarithmic[1])];
        let floor = y.start;
        match self.logarithmic {
            [false, false] => self.draw(x, y, floor, shown),
            [false, true] => self.draw(x, y.log_scale(), floor, shown),
            [true, false] => self.draw(x.log_scale(), y, floor, shown),
            [true, true] => self.draw(x.log_scale(), y.log_scale(), floor, shown),
        }
    }

    fn draw<X, Y>(&self, x: X, y: Y, floor: f64, shown: impl Fn(&(f64, f64)) -> bool) -> Result<String>
    where
        X: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut svg = String::new();
        let whole = SVGBackend::with_string(&mut svg, (820, 420)).into_drawing_area();
        whole.fill(&WHITE)?;
        let (area, legend) = whole.split_horizontally(620);
        let mut chart = ChartBuilder::on(&area)
            .caption(self.title, ("sans-serif", 18))
            .margin(10)
            .x_label_area_size(45)
            .y_label_area_size(72)
            .build_cartesian_2d(x, y)?;
        let label = |v: &f64, log: bool| if log { decade(*v) } else { format!("{}", (v * 1e6).round() / 1e6) };
        chart
            .configure_mesh()
            .light_line_style(BLACK.mix(0.05))
            .x_desc(self.x)
            .y_desc(self.y)
            .x_label_formatter(&|v| label(v, self.logarithmic[0]))
            .y_label_formatter(&|v| label(v, self.logarithmic[1]))
            .draw()?;
        for (i, series) in self.series.iter().enumerate() {
            let color = PALETTE[i % PALETTE.len()];
            let points = || series.points.iter().copied().filter(|p| shown(p));
            match series.style {
                Style::Line => chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?,
                Style::Marks => chart.draw_series(points().map(|p| Circle::new(p, 4, color.filled())))?,
                Style::Both => chart.draw_series(LineSeries::new(points(), color.stroke_width(2)).point_size(4))?,
                Style::Bars => {
                    // Beside those of the other series.
                    let aside = 0.35 * (i as f64 - 0.5);
                    chart.draw_series(
                        points().map(|(x, y)| {
                            PathElement::new([(x + aside, floor), (x + aside, y)], color.stroke_width(2))
                        }),
                    )?
                }
            };
            let y = 40 + 20 * i as i32;
            legend.draw(&Rectangle::new([(4, y), (16, y + 4)], color.filled()))?;
            legend.draw(&Text::new(series.name.as_str(), (22, y - 5), ("sans-serif", 12)))?;
        }
        whole.present()?;
        drop((chart, area, legend, whole));
        Ok(svg)
    }
}

/// The label of a logarithmic grid line: of 1, 2 and 5 in every decade, since those of all nine run into one another.
fn decade(v: f64) -> String {
    let leading = (v / 10f64.powf(v.log10().floor())).round();
    if ![1.0, 2.0, 5.0, 10.0].contains(&leading) {
        String::new()
    } else if (1e-2..1e5).contains(&v) {
        format!("{}", (v * 1e4).round() / 1e4)
    } else {
        format!("{v:.0e}")
    }
}
