//! Pictures as SVG in the colours of the page, light or dark.
//!
//! They are drawn in pixels of [`FINE`] to the CSS pixel, since plotters rounds to whole ones, and in colours that stand for
//! a part of the picture: ink, or the n-th curve. In place of each comes that of a light page, and a class, for which the page
//! has a style where it is dark; a picture in a file of its own brings these along.

use std::ops::Range;

use plotters::prelude::*;

use crate::Error;

/// Pixels drawn for one pixel shown.
const FINE: u32 = 8;

/// Curves told apart by colour, also by eyes that see no red or no green; then they repeat.
const CURVES: usize = 6;

/// Text, axes and grid.
pub const INK: RGBColor = RGBColor(0, 0, 0);

/// Colours of the pictures on a light and on a dark page: paper, ink, then the curves. The light ones are attributes, since
/// many programs know no style sheets; the dark ones are styles.
const THEMES: [[&str; 2 + CURVES]; 2] = [
    [
        "#fff", "#222", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#5a5a5a",
    ],
    [
        "#17191c", "#e4e4e0", "#5aaee8", "#f2924a", "#35c99a", "#e79fc6", "#9fd8fa", "#b4b4b4",
    ],
];

/// Their names in the classes of style sheets.
const CLASSES: [&str; 2 + CURVES] = ["p", "i", "0", "1", "2", "3", "4", "5"];

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
pub fn digits(axis: &Range<f64>) -> usize {
    let step = (axis.end - axis.start) / 10.0;
    if step > 0.0 {
        (-step.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        0
    }
}

/// Colour that stands for curve `i`.
pub fn curve_colour(i: usize) -> RGBColor {
    // No shade of a map has these: their red and green are far below their blue.
    RGBColor(1, 2, 250 - (i % CURVES) as u8)
}

/// Styles of the pictures.
pub fn style() -> String {
    let dark: String = (CLASSES.iter().zip(THEMES[1]))
        .map(|(class, colour)| {
            format!("svg .f{class}{{fill:{colour}}}svg .s{class}{{stroke:{colour}}}")
        })
        .collect();
    format!(
        "@media(prefers-color-scheme:dark){{{dark}}}svg polygon,svg rect{{shape-rendering:crispEdges}}"
    )
}

/// An SVG element of `size` pixels of the page, which `draw` fills.
pub fn picture(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend, plotters::coord::Shift>) -> Result<(), Error>,
) -> Result<String, Error> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (px(size.0), px(size.1))).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    Ok(themed(&svg, size))
}

/// `svg` with classes beside the colours of a light page, and the size that it is shown in.
fn themed(svg: &str, (width, height): (u32, u32)) -> String {
    let drawn = format!("width=\"{}\" height=\"{}\"", px(width), px(height));
    let mut svg = svg.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1);
    let curves = (0..CURVES).map(curve_colour);
    let drawn = std::iter::once(INK).chain(curves);
    for ((RGBColor(r, g, b), class), colour) in drawn.zip(&CLASSES[1..]).zip(&THEMES[0][1..]) {
        for (attribute, prefix) in [("fill", 'f'), ("stroke", 's')] {
            svg = svg.replace(
                &format!("{attribute}=\"#{r:02X}{g:02X}{b:02X}\""),
                &format!("{attribute}=\"{colour}\" class=\"{prefix}{class}\""),
            );
        }
    }
    svg
}

/// `svg` as a file of its own, with a background.
pub fn document(svg: &str) -> String {
    match svg.split_once('>') {
        Some((open, rest)) => format!(
            "{open}>\n<style>{}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"{}\" class=\"fp\"/>{rest}",
            style(),
            THEMES[0][0]
        ),
        None => svg.to_owned(),
    }
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
            svg.contains("stroke=\"#d55e00\" class=\"s1\"")
                && svg.contains("fill=\"#222\" class=\"fi\""),
            "{svg}"
        );
        assert!(!svg.contains("#000000"), "{svg}");
        let file = document(&svg);
        assert!(file.starts_with("<svg") && file.contains("prefers-color-scheme:dark"));
        assert!(!file.contains("var("), "{file}");
        assert!(file.find("fill=\"#fff\" class=\"fp\"/>") < file.find("class=\"s1\""));
    }
}
