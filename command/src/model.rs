//! The options that choose how teeth are modelled, shared by the subcommands that solve contact.

use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gearmesh::compliance::ToothCompliance;
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::finite_element::{
    ModelCache, Origin, PairCompliance, RootStress, Settings, Stage, pair_root_stress,
};

use crate::Error;
use crate::cache::CacheArgs;
use crate::limits;
use crate::progress::Job;

/// How teeth are modelled.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Fineness of the finite elements: coarse is quickest, fine for convergence studies [default: as the pair file says, normal]
    #[arg(long, value_parser = PossibleValuesParser::new(["coarse", "normal", "fine"]).try_map(|name| serde_json::from_value::<Refinement>(name.into())))]
    refinement: Option<Refinement>,

    /// Whether tip corners may touch outside the path of contact [default: as the pair file says, on]
    #[arg(long, value_parser = PossibleValuesParser::new(["on", "off"]).map(|switch| switch == "on"))]
    tip_corner_contact: Option<bool>,

    /// Hold the axial displacement: every slice by itself, as in a two-dimensional calculation
    #[arg(long)]
    pub plane_strain: bool,

    /// Stress in the tooth roots of both gears, too, in tables for the outputs of an FMU's `rootStress`; its elastic model
    /// takes two to three times as long as that of the contact
    #[arg(long, conflicts_with = "plane_strain")]
    pub root_stress: bool,

    /// Stations along the face [default: 40, for contact at run time 22, fewer where one would be shorter than the widest contact]
    #[arg(long, value_parser = limits::within(1..=MOST_STATIONS))]
    stations: Option<usize>,

    /// Compute finite-element models anew and keep none, wherever GEARMESH_CACHE_DIR or --cache-dir would keep them
    #[arg(long)]
    no_cache: bool,

    /// Threads to use, at most 1024 [default: one per core]
    #[arg(long, value_parser = limits::within(1..=MOST_THREADS))]
    threads: Option<usize>,

    /// No progress on standard error
    #[arg(short, long)]
    quiet: bool,

    #[command(flatten)]
    cache: CacheArgs,
}

/// Most stations along the face; the influence matrix of more would not fit into memory.
const MOST_STATIONS: usize = 1000;

/// As many cores have the largest machines; each thread takes memory and time to start.
const MOST_THREADS: usize = 1024;

/// A contact solver and what it took to make it.
pub struct Model {
    pub solver: ContactSolver,
    pub description: String,
    /// Seconds, and where the elastic models of both gears came from and are kept.
    pub effort: String,
    pub compliance: Compliance,
    /// Of the loaded flank, where the stress in the roots is requested.
    pub fillets: Option<Fillets>,
}

/// The models of the fillets of both gears and what it took to make them.
pub struct Fillets {
    /// Maps from loads to the stress in the roots of gear 1 and gear 2.
    pub maps: [Arc<RootStress>; 2],
    pub effort: String,
}

pub type Compliance = [Arc<dyn ToothCompliance>; 2];

impl ModelArgs {
    /// The pair with the choices of the command line instead of those of the file.
    pub fn applied_to(&self, mut pair: Pair) -> Pair {
        pair.refinement = self.refinement.unwrap_or(pair.refinement);
        pair.tip_corner_contact = self.tip_corner_contact.unwrap_or(pair.tip_corner_contact);
        pair
    }

    /// Begins the work, on the chosen number of threads. Once per run.
    pub fn start(&self) -> Result<Job, Error> {
        if let Some(threads) = self.threads {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build_global()?;
        }
        Ok(Job::new(self.quiet))
    }

    /// The model of `pair`, to which the command line has been applied, as part of `job`; with the fillets for loads on the
    /// flank `roots`.
    pub fn model(&self, pair: &Pair, roots: Option<Flank>, job: &Job) -> Result<Model, Error> {
        let begin = Instant::now();
        let cache = self.cache_in_use();
        let progress = progress(job, "elastic model");
        let settings = self.settings(pair);
        let models = PairCompliance::new(&pair.geometry, &settings, cache.as_ref(), &progress)?;
        let effort = effort(begin, &models.origins, cache.as_ref());
        let [first, second] = models.gears;
        let compliance: Compliance = [first, second];
        let fillets = roots.map(|flank| self.fillets(pair, flank, job));
        Ok(Model {
            solver: ContactSolver::new(pair, compliance.clone(), self.contact_settings(pair))?,
            description: self.description(pair),
            effort,
            compliance,
            fillets: fillets.transpose()?,
        })
    }

    /// The models of the fillets of `pair` loaded on `flank`, as part of `job`.
    pub fn fillets(&self, pair: &Pair, flank: Flank, job: &Job) -> Result<Fillets, Error> {
        let begin = Instant::now();
        let cache = self.cache_in_use();
        let progress = progress(job, "model of the fillets");
        let settings = self.settings(pair);
        let models = pair_root_stress(&pair.geometry, flank, &settings, cache.as_ref(), &progress)?;
        let [(first, a), (second, b)] = models;
        Ok(Fillets {
            maps: [first, second],
            effort: effort(begin, &[a, b], cache.as_ref()),
        })
    }

    /// How the contact of `pair` is discretised.
    pub fn contact_settings(&self, pair: &Pair) -> ContactSettings {
        let settings = ContactSettings::for_pair(pair);
        ContactSettings {
            stations: self.stations.unwrap_or(settings.stations),
            ..settings
        }
    }

    /// The solver whose contact an FMU solves at run time: on fewer stations than `solver`, but for a number that was requested.
    pub fn at_run_time(&self, solver: ContactSolver) -> ContactSolver {
        match self.stations {
            Some(_) => solver,
            None => solver.at_run_time(),
        }
    }

    /// Whether the elastic models of `pair` need not be computed.
    pub fn are_kept(&self, pair: &Pair) -> Result<bool, Error> {
        let Some(cache) = self.cache_in_use() else {
            return Ok(false);
        };
        let settings = self.settings(pair);
        Ok(PairCompliance::is_kept(&pair.geometry, &settings, &cache)?)
    }

    fn settings(&self, pair: &Pair) -> Settings {
        Settings {
            plane_strain: self.plane_strain,
            ..Settings::for_pair(pair)
        }
    }

    fn cache_in_use(&self) -> Option<ModelCache> {
        self.cache.cache().filter(|_| !self.no_cache)
    }

    /// The pair with the refinement whose difference to that of `pair` gives the error: the next finer one
    /// where it is cheap, else the next coarser one.
    pub fn reference(pair: &Pair) -> Pair {
        let refinement = match pair.refinement {
            Refinement::Normal => Refinement::Coarse,
            Refinement::Coarse | Refinement::Fine => Refinement::Normal,
        };
        Pair {
            refinement,
            ..pair.clone()
        }
    }

    fn description(&self, pair: &Pair) -> String {
        let mut words = format!("finite elements, {:?}", pair.refinement).to_lowercase();
        if self.plane_strain {
            words.push_str(", plane strain");
        }
        if !pair.tip_corner_contact {
            words.push_str(", contact on the path only");
        }
        words
    }
}

/// Widens the operating range of `pair` to `torque` (N m) and the ranges of `misalignment` (rad) and `center_distance_offset` (m):
/// it decides how wide a contact the elastic model resolves and how far tip corners are followed.
pub fn widen(
    pair: &mut Pair,
    torque: f64,
    misalignment: [f64; 2],
    center_distance_offset: [f64; 2],
) {
    let wider = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let o = &mut pair.operating;
    o.maximum_torque = o.maximum_torque.max(torque);
    o.misalignment = wider(o.misalignment, misalignment);
    o.center_distance_offset = wider(o.center_distance_offset, center_distance_offset);
}

/// Shows in `job` how far the models are that `model` names.
fn progress(job: &Job, model: &str) -> impl Fn(usize, Stage, f64) -> bool {
    move |gear, stage, share| {
        let words = match stage {
            Stage::Assembly => "stiffness of one tooth with its share of the body",
            Stage::Condensation => "reducing it to its loaded flank",
            Stage::Ring => "joining all teeth to the whole gear",
        };
        job.show(&format!("{model} of gear {}: {words}", gear + 1), share);
        true
    }
}

/// What making models with these origins took, begun at `begin`. Says on standard error where the cache did not help: a
/// result is right without it, but it should not be slow in silence.
fn effort(begin: Instant, origins: &[Origin; 2], cache: Option<&ModelCache>) -> String {
    // Equal gears share one model.
    let models = if origins[0] == origins[1] { 1 } else { 2 };
    for origin in &origins[..models] {
        let what = match origin {
            Origin::Replaced(why) => format!("computed anew: {why}"),
            Origin::NotStored(why) => format!("not kept: {why}"),
            Origin::Computed | Origin::Stored | Origin::Loaded => continue,
        };
        eprintln!("gearmesh: note: finite-element model {what}");
    }
    let folder = cache.map_or(String::new(), |c| c.directory().display().to_string());
    let words = origins.each_ref().map(|origin| match origin {
        Origin::Loaded => format!("read from {folder}"),
        Origin::Stored | Origin::Replaced(_) => format!("computed and kept in {folder}"),
        Origin::Computed | Origin::NotStored(_) => "computed".to_owned(),
    });
    let words = match words {
        [first, second] if first == second => first,
        [first, second] => format!("gear 1 {first}, gear 2 {second}"),
    };
    format!("{:.3} s, {words}", begin.elapsed().as_secs_f64())
}
