//! Computed models kept in files of one folder of bounded size.
//!
//! The key of a model is the SHA-256 of what it is computed from: the mesh itself (nodes, elements, held
//! surface, flank and its normals), the stiffness of an element, how many teeth are asked for, and [`VERSION`]. So every
//! setting and constant that shapes the mesh shapes its key without a list to keep; for what is done with the mesh
//! the version stands.
//!
//! File: magic line, key, length of the body, SHA-256 of the body, body; little endian. A file that is cut,
//! altered or of another version is recomputed and replaced, with a note; it never gives a result. A
//! half-written one is never found. When a new model does not fit, the least recently used ones go.

use super::influence::Influence;
use super::model::Model;
use super::{Cost, FiniteElementCompliance, FiniteElementError, Progress, Settings};
use crate::storage::write_whole;
use gearmesh::gear::Gear;
use gearmesh::words::hex;
use gearmesh::words::rounded;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Changes with the layout of the file.
const MAGIC: &[u8; 32] = b"gearmesh finite elements v0004\r\n";

/// Changes with what is computed of a mesh: a method, or a constant that no mesh shows, such as how many modes of the sides and
/// Fourier indices are left out, or how the result is rounded. What was kept is then not found.
const VERSION: u32 = 5;

/// How many bytes of it all versions share: these tell a file of this cache from others.
const COMMON: usize = MAGIC.len() - b"0004\r\n".len();

/// Ending of the files.
const ENDING: &str = "compliance";

/// How a model was obtained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Computed; no cache asked for.
    Computed,
    /// Computed and stored.
    Stored,
    /// Read from the cache.
    Loaded,
    /// The cached file was unusable for this reason; computed anew and stored.
    Replaced(String),
    /// Computed; the cache could not be written for this reason.
    NotStored(String),
}

/// A folder of models, and how large it may become.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelCache {
    directory: PathBuf,
    limit: u64,
}

/// One model in a [`ModelCache`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CachedModel {
    /// Its file.
    pub path: PathBuf,
    /// Size, bytes.
    pub bytes: u64,
    /// When it was last read or written.
    pub used: SystemTime,
    /// The gear in words; None for a file of another version.
    pub gear: Option<String>,
}

impl ModelCache {
    /// Largest size unless another is asked for, bytes: some dozens of pairs.
    pub const DEFAULT_LIMIT: u64 = 1_000_000_000;

    /// The models in `directory`, `limit` bytes at most; the folder is created with the first model.
    pub fn new(directory: impl Into<PathBuf>, limit: u64) -> ModelCache {
        ModelCache {
            directory: directory.into(),
            limit,
        }
    }

    /// The folder.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Largest size of all models together, bytes.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// All models, the least recently used first; none if there is no folder. A file that does not begin as one is none.
    ///
    /// # Errors
    /// What the system says of a folder that cannot be read.
    pub fn models(&self) -> io::Result<Vec<CachedModel>> {
        let mut models = Vec::new();
        for path in self.paths()? {
            let Some(head) = head(&path) else {
                continue;
            };
            // Another run may have removed it meanwhile.
            let Ok(found) = fs::metadata(&path) else {
                continue;
            };
            models.push(CachedModel {
                bytes: found.len(),
                used: found.modified()?,
                gear: label(&head),
                path,
            });
        }
        models.sort_by_key(|model| model.used);
        Ok(models)
    }

    /// Files that end as models do and begin otherwise: not of this cache, which leaves them alone.
    ///
    /// # Errors
    /// What the system says of a folder that cannot be read.
    pub fn others(&self) -> io::Result<Vec<PathBuf>> {
        let mut paths = self.paths()?;
        paths.retain(|path| head(path).is_none());
        paths.sort();
        Ok(paths)
    }

    /// All files that end as models do.
    fn paths(&self) -> io::Result<Vec<PathBuf>> {
        let entries = match fs::read_dir(&self.directory) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let paths = entries.map(|entry| Ok(entry?.path()));
        let ends = |path: &PathBuf| path.extension().is_some_and(|ending| ending == ENDING);
        paths
            .filter(|path| path.as_ref().map_or(true, ends))
            .collect()
    }

    /// Removes all models; returns how many.
    ///
    /// # Errors
    /// What the system says of the first file that stays.
    pub fn clear(&self) -> io::Result<usize> {
        let models = self.models()?;
        for model in &models {
            remove(&model.path)?;
        }
        Ok(models.len())
    }

    /// Whether the model of `gear` is there, sound or not, and that of the gear turned end for end if its body asks for it.
    ///
    /// # Errors
    /// Those of a gear that cannot be meshed.
    pub(super) fn holds(
        &self,
        gear: &Gear,
        settings: &Settings,
    ) -> Result<bool, FiniteElementError> {
        for gear in gear.turned().iter().chain([gear]) {
            let model = Model::new(gear, settings)?;
            if !self.path(&key(&model, settings.reach)).exists() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn path(&self, key: &[u8; 32]) -> PathBuf {
        self.directory.join(format!("{}.{ENDING}", hex(&key[..12])))
    }

    /// What `decode` makes of the body behind the label of what is kept under `key`, or why that is unusable; no reason
    /// if nothing is kept.
    pub(super) fn read<T>(
        &self,
        key: &[u8; 32],
        decode: impl FnOnce(&[u8]) -> Result<T, &'static str>,
    ) -> Result<T, Option<String>> {
        let path = self.path(key);
        let fault = |reason: String| Some(format!("{}: {reason}", path.display()));
        let bytes = fs::read(&path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => None,
            _ => fault(error.to_string()),
        })?;
        let body = opened(&bytes, key).map_err(|reason| fault(reason.to_owned()))?;
        touch(&path);
        decode(body).map_err(|reason| Some(reason.to_owned()))
    }

    /// Keeps `body` under `key`; `fault` is what was wrong with what was kept there.
    pub(super) fn keep(&self, key: &[u8; 32], body: &[u8], fault: Option<String>) -> Origin {
        let path = self.path(key);
        match (self.store(&path, &sealed(body, key)), fault) {
            (Err(error), _) => Origin::NotStored(format!("{}: {error}", path.display())),
            (Ok(()), Some(reason)) => Origin::Replaced(reason),
            (Ok(()), None) => Origin::Stored,
        }
    }

    /// Keeps `bytes` as `path`; the least recently used models make room for it.
    fn store(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let size = bytes.len() as u64;
        if size > self.limit {
            return Err(io::Error::other(format!(
                "it takes {} MB, and the cache may take {} MB",
                size.div_ceil(1_000_000),
                self.limit / 1_000_000
            )));
        }
        fs::create_dir_all(&self.directory)?;
        let mut models = self.models()?;
        models.retain(|model| model.path != path);
        let mut total = size + models.iter().map(|model| model.bytes).sum::<u64>();
        for model in &models {
            if total <= self.limit {
                break;
            }
            remove(&model.path)?;
            total -= model.bytes;
        }
        write_whole(path, bytes)
    }
}

/// A file that another run has removed already is no error.
fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

impl FiniteElementCompliance {
    /// As [`FiniteElementCompliance::new`], by way of `cache`. An unusable cache costs the time of a computation
    /// and is told by [`Origin`].
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn cached(
        gear: &Gear,
        settings: &Settings,
        cache: &ModelCache,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let mut origin = Origin::Loaded;
        let model = Self::with_turned(gear, |gear| {
            let (model, found) = Self::cached_one(gear, settings, cache, progress)?;
            // Of a gear with two models the one that was not simply read.
            if found != Origin::Loaded {
                origin = found;
            }
            Ok(model)
        })?;
        Ok((model, origin))
    }

    fn cached_one(
        gear: &Gear,
        settings: &Settings,
        cache: &ModelCache,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let model = Model::new(gear, settings)?;
        let key = key(&model, settings.reach);
        let fault = match cache.read(&key, decode) {
            Ok((influence, cost)) => {
                let found = Self::from_parts(model, influence, cost, settings);
                return Ok((found, Origin::Loaded));
            }
            Err(fault) => fault,
        };
        let computed = Self::compute(model, settings, progress)?;
        let origin = cache.keep(&key, &encode(&computed, &gear_in_words(gear)), fault);
        Ok((computed, origin))
    }
}

/// Notes that a model was used. Folders that are not the user's own need not allow it.
fn touch(path: &Path) {
    let _ = File::open(path).and_then(|file| file.set_modified(SystemTime::now()));
}

/// Whether both gears have the same model in canonical coordinates: hand, axial position and
/// microgeometry do not matter.
pub(super) fn same_model(
    gears: &[Gear; 2],
    settings: &Settings,
) -> Result<bool, FiniteElementError> {
    if gears[0].teeth != gears[1].teeth {
        return Ok(false);
    }
    let [a, b] = gears.each_ref().map(|gear| Model::new(gear, settings));
    Ok(key(&a?, settings.reach) == key(&b?, settings.reach))
}

fn key(model: &Model, reach: usize) -> [u8; 32] {
    key_of(model, reach, b"")
}

/// The key of what is computed of `model` beside its compliance: `what`, with every node it depends on that
/// [`Model::identify`] does not tell.
pub(super) fn key_of(model: &Model, reach: usize, what: &[u8]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(VERSION.to_le_bytes());
    hash.update((reach as u64).to_le_bytes());
    model.identify(&mut |bytes| hash.update(bytes));
    hash.update(what);
    hash.finalize().into()
}

pub(super) fn gear_in_words(gear: &Gear) -> String {
    format!(
        "{} teeth, module {} mm, helix {} deg, face width {} mm",
        gear.teeth,
        rounded(1e3 * gear.normal_module),
        rounded(gear.helix_angle.to_degrees()),
        rounded(1e3 * gear.face_width)
    )
}

fn encode(model: &FiniteElementCompliance, gear: &str) -> Vec<u8> {
    let Cost {
        elements,
        unknowns,
        factor_entries,
        flank_nodes,
        seconds,
        memory_bytes,
    } = model.cost;
    let mut body = labelled(gear);
    for count in [
        elements,
        unknowns,
        factor_entries,
        flank_nodes,
        memory_bytes,
    ] {
        body.extend((count as u64).to_le_bytes());
    }
    for time in seconds {
        body.extend(time.to_le_bytes());
    }
    model.influence.encode(&mut body);
    body
}

/// The beginning of a body: what it is, in words.
pub(super) fn labelled(words: &str) -> Vec<u8> {
    let mut body = vec![words.len() as u8];
    body.extend(words.as_bytes());
    body
}

/// `body` as a file.
fn sealed(body: &[u8], key: &[u8; 32]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(Sha256::digest(body));
    bytes.extend(body);
    bytes
}

const CUT: &str = "the file is cut off";

/// Takes `count` bytes off the front.
fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], &'static str> {
    let (head, tail) = rest.split_at_checked(count).ok_or(CUT)?;
    *rest = tail;
    Ok(head)
}

fn word(rest: &mut &[u8]) -> Result<u64, &'static str> {
    let bytes = take(rest, 8)?;
    Ok(u64::from_le_bytes(std::array::from_fn(|i| bytes[i])))
}

/// What follows the label in a sound file; the error says what is wrong with it.
fn opened<'a>(bytes: &'a [u8], key: &[u8; 32]) -> Result<&'a [u8], &'static str> {
    let mut rest = bytes;
    if take(&mut rest, MAGIC.len())? != MAGIC {
        return Err("not a compliance file of this version");
    }
    if take(&mut rest, key.len())? != key {
        return Err("the file belongs to another gear or other settings");
    }
    let length = word(&mut rest)?;
    let checksum = take(&mut rest, 32)?;
    if rest.len() as u64 != length {
        return Err(CUT);
    }
    if Sha256::digest(rest).as_slice() != checksum {
        return Err("the checksum does not match");
    }
    let label = take(&mut rest, 1)?[0];
    take(&mut rest, label.into())?;
    Ok(rest)
}

/// Reads a stored model.
fn decode(mut rest: &[u8]) -> Result<(Influence, Cost), &'static str> {
    let mut counts = [0; 5];
    for count in &mut counts {
        *count = usize::try_from(word(&mut rest)?).map_err(|_| CUT)?;
    }
    let mut seconds = [0.0; 3];
    for time in &mut seconds {
        *time = f64::from_bits(word(&mut rest)?);
    }
    let [
        elements,
        unknowns,
        factor_entries,
        flank_nodes,
        memory_bytes,
    ] = counts;
    let influence = Influence::decode(rest).ok_or(CUT)?;
    let cost = Cost {
        elements,
        unknowns,
        factor_entries,
        flank_nodes,
        seconds,
        memory_bytes,
    };
    Ok((influence, cost))
}

/// The beginning of a file, up to the end of its label; None for a file that no version of this cache wrote.
fn head(path: &Path) -> Option<Vec<u8>> {
    use std::io::Read;
    let mut head = Vec::new();
    let longest = MAGIC.len() + 32 + 8 + 32 + 1 + usize::from(u8::MAX);
    let file = File::open(path).ok()?;
    file.take(longest as u64).read_to_end(&mut head).ok()?;
    head.starts_with(&MAGIC[..COMMON]).then_some(head)
}

/// The gear in the `head` of a file in words; None for a file of another version.
fn label(head: &[u8]) -> Option<String> {
    let mut rest = head.strip_prefix(MAGIC)?.get(72..)?;
    let length = take(&mut rest, 1).ok()?[0];
    String::from_utf8(take(&mut rest, length.into()).ok()?.to_vec()).ok()
}

#[cfg(test)]
#[path = "cache_tests.rs"]
mod tests;
