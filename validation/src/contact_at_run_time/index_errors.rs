//! Orders of the transmission error of a pair whose teeth differ, by contact at run time.

use super::{CLASS, PAIR, SEED, level, record, with_errors};
use crate::data::{Data, fixed};
use crate::setup::Setup;
use crate::{Context, Result, row};
use gearmesh::contact::Warm;
use gearmesh::gear::tolerance::{random_index_errors, total_pitch};
use gearmesh::gear::{Flank, Runout, ToothErrors, WeakTooth};
use gearmesh::table::Query;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Mesh positions of a cycle.
const STEPS: usize = 32;

/// Static transmission error (m) under the force `force` (N) over a turn of gear 1, `teeth` mesh cycles. `loads` gives force and
/// stiffness (N, N/m) at the approach (m), the mesh position and the mesh cycle.
fn transmission_error(
    mut loads: impl FnMut(f64, f64, i64) -> Result<[f64; 2]>,
    force: f64,
    teeth: usize,
) -> Result<Vec<f64>> {
    let mut approach = 1e-5;
    let mut all = Vec::with_capacity(teeth * STEPS);
    for i in 0..teeth * STEPS {
        let (cycle, tau) = ((i / STEPS) as i64, (i % STEPS) as f64 / STEPS as f64);
        let mut missing = f64::INFINITY;
        for _ in 0..50 {
            let [found, stiffness] = loads(approach, tau, cycle)?;
            missing = force - found;
            if missing.abs() <= 1e-9 * force {
                break;
            }
            approach += if found > 0.0 { missing / stiffness } else { 5e-6 };
        }
        if missing.abs() > 1e-9 * force {
            return Err(format!("no approach for {force} N at {tau} of cycle {cycle}").into());
        }
        all.push(approach);
    }
    Ok(all)
}

/// Size of the sum of `y` turned by `order` times `x` turns, over the points (x, y).
fn amplitude(points: &[(f64, f64)], order: usize) -> f64 {
    let part = |f: fn(f64) -> f64| -> f64 { points.iter().map(|(x, y)| y * f(TAU * (x * order as f64))).sum() };
    part(f64::cos).hypot(part(f64::sin))
}

/// Amplitude of each shaft order up to `orders` of a signal over a turn.
fn spectrum(signal: &[f64], orders: usize) -> Vec<f64> {
    let n = signal.len() as f64;
    let points: Vec<_> = signal.iter().enumerate().map(|(i, x)| (i as f64 / n, *x)).collect();
    (0..=orders).map(|order| 2.0 / n * amplitude(&points, order)).collect()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (setup, file) = Setup::packed(PAIR)?;
    let gear = &setup.pair.geometry.gears[0];
    let (z, force) = (gear.teeth as usize, setup.nominal_force());
    let index = random_index_errors(gear, CLASS, SEED);
    let alike = ToothErrors::default;
    // F_r is about nine tenths of F_p in one class.
    let runout = Some(Runout { amount: 0.9 * total_pitch(gear, CLASS), angle: 0.0 });
    let weak = vec![WeakTooth { tooth: 0, factor: 2.0 }];
    let cases = [
        ("alike", alike()),
        ("index errors", ToothErrors { index: index.clone(), ..alike() }),
        ("run-out", ToothErrors { runout, ..alike() }),
        ("weak tooth", ToothErrors { weak, ..alike() }),
    ];
    let orders = 3 * z + 4;
    let mut spectra = vec![];
    for (name, first) in cases {
        let with = Arc::new(with_errors(&file, first));
        let contact = with.flank(Flank::Drive).ok_or("no drive flank")?;
        let mut warm = Warm::default();
        let loads = |approach, tau, cycle| {
            let found = contact.potential([approach, 0.0, 0.0, tau], [cycle; 2], &mut warm)?;
            Ok([found.gradient[0], found.tangent.force_by_approach])
        };
        spectra.push((name, spectrum(&transmission_error(loads, force, z)?, orders)));
    }

    let points = if context.quick { 20 } else { 1000 };
    let level = level(&record(&setup, &file, index.clone(), points)?.0, &setup.pair)?;
    let loads = |delta, mesh_position, cycle| {
        let query = Query { delta, center_distance_offset: 0.0, misalignment: 0.0, mesh_position };
        let found = level.evaluate(&query, [cycle; 2], true);
        Ok([found.gradient[0], found.hessian[0][0]])
    };
    let of_level = spectrum(&transmission_error(loads, force, z)?, orders);

    // To first order a tooth that stands out by E takes its share of the load off the transmission error: the errors' own
    // orders, which repeat every z, times those of the share over the way of a tooth pair.
    let turns = 1.0 / z as f64;
    let mut share = vec![];
    for i in 0..STEPS {
        let tau = i as f64 / STEPS as f64;
        let at = setup.solver.position(Flank::Drive, tau, 0.0)?;
        let result = at.solve_torque(setup.pair.operating.nominal_torque, 0.0, None)?;
        share.extend(result.load_share.iter().map(|(k, part)| ((tau + f64::from(*k)) * turns, *part)));
    }
    let errors: Vec<_> = index.iter().enumerate().map(|(j, e)| (j as f64 * turns, *e)).collect();
    let by_share = |order| 2.0 / (z * STEPS) as f64 * amplitude(&errors, order) * amplitude(&share, order);

    let mut rows = vec![];
    for order in [1, 2, 3, z - 2, z - 1, z, z + 1, z + 2, 2 * z - 1, 2 * z, 2 * z + 1, 3 * z] {
        let by_share = if order % z == 0 { String::new() } else { fixed(1e6 * by_share(order), 3) };
        let all = spectra.iter().map(|(_, of_case)| of_case).chain([&of_level]);
        let found = all.map(|amplitudes| fixed(1e6 * amplitudes[order], 3)).collect();
        rows.push([row![order], found, row![by_share]].concat());
    }
    let head = [
        "order",
        spectra[0].0,
        spectra[1].0,
        spectra[2].0,
        spectra[3].0,
        "index errors by `teeth`",
        "index errors by load share",
    ];
    data.table("index-errors", &head, &rows)
}
