//! Figures as SVG, drawn large, since plotters rounds to whole pixels, and shown by the page at half the size.

use std::collections::BTreeMap;
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
/// Around a plot, below it and on its left for the numbers.
const MARGIN: u32 = 24;
const BELOW: u32 = 96;
const LEFT: u32 = 130;
/// Shades of a map: finer ones no eye tells apart.
const SHADES: usize = 64;

const INK: RGBColor = RGBColor(34, 34, 34);

/// Curves distinguished by colour, also by eyes that see no red or no green.
const CURVES: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(140, 86, 75),
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
    let found = values.fold(f64::INFINITY..f64::NEG_INFINITY, |ends, v| {
        ends.start.min(v)..ends.end.max(v)
    });
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

/// `axes` with the shorter one, per pixel of its `pixels`, widened about its middle to the scale of the other.
fn to_scale(axes: [Range<f64>; 2], pixels: [f64; 2]) -> [Range<f64>; 2] {
    let lengths = axes.each_ref().map(|axis| axis.end - axis.start);
    let scale = (lengths[0] / pixels[0]).max(lengths[1] / pixels[1]);
    std::array::from_fn(|k| {
        let middle = 0.5 * (axes[k].start + axes[k].end);
        let half = 0.5 * scale * pixels[k];
        middle - half..middle + half
    })
}

fn lines(labels: &[String], height: Height, curves: &[Curve]) -> Result<String> {
    let points = curves.iter().flat_map(|c| &c.points);
    let lower = curves.iter().filter_map(|curve| match &curve.style {
        Style::Band(low) => Some(low),
        _ => None,
    });
    let least = match height {
        Height::Curves(least) | Height::FromZero(least) => least,
        Height::ToScale => 0.0,
    };
    let mut x = ends(points.clone().map(|p| p.0));
    let mut y = range(points.map(|p| p.1).chain(lower.flatten().copied()), least);
    if let Height::FromZero(_) = height {
        y.start = 0.0;
    }
    if let Height::ToScale = height {
        let pixels = [
            SIZE.0 - LEGEND_WIDTH - 2 * MARGIN - LEFT,
            SIZE.1 - 2 * MARGIN - BELOW,
        ];
        [x, y] = to_scale([x, y], pixels.map(f64::from));
    }
    let own = curves
        .iter()
        .filter(|c| !matches!(c.style, Style::Dashed(_)))
        .count()
        .max(1);
    drawn(|area| {
        let (plot, legend) = area.split_horizontally(SIZE.0 - LEGEND_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(MARGIN)
            .x_label_area_size(BELOW)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(x, y)?;
        axes(&mut chart, [&labels[0], &labels[1]], 8, 0.12)?;
        let mut legend = Legend {
            area: legend,
            next: 40,
            step: (740 / (curves.len() + 1)).min(44) as i32,
        };
        let mut other = None;
        for (i, curve) in curves.iter().enumerate() {
            let colour = match own > CURVES.len() {
                true => shade(0.2 + 0.8 * (i % own) as f64 / own as f64),
                false => CURVES[i % own],
            };
            let mut style = colour.stroke_width(4);
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
                    style = colour.mix(0.25).filled();
                    let lower = curve.points.iter().zip(low).rev();
                    let corners = points.chain(lower.map(|((x, _), y)| (*x, *y)));
                    chart.draw_series([Polygon::new(corners.collect::<Vec<_>>(), style)])?;
                }
                Style::Dots => {
                    style = colour.mix(0.7).filled();
                    chart.draw_series(points.map(|point| Circle::new(point, 6, style)))?;
                }
            }
            legend.add(&curve.style, style, &curve.label)?;
        }
        match other {
            Some((style, name)) => legend.add(style, INK.stroke_width(4), name),
            None => Ok(()),
        }
    })
}

/// The entries beside a plot.
struct Legend<'a> {
    area: Area<'a>,
    /// Height of the next entry, and from one to the next, pixels.
    next: i32,
    step: i32,
}

impl Legend<'_> {
    fn add(&mut self, style: &Style, line: ShapeStyle, label: &str) -> Result<()> {
        let (marks, half): (&[_], _) = match style {
            Style::Solid => (&[[4, 48]], 0),
            Style::Dashed(_) => (&[[4, 18], [30, 48]], 0),
            Style::Band(_) => (&[[4, 48]], 12),
            Style::Dots => (&[[21, 31]], 5),
        };
        for [left, right] in marks {
            let corners = [(*left, self.next - half), (*right, self.next + half)];
            match half {
                0 => self.area.draw(&PathElement::new(corners, line))?,
                _ => self.area.draw(&Rectangle::new(corners, line))?,
            }
        }
        let room = 2 * (LEGEND_WIDTH - 58) / label.chars().count().max(1) as u32;
        let size = room.clamp(18, 32);
        let corner = (58, self.next - size as i32 / 2);
        self.area.draw(&Text::new(label, corner, font(size)))?;
        self.next += self.step;
        Ok(())
    }
}

fn shade(fraction: f64) -> RGBColor {
    // Dark violet, red, orange, pale yellow; lighter is lower.
    const STOPS: [[f64; 3]; 5] = [
        [255.0, 250.0, 225.0],
        [253.0, 201.0, 107.0],
        [242.0, 112.0, 63.0],
        [176.0, 28.0, 82.0],
        [60.0, 10.0, 84.0],
    ];
    let along = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (along as usize).min(STOPS.len() - 2);
    let t = along - i as f64;
    let (a, b) = (STOPS[i], STOPS[i + 1]);
    let [red, green, blue] = [0, 1, 2].map(|k| (a[k] + t * (b[k] - a[k])).round() as u8);
    RGBColor(red, green, blue)
}

/// Higher values over lower ones.
fn map(labels: &[String], map: &Map) -> Result<String> {
    let [x_ends, y_ends] = map.ends.map(|[low, high]| low..high);
    let top = if map.top > 0.0 { map.top } else { 1.0 };
    let mut layers: BTreeMap<usize, String> = BTreeMap::new();
    let mut svg = drawn(|area| {
        let (plot, bar) = area.split_horizontally(SIZE.0 - SCALE_WIDTH);
        let mut chart = ChartBuilder::on(&plot)
            .margin(MARGIN)
            .x_label_area_size(BELOW)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(x_ends, y_ends)?;
        axes(&mut chart, [&labels[0], &labels[1]], 6, 0.0)?;
        for (name, y) in map.end_names.into_iter().zip(map.ends[1]) {
            let (column, row) = chart.backend_coord(&(map.ends[0][0], y));
            let above = if y == map.ends[1][0] { -32 } else { 4 };
            plot.draw(&Text::new(name, (column + 8, row + above), font(30)))?;
        }
        for patch in &map.patches {
            let [a, b] = [0, 1].map(|end| {
                let corner = (patch.ends[0][end], patch.ends[1][end]);
                chart.backend_coord(&corner)
            });
            // Patches that adjoin would leave gaps: each is a pixel larger all around.
            let (x, y) = (a.0.min(b.0) - 1, a.1.min(b.1) - 1);
            let (width, height) = (a.0.abs_diff(b.0) + 2, a.1.abs_diff(b.1) + 2);
            let layer = patch.value.map_or(SHADES, |value| {
                (value / top * SHADES as f64).clamp(0.0, SHADES as f64 - 1.0) as usize
            });
            let path = layers.entry(layer).or_default();
            *path += &format!("M{x} {y}h{width}v{height}h-{width}z");
        }
        let mut bar = ChartBuilder::on(&bar)
            .margin(MARGIN)
            .margin_bottom(MARGIN + BELOW)
            .right_y_label_area_size(120)
            .build_cartesian_2d(0.0..1.0, 0.0..top)?;
        axes(&mut bar, ["", &labels[2]], 5, 0.0)?;
        const STEPS: usize = 40;
        bar.draw_series((0..STEPS).map(|i| {
            let [low, middle, high] = [0.0, 0.5, 1.0].map(|k| (i as f64 + k) / STEPS as f64);
            let corners = [(0.0, top * low), (1.0, top * high)];
            Rectangle::new(corners, shade(middle).filled())
        }))?;
        Ok(())
    })?;
    // One path a shade: as polygons of plotters' the patches would be five times as long.
    let paths: String = layers
        .iter()
        .map(|(layer, path)| {
            let RGBColor(r, g, b) = match *layer {
                SHADES => EDGE,
                shaded => shade((shaded as f64 + 0.5) / SHADES as f64),
            };
            format!("<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"{path}\"/>\n")
        })
        .collect();
    let end = svg.rfind("</svg>").unwrap_or(svg.len());
    svg.insert_str(end, &paths);
    Ok(svg)
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
        let ends = |rectangle: &str| {
            let number = |text: &str| text.parse::<i32>().unwrap();
            let (corner, way) = rectangle.split_once('h').unwrap();
            let y = number(corner.split_once(' ').unwrap().1);
            let height = number(way.split(['v', 'h']).nth(1).unwrap());
            (y, y + height)
        };
        let path = svg.rsplit("d=\"").next().unwrap();
        let mut rows: Vec<_> = path.split('M').skip(1).map(ends).collect();
        rows.sort_unstable();
        assert_eq!(rows.len(), 40);
        assert!(rows.windows(2).all(|w| w[1].0 < w[0].1), "{rows:?}");
    }

    #[test]
    fn a_drawing_has_one_scale_and_shows_all() {
        let [x, y] = to_scale([0.0..2.0, -1.0..1.0], [800.0, 400.0]);
        assert_eq!((x, y), (-1.0..3.0, -1.0..1.0));
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
