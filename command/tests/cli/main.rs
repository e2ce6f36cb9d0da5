//! The command line as a user meets it: exit status, standard output and standard error.

mod inspecting;
mod models;
mod reporting;
mod rexs;
mod solving;
mod studying;
mod tables;

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn gearmesh(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gearmesh"))
        .args(arguments)
        .output()
        .expect("the command starts")
}

fn pair_file(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .join("resources/pairs")
        .join(name)
}

/// Coarse finite elements, computed once for all tests.
const QUICK: [&str; 4] = [
    "--refinement",
    "coarse",
    "--cache-dir",
    concat!(env!("CARGO_TARGET_TMPDIR"), "/elastic-models"),
];

fn paper() -> String {
    pair_file("palermo2013.json").display().to_string()
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

fn solve_json(arguments: &[&str]) -> serde_json::Value {
    let pair = paper();
    let output = gearmesh(&[&["solve", &pair, "--json"], &QUICK[..], arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_str(stdout(&output)).expect("JSON")
}

/// Rows of a CSV file by column name.
fn rows(path: &Path) -> Vec<std::collections::HashMap<String, f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let columns = reader.headers().unwrap().clone();
    let row = |row: csv::StringRecord| {
        let number = |(name, value): (&str, &str)| Some((name.to_owned(), value.parse().ok()?));
        columns.iter().zip(&row).filter_map(number).collect()
    };
    reader.records().map(|r| row(r.unwrap())).collect()
}

fn succeed(arguments: &[&str]) -> Output {
    let output = gearmesh(arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        stderr(&output)
    );
    output
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let array = value.as_array().expect("an array");
    array
        .iter()
        .map(|v| v.as_f64().expect("a number"))
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
