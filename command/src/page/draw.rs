//! Figures as SVG, drawn large, since plotters rounds to whole pixels, and shown by the page at half the size.

use std::ops::Range;

use gearmesh::words::fixed;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::{Curve, Figure, Height, Map, Plot, Style};
use crate::error::Result;

impl Figure {
    pub fn svg(&self) -> askama::Result<String> {
        let drawn = match &self.plot {
            Plot::Lines(height, curves) => lines(&self.labels, *height, curves),
            Plot::Map(data) => map(&self.labels, data),
        };
        drawn.map_err(|error| askama::Error::custom(error.to_string()))
    }
}

const SIZE: (u32, u32) = (1400, 800);
/// Of the width, for the legend and for the scale next to the plot.
const LEGEND_WIDTH: u32 = 380;
const SCALE_WIDTH: u32 = 190;

const INK: RGBColor = RGBColor(34, 34, 34);

/// Curves distinguished by colour, also by eyes that see no red or no green.
const CURVES: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// Contact at a tip edge, apart from the scale.
const EDGE: RGBColor = RGBColor(0, 114, 178);

type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

/// Decimals that make the labels of an axis of this length differ.
fn digits(axis: &Range<f64>) -> usize {
    let step = (axis.end - axis.start) / 10.0;
    (-step.log10().floor()).clamp(0.0, 9.0) as usize
}

/// Draws axes named `labels` with about `count` numbers each, and a grid of this opacity.
fn axes(chart: &mut Chart, labels: [&str; 2], count: usize, grid: f64) -> Result<()> {
    let [x_digits, y_digits] = [digits(&chart.x_range()), digits(&chart.y_range())];
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(grid).stroke_width(2))
        .axis_style(INK.stroke_width(2))
        .set_all_tick_mark_size(8)
        .x_labels(count)
        .y_labels(count)
        .x_label_formatter(&|x| fixed(*x, x_digits))
        .y_label_formatter(&|y| fixed(*y, y_digits))
        .axis_desc_style(font(32))
        .label_style(font(30))
        .x_desc(labels[0])
        .y_desc(labels[1])
        .draw()?;
    Ok(())
}

fn ends(values: impl Iterator<Item = f64>) -> Range<f64> {
    let wider = |ends: Range<f64>, v: f64| ends.start.min(v)..ends.end.max(v);
    let found = values.fold(f64::INFINITY..f64::NEG_INFINITY, wider);
    match found.start < found.end {
        true => found,
        // Nothing, or one value: still an axis.
        false if found.start.is_finite() => found.start - 0.5..found.end + 0.5,
        false => 0.0..1.0,
    }
}

/// The range of `values`, widened by 5 % and to a height of `least` at least.
fn range(values: impl Iterator<Item = f64>, least: f64) -> Range<f64> {
    let Range { start, end } = ends(values);
    let margin = (0.05 * (end - start)).max(0.5 * (least - (end - start)));
    start - margin..end + margin
}

fn lines(labels: &[String], height: Height, curves: &[Curve]) -> Result<String> {
    let points = || curves.iter().flat_map(|c| &c.points);
    let lower = curves.iter().filter_map(|curve| match &curve.style {
        Style::Band(low) => Some(low),
        _ => None,
    });
    let (Height::Curves(least) | Height::FromZero(least)) = height;
    let mut y = range(points().map(|p| p.1).chain(lower.flatten().copied()), least);
    if let Height::FromZero(_) = height {
        y.start = 0.0;
    }
    let is_own = |c: &&Curve| !matches!(c.style, Style::Dashed(_));
    let own = curves.iter().filter(is_own).count().max(1);
    let colour = |i: usize| match own > CURVES.len() {
        true => shade(0.2 + 0.8 * (i % own) as f64 / own as f64),
        false => CURVES[i % own],
    };
    let step = (740 / (curves.len() + 1)).min(44) as i32;
    drawn(|area| {
        let (plot, legend) = area.split_horizontally(SIZE.0 - LEGEND_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(24)
            .x_label_area_size(96)
            .y_label_area_size(130)
            .build_cartesian_2d(ends(points().map(|p| p.0)), y)?;
        axes(&mut chart, [&labels[0], &labels[1]], 8, 0.12)?;
        let mut next = 40;
        let mut entry = |style: &Style, line: ShapeStyle, label: &str| -> Result<()> {
            let (marks, half): (&[_], _) = match style {
                Style::Solid => (&[[4, 48]], 0),
                Style::Dashed(_) => (&[[4, 18], [30, 48]], 0),
                Style::Band(_) => (&[[4, 48]], 12),
            };
            for [left, right] in marks {
                let corners = [(*left, next - half), (*right, next + half)];
                match half {
                    0 => legend.draw(&PathElement::new(corners, line))?,
                    _ => legend.draw(&Rectangle::new(corners, line))?,
                }
            }
            let room = 2 * (LEGEND_WIDTH - 58) / label.chars().count().max(1) as u32;
            let size = room.clamp(18, 32);
            let corner = (58, next - size as i32 / 2);
            legend.draw(&Text::new(label, corner, font(size)))?;
            next += step;
            Ok(())
        };
        let mut other = None;
        for (i, curve) in curves.iter().enumerate() {
            let mut style = colour(i).stroke_width(4);
            let points = curve.points.iter().copied();
            match &curve.style {
                Style::Solid => {
                    chart.draw_series(LineSeries::new(points, style))?;
                }
                Style::Dashed(name) => {
                    chart.draw_series(DashedLineSeries::new(points, 14, 10, style))?;
                    other = Some((&curve.style, name));
                    // Curves of one colour share an entry.
                    if curves[i % own].label == curve.label {
                        continue;
                    }
                }
                Style::Band(low) => {
                    style = colour(i).mix(0.25).filled();
                    let lower = curve.points.iter().zip(low).rev();
                    let corners = points.chain(lower.map(|((x, _), y)| (*x, *y)));
                    chart.draw_series([Polygon::new(corners.collect::<Vec<_>>(), style)])?;
                }
            }
            entry(&curve.style, style, &curve.label)?;
        }
        match other {
            Some((style, name)) => entry(style, INK.stroke_width(4), name),
            None => Ok(()),
        }
    })
}

fn shade(fraction: f64) -> RGBColor {
    // Dark violet, red, orange, pale yellow; lighter is lower.
    const STOPS: [(f64, f64, f64); 5] = [
        (255.0, 250.0, 225.0),
        (253.0, 201.0, 107.0),
        (242.0, 112.0, 63.0),
        (176.0, 28.0, 82.0),
        (60.0, 10.0, 84.0),
    ];
    let along = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (along as usize).min(STOPS.len() - 2);
    let t = along - i as f64;
    let mix = |a: f64, b: f64| (a + t * (b - a)).round() as u8;
    let (a, b) = (STOPS[i], STOPS[i + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Higher values over lower ones.
fn map(labels: &[String], map: &Map) -> Result<String> {
    let order = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    let mut patches: Vec<_> = map.patches.iter().collect();
    patches.sort_by(|a, b| order(a.value).total_cmp(&order(b.value)));
    let [x_ends, y_ends] = map.ends.map(|[low, high]| low..high);
    let top = if map.top > 0.0 { map.top } else { 1.0 };
    drawn(|area| {
        let (plot, bar) = area.split_horizontally(SIZE.0 - SCALE_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(24)
            .x_label_area_size(96)
            .y_label_area_size(130)
            .build_cartesian_2d(x_ends, y_ends)?;
        axes(&mut chart, [&labels[0], &labels[1]], 6, 0.0)?;
        // Patches that adjoin would leave gaps: each is a pixel larger all around.
        let (width, height) = chart.plotting_area().dim_in_pixel();
        let pixel = [(0, width), (1, height)]
            .map(|(axis, n)| (map.ends[axis][1] - map.ends[axis][0]) / f64::from(n));
        chart.draw_series(patches.into_iter().map(|patch| {
            let [x, y] = [0, 1].map(|axis| {
                let [a, b] = patch.ends[axis];
                [a.min(b) - pixel[axis], a.max(b) + pixel[axis]]
            });
            let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
            let colour = patch.value.map_or(EDGE, |value| shade(value / top));
            Polygon::new(corners, colour.filled())
        }))?;
        let mut bar = ChartBuilder::on(&bar)
            .margin(24)
            .margin_bottom(120)
            .right_y_label_area_size(120)
            .build_cartesian_2d(0.0..1.0, 0.0..top)?;
        axes(&mut bar, ["", &labels[2]], 5, 0.0)?;
        const STEPS: usize = 40;
        bar.draw_series((0..STEPS).map(|i| {
            let height = |i: usize| top * i as f64 / STEPS as f64;
            let colour = shade((i as f64 + 0.5) / STEPS as f64);
            Rectangle::new([(0.0, height(i)), (1.0, height(i + 1))], colour.filled())
        }))?;
        Ok(())
    })
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn drawn(draw: impl FnOnce(&Area) -> Result<()>) -> Result<String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    draw(&area)?;
    area.present()?;
    drop(area);
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_an_axis_differ_and_rounding_is_not_magnified() {
        assert_eq!(digits(&(9.99..10.01)), 3);
        assert_eq!(digits(&(0.0..30.0)), 0);
        assert_eq!(digits(&(0.0..1.0)), 1);
        let noise = [10.0, 10.0 + 1e-13, 10.0 - 1e-13];
        assert_eq!(range(noise.into_iter(), 2.0), 9.0..11.0);
        assert_eq!(range([0.0, 10.0].into_iter(), 2.0), -0.5..10.5);
    }

    #[test]
    fn patches_that_adjoin_leave_no_gap() {
        let rows: Vec<f64> = (0..40).map(|i| f64::from(i) * (1.0 / 40.0)).collect();
        let cells = Map::on_nodes([&[0.0], &rows], vec![1.0; 40], 1.0);
        let svg = map(&["x", "y", "v"].map(Into::into), &cells).unwrap();
        let ends = |polygon: &str| {
            let points = polygon.split("points=\"").nth(1).unwrap();
            let points = points.split('"').next().unwrap().split_whitespace();
            let y = points.map(|p| p.split_once(',').unwrap().1.parse::<i32>().unwrap());
            (y.clone().min(), y.max())
        };
        let mut rows: Vec<_> = svg.split("<polygon").skip(1).map(ends).collect();
        rows.sort_unstable();
        assert_eq!(rows.len(), 40);
        assert!(rows.windows(2).all(|w| w[1].0 < w[0].1), "{rows:?}");
    }

    #[test]
    fn a_higher_pressure_is_never_drawn_lighter() {
        let luminance = |f: f64| {
            let RGBColor(r, g, b) = shade(f);
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let shades: Vec<f64> = (0..=100).map(|i| luminance(f64::from(i) / 100.0)).collect();
        assert!(shades.is_sorted_by(|a, b| a >= b));
    }
}
