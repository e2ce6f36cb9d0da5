//! The options that choose how teeth are modelled, shared by the subcommands that solve contact.

use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};
use gearmesh::compliance::ToothCompliance;
use gearmesh::compliance::analytical::{AnalyticalCompliance, AxialState};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::pair::Pair;

use crate::Error;

/// `on` or `off`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Yes.
    On,
    /// No.
    Off,
}

/// Elastic model of the teeth on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Closed form: milliseconds.
    Analytical,
}

/// How teeth are modelled.
#[derive(Debug, Args)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Elastic model of teeth and blanks
    #[arg(long, value_enum)]
    compliance: Method,

    /// Whether tip corners may touch outside the path of contact [default: as the pair file says]
    #[arg(long, value_enum)]
    tip_corner_contact: Option<Switch>,

    /// Hold the axial displacement: every slice by itself, as in a two-dimensional calculation
    #[arg(long)]
    plane_strain: bool,

    /// Stations along the face
    #[arg(long, default_value_t = ContactSettings::default().stations)]
    stations: usize,

    /// Threads to use [default: one per core]
    #[arg(long)]
    threads: Option<usize>,
}

/// A contact solver and what it took to make it.
pub struct Model {
    /// The solver.
    pub solver: ContactSolver,
    /// Seconds for the elastic models.
    pub compliance_seconds: f64,
    /// The elastic model in words.
    pub description: String,
}

impl ModelArgs {
    /// The solver for `pair`.
    pub fn solver(&self, pair: &Pair) -> Result<Model, Error> {
        if let Some(threads) = self.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()?;
        }
        let begin = Instant::now();
        let axial = if self.plane_strain {
            AxialState::PlaneStrain
        } else {
            AxialState::Free
        };
        let model = |i: usize| -> Result<Arc<dyn ToothCompliance>, Error> {
            let gear = &pair.geometry.gears[i];
            Ok(match self.compliance {
                Method::Analytical => Arc::new(AnalyticalCompliance::new(gear, axial)?),
            })
        };
        let compliance = [model(0)?, model(1)?];
        let compliance_seconds = begin.elapsed().as_secs_f64();
        let settings = ContactSettings {
            stations: self.stations,
            tip_corner_contact: match self.tip_corner_contact {
                Some(switch) => switch == Switch::On,
                None => pair.tip_corner_contact,
            },
            ..ContactSettings::default()
        };
        Ok(Model {
            solver: ContactSolver::new(pair, compliance, settings)?,
            compliance_seconds,
            description: format!(
                "analytical{}",
                if self.plane_strain {
                    ", plane strain"
                } else {
                    ""
                }
            ),
        })
    }
}
