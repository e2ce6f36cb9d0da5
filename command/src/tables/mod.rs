//! `gearmesh tables PAIR.json -o TABLES.json`: the static contact of a pair over its operating range.

mod records;
mod words;

use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::pair;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use gearmesh::contact::ContactFile;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::{TableFile, TeethRecord};
use gearmesh_preprocessor::table::plan::{Coverage, default_axes, tilt};
use gearmesh_preprocessor::table::source::WatchedSolver;
use gearmesh_preprocessor::table::sweep::Watch;

use crate::Error;
use crate::model::ModelArgs;
use crate::output;
use crate::pair_summary::at_build;
use crate::preflight::{corners, preflight};
use records::{at_run_time, default_grid, drive_flank, root_stress, sliding, teeth, within};
use words::settings;

/// Random operating points at which the default grid is measured.
const HELD_OUT_POINTS: usize = 1000;

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
    /// Choose the nodes so that the force error between them, root of the mean square over the nominal
    /// force, stays below this [default: a fixed grid, whose error is measured]
    #[arg(long)]
    max_error: Option<f64>,

    /// Nominal centre distance only
    #[arg(long)]
    no_center_distance: bool,

    /// Parallel axes only
    #[arg(long)]
    no_misalignment: bool,

    /// Also how the load slides, for the effect `friction` of the unit
    #[arg(long)]
    pub friction: bool,

    /// Also the stress in the tooth roots, for the outputs of the unit's `rootStress`; its elastic model takes two to
    /// three times as long as that of the contact
    #[arg(long, conflicts_with = "plane_strain")]
    pub root_stress: bool,

    /// Also tooth pairs one by one, for stiffnessModel = teeth of the unit, which takes index errors and run-out
    #[arg(long)]
    pub teeth: bool,
}

impl Tables {
    /// Computes, writes and says what was made.
    pub fn run(self) -> Result<(), Error> {
        let made = compute(&self.pair, &self.output, &self.grid, false, &self.model)?;
        output::write_whole(&self.output, made.file.to_json().as_bytes())?;
        output::print(&format!("Wrote {}: {made}\n", self.output.display()))?;
        Ok(())
    }
}

/// Tables that were just computed.
pub struct Made {
    /// The tables.
    pub file: TableFile,
    /// The contact at run time, if it was wanted.
    pub contact: Option<ContactFile>,
    /// The elastic model, and the time it took.
    elastic_model: String,
    /// Wall-clock time of the static contact, s.
    contact_seconds: f64,
    /// Likewise of the stress in the tooth roots, its elastic model included.
    root_stress_seconds: f64,
    /// Likewise of tooth pairs one by one.
    teeth_seconds: f64,
    /// What is to be known of the pair, one line each: its teeth against the drawing, and its notes.
    about_pair: Vec<String>,
    /// What is to be known where the teeth of the pair differ, which tables do not hold.
    note_on_teeth: Option<&'static str>,
}

/// The tables of the pair file `path`, on their way to `output`, and with `contact` what its contact at run time needs.
pub fn compute(
    path: &Path,
    output: &Path,
    grid: &GridArgs,
    contact: bool,
    args: &ModelArgs,
) -> Result<Made, Error> {
    if let Some(error) = grid.max_error
        && !(error > 0.0 && error < 1.0)
    {
        return Err(format!("--max-error = {error}: give a share of the nominal force between 0 and 1, such as 0.002").into());
    }
    // `--set rootStress=true` asks for it, too, and is no option that conflicts with another.
    if grid.root_stress && args.is_plane_strain() {
        return Err("--plane-strain has no stress in the tooth roots; leave out `rootStress` or --plane-strain".into());
    }
    let pair = args.applied_to(pair::read(path)?);
    if grid.teeth {
        TeethRecord::takes(&pair.teeth)?;
    }
    crate::output::check_writable(output, &[path])?;
    args.use_threads()?;
    let coverage = coverage(&pair, [!grid.no_center_distance, !grid.no_misalignment]);
    let likely = likely_solves(&pair, &coverage, grid);
    let job = args.job();
    preflight(&pair, args, &coverage, &job)?;
    let model = args.solver(&pair, &job)?;
    corners(&model.solver, &pair, &coverage)?;
    let begin = Instant::now();

    let cancel = AtomicBool::new(false);
    // Several grids may be solved one after the other.
    let before = AtomicUsize::new(0);
    let told = |done: usize, total: usize| {
        let all = before.load(Ordering::Relaxed) + done;
        if done == total {
            before.fetch_add(total, Ordering::Relaxed);
        }
        let likely = likely.max(all);
        let share = all as f64 / likely as f64;
        job.tell(
            "static contact",
            share,
            &format!("{all} of about {likely} solves"),
        );
    };
    let watch = Watch {
        progress: &told,
        cancel: &cancel,
    };
    let source = WatchedSolver::new(&model.solver);
    // Solves that no table holds are not counted with it.
    let tilt = match coverage.misalignment {
        Some(_) => tilt(&model.solver, &pair.geometry, &coverage)?,
        None => f64::INFINITY,
    };
    let (drive, mut error) = drive_flank(&source, &pair, &coverage, tilt, grid.max_error, &watch)?;
    let coast = if pair.coast_mirrors_drive() {
        None
    } else {
        let (coast, found) = default_grid(&source, &pair, Flank::Coast, &coverage, tilt, &watch)?;
        error = error.with(found);
        within(grid.max_error, &error)?;
        Some(coast)
    };
    let friction = if grid.friction {
        let own_coast = coast.is_some();
        Some(sliding(&pair, &model, &coverage, own_coast, &watch)?)
    } else {
        None
    };
    drop(job);
    let contact_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let root_stress = if grid.root_stress {
        let own_coast = coast.is_some();
        Some(root_stress(&pair, &model, &coverage, args, own_coast)?)
    } else {
        None
    };
    let root_stress_seconds = begin.elapsed().as_secs_f64();
    let wants_contact = contact;
    let mut contact = if contact || grid.teeth {
        let solver = args.at_run_time(model.solver.clone());
        Some(contact_file(&pair, &solver)?)
    } else {
        None
    };
    if wants_contact && let Some(contact) = &mut contact {
        contact.error = Some(at_run_time(&pair, &model, contact, args)?);
    }
    let begin = Instant::now();
    let teeth = match &contact {
        Some(contact) if grid.teeth => Some(teeth(&pair, &model, &coverage, tilt, contact, args)?),
        _ => None,
    };
    let teeth_seconds = begin.elapsed().as_secs_f64();

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
    file.solver = settings(&pair, &model, args, source.quality());
    file.seal();
    Ok(Made {
        file,
        contact: contact.filter(|_| wants_contact),
        elastic_model: format!(
            "{}, {:.1} s, {}",
            model.description, model.compliance_seconds, model.origin
        ),
        about_pair: at_build(&pair),
        note_on_teeth: pair::note_on_teeth(&pair.teeth),
        contact_seconds,
        root_stress_seconds,
        teeth_seconds,
    })
}

/// How many solves are likely: the default grid with the points it is measured at, and three times as many where the grid is
/// sought.
fn likely_solves(pair: &Pair, coverage: &Coverage, grid: &GridArgs) -> usize {
    let [nc, nm, nu, np] = default_axes(coverage).lengths();
    let flanks = if pair.coast_mirrors_drive() { 1 } else { 2 };
    let grids = if grid.max_error.is_some() { 3 } else { 1 };
    flanks * (grids * nc * nm * (nu + 1) * np + HELD_OUT_POINTS)
}

/// The ranges of the pair file, those of centre distance and misalignment where they are `wanted`.
fn coverage(pair: &Pair, wanted: [bool; 2]) -> Coverage {
    let of = |wanted: bool, range: [f64; 2]| (wanted && range[0] < range[1]).then_some(range);
    let operating = &pair.operating;
    Coverage {
        center_distance_offset: of(wanted[0], operating.center_distance_offset),
        misalignment: of(wanted[1], operating.misalignment),
        nominal_torque: operating.nominal_torque,
        maximum_torque: operating.maximum_torque,
    }
}
