//! Packing a pair, its tables and the compiled library into one .fmu file.
//!
//! One library serves every pair: what belongs to the pair travels in the resources. The same
//! contents give the same bytes, and the GUID is that of the contents, so that two units with
//! different tables never share one.

mod archive;
mod documentation;
mod inspect;
mod library;
mod starts;

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

pub use inspect::{Inspection, inspect};
pub use library::{Library, library_beside};
pub use starts::{Starts, estimated_stiffness, meshing_spin};

use crate::fmi::resources::{TABLES_FILE, UNIT_FILE, UNIT_VERSION, UnitFile};
use crate::fmi::variables::{self, MODEL_IDENTIFIER};
use crate::gear::PairGeometry;

/// What goes into one unit.
#[derive(Debug, Clone, Copy)]
pub struct Contents<'a> {
    /// Name of the pair.
    pub name: &'a str,
    /// The pair, SI.
    pub geometry: &'a PairGeometry,
    /// Text of the tables; `None` for a unit of constant stiffness.
    pub tables: Option<&'a str>,
    /// Start values that belong to the pair.
    pub starts: &'a Starts,
}

/// What was packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packed {
    /// GUID of the unit.
    pub guid: String,
    /// Size of the file in bytes.
    pub bytes: u64,
}

/// Why a unit could not be packed or read.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    /// A file cannot be read or written.
    #[error("{path}: {source}; name a file that can be read, or a folder that can be written")]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The archive cannot be written or read.
    #[error(
        "{path}: {source}; name an FMU that `gearmesh pack` or `gearmesh build` wrote, or pack it again"
    )]
    Archive {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: zip::result::ZipError,
    },
    /// A file that is not what it should be.
    #[error("{path}: {reason}")]
    Contents {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// A start value without meaning.
    #[error("start value {name} = {value}: {remedy}")]
    Start {
        /// The variable.
        name: &'static str,
        /// The value.
        value: f64,
        /// What to do.
        remedy: String,
    },
}

impl PackageError {
    fn file(path: &Path, source: std::io::Error) -> Self {
        PackageError::File {
            path: path.to_owned(),
            source,
        }
    }

    fn archive(path: &Path, source: zip::result::ZipError) -> Self {
        PackageError::Archive {
            path: path.to_owned(),
            source,
        }
    }

    fn contents(path: &Path, reason: impl Into<String>) -> Self {
        PackageError::Contents {
            path: path.to_owned(),
            reason: reason.into(),
        }
    }
}

/// Packs `contents` with the compiled `libraries`, one per platform, into the file `out`.
///
/// The file appears whole or not at all.
///
/// # Errors
/// Start values without meaning, libraries that are none or of one platform twice, files that cannot
/// be read or written.
pub fn pack(
    contents: &Contents,
    libraries: &[Library],
    out: &Path,
) -> Result<Packed, PackageError> {
    let starts = contents.starts.of_variables(contents.geometry)?;
    let mut unit = UnitFile {
        version: UNIT_VERSION,
        guid: String::new(),
        name: contents.name.to_owned(),
        starts: starts
            .iter()
            .map(|&(i, value)| (variables::VARIABLES[i].name.to_owned(), value))
            .collect(),
        geometry: contents.geometry.clone(),
    };
    let description = documentation::summary(&unit, contents.tables.is_some());
    unit.guid = guid(&unit, contents.tables, libraries);
    let mut files = vec![
        (
            "modelDescription.xml".to_owned(),
            variables::model_description(&unit.guid, &description, &starts).into_bytes(),
        ),
        ("model.png".to_owned(), documentation::PICTURE.to_vec()),
        (
            format!("resources/{UNIT_FILE}"),
            unit_text(&unit).into_bytes(),
        ),
    ];
    if let Some(tables) = contents.tables {
        files.push((format!("resources/{TABLES_FILE}"), tables.into()));
    }
    files.extend(documentation::files(&unit, contents.tables.is_some()));
    for (i, library) in libraries.iter().enumerate() {
        if libraries[..i]
            .iter()
            .any(|other| other.platform == library.platform)
        {
            let reason = format!("a second library for {}; give one", library.platform);
            return Err(PackageError::contents(&library.path, reason));
        }
        let (platform, extension) = (library.platform, library.extension());
        files.push((
            format!("binaries/{platform}/{MODEL_IDENTIFIER}.{extension}"),
            library.bytes.clone(),
        ));
    }
    let bytes = archive::write(&files, out)?;
    Ok(Packed {
        guid: unit.guid,
        bytes,
    })
}

fn unit_text(unit: &UnitFile) -> String {
    // A struct of numbers, strings and string keys always serialises.
    serde_json::to_string_pretty(unit).expect("a unit serialises") + "\n"
}

/// GUID of a unit: a hash over everything in it that decides how it behaves.
fn guid(unit: &UnitFile, tables: Option<&str>, libraries: &[Library]) -> String {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    add(variables::TEMPLATE.as_bytes());
    add(unit_text(unit).as_bytes());
    add(tables.unwrap_or("").as_bytes());
    for library in libraries {
        add(library.platform.as_bytes());
        add(&library.bytes);
    }
    let hex = crate::storage::hex(&hash.finalize()[..16]);
    let groups = [
        &hex[..8],
        &hex[8..12],
        &hex[12..16],
        &hex[16..20],
        &hex[20..],
    ];
    format!("{{{}}}", groups.join("-"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::samples::paper_pair;

    #[test]
    fn the_same_contents_give_the_same_file_and_others_another_guid() {
        let folder = tempfile::tempdir().unwrap();
        let geometry = paper_pair(1.0);
        let pack = |name: &str, torque: f64| {
            let starts = Starts::constant_stiffness(&geometry, torque);
            let contents = Contents {
                name,
                geometry: &geometry,
                tables: None,
                starts: &starts,
            };
            let path = folder.path().join(format!("{name}{torque}.fmu"));
            let packed = super::pack(&contents, &[], &path).unwrap();
            (packed, std::fs::read(&path).unwrap(), path)
        };
        let (one, bytes, path) = pack("a", 100.0);
        let (again, same, _) = pack("a", 100.0);
        assert_eq!((&one, &bytes), (&again, &same));
        assert_ne!(one.guid, pack("a", 101.0).0.guid);
        assert_ne!(one.guid, pack("b", 100.0).0.guid);
        let read = inspect(&path).unwrap();
        assert_eq!(read.unit.guid, one.guid);
        assert_eq!(read.unit.geometry, geometry);
        assert!(read.tables.is_none() && read.platforms.is_empty());
        assert!(
            read.files
                .iter()
                .any(|(name, _)| name == "documentation/index.html")
        );
    }
}
