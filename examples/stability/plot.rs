//! One kind of plot: lines over a linear or logarithmic frame, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// One line.
pub struct Line {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// What to draw.
pub struct Plot<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub logarithmic: bool,
    pub lines: Vec<Line>,
}

impl Plot<'_> {
    /// Write it to `path`.
    pub fn save(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let area = SVGBackend::new(path, (760, 420)).into_drawing_area();
        self.draw(&area).map_err(|e| e.to_string())?;
        area.present()?;
        Ok(())
    }

    fn draw(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let scaled = |v: f64| {
            if self.logarithmic {
                v.abs().max(1e-300).log10()
            } else {
                v
            }
        };
        let points: Vec<Vec<(f64, f64)>> = self
            .lines
            .iter()
            .map(|l| {
                l.points
                    .iter()
                    .map(|&(x, y)| (scaled(x), scaled(y)))
                    .collect()
            })
            .collect();
        let range = |pick: fn(&(f64, f64)) -> f64| {
            let all = points.iter().flatten().map(pick).filter(|v| v.is_finite());
            let (low, high) = all.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            let margin = 0.04 * (high - low).max(1e-12);
            (low - margin)..(high + margin)
        };
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, ("sans-serif", 18))
            .margin(10)
            .x_label_area_size(45)
            .y_label_area_size(70)
            .build_cartesian_2d(range(|p| p.0), range(|p| p.1))?;
        let label = |v: &f64| {
            if self.logarithmic {
                format!("{:.1e}", 10f64.powf(*v))
            } else {
                format!("{}", (v * 1e6).round() / 1e6)
            }
        };
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .draw()?;
        for (i, (line, points)) in self.lines.iter().zip(points).enumerate() {
            let color = Palette99::pick(i).to_rgba();
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))?
                .label(&line.name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2))
                });
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK)
            .draw()?;
        Ok(())
    }
}
