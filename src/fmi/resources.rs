//! What a packed FMU carries in its resources: the pair, the tables, and its GUID.
//!
//! One compiled library serves every pair, so nothing of a pair is compiled in. All instances of
//! one FMU in a process share one copy.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use serde::{Deserialize, Serialize};
use url::Url;

use super::Refusal;
use super::parameters::Settings;
use super::variables::{FIRST_PARAMETER, Variable, index_by_name, template_starts};
use crate::contact::ContactFile;
use crate::element::{Element, ElementError, Parameters, StiffnessModel};
use crate::gear::PairGeometry;
use crate::table::{Effects, Table, TableError, TableFile};
use crate::words::json_problem;

/// File with the pair and the GUID.
pub const UNIT_FILE: &str = "unit.json";

/// File with the tables; absent in an FMU of constant stiffness.
pub const TABLES_FILE: &str = "tables.json";

/// File with the contact at run time; absent in an FMU that cannot solve it.
pub const CONTACT_FILE: &str = "contact.bin";

/// Version of [`UnitFile`] that this library reads and writes.
pub const UNIT_VERSION: u32 = 1;

/// Contents of [`UNIT_FILE`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnitFile {
    /// Version of this layout, [`UNIT_VERSION`].
    pub version: u32,
    /// The guid of modelDescription.xml.
    pub guid: String,
    /// Name of the pair.
    pub name: String,
    /// Start values that differ from the template of modelDescription.xml, by name; a Boolean is 0 or 1.
    pub starts: BTreeMap<String, f64>,
    /// The pair, SI.
    pub geometry: PairGeometry,
}

impl UnitFile {
    /// Start value of `variable`: the FMU's own, or that of the template.
    pub fn start(&self, variable: &Variable) -> f64 {
        let own = self.starts.get(variable.name).copied();
        own.or(variable.start).unwrap_or(0.0)
    }
}

/// The resources of one packed FMU, read and checked.
#[derive(Debug)]
pub struct Resources {
    /// The pair and the GUID.
    pub unit: UnitFile,
    /// Where they were read; empty if nowhere.
    folder: PathBuf,
    /// The tables; `None` in an FMU of constant stiffness.
    tables: Option<Arc<TableFile>>,
    /// The contact at run time, if there is any.
    contact: Option<ContactFile>,
    /// Start values of all variables, as modelDescription.xml of this FMU gives them.
    pub starts: Vec<f64>,
    /// Those of the parameters.
    pub settings: Settings,
    /// Interpolants of the tables in use, one for each choice of effects.
    made: Mutex<Vec<Weak<Table>>>,
}

/// Start values of the template with what `unit` has of its own, and those of the parameters.
/// Errors: variables that are none, numbers that are none of their values, as text.
fn starts(unit: &UnitFile) -> Result<(Vec<f64>, Settings), String> {
    let mut starts = template_starts();
    for (name, value) in &unit.starts {
        let i = index_by_name(name)
            .ok_or_else(|| format!("a start value for {name}, which is no variable"))?;
        starts[i] = *value;
    }
    let settings = Settings::new(&starts[FIRST_PARAMETER..]);
    let settings = settings.map_err(|refusal| format!("start values: {refusal}"))?;
    Ok((starts, settings))
}

impl Resources {
    /// The resources of `unit` with its `tables` and its `contact`.
    /// Errors: start values that are none, a contact of another pair, as text.
    pub fn new(
        unit: UnitFile,
        tables: Option<TableFile>,
        contact: Option<ContactFile>,
    ) -> Result<Self, String> {
        let is_foreign = |c: &ContactFile| c.setup.geometry != unit.geometry;
        if contact.as_ref().is_some_and(is_foreign) {
            return Err(format!("{CONTACT_FILE} is not of the pair in {UNIT_FILE}"));
        }
        let (starts, settings) = starts(&unit)?;
        Ok(Self {
            contact,
            starts,
            settings,
            unit,
            folder: PathBuf::new(),
            tables: tables.map(Arc::new),
            made: Mutex::new(Vec::new()),
        })
    }

    /// The element of this FMU with `parameters`.
    /// Errors: parameters without meaning; an effect whose axis the tables lack.
    pub fn element(&self, parameters: &Parameters) -> Result<Element, Refusal> {
        let geometry = &self.unit.geometry;
        let model = parameters.stiffness_model;
        if let (StiffnessModel::Contact, Some(contact)) = (model, &self.contact) {
            return Ok(Element::with_contact(geometry, parameters, contact)?);
        }
        let needs_table = matches!(model, StiffnessModel::Table | StiffnessModel::Teeth);
        let effects = parameters.table_effects(geometry);
        let file = self.tables.as_ref().filter(|_| needs_table);
        let table = file.map(|file| self.table(file, effects)).transpose();
        let table = table.map_err(ElementError::from)?;
        Ok(Element::new(geometry, parameters, table)?)
    }

    /// Number of interpolants in use.
    #[cfg(test)]
    pub(super) fn interpolants(&self) -> usize {
        let made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        made.iter().filter(|table| table.strong_count() > 0).count()
    }

    /// One table in memory for all who ask for the same `effects`, while one of them still holds it.
    fn table(&self, file: &Arc<TableFile>, effects: Effects) -> Result<Arc<Table>, TableError> {
        let suits = |table: &Table| table.effects == effects;
        shared(&self.made, suits, || {
            Table::with_effects(file.clone(), effects).map(Arc::new)
        })
    }
}

/// FMUs in use, so that the instances of one FMU share its table.
static LOADED: Mutex<Vec<Weak<Resources>>> = Mutex::new(Vec::new());

/// The item of `list` in use that `suits`, or what `make` makes. Nobody waits meanwhile: of two that make the same, the
/// first to be done is shared.
fn shared<T, E>(
    list: &Mutex<Vec<Weak<T>>>,
    suits: impl Fn(&T) -> bool,
    make: impl FnOnce() -> Result<Arc<T>, E>,
) -> Result<Arc<T>, E> {
    // The list is whole even if a thread panicked while it held the lock.
    let lock = || list.lock().unwrap_or_else(PoisonError::into_inner);
    let present = |list: &[Weak<T>]| {
        let mut present = list.iter().filter_map(Weak::upgrade);
        present.find(|item| suits(item))
    };
    // Items are dropped without the lock: the last of an FMU takes its tables along.
    let found = present(&lock());
    if let Some(item) = found {
        return Ok(item);
    }
    let made = make()?;
    let mut list = lock();
    list.retain(|item| item.strong_count() > 0);
    Ok(present(&list).unwrap_or_else(|| {
        list.push(Arc::downgrade(&made));
        made
    }))
}

/// Reads the resources at `location` (a file URI) and compares their GUID with `guid`.
/// Errors: a location that is no local folder, a file that is missing or altered, a GUID that is not the host's.
pub fn load(location: &str, guid: &str) -> Result<Arc<Resources>, Refusal> {
    let folder = folder(location).map_err(|reason| {
        Refusal::error(format!(
            "resource location '{location}': {reason}; pass the file URI of the unpacked resources"
        ))
    })?;
    let suits = |unit: &Resources| unit.unit.guid == guid && unit.folder == folder;
    shared(&LOADED, suits, || {
        let mut resources = read(&folder, guid)?;
        resources.folder = folder.clone();
        Ok(Arc::new(resources))
    })
}

/// The folder a host means by `location` on this machine: that of a file URI (RFC 8089), or an absolute path
/// as it is, since some hosts pass one.
/// Errors: what is wrong with the location.
fn folder(location: &str) -> Result<PathBuf, &'static str> {
    // First: to a URL, the drive of a path on Windows is a scheme.
    if Path::new(location).is_absolute() {
        return Ok(location.into());
    }
    let url = Url::parse(location).map_err(|_| "it is neither a file URI nor an absolute path")?;
    if url.scheme() != "file" {
        return Err("it is not a file URI");
    }
    url.to_file_path()
        .or_else(|()| on_the_current_drive(&url))
        .map_err(|()| "it names no folder of this machine")
}

/// On Windows a path without a drive is one of the current drive, as a host in wine gives it.
fn on_the_current_drive(url: &Url) -> Result<PathBuf, ()> {
    if url.host().is_some() {
        return Err(());
    }
    let here = Url::from_directory_path(std::env::current_dir().map_err(drop)?)?;
    here.join(url.path()).map_err(drop)?.to_file_path()
}

/// Forgets FMUs that no instance uses, so that a library that is unloaded leaves no memory behind.
pub fn release() {
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    loaded.retain(|resources| resources.strong_count() > 0);
    if loaded.is_empty() {
        *loaded = Vec::new();
    }
}

fn read(folder: &Path, guid: &str) -> Result<Resources, Refusal> {
    let unit = read_file(folder, UNIT_FILE, parse_unit)?;
    if unit.guid != guid {
        return Err(Refusal::error(format!(
            "the host passed GUID {guid}, but {} belongs to {}; unpack the FMU again",
            folder.join(UNIT_FILE).display(),
            unit.guid
        )));
    }
    let tables = is_there(folder, TABLES_FILE).then(|| {
        read_file(folder, TABLES_FILE, |bytes| {
            let text = str::from_utf8(bytes).map_err(|error| error.to_string())?;
            let tables = TableFile::from_json(text).map_err(|error| error.to_string())?;
            if tables.geometry != unit.geometry {
                return Err(format!("the tables are not those of {UNIT_FILE}"));
            }
            Ok(tables)
        })
    });
    let contact = is_there(folder, CONTACT_FILE);
    let contact = contact.then(|| read_file(folder, CONTACT_FILE, ContactFile::from_bytes));
    Resources::new(unit, tables.transpose()?, contact.transpose()?)
        .map_err(|reason| unusable(&folder.join(UNIT_FILE), reason))
}

/// Whether `folder` has an entry of this `name`, be it a link that leads nowhere: such a file is damaged, not left out.
fn is_there(folder: &Path, name: &str) -> bool {
    fs::symlink_metadata(folder.join(name)).is_ok()
}

/// Reads the bytes of a [`UNIT_FILE`].
/// Errors: what is wrong with them, as text.
pub fn parse_unit(bytes: &[u8]) -> Result<UnitFile, String> {
    let unit: UnitFile = serde_json::from_slice(bytes).map_err(|e| json_problem(&e))?;
    if unit.version != UNIT_VERSION {
        let found = unit.version;
        return Err(format!(
            "version {found}, this library reads {UNIT_VERSION}"
        ));
    }
    (unit.geometry.check()).map_err(|error| error.to_string())?;
    starts(&unit)?;
    Ok(unit)
}

/// Largest file of an FMU, bytes: some hundred times those of the shipped pairs, and as much as packing reads.
pub const LARGEST: u64 = 256 << 20;

/// What `parse` makes of the file `name` in `folder`. What is no file is not opened: a pipe would never answer.
fn read_file<T>(
    folder: &Path,
    name: &str,
    parse: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Result<T, Refusal> {
    let path = folder.join(name);
    let unreadable = |error: io::Error| {
        Refusal::error(format!(
            "cannot read {}: {error}; unpack the whole archive and pass its resources",
            path.display()
        ))
    };
    let found = fs::metadata(&path).map_err(unreadable)?;
    if !found.is_file() {
        return Err(unusable(&path, "it is no file"));
    }
    if found.len() > LARGEST {
        let reason = format!("{} bytes, more than {LARGEST}", found.len());
        return Err(unusable(&path, reason));
    }
    let bytes = fs::read(&path).map_err(unreadable)?;
    parse(&bytes).map_err(|reason| unusable(&path, reason))
}

/// A file that has not the contents that packing wrote.
fn unusable(path: &Path, reason: impl Display) -> Refusal {
    Refusal::error(format!("{}: {reason}; pack the FMU again", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::instance::tests::on_table;
    use crate::fmi::variables::{VARIABLES, index};

    /// A pipe would never answer, and a file as large as this would take all memory.
    #[cfg(unix)]
    #[test]
    fn a_pipe_or_an_endless_file_among_the_resources_is_refused_unread() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(UNIT_FILE);
        let load = || {
            let uri = format!("file://{}", folder.path().display());
            load(&uri, "{guid}").unwrap_err().to_string()
        };
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
        let said = load();
        assert!(said.contains("unit.json: it is no file"), "{said}");
        fs::remove_file(&path).unwrap();
        fs::File::create(&path)
            .unwrap()
            .set_len(LARGEST + 1)
            .unwrap();
        let said = load();
        assert!(
            said.contains("268435457 bytes, more than 268435456"),
            "{said}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_nowhere_is_no_missing_file() {
        let folder = tempfile::tempdir().unwrap();
        let unit = on_table([8, 1, 1, 6], &[]).resources.unit.clone();
        let text = serde_json::to_string(&unit).unwrap();
        fs::write(folder.path().join(UNIT_FILE), text).unwrap();
        let uri = format!("file://{}", folder.path().display());
        for name in [TABLES_FILE, CONTACT_FILE] {
            let link = folder.path().join(name);
            std::os::unix::fs::symlink("nowhere", &link).unwrap();
            let error = load(&uri, &unit.guid).unwrap_err().to_string();
            assert!(
                error.contains(name) && error.contains("cannot read"),
                "{error}"
            );
            fs::remove_file(&link).unwrap();
        }
    }

    #[test]
    fn nobody_waits_for_what_another_makes_and_what_is_done_first_is_shared() {
        let list = Mutex::new(Vec::new());
        let (begun, ready) = std::sync::mpsc::channel();
        let (go, wait) = std::sync::mpsc::channel::<()>();
        let wait = Mutex::new(wait);
        let slow = || {
            shared(
                &list,
                |x: &i32| *x == 1,
                || {
                    begun.send(()).unwrap();
                    wait.lock().unwrap().recv().unwrap();
                    Ok::<_, ()>(Arc::new(1))
                },
            )
        };
        std::thread::scope(|threads| {
            let slow = threads.spawn(slow);
            ready.recv().unwrap();
            let other = shared(&list, |x| *x == 2, || Ok::<_, ()>(Arc::new(2))).unwrap();
            let same = shared(&list, |x| *x == 1, || Ok::<_, ()>(Arc::new(1))).unwrap();
            go.send(()).unwrap();
            assert!(Arc::ptr_eq(&slow.join().unwrap().unwrap(), &same));
            assert_eq!(*other, 2);
        });
    }

    #[test]
    fn a_pair_that_no_pair_file_gives_is_refused_by_field() {
        let unit = on_table([8, 1, 1, 6], &[]).resources.unit.clone();
        let text = serde_json::to_string(&unit).unwrap();
        assert_eq!(parse_unit(text.as_bytes()).unwrap(), unit);
        let teeth = text.replace("\"teeth\":20", "\"teeth\":0");
        let distance = text.replace("\"center_distance\":0.082", "\"center_distance\":0.002");
        for (text, field) in [
            (teeth, "gear1.teeth = 0"),
            (distance, "center_distance_m = 0.002"),
        ] {
            let error = parse_unit(text.as_bytes()).unwrap_err();
            assert!(error.contains(field), "{error}");
        }
    }

    #[test]
    fn instances_of_one_unit_share_tables_and_leave_none_behind() {
        let first = on_table([8, 1, 5, 6], &[]);
        let resources = first.resources.clone();
        let table = |misalignment| {
            let effects = Effects {
                misalignment,
                center_distance: false,
                ..Parameters::default().table_effects(&resources.unit.geometry)
            };
            resources.table(resources.tables.as_ref().unwrap(), effects)
        };
        let (one, two, fewer) = (
            table(true).unwrap(),
            table(true).unwrap(),
            table(false).unwrap(),
        );
        assert!(Arc::ptr_eq(&one, &two) && !Arc::ptr_eq(&one, &fewer));
        assert!(
            Arc::ptr_eq(&one.file, &fewer.file),
            "the samples are shared even then"
        );
        drop((one, two, fewer));
        assert_eq!(Arc::strong_count(resources.tables.as_ref().unwrap()), 1);
    }

    #[test]
    fn an_effect_without_its_axis_is_refused_at_initialization_by_name() {
        for (counts, effect) in [
            ([8, 1, 5, 6], index::CENTER_DISTANCE_EFFECT),
            ([8, 5, 1, 6], index::MISALIGNMENT_EFFECT),
        ] {
            let error = on_table(counts, &[(effect, 1.0)])
                .exit_initialization()
                .unwrap_err();
            let name = VARIABLES[effect].name;
            assert!(error.message.contains(name), "{error}");
            on_table(counts, &[]).exit_initialization().unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn every_legal_file_uri_leads_to_its_folder() {
        for (uri, path) in [
            ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
            ("file:/tmp/fmu/resources", "/tmp/fmu/resources"),
            ("FILE://localhost/tmp/a", "/tmp/a"),
            ("file:///tmp/with%20space/a", "/tmp/with space/a"),
            ("file:///tmp/with space/a", "/tmp/with space/a"),
            ("file:///tmp/%C3%BCml%c3%a4ut", "/tmp/ümläut"),
            ("file:///tmp/ümläut", "/tmp/ümläut"),
            ("file:///tmp/100%25/a+b", "/tmp/100%/a+b"),
            ("/tmp/plain path", "/tmp/plain path"),
            ("/tmp/100%25", "/tmp/100%25"),
        ] {
            assert_eq!(folder(uri).as_deref(), Ok(Path::new(path)), "{uri}");
        }
    }

    #[cfg(windows)]
    #[test]
    fn every_legal_file_uri_leads_to_its_folder() {
        for (uri, path) in [
            ("file:///C:/a%20b/r", "C:\\a b\\r"),
            ("file:/C:/a/r", "C:\\a\\r"),
            ("file:///c|/a/r", "C:\\a\\r"),
            ("file://server/share/r", "\\\\server\\share\\r"),
            ("C:\\a\\r", "C:\\a\\r"),
        ] {
            assert_eq!(folder(uri).as_deref(), Ok(Path::new(path)), "{uri}");
        }
        let found = folder("file:///a%20b/r").unwrap();
        assert!(
            found.is_absolute() && found.ends_with("a b\\r"),
            "{found:?}"
        );
    }

    #[test]
    fn a_location_that_is_no_local_folder_is_refused_with_what_to_pass() {
        for uri in ["", "http://host/a", "relative/path", "file://server/share"] {
            if cfg!(windows) && uri.starts_with("file:") {
                continue;
            }
            let error = load(uri, "{guid}").unwrap_err().to_string();
            let named = error.contains(&format!("'{uri}'"));
            assert!(named && error.contains("pass the file URI"), "{error}");
        }
    }
}
