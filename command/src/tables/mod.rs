//! `gearmesh tables PAIR.json -o TABLES.json`: the static contact of a pair over its operating range.

mod sweeps;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use gearmesh::contact::{ContactFile, MAXIMUM_ITERATIONS};
use gearmesh::pair::Pair;
use gearmesh::table::{TableFile, TeethRecord};
use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{Coverage, SolveQuality, WatchedSolver, tilt};
use serde_json::{Value, json};

use crate::Error;
use crate::flank_summary::modifications;
use crate::inspect::run_time_error;
use crate::model::{Model, ModelArgs};
use crate::output::{self, Listing};
use crate::pair_summary::at_build;
use sweeps::{Sweeps, corners, preflight};

/// Error of the force, rms over the nominal one, from which on tooth pairs one by one are warned of.
const LARGE_ERROR: f64 = 0.03;

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
    pub fn run(self) -> Result<(), Error> {
        let made = compute(&self.pair, &self.output, &self.grid, false, &self.model)?;
        output::write_whole(&self.output, made.file.to_json().as_bytes())?;
        output::print(&format!("Wrote {}: {}\n", self.output.display(), made.text))?;
        Ok(())
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
) -> Result<Made, Error> {
    // `--set rootStress=true` asks for it, too, and is no option that conflicts with another.
    if args.root_stress && args.plane_strain {
        refuse!(
            "--plane-strain has no stress in the tooth roots; leave out `rootStress` or --plane-strain"
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
    let (description, effort) = (&model.description, &model.effort);
    let mut lines = vec![format!("elastic model: {description}, {effort}")];

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
    lines.push(format!(
        "static contact: {}, {} contact solves, Newton steps {} at most of {MAXIMUM_ITERATIONS} allowed, residual of the contact \
         conditions {:.1e} at most",
        seconds_since(begin),
        quality.solves,
        quality.most_iterations,
        quality.kkt_residual
    ));
    lines.extend(at_build(&pair));

    let begin = Instant::now();
    let root_stress = args.root_stress.then(|| sweeps.root_stress()).transpose()?;
    if let Some(record) = &root_stress {
        let error = &record.interpolation_error;
        lines.push(format!("root stress: {}, {error}", seconds_since(begin)));
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
        let (time, words) = (seconds_since(begin), record.in_words());
        lines.push(format!("tooth pairs one by one: {time}, {words}"));
        if record.error.force_rms > LARGE_ERROR {
            lines.push(format!(
                "warning: tooth pairs one by one carry {:.1} % rms of the nominal force more or less than they should; for this \
                 pair build with --contact and set stiffnessModel = contact",
                100.0 * record.error.force_rms
            ));
        }
    }
    let mut contact = at_run_time.filter(|_| contact);
    if let Some(contact) = &mut contact {
        contact.error = Some(sweeps.error_at_run_time(contact)?);
        let error = run_time_error(contact.error.as_ref());
        lines.push(format!("contact at run time: {error}"));
    }
    if let Some(note) = pair::note_on_teeth(&pair.teeth) {
        let note = note_at_build(note, teeth.is_some(), contact.is_some());
        lines.push(format!("note: {note}"));
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
    file.solver = settings(&pair, &model, args, quality)?;
    file.seal();
    let text = format!("{}\n  {}", file.size_and_error(), lines.join("\n  "));
    Ok(Made {
        file,
        contact,
        text,
    })
}

fn seconds_since(begin: Instant) -> String {
    format!("{:.1} s", begin.elapsed().as_secs_f64())
}

/// The ranges of the pair file, those of centre distance and misalignment where they are `included`.
fn coverage(pair: &Pair, included: [bool; 2]) -> Coverage {
    let o = &pair.operating;
    let all = [o.center_distance_offset, o.misalignment];
    let range = |i: usize| Some(all[i]).filter(|[low, high]| included[i] && low < high);
    Coverage {
        center_distance_offset: range(0),
        misalignment: range(1),
        nominal_torque: o.nominal_torque,
        maximum_torque: o.maximum_torque,
    }
}

/// What the tables file keeps of how it was made.
fn settings(
    pair: &Pair,
    model: &Model,
    args: &ModelArgs,
    quality: SolveQuality,
) -> Result<BTreeMap<String, Value>, Error> {
    let modifications = |i| {
        let mut rows = Listing::default();
        modifications(pair, i, &mut rows);
        rows.in_one_line()
    };
    Ok(serde_json::from_value(json!({
        "elastic_model": model.description,
        "tip_corner_contact": pair.tip_corner_contact,
        "plane_strain": args.plane_strain,
        "stations_along_the_face": model.solver.settings().stations,
        "contact_solves": quality.solves,
        "most_newton_steps": quality.most_iterations,
        "newton_steps_allowed": MAXIMUM_ITERATIONS,
        "largest_kkt_residual": quality.kkt_residual,
        "modifications_of_gear_1": modifications(0),
        "modifications_of_gear_2": modifications(1),
    }))?)
}

/// Which levels of an FMU take the teeth of a pair that differ: `note` where none of those built with `teeth` or `contact` does.
fn note_at_build(note: &str, teeth: bool, contact: bool) -> String {
    let table = "`stiffnessModel = table` takes all teeth as alike";
    let also = if contact { ", as `contact` does" } else { "" };
    match (teeth, contact) {
        (true, _) => format!(
            "FMUs start with `stiffnessModel = teeth`, which takes the tooth errors{also}; {table}"
        ),
        (false, true) => format!("{table}; `stiffnessModel = contact` takes the tooth errors"),
        (false, false) => note.to_owned(),
    }
}
