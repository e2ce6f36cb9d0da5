//! Times of short functions on a machine that does other things, too.

use std::time::Instant;

/// Rounds per comparison; each round runs every candidate once, so that a slow moment hits all of them.
pub const ROUNDS: usize = 41;

/// Least time of one run, s: far above the clock's resolution, far below a scheduler's slice.
const RUN_SECONDS: f64 = 4e-4;

/// Something to time: a name and a run over a fixed number of evaluations.
pub struct Candidate<'a> {
    evaluations: usize,
    run: Box<dyn FnMut() + 'a>,
}

impl<'a> Candidate<'a> {
    /// `run` does `evaluations` evaluations.
    pub fn new(evaluations: usize, run: impl FnMut() + 'a) -> Self {
        Candidate {
            evaluations,
            run: Box::new(run),
        }
    }
}

/// Median time of one evaluation of every candidate, ns, measured in turns.
pub fn medians(candidates: &mut [Candidate]) -> Vec<f64> {
    let repeats: Vec<usize> = candidates
        .iter_mut()
        .map(|c| {
            (c.run)();
            let begin = Instant::now();
            (c.run)();
            (RUN_SECONDS / begin.elapsed().as_secs_f64().max(1e-9)).ceil() as usize
        })
        .collect();
    let mut times = vec![Vec::with_capacity(ROUNDS); candidates.len()];
    for _ in 0..ROUNDS {
        for ((c, &n), times) in candidates.iter_mut().zip(&repeats).zip(&mut times) {
            // Not timed: brings back to the caches what the others have driven out.
            (c.run)();
            let begin = Instant::now();
            for _ in 0..n {
                (c.run)();
            }
            let seconds = begin.elapsed().as_secs_f64();
            times.push(1e9 * seconds / (n * c.evaluations) as f64);
        }
    }
    times.into_iter().map(median).collect()
}

/// The middle one of `values`.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Result and duration of `f`, s.
pub fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let begin = Instant::now();
    let value = f();
    (value, begin.elapsed().as_secs_f64())
}
