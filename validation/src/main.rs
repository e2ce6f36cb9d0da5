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

const FOLDERS: [(&str, &[(&str, Chapter)]); 5] = [
    (
        "stability",
        &[
            ("energy", stability::energy::report),
            ("oscillator", stability::oscillator::report),
            ("rattle", stability::rattle::report),
            ("cosimulation", stability::cosimulation::report),
            ("masters", stability::masters::report),
            ("continuity", stability::continuity::report),
        ],
    ),
    (
        "finite-elements",
        &[
            ("machine", MACHINE),
            ("plane-strain", finite_elements::plane::report),
            ("reference", finite_elements::reference::report),
            ("convergence", finite_elements::convergence::report),
            ("held", finite_elements::held::report),
            ("levels", finite_elements::levels),
            ("cost", finite_elements::cost::report),
            ("mesh", finite_elements::mesh::report),
        ],
    ),
    (
        "speed-accuracy",
        &[
            ("machine", MACHINE),
            ("interpolants", speed_accuracy::interpolants::report),
            ("instances", speed_accuracy::instances::report),
            ("cost-per-second", speed_accuracy::hosts::cost),
            ("run-up", speed_accuracy::run_up::report),
            ("levels", speed_accuracy::levels::report),
        ],
    ),
    (
        "contact-at-run-time",
        &[
            ("index-errors", contact_at_run_time::index_errors::report),
            ("stations", contact_at_run_time::stations::report),
            ("cost", contact_at_run_time::cost::report),
        ],
    ),
    (
        "tables",
        &[
            ("bodies", tables::bodies::report),
            ("edges", tables::edges::report),
        ],
    ),
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
    let mut known = vec![];
    for (folder, chapters) in FOLDERS {
        for (chapter, run) in chapters {
            known.push((format!("{folder}/{chapter}"), folder, run));
        }
    }
    let chosen_names = |name: &str| chosen.iter().any(|begin| name.starts_with(begin));
    for begin in &chosen {
        if !known.iter().any(|(name, ..)| name.starts_with(begin)) {
            let names: Vec<_> = known.iter().map(|(name, ..)| name.as_str()).collect();
            return Err(format!("{begin}: no such chapter, only {}", names.join(", ")).into());
        }
    }
    for (name, folder, run) in &known {
        if chosen.is_empty() || chosen_names(name) {
            eprintln!("[{:6.1} s] {name}", start.elapsed().as_secs_f64());
            run(&context, &Data(data.join(folder)))?;
        }
    }
    Ok(())
}
