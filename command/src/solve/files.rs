//! `--output FOLDER`: mesh cycles as CSV files, one row per thing, for spreadsheets, scripts and rotor programs.
//!
//! docs/contact-results.md has every column.

use std::path::Path;

use gearmesh::contact::SegmentLoad;
use gearmesh::gear::PairGeometry;
use gearmesh_preprocessor::contact::MeshCycle;
use gearmesh_preprocessor::finite_element::RootPoint;

use super::report::Report;
use super::roots::{Place, Roots};
use crate::Error;
use crate::columns::{Column, column, maybe};
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
    let mut pairs: Vec<i32> = reports.iter().flat_map(|r| r.tooth_pairs.clone()).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let at = |r, count| (0..count).map(move |i| (r, i));
    let position = || reports.iter().map(|r| (r, at(r, r.mesh_position.len())));
    let station = reports.iter().map(|r| (r, at(r, r.face_z_mm.len())));
    let strip = reports.iter().zip(cycles.iter().map(|cycle| {
        let positions = cycle.mesh_position.iter().zip(&cycle.loads);
        positions.flat_map(|(tau, strips)| strips.iter().map(|strip| (*tau, strip)))
    }));
    let mut tables = vec![
        csv(&distribution(geometry), strip)?,
        csv(&positions(&pairs), position())?,
        csv(&stiffness(geometry), position())?,
        csv(&face_load(), station)?,
        csv(&summary(), reports.iter().map(|r| (r, [r])))?,
    ];
    if reports.iter().any(|report| report.roots.is_some()) {
        let teeth = reports
            .iter()
            .map(|r| (r, r.roots.iter().flat_map(|of| &of.rows)));
        tables.push(csv(&roots(), teeth)?);
        let points = reports
            .iter()
            .map(|r| (r, r.roots.iter().flat_map(Roots::largest_fields)));
        tables.push(csv(&root_field(), points)?);
    }
    for (name, table) in NAMES.iter().zip(tables) {
        output::write_whole(&folder.join(name), &table)?;
    }
    Ok(())
}

/// A CSV file of the rows of every load, each after its load.
fn csv<'a, T, Rows: IntoIterator<Item = T>>(
    columns: &[Column<T>],
    loads: impl Iterator<Item = (&'a Report, Rows)>,
) -> Result<Vec<u8>, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = columns.iter().map(|column| column.name.as_str());
    writer.write_record(["torque_nm", "misalignment_mrad"].into_iter().chain(names))?;
    for (load, rows) in loads {
        let load = [load.torque_nm, load.misalignment_mrad].map(|value| value.to_string());
        for row in rows {
            let fields = columns.iter().map(|column| column.field(&row));
            writer.write_record(load.iter().cloned().chain(fields))?;
        }
    }
    Ok(writer.into_inner()?)
}

/// Line load, pressure and gap of a strip at a mesh position.
fn distribution(geometry: &PairGeometry) -> Vec<Column<'_, (f64, &SegmentLoad)>> {
    type Row<'a> = (f64, &'a SegmentLoad);
    let cos_beta_b = geometry.base_helix_angle().cos();
    let diameter = |i: usize| move |(_, s): &Row| 2e3 * geometry.gears[i].radius_at_roll(s.roll[i]);
    vec![
        column("mesh_position", |(tau, _): &Row| *tau),
        column("tooth_pair", |(_, s): &Row| s.tooth_pair.into()),
        column("z_mm", |(_, s): &Row| 500.0 * (s.z[0] + s.z[1])),
        column("roll1_mm", |(_, s): &Row| 1e3 * s.roll[0]),
        column("roll2_mm", |(_, s): &Row| 1e3 * s.roll[1]),
        column("diameter1_mm", diameter(0)),
        column("diameter2_mm", diameter(1)),
        column("force_n", |(_, s): &Row| s.force),
        column("line_load_n_per_mm", move |(_, s): &Row| {
            1e-3 * s.line_load(cos_beta_b)
        }),
        column("pressure_mpa", |(_, s): &Row| 1e-6 * s.pressure),
        column("edge_line_load_n_per_mm", |(_, s): &Row| {
            s.edge.map_or(0.0, |edge| 1e-3 * edge.line_load)
        }),
        column("gap_um", |(_, s): &Row| 1e6 * s.gap),
    ]
}

/// A report and the number of a position or station in it.
type At<'a> = (&'a Report, usize);

/// The cycle position by position, with the shares of the tooth pairs `pairs`.
pub fn positions(pairs: &[i32]) -> Vec<Column<'_, At<'_>>> {
    let mut columns = vec![
        column("mesh_position", |(r, i): &At| r.mesh_position[*i]).shown(
            "mesh",
            "position",
            9,
            Some(4),
        ),
        column("ste_loa_um", |(r, i): &At| r.ste_loa_um[*i]).shown("STE (loa)", "um", 11, Some(4)),
        column("contact_z_mm", |(r, i): &At| r.contact_z_mm[*i]).shown("z_c", "mm", 9, Some(4)),
        column("maximum_pressure_mpa", |(r, i): &At| {
            r.maximum_pressure_mpa[*i]
        })
        .shown("p_max", "MPa", 9, Some(1)),
        column("edge_line_load_n_per_mm", |(r, i): &At| {
            r.edge_line_load_n_per_mm[*i]
        })
        .shown("tip edge", "N/mm", 9, Some(1)),
        column("mesh_stiffness_loa_n_per_m", |(r, i): &At| {
            r.mesh_stiffness_loa_n_per_m[*i]
        }),
    ];
    columns.extend(pairs.iter().map(|k| {
        let share = move |(r, i): &At| {
            let at = r.tooth_pairs.iter().position(|pair| pair == k);
            at.map_or(0.0, |at| r.load_share[*i][at])
        };
        column(format!("load_share_{k}"), share).shown(format!("pair {k}"), "share", 8, Some(4))
    }));
    columns
}

/// Mesh stiffness over the phase, as rotor programs take it.
fn stiffness(geometry: &PairGeometry) -> Vec<Column<'_, At<'_>>> {
    let gear = &geometry.gears[0];
    let cos_beta_b = geometry.base_helix_angle().cos();
    let rb = gear.base_radius();
    let k = |(r, i): &At| r.mesh_stiffness_loa_n_per_m[*i];
    vec![
        column("mesh_position", |(r, i): &At| r.mesh_position[*i]),
        column("phase_rad", |(r, i): &At| {
            std::f64::consts::TAU * r.mesh_position[*i]
        }),
        column("gear1_angle_deg", |(r, i): &At| {
            360.0 * r.mesh_position[*i] / gear.z()
        }),
        column("stiffness_loa_n_per_m", k),
        column("stiffness_normal_n_per_m", move |at: &At| {
            k(at) / (cos_beta_b * cos_beta_b)
        }),
        column("torsional_stiffness_gear1_nm_per_rad", move |at: &At| {
            k(at) * rb * rb
        }),
    ]
}

fn face_load<'r>() -> Vec<Column<'static, At<'r>>> {
    vec![
        column("z_mm", |(r, i): &At| r.face_z_mm[*i]),
        column("face_load_n_per_mm", |(r, i): &At| r.face_load_n_per_mm[*i]),
    ]
}

/// Root stress of a tooth under load at a position.
fn roots<'r>() -> Vec<Column<'static, &'r Place>> {
    type Row<'a> = &'a Place;
    vec![
        column("mesh_position", |p: &Row| p.mesh_position),
        column("gear", |p: &Row| p.gear as f64),
        column("tooth_pair", |p: &Row| p.tooth_pair.into()),
        column("load_share", |p: &Row| p.load_share),
        column("root_stress_mpa", |p: &Row| p.stress_mpa),
        column("z_mm", |p: &Row| p.z_mm),
        column("diameter_mm", |p: &Row| p.diameter_mm),
        column("tangent_deg", |p: &Row| p.tangent_deg),
        maybe("root_stress_at_tangent_mpa", |p: &Row| p.at_tangent_mpa),
        maybe("at_tangent_z_mm", |p: &Row| p.at_tangent_z_mm),
    ]
}

/// The fillet of a tooth with the largest root stress of its gear.
fn root_field<'r>() -> Vec<Column<'static, (&'r Place, &'r RootPoint)>> {
    type Row<'a> = (&'a Place, &'a RootPoint);
    vec![
        column("gear", |(tooth, _): &Row| tooth.gear as f64),
        column("mesh_position", |(tooth, _): &Row| tooth.mesh_position),
        column("tooth_pair", |(tooth, _): &Row| tooth.tooth_pair.into()),
        column("z_mm", |(_, point): &Row| 1e3 * point.z),
        column("diameter_mm", |(_, point): &Row| 2e3 * point.radius),
        column("tangent_deg", |(_, point): &Row| point.tangent.to_degrees()),
        column("root_stress_mpa", |(_, point): &Row| 1e-6 * point.stress),
    ]
}

/// One load; harmonics that the positions cannot tell apart stay empty.
fn summary<'r>() -> Vec<Column<'static, &'r Report>> {
    type Row<'a> = &'a Report;
    let mut columns = vec![
        column("mean_ste_loa_um", |r: &Row| r.mean_ste_loa_um),
        column("peak_to_peak_ste_loa_um", |r: &Row| {
            r.peak_to_peak_ste_loa_um
        }),
        column("maximum_pressure_mpa", |r: &Row| r.largest_pressure()),
        column("edge_line_load_n_per_mm", |r: &Row| r.largest_edge_load()),
        column("face_load_factor", |r: &Row| r.face_load_factor),
        column("mean_mesh_stiffness_loa_n_per_m", |r: &Row| {
            r.mean_mesh_stiffness_loa_n_per_m
        }),
    ];
    type List = fn(&Report) -> &[Option<f64>];
    let harmonics: [(_, _, List, List); 2] = [
        (
            "ste",
            "loa_um",
            |r| &r.harmonics_loa_um,
            |r| &r.harmonics_phase_rad,
        ),
        (
            "mesh_stiffness",
            "loa_n_per_m",
            |r| &r.mesh_stiffness_harmonics_loa_n_per_m,
            |r| &r.mesh_stiffness_harmonics_phase_rad,
        ),
    ];
    for (of, unit, amplitude, phase) in harmonics {
        for i in 0..gearmesh_preprocessor::contact::HARMONICS {
            let order = i + 1;
            let amplitude = move |r: &Row| amplitude(r)[i];
            columns.push(maybe(format!("{of}_harmonic_{order}_{unit}"), amplitude));
            columns.push(maybe(format!("{of}_phase_{order}_rad"), move |r: &Row| {
                phase(r)[i]
            }));
        }
    }
    columns
}
