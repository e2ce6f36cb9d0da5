//! The zip file: reproducible, and whole or not there.

use std::io::{Cursor, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::PackageError;
use crate::storage::write_whole;

/// Writes `files` (name with forward slashes, contents) in the order of their names to `out` and
/// returns the size. The same files give the same bytes.
pub(super) fn write(files: &[(String, Vec<u8>)], out: &Path) -> Result<u64, PackageError> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // The time is the earliest that zip knows, so that it does not enter the bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut sorted: Vec<_> = files.iter().collect();
    sorted.sort();
    for (name, bytes) in sorted {
        let mode = if name.starts_with("binaries/") {
            0o755
        } else {
            0o644
        };
        archive
            .start_file(name.as_str(), options.unix_permissions(mode))
            .map_err(|e| PackageError::archive(out, e))?;
        archive
            .write_all(bytes)
            .map_err(|e| PackageError::file(out, e))?;
    }
    let archive = archive
        .finish()
        .map_err(|e| PackageError::archive(out, e))?
        .into_inner();
    write_whole(out, &archive).map_err(|e| PackageError::file(out, e))?;
    Ok(archive.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().unwrap()
    }

    #[test]
    fn the_same_files_give_the_same_bytes_in_any_order() {
        let folder = folder();
        let (one, two) = (folder.path().join("one.fmu"), folder.path().join("two.fmu"));
        let mut files = vec![
            ("resources/a.json".to_owned(), b"{}".to_vec()),
            ("binaries/linux64/G.so".to_owned(), vec![7; 1000]),
        ];
        write(&files, &one).unwrap();
        files.reverse();
        let size = write(&files, &two).unwrap();
        let bytes = fs::read(&one).unwrap();
        assert_eq!(bytes, fs::read(&two).unwrap());
        assert_eq!(bytes.len() as u64, size);
        let mut archive = zip::ZipArchive::new(File::open(&one).unwrap()).unwrap();
        let names: Vec<String> = (0..archive.len())
            .map(|i| archive.by_index(i).unwrap().name().to_owned())
            .collect();
        assert_eq!(names, ["binaries/linux64/G.so", "resources/a.json"]);
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_nothing() {
        let folder = folder();
        let out = folder.path().join("taken");
        fs::create_dir(&out).unwrap();
        let error = write(&[("a".into(), vec![])], &out).unwrap_err();
        assert!(error.to_string().contains("taken"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
