//! What tables cost to make, and how far the levels of refinement are from each other.

use crate::document::{Document, Error};
use crate::setting::Setting;
use crate::timing::timed;
use gearmesh::contact::{ContactSettings, CycleInput, MeshCycle};
use gearmesh::pair::Refinement;
use gearmesh::table::{FlankTable, Interpolation};

/// Mean and peak-to-peak STE at `torque`, µm on the line of action.
fn cycle(setting: &Setting, torque: f64) -> Result<[f64; 2], Error> {
    let cycle = MeshCycle::solve(
        &setting.solver,
        &CycleInput {
            torque,
            positions: 32,
            ..crate::nominal_cycle()
        },
    )?;
    Ok([1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste()])
}

/// The section, on the pair file at `path`; the last of `levels` is the finest.
pub fn report(
    document: &mut Document,
    path: &str,
    levels: &[(Refinement, &str)],
    points: usize,
) -> Result<(), Error> {
    document.section("Preprocessing");
    let mut settings = vec![];
    for &(refinement, name) in levels {
        let (setting, seconds) = timed(|| Setting::new(path, refinement));
        settings.push((name, setting?, seconds));
    }
    let best = &settings.last().ok_or("a level of refinement")?.1;
    let mut rows = vec![];
    for (name, setting, seconds) in &settings {
        let mut cells = [const { String::new() }; 4];
        for (cell, counts) in cells.iter_mut().zip([
            [12, 1, 1, 1],
            [12, 1, 1, 32],
            [12, 1, 9, 32],
            [12, 5, 9, 16],
        ]) {
            let (grid, seconds) = timed(|| setting.samples(counts));
            let solves = grid?.loa_force.len() * (counts[0] + 1) / counts[0];
            *cell = format!("{seconds:.2} ({solves})");
        }
        let [a, b, c, d] = cells;
        rows.push([(*name).to_owned(), format!("{seconds:.2}"), a, b, c, d]);
    }
    document.paragraph(&format!(
        "Seconds on {} threads for the elastic models of both gears and for the sweeps of tables with one to \
         four axes (in brackets: static solutions). The cost of contact hardly depends on the refinement; only \
         axes that are asked for are computed.",
        rayon::current_num_threads()
    ));
    document.table(
        [
            "refinement",
            "models, s",
            "12, s",
            "12 × 32, s",
            "12 × 9 × 32, s",
            "12 × 5 × 9 × 16, s",
        ],
        &rows,
    );

    let nominal = best.pair.operating.nominal_torque;
    let exact = best.exact(&best.ranges(3), points)?;
    let mut rows = vec![];
    for (name, setting, _) in &settings {
        let mut ste = vec![];
        for torque in [0.7 * nominal, nominal, 1.3 * nominal] {
            let [mean, swing] = cycle(setting, torque)?;
            ste.push(format!("{mean:.2} / {swing:.3}"));
        }
        let table = FlankTable::new(&setting.samples([12, 1, 9, 32])?, Interpolation::Spline)?;
        let [rms, largest] = crate::interpolants::force_error(&table, &exact, best.nominal_force());
        let [a, b, c] = <[String; 3]>::try_from(ste).map_err(|_| "three torques")?;
        rows.push([
            (*name).to_owned(),
            a,
            b,
            c,
            format!("{:.2}", 100.0 * rms),
            format!("{:.2}", 100.0 * largest),
        ]);
    }
    document.paragraph(&format!(
        "STE on the line of action, mean / peak to peak in µm, at three torques; and the force error of 3-D \
         tables (load, misalignment, mesh position) against direct solutions with the finest model \
         above, at the same displacement, over the nominal force. {} stations along the face. For the \
         finest model itself the error is that of the interpolation alone.",
        ContactSettings::default().stations
    ));
    let head = |t: f64| format!("{t:.0} N m");
    document.table(
        [
            "refinement",
            &head(0.7 * nominal),
            &head(nominal),
            &head(1.3 * nominal),
            "rms error, %",
            "largest, %",
        ],
        &rows,
    );
    Ok(())
}
