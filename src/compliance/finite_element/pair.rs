//! The models of both gears of a pair.

use super::cache::same_model;
use super::{FiniteElementCompliance, FiniteElementError, Origin, Progress, Settings};
use crate::gear::PairGeometry;
use std::path::Path;
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
    /// Computes both models, or reads them from the cache directory if there is one. `progress` is
    /// called with the number of the gear (0 or 1) in front.
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn new(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&Path>,
        progress: &(dyn Fn(usize, super::Stage, f64) -> bool + Sync),
    ) -> Result<PairCompliance, FiniteElementError> {
        let model = |gear: usize| {
            let told: &Progress<'_> = &|stage, share| progress(gear, stage, share);
            match cache {
                Some(directory) => {
                    FiniteElementCompliance::cached(&pair.gears[gear], settings, directory, told)
                }
                None => FiniteElementCompliance::new(&pair.gears[gear], settings, told)
                    .map(|model| (model, Origin::Computed)),
            }
            .map(|(model, origin)| (Arc::new(model), origin))
        };
        let first = model(0)?;
        let second = if same_model(&pair.gears[0], &pair.gears[1]) {
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
