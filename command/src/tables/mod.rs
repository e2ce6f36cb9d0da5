//! `gearmesh tables PAIR.json -o TABLES.json`: the static contact of a pair over its operating range; `gearmesh import
//! SAMPLES.csv --pair PAIR.json -o TABLES.json`: that of another contact program.

mod sweeps;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use gearmesh::contact::{ContactFile, MAXIMUM_ITERATIONS};
use gearmesh::table::{TableFile, TeethRecord};
use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::import::import_csv;
use gearmesh_preprocessor::table::{WatchedSolver, tilt};
use serde_json::json;

use crate::columns::{Listing, rows};
use crate::error::Result;
use crate::inspect::run_time_error;
use crate::model::ModelArgs;
use crate::output;
use crate::pair_summary::{at_build, modifications};
use sweeps::{Sweeps, corners, coverage, preflight};

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
        let made = compute(&self.pair, &self.output, &self.grid, false, &self.model)?;
        output::write_whole(&self.output, made.file.to_json().as_bytes())?;
        output::print(&format!("Wrote {}: {}\n", self.output.display(), made.text))
    }
}

pub struct Made {
    pub file: TableFile,
    pub contact: Option<ContactFile>,
    pub text: String,
}

/// The tables of the pair file `path`, on their way to `output`, and with `contact` what its contact at run time needs.
pub fn compute(
    path: &Path,
    output: &Path,
    grid: &GridArgs,
    contact: bool,
    args: &ModelArgs,
) -> Result<Made> {
    if contact && args.root_stress && args.plane_strain {
        refuse!(
            "contact at run time has no stress in the tooth roots in plane strain; leave out `rootStress`, --plane-strain or --contact"
        );
    }
    let pair = args.applied_to(pair::read(path)?);
    if grid.teeth {
        TeethRecord::takes(&pair.teeth)?;
    }
    output::check_writable(output, [path])?;
    let coverage = coverage(&pair, [!grid.no_center_distance, !grid.no_misalignment]);
    let job = args.start()?;
    preflight(&pair, args, &coverage, &job)?;
    let model = args.model(&pair, None, &job)?;
    corners(&model.solver, &pair, &coverage)?;
    let mut rows = Listing::default();
    rows! { rows; "elastic model" => "{}, {}", model.description, model.effort; }

    let begin = Instant::now();
    // Solves that no table holds are not counted with it.
    let tilt = match coverage.misalignment {
        Some(_) => tilt(&model.solver, &pair.geometry, &coverage)?,
        None => f64::INFINITY,
    };
    let sweeps = Sweeps {
        pair: &pair,
        model: &model,
        coverage: &coverage,
        tilt,
        args,
        job: &job,
    };
    let source = WatchedSolver::new(&model.solver);
    let (drive, coast, error) = sweeps.flanks(&source, grid.max_error)?;
    let friction = grid.friction.then(|| sweeps.sliding()).transpose()?;
    let quality = source.quality();
    rows! { rows;
        "static contact" => "{}, {} contact solves, Newton steps {} at most of {MAXIMUM_ITERATIONS} allowed, residual of the contact \
             conditions {:.1e} at most", seconds_since(begin), quality.solves, quality.most_iterations, quality.kkt_residual;
    }
    at_build(&pair, &mut rows);

    let begin = Instant::now();
    let root_stress = args.root_stress.then(|| sweeps.root_stress()).transpose()?;
    if let Some(record) = &root_stress {
        rows! { rows; "root stress" => "{}, {}", seconds_since(begin), record.interpolation_error; }
    }
    let solver = args.at_run_time(&model.solver);
    let at_run_time = (contact || grid.teeth).then(|| contact_file(&pair, &solver));
    let mut at_run_time = at_run_time.transpose()?;
    if let Some(file) = at_run_time.as_mut().filter(|_| contact && args.root_stress) {
        sweeps.add_root_stress(file, &solver)?;
    }
    let begin = Instant::now();
    let teeth = at_run_time.as_ref().filter(|_| grid.teeth);
    let teeth = teeth.map(|contact| sweeps.teeth(contact, grid.friction));
    let teeth = teeth.transpose()?;
    if let Some(record) = &teeth {
        let percent = 100.0 * record.error.force_rms;
        rows! { rows; "tooth pairs one by one" => "{}, {}", seconds_since(begin), record.in_words(); }
        if percent > LARGE_ERROR {
            rows! { rows;
                "warning" => "tooth pairs one by one carry {percent:.1} % rms of the nominal force more or less than they should; for \
                     this pair build with --contact and set stiffnessModel = contact";
            }
        }
    }
    let mut contact = at_run_time.filter(|_| contact);
    if let Some(contact) = &mut contact {
        contact.error = Some(sweeps.error_at_run_time(contact)?);
        rows.row(
            "contact at run time",
            run_time_error(contact.error.as_ref()),
        );
    }
    if let Some(note) = pair::note_on_teeth(&pair.teeth) {
        let table = "`stiffnessModel = table` takes all teeth as alike";
        let teeth_first = "FMUs start with `stiffnessModel = teeth`, which takes the tooth errors";
        match (teeth.is_some(), contact.is_some()) {
            (true, true) => rows! { rows; "note" => "{teeth_first}, as `contact` does; {table}"; },
            (true, false) => rows! { rows; "note" => "{teeth_first}; {table}"; },
            (false, true) => {
                rows! { rows; "note" => "{table}; `stiffnessModel = contact` takes the tooth errors"; }
            }
            (false, false) => rows.row("note", note),
        }
    }

    let mut file = TableFile::new(
        &pair.name,
        "static tooth contact by gearmesh",
        &pair.geometry,
        [coverage.nominal_torque, coverage.maximum_torque],
        &drive,
        coast.as_ref(),
    );
    file.interpolation_error = Some(error);
    file.friction = friction;
    file.root_stress = root_stress;
    file.teeth = teeth;
    let modified = [0, 1].map(|i| {
        let mut rows = Listing::default();
        modifications(&pair, i, &mut rows);
        rows.joined("; ", " ")
    });
    file.solver = serde_json::from_value(json!({
        "elastic_model": model.description,
        "tip_corner_contact": pair.tip_corner_contact,
        "plane_strain": args.plane_strain,
        "stations_along_the_face": model.solver.settings().stations,
        "contact_solves": quality.solves,
        "most_newton_steps": quality.most_iterations,
        "newton_steps_allowed": MAXIMUM_ITERATIONS,
        "largest_kkt_residual": quality.kkt_residual,
        "modifications_of_gear_1": modified[0],
        "modifications_of_gear_2": modified[1],
    }))?;
    file.seal();
    let text = format!("{}\n  {}", file.size_and_error(), rows.joined("\n  ", ": "));
    Ok(Made {
        file,
        contact,
        text,
    })
}

fn seconds_since(begin: Instant) -> String {
    format!("{:.1} s", begin.elapsed().as_secs_f64())
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
        let (path, words) = (self.output.display(), file.size_and_error());
        output::print(&format!("Wrote {path}: {words}\n"))
    }
}
