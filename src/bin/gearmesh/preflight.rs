//! Before long work: whether the contact can be solved at the corners of the operating range, and what it all
//! will take.
//!
//! The corners are solved on the coarse model, which takes seconds; it also tells how fast this machine is.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use gearmesh::contact::{ContactError, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::plan::{Coverage, mesh_positions};
use rayon::prelude::*;

use crate::Error;
use crate::model::{FILLETS, ModelArgs};
use crate::progress::{Job, Plan, Progress, clock};

/// Positions of the mesh cycle at which every corner is solved.
const POSITIONS: usize = 16;

/// Elastic models that take less are computed at once, s.
const SHORT: f64 = 1.5;

/// Work that is not worth announcing, s.
const UNANNOUNCED: f64 = 10.0;

/// How many contact problems a command solves.
#[derive(Debug, Clone, Copy)]
pub struct Load {
    /// Influence matrices: positions of the mesh and centre distances.
    pub positions: usize,
    /// Solves on all of them.
    pub solves: usize,
    /// Likewise for the stress in the tooth roots, where it is wanted: positions and solves.
    pub root_stress: Option<[usize; 2]>,
    /// Likewise for tooth pairs one by one.
    pub teeth: Option<[usize; 2]>,
}

/// Strips of one tooth pair over those of all in reach.
const STRIPS_ALONE: f64 = 0.4;

/// Refuses what cannot be solved at a corner of `coverage`, tells what the rest will take, and returns the job
/// of the whole command.
pub fn preflight(
    pair: &Pair,
    args: &ModelArgs,
    coverage: &Coverage,
    load: Load,
) -> Result<Job, Error> {
    let estimates = args.estimates(pair)?;
    let elastic: f64 = estimates.iter().map(|e| e.total_seconds()).sum();
    let mut seconds = estimates.map(|e| e.total_seconds());
    let (mut contact, mut roots) = (elastic.max(1.0), 0.0);
    if elastic > SHORT && pair.refinement != Refinement::Coarse {
        let coarse = Pair {
            refinement: Refinement::Coarse,
            ..pair.clone()
        };
        let expected: f64 = args
            .estimates(&coarse)?
            .iter()
            .map(|e| e.seconds.iter().sum::<f64>())
            .sum();
        let model = args.solver(&coarse, &Progress::new(true).job(Plan::default()))?;
        let times = corners(&model.solver, pair, coverage)?;
        let speed = model.computing_seconds / expected;
        seconds = seconds.map(|s| s * speed);
        // Influence matrices cost what the flank's nodes do, solves what the strips do.
        let stations = args.contact_settings(pair).stations as f64;
        let finer = stations / model.solver.settings().stations as f64;
        let cost = |[positions, solves]: [usize; 2]| {
            positions as f64 * times.position * 2.5 * finer
                + solves as f64 * times.solve * finer * finer
        };
        contact = cost([load.positions, load.solves]);
        // Solves cost what the square of the strips does.
        let alone = |load| STRIPS_ALONE * STRIPS_ALONE * cost(load);
        contact += load.teeth.map_or(0.0, alone);
        let models = FILLETS * seconds.iter().sum::<f64>();
        roots = load.root_stress.map_or(0.0, |load| models + cost(load));
    }
    let total = Duration::from_secs_f64(seconds.iter().sum::<f64>() + contact + roots);
    if !args.is_quiet() && elastic > SHORT && total.as_secs_f64() > UNANNOUNCED {
        let memory = estimates.iter().map(|e| e.memory_bytes).fold(0.0, f64::max);
        let file: f64 = estimates.iter().map(|e| e.file_bytes).sum();
        eprintln!(
            "gearmesh: about {} of work: {} for the elastic models (memory {:.1} GB; {:.0} MB of them are kept), {} \
             for the static contact{}",
            clock(total),
            clock(Duration::from_secs_f64(seconds.iter().sum())),
            memory * 1e-9,
            file * 1e-6,
            clock(Duration::from_secs_f64(contact)),
            match roots {
                0.0 => String::new(),
                _ => format!(
                    ", {} for the tooth roots",
                    clock(Duration::from_secs_f64(roots))
                ),
            },
        );
    }
    Ok(args
        .progress()
        .job(Plan::new(seconds, ("static contact", contact))))
}

/// Wall-clock time on all threads, s.
pub struct Times {
    /// Of one influence matrix.
    pub position: f64,
    /// Of one solve.
    pub solve: f64,
}

/// Solves under the largest torque at the corners of `coverage` and at its nominal state.
pub fn corners(solver: &ContactSolver, pair: &Pair, coverage: &Coverage) -> Result<Times, Error> {
    let ends = |range: Option<[f64; 2]>| -> Vec<f64> {
        let mut ends = vec![0.0];
        ends.extend(range.into_iter().flatten());
        ends.dedup();
        ends
    };
    let flanks: &[Flank] = match pair.coast_mirrors_drive() {
        true => &[Flank::Drive],
        false => &[Flank::Drive, Flank::Coast],
    };
    let misalignments = ends(coverage.misalignment);
    let mut points = Vec::new();
    for &flank in flanks {
        for offset in ends(coverage.center_distance_offset) {
            points.extend(
                mesh_positions(POSITIONS)
                    .into_iter()
                    .map(|tau| (flank, offset, tau)),
            );
        }
    }
    let [position, solve] = [AtomicU64::new(0), AtomicU64::new(0)];
    let timed = |sum: &AtomicU64, begin: Instant| {
        sum.fetch_add(begin.elapsed().as_nanos() as u64, Ordering::Relaxed);
    };
    let solved = points.par_iter().try_for_each(|&(flank, offset, tau)| {
        let begin = Instant::now();
        let at = solver.position(flank, tau, offset)?;
        timed(&position, begin);
        for &misalignment in &misalignments {
            let begin = Instant::now();
            at.solve_torque(coverage.maximum_torque, misalignment, None)?;
            timed(&solve, begin);
        }
        Ok::<(), ContactError>(())
    });
    solved.map_err(|error| {
        format!("the operating range of the pair file cannot be covered: {error}")
    })?;
    let per = |sum: AtomicU64, count: usize| {
        let threads = rayon::current_num_threads() as f64;
        1e-9 * sum.into_inner() as f64 / (count as f64 * threads)
    };
    Ok(Times {
        position: per(position, points.len()),
        solve: per(solve, points.len() * misalignments.len()),
    })
}
