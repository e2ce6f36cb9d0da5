//! Line charts as inline SVG.

use plotters::prelude::*;

use crate::Error;

/// Width and height of a chart, pixels of the SVG.
const SIZE: (u32, u32) = (680, 360);

/// Of these, for the legend beside the plot.
const LEGEND_WIDTH: u32 = 96;

/// Colours of the curves, in order; told apart by eyes that see no red or no green, too.
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// One curve of a chart.
pub struct Curve {
    /// Its name in the legend.
    pub label: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// What stands at the axes.
pub struct Axes<'a> {
    /// Horizontal axis, with its unit.
    pub x: &'a str,
    /// Vertical axis, with its unit.
    pub y: &'a str,
    /// Whether the vertical axis starts at zero.
    pub from_zero: bool,
}

/// Lowest and highest of `values`, widened by 5 % (or to something, where all are alike).
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let margin = if high > low {
        0.05 * (high - low)
    } else {
        0.05 * high.abs().max(1.0)
    };
    low - margin..high + margin
}

/// Draws `curves` into an SVG element.
pub fn line_chart(axes: &Axes, curves: &[Curve]) -> Result<String, Error> {
    let points = || curves.iter().flat_map(|c| c.points.iter());
    let x_low = points().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let x_high = points().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    let mut y_range = range(points().map(|p| p.1));
    if axes.from_zero {
        y_range.start = 0.0;
    }
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let (plot, legend) = area.split_horizontally(SIZE.0 - LEGEND_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(58)
            .build_cartesian_2d(x_low..x_high, y_range)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(axes.x)
            .y_desc(axes.y)
            .label_style(("sans-serif", 13))
            .draw()?;
        for (i, curve) in curves.iter().enumerate() {
            let style = PALETTE[i % PALETTE.len()].stroke_width(2);
            chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
            let y = 22 + 20 * i as i32;
            legend.draw(&PathElement::new([(4, y), (24, y)], style))?;
            let text = ("sans-serif", 13).into_font().color(&BLACK);
            legend.draw(&Text::new(curve.label.as_str(), (30, y - 6), text))?;
        }
        area.present()?;
    }
    Ok(svg)
}
