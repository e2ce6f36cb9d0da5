//! Elastic models of teeth: the options of all subcommands that solve contact, and where models are kept.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gearmesh::gear::Flank;
use gearmesh_preprocessor::compliance::ToothCompliance;
use gearmesh_preprocessor::contact::{ElasticModels, ModelSettings};
use gearmesh_preprocessor::finite_element::{ModelCache, Origin, RootStress};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::shaft::held_by_its_shafts;
use gearmesh_preprocessor::static_contact::ContactSolver;

use crate::error::Result;
use crate::limits;
use crate::output::Job;

/// How teeth are modelled.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Fineness of the finite elements: coarse is quickest, fine for convergence studies [default: as the pair file says, normal]
    #[arg(long, value_parser = PossibleValuesParser::new(["coarse", "normal", "fine"]).try_map(|name| serde_json::from_value::<Refinement>(name.into())))]
    refinement: Option<Refinement>,

    /// Whether tip edges may touch outside the path of contact [default: as the pair file says, on]
    #[arg(long, value_parser = PossibleValuesParser::new(["on", "off"]).map(|switch| switch == "on"))]
    tip_corner_contact: Option<bool>,

    /// Hold the axial displacement: every slice by itself, as in a two-dimensional calculation
    #[arg(long)]
    pub plane_strain: bool,

    /// Stress in the tooth roots of both gears, too; its elastic model takes two to three times as long as that of the contact
    #[arg(long)]
    pub root_stress: bool,

    /// Stations along the face [default: 40, for contact at run time 22, fewer where one would be shorter than the widest contact]
    #[arg(long, value_parser = limits::within(1..=1000_usize))]
    stations: Option<usize>,

    /// Compute finite-element models anew and keep none, wherever GEARMESH_CACHE_DIR or --cache-dir would keep them
    #[arg(long)]
    no_cache: bool,

    /// Threads to use, at most 1024 [default: one per core]
    #[arg(long, value_parser = limits::within(1..=1024_usize))]
    threads: Option<usize>,

    /// No progress on standard error
    #[arg(short, long)]
    quiet: bool,

    #[command(flatten)]
    cache: CacheArgs,
}

pub struct Model {
    pub solver: ContactSolver,
    pub description: String,
    /// Seconds, and where the elastic models of both gears came from and are kept.
    pub effort: String,
    pub compliance: Compliance,
    /// Of the loaded flank, where the stress in the roots is requested.
    pub fillets: Option<Fillets>,
}

/// Of gear 1 and gear 2.
pub type Compliance = [Arc<dyn ToothCompliance>; 2];

pub struct Fillets {
    /// Maps from loads to the stress in the roots of gear 1 and gear 2.
    pub maps: [Arc<RootStress>; 2],
    pub effort: String,
}

impl ModelArgs {
    /// The pair with the choices of the command line instead of those of the file.
    pub fn applied_to(&self, mut pair: Pair) -> Pair {
        pair.refinement = self.refinement.unwrap_or(pair.refinement);
        pair.tip_corner_contact = self.tip_corner_contact.unwrap_or(pair.tip_corner_contact);
        pair
    }

    /// Begins the work, on the chosen number of threads. Once per run.
    pub fn start(&self) -> Result<Job> {
        if let Some(threads) = self.threads {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build_global()?;
        }
        Ok(Job::new(self.quiet))
    }

    /// The model of `pair`, to which the command line has been applied; with the fillets for loads on the flank `roots`.
    pub fn model(&self, pair: &Pair, roots: Option<Flank>, job: &Job) -> Result<Model> {
        let settings = self.settings();
        let models = ElasticModels::new(pair, &settings, &|stage, share| job.show(stage, share))?;
        let effort = self.effort(models.seconds, &models.origins);
        let mut fillets = None;
        if let Some(flank) = roots {
            let found =
                settings.root_models(pair, flank, &|stage, share| job.show(stage, share))?;
            fillets = Some(Fillets {
                effort: self.effort(found.seconds, &found.origins),
                maps: found.maps,
            });
        }
        Ok(Model {
            effort,
            fillets,
            description: models.description(),
            solver: models.solver,
            compliance: models.compliance,
        })
    }

    pub fn settings(&self) -> ModelSettings {
        ModelSettings {
            plane_strain: self.plane_strain,
            stations: self.stations,
            cache: self.cache.cache().filter(|_| !self.no_cache),
        }
    }

    /// What making models with these origins took; standard error has a note where the cache did not help.
    pub fn effort(&self, seconds: f64, origins: &[Origin; 2]) -> String {
        note_on_cache(origins);
        let folder = match self.settings().cache {
            Some(cache) => cache.directory.display().to_string(),
            None => String::new(),
        };
        let words = origins.each_ref().map(|origin| match origin {
            Origin::Loaded => format!("read from {folder}"),
            Origin::Stored | Origin::Replaced(_) => format!("computed and kept in {folder}"),
            Origin::Computed | Origin::NotStored(_) => "computed".to_owned(),
        });
        let words = match words {
            [first, second] if first == second => first,
            [first, second] => format!("gear 1 {first}, gear 2 {second}"),
        };
        format!("{seconds:.3} s, {words}")
    }

    /// `pair` with another refinement to estimate the error: the next finer one where it is cheap, else the next coarser one.
    pub fn reference(pair: &Pair) -> Pair {
        let mut pair = pair.clone();
        pair.refinement = match pair.refinement {
            Refinement::Normal => Refinement::Coarse,
            Refinement::Coarse | Refinement::Fine => Refinement::Normal,
        };
        pair
    }
}

/// Widens the operating range of `pair` to `torque` (N m), `misalignment` (rad) and the centre distance `offset` (m):
/// it decides how wide a contact the elastic model resolves and how far tip edges are followed.
pub fn widen(pair: &mut Pair, torque: f64, misalignment: [f64; 2], offset: [f64; 2]) {
    let o = &mut pair.operating;
    o.maximum_torque = o.maximum_torque.max(torque);
    for (range, [low, high]) in [
        (&mut o.misalignment, misalignment),
        (&mut o.center_distance_offset, offset),
    ] {
        *range = [range[0].min(low), range[1].max(high)];
    }
}

/// Notes on standard error where the cache did not help.
pub fn note_on_cache(origins: &[Origin; 2]) {
    // Equal gears share one model.
    let count = 2 - usize::from(origins[0] == origins[1]);
    for origin in &origins[..count] {
        let what = match origin {
            Origin::Replaced(why) => format!("computed anew: {why}"),
            Origin::NotStored(why) => format!("not kept: {why}"),
            Origin::Computed | Origin::Stored | Origin::Loaded => continue,
        };
        eprintln!("gearmesh: note: finite-element model {what}");
    }
}

/// The variable `name` of the environment, unless it is empty.
fn variable(name: &str) -> Option<OsString> {
    std::env::var_os(name).filter(|value| !value.is_empty())
}

/// Shafts on bearings.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Shafts")]
pub struct ShaftArgs {
    /// Whether the shafts of the pair file bend and twist on their bearings under the load [default: on]
    #[arg(long, value_parser = PossibleValuesParser::new(["on", "off"]).map(|switch| switch == "on"))]
    shafts: Option<bool>,
}

impl ShaftArgs {
    /// `pair` as its contact takes it: on its shafts, or without any.
    pub fn applied_to(&self, mut pair: Pair) -> Pair {
        if self.shafts == Some(false) {
            pair.shafts = [None, None];
        }
        held_by_its_shafts(&pair)
    }
}

/// Where elastic models are kept.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Cache of elastic models")]
pub struct CacheArgs {
    /// Folder that keeps elastic models [default: gearmesh in the user's cache folder]
    #[arg(long, env = "GEARMESH_CACHE_DIR", hide_env_values = true)]
    cache_dir: Option<PathBuf>,

    /// Largest size of that folder in megabytes; the least recently used models make room for new ones
    #[arg(long, env = "GEARMESH_CACHE_LIMIT_MB", hide_env_values = true, value_name = "MB", default_value_t = ModelCache::DEFAULT_LIMIT / 1_000_000)]
    cache_limit_mb: u64,
}

impl CacheArgs {
    /// The cache; None where the system names no folder for it.
    pub fn cache(&self) -> Option<ModelCache> {
        // The specification of this variable has a relative path ignored.
        let base = variable("XDG_CACHE_HOME").filter(|base| Path::new(base).is_absolute());
        let directory = (self.cache_dir.clone())
            .or_else(|| base.map(|base| Path::new(&base).join("gearmesh")))
            .or_else(|| variable("HOME").map(|home| Path::new(&home).join(".cache/gearmesh")))
            .or_else(|| variable("LOCALAPPDATA").map(|base| Path::new(&base).join("gearmesh")))?;
        let limit = self.cache_limit_mb.saturating_mul(1_000_000);
        Some(ModelCache::new(directory, limit))
    }
}
