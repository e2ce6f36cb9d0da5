//! The models of both gears of a pair.

use std::sync::Arc;

use gearmesh::gear::{Flank, Gear, PairGeometry};

use super::cache::{ModelCache, Origin};
use super::error::FiniteElementError;
use super::gear_model::FiniteElementCompliance;
use super::model::{Progress, Stage};
use super::root_stress::RootStress;
use super::settings::Settings;
use super::uneven;
use crate::gear::{Pair, body};

/// Progress of both gears: the number of the gear (0 or 1) in front of what [`Progress`] is called with.
type PairProgress<'a> = dyn Fn(usize, Stage, f64) -> bool + Sync + 'a;

/// Models of gear 1 and gear 2; the same one twice when the gears are equal but for hand and axial position.
#[derive(Debug, Clone)]
pub struct PairModels<T> {
    /// One model per gear.
    pub gears: [Arc<T>; 2],
    /// Where each came from.
    pub origins: [Origin; 2],
}

/// Elastic models of both gears.
pub type PairCompliance = PairModels<FiniteElementCompliance>;

impl PairCompliance {
    /// Models of `pair` with its bodies; see [`PairCompliance::new`].
    ///
    /// # Errors
    /// As there; [`FiniteElementError::PlaneBody`] for a body that is no solid of revolution in plane strain.
    pub fn of(
        pair: &Pair,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        let mut models = PairCompliance::new(&cut_pair(pair), settings, cache, progress)?;
        for (i, body) in pair.bodies.iter().enumerate() {
            if let Some(body) = body {
                let (gear, progress) = (&pair.geometry.gears[i], |stage, share| {
                    progress(i, stage, share)
                });
                let model = models.gears[i].on_body(gear, body, settings, cache, &progress)?;
                models.gears[i] = Arc::new(model);
            }
        }
        Ok(models)
    }

    /// Computes both models, or reads them from the cache if there is one.
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn new(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        both(
            &pair.gears,
            settings,
            progress,
            |gear, settings, progress| {
                FiniteElementCompliance::new(gear, settings, cache, progress)
            },
        )
    }
}

/// The geometry of `pair`, its teeth cut from bodies that are no solids of revolution.
fn cut_pair(pair: &Pair) -> PairGeometry {
    let mut geometry = pair.geometry.clone();
    for (gear, body) in geometry.gears.iter_mut().zip(&pair.bodies) {
        if let Some(body) = body {
            *gear = uneven::cut_from(gear, body);
        }
    }
    geometry
}

/// The maps of gear 1 and gear 2 of `pair` loaded on `flank` (of gear 1), the same one twice for equal gears; `settings` are
/// those of its compliance.
///
/// # Errors
/// Those of [`RootStress::new`].
pub fn pair_root_stress(
    pair: &PairGeometry,
    flank: Flank,
    settings: &Settings,
    cache: Option<&ModelCache>,
    progress: &PairProgress<'_>,
) -> Result<PairModels<RootStress>, FiniteElementError> {
    let settings = settings.for_root_stress();
    // As segments see them: turned end for end where they are mirrored.
    let gears = [0, 1].map(|i| {
        let turned = body::turned(&pair.gears[i]);
        let turned = turned.filter(|_| pair.is_mirrored(flank, i));
        turned.unwrap_or_else(|| pair.gears[i].clone())
    });
    both(&gears, &settings, progress, |gear, settings, progress| {
        RootStress::new(gear, settings, cache, progress)
    })
}

/// What `model` gives of the first and the second gear; of gears that are alike the same. Models are in canonical coordinates: hand
/// and axial position do not matter.
fn both<T: Send + Sync>(
    gears: &[Gear; 2],
    settings: &Settings,
    progress: &PairProgress<'_>,
    model: impl Fn(&Gear, &Settings, &Progress<'_>) -> Result<(T, Origin), FiniteElementError> + Sync,
) -> Result<PairModels<T>, FiniteElementError> {
    let [first, second] = gears.each_ref().map(|gear| Gear {
        hand: 1.0,
        face_offset: 0.0,
        ..gear.clone()
    });
    let alike = first == second;
    let of = |i: usize, share: f64| {
        let settings = Settings {
            memory_share: share * settings.memory_share,
            ..*settings
        };
        model(&gears[i], &settings, &|stage, share| {
            progress(i, stage, share)
        })
    };
    // At once: each leaves threads idle now and then.
    let (first, second) = match alike {
        true => (of(0, 1.0), None),
        false => {
            let (first, second) = rayon::join(|| of(0, 0.5), || of(1, 0.5));
            (first, Some(second))
        }
    };
    // Memory that does not do for both may do for one after the other.
    let again = |i: usize, found| match found {
        Err(FiniteElementError::Memory { .. }) => of(i, 1.0),
        found => found,
    };
    let second = second.map(|second| again(1, second)).transpose()?;
    let (first, first_origin) = again(0, first)?;
    let first = Arc::new(first);
    let (second, second_origin) = match second {
        Some((second, origin)) => (Arc::new(second), origin),
        None => (first.clone(), first_origin.clone()),
    };
    Ok(PairModels {
        gears: [first, second],
        origins: [first_origin, second_origin],
    })
}
