//! Time and memory as instances multiply, with one shared table and with their own.

use super::Sampled;
use crate::data::Data;
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use gearmesh::table::{FlankTable, Interpolation};

const POINTS: usize = 512;
const INSTANCES: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid } = Sampled::of(context)?;
    let mut own = vec![];
    for _ in 0..INSTANCES[INSTANCES.len() - 1] {
        own.push(FlankTable::new(grid, Interpolation::Spline)?);
    }
    let exact = setup.exact(POINTS)?;
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
