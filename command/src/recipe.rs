//! The tables of a pair file as `gearmesh tables` and `gearmesh build` compute them, and what they print of it.

use std::path::Path;

use clap::Args;
use gearmesh::accuracy::LOW_LOADS;
use gearmesh::contact::MAXIMUM_ITERATIONS;
use gearmesh::table::InterpolationError;
use gearmesh_preprocessor::contact::ElasticModels;
use gearmesh_preprocessor::table::{Made, Recipe};
use gearmesh_preprocessor::{pair, table};

use crate::columns::{Listing, rows};
use crate::error::Result;
use crate::model::{ModelArgs, note_on_cache};
use crate::output;
use crate::pair_summary::at_build;

/// Error of the force, percent rms of the nominal one or, under low loads, of that which acts, from which on tooth pairs one by one are
/// warned of.
const LARGE_ERROR: f64 = 3.0;
/// The same of the moment, % of the nominal force at an end of the face.
const LARGE_MOMENT_ERROR: f64 = 6.0;

/// Which dimensions a table has and how fine it is.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Grid")]
pub struct GridArgs {
    /// Choose the nodes for a force error, rms over the nominal force, below this [default: a fixed grid, whose error is measured]
    #[arg(long, value_parser = share)]
    max_error: Option<f64>,

    /// Nominal centre distance only
    #[arg(long)]
    no_center_distance: bool,

    /// Parallel axes only
    #[arg(long)]
    no_misalignment: bool,

    /// Mean bodies only, for bodies that are no solids of revolution
    #[arg(long)]
    no_body: bool,

    /// Also how the load slides, for the effect `friction` of the FMU
    #[arg(long)]
    pub friction: bool,

    /// Also tooth pairs one by one, for stiffnessModel = teeth of the FMU, which takes index errors and run-out
    #[arg(long)]
    pub teeth: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if 0.0 < share && share < 1.0 => Ok(share),
        _ => Err("give a share of the nominal force between 0 and 1, such as 0.002".into()),
    }
}

/// Tables with what is packed and said of them.
pub struct Computed {
    pub made: Made,
    pub text: String,
}

/// The tables of the pair file `path`, on their way to `output`, with `contact` what contact at run time needs.
pub fn compute(
    path: &Path,
    output: &Path,
    grid: &GridArgs,
    contact: bool,
    args: &ModelArgs,
) -> Result<Computed> {
    let recipe = Recipe {
        center_distance: !grid.no_center_distance,
        misalignment: !grid.no_misalignment,
        max_error: grid.max_error,
        friction: grid.friction,
        root_stress: args.root_stress,
        teeth: grid.teeth,
        contact,
        body: !grid.no_body,
    };
    let pair = args.applied_to(pair::read(path)?);
    let settings = args.settings();
    recipe.check(&pair, &settings)?;
    output::check_writable(output, [path])?;
    let job = args.start()?;
    let progress = &|stage: &str, share| job.show(stage, share);
    let models = ElasticModels::new(&pair, &settings, progress)?;
    let effort = args.effort(models.seconds, &models.origins);
    let made = recipe.compute(&models, progress)?;
    made.account.root_origins.iter().for_each(note_on_cache);
    let rows = in_words(&made, &models, &effort);
    let text = format!(
        "{}\n  {}",
        table::size_and_error(&made.file),
        rows.joined("\n  ", ": ")
    );
    Ok(Computed { made, text })
}

/// What was computed for `made`, how long it took, and what is to be known of the pair.
fn in_words(made: &Made, models: &ElasticModels, effort: &str) -> Listing {
    let (pair, account) = (&models.pair, &made.account);
    let quality = account.quality;
    let mut rows = Listing::default();
    rows! { rows;
        "elastic model" => "{}, {effort}", models.description();
        "static contact" => "{:.1} s, {} contact solves, Newton steps {} at most of {MAXIMUM_ITERATIONS} allowed, residual of the \
             contact conditions {:.1e} at most", account.contact_seconds, quality.solves, quality.most_iterations, quality.kkt_residual;
    }
    if let Some(number) = account.more_center_distances {
        rows! { rows;
            "centre distances" => "{number}, as the spline through fewer of them falls between them: teeth deflect little beside \
                 the range of centre distances";
        }
    }
    at_build(pair, &mut rows);
    if let (Some(record), Some(seconds)) = (&made.file.root_stress, account.root_stress_seconds) {
        rows! { rows; "root stress" => "{seconds:.1} s, {}", record.interpolation_error; }
    }
    if let (Some(record), Some(seconds)) = (&made.file.teeth, account.teeth_seconds) {
        let [percent, moment] =
            [record.error.force_rms, record.error.moment_rms].map(|x| 100.0 * x);
        let low_load = record.error.low_load_force.map(|[rms, _]| 100.0 * rms);
        rows! { rows; "tooth pairs one by one" => "{seconds:.1} s, {}", table::teeth_in_words(record); }
        if percent.max(low_load.unwrap_or(0.0)) > LARGE_ERROR || moment > LARGE_MOMENT_ERROR {
            let [least, most] = LOW_LOADS;
            let low_load = low_load.map_or_else(String::new, |error| {
                format!(", and at {least} to {most} of it by {error:.1} % of the force that acts")
            });
            rows! { rows;
                "warning" => "tooth pairs one by one are off by {percent:.1} % rms of the nominal force{low_load}, and by {moment:.1} % in its moment over the face; for this pair build with \
                     --contact and set stiffnessModel = contact";
            }
        }
    }
    if let Some(contact) = &made.contact {
        rows.row(
            "contact at run time",
            run_time_error(contact.error.as_ref()),
        );
    }
    if let Some(note) = pair::note_on_teeth(&pair.teeth) {
        let table = "`stiffnessModel = table` takes all teeth as alike";
        let teeth_first = "FMUs start with `stiffnessModel = teeth`, which takes the tooth errors";
        match (made.file.teeth.is_some(), made.contact.is_some()) {
            (true, true) => rows! { rows; "note" => "{teeth_first}, as `contact` does; {table}"; },
            (true, false) => rows! { rows; "note" => "{teeth_first}; {table}"; },
            (false, true) => {
                rows! { rows; "note" => "{table}; `stiffnessModel = contact` takes the tooth errors"; }
            }
            (false, false) => rows.row("note", note),
        }
    }
    rows
}

/// How far contact at run time is from static contact, in words.
pub fn run_time_error(error: Option<&InterpolationError>) -> String {
    error.map_or("not measured; build the FMU again".into(), |error| {
        format!("{error}; against static contact on more stations, all teeth alike")
    })
}
