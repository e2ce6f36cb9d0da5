//! Text to standard output, whole files to disk, errors in one line.

use std::io::{self, Read, Write};
use std::path::Path;

use gearmesh::words::{shown, shown_in_full};
use gearmesh_preprocessor::storage;

/// Writes `bytes` to `path`, whole or not at all: see [`storage::write_whole`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    storage::write_whole(path, bytes).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &io::Error) -> String {
    format!(
        "cannot write {}: {error}; name a file in a folder that exists and can be written",
        path.display()
    )
}

/// Refuses `path` before the work whose result it shall take, where it cannot be written or is one of the files `read`.
pub fn check_writable<P: AsRef<Path>>(
    path: &Path,
    read: impl IntoIterator<Item = P>,
) -> Result<(), String> {
    let known = |path: &Path| path.canonicalize().ok();
    let here = known(path);
    for input in read {
        let input = input.as_ref();
        if here.is_some() && known(input) == here {
            let (path, input) = (path.display(), input.display());
            refuse!("--output {path} is {input}, which is read: give another file");
        }
    }
    storage::check_writable(path).map_err(|error| unwritable(path, &error))
}

pub fn make_folder(option: &str, path: &Path) -> Result<(), String> {
    std::fs::create_dir_all(path).map_err(|error| {
        format!(
            "{option} = {}: making this folder failed: {error}; name one that is there or can be made",
            path.display()
        )
    })
}

/// Longest text that is read, bytes: some hundred times the tables of a pair.
const LONGEST_TEXT: u64 = 256 << 20;

/// The text of tables or samples. A pair file has its own limit.
pub fn read_text(path: &Path) -> Result<String, String> {
    let name = path.display();
    let file = std::fs::File::open(path).map_err(|error| unreadable(path, &error))?;
    let mut text = String::new();
    // One byte more than allowed shows a longer file, even where no length is known.
    match file.take(LONGEST_TEXT + 1).read_to_string(&mut text) {
        Err(error) if error.kind() == io::ErrorKind::InvalidData => refuse!(
            "{name}: neither text nor an archive; name a pair file, tables, samples or an FMU"
        ),
        Err(error) => Err(unreadable(path, &error)),
        Ok(length) if length as u64 > LONGEST_TEXT => refuse!(
            "{name}: longer than {} MB, and tables or samples of a pair have a few; name another file, or give fewer samples",
            LONGEST_TEXT >> 20
        ),
        Ok(_) => Ok(text),
    }
}

pub fn unreadable(path: &Path, error: &io::Error) -> String {
    format!(
        "cannot read {}: {error}; name a file that exists and that you may read",
        path.display()
    )
}

/// Prints `text` to standard output. A reader that has gone away (`gearmesh ... | head`) is no error.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(io::Error::other(format!(
            "cannot write to standard output: {error}; send it elsewhere, or make room"
        ))),
        _ => Ok(()),
    }
}

/// An error and its causes on one line. A cause whose text the line contains already is left out.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !line.contains(&text) {
            line.push_str(": ");
            line.push_str(&text);
        }
        cause = error.source();
    }
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Adds rows `name => format, values;` to a [`Listing`].
macro_rules! rows {
    ($rows:expr; $($name:expr => $format:literal $(, $value:expr)*;)*) => {
        $($rows.row($name, format!($format $(, $value)*));)*
    };
}
pub(crate) use rows;

/// Lines of `name  value unit` with the values aligned.
#[derive(Debug, Default)]
pub struct Listing {
    rows: Vec<(String, String)>,
}

impl Listing {
    pub fn row(&mut self, name: impl AsRef<str>, value: impl AsRef<str>) {
        // Either may come from a file that somebody else wrote.
        let row = (shown(name.as_ref()), shown_in_full(value.as_ref()));
        self.rows.push(row);
    }

    pub fn in_one_line(&self) -> String {
        let row = |(name, value): &(String, String)| format!("{name} {value}");
        self.rows.iter().map(row).collect::<Vec<_>>().join("; ")
    }
}

impl std::fmt::Display for Listing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let widths = self.rows.iter().map(|(name, _)| name.chars().count());
        let width = widths.max().unwrap_or(0);
        for (name, value) in &self.rows {
            writeln!(f, "  {name:width$}  {value}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_errors_is_one_line_and_says_nothing_twice() {
        let inner = io::Error::other("disk\nfull");
        let line = chain(&io::Error::other(inner));
        assert_eq!(line.matches("disk full").count(), 1, "{line}");
        assert!(!line.contains('\n'));
    }
}
