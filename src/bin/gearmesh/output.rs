//! Text to standard output, whole files to disk, errors in one line.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::interrupt;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}; name a file in a folder that exists and can be written", path.display())]
pub struct WriteError {
    path: PathBuf,
    source: io::Error,
}

/// Writes `bytes` to `path`, whole or not at all, Ctrl-C or not: to a temporary file in the same folder, which
/// then takes the name.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let write = || -> io::Result<()> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        // The user's umask decides, as for any other file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.prefix(".gearmesh-").tempfile_in(folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        Ok(())
    };
    interrupt::uninterrupted(write).map_err(|source| WriteError {
        path: path.to_owned(),
        source,
    })
}

/// What to say of a file that `error` keeps from being read.
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
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
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

/// Lines of `name  value unit` with the values aligned.
#[derive(Debug, Default)]
pub struct Listing {
    rows: Vec<(String, String)>,
}

impl Listing {
    /// Adds one row.
    pub fn row(&mut self, name: impl Into<String>, value: impl Into<String>) -> &mut Self {
        self.rows.push((name.into(), value.into()));
        self
    }
}

impl std::fmt::Display for Listing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let width = self
            .rows
            .iter()
            .map(|(name, _)| name.chars().count())
            .max()
            .unwrap_or(0);
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
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.json");
        write_whole(&path, b"first").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_in_a_missing_folder_is_refused_by_name() {
        let error = write_whole(Path::new("/no/such/folder/out.json"), b"x").unwrap_err();
        assert!(error.to_string().contains("/no/such/folder/out.json"));
    }

    #[test]
    fn a_chain_of_errors_is_one_line_and_says_nothing_twice() {
        let inner = io::Error::other("disk\nfull");
        let outer = WriteError {
            path: "a.fmu".into(),
            source: inner,
        };
        let line = chain(&outer);
        assert_eq!(line.matches("disk full").count(), 1, "{line}");
        assert!(!line.contains('\n'));
    }
}
