//! Maps of root stress in the cache of elastic models, and those of a pair.

use std::sync::Arc;

use super::cache::{gear_in_words, key_of, labelled, same_model};
use super::fillet::COMPONENTS;
use super::model::Model;
use super::root_stress::RootStress;
use super::{FiniteElementError, ModelCache, Origin, Progress, Settings, Stage};
use gearmesh::gear::{Flank, Gear, PairGeometry};

/// What is computed of the mesh beside its compliance.
const WHAT: &[u8] = b"root stress";

impl RootStress {
    /// As [`RootStress::new`], by way of `cache` if there is one.
    ///
    /// # Errors
    /// Those of [`RootStress::new`].
    pub fn cached(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let Some(cache) = cache else {
            return Ok((Self::new(gear, settings, progress)?, Origin::Computed));
        };
        let model = Model::new(gear, settings)?;
        let mut what = WHAT.to_vec();
        for node in &model.mesh.fillet {
            what.extend((*node as u64).to_le_bytes());
        }
        let key = key_of(&model, settings.reach, &what);
        let decode = |body: &[u8]| {
            let mut found = RootStress::without_map(&model, settings.reach);
            found.decode(body).ok_or("the file is cut off")?;
            Ok(found)
        };
        let fault = match cache.read(&key, decode) {
            Ok(found) => return Ok((found, Origin::Loaded)),
            Err(fault) => fault,
        };
        let computed = model.root_stress(settings.reach, progress)?;
        let mut body = labelled(&format!("root stress, {}", gear_in_words(gear)));
        computed.encode(&mut body);
        let origin = cache.keep(&key, &body, fault);
        Ok((computed, origin))
    }

    fn encode(&self, out: &mut Vec<u8>) {
        out.extend(self.scales.iter().flat_map(|s| s.to_le_bytes()));
        out.extend(self.map.iter().flat_map(|s| s.to_le_bytes()));
    }

    /// None if `bytes` are not as many as the map has.
    fn decode(&mut self, bytes: &[u8]) -> Option<()> {
        let columns = (2 * self.reach + 1) * self.loads.len();
        let (scales, map) = bytes.split_at_checked(4 * columns)?;
        if map.len() != 2 * columns * COMPONENTS * self.fillet.len() {
            return None;
        }
        let scale = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        self.scales = scales.chunks_exact(4).map(scale).collect();
        let entry = |b: &[u8]| i16::from_le_bytes([b[0], b[1]]);
        self.map = map.chunks_exact(2).map(entry).collect();
        Some(())
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
    progress: &(dyn Fn(usize, Stage, f64) -> bool + Sync),
) -> Result<[(Arc<RootStress>, Origin); 2], FiniteElementError> {
    let settings = settings.for_root_stress();
    // As strips see them: turned end for end where they are mirrored.
    let gears = [0, 1].map(|i| {
        let turned = pair.gears[i].turned();
        let turned = turned.filter(|_| pair.is_mirrored(flank, i));
        turned.unwrap_or_else(|| pair.gears[i].clone())
    });
    let model = |gear: usize| {
        let told: &Progress<'_> = &|stage, share| progress(gear, stage, share);
        RootStress::cached(&gears[gear], &settings, cache, told)
            .map(|(model, origin)| (Arc::new(model), origin))
    };
    let first = model(0)?;
    let second = match same_model(&gears, &settings)? {
        true => first.clone(),
        false => model(1)?,
    };
    Ok([first, second])
}
