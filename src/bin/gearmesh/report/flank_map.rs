//! Contact pressure on the unrolled flank of gear 1, as inline SVG.

use std::ops::Range;

use plotters::prelude::*;

use crate::Error;

/// Width and height of a map, pixels of the SVG.
const SIZE: (u32, u32) = (420, 320);

/// A piece of flank with one pressure: corners as (z mm, diameter mm), pressure in MPa.
pub struct Patch {
    /// Corners in order.
    pub corners: [(f64, f64); 4],
    /// Pressure, MPa.
    pub pressure: f64,
    /// Whether contact reaches a tip edge there: drawn apart from the scale.
    pub at_edge: bool,
}

/// The flank that patches lie on.
pub struct FlankView {
    /// Face of the gear, mm.
    pub z: Range<f64>,
    /// Diameters from the start of the active profile to the tip, mm.
    pub diameter: Range<f64>,
}

/// Contact at a tip edge.
const EDGE: RGBColor = RGBColor(0, 114, 178);

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

/// Draws `patches`, higher pressures over lower ones, on a scale from 0 to `top` MPa; contact at tip edges,
/// where pressure has no bound, in a colour of its own.
pub fn flank_map(
    title: &str,
    view: &FlankView,
    mut patches: Vec<Patch>,
    top: f64,
) -> Result<String, Error> {
    patches.sort_by(|a, b| (a.at_edge.cmp(&b.at_edge)).then(a.pressure.total_cmp(&b.pressure)));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let (map, bar) = area.split_horizontally(SIZE.0 - 78);
        let mut chart = ChartBuilder::on(&map)
            .caption(title, ("sans-serif", 15))
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(52)
            .build_cartesian_2d(view.z.clone(), view.diameter.clone())?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(6)
            .y_labels(6)
            .x_desc("z (mm)")
            .y_desc("diameter (mm)")
            .label_style(("sans-serif", 12))
            .draw()?;
        chart.draw_series(patches.into_iter().map(|patch| {
            let colour = if patch.at_edge {
                EDGE
            } else {
                shade(patch.pressure / top)
            };
            Polygon::new(patch.corners.to_vec(), colour.filled())
        }))?;

        let mut scale = ChartBuilder::on(&bar)
            .margin_top(34)
            .margin_bottom(46)
            .margin_right(6)
            .right_y_label_area_size(46)
            .build_cartesian_2d(0.0..1.0, 0.0..top)?;
        scale
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_desc("MPa")
            .y_labels(5)
            .label_style(("sans-serif", 12))
            .draw()?;
        const STEPS: usize = 40;
        scale.draw_series((0..STEPS).map(|i| {
            let at = |i: usize| top * i as f64 / STEPS as f64;
            let colour = shade((i as f64 + 0.5) / STEPS as f64);
            Rectangle::new([(0.0, at(i)), (1.0, at(i + 1))], colour.filled())
        }))?;
        area.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

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
