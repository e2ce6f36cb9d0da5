//! Writes the tables of docs/data.

use clap::Parser;
use gearmesh_validation::data::Data;
use gearmesh_validation::{
    Context, Result, contact_at_run_time, finite_elements, in_repository, speed_accuracy,
    stability, tables, timing,
};
use std::path::PathBuf;
use std::time::Instant;

/// Measures something and writes its tables.
type Chapter = fn(&Context, &Data) -> Result<()>;

const MACHINE: Chapter = |_, data| timing::machine(data);

/// By folder of docs/data and name, a line each.
#[rustfmt::skip]
const CHAPTERS: &[(&str, &str, Chapter)] = &[
    ("stability", "energy", stability::energy::report),
    ("stability", "oscillator", stability::oscillator::report),
    ("stability", "rattle", stability::rattle::report),
    ("stability", "cosimulation", stability::cosimulation::report),
    ("stability", "masters", stability::masters::report),
    ("stability", "continuity", stability::continuity::report),
    ("finite-elements", "machine", MACHINE),
    ("finite-elements", "plane-strain", finite_elements::plane::report),
    ("finite-elements", "reference", finite_elements::reference::report),
    ("finite-elements", "convergence", finite_elements::convergence::report),
    ("finite-elements", "held", finite_elements::held::report),
    ("finite-elements", "levels", finite_elements::levels),
    ("finite-elements", "cost", finite_elements::cost::report),
    ("finite-elements", "mesh", finite_elements::mesh::report),
    ("speed-accuracy", "machine", MACHINE),
    ("speed-accuracy", "interpolants", speed_accuracy::interpolants::report),
    ("speed-accuracy", "instances", speed_accuracy::instances::report),
    ("speed-accuracy", "cost-per-second", speed_accuracy::hosts::cost),
    ("speed-accuracy", "run-up", speed_accuracy::run_up::report),
    ("speed-accuracy", "levels", speed_accuracy::levels::report),
    ("contact-at-run-time", "index-errors", contact_at_run_time::index_errors::report),
    ("contact-at-run-time", "stations", contact_at_run_time::stations::report),
    ("contact-at-run-time", "cost", contact_at_run_time::cost::report),
    ("tables", "bodies", tables::bodies::report),
    ("tables", "edges", tables::edges::report),
];

/// Measures what docs/ says of gearmesh.
#[derive(Parser)]
struct Arguments {
    /// FOLDER/CHAPTER or its beginning, with the folders of docs/data; all where none is given.
    chapters: Vec<String>,
    /// Fewer points and coarser elements: for trying out, not for the record.
    #[arg(long)]
    quick: bool,
    /// Where tables go; docs/data unless given.
    #[arg(long)]
    data: Option<PathBuf>,
    /// Interpreter that has fmpy.
    #[arg(long, default_value = ".venv/bin/python")]
    python: String,
    /// Of the chapter on cost, which measures memory in a process of its own.
    #[arg(long, hide = true, num_args = 2)]
    measure: Option<Vec<String>>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(measure) = arguments.measure {
        return finite_elements::cost::measure(&measure[0], &measure[1]);
    }
    let context = Context {
        quick: arguments.quick,
        python: arguments.python,
    };
    let chosen = arguments.chapters;
    let data = arguments.data.unwrap_or_else(|| in_repository("docs/data"));
    let start = Instant::now();
    let names = CHAPTERS
        .iter()
        .map(|(folder, chapter, _)| format!("{folder}/{chapter}"));
    let names: Vec<String> = names.collect();
    for begin in &chosen {
        if !names.iter().any(|name| name.starts_with(begin)) {
            return Err(format!("{begin}: no such chapter, only {}", names.join(", ")).into());
        }
    }
    for (name, (folder, _, run)) in names.iter().zip(CHAPTERS) {
        if chosen.is_empty() || chosen.iter().any(|begin| name.starts_with(begin)) {
            eprintln!("[{:6.1} s] {name}", start.elapsed().as_secs_f64());
            run(&context, &Data(data.join(folder)))?;
        }
    }
    Ok(())
}
