//! The elastic models of both gears and the contact solver on them.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use crate::compliance::ToothCompliance;
use crate::gear::Pair;
use crate::static_contact::{ContactError, ContactSolver, contact_settings};
use gearmesh::contact::ContactSettings;
use gearmesh::gear::Flank;

use crate::finite_element::{
    FiniteElementError, ModelCache, Origin, PairCompliance, RootStress, Settings, Stage,
    pair_root_stress,
};

/// Progress of long work: called from any thread with the stage in words and the share of it that is done.
pub type StageProgress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// How the teeth of a pair are modelled, beyond what its pair file says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelSettings {
    /// Hold the axial displacement: every slice deforms by itself, as in a two-dimensional calculation.
    pub plane_strain: bool,
    /// Stations along the face; None: those of [`contact_settings`], and fewer for contact at run time.
    pub stations: Option<usize>,
    /// Where finite-element models are kept; None: each is computed anew.
    pub cache: Option<ModelCache>,
}

impl ModelSettings {
    /// Settings of the finite elements of `pair`.
    pub fn finite_elements(&self, pair: &Pair) -> Settings {
        Settings {
            plane_strain: self.plane_strain,
            ..Settings::for_pair(pair)
        }
    }

    /// Settings of the contact of `pair`.
    pub fn contact(&self, pair: &Pair) -> ContactSettings {
        let settings = contact_settings(pair);
        ContactSettings {
            stations: self.stations.unwrap_or(settings.stations),
            ..settings
        }
    }

    /// Models of the stress in the tooth roots of both gears of `pair`, loaded on `flank` of gear 1.
    ///
    /// # Errors
    /// Those of [`RootStress::new`].
    pub fn root_models(
        &self,
        pair: &Pair,
        flank: Flank,
        progress: StageProgress,
    ) -> Result<RootModels, FiniteElementError> {
        let begin = Instant::now();
        let models = pair_root_stress(
            &pair.geometry,
            flank,
            &self.finite_elements(pair),
            self.cache.as_ref(),
            &report("models of the fillets", progress),
        )?;
        Ok(RootModels {
            maps: models.gears,
            origins: models.origins,
            seconds: begin.elapsed().as_secs_f64(),
        })
    }
}

/// Why elastic models could not be made or used.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// No finite-element model.
    #[error(transparent)]
    FiniteElement(#[from] FiniteElementError),
    /// Contact of these gears cannot be solved.
    #[error(transparent)]
    Contact(#[from] ContactError),
}

/// The elastic models of both gears of a pair and the contact solver on them.
pub struct ElasticModels {
    /// The pair that they are models of.
    pub pair: Pair,
    /// How its teeth are modelled.
    pub settings: ModelSettings,
    /// Static contact of the pair.
    pub solver: ContactSolver,
    /// Gear 1 and gear 2.
    pub compliance: [Arc<dyn ToothCompliance>; 2],
    /// Where the model of each gear came from.
    pub origins: [Origin; 2],
    /// Wall clock that they took, s.
    pub seconds: f64,
}

/// Models of the stress in the tooth roots.
#[derive(Debug, Clone)]
pub struct RootModels {
    /// Maps from loads on the flank to the stress in the roots of gear 1 and gear 2.
    pub maps: [Arc<RootStress>; 2],
    /// Where each came from.
    pub origins: [Origin; 2],
    /// Wall clock that they took, s.
    pub seconds: f64,
}

impl ElasticModels {
    /// Computes the models of `pair`, or reads them from the cache of `settings`.
    ///
    /// # Errors
    /// Gears that cannot be meshed, memory, settings that no contact can be solved with.
    pub fn new(
        pair: &Pair,
        settings: &ModelSettings,
        progress: StageProgress,
    ) -> Result<ElasticModels, ModelError> {
        let begin = Instant::now();
        let models = PairCompliance::of(
            pair,
            &settings.finite_elements(pair),
            settings.cache.as_ref(),
            &report("elastic models", progress),
        )?;
        let [first, second] = models.gears;
        let compliance: [Arc<dyn ToothCompliance>; 2] = [first, second];
        Ok(ElasticModels {
            solver: ContactSolver::new(pair, compliance.clone(), settings.contact(pair))?,
            pair: pair.clone(),
            settings: settings.clone(),
            compliance,
            origins: models.origins,
            seconds: begin.elapsed().as_secs_f64(),
        })
    }

    /// The solver whose contact an FMU solves at run time: on fewer stations, unless their number was set.
    pub fn solver_at_run_time(&self) -> ContactSolver {
        match self.settings.stations {
            Some(_) => self.solver.clone(),
            None => self.solver.clone().at_run_time(),
        }
    }

    /// The models in words: refinement, plane strain, shafts, contact on the path only.
    pub fn description(&self) -> String {
        let mut words = format!("finite elements, {:?}", self.pair.refinement).to_lowercase();
        if self.settings.plane_strain {
            words.push_str(", plane strain");
        }
        words.push_str(match self.pair.shafts {
            [Some(_), Some(_)] => ", shafts on bearings",
            [Some(_), None] => ", shaft of gear 1 on bearings",
            [None, Some(_)] => ", shaft of gear 2 on bearings",
            [None, None] => "",
        });
        if !self.pair.tip_corner_contact {
            words.push_str(", contact on the path only");
        }
        words
    }
}

/// Share of the work on a model that its condensation is.
const CONDENSATION: f64 = 0.6;

/// Reports to `progress` how far the `models` of both gears are.
fn report<'a>(
    models: &'a str,
    progress: StageProgress<'a>,
) -> impl Fn(usize, Stage, f64) -> bool + Sync + 'a {
    let done: Mutex<[Option<f64>; 2]> = Mutex::new([None; 2]);
    move |gear, stage, share| {
        let share = match stage {
            Stage::Assembly | Stage::Condensation => CONDENSATION * share,
            Stage::Ring => CONDENSATION + (1.0 - CONDENSATION) * share,
        };
        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
        done[gear] = Some(share);
        // Of a gear that is kept or is like the other nothing is heard.
        let heard: Vec<f64> = done.iter().copied().flatten().collect();
        drop(done);
        progress(models, heard.iter().sum::<f64>() / heard.len() as f64);
        true
    }
}
