//! Mesh cycles as JSON and, for spreadsheets, scripts and rotor programs, as CSV files with a row per thing.
//!
//! docs/contact-results.md has every key and column.

use std::f64::consts::TAU;
use std::path::Path;

use gearmesh::contact::RootPoint;
use gearmesh::gear::PairGeometry;
use gearmesh_preprocessor::contact::{FaceLoad, HARMONICS, Harmonic, ToothRoot, harmonics};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::shaft::AtNode;
use gearmesh_preprocessor::static_contact::{ContactSolver, SegmentLoad};
use gearmesh_preprocessor::{NominalRootStress, pair};
use serde_json::{Map, Value, json};

use crate::case::{Case, bearing_columns, bearings, details, load, on_shafts, summary};
use crate::columns::{Column, columns, csv, lists, object};
use crate::error::Result;
use crate::output;

use crate::revolution;

/// Names of the files in the folder, of those of root stress, and of those of shafts on bearings.
const NAMES: [&str; 5] = [
    "load-distribution.csv",
    "mesh-cycle.csv",
    "stiffness.csv",
    "face-load.csv",
    "summary.csv",
];
const ROOT_NAMES: [&str; 2] = ["root-stress.csv", "root-stress-field.csv"];
const SHAFT_NAMES: [&str; 3] = ["bearings.csv", "shafts.csv", "shaft-closing.csv"];
/// Of turns of bodies that are no solids of revolution.
const REVOLUTION_NAMES: [&str; 2] = ["revolution.csv", "revolution-orders.csv"];

/// Refuses a folder that cannot take the files, those of root stress, shafts and turns if there are any, and makes it if it is not there.
pub fn check(folder: &Path, root_stress: bool, shafts: bool, turns: bool) -> Result<()> {
    output::make_folder("--output", folder)?;
    let roots = ROOT_NAMES.iter().filter(|_| root_stress);
    let of_shafts = SHAFT_NAMES.iter().filter(|_| shafts);
    let of_turns = REVOLUTION_NAMES.iter().filter(|_| turns);
    for name in NAMES.iter().chain(roots).chain(of_shafts).chain(of_turns) {
        output::check_writable(&folder.join(name), [] as [&Path; 0])?;
    }
    Ok(())
}

pub fn write(folder: &Path, solver: &ContactSolver, pair: &Pair, cases: &[Case]) -> Result<()> {
    let geometry = solver.geometry();
    let mut pairs: Vec<i32> = cases.iter().flat_map(|c| c.cycle.tooth_pairs()).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut row = summary(solver);
    row.extend(on_shafts(cases.first()));
    row.extend(harmonic_columns());
    let mut names = NAMES.to_vec();
    let mut tables = vec![
        csv(&load(), &distribution(geometry), cases, segments)?,
        csv(&load(), &positions(&pairs), cases, at_positions)?,
        csv(&load(), &stiffness(geometry), cases, at_positions)?,
        csv(&load(), &face_load(), cases, stations)?,
        csv(&load(), &row, cases, |case| [case])?,
    ];
    if cases.iter().any(|case| case.roots.is_some()) {
        tables.push(csv(&load(), &root_stress(), cases, loaded_teeth)?);
        tables.push(csv(&load(), &root_field(), cases, largest_fields)?);
        names.extend(ROOT_NAMES);
    }
    if cases.iter().any(|case| case.shafts.is_some()) {
        tables.push(csv(&load(), &bearing_columns(), cases, |case| {
            (case.shafts.as_ref()).map_or(vec![], |s| bearings(pair, s))
        })?);
        tables.push(csv(&load(), &axis_columns(), cases, axes)?);
        tables.push(csv(&load(), &closing_columns(), cases, closings)?);
        names.extend(SHAFT_NAMES);
    }
    if cases.iter().any(|case| !case.revolutions.is_empty()) {
        let of_turn = revolution::all_positions;
        tables.push(csv(&load(), &revolution::positions(), cases, of_turn)?);
        let of_turn = revolution::all_orders;
        tables.push(csv(&load(), &revolution::orders(), cases, of_turn)?);
        names.extend(REVOLUTION_NAMES);
    }
    for (name, table) in names.iter().zip(tables) {
        output::write_whole(&folder.join(name), &table)?;
    }
    Ok(())
}

/// A case as `--json` prints it, with the losses at `speeds` of gear 1, rpm.
pub fn json(
    solver: &ContactSolver,
    pair: &Pair,
    case: &Case,
    speeds: &[f64],
) -> Map<String, Value> {
    let cycle = &case.cycle;
    let pairs = cycle.tooth_pairs();
    let mut json = object(&load(), &case);
    json.extend(object(&summary(solver), &case));
    json.extend(object(&on_shafts(Some(case)), &case));
    json.extend(object(&details(solver), &case));
    let rows: Vec<At> = at_positions(case).collect();
    json.extend(lists(&positions(&[]), &rows));
    let mut more = |name: &str, value: Value| json.insert(name.into(), value);
    let shares: Vec<Vec<f64>> = (0..cycle.results.len())
        .map(|i| pairs.iter().map(|&k| case.share(i, k)).collect())
        .collect();
    more("load_share", json!(shares));
    more("tooth_pairs", json!(pairs));
    more("solve_seconds", json!(cycle.solve_seconds));
    more("notes", json!(notes(pair, case)));
    for (k, (_, of, unit)) in HARMONIC_LISTS.into_iter().enumerate() {
        let all = harmonics_of(case, k);
        let amplitudes = all.map(|h| h.map(|h| h.amplitude));
        let phases = all.map(|h| h.map(|h| h.phase));
        more(&format!("{of}harmonics_{unit}"), json!(amplitudes));
        more(&format!("{of}harmonics_phase_rad"), json!(phases));
    }
    let FaceLoad { z, load } = &case.face_load;
    more("face_z_mm", z.iter().map(|z| 1e3 * z).collect());
    more(
        "face_load_n_per_mm",
        load.iter().map(|load| 1e-3 * load).collect(),
    );
    if let Some(state) = &case.shafts {
        let bearings = bearings(pair, state);
        let rows = bearings.iter().map(|row| object(&bearing_columns(), row));
        more("bearings", rows.collect());
        more(
            "shaft_closing_z_mm",
            state.z.iter().map(|z| 1e3 * z).collect(),
        );
        let closing = state.closing.iter().map(|m| 1e6 * m);
        more("shaft_closing_um", closing.collect());
    }
    if let Some(gears) = &case.roots {
        let positions = cycle.results.len();
        let over_cycle = |stress: fn(&ToothRoot) -> Option<f64>| {
            let [one, two] = gears
                .each_ref()
                .map(|g| g.over_cycle(positions, |tooth| Some(1e-6 * stress(tooth)?)));
            json!([one, two])
        };
        more("root_stress_mpa", over_cycle(|t| Some(t.largest.stress)));
        let at_tangent = over_cycle(|t| Some(t.at_tangent?.stress));
        more("root_stress_at_tangent_mpa", at_tangent);
        let largest = [0, 1].map(|i| {
            let tooth = object(&root_stress(), &largest_tooth(case, i)?);
            let renamed = tooth.into_iter().map(|(name, value)| {
                let name = name.trim_start_matches("root_");
                (name.replace("stress_at", "at"), value)
            });
            Some(renamed.collect::<Map<_, _>>())
        });
        more("largest_root_stress", json!(largest));
        let nominal = [0, 1].map(|i| Some(object(&nominal(), &nominal_stress(solver, case, i)?)));
        more("iso_6336_3", json!(nominal));
    }
    json.extend(lists(&losses(pair, case), speeds));
    if !case.revolutions.is_empty() {
        json.insert("revolutions".into(), revolution::json(case));
    }
    json
}

pub fn notes(pair: &Pair, case: &Case) -> Vec<String> {
    let on_teeth = pair::note_on_teeth(&pair.teeth).map(String::from);
    let elasticity = case.cycle.note_on_elasticity(&pair.geometry);
    let held = pair
        .warnings
        .iter()
        .find(|note| note.contains(pair::ASSUMED_HELD));
    let segments = case.cycle.note_on_segments();
    let on_offset = pair::notes_on_offset(&pair.geometry, case.input.center_distance_offset);
    let notes = [on_teeth, elasticity, segments, held.cloned()];
    notes.into_iter().flatten().chain(on_offset).collect()
}

type At<'a> = (usize, &'a Case);

pub fn at_positions(case: &Case) -> impl Iterator<Item = At<'_>> {
    (0..case.cycle.results.len()).map(move |i| (i, case))
}

pub fn positions<'r>(pairs: &[i32]) -> Vec<Column<'static, At<'r>>> {
    let mut columns = columns! { |(i, c): &At|
        "mesh_position", ["mesh", "position", 4] => c.cycle.mesh_position[*i];
        "ste_loa_um", ["STE (loa)", "um", 4] => 1e6 * c.cycle.results[*i].approach;
        "contact_z_mm", ["z_c", "mm", 4] => 1e3 * c.cycle.results[*i].contact_z;
        "maximum_pressure_mpa", ["p_max", "MPa", 1] => 1e-6 * c.cycle.results[*i].max_pressure;
        "edge_line_load_n_per_mm", ["tip edge", "N/mm", 1] => c.cycle.results[*i].edge_load.map_or(0.0, |edge| 1e-3 * edge.line_load);
        "edge_gear" => c.cycle.results[*i].edge_load.map(|edge| edge.gear + 1);
        "edge_z_mm" => c.cycle.results[*i].edge_load.map(|edge| 1e3 * edge.z);
        "mesh_stiffness_loa_n_per_m" => c.cycle.results[*i].tangent.force_by_approach;
    };
    for &k in pairs {
        columns.extend(columns! { |(i, c): &At|
            format!("load_share_{k}"), [format!("pair {k}"), "share", 4] => c.share(*i, k);
        });
    }
    columns
}

/// Mesh stiffness over the phase, as rotor programs take it.
fn stiffness<'r>(geometry: &PairGeometry) -> Vec<Column<'static, At<'r>>> {
    let [rb, teeth] = [geometry.gears[0].base_radius(), geometry.gears[0].z()];
    let cos_beta_b = geometry.base_helix_angle().cos();
    let per_normal = 1.0 / (cos_beta_b * cos_beta_b);
    columns! { |(i, c): &At|
        "mesh_position" => c.cycle.mesh_position[*i];
        "phase_rad" => TAU * c.cycle.mesh_position[*i];
        "gear1_angle_deg" => 360.0 * c.cycle.mesh_position[*i] / teeth;
        "stiffness_loa_n_per_m" => c.cycle.results[*i].tangent.force_by_approach;
        "stiffness_normal_n_per_m" => per_normal * c.cycle.results[*i].tangent.force_by_approach;
        "torsional_stiffness_gear1_nm_per_rad" => rb * rb * c.cycle.results[*i].tangent.force_by_approach;
    }
}

type AtSegment<'a> = (At<'a>, &'a SegmentLoad);

fn segments(case: &Case) -> impl Iterator<Item = AtSegment<'_>> {
    at_positions(case).flat_map(|at| {
        case.cycle.results[at.0]
            .segments
            .iter()
            .map(move |s| (at, s))
    })
}

fn distribution<'s, 'r>(geometry: &'s PairGeometry) -> Vec<Column<'s, AtSegment<'r>>> {
    let cos_beta_b = geometry.base_helix_angle().cos();
    let [one, two] = &geometry.gears;
    columns! { |((i, c), s): &AtSegment|
        "mesh_position" => c.cycle.mesh_position[*i];
        "tooth_pair" => s.tooth_pair;
        "z_mm" => 500.0 * (s.z[0] + s.z[1]);
        "roll1_mm" => 1e3 * s.roll[0];
        "roll2_mm" => 1e3 * s.roll[1];
        "diameter1_mm" => 2e3 * one.radius_at_roll(s.roll[0]);
        "diameter2_mm" => 2e3 * two.radius_at_roll(s.roll[1]);
        "force_n" => s.force;
        "line_load_n_per_mm" => 1e-3 * s.line_load(cos_beta_b);
        "pressure_mpa" => 1e-6 * s.pressure;
        "edge_line_load_n_per_mm" => s.edge.map_or(0.0, |edge| 1e-3 * edge.line_load);
        "gap_um" => 1e6 * s.gap;
    }
}

type OnAxis = (usize, f64, AtNode);

fn axes(case: &Case) -> Vec<OnAxis> {
    let axes = case
        .shafts
        .iter()
        .flat_map(|state| state.axes.iter().enumerate());
    let points = axes.flat_map(|(gear, axis)| axis.iter().map(move |(z, at)| (gear + 1, *z, *at)));
    points.collect()
}

fn axis_columns() -> Vec<Column<'static, OnAxis>> {
    columns! { |(gear, z, at): &OnAxis|
        "gear" => *gear;
        "z_mm" => 1e3 * z;
        "x_um" => 1e6 * at.linear[0];
        "y_um" => 1e6 * at.linear[1];
        "axial_um" => 1e6 * at.linear[2];
        "tilt_x_mrad" => 1e3 * at.angular[0];
        "tilt_y_mrad" => 1e3 * at.angular[1];
        "twist_mrad" => 1e3 * at.angular[2];
    }
}

/// z, what the shafts close there, and torsion of that, m.
fn closings(case: &Case) -> Vec<[f64; 3]> {
    case.shafts
        .as_ref()
        .map(|state| {
            let values = state.closing.iter().zip(&state.torsion);
            let rows = state
                .z
                .iter()
                .zip(values)
                .map(|(z, (all, torsion))| [*z, *all, *torsion]);
            rows.collect()
        })
        .unwrap_or_default()
}

fn closing_columns() -> Vec<Column<'static, [f64; 3]>> {
    columns! { |row: &[f64; 3]|
        "z_mm" => 1e3 * row[0];
        "closing_um" => 1e6 * row[1];
        "torsion_um" => 1e6 * row[2];
    }
}

/// z and load per face width of the stations along the face, m and N/m.
fn stations(case: &Case) -> Vec<(f64, f64)> {
    let FaceLoad { z, load } = &case.face_load;
    z.iter().copied().zip(load.iter().copied()).collect()
}

fn face_load() -> Vec<Column<'static, (f64, f64)>> {
    columns! { |(z, load): &(f64, f64)|
        "z_mm" => 1e3 * z;
        "face_load_n_per_mm" => 1e-3 * load;
    }
}

/// What has harmonics: the beginning of its names in CSV and in JSON, and the unit of the amplitudes.
const HARMONIC_LISTS: [(&str, &str, &str); 2] = [
    ("ste", "", "loa_um"),
    ("mesh_stiffness", "mesh_stiffness_", "loa_n_per_m"),
];

fn harmonics_of(case: &Case, k: usize) -> [Option<Harmonic>; HARMONICS] {
    let cycle = &case.cycle;
    match k {
        0 => harmonics(&cycle.ste().iter().map(|ste| 1e6 * ste).collect::<Vec<_>>()),
        _ => harmonics(&cycle.stiffness()),
    }
}

/// Harmonics in a row; those that the positions cannot resolve stay empty.
fn harmonic_columns<'r>() -> Vec<Column<'static, &'r Case>> {
    let mut columns = Vec::new();
    for (k, (of, _, unit)) in HARMONIC_LISTS.into_iter().enumerate() {
        for order in 1..=HARMONICS {
            columns.extend(columns! { |c: &&Case|
                format!("{of}_harmonic_{order}_{unit}") => harmonics_of(c, k)[order - 1].map(|h| h.amplitude);
                format!("{of}_phase_{order}_rad") => harmonics_of(c, k)[order - 1].map(|h| h.phase);
            });
        }
    }
    columns
}

/// Losses of a mesh cycle at speeds of gear 1; the coefficient times `loss_factor` and the transmitted power is the loss.
pub fn losses<'c>(pair: &'c Pair, case: &'c Case) -> Vec<Column<'c, f64>> {
    columns! { |rpm: &f64|
        "speed_rpm", ["speed", "rpm", None] => *rpm;
        "loss_w", ["loss", "W", 2] => case.loss(pair, *rpm).power;
        "efficiency", ["efficiency", "", 5] => case.loss(pair, *rpm).efficiency;
        "friction_coefficient", ["friction", "coefficient", 4] => case.loss(pair, *rpm).coefficient;
    }
}

pub struct Tooth<'a> {
    case: &'a Case,
    gear: usize,
    root: &'a ToothRoot,
}

fn loaded_teeth(case: &Case) -> impl Iterator<Item = Tooth<'_>> {
    let gears = case.roots.iter().flatten().enumerate();
    gears.flat_map(move |(gear, roots)| {
        let teeth = roots.teeth.iter();
        teeth.map(move |root| Tooth { case, gear, root })
    })
}

/// The tooth of gear `gear` with the largest root stress of the cycle; None without load.
pub fn largest_tooth(case: &Case, gear: usize) -> Option<Tooth<'_>> {
    let root = case.roots.as_ref()?[gear].largest()?;
    Some(Tooth { case, gear, root })
}

pub fn root_stress<'r>() -> Vec<Column<'static, Tooth<'r>>> {
    columns! { |t: &Tooth|
        "mesh_position", ["mesh", "position", 4] => t.case.cycle.mesh_position[t.root.position];
        "gear", ["gear", "", None] => t.gear + 1;
        "tooth_pair", ["pair", "", None] => t.root.tooth_pair;
        "load_share", ["load", "share", 4] => t.case.share(t.root.position, t.root.tooth_pair);
        "root_stress_mpa", ["root stress", "MPa", 1] => 1e-6 * t.root.largest.stress;
        "z_mm", ["at z", "mm", 2] => 1e3 * t.root.largest.z;
        "diameter_mm", ["diameter", "mm", 3] => 2e3 * t.root.largest.radius;
        "tangent_deg", ["tangent", "deg", 0] => t.root.largest.tangent.to_degrees();
        "root_stress_at_tangent_mpa", ["at tangent", "MPa", 1] => t.root.at_tangent.map(|point| 1e-6 * point.stress);
        "at_tangent_z_mm" => t.root.at_tangent.map(|point| 1e3 * point.z);
    }
}

/// The points of the fillets of the teeth with the largest root stress, each after its tooth.
fn largest_fields(case: &Case) -> Vec<(Tooth<'_>, &RootPoint)> {
    let mut all = Vec::new();
    for (i, gear) in case.roots.iter().flatten().enumerate() {
        let points = gear.field.iter().flatten();
        all.extend(points.filter_map(|point| Some((largest_tooth(case, i)?, point))));
    }
    all
}

fn root_field<'r>() -> Vec<Column<'static, (Tooth<'r>, &'r RootPoint)>> {
    columns! { |(t, point): &(Tooth, &RootPoint)|
        "gear" => t.gear + 1;
        "mesh_position" => t.case.cycle.mesh_position[t.root.position];
        "tooth_pair" => t.root.tooth_pair;
        "z_mm" => 1e3 * point.z;
        "diameter_mm" => 2e3 * point.radius;
        "tangent_deg" => point.tangent.to_degrees();
        "root_stress_mpa" => 1e-6 * point.stress;
    }
}

pub fn nominal_stress(solver: &ContactSolver, case: &Case, i: usize) -> Option<NominalRootStress> {
    NominalRootStress::new(solver.geometry(), i, case.load.torque)
}

/// Terms of ISO 6336-3:2006, method B.
pub fn nominal() -> Vec<Column<'static, NominalRootStress>> {
    columns! { |n: &NominalRootStress|
        "sigma_f0_mpa", ["sigma_F0", "MPa", 1] => 1e-6 * n.stress;
        "y_f", ["Y_F", "", 3] => n.form_factor;
        "y_s", ["Y_S", "", 3] => n.correction_factor;
        "y_beta", ["Y_beta", "", 3] => n.helix_factor;
        "y_b", ["Y_B", "", 3] => n.rim_factor;
        "virtual_teeth" => n.virtual_teeth;
        "virtual_contact_ratio" => n.virtual_contact_ratio;
        "load_angle_deg" => n.section.load_angle.to_degrees();
        "h_fe_over_module" => n.section.lever_arm;
        "s_fn_over_module" => n.section.chord;
        "rho_f_over_module" => n.section.fillet_radius;
    }
}
