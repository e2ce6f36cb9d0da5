//! The models of both gears of a pair.

use super::model::Model;
use super::{
    FiniteElementCompliance, FiniteElementError, ModelCache, Origin, Progress, RootStress,
    Settings, Stage,
};
use gearmesh::gear::{Flank, Gear, PairGeometry};
use std::sync::Arc;

/// Progress of both gears: the number of the gear (0 or 1) in front of what [`Progress`] is called with.
type PairProgress<'a> = dyn Fn(usize, Stage, f64) -> bool + Sync + 'a;

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
        for gear in &pair.gears {
            for gear in gear.turned().iter().chain([gear]) {
                if !cache.holds(&Model::new(gear, settings)?) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
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
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        let [(first, from), (second, second_from)] = both(&pair.gears, |i| {
            let progress: &Progress<'_> = &|stage, share| progress(i, stage, share);
            FiniteElementCompliance::cached(&pair.gears[i], settings, cache, progress)
                .map(|(model, origin)| (Arc::new(model), origin))
        })?;
        Ok(PairCompliance {
            gears: [first, second],
            origins: [from, second_from],
        })
    }
}

/// The maps of gear 1 and gear 2 of `pair` loaded on `flank` (of gear 1), the same one twice for equal gears; `settings` are
/// those of its compliance.
/// `progress` is called with the number of the gear (0 or 1) in front.
///
/// # Errors
/// Those of [`RootStress::new`].
pub fn pair_root_stress(
    pair: &PairGeometry,
    flank: Flank,
    settings: &Settings,
    cache: Option<&ModelCache>,
    progress: &PairProgress<'_>,
) -> Result<[(Arc<RootStress>, Origin); 2], FiniteElementError> {
    let settings = settings.for_root_stress();
    // As segments see them: turned end for end where they are mirrored.
    let gears = [0, 1].map(|i| {
        let turned = pair.gears[i].turned();
        let turned = turned.filter(|_| pair.is_mirrored(flank, i));
        turned.unwrap_or_else(|| pair.gears[i].clone())
    });
    both(&gears, |i| {
        let progress: &Progress<'_> = &|stage, share| progress(i, stage, share);
        RootStress::cached(&gears[i], &settings, cache, progress)
            .map(|(model, origin)| (Arc::new(model), origin))
    })
}

/// What `model` gives of the first and the second gear; of gears that are alike the same. Models are in canonical coordinates: hand
/// and axial position do not matter.
fn both<T: Clone>(
    gears: &[Gear; 2],
    mut model: impl FnMut(usize) -> Result<T, FiniteElementError>,
) -> Result<[T; 2], FiniteElementError> {
    let [first, second] = gears.each_ref().map(|gear| Gear {
        hand: 1.0,
        face_offset: 0.0,
        ..gear.clone()
    });
    let of_first = model(0)?;
    let of_second = match first == second {
        true => of_first.clone(),
        false => model(1)?,
    };
    Ok([of_first, of_second])
}
