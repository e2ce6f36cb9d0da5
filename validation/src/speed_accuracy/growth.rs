//! Time and memory as tables grow and as instances multiply, with one shared table and with their own.

use super::Sampled;
use crate::data::Data;
use crate::spring::Spring;
use crate::timing::{Candidate, medians, timed};
use crate::{Context, Result};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{FlankTable, Interpolation, Query, Table, TableFile};

const POINTS: usize = 512;
const GRIDS: [[usize; 4]; 6] = [
    [6, 4, 5, 8],
    [8, 5, 9, 16],
    [12, 9, 9, 32],
    [12, 9, 17, 32],
    [16, 9, 33, 64],
    [24, 17, 33, 96],
];
const INSTANCES: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Random points in the range of `Spring`'s grids.
fn points() -> Vec<Query> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut point = || {
        let (c, m) = (random.within([-1e-4, 1e-4]), random.within([-3e-3, 3e-3]));
        Query {
            delta: 1e-6 * random.within([0.7, 6.7]) + 3e-3 * c - 0.2 * m * m,
            center_distance_offset: c,
            misalignment: m,
            mesh_position: random.next(),
        }
    };
    (0..POINTS).map(|_| point()).collect()
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let sampled = Sampled::of(context)?;
    let (setup, samples) = (&sampled.setup, &sampled.grid);
    let random = points();
    let (mut tables, mut rows) = (vec![], vec![]);
    for counts in GRIDS {
        let mut grid = Spring::grid(counts);
        let text = setup.file(&grid).to_json();
        let (file, reading) = timed(|| TableFile::from_json(&text));
        let (table, fitting) = timed(|| Table::from_file(file?));
        let [file, memory] =
            [text.len(), table?.flank(Flank::Drive).0.bytes()].map(|n| n as f64 / 1e6);
        grid.moment = None;
        tables.push(FlankTable::new(&grid, Interpolation::Spline)?);
        let (name, times) = (
            counts.map(|n| n.to_string()).join(" × "),
            [1e3 * reading, 1e3 * fitting],
        );
        rows.push(format!(
            "{name} | {file:.2} | {memory:.2} | {:.0} | {:.0}",
            times[0], times[1]
        ));
    }
    let mut candidates = vec![];
    for table in &tables {
        candidates.push(Candidate::over(&random, |q| table.evaluate(q, false)));
    }
    for (row, ns) in rows.iter_mut().zip(medians(&mut candidates)) {
        *row += &format!(" | {ns:.0}");
    }
    let head = "grid | file, MB | memory, MB | reading, ms | preparing, ms | evaluation, ns";
    data.table("growth", head, &rows)?;

    let mut own = vec![];
    for _ in 0..INSTANCES[INSTANCES.len() - 1] {
        own.push(FlankTable::new(samples, Interpolation::Spline)?);
    }
    let exact = setup.exact(&setup.ranges(4), POINTS)?;
    let mut candidates = vec![];
    for n in INSTANCES {
        for own in [&own[..1], &own[..n]] {
            let mut turn = 0;
            candidates.push(Candidate::over(&exact, move |x| {
                turn = (turn + 1) % n;
                own[turn % own.len()].evaluate(&x.query, false)
            }));
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);
    let row = |(n, t): (usize, &[f64])| {
        let megabytes = (n * own[0].bytes()) as f64 / 1e6;
        format!("{n} | {:.0} | {:.0} | {megabytes:.1}", t[0], t[1])
    };
    let rows: Vec<_> = INSTANCES
        .into_iter()
        .zip(times.chunks_exact(2))
        .map(row)
        .collect();
    let head = "instances | shared, ns | own, ns | memory of own tables, MB";
    data.table("instances", head, &rows)
}
