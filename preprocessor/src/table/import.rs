//! Tables from samples of any other program: a CSV file of static solutions on a full grid of torque,
//! mesh position, centre distance and misalignment.
//!
//! A sample gives the displacement under a load; the table wants the load at a displacement. Each line of samples over the torque
//! is inverted by a monotone cubic (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238-246), so a line must rise strictly.

use crate::storage::csv_reader;
use gearmesh::contact::STIFFNESS_OVER_MODULUS;
use gearmesh::gear::PairGeometry;
use gearmesh::table::{Axes, FlankGrid, TableError};
use gearmesh::words::{rounded, shown};
use std::cmp::Ordering;

/// Columns of the file, in any order in its header.
pub const COLUMNS: [&str; 6] = [
    "torque_nm",
    "mesh_position",
    "center_distance_offset_um",
    "misalignment_mrad",
    "ste_loa_um",
    "contact_z_mm",
];

/// Force at the lowest node over that of a linear spring. With cells that end at 0, x/2, x, 4x the C2 spline
/// that vanishes before 0 and is the linear spring k u beyond 4x is k times the sum of c_i (u - t_i)³ with
/// c x² = 11/12, -40/21, 1, -1/84 (no cubic, no quadratic, no constant part beyond); at x it is 19/28 k x.
const ROUNDED_ONSET: f64 = 19.0 / 28.0;

#[derive(Debug, Clone, Copy)]
struct Row {
    line: u64,
    values: [f64; 6],
}

impl Row {
    /// Centre distance offset, misalignment, mesh position and torque, by which rows are sorted.
    fn key(&self) -> [f64; 4] {
        let [t, p, c, m, ..] = self.values;
        [c, m, p, t]
    }
}

/// What an import gives.
#[derive(Debug)]
pub struct Imported {
    /// Samples on the table's grid.
    pub grid: FlankGrid,
    /// Largest torque, N m on gear 1.
    pub maximum_torque: f64,
    /// Smallest torque above 0, N m on gear 1; below it the table follows an assumed onset.
    pub smallest_torque: f64,
}

/// Samples stiffer or softer than teeth by less than this factor may be meant, if they are odd.
const ODD: f64 = 10.0;

/// And beyond this one they are in another unit.
const IMPOSSIBLE: f64 = 100.0;

impl Imported {
    /// What is odd about the samples for a pair with this geometry and nominal torque (N m on gear 1), in a sentence.
    ///
    /// # Errors
    /// Samples that no simulation can use: largest torque below the nominal one, an axis that leaves out the
    /// nominal centre distance or parallel axes, or a stiffness that no teeth have.
    pub fn doubt(
        &self,
        geometry: &PairGeometry,
        nominal_torque: f64,
    ) -> Result<Option<String>, TableError> {
        let torque = self.maximum_torque;
        if torque < nominal_torque {
            return refused(format!(
                "the largest torque_nm is {torque}, below the nominal torque of the pair file, {nominal_torque} N m; give \
                 samples up to the torques that are to be simulated, or correct operating.nominal_torque_nm"
            ));
        }
        let (grid, axes) = (&self.grid, &self.grid.axes);
        for (name, nodes, scale) in [
            (COLUMNS[2], &axes.center_distance_offset, 1e6),
            (COLUMNS[3], &axes.misalignment, 1e3),
        ] {
            let [low, high] = [nodes[0], nodes[nodes.len() - 1]].map(|node| rounded(node * scale));
            if low > 0.0 || high < 0.0 {
                return refused(format!(
                    "{name} runs from {low} to {high} and leaves out 0, the nominal state; give deviations from nominal"
                ));
            }
        }
        let ends = [&grid.no_load_approach, &grid.top_load_approach];
        let [low, top] = ends.map(|ends| ends.iter().sum::<f64>());
        let travel = (top - low) / grid.top_load_approach.len() as f64;
        let modulus = geometry.gears.iter().map(|g| g.youngs_modulus);
        let width = geometry.face_overlap().1;
        let usual = STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min) * width;
        let ratio = torque / geometry.gears[0].base_radius() / travel / usual;
        let [rise, times] = [1e6 * travel, ratio].map(two_digits);
        let rise = format!(
            "ste_loa_um rises by {rise} um on average up to {torque} N m, {times} times the stiffness usual for these teeth"
        );
        if !(IMPOSSIBLE.recip()..=IMPOSSIBLE).contains(&ratio) {
            return refused(format!(
                "{rise}; give the transmission error on the line of action in um, and the torque on gear 1 in N m"
            ));
        }
        let is_odd = !(ODD.recip()..=ODD).contains(&ratio);
        let odd = is_odd.then(|| format!("{rise}; check units and pair file"));
        let smallest = self.smallest_torque;
        let assumed = (smallest > nominal_torque).then(|| {
            format!(
                "the smallest torque_nm above 0 is {smallest}, above the nominal torque of the pair file, {nominal_torque} N m: below \
                 it loads follow an assumed onset, not samples; give samples at smaller torques, too"
            )
        });
        let doubts: Vec<String> = odd.into_iter().chain(assumed).collect();
        Ok((!doubts.is_empty()).then(|| doubts.join("; ")))
    }
}

/// Reads CSV text of the drive flank of `geometry`: header with [`COLUMNS`], then one row per sample; empty lines and lines that
/// begin with # are skipped. `contact_z_mm` is where the resultant crosses the pitch plane, from gear 1's z = 0 face.
///
/// The no-load approach is the sample at torque 0, or the line through the two smallest torques taken to 0.
/// `contact_z_mm` at torque 0 is not looked at.
///
/// Between that and the smallest torque above 0 the samples say nothing. The table has two nodes there, at a
/// quarter and a sixteenth of that displacement. The lowest one takes 19/28 of the force that the line through the
/// samples has there, which rounds the kink of the onset off below the other: a linear spring comes out exact
/// from a quarter of the displacement at the smallest torque on.
///
/// # Errors
/// Unknown or missing columns, numbers that are none, repeated or missing grid points, displacement that
/// does not rise with the torque: each with line and values.
pub fn import_csv(text: &str, geometry: &PairGeometry) -> Result<Imported, TableError> {
    let mut rows = parse(text)?;
    let [torques, positions, offsets, misalignments] = &nodes(&rows)?;
    check_on_face(&rows, geometry)?;
    rows.sort_by(|a, b| a.key().partial_cmp(&b.key()).unwrap_or(Ordering::Equal));
    check_complete(&rows, [torques, positions, offsets, misalignments])?;
    let lines = rows.chunks(torques.len());
    let lines = lines.map(|line| Line::new(line, geometry));
    let lines = lines.collect::<Result<Vec<_>, _>>()?;
    let loads = loads(torques);
    let fractions = fractions(&lines, loads);
    let axes = Axes {
        displacement_fraction: fractions.clone(),
        center_distance_offset: offsets.iter().map(|c| 1e-6 * c).collect(),
        misalignment: misalignments.iter().map(|m| 1e-3 * m).collect(),
        mesh_position: positions.clone(),
    };
    let (mut loa_force, mut moment) = (vec![], vec![]);
    for block in lines.chunks(positions.len()) {
        for (k, u) in fractions.iter().enumerate() {
            for l in block {
                let (force, lever) = l.at(l.delta[0] + u * (l.delta[loads] - l.delta[0]));
                let force = if k == 0 { force * ROUNDED_ONSET } else { force };
                loa_force.push(force);
                moment.push(force * lever);
            }
        }
    }
    let grid = FlankGrid {
        axes,
        no_load_approach: lines.iter().map(|l| l.delta[0]).collect(),
        top_load_approach: lines.iter().map(|l| l.delta[loads]).collect(),
        loa_force,
        moment: Some(moment),
        sliding: None,
    };
    grid.check("samples")?;
    let maximum_torque = torques[torques.len() - 1];
    Ok(Imported {
        grid,
        maximum_torque,
        smallest_torque: torques[torques.len() - loads],
    })
}

/// Torques above 0.
fn loads(torques: &[f64]) -> usize {
    torques.len() - usize::from(torques[0] == 0.0)
}

/// Torques, mesh positions, centre distance offsets and misalignments of the samples, each ascending, of which there are enough.
fn nodes(rows: &[Row]) -> Result<[Vec<f64>; 4], TableError> {
    let nodes = [0, 1, 2, 3].map(|k| {
        let mut values: Vec<f64> = rows.iter().map(|r| r.values[k]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    });
    let [torques, others @ ..] = &nodes;
    if torques[0] < 0.0 {
        return refused(format!(
            "torque_nm = {}: a torque is not negative; give the loaded flank's samples only",
            brief(torques[0])
        ));
    }
    let loads = loads(torques);
    if loads < 4 {
        return refused(format!(
            "torque_nm has {loads} values above 0; a cubic spline needs at least 4; add values"
        ));
    }
    for (name, values) in COLUMNS[1..].iter().zip(others) {
        if let 2..4 = values.len() {
            return refused(format!(
                "{name} has {} values; a cubic spline needs at least 4; add values, or give a single one, which leaves the axis out",
                values.len()
            ));
        }
    }
    Ok(nodes)
}

/// Every point of the grid of torques, mesh positions, centre distance offsets and misalignments has one of the sorted `rows`.
fn check_complete(rows: &[Row], nodes: [&Vec<f64>; 4]) -> Result<(), TableError> {
    if let Some([first, twice]) = neighbours(rows, |a, b| a.key() == b.key()) {
        return refused(format!(
            "line {}: the point {} stands in line {} already; leave one of them out",
            twice.line,
            describe(twice.values),
            first.line
        ));
    }
    let [torques, positions, offsets, misalignments] = nodes;
    let (nt, np, nm) = (torques.len(), positions.len(), misalignments.len());
    let total = nodes
        .map(Vec::len)
        .into_iter()
        .fold(1, usize::saturating_mul);
    for i in 0..total {
        let (t, p) = (torques[i % nt], positions[i / nt % np]);
        let (m, c) = (misalignments[i / nt / np % nm], offsets[i / nt / np / nm]);
        if rows.get(i).map(Row::key) != Some([c, m, p, t]) {
            return refused(format!(
                "no sample at {}; the grid must be complete",
                describe([t, p, c, m, 0.0, 0.0])
            ));
        }
    }
    Ok(())
}

/// Displacement nodes where the samples under `loads` torques above 0 lie on average, so that inversion has little to bridge, and two below.
fn fractions(lines: &[Line], loads: usize) -> Vec<f64> {
    let fractions = (1..=loads).map(|k| {
        let parts =
            (lines.iter()).map(|l| (l.delta[k] - l.delta[0]) / (l.delta[loads] - l.delta[0]));
        parts.sum::<f64>() / lines.len() as f64
    });
    let mut fractions: Vec<f64> = fractions.collect();
    fractions[loads - 1] = 1.0;
    // Springs that start with a kink (linear ones) must not ring: the spline, which starts without,
    // gets two more nodes below the smallest load to round the kink off within.
    let smallest = fractions[0];
    fractions.splice(0..0, [smallest / 16.0, smallest / 4.0]);
    fractions
}

fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

fn refused<T>(message: String) -> Result<T, TableError> {
    Err(TableError::Failed(format!("samples: {message}")))
}

fn neighbours(rows: &[Row], is_so: impl Fn(&Row, &Row) -> bool) -> Option<[&Row; 2]> {
    let mut pairs = rows.iter().zip(rows.iter().skip(1));
    let (a, b) = pairs.find(|(a, b)| is_so(a, b))?;
    Some([a, b])
}

fn describe(values: [f64; 6]) -> String {
    let named = COLUMNS.iter().zip(values).take(4);
    let named: Vec<_> = named.map(|(k, v)| format!("{k} = {}", brief(v))).collect();
    named.join(", ")
}

fn brief(value: f64) -> String {
    shown(&value.to_string())
}

/// How far off the face a resultant may be written for rounding, mm.
const OFF_FACE_MM: f64 = 1e-3;

/// Every load lies within the common face, so that the resultant crosses the pitch plane no farther beyond it than it may lie
/// off that plane times the slope of the contact lines.
fn check_on_face(rows: &[Row], geometry: &PairGeometry) -> Result<(), TableError> {
    let (low, width) = geometry.face_overlap();
    let path = geometry.base_pitch() * geometry.transverse_contact_ratio(geometry.center_distance);
    let beyond = geometry.base_helix_angle().tan() * path;
    let [low, high] = [low - beyond, low + width + beyond].map(|z| 1e3 * z);
    let Some(row) = rows.iter().find(|r| {
        let z = r.values[5];
        r.values[0] > 0.0 && (z < low - OFF_FACE_MM || z > high + OFF_FACE_MM)
    }) else {
        return Ok(());
    };
    refused(format!(
        "line {}: contact_z_mm = {} at {} lies off the common face of the gears: {low} to {high} mm from gear 1's z = 0 \
         face can be; give from that face where the resultant crosses the pitch plane",
        row.line,
        brief(row.values[5]),
        describe(row.values)
    ))
}

fn parse(text: &str) -> Result<Vec<Row>, TableError> {
    let mut reader = csv_reader(text);
    let header = reader.headers().map_err(unreadable)?.clone();
    if let Some(name) = header.iter().chain(COLUMNS).find(|name| {
        !COLUMNS.contains(name) || header.iter().filter(|column| column == name).count() != 1
    }) {
        return refused(format!(
            "column `{}`: the header must have each of {} once, and no others",
            shown(name),
            COLUMNS.join(",")
        ));
    }
    let rows = reader.records().map(|record| {
        let record = record.map_err(unreadable)?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = [0.0; 6];
        for (cell, column) in record.iter().zip(&header) {
            let value = cell.parse().ok().filter(|v: &f64| v.is_finite());
            let Some(value) = value else {
                let cell = shown(cell);
                return refused(format!(
                    "line {line}: {column} = {cell}: not a finite number"
                ));
            };
            let known = COLUMNS.iter().position(|name| *name == column);
            values[known.expect("checked above")] = value;
        }
        Ok(Row { line, values })
    });
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    match rows.is_empty() {
        true => refused("no rows after the header; give one for every point of the grid".into()),
        false => Ok(rows),
    }
}

fn unreadable(error: csv::Error) -> TableError {
    TableError::Failed(format!("samples: {error}"))
}

/// Samples over the load at one point of the other coordinates, from the no-load approach on.
struct Line {
    delta: Vec<f64>,
    force: Vec<f64>,
    /// dF/d delta, limited so that the cubic is monotone.
    slope: Vec<f64>,
    lever: Vec<f64>,
}

/// Slopes of parabolas through three neighbours, cut to what keeps the cubic monotone.
fn monotone_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
    let secant: Vec<f64> = (y.windows(2).zip(&h))
        .map(|(y, h)| (y[1] - y[0]) / h)
        .collect();
    // At the end of the cell `end`, whose neighbour is `next`.
    let outer = |end: usize, next: usize| {
        let slope = secant[end] + h[end] / (h[end] + h[next]) * (secant[end] - secant[next]);
        slope.clamp(0.0, 3.0 * secant[end])
    };
    (0..n)
        .map(|i| match i {
            0 => outer(0, 1),
            _ if i == n - 1 => outer(n - 2, n - 3),
            _ => {
                let (a, b) = (i - 1, i);
                let slope = (secant[a] * h[b] + secant[b] * h[a]) / (h[a] + h[b]);
                slope.min(3.0 * secant[a]).min(3.0 * secant[b])
            }
        })
        .collect()
}

impl Line {
    fn new(rows: &[Row], geometry: &PairGeometry) -> Result<Line, TableError> {
        let (z_ref, base_radius) = (geometry.z_ref(), geometry.gears[0].base_radius());
        if let Some([low, high]) = neighbours(rows, |low, high| high.values[4] <= low.values[4]) {
            return refused(format!(
                "line {}: ste_loa_um = {} at {} is not above ste_loa_um = {} at torque_nm = {} (line {}); the displacement must \
             rise with the load, so correct or remove this sample",
                high.line,
                brief(high.values[4]),
                describe(high.values),
                brief(low.values[4]),
                brief(low.values[0]),
                low.line
            ));
        }
        let mut delta: Vec<f64> = rows.iter().map(|r| 1e-6 * r.values[4]).collect();
        let mut force: Vec<f64> = rows.iter().map(|r| r.values[0] / base_radius).collect();
        let mut lever: Vec<f64> = rows.iter().map(|r| 1e-3 * r.values[5] - z_ref).collect();
        if force[0] > 0.0 {
            let touch = delta[0] - force[0] * (delta[1] - delta[0]) / (force[1] - force[0]);
            delta.insert(0, touch);
            force.insert(0, 0.0);
            lever.insert(0, lever[0]);
        }
        let slope = monotone_slopes(&delta, &force);
        Ok(Line {
            delta,
            force,
            slope,
            lever,
        })
    }

    /// Force and lever at a displacement inside the samples.
    fn at(&self, delta: f64) -> (f64, f64) {
        let n = self.delta.len();
        let i = self.delta.partition_point(|&d| d <= delta).clamp(1, n - 1) - 1;
        let h = self.delta[i + 1] - self.delta[i];
        let t = (delta - self.delta[i]) / h;
        let s = 1.0 - t;
        let force = self.force[i] * s * s * (1.0 + 2.0 * t)
            + self.force[i + 1] * t * t * (1.0 + 2.0 * s)
            + h * t * s * (self.slope[i] * s - self.slope[i + 1] * t);
        (force, self.lever[i] * s + self.lever[i + 1] * t)
    }
}

#[cfg(test)]
#[path = "import_tests.rs"]
mod tests;
