//! `gearmesh tables PAIR.json -o TABLES.json`: the static contact of a pair over its operating range; `gearmesh import
//! SAMPLES.csv --pair PAIR.json -o TABLES.json`: that of another contact program.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::contact::MAXIMUM_ITERATIONS;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::contact::ElasticModels;
use gearmesh_preprocessor::table::import::import_csv;
use gearmesh_preprocessor::table::{Made, Recipe};
use gearmesh_preprocessor::{pair, table};

use crate::columns::{Listing, rows};
use crate::error::Result;
use crate::inspect::run_time_error;
use crate::model::{ModelArgs, note_on_cache};
use crate::output;
use crate::pair_summary::at_build;

/// Error of the force, percent rms of the nominal one, from which on tooth pairs one by one are warned of.
const LARGE_ERROR: f64 = 3.0;

/// Compute the tables of a pair.
#[derive(Debug, Args)]
pub struct Tables {
    /// Pair file
    pair: PathBuf,

    /// Tables to write
    #[arg(short, long)]
    output: PathBuf,

    #[command(flatten)]
    grid: GridArgs,

    #[command(flatten)]
    model: ModelArgs,
}

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

impl Tables {
    pub fn run(self) -> Result<()> {
        let Computed { made, text } =
            compute(&self.pair, &self.output, &self.grid, false, &self.model)?;
        output::write_whole(&self.output, made.file.to_json().as_bytes())?;
        output::print(&format!("Wrote {}: {text}\n", self.output.display()))
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
    };
    let pair = args.applied_to(pair::read(path)?);
    let settings = args.settings();
    recipe.check(&pair, &settings)?;
    output::check_writable(output, [path])?;
    let job = args.start()?;
    let progress = &|stage: &str, share| job.show(stage, share);
    recipe.check_on_coarse_model(&pair, &settings, progress)?;
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
    at_build(pair, &mut rows);
    if let (Some(record), Some(seconds)) = (&made.file.root_stress, account.root_stress_seconds) {
        rows! { rows; "root stress" => "{seconds:.1} s, {}", record.interpolation_error; }
    }
    if let (Some(record), Some(seconds)) = (&made.file.teeth, account.teeth_seconds) {
        let percent = 100.0 * record.error.force_rms;
        rows! { rows; "tooth pairs one by one" => "{seconds:.1} s, {}", table::teeth_in_words(record); }
        if percent > LARGE_ERROR {
            rows! { rows;
                "warning" => "tooth pairs one by one carry {percent:.1} % rms of the nominal force more or less than they should; for \
                     this pair build with --contact and set stiffnessModel = contact";
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

/// Make tables of the samples of another contact program.
///
/// CSV with a header and the columns torque_nm, mesh_position, center_distance_offset_um,
/// misalignment_mrad, ste_loa_um, contact_z_mm; one row for every point of a full grid.
#[derive(Debug, Args)]
pub struct Import {
    /// Samples of the drive flank
    samples: PathBuf,

    /// Pair file that the samples belong to
    #[arg(long)]
    pair: PathBuf,

    /// Samples of the coast flank [default: the drive flank's, mirrored]
    #[arg(long)]
    coast: Option<PathBuf>,

    /// Tables to write
    #[arg(short, long)]
    output: PathBuf,
}

impl Import {
    pub fn run(self) -> Result<()> {
        let files = [&self.pair, &self.samples].into_iter().chain(&self.coast);
        output::check_writable(&self.output, files)?;
        let pair = pair::read(&self.pair)?;
        let nominal = pair.operating.nominal_torque;
        let read = |path: &PathBuf| -> Result<_> {
            let named = |error: String| format!("{}: {error}", path.display());
            let imported = import_csv(&output::read_text(path)?, &pair.geometry);
            let imported = imported.map_err(|error| named(error.to_string()))?;
            let doubt = imported.doubt(&pair.geometry, nominal);
            if let Some(doubt) = doubt.map_err(|error| named(error.to_string()))? {
                eprintln!("gearmesh: note: {}", named(doubt));
            }
            Ok(imported)
        };
        let drive = read(&self.samples)?;
        let coast = self.coast.as_ref().map(read).transpose()?;
        if coast.is_none() && !pair.coast_mirrors_drive() {
            refuse!(
                "{}: modifications or face offset make the flanks differ; give the samples of the coast flank with --coast",
                self.pair.display()
            );
        }
        let file = TableFile::new(
            &pair.name,
            &format!("samples in {}", self.samples.display()),
            &pair.geometry,
            [nominal, drive.maximum_torque],
            &drive.grid,
            coast.as_ref().map(|c| &c.grid),
        );
        file.check()?;
        output::write_whole(&self.output, file.to_json().as_bytes())?;
        let (path, words) = (self.output.display(), table::size_and_error(&file));
        output::print(&format!("Wrote {path}: {words}\n"))
    }
}
