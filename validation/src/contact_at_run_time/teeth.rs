//! How near `stiffnessModel = teeth` comes to contact at run time, and what it costs.

use super::{CLASS, PAIR, SEED, level, record};
use crate::data::{Data, fixed, mean, rms};
use crate::setup::Setup;
use crate::timing::{Candidate, medians, timed};
use crate::{Context, Result, row};
use gearmesh::contact::Warm;
use gearmesh::gear::Flank;
use gearmesh::gear::tolerance::random_index_errors;
use gearmesh::random::Random;
use gearmesh::table::{FlankTable, Interpolation, Query, TeethFlank, TeethRecord};
use gearmesh_preprocessor::table::{default_axes, sweep};
use std::sync::Arc;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (setup, file) = Setup::packed(PAIR)?;
    let (poses, points) = if context.quick { (10, 20) } else { (200, 1000) };
    let gear = &setup.pair.geometry.gears[0];
    let turn = [0.0, gear.z()];
    let nominal = setup.nominal_force();
    let torque = setup.pair.operating.nominal_torque;
    let delta = setup.solver.position(Flank::Drive, 0.0, 0.0)?.solve_torque(torque, 0.0, None)?.approach;
    let (mut rows, mut records) = (vec![], vec![]);
    let mut last = None;
    for (name, index) in
        [("alike", vec![0.0; gear.teeth as usize]), ("class 6", random_index_errors(gear, CLASS, SEED))]
    {
        let (recorded, seconds) = timed(|| record(&setup, &file, index, points));
        let (record, contact) = recorded?;
        records.push(row![name, record.in_words(), fixed(seconds, 0)]);
        let contact = Arc::new(contact);
        let contact = contact.flank(Flank::Drive).ok_or("no drive flank")?;
        let coupling_m_per_n = vec![vec![0.0]];
        let without = level(&TeethRecord { coupling_m_per_n, ..record.clone() }, &setup.pair)?;
        let whole = level(&record, &setup.pair)?;
        for (misalignment, share) in [0.0, 5e-4, 2e-3].into_iter().flat_map(|m| [0.7, 1.0, 1.3].map(|s| (m, s))) {
            let mut random = Random::new(1);
            let (mut errors, mut loads) = ([(); 3].map(|()| vec![]), vec![]);
            for _ in 0..poses {
                let mesh_position = random.within(turn);
                let query = Query { delta: share * delta, center_distance_offset: 0.0, misalignment, mesh_position };
                let at = [query.delta, 0.0, misalignment, query.mesh_position];
                let exact = contact.potential(at, [0; 2], &mut Warm::default())?.gradient;
                let of = |level: &TeethFlank| level.evaluate(&query, [0; 2], false).gradient;
                let found = of(&whole);
                loads.push(exact[0] / nominal);
                errors[0].push((of(&without)[0] - exact[0]) / nominal);
                errors[1].push((found[0] - exact[0]) / nominal);
                errors[2].push((found[2] - exact[2]) / (nominal * setup.half_face()));
            }
            let scene = row![name, fixed(1e3 * misalignment, 1), fixed(1e6 * share * delta, 2), fixed(mean(&loads), 2)];
            rows.push([scene, errors.map(|errors| fixed(100.0 * rms(errors), 2)).to_vec()].concat());
        }
        last = Some(whole);
    }
    data.table("teeth-records", &["teeth", "record", "s"], &records)?;
    let head = ["teeth", "misalignment, mrad", "approach, um", "load", "force without coupling", "force", "moment"];
    data.table("teeth", &head, &rows)?;

    let whole = last.ok_or("no level")?;
    let grid = if context.quick {
        setup.samples([8, 5, 9, 16])?
    } else {
        let axes = default_axes(&setup.coverage());
        sweep(&setup.solver, Flank::Drive, &axes, setup.pair.operating.maximum_torque, &crate::setup::quiet())?
    };
    let table = FlankTable::new(&grid, Interpolation::Spline)?;
    let mut random = Random::new(2);
    let mut query = || Query {
        delta: delta * random.within([0.5, 1.5]),
        center_distance_offset: random.within([-5e-5, 5e-5]),
        misalignment: random.within([-5e-4, 5e-4]),
        mesh_position: random.within(turn),
    };
    let queries: Vec<Query> = (0..1000).map(|_| query()).collect();
    let mut candidates = vec![];
    for hessian in [false, true] {
        let (table, whole) = (&table, &whole);
        candidates.push(Candidate::over(&queries, move |q| table.evaluate(q, hessian).gradient[0]));
        candidates.push(Candidate::over(&queries, move |q| whole.evaluate(q, [0; 2], hessian).gradient[0]));
    }
    let ns = medians(&mut candidates);
    let rows = ["4-D table", "tooth pair by tooth pair"].into_iter().enumerate();
    let rows: Vec<_> = rows.map(|(i, name)| row![name, fixed(ns[i], 0), fixed(ns[2 + i], 0)]).collect();
    data.table("teeth-cost", &["evaluation, ns", "loads", "with second derivatives"], &rows)
}
