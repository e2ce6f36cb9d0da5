//! `gearmesh cache`: the elastic models that are kept, and the options that say where.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::words::count;
use gearmesh_preprocessor::finite_element::ModelCache;
use indicatif::HumanDuration;

use crate::Error;
use crate::output::{self, Listing};

/// Where elastic models are kept.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Cache of elastic models")]
pub struct CacheArgs {
    /// Folder that keeps elastic models [default: gearmesh in the user's cache folder]
    #[arg(long, env = "GEARMESH_CACHE_DIR", hide_env_values = true)]
    cache_dir: Option<PathBuf>,

    /// Largest size of that folder in megabytes; the least recently used models make room for new ones
    #[arg(long, env = "GEARMESH_CACHE_LIMIT_MB", hide_env_values = true, value_name = "MB", default_value_t = ModelCache::DEFAULT_LIMIT / 1_000_000)]
    cache_limit_mb: u64,
}

impl CacheArgs {
    /// The cache; None where the system names no folder for it.
    pub fn cache(&self) -> Option<ModelCache> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let directory = (self.cache_dir.clone())
            .or_else(|| variable("XDG_CACHE_HOME").map(|base| Path::new(&base).join("gearmesh")))
            .or_else(|| variable("HOME").map(|home| Path::new(&home).join(".cache/gearmesh")))
            .or_else(|| variable("LOCALAPPDATA").map(|base| Path::new(&base).join("gearmesh")))?;
        let limit = self.cache_limit_mb.saturating_mul(1_000_000);
        Some(ModelCache::new(directory, limit))
    }
}

/// Show or empty the folder that keeps elastic models of teeth.
#[derive(Debug, Args)]
pub struct Cache {
    /// Remove all models; other files stay
    #[arg(long)]
    clear: bool,

    #[command(flatten)]
    cache: CacheArgs,
}

impl Cache {
    pub fn run(self) -> Result<(), Error> {
        let cache = self.cache.cache();
        let cache = cache.ok_or("no folder for elastic models: name one with --cache-dir")?;
        let folder = cache.directory().display();
        let failed = |error| format!("{folder}: {error}; name another folder with --cache-dir");
        let models = cache.models().map_err(failed)?;
        let total = megabytes(models.iter().map(|model| model.bytes).sum());
        if self.clear {
            let removed = count(cache.clear().map_err(failed)?, "model");
            let mut text = format!("{folder}: removed {removed}, {total}\n");
            for path in cache.others().map_err(failed)? {
                text += &format!("left {}, which is no model of this cache\n", path.display());
            }
            return Ok(output::print(&text)?);
        }
        let mut rows = Listing::default();
        for model in models.iter().rev() {
            let unused = HumanDuration(model.used.elapsed().unwrap_or_default());
            let gear = model.gear.as_deref().unwrap_or("model of another version");
            let size = megabytes(model.bytes);
            rows.row(gear, format!("{size}, last used {unused} ago"));
        }
        let number = count(models.len(), "elastic model");
        let limit = megabytes(cache.limit());
        Ok(output::print(&format!(
            "{folder}: {number}, {total} of {limit}\n{rows}"
        ))?)
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
