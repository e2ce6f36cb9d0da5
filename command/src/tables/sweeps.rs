//! What a tables file is made of: grids of the flanks, sliding, root stress, tooth pairs; before them, whether the contact can
//! be solved at the corners of the operating range.

use std::sync::Arc;

use gearmesh::contact::{ContactFile, ContactSettings, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::{
    Axes, FlankGrid, FlankTable, FrictionRecord, Interpolation, InterpolationError, LoadSpline,
    RootStressRecord, TeethRecord,
};
use gearmesh_preprocessor::contact::{CycleInput, MeshCycle, condensed_roots};
use gearmesh_preprocessor::table::{
    Coverage, RootStressSweep, TeethSweep, WatchedSolver, default_axes, default_root_stress_axes,
    default_sliding_axes, default_teeth_axes, measure, measure_at_run_time, misalignments, sweep,
    sweep_sliding, table_within,
};

use crate::case::load_matrix;
use crate::error::Result;
use crate::model::{Model, ModelArgs};
use crate::output::Job;

/// Positions of the mesh cycle at which every corner is solved.
const POSITIONS: usize = 16;
/// Random operating points at which the default grid, and contact at run time, is measured.
const HELD_OUT_POINTS: usize = 1000;
const RUN_TIME_POINTS: usize = 32;

/// Most stations of the contact that it is measured against; a solve on 400 takes seconds.
const MOST_STATIONS: usize = 200;

pub(super) struct Sweeps<'a> {
    pub pair: &'a Pair,
    pub model: &'a Model,
    pub coverage: &'a Coverage,
    /// Misalignment (rad) beyond which the contact changes its form, see `tilt`.
    pub tilt: f64,
    pub args: &'a ModelArgs,
    pub job: &'a Job,
}

impl Sweeps<'_> {
    /// Grids of the drive flank, within `max_error` if there is one, and of a coast flank that needs its own, on the same axes, and
    /// their error.
    pub fn flanks(
        &self,
        solver: &WatchedSolver<'_>,
        max_error: Option<f64>,
    ) -> Result<(FlankGrid, Option<FlankGrid>, InterpolationError)> {
        let geometry = &self.pair.geometry;
        let (drive, error) = match max_error {
            None => {
                let axes = self.with_misalignments(default_axes(self.coverage));
                self.grid_on(&axes, solver, Flank::Drive)?
            }
            Some(bound) => {
                let progress = &self.progress("static contact");
                table_within(solver, geometry, self.coverage, self.tilt, bound, progress)?
            }
        };
        let coast = self.on_own_coast(|flank| self.grid_on(&drive.axes, solver, flank))?;
        let error = coast.as_ref().map_or(error, |coast| error.with(coast.1));
        if let Some(bound) = max_error.filter(|bound| error.force_rms > *bound) {
            refuse!(
                "--max-error = {bound}: the best grid has an rms error of {:.5}; ask for no less, or narrow the ranges of the pair file",
                error.force_rms
            );
        }
        Ok((drive, coast.map(|(grid, _)| grid), error))
    }

    /// The grid of `flank` on `axes`, and its error at random operating points.
    fn grid_on(
        &self,
        axes: &Axes,
        solver: &WatchedSolver<'_>,
        flank: Flank,
    ) -> Result<(FlankGrid, InterpolationError)> {
        let largest = self.coverage.maximum_torque;
        let progress = &self.progress("static contact");
        let grid = sweep(solver, flank, axes, largest, progress)?;
        let table = &FlankTable::new(&grid, Interpolation::Spline)?;
        let (geometry, coverage, points) = (&self.pair.geometry, self.coverage, HELD_OUT_POINTS);
        let error = measure(solver, geometry, flank, coverage, table, points)?;
        Ok((grid, error))
    }

    pub fn sliding(&self) -> Result<FrictionRecord> {
        let base_radius = self.pair.geometry.gears[0].base_radius();
        let axes = default_sliding_axes(self.coverage, base_radius);
        let solver = &self.model.solver;
        let progress = &self.progress("sliding");
        let sample = |flank| Ok(sweep_sliding(solver, flank, &axes, progress)?);
        Ok(FrictionRecord {
            law: self.pair.friction,
            drive: sample(Flank::Drive)?,
            coast: self.on_own_coast(sample)?,
            axes: axes.clone(),
        })
    }

    pub fn root_stress(&self) -> Result<RootStressRecord> {
        let base_radius = self.pair.geometry.gears[0].base_radius();
        let axes = default_root_stress_axes(self.coverage, base_radius);
        let sample = |flank| {
            let sweep = RootStressSweep {
                solver: &self.model.solver,
                models: &self.args.fillets(self.pair, flank, self.job)?.maps,
                flank,
            };
            let samples = sweep.samples(&axes, &self.progress("root stress"))?;
            let table = LoadSpline::new(axes.nodes(), &samples.columns(), [true; 2])?;
            let error = sweep.measure(self.coverage, &table, HELD_OUT_POINTS)?;
            Ok((samples, error))
        };
        let (drive, error) = sample(Flank::Drive)?;
        let coast = self.on_own_coast(sample)?;
        let error = coast.as_ref().map_or(error, |coast| error.with(coast.1));
        Ok(RootStressRecord {
            drive,
            coast: coast.map(|(samples, _)| samples),
            interpolation_error: error,
            axes,
        })
    }

    /// Adds the stress in the tooth roots to the `contact` at run time that `solver` has.
    pub fn add_root_stress(&self, contact: &mut ContactFile, solver: &ContactSolver) -> Result<()> {
        let flanks = [&mut contact.drive].into_iter().chain(&mut contact.coast);
        for (condensed, flank) in flanks.zip([Flank::Drive, Flank::Coast]) {
            let maps = self.args.fillets(self.pair, flank, self.job)?.maps;
            Arc::make_mut(condensed).roots = Some(condensed_roots(solver, flank, &maps)?);
        }
        Ok(())
    }

    /// Tooth pairs one by one, their error measured against `contact`.
    pub fn teeth(&self, contact: &ContactFile, friction: bool) -> Result<TeethRecord> {
        let sweep = TeethSweep {
            solver: &self.model.solver,
            contact,
            coverage: self.coverage,
            coast_mirrors_drive: self.pair.coast_mirrors_drive(),
            friction,
        };
        let axes = self.with_misalignments(default_teeth_axes(self.coverage));
        Ok(sweep.record(&axes, HELD_OUT_POINTS, &self.progress("tooth pairs"))?)
    }

    /// How far `contact` is over the whole range of the pair file from the static contact on more stations.
    pub fn error_at_run_time(&self, contact: &ContactFile) -> Result<InterpolationError> {
        let settings = self.args.contact_settings(self.pair);
        let usual = ContactSettings::for_pair(self.pair).stations;
        let own = settings.stations;
        let finer = ContactSettings {
            // Twice as many, but no more than are solved in seconds.
            stations: (2 * own.max(usual)).min(MOST_STATIONS).max(own),
            ..settings
        };
        let solver = ContactSolver::new(self.pair, self.model.compliance.clone(), finer)?;
        let coverage = coverage(self.pair, [true; 2]);
        let error =
            |flank| measure_at_run_time(&solver, contact, flank, &coverage, RUN_TIME_POINTS);
        let drive = error(Flank::Drive)?;
        match contact.coast {
            Some(_) => Ok(drive.with(error(Flank::Coast)?)),
            None => Ok(drive),
        }
    }

    fn with_misalignments(&self, mut axes: Axes) -> Axes {
        axes.misalignment = misalignments(self.coverage, self.tilt);
        axes
    }

    /// `work` on the coast flank where the drive flank's tables do not serve it.
    fn on_own_coast<R>(&self, work: impl FnOnce(Flank) -> Result<R>) -> Result<Option<R>> {
        let own = !self.pair.coast_mirrors_drive();
        own.then(|| work(Flank::Coast)).transpose()
    }

    fn progress<'s>(&'s self, stage: &'s str) -> impl Fn(usize, usize) + Sync + 's {
        let job = self.job;
        move |done, total| job.show(stage, done as f64 / total as f64)
    }
}

/// The ranges of the pair file, those of centre distance and misalignment where they are `included`.
pub fn coverage(pair: &Pair, included: [bool; 2]) -> Coverage {
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

/// Refuses what cannot be solved at a corner of `coverage` on the coarse model, where a finer one is still to be computed.
pub fn preflight(pair: &Pair, args: &ModelArgs, coverage: &Coverage, job: &Job) -> Result<()> {
    if pair.refinement == Refinement::Coarse || args.are_cached(pair)? {
        return Ok(());
    }
    let mut coarse = pair.clone();
    coarse.refinement = Refinement::Coarse;
    corners(&args.model(&coarse, None, job)?.solver, pair, coverage)
}

/// Solves under the largest torque at the corners of `coverage` and at its nominal state.
pub fn corners(solver: &ContactSolver, pair: &Pair, coverage: &Coverage) -> Result<()> {
    let torque = coverage.maximum_torque;
    let nominal = |range: Option<[f64; 2]>| [&[0.0], range.as_slice().as_flattened()].concat();
    let loads = load_matrix(&[torque], &nominal(coverage.misalignment));
    for flank in [Flank::Drive, Flank::Coast] {
        if flank == Flank::Coast && pair.coast_mirrors_drive() {
            continue;
        }
        for center_distance_offset in nominal(coverage.center_distance_offset) {
            let input = CycleInput {
                flank,
                torque,
                center_distance_offset,
                misalignment: 0.0,
                positions: POSITIONS,
            };
            MeshCycle::solve_all(solver, &[None, None], &input, &loads, &|_| {}).map_err(
                |error| format!("the operating range of the pair file cannot be covered: {error}"),
            )?;
        }
    }
    Ok(())
}
