//! What `stiffnessModel = teeth` costs beside a table.

use super::{CLASS, PAIR, SEED, level, record};
use crate::data::Data;
use crate::setup::{Setup, quiet};
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use gearmesh::gear::Flank;
use gearmesh::gear::tolerance::random_index_errors;
use gearmesh::random::Random;
use gearmesh::table::{FlankTable, Interpolation, Query};
use gearmesh_preprocessor::table::{default_axes, sweep};

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (setup, file) = Setup::packed(PAIR)?;
    let gear = &setup.pair.geometry.gears[0];
    let index = random_index_errors(gear, CLASS, SEED);
    let record = record(&setup, &file, index, if context.quick { 20 } else { 1000 })?;
    let teeth = level(&record, &setup.pair)?;
    let grid = if context.quick {
        setup.samples([8, 5, 9, 16])?
    } else {
        let axes = default_axes(&setup.coverage());
        let torque = setup.pair.operating.maximum_torque;
        sweep(&setup.solver, Flank::Drive, &axes, torque, &quiet())?
    };
    let table = FlankTable::new(&grid, Interpolation::Spline)?;
    let delta = setup.nominal_approach()?;
    let mut random = Random::new(2);
    let mut query = || Query {
        delta: delta * random.within([0.5, 1.5]),
        center_distance_offset: random.within([-5e-5, 5e-5]),
        misalignment: random.within([-5e-4, 5e-4]),
        mesh_position: random.within([0.0, gear.z()]),
    };
    let queries: Vec<Query> = (0..1000).map(|_| query()).collect();
    let mut candidates = vec![];
    for hessian in [false, true] {
        let (table, teeth) = (&table, &teeth);
        candidates.push(Candidate::over(&queries, move |q| {
            table.evaluate(q, hessian)
        }));
        let whole = move |q: &Query| teeth.evaluate(q, [0; 2], hessian);
        candidates.push(Candidate::over(&queries, whole));
    }
    let ns = medians(&mut candidates);
    let rows = [("4-D table", 0), ("tooth pair by tooth pair", 1)]
        .map(|(name, i)| format!("{name} | {:.0} | {:.0}", ns[i], ns[2 + i]));
    data.table(
        "teeth-cost",
        "evaluation, ns | loads | with second derivatives",
        &rows,
    )
}
