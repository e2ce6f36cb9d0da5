//! The command `gearmesh`: from the pair file to tables, an FMU and a report.
//!
//! Results go to standard output, progress and errors to standard error, and the exit status is 0 only when the whole
//! thing was done.

#[macro_use]
mod error;

mod bands;
mod cache;
mod case;
mod columns;
mod inspect;
mod limits;
mod model;
mod new;
mod output;
mod pack;
mod page;
mod pair_summary;
mod recipe;
mod report;
mod revolution;
mod run_up;
mod solve;
mod statistics;
mod study;
mod tables;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use error::Result;
use gearmesh_preprocessor::storage::uninterrupted;

/// Gear contact for multibody and system simulation: static tooth contact, tables, FMI 2.0 units.
#[derive(Debug, Parser)]
#[command(name = "gearmesh", version, propagate_version = true)]
// A value such as -10 is no option: it is for the option's own limits to refuse it.
#[command(mut_subcommands(|command| command.allow_negative_numbers(true)))]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    New(new::New),
    Solve(solve::Solve),
    Tables(tables::Tables),
    Import(tables::Import),
    Build(pack::Build),
    Pack(pack::Pack),
    Inspect(inspect::Inspect),
    Report(report::Report),
    Study(study::Study),
    RunUp(run_up::RunUpCommand),
    Cache(cache::Cache),
}

/// From now on the signals to interrupt and to terminate end the process after the file that is being written.
fn stop_on_signals() -> Result<()> {
    ctrlc::set_handler(|| {
        uninterrupted(|| {
            eprintln!("gearmesh: stopped; no unfinished file is left");
            // As shells give it: 128 + SIGINT.
            std::process::exit(130);
        })
    })
    .map_err(|e| format!("cannot watch for Ctrl-C: {e}").into())
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    let result = stop_on_signals().and_then(|()| match command {
        Command::New(command) => command.run(),
        Command::Solve(command) => command.run(),
        Command::Tables(command) => command.run(),
        Command::Import(command) => command.run(),
        Command::Build(command) => command.run(),
        Command::Pack(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Report(command) => command.run(),
        Command::Study(command) => command.run(),
        Command::RunUp(command) => command.run(),
        Command::Cache(command) => command.run(),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("gearmesh: error: {}", error::chain(error.as_ref()));
            ExitCode::FAILURE
        }
    }
}
