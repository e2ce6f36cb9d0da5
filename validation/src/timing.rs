//! Times of short functions on a machine that does other things, too, and what machine that is.

use crate::Result;
use crate::data::Data;
use std::hint::black_box;
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
    /// Evaluates `f` at each of `points`.
    pub fn over<T, R>(points: &'a [T], mut f: impl FnMut(&T) -> R + 'a) -> Self {
        let run = move || {
            for x in points {
                let _ = black_box(f(black_box(x)));
            }
        };
        Candidate {
            evaluations: points.len(),
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

/// Writes machine.csv: date, processor, compiler, load.
pub fn machine(data: &Data) -> Result<()> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let (cpu_info, load) = (read("/proc/cpuinfo"), read("/proc/loadavg"));
    let field = |name: &str| {
        let line = cpu_info.lines().find(|l| l.starts_with(name));
        let value = line.and_then(|l| l.split_once(':'));
        value.map_or("unknown", |(_, value)| value.trim())
    };
    let printed = |program: &str, argument: &str| {
        let output = std::process::Command::new(program).arg(argument).output();
        output.map_or("unknown".to_owned(), |o| {
            String::from_utf8_lossy(&o.stdout).into_owned()
        })
    };
    let [model, number, stepping] = ["model name", "model\t", "stepping"].map(field);
    let processors = std::thread::available_parallelism()?;
    let load = load.split(' ').next().unwrap_or_default();
    let rows = [
        format!("date | {}", printed("date", "+%F")),
        format!("processor | {model} (model {number}, stepping {stepping})"),
        format!("processors to this process | {processors}"),
        format!("compiler | {}", printed("rustc", "--version")),
        format!("load average of one minute at the start | {load}"),
    ];
    data.table("machine", "property | value", &rows)
}
