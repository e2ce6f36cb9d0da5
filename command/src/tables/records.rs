//! What a tables file is made of: grids of the flanks, sliding, root stress, tooth pairs.

use std::sync::atomic::AtomicBool;

use gearmesh::contact::{ContactFile, ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::table::{
    Axes, FlankGrid, FlankTable, FrictionRecord, Interpolation, InterpolationError,
    RootStressRecord, TeethRecord,
};
use gearmesh_preprocessor::table::plan::{
    Coverage, default_axes, measure, measure_at_run_time, misalignments, table_within,
};
use gearmesh_preprocessor::table::source::WatchedSolver;
use gearmesh_preprocessor::table::sweep::{Watch, sweep};
use gearmesh_preprocessor::table::{
    RootStressSweep, TeethSweep, default_root_stress_axes, default_sliding_axes,
    default_teeth_axes, sweep_sliding,
};

use super::HELD_OUT_POINTS;
use crate::Error;
use crate::model::{Model, ModelArgs};

/// Random operating points at which contact at run time is measured.
const RUN_TIME_POINTS: usize = 32;

/// Most stations of the contact that it is measured against; a solve on 400 takes seconds.
const MOST_STATIONS: usize = 200;

/// Of the drive flank: the default grid, or one whose error stays below `max_error`, with its error.
pub(super) fn drive_flank(
    solver: &WatchedSolver<'_>,
    pair: &Pair,
    coverage: &Coverage,
    tilt: f64,
    max_error: Option<f64>,
    watch: &Watch,
) -> Result<(FlankGrid, InterpolationError), Error> {
    if let Some(error) = max_error {
        let (grid, found) = table_within(solver, &pair.geometry, coverage, tilt, error, watch)?;
        within(max_error, &found)?;
        return Ok((grid, found));
    }
    default_grid(solver, pair, Flank::Drive, coverage, tilt, watch)
}

/// The default grid of `flank`, and its error at random operating points.
pub(super) fn default_grid(
    solver: &WatchedSolver<'_>,
    pair: &Pair,
    flank: Flank,
    coverage: &Coverage,
    tilt: f64,
    watch: &Watch,
) -> Result<(FlankGrid, InterpolationError), Error> {
    let axes = Axes {
        misalignment: misalignments(coverage, tilt),
        ..default_axes(coverage)
    };
    let grid = sweep(solver, flank, &axes, coverage.maximum_torque, watch)?;
    let table = FlankTable::new(&grid, Interpolation::Spline)?;
    let points = HELD_OUT_POINTS;
    let error = measure(
        solver,
        &pair.geometry,
        flank,
        coverage,
        &table,
        points,
        watch,
    )?;
    Ok((grid, error))
}

/// Refuses tables that miss the error asked for.
pub(super) fn within(max_error: Option<f64>, found: &InterpolationError) -> Result<(), Error> {
    match max_error {
        Some(error) if found.force_rms > error => Err(format!(
            "--max-error = {error}: the best grid has an rms error of {:.5}; ask for no less, or narrow \
             the ranges of the pair file",
            found.force_rms
        )
        .into()),
        _ => Ok(()),
    }
}

/// How the load slides, on the coast flank, too, where it has its `own` tables.
pub(super) fn sliding(
    pair: &Pair,
    model: &Model,
    coverage: &Coverage,
    own: bool,
    watch: &Watch,
) -> Result<FrictionRecord, Error> {
    let axes = default_sliding_axes(coverage, pair.geometry.gears[0].base_radius());
    let of = |flank| sweep_sliding(&model.solver, flank, &axes, watch);
    Ok(FrictionRecord {
        law: pair.friction,
        drive: of(Flank::Drive)?,
        coast: own.then(|| of(Flank::Coast)).transpose()?,
        axes: axes.clone(),
    })
}

/// Stress in the tooth roots over the range of `coverage`, on the coast flank, too, where it has its `own` tables.
pub(super) fn root_stress(
    pair: &Pair,
    model: &Model,
    coverage: &Coverage,
    args: &ModelArgs,
    own: bool,
) -> Result<RootStressRecord, Error> {
    let rb = pair.geometry.gears[0].base_radius();
    let axes = default_root_stress_axes(coverage, rb);
    let of = |flank| {
        let job = args.job();
        let models = &args.fillets(pair, flank, &job)?.maps;
        drop(job);
        let sweep = RootStressSweep {
            solver: &model.solver,
            models,
            flank,
        };
        watched(args, "root stress", |watch| {
            let samples = sweep.samples(&axes, watch)?;
            let table = samples.spline(&axes, [true; 2])?;
            let error = sweep.measure(coverage, &table, HELD_OUT_POINTS, watch)?;
            Ok((samples, error))
        })
    };
    let (drive, mut error) = of(Flank::Drive)?;
    let coast = if own { Some(of(Flank::Coast)?) } else { None };
    if let Some((_, found)) = &coast {
        error = error.with(*found);
    }
    Ok(RootStressRecord {
        drive,
        coast: coast.map(|(samples, _)| samples),
        interpolation_error: error,
        axes,
    })
}

/// Tooth pairs one by one over the range of `coverage`, their error measured against `contact`.
pub(super) fn teeth(
    pair: &Pair,
    model: &Model,
    coverage: &Coverage,
    tilt: f64,
    contact: &ContactFile,
    args: &ModelArgs,
) -> Result<TeethRecord, Error> {
    let sweep = TeethSweep {
        solver: &model.solver,
        contact,
        coverage,
        coast_mirrors_drive: pair.coast_mirrors_drive(),
    };
    watched(args, "tooth pairs", |watch| {
        let axes = Axes {
            misalignment: misalignments(coverage, tilt),
            ..default_teeth_axes(coverage)
        };
        Ok(sweep.record(&axes, HELD_OUT_POINTS, watch)?)
    })
}

/// How far `contact` is over the whole range of the pair file from the static contact on more stations.
pub(super) fn at_run_time(
    pair: &Pair,
    model: &Model,
    contact: &ContactFile,
    args: &ModelArgs,
) -> Result<InterpolationError, Error> {
    let settings = args.contact_settings(pair);
    let usual = ContactSettings::for_pair(pair).stations;
    let own = settings.stations;
    let finer = ContactSettings {
        // Twice as many, but no more than are solved in seconds.
        stations: (2 * own.max(usual)).min(MOST_STATIONS).max(own),
        ..settings
    };
    let solver = ContactSolver::new(pair, model.compliance.clone(), finer)?;
    let coverage = super::coverage(pair, [true; 2]);
    watched(args, "error of contact at run time", |watch| {
        let of =
            |flank| measure_at_run_time(&solver, contact, flank, &coverage, RUN_TIME_POINTS, watch);
        let drive = of(Flank::Drive)?;
        Ok(match contact.coast {
            Some(_) => drive.with(of(Flank::Coast)?),
            None => drive,
        })
    })
}

/// `work` with its progress shown as that of `what`.
fn watched<R>(
    args: &ModelArgs,
    what: &'static str,
    work: impl FnOnce(&Watch) -> Result<R, Error>,
) -> Result<R, Error> {
    let job = args.job();
    work(&Watch {
        progress: &|done, total| {
            let told = format!("{done} of {total} solves");
            job.tell(what, done as f64 / total as f64, &told);
        },
        cancel: &AtomicBool::new(false),
    })
}
