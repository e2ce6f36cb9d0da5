//! The command line as a user meets it: exit status, standard output and standard error.

/// Folder of the shipped pair files.
macro_rules! pairs {
    () => {
        concat!(env!("CARGO_MANIFEST_DIR"), "/../resources/pairs/")
    };
}

/// Standard output of the command with these words, which does its work.
macro_rules! succeed {
    ($($line:tt)*) => {
        succeed(format!($($line)*))
    };
}

/// The command with these words is refused with all of the words after the semicolon.
macro_rules! refused {
    ($line:literal $(, $value:expr)*; $($word:expr),+) => {
        refused(format!($line $(, $value)*), &[$(&*$word),+])
    };
}

/// A text has all of these words.
macro_rules! contains {
    ($text:expr, $($word:expr),+ $(,)?) => {
        contains(AsRef::<str>::as_ref(&$text), &[$(&*$word),+])
    };
}

mod inspecting;
mod interrupt;
mod models;
mod new;
mod refusing;
mod reporting;
mod running_up;
mod solving;
mod studying;
mod tables;

use std::collections::HashMap;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Once;

use serde_json::Value;

const PAPER: &str = concat!(pairs!(), "palermo2013.json");

/// Coarse finite elements, computed once for all tests.
const QUICK: &str = concat!(
    "--refinement coarse --cache-dir ",
    env!("CARGO_TARGET_TMPDIR"),
    "/elastic-models"
);

/// Options of `new` for a small pair.
const NEW: &str = "--teeth 24 36 --module-mm 3 --face-width-mm 20 20 --torque-nm 100";

const REXS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rexs");

/// Tables over load and mesh position only.
const SMALL: &str = "--no-center-distance --no-misalignment";

/// The command, with the library that it packs in its folder, as after a build of the whole workspace.
fn command() -> Command {
    static LIBRARY: Once = Once::new();
    let program = Path::new(env!("CARGO_BIN_EXE_gearmesh"));
    LIBRARY.call_once(|| {
        let folder = program.parent().unwrap();
        let name = format!("{DLL_PREFIX}gearmesh{DLL_SUFFIX}");
        let link = folder.join(format!("{name}.{}", std::process::id()));
        std::fs::hard_link(folder.join("deps").join(&name), &link).unwrap();
        std::fs::rename(&link, folder.join(name)).unwrap();
        // It stays where both were the same file.
        let _ = std::fs::remove_file(link);
    });
    Command::new(program)
}

/// Runs the command with the words of `line`; %20 is a blank within a word.
fn run(line: impl AsRef<str>) -> Output {
    let words = line.as_ref().split_whitespace();
    let words = words.map(|word| word.replace("%20", " "));
    command().args(words).output().expect("the command starts")
}

/// What it prints when it does its work.
fn succeed(line: impl AsRef<str>) -> String {
    let output = run(&line);
    let error = text(&output.stderr);
    assert!(output.status.success(), "{}: {error}", line.as_ref());
    text(&output.stdout)
}

/// Runs a command that is refused, on standard error alone, with all of `words`: with status 2 for a wrong option, else
/// with status 1 in one line.
fn refused(line: impl AsRef<str>, words: &[&str]) {
    refusal(&run(&line), words);
}

fn refusal(output: &Output, words: &[&str]) {
    let error = text(&output.stderr);
    let is_one_line = error.lines().count() == 1;
    match output.status.code() {
        Some(1) => assert!(is_one_line, "{error}"),
        code => assert_eq!(code, Some(2), "{error}"),
    }
    assert_eq!(text(&output.stdout), "");
    contains(&error, words);
}

/// The first line of `text` with these words.
fn line<'t>(text: &'t str, words: &str) -> &'t str {
    let line = text.lines().find(|line| line.contains(words));
    line.unwrap_or_else(|| panic!("no {words} in {text}"))
}

/// Asserts that `text` has all of `words`.
fn contains(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word}: {text}");
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(text: impl AsRef<str>) -> Value {
    serde_json::from_str(text.as_ref()).expect("JSON")
}

/// JSON of the paper's pair with `options`.
fn solve_json(options: &str) -> Value {
    json(succeed!("solve {PAPER} --json {QUICK} {options}"))
}

/// A folder of its own for a test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    fn paths<const N: usize>(&self, names: [&str; N]) -> [String; N] {
        names.map(|name| self.path(name))
    }

    fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), contents).unwrap();
        self.path(name)
    }

    /// The paper's pair after `change` as pair.json.
    fn pair(&self, change: impl FnOnce(&mut Value)) -> String {
        let mut pair = json(std::fs::read_to_string(PAPER).unwrap());
        change(&mut pair);
        self.write("pair.json", pair.to_string())
    }

    fn read(&self, name: &str) -> String {
        text(&std::fs::read(self.path(name)).unwrap())
    }

    /// Rows of a CSV file by column name.
    fn rows(&self, name: &str) -> Vec<HashMap<String, f64>> {
        let mut reader = csv::Reader::from_path(self.path(name)).unwrap();
        let columns = reader.headers().unwrap().clone();
        let row = |row: csv::StringRecord| {
            let number = |(name, value): (&str, &str)| Some((name.to_owned(), value.parse().ok()?));
            columns.iter().zip(&row).filter_map(number).collect()
        };
        reader.records().map(|r| row(r.unwrap())).collect()
    }

    fn exists(&self, name: &str) -> bool {
        Path::new(&self.path(name)).exists()
    }

    fn count(&self, name: &str) -> usize {
        std::fs::read_dir(self.path(name)).unwrap().count()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().expect("an array");
    values.iter().map(number).collect()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::MIN, f64::max)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
