//! The models of both gears of a pair.

use super::cache::same_model;
use super::{FiniteElementCompliance, FiniteElementError, ModelCache, Origin, Progress, Settings};
use gearmesh::gear::PairGeometry;
use std::sync::Arc;

/// Models of gear 1 and gear 2; the same one twice when the gears are equal but for hand and axial
/// position.
#[derive(Debug, Clone)]
pub struct PairCompliance {
    /// One model per gear.
    pub gears: [Arc<FiniteElementCompliance>; 2],
    /// Where each came from.
    pub origins: [Origin; 2],
}

impl PairCompliance {
    /// Whether `cache` holds both models, sound or not.
    ///
    /// # Errors
    /// Those of gears that cannot be meshed.
    pub fn is_kept(
        pair: &PairGeometry,
        settings: &Settings,
        cache: &ModelCache,
    ) -> Result<bool, FiniteElementError> {
        let [first, second] = &pair.gears;
        Ok(cache.holds(first, settings)? && cache.holds(second, settings)?)
    }

    /// Computes both models, or reads them from the cache if there is one. `progress` is
    /// called with the number of the gear (0 or 1) in front.
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn new(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &(dyn Fn(usize, super::Stage, f64) -> bool + Sync),
    ) -> Result<PairCompliance, FiniteElementError> {
        let model = |gear: usize| {
            let told: &Progress<'_> = &|stage, share| progress(gear, stage, share);
            match cache {
                Some(cache) => {
                    FiniteElementCompliance::cached(&pair.gears[gear], settings, cache, told)
                }
                None => FiniteElementCompliance::new(&pair.gears[gear], settings, told)
                    .map(|model| (model, Origin::Computed)),
            }
            .map(|(model, origin)| (Arc::new(model), origin))
        };
        let first = model(0)?;
        let second = if same_model(&pair.gears, settings)? {
            first.clone()
        } else {
            model(1)?
        };
        Ok(PairCompliance {
            gears: [first.0, second.0],
            origins: [first.1, second.1],
        })
    }
}
