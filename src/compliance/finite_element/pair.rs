//! The models of both gears of a pair.

use super::cache::same_model;
use super::{
    Estimate, FiniteElementCompliance, FiniteElementError, ModelCache, Origin, Progress, Settings,
};
use crate::gear::PairGeometry;
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
    /// What [`PairCompliance::new`] will take for gear 1 and gear 2; nothing for a gear 2 that shares gear 1's model.
    ///
    /// # Errors
    /// Those of gears that cannot be meshed.
    pub fn estimate(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&ModelCache>,
    ) -> Result<[Estimate; 2], FiniteElementError> {
        let first = Estimate::new(&pair.gears[0], settings, cache)?;
        let second = match same_model(&pair.gears, settings)? {
            true => Estimate::default(),
            false => Estimate::new(&pair.gears[1], settings, cache)?,
        };
        Ok([first, second])
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
