//! Packing a pair, its tables and the compiled library into one .fmu file.
//!
//! One library serves every pair: what belongs to the pair travels in the resources. The same contents give the same
//! bytes, and the GUID is that of the contents, so that two FMUs with different tables never share one.

mod archive;
mod documentation;
mod driven;
mod dynamics;
mod starts;

use std::path::Path;
use std::sync::Arc;

use sha2::{Digest, Sha256};

pub use archive::{Inspection, Library, PackageError, inspect, libraries_beside};
pub use documentation::start_in_words;
pub(crate) use driven::Driven;
pub use driven::{MESH_FREQUENCY, StepError, step_error};
pub use dynamics::{Blank, MeshDynamics};
pub(crate) use starts::{SEQUENTIAL, TABLE, TEETH};
pub use starts::{Setting, Starts};

use documentation::Description;
use gearmesh::contact::ContactFile;
use gearmesh::fmi::resources::{
    CONTACT_FILE, Resources, TABLES_FILE, UNIT_FILE, UNIT_VERSION, UnitFile,
};
use gearmesh::fmi::variables::MODEL_IDENTIFIER;
use gearmesh::gear::PairGeometry;
use gearmesh::table::TableFile;

/// What goes into one FMU.
#[derive(Debug, Clone, Copy)]
pub struct Contents<'a> {
    /// Name of the pair.
    pub name: &'a str,
    /// The pair, SI.
    pub geometry: &'a PairGeometry,
    /// What contact at run time needs, for `stiffnessModel = contact`.
    pub contact: Option<&'a ContactFile>,
    /// Start values that belong to the pair, with its tables, if there are any.
    pub starts: &'a Starts,
}

/// What was packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packed {
    /// GUID of the FMU.
    pub guid: String,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// What it runs on, in words: platforms, that of Linux with the oldest glibc that loads its library.
    pub platforms: Vec<String>,
}

/// Packs `contents` with the compiled `libraries`, one per platform, into the file `out`.
///
/// The file appears whole or not at all.
///
/// # Errors
/// Start values without meaning or that make no mesh, libraries that are none or of one platform twice,
/// files that cannot be read or written.
pub fn pack(
    contents: &Contents,
    libraries: &[Library],
    out: &Path,
) -> Result<Packed, PackageError> {
    let effects = contents.starts.check_effects();
    effects.map_err(|reason| PackageError::starts(&reason))?;
    let mut unit = UnitFile {
        version: UNIT_VERSION,
        guid: String::new(),
        name: contents.name.to_owned(),
        starts: contents.starts.of_variables(contents.geometry),
        geometry: contents.geometry.clone(),
    };
    let table = contents.starts.table.as_ref();
    let table_file = table.map(|table| &*table.file);
    let tables = table_file.map(TableFile::to_json);
    let contact = contents.contact.map(ContactFile::to_bytes);
    unit.guid = guid(&unit, tables.as_deref(), contact.as_deref(), libraries);
    let guid = unit.guid.clone();
    let resources = [
        (UNIT_FILE, Some(unit_text(&unit).into_bytes())),
        (TABLES_FILE, tables.map(String::into_bytes)),
        (CONTACT_FILE, contact),
    ];
    let mut files: Vec<(String, Vec<u8>)> = resources
        .into_iter()
        .filter_map(|(name, bytes)| Some((format!("resources/{name}"), bytes?)))
        .collect();
    // The FMU starts here as it will in a host.
    let resources = Resources::new(unit, table_file.cloned(), contents.contact.cloned());
    let resources = Arc::new(resources.map_err(|reason| PackageError::starts(&reason))?);
    let example = driven::example_signals(&resources);
    let example = example.map_err(|refusal| PackageError::starts(&refusal.message))?;
    let dynamics = contents.starts.dynamics(contents.geometry);
    let description = Description {
        unit: &resources.unit,
        table,
        dynamics: &dynamics,
        step_error: step_error(&resources.unit, table_file, dynamics.step()),
        example,
    };
    files.extend(description.files());
    for library in libraries {
        let (platform, extension) = (library.platform, library.extension());
        let name = format!("binaries/{platform}/{MODEL_IDENTIFIER}.{extension}");
        if files.iter().any(|(other, _)| *other == name) {
            let reason = format!("a second library for {platform}; give one");
            return Err(PackageError::contents(&library.path, reason));
        }
        files.push((name, library.bytes.clone()));
    }
    let bytes = archive::write(&files, out)?;
    Ok(Packed {
        guid,
        bytes,
        platforms: libraries
            .iter()
            .map(|library| archive::runs_on(library.platform, &library.bytes))
            .collect(),
    })
}

fn unit_text(unit: &UnitFile) -> String {
    // A struct of numbers, strings and string keys always serialises.
    serde_json::to_string_pretty(unit).expect("a unit serialises") + "\n"
}

/// GUID of an FMU: a hash over everything in it that decides how it behaves.
fn guid(
    unit: &UnitFile,
    tables: Option<&str>,
    contact: Option<&[u8]>,
    libraries: &[Library],
) -> String {
    let (unit, tables) = (unit_text(unit), tables.unwrap_or(""));
    let mut contents = vec![
        documentation::TEMPLATE.as_bytes(),
        unit.as_bytes(),
        tables.as_bytes(),
    ];
    contents.extend(contact);
    for library in libraries {
        contents.extend([library.platform.as_bytes(), &library.bytes]);
    }
    let mut hash = Sha256::new();
    for bytes in contents {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    let hex = gearmesh::words::hex(&hash.finalize()[..16]);
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32].map(|part| &hex[part]);
    format!("{{{}}}", parts.join("-"))
}

/// A file of `resources/tables`.
#[cfg(test)]
pub(crate) fn shipped_tables(name: &str) -> TableFile {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../resources/tables");
    TableFile::read(format!("{folder}/{name}.json")).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::paper_pair;

    /// Packs the paper's pair with constant stiffness, without a library.
    fn pack(name: &str, starts: &Starts, out: &Path) -> Result<Packed, PackageError> {
        let contents = Contents {
            name,
            geometry: &paper_pair(1.0),
            contact: None,
            starts,
        };
        super::pack(&contents, &[], out)
    }

    #[test]
    fn the_same_contents_give_the_same_file_and_others_another_guid() {
        let folder = tempfile::tempdir().unwrap();
        let geometry = paper_pair(1.0);
        let pack = |name: &str, torque: f64| {
            let path = folder.path().join(format!("{name}{torque}.fmu"));
            let starts = Starts::constant_stiffness(&geometry, torque);
            let packed = pack(name, &starts, &path).unwrap();
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
        let mut names = read.files.iter().map(|(name, _)| name);
        assert!(names.any(|name| name == "documentation/index.html"));
    }

    #[test]
    fn what_no_host_could_start_with_is_not_packed() {
        let folder = tempfile::tempdir().unwrap();
        let geometry = paper_pair(1.0);
        for (setting, reason) in [
            ("stiffnessModel=table", "table"),
            ("gear2.position[1]=0.05", "centre distance"),
            ("dampingOnset=0", "dampingOnset"),
            ("nominalTorque=0", "nominalTorque = 0"),
            (
                "centerDistanceEffect=true",
                "centerDistanceEffect = true: the FMU has no tables, and constant stiffness has no such effect; make tables over a \
                 range of `operating.center_distance_offset_um`",
            ),
            (
                "misalignmentEffect=true",
                "misalignmentEffect = true: the FMU has no tables",
            ),
            ("shuttlingEffect=true", "make tables with `gearmesh build`"),
        ] {
            let starts = Starts::constant_stiffness(&geometry, 100.0);
            let starts = starts.with(&[setting.parse().unwrap()]);
            let out = folder.path().join("a.fmu");
            let error = pack("a", &starts, &out).unwrap_err().to_string();
            assert!(error.contains(reason), "{setting}: {error}");
            assert!(!out.exists());
        }
    }
}
