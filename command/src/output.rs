//! Text to standard output, progress to standard error, whole files to disk.

use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use gearmesh_preprocessor::storage;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use serde::de::IgnoredAny;

use crate::error::{Error, Result};

/// Writes `bytes` to `path`, whole or not at all: see [`storage::write_whole`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    storage::write_whole(path, bytes).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &io::Error) -> Error {
    let (path, remedy) = (path.display(), storage::remedy(error));
    format!("cannot write {path}: {error}; {remedy}").into()
}

/// Refuses `path` before the work whose result it shall take, where it cannot be written or is one of the files `read`.
pub fn check_writable<P: AsRef<Path>>(
    path: &Path,
    read: impl IntoIterator<Item = P>,
) -> Result<()> {
    let here = path.canonicalize().ok();
    for input in read {
        let input = input.as_ref();
        if here.is_some() && input.canonicalize().ok() == here {
            let (path, input) = (path.display(), input.display());
            refuse!("--output {path} is {input}, which is read: give another file");
        }
    }
    storage::check_writable(path).map_err(|error| unwritable(path, &error))
}

pub fn make_folder(option: &str, path: &Path) -> Result<()> {
    if let Err(error) = std::fs::create_dir_all(path) {
        let failed = format!("{option} = {}: making this folder failed", path.display());
        refuse!("{failed}: {error}; name one that is there or can be made");
    }
    Ok(())
}

/// Longest text that is read, bytes: some hundred times the tables of a pair.
const LONGEST_TEXT: u64 = 256 << 20;

/// The text of tables or samples. A pair file has its own limit.
pub fn read_text(path: &Path) -> Result<String, String> {
    let name = path.display();
    let file = storage::open(path).map_err(|error| unreadable(path, &error))?;
    let mut text = String::new();
    // One byte more than allowed shows a longer file, even where no length is known.
    match file.take(LONGEST_TEXT + 1).read_to_string(&mut text) {
        Err(error) if error.kind() == io::ErrorKind::InvalidData => refuse!(
            "{name}: neither text in UTF-8 nor an archive; save it as UTF-8, or name a pair file, tables, samples or an FMU"
        ),
        Err(error) => Err(unreadable(path, &error)),
        Ok(length) if length as u64 > LONGEST_TEXT => refuse!(
            "{name}: longer than {} MB, and tables or samples of a pair have a few; name another file, or give fewer samples",
            LONGEST_TEXT >> 20
        ),
        Ok(_) => Ok(text),
    }
}

/// Tables say their format; a pair file does not.
pub fn is_tables(text: &str) -> bool {
    #[derive(serde::Deserialize)]
    struct Marks {
        format: Option<IgnoredAny>,
        axes: Option<IgnoredAny>,
    }
    serde_json::from_str::<Marks>(text)
        .is_ok_and(|marks| marks.format.is_some() && marks.axes.is_some())
}

pub fn unreadable(path: &Path, error: &io::Error) -> String {
    let path = path.display();
    format!("cannot read {path}: {error}; name a file that exists and that you may read")
}

/// Prints `text` to standard output. A reader that has gone away (`gearmesh ... | head`) is no error.
pub fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            refuse!("cannot write to standard output: {error}; send it elsewhere, or make room")
        }
        _ => Ok(()),
    }
}

/// The work of a command, whose progress is shown: on a terminal in one line that is written over and disappears when this
/// is dropped, else in a line now and then.
pub struct Job {
    line: ProgressBar,
    /// When the last line was printed where there is no terminal; None: quiet.
    printed: Option<Mutex<Instant>>,
}

/// Time between two lines where there is no terminal; short work says nothing.
const EVERY: Duration = Duration::from_secs(10);

impl Job {
    pub fn new(quiet: bool) -> Job {
        // Hides itself where standard error is no terminal.
        let target = match quiet {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        };
        let line = ProgressBar::with_draw_target(None, target);
        let line = line.with_finish(ProgressFinish::AndClear);
        if let Ok(style) = ProgressStyle::with_template("after {elapsed}: {msg}") {
            line.set_style(style);
        }
        Job {
            line,
            printed: (!quiet).then(|| Mutex::new(Instant::now())),
        }
    }

    /// A line that stays.
    pub fn note(&self, words: &str) {
        if self.printed.is_some() {
            self.line.suspend(|| eprintln!("gearmesh: {words}"));
        }
    }

    pub fn show(&self, stage: &str, share: f64) {
        let words = format!("{stage}, {:.0} %", 100.0 * share);
        if let (true, Some(printed)) = (self.line.is_hidden(), &self.printed) {
            let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
            if printed.elapsed() >= EVERY {
                *printed = Instant::now();
                let elapsed = HumanDuration(self.line.elapsed());
                eprintln!("gearmesh: after {elapsed}: {words}");
            }
        }
        self.line.set_message(words);
        self.line.tick();
    }
}
