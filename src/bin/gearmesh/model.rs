//! The options that choose how teeth are modelled, shared by the subcommands that solve contact.

use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};
use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::finite_element::{
    Estimate, FiniteElementCompliance, ModelCache, Origin, PairCompliance, RootStress, Settings,
    Stage, pair_root_stress,
};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};

use crate::Error;
use crate::cache::CacheArgs;
use crate::limits;
use crate::progress::{Job, Plan, Progress};

/// `on` or `off`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Yes
    On,
    /// No
    Off,
}

/// Fineness of the finite-element model on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Level {
    /// Quickest
    Coarse,
    /// The default
    Normal,
    /// For convergence studies
    Fine,
}

/// How teeth are modelled.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Fineness of the finite elements [default: as the pair file says, normal]
    #[arg(long, value_enum)]
    refinement: Option<Level>,

    /// Whether tip corners may touch outside the path of contact [default: as the pair file says, on]
    #[arg(long, value_enum)]
    tip_corner_contact: Option<Switch>,

    /// Hold the axial displacement: every slice by itself, as in a two-dimensional calculation
    #[arg(long)]
    plane_strain: bool,

    /// Stations along the face [default: 40, for contact at run time 22, fewer where one would be shorter than the widest contact]
    #[arg(long)]
    stations: Option<usize>,

    /// Compute finite-element models anew and keep none, wherever GEARMESH_CACHE_DIR or --cache-dir would keep them
    #[arg(long)]
    no_cache: bool,

    /// Threads to use, at most 1024 [default: one per core]
    #[arg(long)]
    threads: Option<usize>,

    /// No progress on standard error
    #[arg(short, long)]
    quiet: bool,

    #[command(flatten)]
    cache: CacheArgs,
}

/// A contact solver and what it took to make it.
pub struct Model {
    /// The solver.
    pub solver: ContactSolver,
    /// Seconds for the elastic models of both gears.
    pub compliance_seconds: f64,
    /// The elastic model in words.
    pub description: String,
    /// Where the elastic model came from and is kept, in words.
    pub origin: String,
    /// The elastic models of gear 1 and gear 2.
    pub compliance: Compliance,
    /// What computing them took, s, even if that was in another run.
    pub computing_seconds: f64,
}

/// The models of the fillets of both gears and what it took to make them.
pub struct Fillets {
    /// Maps from loads to the stress in the roots of gear 1 and gear 2.
    pub maps: [Arc<RootStress>; 2],
    /// Seconds for both.
    pub seconds: f64,
    /// Where they came from and are kept, in words.
    pub origin: String,
}

/// Time of the models of the fillets over that of the elastic models.
pub const FILLETS: f64 = 2.5;

/// Elastic models of gear 1 and gear 2.
pub type Compliance = [Arc<dyn ToothCompliance>; 2];

type Models = [Arc<FiniteElementCompliance>; 2];

impl ModelArgs {
    /// The pair with the choices of the command line in place of those of the file.
    pub fn applied_to(&self, mut pair: Pair) -> Pair {
        if let Some(level) = self.refinement {
            pair.refinement = match level {
                Level::Coarse => Refinement::Coarse,
                Level::Normal => Refinement::Normal,
                Level::Fine => Refinement::Fine,
            };
        }
        if let Some(switch) = self.tip_corner_contact {
            pair.tip_corner_contact = switch == Switch::On;
        }
        pair
    }

    /// How much is said on standard error.
    pub fn progress(&self) -> Progress {
        Progress::new(self.quiet)
    }

    /// Sets the number of threads. Once per run.
    pub fn use_threads(&self) -> Result<(), Error> {
        if let Some(threads) = self.threads {
            limits::threads(threads)?;
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()?;
        }
        Ok(())
    }

    /// Whether nothing is to be said of progress.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Whether every slice stands by itself.
    pub fn is_plane_strain(&self) -> bool {
        self.plane_strain
    }

    /// The solver for `pair`, to which the command line has been applied, as the first phases of `job`.
    pub fn solver(&self, pair: &Pair, job: &Job) -> Result<Model, Error> {
        self.stations.map_or(Ok(()), limits::stations)?;
        let begin = Instant::now();
        let (models, origin) = self.finite_element(pair, job)?;
        let compliance_seconds = begin.elapsed().as_secs_f64();
        let seconds = |i: usize| models[i].cost().seconds.iter().sum::<f64>();
        let computing_seconds = match Arc::ptr_eq(&models[0], &models[1]) {
            true => seconds(0),
            false => seconds(0) + seconds(1),
        };
        let [first, second] = models;
        let compliance: Compliance = [first, second];
        Ok(Model {
            solver: ContactSolver::new(pair, compliance.clone(), self.contact_settings(pair))?,
            compliance_seconds,
            description: self.description(pair),
            origin,
            compliance,
            computing_seconds,
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

    /// The solver whose contact a unit solves at run time: on fewer stations than `solver`, but for a number that was asked for.
    pub fn at_run_time(&self, solver: ContactSolver) -> ContactSolver {
        match self.stations {
            Some(_) => solver,
            None => solver.at_run_time(),
        }
    }

    /// What the elastic models of `pair` will take.
    pub fn estimates(&self, pair: &Pair) -> Result<[Estimate; 2], Error> {
        let cache = self.kept();
        let settings = self.settings(pair);
        Ok(PairCompliance::estimate(
            &pair.geometry,
            &settings,
            cache.as_ref(),
        )?)
    }

    /// The plan of a command that solves the contact of `pair`; `contact` says what is solved.
    pub fn plan(&self, pair: &Pair, contact: &str) -> Result<Plan, Error> {
        let elastic = self.estimates(pair)?.map(|e| e.total_seconds());
        // How long the contact takes is not known here: as long as the models.
        let likely = (elastic[0] + elastic[1]).max(1.0);
        Ok(Plan::new(elastic, (contact, likely)))
    }

    /// What the models of the fillets of `pair` will take, s, unless they are kept, which is not known here.
    pub fn fillet_seconds(&self, pair: &Pair) -> Result<[f64; 2], Error> {
        let seconds = |e: Estimate| FILLETS * e.seconds.iter().sum::<f64>();
        Ok(self.estimates(pair)?.map(seconds))
    }

    fn settings(&self, pair: &Pair) -> Settings {
        Settings {
            plane_strain: self.plane_strain,
            ..Settings::for_pair(pair)
        }
    }

    /// The models of the fillets of `pair` loaded on `flank`, as phases of `job`, whose plan has them.
    pub fn fillets(&self, pair: &Pair, flank: Flank, job: &Job) -> Result<Fillets, Error> {
        let settings = self.settings(pair);
        let cache = self.kept();
        let told = |gear, stage, share| {
            let (done, words) = so_far(stage, share);
            job.fillets(gear, done, words);
            true
        };
        let begin = Instant::now();
        let found = pair_root_stress(&pair.geometry, flank, &settings, cache.as_ref(), &told)?;
        let seconds = begin.elapsed().as_secs_f64();
        let [(first, a), (second, b)] = found;
        let origins = [a, b];
        note([&origins[0], &origins[1]]);
        Ok(Fillets {
            maps: [first, second],
            seconds,
            origin: origin_in_words(&origins, cache.as_ref()),
        })
    }

    fn kept(&self) -> Option<ModelCache> {
        self.cache.cache().filter(|_| !self.no_cache)
    }

    /// The pair with the refinement whose difference to that of `pair` tells the error: the next finer one
    /// where it is cheap, else the next coarser one.
    pub fn reference(pair: &Pair) -> Pair {
        let mut other = pair.clone();
        other.refinement = match pair.refinement {
            Refinement::Normal => Refinement::Coarse,
            Refinement::Coarse | Refinement::Fine => Refinement::Normal,
        };
        other
    }

    fn description(&self, pair: &Pair) -> String {
        let mut words = format!(
            "finite elements, {}",
            match pair.refinement {
                Refinement::Coarse => "coarse",
                Refinement::Normal => "normal",
                Refinement::Fine => "fine",
            }
        );
        if self.plane_strain {
            words.push_str(", plane strain");
        }
        if !pair.tip_corner_contact {
            words.push_str(", contact on the path only");
        }
        words
    }

    fn finite_element(&self, pair: &Pair, job: &Job) -> Result<(Models, String), Error> {
        let settings = self.settings(pair);
        let cache = self.kept();
        let told = |gear, stage, share| {
            let (done, words) = so_far(stage, share);
            job.elastic(gear, done, words);
            true
        };
        let models = PairCompliance::new(&pair.geometry, &settings, cache.as_ref(), &told)?;
        note([&models.origins[0], &models.origins[1]]);
        let origin = origin_in_words(&models.origins, cache.as_ref());
        Ok((models.gears, origin))
    }
}

/// How far the model of a gear is with `share` of `stage` done, and what is being done.
fn so_far(stage: Stage, share: f64) -> (f64, &'static str) {
    // Shares of the time of a model that is wide enough to be waited for.
    let (before, part, words) = match stage {
        Stage::Assembly => (
            0.0,
            0.05,
            "stiffness of one tooth with its share of the body",
        ),
        Stage::Condensation => (0.05, 0.6, "reducing it to its loaded flank"),
        Stage::Ring => (0.65, 0.35, "joining all teeth to the whole gear"),
    };
    (before + part * share, words)
}

/// Says where the cache did not help: a result is right without it, but it should not be slow in silence. Equal gears
/// share one model.
fn note([first, second]: [&Origin; 2]) {
    for origin in std::iter::once(first).chain((second != first).then_some(second)) {
        match origin {
            Origin::Replaced(reason) => {
                eprintln!("gearmesh: note: finite-element model computed anew: {reason}");
            }
            Origin::NotStored(reason) => {
                eprintln!("gearmesh: note: finite-element model not kept: {reason}");
            }
            Origin::Computed | Origin::Stored | Origin::Loaded => {}
        }
    }
}

/// Where the models of both gears came from and are kept.
fn origin_in_words(origins: &[Origin; 2], cache: Option<&ModelCache>) -> String {
    let [first, second] = origins.each_ref().map(|origin| {
        let of = match origin {
            Origin::Loaded => "read from",
            Origin::Stored | Origin::Replaced(_) => "computed and kept in",
            Origin::Computed | Origin::NotStored(_) => return "computed".to_owned(),
        };
        let folder = cache.map(|cache| cache.directory().display());
        format!("{of} {}", folder.map_or(String::new(), |d| d.to_string()))
    });
    if first == second {
        first
    } else {
        format!("gear 1 {first}, gear 2 {second}")
    }
}
