//! Contact at run time of a shipped pair on its own elements, whose models are kept in target/finite-elements.

use std::error::Error;
use std::path::Path;

use gearmesh::compliance::finite_element::{ModelCache, PairCompliance, Settings};
use gearmesh::contact::{ContactFile, ContactSettings, ContactSolver};
use gearmesh::pair::Pair;

/// The pair `name` of resources/pairs, its solver and what a unit packs of it.
pub fn ready(name: &str) -> Result<(Pair, ContactSolver, ContactFile), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pair = Pair::read(folder.join(format!("resources/pairs/{name}.json")))?;
    let settings = Settings::for_pair(&pair);
    let kept = folder.join("target/finite-elements");
    let cache = ModelCache::new(kept, ModelCache::DEFAULT_LIMIT);
    let models = PairCompliance::new(&pair.geometry, &settings, Some(&cache), &|_, _, _| true)?;
    let [first, second] = models.gears;
    let contact = ContactSettings::for_pair(&pair);
    let solver = ContactSolver::new(&pair, [first, second], contact)?;
    let file = ContactFile::new(&pair, &solver.clone().at_run_time())?;
    Ok((pair, solver, file))
}
