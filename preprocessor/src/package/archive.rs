//! The zip file: written reproducibly, and whole or not at all; what a packed FMU holds.

use std::fs::File;
use std::io::{Cursor, Read, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::error::PackageError;
use super::library::runs_on;
use crate::storage::write_whole;
use gearmesh::contact::ContactFile;
use gearmesh::fmi::resources::{CONTACT_FILE, TABLES_FILE, UNIT_FILE, UnitFile, parse_unit};

/// Writes `files` (name with forward slashes, contents) in the order of their names to `out` and
/// returns the size. The same files give the same bytes.
pub(super) fn write(files: &[(String, Vec<u8>)], out: &Path) -> Result<u64, PackageError> {
    let broken = |error| PackageError::archive(out, error);
    let unwritten = |error| PackageError::file(out, error);
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
        archive.start_file(name.as_str(), options).map_err(broken)?;
        archive.write_all(bytes).map_err(unwritten)?;
    }
    let archive = archive.finish().map_err(broken)?.into_inner();
    write_whole(out, &archive).map_err(unwritten)?;
    Ok(archive.len() as u64)
}

/// Longest file that is read from an FMU, bytes: some hundred times the tables of a pair.
const LONGEST_FILE: u64 = 256 << 20;

const DESCRIPTION: &str = "modelDescription.xml";

/// Most files of an FMU that is looked into; one of gearmesh has about a dozen.
const MOST_FILES: usize = 10_000;

/// The archive at `path`, if it is no larger than an FMU is.
fn opened(path: &Path) -> Result<ZipArchive<File>, PackageError> {
    let file = File::open(path).map_err(|e| PackageError::file(path, e))?;
    let archive = ZipArchive::new(file).map_err(|e| PackageError::archive(path, e))?;
    if archive.len() > MOST_FILES {
        let count = archive.len();
        let problem = format!("holds {count} files, and was not packed by gearmesh");
        return Err(PackageError::contents(path, problem));
    }
    Ok(archive)
}

/// The file `name` of the `archive` at `path`, if there is one.
fn bytes(
    archive: &mut ZipArchive<File>,
    path: &Path,
    name: &str,
) -> Result<Option<Vec<u8>>, PackageError> {
    let entry = match archive.by_name(name) {
        Ok(entry) => entry,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(PackageError::archive(path, e)),
    };
    let mut bytes = Vec::new();
    // Few packed bytes may unfold into any number of them.
    let length = entry.take(LONGEST_FILE + 1).read_to_end(&mut bytes);
    if length.map_err(|e| PackageError::file(path, e))? as u64 > LONGEST_FILE {
        let longest = LONGEST_FILE >> 20;
        let problem =
            format!("{name} unfolds into more than {longest} MB, and was not packed by gearmesh");
        return Err(PackageError::contents(path, problem));
    }
    Ok(Some(bytes))
}

/// Contents of a packed FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name, GUID, pair and start values.
    pub unit: UnitFile,
    /// Text of the tables, if there are any.
    pub tables: Option<String>,
    /// Communication step of the default experiment, s.
    pub step_size: f64,
    /// The contact at run time, if it is there.
    pub contact: Option<ContactFile>,
    /// Platforms there are libraries for, in words, each with what its library needs.
    pub platforms: Vec<String>,
    /// Every file with its size in bytes.
    pub files: Vec<(String, u64)>,
}

/// Reads the FMU at `path`.
///
/// # Errors
/// A file that cannot be read or is no FMU that this program packed.
pub fn inspect(path: &Path) -> Result<Inspection, PackageError> {
    let mut archive = opened(path)?;
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let entry = archive.by_index(i);
        let entry = entry.map_err(|e| PackageError::archive(path, e))?;
        files.push((entry.name().to_owned(), entry.size()));
    }
    let faulty =
        |name: &str, reason: &str| PackageError::contents(path, format!("{name}: {reason}"));
    let mut bytes = |name: &str| bytes(&mut archive, path, name);
    let mut text = |name: &str| -> Result<Option<String>, PackageError> {
        let text = bytes(name)?.map(String::from_utf8).transpose();
        text.map_err(|_| faulty(name, "no text, and was not packed by gearmesh"))
    };
    let unit = format!("resources/{UNIT_FILE}");
    let missing = || faulty(&unit, "is missing; it was not packed by gearmesh");
    let found = text(&unit)?.ok_or_else(missing)?;
    let unit = parse_unit(found.as_bytes()).map_err(|reason| faulty(&unit, &reason))?;
    let tables = text(&format!("resources/{TABLES_FILE}"))?;
    let description = text(DESCRIPTION)?.unwrap_or_default();
    let step_size = description.split_once("stepSize=\"");
    let step_size = step_size.and_then(|(_, rest)| rest.split('"').next()?.parse().ok());
    let missing = || faulty(DESCRIPTION, "no stepSize in its default experiment");
    let contact = format!("resources/{CONTACT_FILE}");
    let found = bytes(&contact)?.as_deref().map(ContactFile::from_bytes);
    let contact = (found.transpose()).map_err(|reason| faulty(&contact, &reason))?;
    let mut platforms = Vec::new();
    for (name, _) in files.iter().filter(|(name, _)| !name.ends_with('/')) {
        if let ["binaries", platform, _, ..] = name.split('/').collect::<Vec<_>>()[..] {
            platforms.push(runs_on(platform, &bytes(name)?.unwrap_or_default()));
        }
    }
    platforms.sort();
    Ok(Inspection {
        unit,
        tables,
        step_size: step_size.ok_or_else(missing)?,
        contact,
        platforms,
        files,
    })
}
