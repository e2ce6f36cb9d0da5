//! Line charts, and maps: quantities over two others in shades, with their scale.

use std::ops::Range;

use plotters::prelude::*;

use super::picture::{curve_colour, draw_axes, font, picture, px};
use crate::Error;

/// Width and height of a chart and of a map, pixels of the page.
const CHART: (u32, u32) = (700, 360);
const MAP: (u32, u32) = (440, 330);

/// Of the width of a chart, for the legend beside the plot; of that of a map, for the scale.
const LEGEND_WIDTH: u32 = 130;
const SCALE_WIDTH: u32 = 84;

pub struct Curve {
    pub label: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    pub fn new(label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
        Curve {
            label: label.into(),
            points: points.into_iter().collect(),
        }
    }
}

/// The vertical axis; what is smaller than the height given, in its unit, is no more than rounding.
#[derive(Clone, Copy)]
pub enum Height {
    /// As high as the curves, at least this.
    Curves(f64),
    /// From zero, at least to this.
    FromZero(f64),
}

fn ends(values: impl Iterator<Item = f64>) -> Range<f64> {
    let ends = |ends: Range<f64>, v: f64| ends.start.min(v)..ends.end.max(v);
    values.fold(f64::INFINITY..f64::NEG_INFINITY, ends)
}

/// Those of `values`, widened by 5 % and to a height of `least` at least.
fn range(values: impl Iterator<Item = f64>, least: f64) -> Range<f64> {
    let Range { start, end } = ends(values);
    let margin = (0.05 * (end - start)).max(0.5 * (least - (end - start)));
    start - margin..end + margin
}

/// Draws `curves` into an SVG element; `labels` stand at the axes.
pub fn line_chart(labels: [&str; 2], height: Height, curves: &[Curve]) -> Result<String, Error> {
    let points = || curves.iter().flat_map(|c| c.points.iter());
    let (Height::Curves(least) | Height::FromZero(least)) = height;
    let mut y = range(points().map(|p| p.1), least);
    if let Height::FromZero(_) = height {
        y.start = 0.0;
    }
    picture(CHART, |area| {
        let (plot, legend) = area.split_horizontally(px(CHART.0 - LEGEND_WIDTH));
        let mut chart = ChartBuilder::on(&plot)
            .margin(px(12))
            .x_label_area_size(px(42))
            .y_label_area_size(px(62))
            .build_cartesian_2d(ends(points().map(|p| p.0)), y)?;
        draw_axes(&mut chart, labels, 8, 0.12)?;
        for (i, curve) in curves.iter().enumerate() {
            let style = curve_colour(i).stroke_width(px(2));
            chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
            let place = |x: u32, y: u32| (px(x) as i32, px(y) as i32);
            let y = 24 + 20 * i as u32;
            legend.draw(&PathElement::new([place(4, y), place(24, y)], style))?;
            legend.draw(&Text::new(curve.label.as_str(), place(30, y - 6), font(13)))?;
        }
        Ok(())
    })
}

/// A piece of the map with one value.
pub struct Patch {
    /// Corners in order, in the units of the axes.
    pub corners: [(f64, f64); 4],
    pub value: f64,
    /// Drawn apart from the scale, over everything: contact at a tip edge.
    pub apart: bool,
}

impl Patch {
    pub fn rectangle(x: [f64; 2], y: [f64; 2], value: f64) -> Patch {
        Patch {
            corners: [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])],
            value,
            apart: false,
        }
    }

    /// Its corners, moved outwards by `by` along the axes.
    fn widened(&self, by: [f64; 2]) -> Vec<(f64, f64)> {
        let [a, _, b, _] = self.corners;
        let middle = (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
        let out = |place: f64, middle: f64, by: f64| place + by.copysign(place - middle);
        let corners = self.corners.iter();
        corners
            .map(|(x, y)| (out(*x, middle.0, by[0]), out(*y, middle.1, by[1])))
            .collect()
    }
}

/// Patches, what they lie on and how they are shown.
pub struct Map<'a> {
    pub title: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// What stands at the axes and at the scale, with its unit.
    pub labels: [&'a str; 3],
    pub patches: Vec<Patch>,
    pub top: f64,
}

impl<'a> Map<'a> {
    /// `values` in the cells between `columns` and `rows`, all of a row after each other; the scale reaches to the
    /// largest, at least to `top`.
    pub fn of_cells(
        title: impl Into<String>,
        [columns, rows]: [Vec<f64>; 2],
        labels: [&'a str; 3],
        values: impl IntoIterator<Item = f64>,
        top: f64,
    ) -> Map<'a> {
        let places = rows
            .windows(2)
            .flat_map(|y| columns.windows(2).map(move |x| (x, y)));
        let patches = places.zip(values);
        let patches = patches.map(|((x, y), v)| Patch::rectangle([x[0], x[1]], [y[0], y[1]], v));
        let patches: Vec<Patch> = patches.collect();
        Map {
            title: title.into(),
            x: ends(columns.iter().copied()),
            y: ends(rows.iter().copied()),
            labels,
            top: patches.iter().map(|p| p.value).fold(top, f64::max),
            patches,
        }
    }
}

/// Ends of cells: halfway between `nodes`, and the outermost themselves.
pub fn cells_between(nodes: &[f64]) -> Vec<f64> {
    let middles = nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    [first].into_iter().chain(middles).chain([last]).collect()
}

/// Ends of cells around `nodes`, which are even.
pub fn cells_around(nodes: &[f64]) -> Vec<f64> {
    let mut ends = cells_between(nodes);
    let half = 0.5 * (nodes[1] - nodes[0]);
    ends[0] -= half;
    ends[nodes.len()] += half;
    ends
}

/// Patches apart from the scale.
const APART: RGBColor = RGBColor(0, 114, 178);

/// From pale to dark with the fraction 0 ..= 1 of the scale.
fn shade(fraction: f64) -> RGBColor {
    // Dark violet, red, orange, pale yellow; lighter is lower.
    const STOPS: [(f64, f64, f64); 5] = [
        (255.0, 250.0, 225.0),
        (253.0, 201.0, 107.0),
        (242.0, 112.0, 63.0),
        (176.0, 28.0, 82.0),
        (60.0, 10.0, 84.0),
    ];
    let place = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (place as usize).min(STOPS.len() - 2);
    let t = place - i as f64;
    let mix = |a: f64, b: f64| (a + t * (b - a)).round() as u8;
    let (a, b) = (STOPS[i], STOPS[i + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Draws `map`, higher values over lower ones, on a scale from 0.
pub fn draw_map(mut map: Map) -> Result<String, Error> {
    map.patches
        .sort_by(|a, b| (a.apart.cmp(&b.apart)).then(a.value.total_cmp(&b.value)));
    let [x_label, y_label, scale_label] = map.labels;
    let [x_length, y_length] = [&map.x, &map.y].map(|axis| axis.end - axis.start);
    let top = map.top;
    picture(MAP, |area| {
        let (plot, bar) = area.split_horizontally(px(MAP.0 - SCALE_WIDTH));
        let mut chart = ChartBuilder::on(&plot)
            .caption(&map.title, font(15))
            .margin(px(8))
            .x_label_area_size(px(40))
            .y_label_area_size(px(56))
            .build_cartesian_2d(map.x, map.y)?;
        chart.plotting_area().fill(&WHITE)?;
        draw_axes(&mut chart, [x_label, y_label], 6, 0.0)?;
        // A pixel of the drawing: rounded to these, patches side by side would leave gaps.
        let (width, height) = chart.plotting_area().dim_in_pixel();
        let pixel = [x_length / f64::from(width), y_length / f64::from(height)];
        chart.draw_series(map.patches.iter().map(|patch| {
            let colour = if patch.apart {
                APART
            } else {
                shade(patch.value / top)
            };
            Polygon::new(patch.widened(pixel), colour.filled())
        }))?;

        let mut scale = ChartBuilder::on(&bar)
            .margin_top(px(36))
            .margin_bottom(px(48))
            .margin_right(px(6))
            .right_y_label_area_size(px(52))
            .build_cartesian_2d(0.0..1.0, 0.0..top)?;
        draw_axes(&mut scale, ["", scale_label], 5, 0.0)?;
        const STEPS: usize = 40;
        scale.draw_series((0..STEPS).map(|i| {
            let height = |i: usize| top * i as f64 / STEPS as f64;
            let colour = shade((i as f64 + 0.5) / STEPS as f64);
            Rectangle::new([(0.0, height(i)), (1.0, height(i + 1))], colour.filled())
        }))?;
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

    #[test]
    fn cells_fill_the_map_and_carry_their_values_row_by_row() {
        let cells = [cells_around(&[1.0, 2.0, 3.0]), cells_around(&[10.0, 20.0])];
        let values = (0..6).map(f64::from);
        let map = Map::of_cells("", cells, ["x", "y", "value"], values, 0.0);
        assert_eq!((map.x, map.y, map.top), (0.5..3.5, 5.0..25.0, 5.0));
        assert_eq!(map.patches.len(), 6);
        assert_eq!(map.patches[4].value, 4.0);
        assert_eq!(map.patches[4].corners[0], (1.5, 15.0));
        assert_eq!(map.patches[4].corners[2], (2.5, 25.0));
    }

    #[test]
    fn patches_side_by_side_leave_no_gap() {
        // Steps that fall on pixels with a rounding of their own.
        let patches = (0..40).map(|i| {
            let [low, high] = [i, i + 1].map(|i| f64::from(i) * (1.0 / 40.0));
            let high = high - 1e-15;
            Patch::rectangle([0.0, 1.0], [low, high], 1.0)
        });
        let map = Map {
            title: String::new(),
            x: 0.0..1.0,
            y: 0.0..1.0,
            labels: ["x", "y", "value"],
            patches: patches.collect(),
            top: 1.0,
        };
        let svg = draw_map(map).unwrap();
        let mut rows: Vec<(i32, i32)> = (svg.split("<polygon").skip(1))
            .map(|polygon| {
                let points = polygon.split("points=\"").nth(1).unwrap();
                let points = points.split('"').next().unwrap().split_whitespace();
                let y = points.map(|p| p.split_once(',').unwrap().1.parse::<i32>().unwrap());
                y.fold((i32::MAX, i32::MIN), |(a, b), y| (a.min(y), b.max(y)))
            })
            .collect();
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
        for i in 0..100 {
            assert!(luminance(f64::from(i) / 100.0) >= luminance(f64::from(i + 1) / 100.0));
        }
    }
}
