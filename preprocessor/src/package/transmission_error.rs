//! The static transmission error over one base pitch, drawn for the page in the FMU.

use super::stiffness::nominal_pose;
use gearmesh::gear::Flank;
use gearmesh::table::Table;
use gearmesh::words::{fixed, rounded};
use std::fmt::Write as _;

/// Points of the curve.
const POINTS: usize = 96;

/// Left, top, width and height of the diagram's frame, pixels.
const FRAME: [f64; 4] = [60.0, 15.0, 560.0, 150.0];

/// Static transmission error on the line of action (m) at both ends of one base pitch and evenly between: drive flank,
/// aligned, nominal centre distance, under `torque` on gear 1 (N m).
fn curve(table: &Table, torque: f64) -> Vec<f64> {
    let force = torque / table.geometry().gears[0].base_radius();
    let (drive, _) = table.flank(Flank::Drive);
    let positions = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
    let approaches = positions.map(|position| drive.approach_at(force, &nominal_pose(position)));
    approaches.collect()
}

/// A figure of HTML with the curve at `torque` (on gear 1, N m), or at the largest of the tables.
pub(super) fn figure(table: &Table, torque: f64) -> String {
    let torque = torque.min(table.file().maximum_torque_nm);
    let values: Vec<f64> = (curve(table, torque).iter()).map(|m| 1e6 * m).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [left, top, width, height] = FRAME;
    // A curve without variation lies at the bottom.
    let scale = height / (largest - least).max(1e-9);
    let mut points = String::new();
    for (i, value) in values.iter().enumerate() {
        let x = left + width * i as f64 / POINTS as f64;
        let y = top + height - scale * (value - least);
        let _ = write!(points, "{x:.1},{y:.1} ");
    }
    let (right, bottom) = (left + width, top + height);
    let (line, text) = (bottom + 18.0, left - 8.0);
    format!(
        r##"<figure>
<svg viewBox="0 0 640 190" style="max-width: 640px" font-family="sans-serif" font-size="13" role="img" aria-label="Static transmission error over one base pitch">
<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#bbb"/>
<polyline points="{points}" fill="none" stroke="#c33" stroke-width="2"/>
<g fill="#222"><text x="{left}" y="{line}" text-anchor="middle">0</text><text x="{right}" y="{line}" text-anchor="middle">1</text>
<text x="340" y="{line}" text-anchor="middle">base pitches</text><text x="{text}" y="{bottom}" text-anchor="end">{}</text>
<text x="{text}" y="{top}" dy="0.7em" text-anchor="end">{}</text><text x="{text}" y="95" text-anchor="end">um</text></g>
</svg>
<figcaption>Static transmission error on the line of action at {} N m on gear 1, aligned, at the nominal centre distance: mean {} um,
peak to peak {} um.</figcaption>
</figure>
"##,
        fixed(least, 2),
        fixed(largest, 2),
        rounded(torque),
        fixed(values[1..].iter().sum::<f64>() / POINTS as f64, 2),
        fixed(largest - least, 3)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::shipped_tables;
    use gearmesh::table::TableFile;

    /// Peak to peak of the approach (um) from the samples alone, linear between the displacements.
    fn of_samples(file: &TableFile, torque: f64) -> f64 {
        let grid = file.drive_grid();
        let lengths @ [_, nm, nu, columns] = grid.axes.lengths();
        let [c, m, ..] = lengths.map(|length| length / 2);
        let force = torque / file.geometry.gears[0].base_radius();
        let approaches = (0..columns).map(|p| {
            let carried = |u| grid.loa_force[((c * nm + m) * nu + u) * columns + p];
            let approach = |u| 1e6 * grid.query([c, m, u, p]).delta;
            let above = (1..nu).find(|&u| carried(u) >= force).unwrap();
            let below = above - 1;
            let share = (force - carried(below)) / (carried(above) - carried(below));
            approach(below) + share * (approach(above) - approach(below))
        });
        let approaches: Vec<f64> = approaches.collect();
        let [least, largest] = [f64::min, f64::max].map(|f| approaches.iter().copied().reduce(f));
        largest.unwrap() - least.unwrap()
    }

    #[test]
    fn the_curve_is_drawn_with_the_variation_that_the_tables_hold() {
        for name in ["fzg-c", "palermo2013"] {
            let file = shipped_tables(name);
            let torque = 0.8 * file.nominal_torque_nm;
            let table = Table::from_file(file.clone()).unwrap();
            let figure = figure(&table, torque);
            let number = |after: &str| -> f64 {
                let (_, text) = figure.split_once(after).unwrap();
                text.split_whitespace().next().unwrap().parse().unwrap()
            };
            let peak_to_peak = number("peak to peak ");
            let expected = of_samples(&file, torque);
            assert!(
                (peak_to_peak / expected - 1.0).abs() < 0.05,
                "{name}: {peak_to_peak} {expected}"
            );
            // Beyond the tables: at their largest torque.
            let end = super::figure(&table, 1e9);
            assert_eq!(end, super::figure(&table, file.maximum_torque_nm));
        }
    }
}
