//! Computed models kept in files of one folder of bounded size.
//!
//! The key of a model is the SHA-256 of what it is computed from: the mesh of the section and its layers, material and number of
//! teeth, how many of them are asked for, and the version of the code. So every setting and constant that shapes section and
//! layers shapes its key without a list to keep; for what is done with them [`VERSION`] stands.
//!
//! File: magic line, SHA-256 of the rest, key, label, body; little endian. A file that is cut,
//! altered or of another version is recomputed and replaced, with a note; it never gives a result. A
//! half-written one is never found. When a new model does not fit, the least recently used ones go.

use super::FiniteElementError;
use super::model::Model;
use crate::storage::write_whole;
use gearmesh::gear::Gear;
use gearmesh::words::{hex, rounded};
use sha2::{Digest, Sha256};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Changes with the layout of the file.
const MAGIC: &[u8; 32] = b"gearmesh finite elements v0005\r\n";

/// Changes with what is computed of section and layers: a method, or a constant that they do not show, such as how many modes of the sides and
/// Fourier indices are left out, or how the result is rounded. What was kept is then not found.
const VERSION: u32 = 6;

/// How many bytes of it all versions share: these tell a file of this cache from others.
const COMMON: usize = MAGIC.len() - b"0005\r\n".len();

/// Bytes before the checksum, the key and the label: a byte with its length, then its text.
const CHECKSUM: usize = MAGIC.len();
const KEY: usize = CHECKSUM + 32;
const LABEL: usize = KEY + 32;

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

    /// Whether `what` is computed of `model` is there, sound or not.
    pub(super) fn holds(&self, model: &Model, reach: usize, what: &str) -> bool {
        self.path(&key(model, reach, what)).exists()
    }

    fn path(&self, key: &[u8; 32]) -> PathBuf {
        self.directory.join(format!("{}.{ENDING}", hex(&key[..12])))
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

/// What a file holds.
pub(super) trait Stored: Sized {
    fn encode(&self) -> Vec<u8>;

    /// None for anything else than what [`Stored::encode`] gives.
    fn decode(bytes: &[u8]) -> Option<Self>;
}

/// What `compute` gives of `model` for teeth up to `reach` apart, by way of `cache` if there is one. `what` that is, in words, is
/// part of its key. An unusable cache costs the time of a computation.
///
/// # Errors
/// Those of `compute`.
pub(super) fn get<T: Stored>(
    cache: Option<&ModelCache>,
    model: &Model,
    reach: usize,
    what: &str,
    compute: impl FnOnce() -> Result<T, FiniteElementError>,
) -> Result<(T, Origin), FiniteElementError> {
    let Some(cache) = cache else {
        return Ok((compute()?, Origin::Computed));
    };
    let key = key(model, reach, what);
    let path = cache.path(&key);
    let in_words = |reason: &dyn Display| format!("{}: {reason}", path.display());
    let fault = match read(&path, &key) {
        Ok(found) => {
            // Notes that it was used. Folders that are not the user's own need not allow it.
            let _ = File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
            return Ok((found, Origin::Loaded));
        }
        Err(fault) => fault,
    };
    let found = compute()?;
    let origin = match cache.store(&path, &sealed(&key, what, &found.encode())) {
        Err(error) => Origin::NotStored(in_words(&error)),
        Ok(()) if fault.kind() == io::ErrorKind::NotFound => Origin::Stored,
        Ok(()) => Origin::Replaced(in_words(&fault)),
    };
    Ok((found, origin))
}

/// The key of `what` is computed of `model`.
pub(super) fn key(model: &Model, reach: usize, what: &str) -> [u8; 32] {
    let code = (env!("CARGO_PKG_VERSION"), VERSION);
    Sha256::digest(format!("{code:?} {what:?} {reach} {}", model.identity())).into()
}

/// What the file at `path` with this `key` holds.
fn read<T: Stored>(path: &Path, key: &[u8; 32]) -> io::Result<T> {
    let bytes = fs::read(path)?;
    let fault = |reason: &str| io::Error::new(io::ErrorKind::InvalidData, reason);
    if !bytes.starts_with(MAGIC) {
        return Err(fault("not a compliance file of this version"));
    }
    let cut = || fault("the file is cut off or altered");
    let (checksum, sealed) = bytes[CHECKSUM..].split_at_checked(32).ok_or_else(cut)?;
    if Sha256::digest(sealed)[..] != *checksum {
        return Err(cut());
    }
    if !sealed.starts_with(key) {
        return Err(fault("the file belongs to another gear or other settings"));
    }
    let body = LABEL + 1 + usize::from(bytes[LABEL]);
    T::decode(&bytes[body..]).ok_or_else(cut)
}

fn sealed(key: &[u8; 32], label: &str, body: &[u8]) -> Vec<u8> {
    let label = [&[label.len() as u8], label.as_bytes()].concat();
    let sealed = [key, &label[..], body].concat();
    [&MAGIC[..], &Sha256::digest(&sealed), &sealed].concat()
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

/// The beginning of a file, up to the end of its label; None for a file that no version of this cache wrote.
fn head(path: &Path) -> Option<Vec<u8>> {
    let mut head = Vec::new();
    let longest = LABEL + 1 + usize::from(u8::MAX);
    let file = File::open(path).ok()?;
    file.take(longest as u64).read_to_end(&mut head).ok()?;
    head.starts_with(&MAGIC[..COMMON]).then_some(head)
}

/// The label in the `head` of a file; None for a file of another version.
fn label(head: &[u8]) -> Option<String> {
    let length = head.starts_with(MAGIC).then(|| head.get(LABEL))??;
    let label = head.get(LABEL + 1..)?.get(..usize::from(*length))?;
    String::from_utf8(label.to_vec()).ok()
}

#[cfg(test)]
#[path = "cache_tests.rs"]
mod tests;
