//! Time and memory: compliance, one contact solve, a full table, a changed modification.

use crate::data::{Data, fixed, verdict};
use crate::setup::{Setup, compute, quiet, shipped};
use crate::timing::{median, timed};
use crate::{Context, Result, in_repository, row};
use gearmesh::contact::ContactResult;
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::Axes;
use gearmesh_preprocessor::finite_element::{SectorMesh, Settings};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{WatchedSolver, displacement_nodes, mesh_positions, sweep};
use std::path::Path;
use std::process::Command;

const PAIR: &str = "palermo2013";
const SHIPPED: &str = "resources/pairs";
const DRIVELINES: &str = "examples/drivelines/pairs";
const LEVELS: [(&str, Refinement); 3] =
    [("coarse", Refinement::Coarse), ("normal", Refinement::Normal), ("fine", Refinement::Fine)];

/// Prints seconds, processor seconds, the largest memory (MB) and unknowns of the elastic models of the pair file `path`.
pub fn measure(path: &str, level: &str) -> Result<()> {
    let (_, refinement) = *LEVELS.iter().find(|l| l.0 == level).ok_or("coarse, normal or fine")?;
    let pair = Pair { refinement, ..pair::read(path)? };
    let settings = Settings::for_pair(&pair);
    let (models, seconds) = timed(|| compute(&pair, &settings));
    models?;
    let [first, second] = pair.geometry.gears.each_ref().map(|gear| SectorMesh::unknowns(gear, &settings));
    let unknowns = first?.max(second?);
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"));
    let kilobytes = line.and_then(|l| l.split_whitespace().nth(1)).ok_or("no VmHWM in /proc/self/status")?;
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    // Fields 14 and 15, in hundredths of a second on Linux; the name in parentheses may hold spaces.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let processor = (fields[11].parse::<f64>()? + fields[12].parse::<f64>()?) / 100.0;
    println!("{seconds} {processor} {} {unknowns}", kilobytes.parse::<f64>()? / 1024.0);
    Ok(())
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    compliance(context, data)?;
    let mut rows = contact(context)?;
    rows.extend(changed_relief()?);
    data.table("contact-cost", &["contact, tables, packing", "found", "bar"], &rows)
}

fn compliance(context: &Context, data: &Data) -> Result<()> {
    let mut cases = vec![(SHIPPED, PAIR, "coarse"), (SHIPPED, PAIR, "normal"), (SHIPPED, PAIR, "fine")];
    cases.extend(["fzg-c", "helical-25-47", "planet-ring-27-84"].map(|pair| (SHIPPED, pair, "normal")));
    cases.extend(["spur-50-50", "grc-sun-planet", "grc-planet-ring"].map(|pair| (DRIVELINES, pair, "normal")));
    let mut rows = vec![];
    for (folder, pair, level) in cases.into_iter().take(if context.quick { 2 } else { 9 }) {
        eprintln!("    {pair}, {level}");
        // In a process of its own, whose memory is that of the models alone.
        let file = in_repository(&format!("{folder}/{pair}.json"));
        let mut command = Command::new(std::env::current_exe()?);
        let line = output(command.arg("--measure").arg(file).arg(level))?;
        let numbers = line.split_whitespace().map(str::parse).collect::<std::result::Result<Vec<f64>, _>>()?;
        let [seconds, processor, megabytes, unknowns] = numbers[..] else {
            return Err(format!("unexpected output: {line}").into());
        };
        let name = format!("{pair}, {level}");
        rows.push(row![name, fixed(unknowns, 0), fixed(seconds, 1), fixed(processor, 1), fixed(megabytes, 0)]);
    }
    let head = ["pair, level", "unknowns of the larger sector", "s", "processor s", "peak memory, MB"];
    data.table("compliance-cost", &head, &rows)
}

fn contact(context: &Context) -> Result<Vec<Vec<String>>> {
    let pair = shipped(PAIR)?;
    let setup = Setup { solver: context.models.solver(&pair)?, pair };
    let (mut warm, mut cold, mut set_up) = (vec![], vec![], vec![]);
    let mut most = 0;
    for i in 0..24 {
        let (problem, seconds) = timed(|| setup.solver.position(Flank::Drive, f64::from(i) / 24.0, 0.0));
        let problem = problem?;
        set_up.push(1e3 * seconds);
        let mut last: Option<ContactResult> = None;
        for k in 0..40 {
            let (torque, misalignment) = (200.0 * (1.0 - f64::from(k) / 40.0), 1e-3 * f64::from(i % 7 - 3));
            let (fresh, seconds) = timed(|| problem.solve_torque(torque, misalignment, None));
            cold.push(1e3 * seconds);
            let (result, seconds) = timed(|| problem.solve_torque(torque, misalignment, last.as_ref()));
            warm.push(1e3 * seconds);
            let result = result?;
            most = most.max(fresh?.iterations).max(result.iterations);
            last = Some(result);
        }
    }
    let [warm, cold, set_up] = [warm, cold, set_up].map(median);

    eprintln!("    table of 10 x 32 x 9 x 9");
    let operating = &setup.pair.operating;
    let n = if context.quick { 3 } else { 9 };
    let axes = Axes {
        displacement_fraction: displacement_nodes(10, 1.6),
        center_distance_offset: crate::data::even(operating.center_distance_offset, n),
        misalignment: crate::data::even(operating.misalignment, n),
        mesh_position: mesh_positions(32),
    };
    let source = WatchedSolver::new(&setup.solver);
    let (grid, seconds) = timed(|| sweep(&source, Flank::Drive, &axes, operating.maximum_torque, &quiet()));
    grid?;
    let quality = source.quality();
    let bar = |bar: f64, found: f64| format!("{bar}: {}", verdict(found < bar));
    Ok(vec![
        row![
            format!("{PAIR}, one thread: a solve from that at the next load, median of 960, ms"),
            fixed(warm, 2),
            bar(1.0, warm)
        ],
        row!["the same from nothing, ms", fixed(cold, 2), ""],
        row!["Newton steps at most", most, ""],
        row!["influence matrix of a position, once for all its loads, ms", fixed(set_up, 1), ""],
        row![
            "table of 10 displacements × 32 positions × 9 × 9 after compliance, s",
            fixed(seconds, 1),
            bar(60.0, seconds)
        ],
        row!["its solves", quality.solves, ""],
        row!["its Newton steps at most", quality.most_iterations, gearmesh::contact::MAXIMUM_ITERATIONS],
        row!["largest residual of its contact conditions", format!("{:.1e}", quality.kkt_residual), ""],
    ])
}

/// `gearmesh build` of a pair from the drawing, and again with another tip relief, whose elastic model is kept.
fn changed_relief() -> Result<Vec<Vec<String>>> {
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
            .arg(folder.path().join("pair.fmu"))
            .arg("--cache-dir")
            .arg(folder.path());
        let (said, seconds) = timed(|| output(&mut command));
        Ok((said?, seconds))
    };
    eprintln!("    gearmesh build, twice");
    let text = std::fs::read_to_string(in_repository(&format!("{SHIPPED}/{PAIR}.json")))?;
    let mut pair: serde_json::Value = serde_json::from_str(&text)?;
    let (_, first) = build(&pair)?;
    pair["gear1"]["tip_relief"]["amount_um"] = 9.0.into();
    pair["gear2"]["lead_crowning_um"] = 6.0.into();
    let (said, second) = build(&pair)?;
    if !said.contains("read from") {
        return Err(format!("the elastic model was not found again: {said}").into());
    }
    let changed = format!("60: {}", verdict(second < 60.0));
    Ok(vec![
        row!["`gearmesh build` with its default grid from the drawing, s", fixed(first, 1), ""],
        row!["the same with only tip relief and crowning changed, s", fixed(second, 1), changed],
    ])
}

/// What `command` prints.
fn output(command: &mut Command) -> Result<String> {
    let name = Path::new(command.get_program()).display().to_string();
    let output = command.output().map_err(|e| format!("{name}: {e}; `cargo build --release` makes it"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    Ok(String::from_utf8(output.stdout)?)
}
