//! Time and memory: compliance, one contact solve, a full table, a changed modification.

use crate::data::{Data, verdict};
use crate::setup::{Setup, compute, quiet, shipped};
use crate::timing::{median, timed};
use crate::{Context, Result, in_repository};
use gearmesh::contact::{ContactResult, MAXIMUM_ITERATIONS};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::finite_element::{Settings, sector_unknowns};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{WatchedSolver, sweep};
use std::path::Path;
use std::process::Command;

const PAIR: &str = "palermo2013";
const SHIPPED: &str = "resources/pairs";
const DRIVELINES: &str = "examples/drivelines/pairs";
const CASES: [(&str, &str, &str); 9] = [
    (SHIPPED, PAIR, "coarse"),
    (SHIPPED, PAIR, "normal"),
    (SHIPPED, PAIR, "fine"),
    (SHIPPED, "fzg-c", "normal"),
    (SHIPPED, "helical-25-47", "normal"),
    (SHIPPED, "planet-ring-27-84", "normal"),
    (DRIVELINES, "spur-50-50", "normal"),
    (DRIVELINES, "grc-sun-planet", "normal"),
    (DRIVELINES, "grc-planet-ring", "normal"),
];

/// Prints seconds, processor seconds, the largest memory (MB) and unknowns of the elastic models of the pair file `path`.
pub fn measure(path: &str, level: &str) -> Result<()> {
    let refinement: Refinement = serde_json::from_value(level.into())?;
    let pair = pair::read(path)?;
    let pair = Pair { refinement, ..pair };
    let settings = Settings::for_pair(&pair);
    let (models, seconds) = timed(|| compute(&pair, &settings));
    models?;
    let gears = pair.geometry.gears.each_ref();
    let [first, second] = gears.map(|gear| sector_unknowns(gear, &settings));
    let unknowns = first?.max(second?);
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"));
    let kilobytes = line.and_then(|l| l.split_whitespace().nth(1));
    let kilobytes: f64 = kilobytes.ok_or("no VmHWM in /proc/self/status")?.parse()?;
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    // Fields 14 and 15, in hundredths of a second on Linux; the name in parentheses may hold spaces.
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let times: Vec<&str> = fields.split_whitespace().skip(11).take(2).collect();
    let processor = (times[0].parse::<f64>()? + times[1].parse::<f64>()?) / 100.0;
    println!("{seconds} {processor} {} {unknowns}", kilobytes / 1024.0);
    Ok(())
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    compliance(context, data)?;
    let mut rows = contact(context)?;
    rows.extend(changed_relief()?);
    data.table(
        "contact-cost",
        "contact, tables, packing | found | bar",
        &rows,
    )
}

fn compliance(context: &Context, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for (folder, pair, level) in CASES.into_iter().take(if context.quick { 2 } else { 9 }) {
        eprintln!("    {pair}, {level}");
        // In a process of its own, whose memory is that of the models alone.
        let file = in_repository(&format!("{folder}/{pair}.json"));
        let mut command = Command::new(std::env::current_exe()?);
        let line = output(command.arg("--measure").arg(file).arg(level))?;
        let numbers = line.split_whitespace().map(str::parse);
        let numbers = numbers.collect::<std::result::Result<Vec<f64>, _>>()?;
        let [seconds, processor, megabytes, unknowns] = numbers[..] else {
            return Err(format!("unexpected output: {line}").into());
        };
        let times = format!("{seconds:.1} | {processor:.1}");
        rows.push(format!(
            "{pair}, {level} | {unknowns:.0} | {times} | {megabytes:.0}"
        ));
    }
    let head = "pair, level | unknowns of the larger sector | s | processor s | peak memory, MB";
    data.table("compliance-cost", head, &rows)
}

/// A row with the bar that a number is to stay below.
fn below(claim: &str, found: f64, digits: usize, bar: f64) -> String {
    format!(
        "{claim} | {found:.digits$} | {bar}: {}",
        verdict(found < bar)
    )
}

fn contact(context: &Context) -> Result<Vec<String>> {
    let pair = shipped(PAIR)?;
    let solver = context.models.solver(&pair)?;
    let setup = Setup { pair, solver };
    let (mut warm, mut cold, mut set_up) = (vec![], vec![], vec![]);
    let mut most = 0;
    for i in 0..24 {
        let tau = f64::from(i) / 24.0;
        let (problem, seconds) = timed(|| setup.solver.position(Flank::Drive, tau, 0.0));
        let problem = problem?;
        set_up.push(1e3 * seconds);
        let misalignment = 1e-3 * f64::from(i % 7 - 3);
        let mut last: Option<ContactResult> = None;
        for k in 0..40 {
            let torque = 200.0 * (1.0 - f64::from(k) / 40.0);
            let solve = |last| timed(|| problem.solve_torque(torque, misalignment, last));
            let ((fresh, cold_seconds), (result, seconds)) = (solve(None), solve(last.as_ref()));
            cold.push(1e3 * cold_seconds);
            warm.push(1e3 * seconds);
            let result = result?;
            most = most.max(fresh?.iterations).max(result.iterations);
            last = Some(result);
        }
    }
    let [warm, cold, set_up] = [warm, cold, set_up].map(median);

    eprintln!("    table of 10 x 32 x 9 x 9");
    let n = if context.quick { 3 } else { 9 };
    let axes = setup.axes([10, n, n, 32]);
    let source = WatchedSolver::new(&setup.solver);
    let torque = setup.pair.operating.maximum_torque;
    let (grid, seconds) = timed(|| sweep(&source, Flank::Drive, &axes, torque, &quiet()));
    grid?;
    let quality = source.quality();
    let claim =
        format!("{PAIR}, one thread: a solve from that at the next load, median of 960, ms");
    let table = "table of 10 displacements × 32 positions × 9 × 9 after compliance, s";
    Ok(vec![
        below(&claim, warm, 2, 1.0),
        format!("the same from nothing, ms | {cold:.2} |"),
        format!("Newton steps at most | {most} |"),
        format!("influence matrix of a position, once for all its loads, ms | {set_up:.1} |"),
        below(table, seconds, 1, 60.0),
        format!("its solves | {} |", quality.solves),
        format!(
            "its Newton steps at most | {} | {MAXIMUM_ITERATIONS}",
            quality.most_iterations
        ),
        format!(
            "largest residual of its contact conditions | {:.1e} |",
            quality.kkt_residual
        ),
    ])
}

/// `gearmesh build` of a pair from the drawing, and again with another tip relief, whose elastic model is cached.
fn changed_relief() -> Result<[String; 2]> {
    let program = std::env::current_exe()?.with_file_name("gearmesh");
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("pair.json");
    let build = |pair: &serde_json::Value| -> Result<(String, f64)> {
        std::fs::write(&file, pair.to_string())?;
        // Read as the command reads it, so that a wrong change is not timed.
        pair::read(&file)?;
        let mut command = Command::new(&program);
        command
            .arg("build")
            .arg(&file)
            .arg("-o")
            .arg(folder.path().join("pair.fmu"));
        let (printed, seconds) = timed(|| output(command.arg("--cache-dir").arg(folder.path())));
        Ok((printed?, seconds))
    };
    eprintln!("    gearmesh build, twice");
    let text = std::fs::read_to_string(in_repository(&format!("{SHIPPED}/{PAIR}.json")))?;
    let mut pair: serde_json::Value = serde_json::from_str(&text)?;
    let (_, first) = build(&pair)?;
    pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into();
    pair["gear2"]["lead_crowning_um"] = 6.0.into();
    let (printed, second) = build(&pair)?;
    if !printed.contains("read from") {
        return Err(format!("the elastic model was not found again: {printed}").into());
    }
    Ok([
        format!("`gearmesh build` with its default grid from the drawing, s | {first:.1} |"),
        below(
            "the same with only tip relief and crowning changed, s",
            second,
            1,
            60.0,
        ),
    ])
}

/// What `command` prints.
fn output(command: &mut Command) -> Result<String> {
    let name = Path::new(command.get_program()).display().to_string();
    let missing = |e| format!("{name}: {e}; `cargo build --release` makes it");
    let output = command.output().map_err(missing)?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    Ok(String::from_utf8(output.stdout)?)
}
