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
        let is_library = name.starts_with("binaries/");
        let options = options.unix_permissions(if is_library { 0o755 } else { 0o644 });
        (archive.start_file(name.as_str(), options)).map_err(|e| PackageError::archive(out, e))?;
        (archive.write_all(bytes)).map_err(|e| PackageError::file(out, e))?;
    }
    let archive = archive
        .finish()
        .map_err(|e| PackageError::archive(out, e))?;
    let archive = archive.into_inner();
    write_whole(out, &archive).map_err(|e| PackageError::file(out, e))?;
    Ok(archive.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_files_give_the_same_bytes_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = ["one.fmu", "two.fmu"].map(|name| folder.path().join(name));
        let mut files = vec![
            ("resources/a.json".to_owned(), b"{}".to_vec()),
            ("binaries/linux64/G.so".to_owned(), vec![7; 1000]),
        ];
        write(&files, &one).unwrap();
        files.reverse();
        let size = write(&files, &two).unwrap();
        let bytes = std::fs::read(&one).unwrap();
        assert_eq!(bytes, std::fs::read(&two).unwrap());
        assert_eq!(bytes.len() as u64, size);
    }
}
