//! What tests of several modules share.

use gearmesh::compliance::ToothCompliance;
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Gear;
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::finite_element::{FiniteElementCompliance, Settings};
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

type Kept = Arc<OnceLock<Arc<FiniteElementCompliance>>>;

/// Solver of `pair` on coarse finite elements. Their models are kept, since most tests ask for the same few.
pub fn coarse_solver(pair: &Pair, contact: ContactSettings) -> ContactSolver {
    let coarse = Pair {
        refinement: Refinement::Coarse,
        ..pair.clone()
    };
    let settings = Settings::for_pair(&coarse);
    let compliance = pair.geometry.gears.each_ref().map(|gear| {
        let model: Arc<dyn ToothCompliance> = kept(gear, &settings);
        model
    });
    ContactSolver::new(pair, compliance, contact).unwrap()
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
    let new = || FiniteElementCompliance::new(&canonical, settings, &|_, _| true).unwrap();
    Arc::clone(model.get_or_init(|| Arc::new(new())))
}
