//! Mesh cycles as text.

use std::fmt::Write;

use gearmesh::contact::{CycleInput, MeshCycle};
use gearmesh::pair::Pair;
use gearmesh::words::{count, fixed, rounded};

use super::report::Report;
use crate::model::{Fillets, Model};
use crate::output::Listing;

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
    let _ = write!(
        text,
        "{:>9} {:>11} {:>9} {:>9} {:>9}",
        "mesh", "STE (loa)", "z_c", "p_max", "tip edge"
    );
    for k in &report.tooth_pairs {
        let _ = write!(text, " {:>8}", format!("pair {k}"));
    }
    let _ = write!(
        text,
        "\n{:>9} {:>11} {:>9} {:>9} {:>9}",
        "position", "um", "mm", "MPa", "N/mm"
    );
    for _ in &report.tooth_pairs {
        let _ = write!(text, " {:>8}", "share");
    }
    text.push('\n');
    for i in 0..report.mesh_position.len() {
        let _ = write!(
            text,
            "{:>9.4} {:>11} {:>9} {:>9.1} {:>9.1}",
            report.mesh_position[i],
            fixed(report.ste_loa_um[i], 4),
            fixed(report.contact_z_mm[i], 4),
            report.maximum_pressure_mpa[i],
            report.edge_line_load_n_per_mm[i]
        );
        for share in &report.load_share[i] {
            let _ = write!(text, " {share:>8.4}");
        }
        text.push('\n');
    }
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
    let mut rows = Listing::default();
    rows.row("mean STE", format!("{:.4} um", report.mean_ste_loa_um))
        .row(
            "peak-to-peak STE",
            format!("{:.4} um", report.peak_to_peak_ste_loa_um),
        )
        .row(
            "largest flank pressure",
            format!("{:.1} MPa", cycle.max_pressure() * 1e-6),
        )
        .row(
            "largest line load at a tip edge",
            cycle.edge_load().map_or("none".into(), |edge| {
                format!(
                    "{:.1} N/mm, gear {} at z = {:.2} mm",
                    edge.line_load * 1e-3,
                    edge.gear + 1,
                    edge.z * 1e3
                )
            }),
        )
        .row("harmonics 1 to 10", format!("{} um", harmonics.join(" ")))
        .row(
            "mesh stiffness",
            format!(
                "{:.4e} N/m in the mean, tangent, on the line of action",
                report.mean_mesh_stiffness_loa_n_per_m
            ),
        )
        .row(
            "face load factor K_Hbeta",
            format!("{:.3}", report.face_load_factor),
        )
        .row(
            "transverse contact ratio",
            format!("{:.4}", report.transverse_contact_ratio),
        )
        .row("overlap ratio", format!("{:.4}", report.overlap_ratio));
    report.losses.list(&mut rows);
    if let Some(roots) = &report.roots {
        roots.list(&mut rows);
    }
    rows.row(
        "largest KKT residual",
        format!("{:.1e}", cycle.kkt_residual()),
    );
    times(&mut rows, models, report.solve_seconds);
    let _ = write!(text, "\n{rows}");
    text + &notes(pair)
}

/// What was used, and what it took; `contact` the time of the contact, s.
fn times(rows: &mut Listing, (model, fillets): (&Model, &Option<Fillets>), contact: f64) {
    rows.row("elastic model", &model.description).row(
        "time for the elastic model",
        format!("{:.3} s, {}", model.compliance_seconds, model.origin),
    );
    if let Some(fillets) = fillets {
        rows.row(
            "time for the model of the fillets",
            format!("{:.3} s, {}", fillets.seconds, fillets.origin),
        );
    }
    rows.row("time for the contact", format!("{contact:.3} s"));
}

/// What is to be known of the results.
fn notes(pair: &Pair) -> String {
    let note = pair.note_on_teeth();
    note.map_or(String::new(), |note| format!("\nnote: {note}\n"))
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
    cycles: &[MeshCycle],
    reports: &[Report],
) -> String {
    let number = count(reports.len(), "load");
    let mut text = format!(
        "{}: {number}, {}\n\n\
         {:>9} {:>12} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>8}\n\
         {:>9} {:>12} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>8}\n",
        pair.name,
        state(input),
        "torque",
        "misalignment",
        "mean STE",
        "p-p STE",
        "1st harm.",
        "p_max",
        "tip edge",
        "stiffness",
        "K_Hbeta",
        "N m",
        "mrad",
        "um",
        "um",
        "um",
        "MPa",
        "N/mm",
        "N/(mm um)",
        "",
    );
    let width = pair.geometry.face_overlap().1;
    for (cycle, report) in cycles.iter().zip(reports) {
        let first = report.harmonics_loa_um[0];
        let _ = writeln!(
            text,
            "{:>9} {:>12} {:>9} {:>9} {:>9} {:>9.1} {:>9.1} {:>10.3} {:>8.3}",
            rounded(report.torque_nm),
            report.misalignment_mrad,
            fixed(report.mean_ste_loa_um, 4),
            fixed(report.peak_to_peak_ste_loa_um, 4),
            first.map_or("-".into(), |h| fixed(h, 4)),
            cycle.max_pressure() * 1e-6,
            cycle.edge_load().map_or(0.0, |edge| edge.line_load * 1e-3),
            report.mean_mesh_stiffness_loa_n_per_m / width * 1e-9,
            report.face_load_factor,
        );
    }
    text.push_str(
        "\nSTE: static transmission error on the line of action at mid-face; p_max: largest flank pressure; tip edge: largest\n\
         line load there; stiffness: mean of the cycle, tangent, on the line of action, per face width; K_Hbeta: largest over\n\
         mean load along the face.\n",
    );
    if reports.iter().any(|report| report.roots.is_some()) {
        text.push_str(&super::roots::table(reports));
    }
    let seconds: f64 = reports.iter().map(|report| report.solve_seconds).sum();
    let mut rows = Listing::default();
    times(&mut rows, models, seconds);
    let _ = write!(text, "\n{rows}");
    text + &notes(pair)
}
