//! `--output FOLDER`: mesh cycles as CSV files, one row per thing, for spreadsheets, scripts and rotor programs.
//!
//! docs/contact-results.md has every column.

use std::fmt::Display;
use std::path::Path;

use gearmesh::contact::MeshCycle;
use gearmesh::gear::PairGeometry;

use super::report::Report;
use crate::Error;
use crate::output;

/// Names of the files in the folder, in the order in which they are written; those from [`ALWAYS`] on only where root
/// stress is asked for.
const NAMES: [&str; 7] = [
    "load-distribution.csv",
    "mesh-cycle.csv",
    "stiffness.csv",
    "face-load.csv",
    "summary.csv",
    "root-stress.csv",
    "root-stress-field.csv",
];

/// Files of every run.
const ALWAYS: usize = 5;

/// Refuses a folder that cannot take the files, those of root stress if it is asked for, and makes it if it is not there.
pub fn check(folder: &Path, root_stress: bool) -> Result<(), Error> {
    output::make_folder("--output", folder)?;
    let count = if root_stress { NAMES.len() } else { ALWAYS };
    for name in &NAMES[..count] {
        output::check_writable(&folder.join(name), &[])?;
    }
    Ok(())
}

/// Writes all files into `folder`.
pub fn write(
    folder: &Path,
    geometry: &PairGeometry,
    cycles: &[MeshCycle],
    reports: &[Report],
) -> Result<(), Error> {
    let mut tables = vec![
        distribution(geometry, cycles, reports)?,
        positions(reports)?,
        stiffness(geometry, reports)?,
        face_load(reports)?,
        summary(cycles, reports)?,
    ];
    if reports.iter().any(|report| report.roots.is_some()) {
        tables.push(roots(reports)?);
        tables.push(root_field(reports)?);
    }
    for (name, table) in NAMES.iter().zip(tables) {
        output::write_whole(&folder.join(name), &table)?;
    }
    Ok(())
}

/// Rows of a CSV file, each beginning with its load.
struct Table(csv::Writer<Vec<u8>>);

impl Table {
    fn new(columns: &[&str]) -> Result<Table, Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(["torque_nm", "misalignment_mrad"].iter().chain(columns))?;
        Ok(Table(writer))
    }

    fn row(&mut self, load: &Report, values: &[&dyn Display]) -> Result<(), Error> {
        let load: [&dyn Display; 2] = [&load.torque_nm, &load.misalignment_mrad];
        let fields = load.iter().chain(values).map(ToString::to_string);
        Ok(self.0.write_record(fields)?)
    }

    fn finish(self) -> Result<Vec<u8>, Error> {
        Ok(self.0.into_inner()?)
    }
}

/// A number where there is one.
struct Maybe(Option<f64>);

impl Display for Maybe {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.map_or(Ok(()), |value| value.fmt(f))
    }
}

/// Line load, pressure and gap of every strip.
fn distribution(
    geometry: &PairGeometry,
    cycles: &[MeshCycle],
    reports: &[Report],
) -> Result<Vec<u8>, Error> {
    let mut table = Table::new(&[
        "mesh_position",
        "tooth_pair",
        "z_mm",
        "roll1_mm",
        "roll2_mm",
        "diameter1_mm",
        "diameter2_mm",
        "force_n",
        "line_load_n_per_mm",
        "pressure_mpa",
        "edge_line_load_n_per_mm",
        "gap_um",
    ])?;
    let cos_beta_b = geometry.base_helix_angle().cos();
    for (cycle, report) in cycles.iter().zip(reports) {
        for (position, strips) in cycle.mesh_position.iter().zip(&cycle.loads) {
            for strip in strips {
                let diameter = |i: usize| 2e3 * geometry.gears[i].radius_at_roll(strip.roll[i]);
                table.row(
                    report,
                    &[
                        position,
                        &strip.tooth_pair,
                        &(500.0 * (strip.z[0] + strip.z[1])),
                        &(1e3 * strip.roll[0]),
                        &(1e3 * strip.roll[1]),
                        &diameter(0),
                        &diameter(1),
                        &strip.force,
                        &(1e-3 * strip.line_load(cos_beta_b)),
                        &(1e-6 * strip.pressure),
                        &strip.edge.map_or(0.0, |edge| 1e-3 * edge.line_load),
                        &(1e6 * strip.gap),
                    ],
                )?;
            }
        }
    }
    table.finish()
}

/// One row per position, and the share of every tooth pair that any of the loads has.
fn positions(reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut pairs: Vec<i32> = reports
        .iter()
        .flat_map(|r| &r.tooth_pairs)
        .copied()
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let shares: Vec<String> = pairs.iter().map(|k| format!("load_share_{k}")).collect();
    let fixed = [
        "mesh_position",
        "ste_loa_um",
        "contact_z_mm",
        "maximum_pressure_mpa",
        "edge_line_load_n_per_mm",
        "mesh_stiffness_loa_n_per_m",
    ];
    let columns: Vec<&str> = fixed
        .into_iter()
        .chain(shares.iter().map(String::as_str))
        .collect();
    let mut table = Table::new(&columns)?;
    for r in reports {
        for i in 0..r.mesh_position.len() {
            let share = |k: &i32| {
                let at = r.tooth_pairs.iter().position(|pair| pair == k);
                at.map_or(0.0, |at| r.load_share[i][at])
            };
            let shares: Vec<f64> = pairs.iter().map(share).collect();
            let mut values: Vec<&dyn Display> = vec![
                &r.mesh_position[i],
                &r.ste_loa_um[i],
                &r.contact_z_mm[i],
                &r.maximum_pressure_mpa[i],
                &r.edge_line_load_n_per_mm[i],
                &r.mesh_stiffness_loa_n_per_m[i],
            ];
            values.extend(shares.iter().map(|share| share as &dyn Display));
            table.row(r, &values)?;
        }
    }
    table.finish()
}

/// Mesh stiffness over the phase, as rotor programs take it.
fn stiffness(geometry: &PairGeometry, reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut table = Table::new(&[
        "mesh_position",
        "phase_rad",
        "gear1_angle_deg",
        "stiffness_loa_n_per_m",
        "stiffness_normal_n_per_m",
        "torsional_stiffness_gear1_nm_per_rad",
    ])?;
    let gear = &geometry.gears[0];
    let cos_beta_b = geometry.base_helix_angle().cos();
    for r in reports {
        for (position, k) in r.mesh_position.iter().zip(&r.mesh_stiffness_loa_n_per_m) {
            table.row(
                r,
                &[
                    position,
                    &(std::f64::consts::TAU * position),
                    &(360.0 * position / gear.z()),
                    k,
                    &(k / (cos_beta_b * cos_beta_b)),
                    &(k * gear.base_radius() * gear.base_radius()),
                ],
            )?;
        }
    }
    table.finish()
}

fn face_load(reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut table = Table::new(&["z_mm", "face_load_n_per_mm"])?;
    for r in reports {
        for (z, load) in r.face_z_mm.iter().zip(&r.face_load_n_per_mm) {
            table.row(r, &[z, load])?;
        }
    }
    table.finish()
}

/// Root stress of every tooth under load at every position.
fn roots(reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut table = Table::new(&[
        "mesh_position",
        "gear",
        "tooth_pair",
        "load_share",
        "root_stress_mpa",
        "z_mm",
        "diameter_mm",
        "tangent_deg",
        "root_stress_at_tangent_mpa",
        "at_tangent_z_mm",
    ])?;
    for report in reports {
        for row in report.roots.iter().flat_map(|roots| &roots.rows) {
            table.row(
                report,
                &[
                    &row.mesh_position,
                    &row.gear,
                    &row.tooth_pair,
                    &row.load_share,
                    &row.stress_mpa,
                    &row.z_mm,
                    &row.diameter_mm,
                    &row.tangent_deg,
                    &Maybe(row.at_tangent_mpa),
                    &Maybe(row.at_tangent_z_mm),
                ],
            )?;
        }
    }
    table.finish()
}

/// The fillets of the teeth with the largest root stress of either gear.
fn root_field(reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut table = Table::new(&[
        "gear",
        "mesh_position",
        "tooth_pair",
        "z_mm",
        "diameter_mm",
        "tangent_deg",
        "root_stress_mpa",
    ])?;
    for report in reports {
        for roots in report.roots.iter() {
            for (largest, field) in roots.largest.iter().zip(&roots.fields) {
                let Some(largest) = largest else { continue };
                for point in field.iter().flatten() {
                    table.row(
                        report,
                        &[
                            &largest.gear,
                            &largest.mesh_position,
                            &largest.tooth_pair,
                            &(1e3 * point.z),
                            &(2e3 * point.radius),
                            &point.tangent.to_degrees(),
                            &(1e-6 * point.stress),
                        ],
                    )?;
                }
            }
        }
    }
    table.finish()
}

/// One row per load; harmonics that the positions cannot tell apart stay empty.
fn summary(cycles: &[MeshCycle], reports: &[Report]) -> Result<Vec<u8>, Error> {
    let mut columns: Vec<String> = [
        "mean_ste_loa_um",
        "peak_to_peak_ste_loa_um",
        "maximum_pressure_mpa",
        "edge_line_load_n_per_mm",
        "face_load_factor",
        "mean_mesh_stiffness_loa_n_per_m",
    ]
    .map(str::to_owned)
    .to_vec();
    for (of, unit) in [("ste", "loa_um"), ("mesh_stiffness", "loa_n_per_m")] {
        for order in 1..=gearmesh::contact::HARMONICS {
            columns.push(format!("{of}_harmonic_{order}_{unit}"));
            columns.push(format!("{of}_phase_{order}_rad"));
        }
    }
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>())?;
    for (cycle, r) in cycles.iter().zip(reports) {
        let amplitudes = r.harmonics_loa_um.iter();
        let amplitudes = amplitudes.chain(&r.mesh_stiffness_harmonics_loa_n_per_m);
        let phases = r.harmonics_phase_rad.iter();
        let phases = phases.chain(&r.mesh_stiffness_harmonics_phase_rad);
        let harmonics: Vec<Maybe> = amplitudes
            .zip(phases)
            .flat_map(|(a, p)| [Maybe(*a), Maybe(*p)])
            .collect();
        let (pressure, edge) = (
            cycle.max_pressure() * 1e-6,
            cycle.edge_load().map_or(0.0, |edge| edge.line_load * 1e-3),
        );
        let mut values: Vec<&dyn Display> = vec![
            &r.mean_ste_loa_um,
            &r.peak_to_peak_ste_loa_um,
            &pressure,
            &edge,
            &r.face_load_factor,
            &r.mean_mesh_stiffness_loa_n_per_m,
        ];
        values.extend(harmonics.iter().map(|h| h as &dyn Display));
        table.row(r, &values)?;
    }
    table.finish()
}
