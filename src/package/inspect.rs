//! What a packed unit holds.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use zip::ZipArchive;

use super::PackageError;
use crate::fmi::resources::{TABLES_FILE, UNIT_FILE, UnitFile, parse_unit};

/// Longest file that is read from a unit, bytes: some hundred times the tables of a pair.
const LONGEST_TEXT: u64 = 256 << 20;

/// Most files of a unit that is looked into; one of gearmesh has some twenty.
const MOST_FILES: usize = 10_000;

/// Unpacks the resources of the unit at `path` into `folder`, as a host would.
///
/// # Errors
/// A file that cannot be read, or resources longer than any that this program packs.
pub fn unpack_resources(path: &Path, folder: &Path) -> Result<(), PackageError> {
    let mut archive = opened(path)?;
    let names: Vec<String> = archive.file_names().map(str::to_owned).collect();
    for name in names {
        // Only what lies there itself: no name leads out of `folder`.
        let Some(last) = name.strip_prefix("resources/").filter(|n| is_plain(n)) else {
            continue;
        };
        let entry = archive
            .by_name(&name)
            .map_err(|e| PackageError::archive(path, e))?;
        let target = folder.join(last);
        let mut file = File::create(&target).map_err(|e| PackageError::file(&target, e))?;
        let mut limited = entry.take(LONGEST_TEXT + 1);
        let length =
            std::io::copy(&mut limited, &mut file).map_err(|e| PackageError::file(path, e))?;
        if length > LONGEST_TEXT {
            return Err(PackageError::contents(path, too_long(&name)));
        }
    }
    Ok(())
}

/// The archive at `path`, if it is no larger than a unit is.
fn opened(path: &Path) -> Result<ZipArchive<File>, PackageError> {
    let file = File::open(path).map_err(|e| PackageError::file(path, e))?;
    let archive = ZipArchive::new(file).map_err(|e| PackageError::archive(path, e))?;
    if archive.len() > MOST_FILES {
        let problem = format!(
            "holds {} files, and was not packed by gearmesh",
            archive.len()
        );
        return Err(PackageError::contents(path, problem));
    }
    Ok(archive)
}

fn is_plain(name: &str) -> bool {
    !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':'])
}

fn too_long(name: &str) -> String {
    let longest = LONGEST_TEXT >> 20;
    format!("{name} unfolds into more than {longest} MB, and was not packed by gearmesh")
}

/// Contents of a packed unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name, GUID, pair and start values.
    pub unit: UnitFile,
    /// Text of the tables, if there are any.
    pub tables: Option<String>,
    /// Platforms there are libraries for.
    pub platforms: Vec<String>,
    /// Every file with its size in bytes.
    pub files: Vec<(String, u64)>,
}

/// Reads the unit at `path`.
///
/// # Errors
/// A file that cannot be read or is no unit that this program packed.
pub fn inspect(path: &Path) -> Result<Inspection, PackageError> {
    let mut archive = opened(path)?;
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let entry = archive
            .by_index(i)
            .map_err(|e| PackageError::archive(path, e))?;
        files.push((entry.name().to_owned(), entry.size()));
    }
    let mut text = |name: &str| -> Result<Option<String>, PackageError> {
        let mut entry = match archive.by_name(name) {
            Ok(entry) => entry,
            Err(zip::result::ZipError::FileNotFound) => return Ok(None),
            Err(e) => return Err(PackageError::archive(path, e)),
        };
        let mut text = String::new();
        // Few packed bytes may unfold into any number of them.
        let length = (&mut entry)
            .take(LONGEST_TEXT + 1)
            .read_to_string(&mut text)
            .map_err(|e| PackageError::file(path, e))?;
        if length as u64 > LONGEST_TEXT {
            return Err(PackageError::contents(path, too_long(name)));
        }
        Ok(Some(text))
    };
    let unit_name = format!("resources/{UNIT_FILE}");
    let unit = text(&unit_name)?.ok_or_else(|| {
        PackageError::contents(
            path,
            format!("has no {unit_name}; it was not packed by gearmesh"),
        )
    })?;
    let unit = parse_unit(&unit)
        .map_err(|reason| PackageError::contents(path, format!("{unit_name}: {reason}")))?;
    let tables = text(&format!("resources/{TABLES_FILE}"))?;
    let mut platforms: Vec<String> = files
        .iter()
        .filter_map(|(name, _)| name.strip_prefix("binaries/")?.split('/').next())
        .map(str::to_owned)
        .collect();
    platforms.sort();
    platforms.dedup();
    Ok(Inspection {
        unit,
        tables,
        platforms,
        files,
    })
}
