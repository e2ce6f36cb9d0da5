//! Mesh cycles as text.

use std::fmt::Write;

use gearmesh::pair::Pair;
use gearmesh::words::{count, rounded};
use gearmesh_preprocessor::contact::{CycleInput, MeshCycle};

use super::files::positions;
use super::report::Report;
use crate::columns::{Column, column, maybe, table};
use crate::model::{Fillets, Model};
use crate::output::{Listing, rows};

/// One cycle, position by position.
pub fn one(
    pair: &Pair,
    models: (&Model, &Option<Fillets>),
    input: &CycleInput,
    cycle: &MeshCycle,
    report: &Report,
) -> String {
    let mut text = format!(
        "{}: {} N m on gear 1, {}, misalignment {} mrad\n\n",
        pair.name,
        rounded(input.torque),
        state(input),
        rounded(input.misalignment * 1e3),
    );
    let at_positions = (0..report.mesh_position.len()).map(|i| (report, i));
    text += &table(&positions(&report.tooth_pairs), at_positions);
    text.push_str(
        "\nSTE: static transmission error on the line of action at mid-face, from unmodified flanks that just touch.\n\
         z_c: axial position of the resulting force, from the z = 0 face of gear 1.\n\
         pair k: share of a tooth pair in the load. Pair 0 touches at the pitch point at mid-face at mesh position 0;\n\
         pair 1 is ahead of it by one pitch and leaves the mesh first, pair -1 comes into mesh after it.\n",
    );
    let harmonics: Vec<String> = report
        .harmonics_loa_um
        .iter()
        .map(|h| h.map_or("-".into(), |h| format!("{h:.4}")))
        .collect();
    let edge = cycle.edge_load().map_or("none".into(), |edge| {
        let [line_load, z] = [edge.line_load * 1e-3, edge.z * 1e3];
        format!(
            "{line_load:.1} N/mm, gear {} at z = {z:.2} mm",
            edge.gear + 1
        )
    });
    let mut rows = Listing::default();
    rows! { rows;
        "mean STE" => "{:.4} um", report.mean_ste_loa_um;
        "peak-to-peak STE" => "{:.4} um", report.peak_to_peak_ste_loa_um;
        "largest flank pressure" => "{:.1} MPa", report.largest_pressure();
        "largest line load at a tip edge" => "{edge}";
        "harmonics 1 to 10" => "{} um", harmonics.join(" ");
        "mesh stiffness" => "{:.4e} N/m in the mean, tangent, on the line of action", report.mean_mesh_stiffness_loa_n_per_m;
        "face load factor K_Hbeta" => "{:.3}", report.face_load_factor;
        "transverse contact ratio" => "{:.4}", report.transverse_contact_ratio;
        "overlap ratio" => "{:.4}", report.overlap_ratio;
    }
    report.losses.list(&mut rows);
    if let Some(roots) = &report.roots {
        roots.list(&mut rows);
    }
    rows! { rows; "largest KKT residual" => "{:.1e}", cycle.kkt_residual(); }
    times(&mut rows, models, report.solve_seconds);
    let _ = write!(text, "\n{rows}");
    text + &notes(std::slice::from_ref(report))
}

/// What was used, and what it took; `contact` the time of the contact, s.
fn times(rows: &mut Listing, (model, fillets): (&Model, &Option<Fillets>), contact: f64) {
    rows! { rows;
        "elastic model" => "{}", model.description;
        "time for the elastic model" => "{:.3} s, {}", model.compliance_seconds, model.origin;
    }
    if let Some(f) = fillets {
        rows! { rows; "time for the model of the fillets" => "{:.3} s, {}", f.seconds, f.origin; }
    }
    rows! { rows; "time for the contact" => "{contact:.3} s"; }
}

/// What is to be known of the results, each sentence with the loads that it is about if it is not about all.
fn notes(reports: &[Report]) -> String {
    let mut text = String::new();
    let mut told: Vec<&str> = vec![];
    for note in reports.iter().flat_map(|report| &report.notes) {
        if told.contains(&note.as_str()) {
            continue;
        }
        told.push(note);
        let about = reports.iter().filter(|report| report.notes.contains(note));
        let about: Vec<String> = about
            .map(|r| format!("{} N m, {} mrad", rounded(r.torque_nm), r.misalignment_mrad))
            .collect();
        let _ = match about.len() < reports.len() {
            true => writeln!(text, "\nnote: {note} ({})", about.join("; ")),
            false => writeln!(text, "\nnote: {note}"),
        };
    }
    text
}

/// Flank and centre distance, which all loads of a run share.
fn state(input: &CycleInput) -> String {
    let flank = if input.flank.sign() > 0.0 {
        "drive"
    } else {
        "coast"
    };
    let offset = rounded(input.center_distance_offset * 1e6);
    format!("{flank} flank, centre distance offset {offset} um")
}

/// Many cycles, a line for each.
pub fn many(
    pair: &Pair,
    models: (&Model, &Option<Fillets>),
    input: &CycleInput,
    reports: &[Report],
) -> String {
    type Row<'a> = &'a Report;
    let width = pair.geometry.face_overlap().1;
    let stiffness = move |r: &Row| r.mean_mesh_stiffness_loa_n_per_m / width * 1e-9;
    let mut columns: Vec<Column<Row>> = loads();
    columns.extend([
        column("mean", |r: &Row| r.mean_ste_loa_um).shown("mean STE", "um", 9, Some(4)),
        column("swing", |r: &Row| r.peak_to_peak_ste_loa_um).shown("p-p STE", "um", 9, Some(4)),
        maybe("first", |r: &Row| r.harmonics_loa_um[0]).shown("1st harm.", "um", 9, Some(4)),
        column("pressure", |r: &Row| r.largest_pressure()).shown("p_max", "MPa", 9, Some(1)),
        column("edge", |r: &Row| r.largest_edge_load()).shown("tip edge", "N/mm", 9, Some(1)),
        column("stiffness", stiffness).shown("stiffness", "N/(mm um)", 10, Some(3)),
        column("factor", |r: &Row| r.face_load_factor).shown("K_Hbeta", "", 8, Some(3)),
    ]);
    let number = count(reports.len(), "load");
    let mut text = format!(
        "{}: {number}, {}\n\n{}\n\
         STE: static transmission error on the line of action at mid-face; p_max: largest flank pressure; tip edge: largest\n\
         line load there; stiffness: mean of the cycle, tangent, on the line of action, per face width; K_Hbeta: largest over\n\
         mean load along the face.\n",
        pair.name,
        state(input),
        table(&columns, reports),
    );
    if reports.iter().any(|report| report.roots.is_some()) {
        text += &root_stress(reports);
    }
    let seconds: f64 = reports.iter().map(|report| report.solve_seconds).sum();
    let mut rows = Listing::default();
    times(&mut rows, models, seconds);
    let _ = write!(text, "\n{rows}");
    text + &notes(reports)
}

/// What tells the loads apart.
fn loads<'r>() -> Vec<Column<'static, &'r Report>> {
    type Row<'a> = &'a Report;
    vec![
        column("torque", |r: &Row| r.torque_nm).shown("torque", "N m", 9, None),
        column("tilt", |r: &Row| r.misalignment_mrad).shown("misalignment", "mrad", 12, None),
    ]
}

/// The largest root stress of every load, a line for each.
fn root_stress(reports: &[Report]) -> String {
    let mut columns = loads();
    for i in 0..2 {
        for (head, at_tangent) in [("root stress", false), ("at tangent", true)] {
            let value =
                move |r: &&Report| Some(r.roots.as_ref()?.largest_over_cycle(i, at_tangent));
            columns.push(maybe(head, value).shown(format!("{head} {}", i + 1), "MPa", 13, Some(1)));
        }
    }
    format!(
        "\n{}\n\
         root stress: largest principal stress in the fillets of a gear over the mesh cycle; at tangent: the same at the\n\
         30 degree tangent (ring: 60 degrees).\n",
        table(&columns, reports)
    )
}
