//! Orders of the transmission error of a pair whose teeth differ, by contact at run time.

use crate::data::Data;
use crate::setup::{Setup, query, shipped};
use crate::{Context, Result};
use gearmesh::contact::{ContactFile, Warm};
use gearmesh::gear::{Flank, PairTeeth, Runout, ToothErrors, WeakTooth};
use gearmesh::table::{Effects, Interpolation, Load, TeethFlank};
use gearmesh_preprocessor::gear::tolerance::{random_index_errors, total_pitch};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::Arc;

/// The pair, and the flank tolerance class of ISO 1328-1 and seed of gear 1's index errors.
const PAIR: &str = "palermo2013";
const CLASS: u8 = 6;
const SEED: u32 = 1;
/// Mesh positions of a cycle.
const STEPS: usize = 32;

/// The contact of `file` with the errors `first` of gear 1's teeth on the drive flank.
fn with_errors(file: &ContactFile, first: ToothErrors) -> ContactFile {
    let mut file = file.clone();
    Arc::make_mut(&mut file.setup).teeth = PairTeeth {
        drive: [first, ToothErrors::default()],
        ..PairTeeth::default()
    };
    file
}

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
            approach += if found > 0.0 {
                missing / stiffness
            } else {
                5e-6
            };
        }
        if missing.abs() > 1e-9 * force {
            return Err(format!("no approach for {force} N at {tau} of cycle {cycle}").into());
        }
        all.push(approach);
    }
    Ok(all)
}

/// A value at a part of a turn.
struct Point {
    turns: f64,
    value: f64,
}

/// Size of the sum of the values turned by `order` times their turns.
fn amplitude(points: &[Point], order: usize) -> f64 {
    let part = |f: fn(f64) -> f64| -> f64 {
        let turned = |p: &Point| p.value * f(TAU * p.turns * order as f64);
        points.iter().map(turned).sum()
    };
    part(f64::cos).hypot(part(f64::sin))
}

/// A signal at even steps over a turn.
fn over_a_turn(signal: &[f64]) -> Vec<Point> {
    let turns = |i: usize| i as f64 / signal.len() as f64;
    let point = |(i, &value)| Point {
        turns: turns(i),
        value,
    };
    signal.iter().enumerate().map(point).collect()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let setup = Setup::new(shipped(PAIR)?, None)?;
    let file = setup.contact_file()?;
    let gear = &setup.pair.geometry.gears[0];
    let (z, force) = (gear.teeth as usize, setup.nominal_force());
    let index = random_index_errors(gear, CLASS, SEED);
    let mut cases: [ToothErrors; 4] = Default::default();
    cases[1].index = index.clone();
    // F_r is about nine tenths of F_p in one class.
    let amount = 0.9 * total_pitch(gear, CLASS);
    cases[2].runout = Some(Runout { amount, angle: 0.0 });
    let (tooth, factor) = (0, 2.0);
    cases[3].weak = vec![WeakTooth { tooth, factor }];
    let mut signals = vec![];
    for errors in cases {
        let with = Arc::new(with_errors(&file, errors));
        let contact = with.flank(Flank::Drive).ok_or("no drive flank")?;
        let mut warm = Warm::default();
        let loads = |approach, tau, cycle| {
            let found = contact.potential([approach, 0.0, 0.0, tau], [cycle; 2], &mut warm)?;
            Ok([found.gradient[0], found.tangent.force_by_approach])
        };
        signals.push(over_a_turn(&transmission_error(loads, force, z)?));
    }

    let points = if context.quick { 20 } else { 1000 };
    let errors = ToothErrors {
        index: index.clone(),
        ..ToothErrors::default()
    };
    let record = setup.teeth_record(&with_errors(&file, errors), points)?;
    let effects = Effects {
        interpolation: Interpolation::Spline,
        load: Load::Variable,
        center_distance: true,
        misalignment: true,
        shuttling: true,
        friction: false,
        root_stress: false,
        teeth: true,
    };
    let level = TeethFlank::new(&record, &setup.pair.geometry, Flank::Drive, &effects)?;
    let loads = |approach, tau, cycle| {
        let found = level.evaluate(&query(approach, tau), [cycle; 2], true);
        Ok([found.gradient[0], found.hessian[0][0]])
    };
    signals.push(over_a_turn(&transmission_error(loads, force, z)?));

    // To first order a tooth that stands out by E takes its share of the load off the transmission error: the errors' own
    // orders, which repeat every z, times those of the share over the way of a tooth pair.
    let mut share = vec![];
    for i in 0..STEPS {
        let tau = i as f64 / STEPS as f64;
        for (k, value) in setup.nominal(tau)?.load_share {
            let turns = (tau + f64::from(k)) / z as f64;
            share.push(Point { turns, value });
        }
    }
    let errors = over_a_turn(&index);
    let scale = 2e6 / (z * STEPS) as f64;
    let mut rows = vec![];
    for order in [
        1,
        2,
        3,
        z - 2,
        z - 1,
        z,
        z + 1,
        z + 2,
        2 * z - 1,
        2 * z,
        2 * z + 1,
        3 * z,
    ] {
        let mut row = order.to_string();
        for signal in &signals {
            let _ = write!(row, " | {:.3}", scale * amplitude(signal, order));
        }
        let by_share = scale * amplitude(&errors, order) * amplitude(&share, order);
        rows.push(match order % z {
            0 => row + "|",
            _ => format!("{row} | {by_share:.3}"),
        });
    }
    let head = "order | alike | index errors | run-out | weak tooth | index errors by `teeth` \
        | index errors by load share";
    data.table("index-errors", head, &rows)
}
