//! How files are written: whole or not at all, whatever stops the program; how CSV is read.

use std::fs::{self, OpenOptions};
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Links that are followed at most, as the system does.
const LINKS: usize = 40;

/// Held while there is a file or folder under a temporary name.
static TEMPORARY: Mutex<()> = Mutex::new(());

/// Runs `work`, which makes temporary files and removes or renames them before it returns, after any other such work. A
/// signal handler that ends the program in here leaves none behind. Not to be nested; [`write_whole`] is such work.
pub fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    // Work that panicked has left nothing to protect.
    let _held = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    work()
}

/// Writes `bytes` to `path`, whole or not at all: to a temporary file in the same folder, which then takes the
/// name. A link is followed; what is no regular file (a device, a pipe) is written through.
///
/// # Errors
/// What the system says; nothing is left behind then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let path = followed(path);
    if is_special(&path) {
        return OpenOptions::new().write(true).open(&path)?.write_all(bytes);
    }
    uninterrupted(|| {
        let file = beside(&path)?;
        // To the file itself: what fails through its handle names the temporary name.
        file.as_file().write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(&path)?;
        Ok(())
    })
}

/// Whether [`write_whole`] could write `path` now, so that this is known before the work whose result it shall take.
///
/// # Errors
/// What the system says.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let path = followed(path);
    if is_special(&path) {
        return OpenOptions::new().write(true).open(&path).map(drop);
    }
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    uninterrupted(|| beside(&path).map(drop))
}

/// What helps where a file could not be written for this reason.
pub fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "make room, or name a file elsewhere"
        }
        _ => "name a file in a folder that exists and can be written",
    }
}

/// Where the links at `path` lead.
fn followed(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        let Ok(target) = fs::read_link(&path) else {
            break;
        };
        path = folder(&path).join(target);
    }
    path
}

/// Opens the file at `path` to read it.
///
/// # Errors
/// Those of the system, and a pipe or a device: whoever reads one may wait for ever.
pub fn open(path: &Path) -> io::Result<fs::File> {
    match is_special(path) {
        true => Err(io::Error::other("it is a pipe or a device, and no file")),
        false => fs::File::open(path),
    }
}

fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of `path`.
fn beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // The user's umask decides, as for any other file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.prefix(".gearmesh-").tempfile_in(folder(path));
    made.map_err(|error| {
        // What the system says, without the temporary name, which means nothing to the user.
        let said = error.get_ref().and_then(std::error::Error::source);
        let said = said.map_or_else(|| error.kind().to_string(), ToString::to_string);
        let tried = format!("making a file in the folder {}", folder(path).display());
        io::Error::new(error.kind(), format!("{tried} failed: {said}"))
    })
}

/// A reader of CSV `text` in which blanks stand around cells and lines that begin with # are remarks.
pub fn csv_reader(text: &str) -> csv::Reader<Cursor<String>> {
    // The reader counts a line only at its \n, after the place of the next one, and ends remarks nowhere else.
    let text = Cursor::new(text.replace("\r\n", "\n").replace('\r', "\n"));
    let mut builder = csv::ReaderBuilder::new();
    builder
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_target_that_cannot_be_is_refused_beforehand_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        for path in [&taken, &folder.path().join("missing/out.json")] {
            check_writable(path).unwrap_err();
            let error = write_whole(path, b"x").unwrap_err().to_string();
            assert!(!error.contains(".gearmesh-"), "{error}");
        }
        let lost = folder.path().join("missing");
        let error = check_writable(&lost.join("out.json")).unwrap_err();
        let tried = format!("making a file in the folder {} failed: ", lost.display());
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().starts_with(&tried), "{error}");
        assert!(error.to_string().len() > tried.len(), "{error}");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn rows_and_their_lines_are_the_same_however_lines_end() {
        let text = "# remark\na, b\n1,2\n3,4\n";
        for ending in ["\n", "\r\n", "\r"] {
            let rows = csv_reader(&text.replace('\n', ending)).into_records();
            let rows = rows.map(|row| row.unwrap());
            let rows = rows.map(|row| (row.position().unwrap().line(), row[1].to_owned()));
            let rows: Vec<_> = rows.collect();
            assert_eq!(rows, [(3, "2".into()), (4, "4".into())], "{ending:?}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_written_through() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link, dangling, device] =
            ["file", "link", "dangling", "null"].map(|name| folder.path().join(name));
        fs::write(&file, b"old").unwrap();
        symlink("file", &link).unwrap();
        symlink(folder.path().join("new"), &dangling).unwrap();
        symlink("/dev/null", &device).unwrap();
        for path in [&link, &dangling, &device] {
            check_writable(path).unwrap();
            write_whole(path, b"bytes").unwrap();
            assert!(path.is_symlink(), "{}", path.display());
        }
        assert_eq!(fs::read(&file).unwrap(), b"bytes");
        assert_eq!(fs::read(folder.path().join("new")).unwrap(), b"bytes");
        let null = fs::metadata("/dev/null").unwrap();
        assert!(null.file_type().is_char_device());
        assert_eq!(entries(folder.path()), 5);
    }
}
