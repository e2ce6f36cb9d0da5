//! Pictures as SVG in the colours of the page, light or dark.
//!
//! They are drawn in pixels of [`FINE`] to the CSS pixel, since plotters rounds to whole ones, and in colours that stand for
//! a part of the picture: ink, or the n-th curve. The page has a style for each of these, and a picture in a file of its own
//! brings them along.

use std::ops::Range;

use plotters::prelude::*;

use crate::Error;

/// Pixels drawn for one pixel shown.
const FINE: u32 = 8;

/// Curves told apart by colour, also by eyes that see no red or no green; then they repeat.
const CURVES: usize = 6;

/// Text, axes and grid.
pub const INK: RGBColor = RGBColor(0, 0, 0);

/// Styles of a light and of a dark page: paper, ink, soft text, panels, rules, then the curves.
const THEMES: [[&str; 5 + CURVES]; 2] = [
    [
        "#fff", "#222", "#555", "#f6f6f4", "#ddd", "#0072b2", "#d55e00", "#009e73", "#cc79a7",
        "#56b4e9", "#5a5a5a",
    ],
    [
        "#17191c", "#e4e4e0", "#aaa", "#222529", "#3a3d42", "#5aaee8", "#f2924a", "#35c99a",
        "#e79fc6", "#9fd8fa", "#b4b4b4",
    ],
];

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

/// Rules for the styles of both themes.
pub fn style() -> String {
    let rules = |theme: &[&str; 5 + CURVES]| {
        let [paper, ink, soft, panel, rule, curves @ ..] = theme;
        let curves: String = (0..)
            .zip(curves)
            .map(|(i, colour)| format!("--c{i}:{colour};"))
            .collect();
        format!(
            ":root{{--paper:{paper};--ink:{ink};--soft:{soft};--panel:{panel};--rule:{rule};{curves}}}"
        )
    };
    let uses: String = (0..CURVES)
        .map(|i| format!(".f{i}{{fill:var(--c{i})}}.s{i}{{stroke:var(--c{i})}}"))
        .collect();
    format!(
        "{}@media(prefers-color-scheme:dark){{{}}}svg .fi{{fill:var(--ink)}}svg .si{{stroke:var(--ink)}}{uses}\
         svg polygon,svg rect{{shape-rendering:crispEdges}}",
        rules(&THEMES[0]),
        rules(&THEMES[1])
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

/// `svg` with styles in place of colours, and the size that it is shown in.
fn themed(svg: &str, (width, height): (u32, u32)) -> String {
    let drawn = format!("width=\"{}\" height=\"{}\"", px(width), px(height));
    let mut svg = svg.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1);
    let mut style = |colour: RGBColor, class: &str| {
        let RGBColor(r, g, b) = colour;
        for (attribute, prefix) in [("fill", 'f'), ("stroke", 's')] {
            svg = svg.replace(
                &format!("{attribute}=\"#{r:02X}{g:02X}{b:02X}\""),
                &format!("class=\"{prefix}{class}\""),
            );
        }
    };
    style(INK, "i");
    for i in 0..CURVES {
        style(curve_colour(i), &i.to_string());
    }
    svg
}

/// `svg` as a file of its own, with a background.
pub fn document(svg: &str) -> String {
    match svg.split_once('>') {
        Some((open, rest)) => format!(
            "{open}>\n<style>{}</style>\n<rect width=\"100%\" height=\"100%\" style=\"fill:var(--paper)\"/>{rest}",
            style()
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
    fn a_picture_has_no_ink_of_its_own_and_a_file_of_it_a_background() {
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
            svg.contains("class=\"s1\"") && svg.contains("class=\"fi\""),
            "{svg}"
        );
        assert!(!svg.contains("#000000"), "{svg}");
        let file = document(&svg);
        assert!(file.starts_with("<svg") && file.contains("prefers-color-scheme:dark"));
        assert!(file.find("var(--paper)\"/>") < file.find("class=\"s1\""));
    }
}
