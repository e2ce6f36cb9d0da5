//! What tables cost to make, and how far closed-form compliance is from finite elements.

use crate::document::{Document, Error};
use crate::setting::Setting;
use crate::timing::timed;
use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::finite_element::{FiniteElementCompliance, Settings};
use gearmesh::contact::{ContactSettings, CycleInput, MeshCycle};
use gearmesh::gear::Gear;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::{FlankTable, Interpolation};
use std::sync::Arc;

/// The pair file at `path` on finite elements, and seconds for the elastic models.
fn finite_element(path: &str, refinement: Refinement) -> Result<(Setting, f64), Error> {
    let mut pair = Pair::read(path)?;
    pair.compliance.refinement = refinement;
    let settings = Settings::for_pair(&pair);
    let (models, seconds) = timed(|| -> Result<[Arc<dyn ToothCompliance>; 2], Error> {
        let model = |i: usize| -> Result<Arc<dyn ToothCompliance>, Error> {
            let gear = &pair.geometry.gears[i];
            Ok(Arc::new(FiniteElementCompliance::new(
                gear,
                &settings,
                &|_, _| true,
            )?))
        };
        let first = model(0)?;
        let [a, b] = &pair.geometry.gears;
        // Equal but for hand and axial position, which the compliance does not know: one model serves both.
        let equal = *b
            == Gear {
                hand: b.hand,
                face_offset: b.face_offset,
                ..a.clone()
            };
        let second = if equal { first.clone() } else { model(1)? };
        Ok([first, second])
    });
    let models = models?;
    Ok((Setting::with(pair, models)?, seconds))
}

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

/// The section. `path` is the pair file of `analytical`.
pub fn report(
    document: &mut Document,
    path: &str,
    analytical: &Setting,
    levels: &[(Refinement, &str)],
    points: usize,
) -> Result<(), Error> {
    document.section("Preprocessing, and closed-form against finite-element tables");
    let (_, seconds) = timed(|| Setting::analytical(path));
    let mut settings = vec![("closed form".to_owned(), None, seconds)];
    for &(refinement, name) in levels {
        let (setting, seconds) = finite_element(path, refinement)?;
        settings.push((format!("finite elements, {name}"), Some(setting), seconds));
    }
    let mut rows = vec![];
    for (name, setting, seconds) in &settings {
        let setting = setting.as_ref().unwrap_or(analytical);
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
        rows.push([name.clone(), format!("{seconds:.2}"), a, b, c, d]);
    }
    document.paragraph(&format!(
        "Seconds on {} threads for the elastic models of both gears and for the sweeps of tables with one to \
         four axes (in brackets: static solutions). The cost of contact hardly depends on where the \
         compliance came from; only axes that are asked for are computed.",
        rayon::current_num_threads()
    ));
    document.table(
        [
            "compliance",
            "models, s",
            "12, s",
            "12 × 32, s",
            "12 × 9 × 32, s",
            "12 × 5 × 9 × 16, s",
        ],
        &rows,
    );

    let nominal = analytical.pair.operating.nominal_torque;
    let best = settings
        .last()
        .and_then(|s| s.1.as_ref())
        .unwrap_or(analytical);
    let exact = best.exact(&best.ranges(3), points)?;
    let mut rows = vec![];
    for (name, setting, _) in &settings {
        let setting = setting.as_ref().unwrap_or(analytical);
        let mut ste = vec![];
        for torque in [0.7 * nominal, nominal, 1.3 * nominal] {
            let [mean, swing] = cycle(setting, torque)?;
            ste.push(format!("{mean:.2} / {swing:.3}"));
        }
        let table = FlankTable::new(&setting.samples([12, 1, 9, 32])?, Interpolation::Spline)?;
        let [rms, largest] = crate::interpolants::force_error(&table, &exact, best.nominal_force());
        let [a, b, c] = <[String; 3]>::try_from(ste).map_err(|_| "three torques")?;
        rows.push([
            name.clone(),
            a,
            b,
            c,
            format!("{:.2}", 100.0 * rms),
            format!("{:.2}", 100.0 * largest),
        ]);
    }
    document.paragraph(&format!(
        "STE on the line of action, mean / peak to peak in µm, at three torques; and the force error of 3-D \
         tables (load, misalignment, mesh position) against direct solutions with the finest compliance \
         above, at the same displacement, over the nominal force. {} stations along the face. For the \
         finest compliance itself the error is that of the interpolation alone.",
        ContactSettings::default().stations
    ));
    let head = |t: f64| format!("{t:.0} N m");
    document.table(
        [
            "compliance",
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
