//! `gearmesh cache`: what is in the folder that keeps elastic models of teeth.

use clap::Args;
use gearmesh::words::count;
use indicatif::HumanDuration;

use crate::columns::Listing;
use crate::error::Result;
use crate::model::CacheArgs;
use crate::output;

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
    pub fn run(self) -> Result<()> {
        let cache = self.cache.cache();
        let cache = cache.ok_or("no folder for elastic models: name one with --cache-dir")?;
        let folder = cache.directory.display();
        let failed = |error| format!("{folder}: {error}; name another folder with --cache-dir");
        let models = cache.models().map_err(failed)?;
        let total = megabytes(models.iter().map(|model| model.bytes).sum());
        if self.clear {
            let removed = count(cache.clear().map_err(failed)?, "model");
            let mut text = format!("{folder}: removed {removed}, {total}\n");
            for path in cache.others().map_err(failed)? {
                text += &format!("left {}, which is no model of this cache\n", path.display());
            }
            return output::print(&text);
        }
        let mut rows = Listing::default();
        for model in models.iter().rev() {
            let unused = HumanDuration(model.used.elapsed().unwrap_or_default());
            let gear = model.gear.as_deref().unwrap_or("model of another version");
            let size = megabytes(model.bytes);
            rows.row(gear, format!("{size}, last used {unused} ago"));
        }
        let number = count(models.len(), "elastic model");
        let limit = megabytes(cache.limit);
        output::print(&format!("{folder}: {number}, {total} of {limit}\n{rows}"))
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
