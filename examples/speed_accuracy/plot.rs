//! Scatter plots and curves on logarithmic axes, as SVG.

use crate::document::Error;
use plotters::prelude::*;

const SIZE: (u32, u32) = (720, 440);
const LEGEND_WIDTH: u32 = 150;

/// Okabe and Ito's colours, told apart by eyes that see no red or no green, too.
const PALETTE: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// Points that belong together.
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// (x, y), both above zero.
    pub points: Vec<(f64, f64)>,
    /// Joined by a line.
    pub joined: bool,
}

/// A plot on two logarithmic axes. The points of `front` are joined by a dark line in their order.
pub fn log_log(
    x_label: &str,
    y_label: &str,
    series: &[Series],
    front: &[(f64, f64)],
) -> Result<String, Error> {
    let all = || series.iter().flat_map(|s| s.points.iter());
    let range = |f: fn(&(f64, f64)) -> f64| {
        let low = all().map(f).fold(f64::INFINITY, f64::min);
        let high = all().map(f).fold(0.0, f64::max);
        low / 1.4..high * 1.4
    };
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (plot, legend) = area.split_horizontally(SIZE.0 - LEGEND_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(x_label)
            .y_desc(y_label)
            .x_label_formatter(&|v| short(*v))
            .y_label_formatter(&|v| short(*v))
            .label_style(("sans-serif", 13))
            .draw()?;
        if !front.is_empty() {
            let style = BLACK.mix(0.55).stroke_width(2);
            chart.draw_series(LineSeries::new(front.iter().copied(), style))?;
        }
        for (i, s) in series.iter().enumerate() {
            let colour = PALETTE[i % PALETTE.len()];
            if s.joined {
                let style = colour.stroke_width(2);
                chart.draw_series(LineSeries::new(s.points.iter().copied(), style))?;
            }
            chart.draw_series(s.points.iter().map(|&p| Circle::new(p, 4, colour.filled())))?;
            let y = 26 + 20 * i as i32;
            legend.draw(&Circle::new((10, y), 4, colour.filled()))?;
            let text = ("sans-serif", 13).into_font().color(&BLACK);
            legend.draw(&Text::new(s.label.as_str(), (22, y - 6), text))?;
        }
        if !front.is_empty() {
            let y = 26 + 20 * series.len() as i32;
            let style = BLACK.mix(0.55).stroke_width(2);
            legend.draw(&PathElement::new([(2, y), (18, y)], style))?;
            let text = ("sans-serif", 13).into_font().color(&BLACK);
            legend.draw(&Text::new("Pareto front", (22, y - 6), text))?;
        }
        area.present()?;
    }
    Ok(svg)
}

/// The label of a grid line: of 1, 2 and 5 in every decade, since those of all nine run into one another.
fn short(v: f64) -> String {
    let leading = (v / 10f64.powf(v.log10().floor())).round();
    if ![1.0, 2.0, 5.0, 10.0].contains(&leading) {
        String::new()
    } else if (1e-2..1e5).contains(&v) {
        format!("{}", (v * 1e4).round() / 1e4)
    } else {
        format!("{v:.0e}")
    }
}
