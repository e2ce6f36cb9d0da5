//! Pictures as SVG in the colours of a light page, which a style inverts where the page is dark.
//!
//! They are drawn in pixels of [`FINE`] to the CSS pixel, since plotters rounds to whole ones.

use std::ops::Range;

use gearmesh::words::fixed;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::Error;

/// Pixels drawn for one pixel shown.
const FINE: u32 = 8;

pub const INK: RGBColor = RGBColor(34, 34, 34);

/// Curves told apart by colour, also by eyes that see no red or no green; then they repeat.
const CURVES: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

pub const STYLE: &str = "@media(prefers-color-scheme:dark){svg{filter:invert(.9) hue-rotate(180deg)}}\
                         svg polygon,svg rect{shape-rendering:crispEdges}";

/// What is drawn on, and a system of coordinates there.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// `n` pixels of the page in pixels of the drawing.
pub fn px(n: u32) -> u32 {
    n * FINE
}

/// Text of this size in pixels of the page.
pub fn font(size: u32) -> TextStyle<'static> {
    // plotters takes the height of a line, which it counts as 1.24 of the size.
    ("sans-serif", 1.24 * f64::from(px(size)))
        .into_font()
        .color(&INK)
}

/// Decimals that tell the labels of an axis of this length apart.
fn digits(axis: &Range<f64>) -> usize {
    let step = (axis.end - axis.start) / 10.0;
    if step > 0.0 {
        (-step.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        0
    }
}

pub fn curve_colour(i: usize) -> RGBColor {
    CURVES[i % CURVES.len()]
}

/// Draws axes named `labels` with about `count` numbers each, and a grid of this opacity.
pub fn draw_axes(
    chart: &mut Chart,
    labels: [&str; 2],
    count: usize,
    grid: f64,
) -> Result<(), Error> {
    let [x_digits, y_digits] = [digits(&chart.x_range()), digits(&chart.y_range())];
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(grid).stroke_width(px(1)))
        .axis_style(INK.stroke_width(px(1)))
        .set_all_tick_mark_size(px(4))
        .x_labels(count)
        .y_labels(count)
        .x_label_formatter(&|x| fixed(*x, x_digits))
        .y_label_formatter(&|y| fixed(*y, y_digits))
        .x_desc(labels[0])
        .y_desc(labels[1])
        .axis_desc_style(font(12))
        .label_style(font(12))
        .draw()?;
    Ok(())
}

/// An SVG element of `size` pixels of the page, which `draw` fills.
pub fn picture(
    (width, height): (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), Error>,
) -> Result<String, Error> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (px(width), px(height))).into_drawing_area();
    draw(&area)?;
    area.present()?;
    drop(area);
    let drawn = format!("width=\"{}\" height=\"{}\"", px(width), px(height));
    Ok(svg.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

/// `svg` as a file of its own, with a background.
pub fn document(svg: &str) -> String {
    let background = "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>";
    svg.replacen('>', &format!(">\n<style>{STYLE}</style>\n{background}"), 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_an_axis_differ() {
        assert_eq!(digits(&(9.99..10.01)), 3);
        assert_eq!(digits(&(0.0..30.0)), 0);
        assert_eq!(digits(&(0.0..1.0)), 1);
    }

    #[test]
    fn a_picture_has_colours_without_style_sheets_and_a_file_of_it_a_background() {
        let svg = picture((100, 50), |area| {
            let line = [(0, 0), (700, 300)];
            area.draw(&PathElement::new(line, curve_colour(1).stroke_width(2)))?;
            area.draw(&Text::new("load", (8, 8), font(12)))?;
            Ok(())
        })
        .unwrap();
        assert!(
            svg.contains("width=\"100\" height=\"50\" viewBox=\"0 0 800 400\""),
            "{svg}"
        );
        assert!(
            svg.contains("stroke=\"#D55E00\"") && svg.contains("fill=\"#222222\""),
            "{svg}"
        );
        let file = document(&svg);
        assert!(file.starts_with("<svg") && file.contains("prefers-color-scheme:dark"));
        assert!(file.find("fill=\"#fff\"/>") < file.find("#D55E00"));
    }
}
