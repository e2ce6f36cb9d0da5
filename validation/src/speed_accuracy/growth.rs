//! Time and memory as tables grow and as instances multiply, with one shared table and with their own.

use super::Sampled;
use crate::data::{Data, fixed};
use crate::spring::Spring;
use crate::timing::{Candidate, medians, timed};
use crate::{Context, Result, row};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{FlankTable, Interpolation, Query, Table, TableFile};

const POINTS: usize = 512;

/// Random points in the range of `Spring`'s grids.
fn points() -> Vec<Query> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut point = || {
        let (c, m) = (random.within([-1e-4, 1e-4]), random.within([-3e-3, 3e-3]));
        let delta = 1e-6 * random.within([0.7, 6.7]) + 3e-3 * c - 0.2 * m * m;
        Query { delta, center_distance_offset: c, misalignment: m, mesh_position: random.next() }
    };
    (0..POINTS).map(|_| point()).collect()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid: samples } = Sampled::of(context)?;
    let random = points();
    let mut tables = vec![];
    for counts in [[6, 4, 5, 8], [8, 5, 9, 16], [12, 9, 9, 32], [12, 9, 17, 32], [16, 9, 33, 64], [24, 17, 33, 96]] {
        let mut grid = Spring::grid(counts);
        let text = setup.file(&grid).to_json();
        let (file, reading) = timed(|| TableFile::from_json(&text));
        let (table, fitting) = timed(|| Table::from_file(file?));
        let bytes = table?.flank(Flank::Drive).0.bytes();
        grid.moment = None;
        let name = counts.map(|n: usize| n.to_string()).join(" × ");
        let megabytes = [text.len(), bytes].map(|n| fixed(n as f64 / 1e6, 2));
        let milliseconds = [reading, fitting].map(|s| fixed(1e3 * s, 0));
        let cells = [row![name], megabytes.to_vec(), milliseconds.to_vec()].concat();
        tables.push((FlankTable::new(&grid, Interpolation::Spline)?, cells));
    }
    let mut candidates: Vec<_> =
        tables.iter().map(|(table, _)| Candidate::over(&random, |q| table.evaluate(q, false))).collect();
    let times = medians(&mut candidates);
    let rows: Vec<_> =
        tables.iter().zip(times).map(|((_, cells), t)| [cells.clone(), row![fixed(t, 0)]].concat()).collect();
    data.table("growth", &["grid", "file, MB", "memory, MB", "reading, ms", "preparing, ms", "evaluation, ns"], &rows)?;

    let instances = [1, 2, 4, 8, 16, 32, 64, 128];
    let own = (0..instances[instances.len() - 1])
        .map(|_| FlankTable::new(samples, Interpolation::Spline))
        .collect::<std::result::Result<Vec<_>, _>>()?;
    let exact: Vec<Query> = setup.exact(&setup.ranges(4), POINTS)?.into_iter().map(|x| x.query).collect();
    let mut candidates = vec![];
    for n in instances {
        for own in [&own[..1], &own[..n]] {
            let mut turn = 0;
            candidates.push(Candidate::over(&exact, move |q| {
                turn = (turn + 1) % n;
                own[turn % own.len()].evaluate(q, false)
            }));
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);
    let mut rows = vec![];
    for (n, t) in instances.into_iter().zip(times.chunks_exact(2)) {
        let megabytes = (n * own[0].bytes()) as f64 / 1e6;
        rows.push(row![n, fixed(t[0], 0), fixed(t[1], 0), fixed(megabytes, 1)]);
    }
    data.table("instances", &["instances", "shared, ns", "own, ns", "memory of own tables, MB"], &rows)
}
