//! Quantities over two others in shades, with their scale.

use std::ops::Range;

use gearmesh::words::fixed;
use plotters::prelude::*;

use super::picture::{INK, digits, font, picture, px};
use crate::Error;

/// Width and height of a map, pixels of the page.
const SIZE: (u32, u32) = (440, 330);

/// A piece of the map with one value.
pub struct Patch {
    /// Corners in order, in the units of the axes.
    pub corners: [(f64, f64); 4],
    /// Value in the unit of the scale.
    pub value: f64,
    /// Drawn apart from the scale, over everything: contact at a tip edge.
    pub apart: bool,
}

impl Patch {
    /// A rectangle between the ends of `x` and `y`.
    pub fn rectangle(x: [f64; 2], y: [f64; 2], value: f64) -> Patch {
        Patch {
            corners: [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])],
            value,
            apart: false,
        }
    }
}

impl Patch {
    /// Its corners, moved outwards by `by` along the axes.
    fn widened(&self, by: [f64; 2]) -> Vec<(f64, f64)> {
        let [a, _, b, _] = self.corners;
        let middle = (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
        let out = |at: f64, middle: f64, by: f64| at + by.copysign(at - middle);
        let corners = self.corners.iter();
        corners
            .map(|(x, y)| (out(*x, middle.0, by[0]), out(*y, middle.1, by[1])))
            .collect()
    }
}

/// Patches around the points of an even grid: `values` in rows over `x`, one row for each of `y`.
pub fn cells(x: &[f64], y: &[f64], values: impl Iterator<Item = f64>) -> Vec<Patch> {
    let points = y.iter().flat_map(|y| x.iter().map(move |x| (*x, *y)));
    let around = |at: f64, half: f64| [at - half, at + half];
    let half = [x, y].map(half_step);
    points
        .zip(values)
        .map(|((x, y), value)| Patch::rectangle(around(x, half[0]), around(y, half[1]), value))
        .collect()
}

fn half_step(nodes: &[f64]) -> f64 {
    0.5 * (nodes[1] - nodes[0])
}

/// What patches lie on.
pub struct View<'a> {
    /// Horizontal axis.
    pub x: Range<f64>,
    /// Vertical axis.
    pub y: Range<f64>,
    /// What stands at the axes and at the scale, with its unit.
    pub labels: [&'a str; 3],
}

impl<'a> View<'a> {
    /// Of the [`cells`] around the points of an even grid of two axes.
    pub fn over(axes: [&[f64]; 2], labels: [&'a str; 3]) -> View<'a> {
        let [x, y] = axes.map(|nodes| {
            let half = half_step(nodes);
            nodes[0] - half..nodes[nodes.len() - 1] + half
        });
        View { x, y, labels }
    }
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

/// Draws `patches`, higher values over lower ones, on a scale from 0 to `top`. The map is white paper on a dark page,
/// too, since its shades are made for that.
pub fn map(title: &str, view: &View, mut patches: Vec<Patch>, top: f64) -> Result<String, Error> {
    patches.sort_by(|a, b| (a.apart.cmp(&b.apart)).then(a.value.total_cmp(&b.value)));
    let [x_label, y_label, scale_label] = view.labels;
    let [x_digits, y_digits, scale_digits] = [&view.x, &view.y, &(0.0..top)].map(digits);
    picture(SIZE, |area| {
        let (map, bar) = area.split_horizontally(px(SIZE.0 - 84));
        let mut chart = ChartBuilder::on(&map)
            .caption(title, font(15))
            .margin(px(8))
            .x_label_area_size(px(40))
            .y_label_area_size(px(56))
            .build_cartesian_2d(view.x.clone(), view.y.clone())?;
        chart.plotting_area().fill(&WHITE)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(INK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(4))
            .x_labels(6)
            .y_labels(6)
            .x_label_formatter(&|x| fixed(*x, x_digits))
            .y_label_formatter(&|y| fixed(*y, y_digits))
            .x_desc(x_label)
            .y_desc(y_label)
            .axis_desc_style(font(12))
            .label_style(font(12))
            .draw()?;
        // A pixel of the drawing: rounded to these, patches side by side would leave gaps.
        let (width, height) = chart.plotting_area().dim_in_pixel();
        let pixel = [
            (view.x.end - view.x.start) / f64::from(width),
            (view.y.end - view.y.start) / f64::from(height),
        ];
        chart.draw_series(patches.into_iter().map(|patch| {
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
        scale
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .axis_style(INK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(4))
            .y_desc(scale_label)
            .y_labels(5)
            .y_label_formatter(&|y| fixed(*y, scale_digits))
            .axis_desc_style(font(12))
            .label_style(font(12))
            .draw()?;
        const STEPS: usize = 40;
        scale.draw_series((0..STEPS).map(|i| {
            let at = |i: usize| top * i as f64 / STEPS as f64;
            let colour = shade((i as f64 + 0.5) / STEPS as f64);
            Rectangle::new([(0.0, at(i)), (1.0, at(i + 1))], colour.filled())
        }))?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_view_and_carry_their_values_row_by_row() {
        let (x, y) = ([1.0, 2.0, 3.0], [10.0, 20.0]);
        let patches = cells(&x, &y, (0..6).map(f64::from));
        let view = View::over([&x, &y], ["x", "y", "value"]);
        assert_eq!((view.x, view.y), (0.5..3.5, 5.0..25.0));
        assert_eq!(patches.len(), 6);
        assert_eq!(patches[4].value, 4.0);
        assert_eq!(patches[4].corners[0], (1.5, 15.0));
        assert_eq!(patches[4].corners[2], (2.5, 25.0));
    }

    #[test]
    fn patches_side_by_side_leave_no_gap() {
        // Steps that fall on pixels with a rounding of their own.
        let patches = (0..40).map(|i| {
            let [low, high] = [i, i + 1].map(|i| f64::from(i) * (1.0 / 40.0));
            let high = high - 1e-15;
            Patch::rectangle([0.0, 1.0], [low, high], 1.0)
        });
        let view = View {
            x: 0.0..1.0,
            y: 0.0..1.0,
            labels: ["x", "y", "value"],
        };
        let svg = map("", &view, patches.collect(), 1.0).unwrap();
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
