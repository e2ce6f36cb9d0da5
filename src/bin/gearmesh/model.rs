//! The options that choose how teeth are modelled, shared by the subcommands that solve contact.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};
use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::finite_element::{Origin, PairCompliance, Settings};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::pair::{Pair, Refinement};

use crate::Error;
use crate::limits;
use crate::progress::Progress;

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

    /// Stations along the face [default: 40, fewer where a station would be shorter than the widest contact]
    #[arg(long)]
    stations: Option<usize>,

    /// Folder that keeps finite-element models; a change of microgeometry, loads or misalignments alone
    /// finds its model there [default: where tables or an FMU are written .gearmesh-compliance beside them, else
    /// gearmesh in the user's cache folder]
    #[arg(long)]
    cache_dir: Option<PathBuf>,

    /// Compute finite-element models anew and keep none
    #[arg(long, conflicts_with = "cache_dir")]
    no_cache: bool,

    /// Threads to use [default: one per core]
    #[arg(long)]
    threads: Option<usize>,

    /// No progress on standard error
    #[arg(short, long)]
    quiet: bool,
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
}

type Compliance = [Arc<dyn ToothCompliance>; 2];

/// Folder for finite-element models beside the tables or the FMU they serve.
const BESIDE: &str = ".gearmesh-compliance";

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
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()?;
        }
        Ok(())
    }

    /// Whether every slice stands by itself.
    pub fn is_plane_strain(&self) -> bool {
        self.plane_strain
    }

    /// The solver for `pair`, to which the command line has been applied. Its finite-element models are kept
    /// beside `output`, the tables or the FMU that is made of them, if there is one.
    pub fn solver(&self, pair: &Pair, output: Option<&Path>) -> Result<Model, Error> {
        let mut settings = ContactSettings::for_pair(pair);
        if let Some(stations) = self.stations {
            limits::stations(stations)?;
            settings.stations = stations;
        }
        let begin = Instant::now();
        let (compliance, origin) = self.finite_element(pair, output)?;
        let compliance_seconds = begin.elapsed().as_secs_f64();
        Ok(Model {
            solver: ContactSolver::new(pair, compliance, settings)?,
            compliance_seconds,
            description: self.description(pair),
            origin,
        })
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

    fn finite_element(
        &self,
        pair: &Pair,
        output: Option<&Path>,
    ) -> Result<(Compliance, String), Error> {
        let settings = Settings {
            plane_strain: self.plane_strain,
            ..Settings::for_pair(pair)
        };
        let cache = self.cache(output);
        let progress = self.progress();
        let bars = [1, 2].map(|gear| progress.share(&format!("finite elements of gear {gear}")));
        let told = |gear: usize, stage, share| {
            bars[gear].set(&format!("{stage:?}").to_lowercase(), share);
            true
        };
        let models = PairCompliance::new(&pair.geometry, &settings, cache.as_deref(), &told)?;
        drop(bars);
        // A result is right with or without the cache, but it should not be slow in silence. Equal gears share
        // one model.
        let [first, second] = &models.origins;
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
        let origin = origin_in_words(&models.origins, cache.as_deref());
        let [first, second] = models.gears;
        Ok(([first, second], origin))
    }

    /// Where finite-element models are kept: as the option says, else beside `output`, else in the user's
    /// cache.
    fn cache(&self, output: Option<&Path>) -> Option<PathBuf> {
        if self.no_cache {
            return None;
        }
        let beside = output.map(|file| file.with_file_name(BESIDE));
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        self.cache_dir
            .clone()
            .or(beside)
            .or_else(|| variable("XDG_CACHE_HOME").map(|base| Path::new(&base).join("gearmesh")))
            .or_else(|| variable("HOME").map(|home| Path::new(&home).join(".cache/gearmesh")))
            .or_else(|| variable("LOCALAPPDATA").map(|base| Path::new(&base).join("gearmesh")))
    }
}

/// Where the models of both gears came from and are kept.
fn origin_in_words(origins: &[Origin; 2], cache: Option<&Path>) -> String {
    let [first, second] = origins.each_ref().map(|origin| {
        let of = match origin {
            Origin::Loaded => "read from",
            Origin::Stored | Origin::Replaced(_) => "computed and kept in",
            Origin::Computed | Origin::NotStored(_) => return "computed".to_owned(),
        };
        let folder = cache.unwrap_or(Path::new(""));
        format!("{of} {}", folder.display())
    });
    if first == second {
        first
    } else {
        format!("gear 1 {first}, gear 2 {second}")
    }
}
