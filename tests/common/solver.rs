//! What tests of several modules share.

#![allow(dead_code)] // none needs all of it

use gearmesh::contact::ContactSettings;
use gearmesh::gear::Gear;
use gearmesh_preprocessor::compliance::ToothCompliance;
use gearmesh_preprocessor::finite_element::{
    FiniteElementCompliance, ModelCache, PairCompliance, Settings,
};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::static_contact::ContactSolver;
use gearmesh_preprocessor::table::Progress;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

/// Shows no progress.
pub const QUIET: Progress = &|_, _| ();

type Kept = Arc<OnceLock<Arc<FiniteElementCompliance>>>;

/// Defaults but for the number of stations along the face.
pub fn with_stations(stations: usize) -> ContactSettings {
    ContactSettings {
        stations,
        ..ContactSettings::default()
    }
}

/// Solver of `pair` on coarse finite elements. Their models are kept, since most tests ask for the same few.
pub fn coarse_solver(pair: &Pair, contact: ContactSettings) -> ContactSolver {
    let coarse = Pair {
        refinement: Refinement::Coarse,
        ..pair.clone()
    };
    let settings = Settings::for_pair(&coarse);
    let kept = |gear| -> Arc<dyn ToothCompliance> { kept(gear, &settings) };
    let compliance = pair.geometry.gears.each_ref().map(kept);
    ContactSolver::new(pair, compliance, contact).unwrap()
}

/// Solver of `pair` on finite elements as `settings` say, from `cache` where they are there.
pub fn solver(
    pair: &Pair,
    settings: &Settings,
    cache: Option<&ModelCache>,
    contact: ContactSettings,
) -> ContactSolver {
    let models = PairCompliance::new(&pair.geometry, settings, cache, &|_, _, _| true);
    let [first, second] = models.unwrap().gears;
    ContactSolver::new(pair, [first, second], contact).unwrap()
}

fn kept(gear: &Gear, settings: &Settings) -> Arc<FiniteElementCompliance> {
    static MODELS: LazyLock<Mutex<HashMap<String, Kept>>> = LazyLock::new(Mutex::default);
    // Models do not know of hand and axial position.
    let canonical = Gear {
        hand: 1.0,
        face_offset: 0.0,
        ..gear.clone()
    };
    let key = format!("{canonical:?} {settings:?}");
    let mut models = MODELS.lock().unwrap_or_else(PoisonError::into_inner);
    let model = Arc::clone(models.entry(key).or_default());
    // Other models may be computed meanwhile.
    drop(models);
    let new = || FiniteElementCompliance::new(&canonical, settings, None, &|_, _| true).unwrap();
    Arc::clone(model.get_or_init(|| Arc::new(new().0)))
}
