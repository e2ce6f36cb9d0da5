//! Time and memory: compliance, one contact solve, a full table, a changed modification.

use crate::cases::{Models, shipped};
use crate::page::{Outcome, table, verdict};
use gearmesh::compliance::finite_element::{PairCompliance, Settings};
use gearmesh::contact::{ContactResult, MAXIMUM_ITERATIONS};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::Axes;
use gearmesh::table::plan::{displacement_nodes, mesh_positions};
use gearmesh::table::source::WatchedSolver;
use gearmesh::table::sweep::{Watch, sweep};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// First argument of this program where it is to measure one elastic model and nothing else.
pub const MEASURE: &str = "--measure";

const PAIR: &str = "palermo2013";
const SHIPPED: &str = "resources/pairs";
const DRIVELINES: &str = "examples/drivelines/pairs";

/// Prints seconds, processor seconds and the largest memory (MB) of the elastic models of the pair file `path`.
pub fn measure(path: &str, level: &str) -> Outcome<()> {
    let mut pair = Pair::read(path)?;
    pair.refinement = match level {
        "coarse" => Refinement::Coarse,
        "normal" => Refinement::Normal,
        "fine" => Refinement::Fine,
        _ => return Err(format!("{level}: coarse, normal or fine").into()),
    };
    let begin = Instant::now();
    let settings = Settings::for_pair(&pair);
    let models = PairCompliance::new(&pair.geometry, &settings, None, &|_, _, _| true)?;
    let seconds = begin.elapsed().as_secs_f64();
    let unknowns = models.gears.iter().map(|g| g.cost().unknowns).max();
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"));
    let kilobytes: f64 = line
        .and_then(|l| l.split_whitespace().nth(1))
        .ok_or("no VmHWM in /proc/self/status")?
        .parse()?;
    println!(
        "{seconds} {} {} {}",
        processor_seconds()?,
        kilobytes / 1024.0,
        unknowns.unwrap_or(0)
    );
    Ok(())
}

/// Processor time of this process so far, s.
fn processor_seconds() -> Outcome<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    // Fields 14 and 15, in hundredths of a second on Linux; the name in parentheses may hold spaces.
    let rest = stat.rsplit(')').next().unwrap_or_default();
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks: f64 = fields[11].parse::<f64>()? + fields[12].parse::<f64>()?;
    Ok(ticks / 100.0)
}

/// The chapter.
pub fn report(models: &Models, _: &Path) -> Outcome<String> {
    let mut text = format!(
        "Wall-clock times on {} threads, load of the machine as said on top; processor time is the sum over the threads. \
         Memory is the largest resident set (VmHWM) of a process that computes the elastic models of both gears and nothing \
         else.\n\n",
        rayon::current_num_threads()
    );
    text += &compliance()?;
    text += &contact(models)?;
    text += &new_unit()?;
    Ok(text)
}

fn compliance() -> Outcome<String> {
    let program = std::env::current_exe()?;
    let mut rows = vec![];
    let mut normal = [0.0; 3];
    let mut longest = 0.0f64;
    for (folder, pair, level) in [
        (SHIPPED, PAIR, "coarse"),
        (SHIPPED, PAIR, "normal"),
        (SHIPPED, PAIR, "fine"),
        (SHIPPED, "fzg-c", "normal"),
        (SHIPPED, "helical-25-47", "normal"),
        (SHIPPED, "planet-ring-27-84", "normal"),
        (DRIVELINES, "spur-50-50", "normal"),
        (DRIVELINES, "grc-sun-planet", "normal"),
        (DRIVELINES, "grc-planet-ring", "normal"),
    ] {
        eprintln!("    {pair}, {level}");
        let output = Command::new(&program)
            .args([MEASURE, &format!("{folder}/{pair}.json"), level])
            .output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        let line = String::from_utf8(output.stdout)?;
        let numbers = line
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<Vec<f64>, _>>()?;
        let [seconds, processor, megabytes, unknowns] = numbers[..] else {
            return Err(format!("unexpected output: {line}").into());
        };
        if (pair, level) == (PAIR, "normal") {
            normal = [seconds, processor, megabytes];
        }
        if level == "normal" {
            longest = longest.max(seconds);
        }
        rows.push([
            format!("{pair}, {level}"),
            format!("{unknowns:.0}"),
            format!("{seconds:.1}"),
            format!("{processor:.1}"),
            format!("{megabytes:.0}"),
        ]);
    }
    Ok(format!(
        "**Compliance**, both gears (equal gears share one model). Bars: the reference pair at level normal under 60 s and 3 GB: \
         {}; every shipped or example pair at level normal under 20 s: {}.\n\n{}",
        verdict(normal[0] < 60.0 && normal[2] < 3072.0),
        verdict(longest < 20.0),
        table(
            [
                "pair, level",
                "unknowns of the larger sector",
                "s",
                "processor s",
                "peak memory, MB"
            ],
            &rows
        )
    ))
}

fn contact(models: &Models) -> Outcome<String> {
    let pair = shipped(PAIR)?;
    let solver = models.solver(&pair)?;
    let (mut warm, mut cold, mut set_up) = (vec![], vec![], vec![]);
    let mut most = 0;
    for i in 0..24 {
        let begin = Instant::now();
        let problem = solver.position(Flank::Drive, f64::from(i) / 24.0, 0.0)?;
        set_up.push(begin.elapsed().as_secs_f64());
        let mut last: Option<ContactResult> = None;
        for k in 0..40 {
            let torque = 200.0 * (1.0 - f64::from(k) / 40.0);
            let misalignment = 1e-3 * f64::from(i % 7 - 3);
            let mut timed = |start: Option<&ContactResult>| -> Outcome<(ContactResult, f64)> {
                let begin = Instant::now();
                let result = problem.solve_torque(torque, misalignment, start)?;
                most = most.max(result.iterations);
                Ok((result, begin.elapsed().as_secs_f64()))
            };
            cold.push(timed(None)?.1);
            let (result, seconds) = timed(last.as_ref())?;
            warm.push(seconds);
            last = Some(result);
        }
    }
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        1e3 * v[v.len() / 2]
    };
    let (warm, cold, set_up) = (median(warm), median(cold), median(set_up));

    eprintln!("    table of 10 x 32 x 9 x 9");
    let even = |[low, high]: [f64; 2]| -> Vec<f64> {
        (0..9)
            .map(|i| low + (high - low) * f64::from(i) / 8.0)
            .collect()
    };
    let axes = Axes {
        displacement_fraction: displacement_nodes(10, 1.6),
        center_distance_offset: even(pair.operating.center_distance_offset),
        misalignment: even(pair.operating.misalignment),
        mesh_position: mesh_positions(32),
    };
    let source = WatchedSolver::new(&solver);
    let cancel = AtomicBool::new(false);
    let watch = Watch {
        progress: &|_, _| {},
        cancel: &cancel,
    };
    let begin = Instant::now();
    sweep(
        &source,
        Flank::Drive,
        &axes,
        pair.operating.maximum_torque,
        &watch,
    )?;
    let seconds = begin.elapsed().as_secs_f64();
    let quality = source.quality();
    Ok(format!(
        "**Contact** of {PAIR}, one thread: median of 960 solves {warm:.2} ms from the solution at the next load, {cold:.2} ms from \
         nothing (at most {most} Newton steps); bar 1 ms: {}. The influence matrix of a position takes {set_up:.1} ms once for all \
         its loads and misalignments.\n\n\
         **Full table** of 10 displacements × 32 mesh positions × 9 centre distances × 9 misalignments after compliance: \
         **{seconds:.1} s**, {} solves, at most {} Newton steps of {MAXIMUM_ITERATIONS} allowed, KKT residual {:.1e} at most. Bar \
         60 s: {}.\n\n",
        verdict(warm < 1.0),
        quality.solves,
        quality.most_iterations,
        quality.kkt_residual,
        verdict(seconds < 60.0)
    ))
}

/// `gearmesh build` of a pair whose elastic model is kept, with another tip relief.
fn new_unit() -> Outcome<String> {
    let program = program()?;
    let folder = std::env::temp_dir().join(format!("gearmesh-cost-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let result = changed_relief(&program, &folder);
    std::fs::remove_dir_all(&folder)?;
    let [first, second] = result?;
    Ok(format!(
        "**Changed modification to new FMU**: `gearmesh build` of {PAIR} with its default grid takes {first:.1} s from the \
         drawing and {second:.1} s when only tip relief and crowning are changed, since the elastic model is kept. \
         Bar 60 s: {}.\n",
        verdict(second < 60.0)
    ))
}

/// Seconds of the first build and of that after the change.
fn changed_relief(program: &Path, folder: &Path) -> Outcome<[f64; 2]> {
    let mut pair: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(format!(
        "resources/pairs/{PAIR}.json"
    ))?)?;
    let build = |pair: &serde_json::Value| -> Outcome<(f64, String)> {
        let file = folder.join("pair.json");
        std::fs::write(&file, pair.to_string())?;
        let begin = Instant::now();
        let output = Command::new(program)
            .arg("build")
            .arg(&file)
            .arg("-o")
            .arg(folder.join("pair.fmu"))
            .arg("--cache-dir")
            .arg(folder)
            .output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        Ok((
            begin.elapsed().as_secs_f64(),
            String::from_utf8(output.stdout)?,
        ))
    };
    eprintln!("    gearmesh build, twice");
    let (first, _) = build(&pair)?;
    pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into();
    pair["gear2"]["lead_crowning_um"] = 6.0.into();
    let (second, said) = build(&pair)?;
    if !said.contains("read from") {
        return Err(format!("the elastic model was not found again: {said}").into());
    }
    // The pair is read as the command reads it, so that a wrong change is not timed.
    Pair::read(folder.join("pair.json"))?;
    Ok([first, second])
}

/// The command beside this program.
fn program() -> Outcome<PathBuf> {
    let here = std::env::current_exe()?;
    let folder = here
        .parent()
        .and_then(Path::parent)
        .ok_or("no folder of programs")?;
    let program = folder.join("gearmesh");
    if program.exists() {
        Ok(program)
    } else {
        Err(format!(
            "{} is missing; run `cargo build --release` first",
            program.display()
        )
        .into())
    }
}
