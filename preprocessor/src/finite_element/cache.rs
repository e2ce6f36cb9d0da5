//! Computed models kept in files of one folder of bounded size.
//!
//! The key of a model is the SHA-256 of what it is computed from: the mesh of the section and its layers, material, number and
//! reach of teeth, and the version of the code. So every constant that shapes section and layers shapes its key; for what is
//! done with them [`VERSION`] stands.
//!
//! A file ([`gearmesh::sealed`]) holds label, key and body. One that is cut, altered or of another version is recomputed and
//! replaced, with a note; it never gives a result. When a new model does not fit, the least recently used ones go.

use super::error::FiniteElementError;
use super::model::Model;
use crate::storage::{self, write_whole};
use gearmesh::sealed;
use gearmesh::words::hex;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Changes with the layout of the file.
const MAGIC: &[u8; 32] = b"gearmesh finite elements v0006\r\n";

/// Changes with what is computed of section and layers: a method, or a constant that they do not show. What was kept is then not found.
const VERSION: u32 = 12;

/// How many bytes of the magic line all versions share: these tell a file of this cache from others.
const COMMON: usize = MAGIC.len() - b"0006\r\n".len();

/// Bytes of the label in a file, filled up with spaces.
const LABEL: usize = 128;

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
    /// The folder, created with the first model.
    pub directory: PathBuf,
    /// Largest size of all models together, bytes.
    pub limit: u64,
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

    /// The models in `directory`, `limit` bytes at most.
    pub fn new(directory: impl Into<PathBuf>, limit: u64) -> ModelCache {
        ModelCache {
            directory: directory.into(),
            limit,
        }
    }

    /// All models, the least recently used first; none if there is no folder. A file that does not begin as one is none.
    ///
    /// # Errors
    /// What the system says of a folder that cannot be read.
    pub fn models(&self) -> io::Result<Vec<CachedModel>> {
        let mut models = Vec::new();
        for path in self.paths()? {
            // Another run may have removed it meanwhile.
            if let (Some(head), Ok(file)) = (head(&path), fs::metadata(&path)) {
                let label = head.get(sealed::HEAD..).filter(|_| head.starts_with(MAGIC));
                models.push(CachedModel {
                    bytes: file.len(),
                    used: file.modified()?,
                    gear: label.map(|label| String::from_utf8_lossy(label).trim_end().to_owned()),
                    path,
                });
            }
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
        let mut paths = paths.collect::<io::Result<Vec<_>>>()?;
        paths.retain(|path| path.extension().is_some_and(|ending| ending == ENDING));
        Ok(paths)
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

    fn path(&self, key: &[u8]) -> PathBuf {
        self.directory.join(format!("{}.{ENDING}", hex(&key[..12])))
    }

    /// The bytes of the file at `path`.
    fn bytes(&self, path: &Path) -> io::Result<Vec<u8>> {
        let file = storage::open(path)?;
        // No model is larger than the cache, be it that of another run.
        let (length, most) = (file.metadata()?.len(), self.limit.max(Self::DEFAULT_LIMIT));
        if length > most {
            return Err(io::Error::other(format!(
                "it has {} MB, and models have {} MB at most",
                length / 1_000_000,
                most / 1_000_000
            )));
        }
        let mut bytes = Vec::new();
        file.take(most).read_to_end(&mut bytes)?;
        Ok(bytes)
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
        if path.exists() {
            // Only a file makes way for the model.
            storage::open(path)?;
        }
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

/// What `compute` gives of `model`, by way of `cache` if there is one; `what` that is, in words, is part of its key.
///
/// # Errors
/// Those of `compute`.
pub(super) fn get<T: Stored>(
    cache: Option<&ModelCache>,
    model: &Model,
    what: &str,
    compute: impl FnOnce() -> Result<T, FiniteElementError>,
) -> Result<(T, Origin), FiniteElementError> {
    let Some(cache) = cache else {
        return Ok((compute()?, Origin::Computed));
    };
    let key = key(model, what);
    let path = cache.path(&key);
    let in_words = |reason: String| format!("{}: {reason}", path.display());
    let fault = match cache.bytes(&path) {
        Ok(bytes) => match read(&bytes, &key) {
            Ok(found) => {
                // Notes that it was used. Folders that are not the user's own need not allow it.
                let _ = File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
                return Ok((found, Origin::Loaded));
            }
            Err(fault) => Some(fault.to_owned()),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => Some(error.to_string()),
    };
    let found = compute()?;
    let label = format!("{:LABEL$.LABEL$}", format!("{what}{}", model.in_words()));
    let contents = [label.as_bytes(), &key, &found.encode()].concat();
    let origin = match (cache.store(&path, &sealed::seal(MAGIC, &contents)), fault) {
        (Err(error), _) => Origin::NotStored(in_words(error.to_string())),
        (Ok(()), None) => Origin::Stored,
        (Ok(()), Some(fault)) => Origin::Replaced(in_words(fault)),
    };
    Ok((found, origin))
}

/// The key of `what` is computed of `model`.
fn key(model: &Model, what: &str) -> [u8; 32] {
    let code = (env!("CARGO_PKG_VERSION"), VERSION);
    Sha256::digest(format!("{code:?} {what:?} {}", model.identity())).into()
}

/// What `bytes` of a file with this `key` hold.
fn read<T: Stored>(bytes: &[u8], key: &[u8]) -> Result<T, &'static str> {
    let contents = sealed::open(MAGIC, bytes)?;
    let rest = contents.get(LABEL..);
    let keyed = rest.and_then(|rest| rest.strip_prefix(key));
    let body = keyed.ok_or("it belongs to another gear or other settings")?;
    T::decode(body).ok_or("it was cut or altered")
}

/// The beginning of a file, up to the end of its label; None for a file that no version of this cache wrote.
fn head(path: &Path) -> Option<Vec<u8>> {
    let mut head = Vec::new();
    let file = storage::open(path).ok()?;
    let length = sealed::HEAD + LABEL;
    file.take(length as u64).read_to_end(&mut head).ok()?;
    head.starts_with(&MAGIC[..COMMON]).then_some(head)
}

#[cfg(test)]
#[path = "cache_tests.rs"]
mod tests;
