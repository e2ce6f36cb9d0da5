//! Line charts.

use gearmesh::words::fixed;
use plotters::prelude::*;

use super::picture::{INK, curve_colour, digits, font, picture, px};
use crate::Error;

/// Width and height of a chart, pixels of the page.
const SIZE: (u32, u32) = (700, 360);

/// Of these, for the legend beside the plot.
const LEGEND_WIDTH: u32 = 130;

/// One curve of a chart.
pub struct Curve {
    /// Its name in the legend.
    pub label: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// The vertical axis; what is smaller than the height given, in its unit, is no more than rounding.
#[derive(Clone, Copy)]
pub enum Height {
    /// As high as the curves, at least this.
    Curves(f64),
    /// From zero, at least to this.
    FromZero(f64),
}

/// Lowest and highest of `values`, widened by 5 % and to a height of `least` at least.
fn range(values: impl Iterator<Item = f64>, least: f64) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let margin = (0.05 * (high - low)).max(0.5 * (least - (high - low)));
    low - margin..high + margin
}

/// Draws `curves` into an SVG element; `labels` stand at the axes.
pub fn line_chart(
    [x_label, y_label]: [&str; 2],
    height: Height,
    curves: &[Curve],
) -> Result<String, Error> {
    let points = || curves.iter().flat_map(|c| c.points.iter());
    let x_low = points().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let x_high = points().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    let (Height::Curves(least) | Height::FromZero(least)) = height;
    let mut y_range = range(points().map(|p| p.1), least);
    if let Height::FromZero(_) = height {
        y_range.start = 0.0;
    }
    let [x_digits, y_digits] = [digits(&(x_low..x_high)), digits(&y_range)];
    picture(SIZE, |area| {
        let (plot, legend) = area.split_horizontally(px(SIZE.0 - LEGEND_WIDTH));
        let mut chart = ChartBuilder::on(&plot)
            .margin(px(12))
            .x_label_area_size(px(42))
            .y_label_area_size(px(62))
            .build_cartesian_2d(x_low..x_high, y_range)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.12).stroke_width(px(1)))
            .axis_style(INK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(4))
            .x_labels(9)
            .y_labels(8)
            .x_label_formatter(&|x| fixed(*x, x_digits))
            .y_label_formatter(&|y| fixed(*y, y_digits))
            .x_desc(x_label)
            .y_desc(y_label)
            .axis_desc_style(font(13))
            .label_style(font(13))
            .draw()?;
        for (i, curve) in curves.iter().enumerate() {
            let style = curve_colour(i).stroke_width(px(2));
            chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
            let at = |x: u32, y: u32| (px(x) as i32, px(y) as i32);
            let y = 24 + 20 * i as u32;
            legend.draw(&PathElement::new([at(4, y), at(24, y)], style))?;
            legend.draw(&Text::new(curve.label.as_str(), at(30, y - 6), font(13)))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_not_magnified() {
        let noise = [10.0, 10.0 + 1e-13, 10.0 - 1e-13];
        assert_eq!(range(noise.into_iter(), 2.0), 9.0..11.0);
        let wide = range([0.0, 10.0].into_iter(), 2.0);
        assert_eq!(wide, -0.5..10.5);
    }
}
