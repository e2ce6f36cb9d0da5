//! The tables of a pair from its elastic models: which sweeps they need, on which nodes, and how far they are off static contact.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use crate::gear::Pair;
use crate::static_contact::{ContactError, ContactSolver, contact_settings};
use gearmesh::contact::{ContactFile, ContactSettings, MAXIMUM_ITERATIONS};
use gearmesh::gear::Flank;
use gearmesh::table::{
    Axes, Axis, FlankGrid, FlankTable, FrictionRecord, Interpolation, InterpolationError,
    LoadSpline, RootStressRecord, TableError, TableFile, TeethRecord,
};
use serde_json::{Value, json};

use super::coverage::{Coverage, default_axes, measure, measure_at_run_time, misalignments};
use super::plan::table_within;
use super::records::{
    RootStressSweep, default_root_stress_axes, default_sliding_axes, sweep_sliding,
};
use super::sweep::{SolveQuality, WatchedSolver, sweep};
use super::teeth::{TeethSweep, default_teeth_axes};
use crate::contact::{
    CycleInput, ElasticModels, LoadCase, MeshCycle, ModelError, ModelSettings, RootModels,
    StageProgress, body_orders, condensed_roots, contact_file,
};
use crate::finite_element::{FiniteElementError, Origin};
use crate::pair::modifications;

/// Random operating points at which the default grid is measured.
const HELD_OUT_POINTS: usize = 1000;
/// Those at which contact at run time is measured.
const RUN_TIME_POINTS: usize = 32;
/// Most stations of the contact that it is measured against; a solve on 400 takes seconds.
const MOST_STATIONS: usize = 200;

/// What the tables of a pair are to hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// Tables over the centre distance, where the pair has a range of it.
    pub center_distance: bool,
    /// Tables over the misalignment, likewise.
    pub misalignment: bool,
    /// Largest error of the force, rms over the nominal force; None: a fixed grid, whose error is measured.
    pub max_error: Option<f64>,
    /// How the load slides, for the effect `friction` of the FMU.
    pub friction: bool,
    /// Stress in the tooth roots, for its effect `rootStress`.
    pub root_stress: bool,
    /// Tooth pairs one by one, for its `stiffnessModel = teeth`.
    pub teeth: bool,
    /// What its `stiffnessModel = contact` needs to solve static contact at run time.
    pub contact: bool,
    /// What bodies that are no solids of revolution do beyond their mean, for its `bodyEffect`, where the pair has any.
    pub body: bool,
}

impl Default for Recipe {
    /// The force over all axes of the pair with its bodies, and no effects.
    fn default() -> Recipe {
        Recipe {
            center_distance: true,
            misalignment: true,
            max_error: None,
            friction: false,
            root_stress: false,
            teeth: false,
            contact: false,
            body: true,
        }
    }
}

/// Why a pair gets no tables.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// Root stress at run time in plane strain.
    #[error(
        "contact at run time has no stress in the tooth roots in plane strain; leave out `rootStress`, --plane-strain or --contact"
    )]
    PlaneStrain,
    /// No grid reaches [`Recipe::max_error`].
    #[error(
        "--max-error = {bound}: the best grid has an rms error of {reached:.5}; ask for no less, or narrow the ranges of the pair file"
    )]
    MaxError {
        /// What was wanted.
        bound: f64,
        /// What the best grid has.
        reached: f64,
    },
    /// No elastic model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// No finite-element model of the fillets.
    #[error(transparent)]
    FiniteElement(#[from] FiniteElementError),
    /// Contact at run time cannot be prepared.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// A static solve failed, or its samples make no table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// Tables, and what was done for them.
#[derive(Debug, Clone)]
pub struct Made {
    /// The tables, sealed.
    pub file: TableFile,
    /// Contact at run time, where the recipe has it.
    pub contact: Option<ContactFile>,
    /// What was done.
    pub account: Account,
}

/// What the computation of tables took.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Account {
    /// How well the static solves of the force went.
    pub quality: SolveQuality,
    /// Centre distances of the default grid, where the spline through the usual ones falls.
    pub more_center_distances: Option<usize>,
    /// Wall clock of the choice of the misalignments and of the sweeps of force and sliding, s.
    pub contact_seconds: f64,
    /// That of root stress in tables with its elastic models, s; None: the recipe has none.
    pub root_stress_seconds: Option<f64>,
    /// That of tooth pairs one by one, s; None: the recipe has none.
    pub teeth_seconds: Option<f64>,
    /// Where the models of the fillets came from, for each flank that has its own.
    pub root_origins: Vec<[Origin; 2]>,
}

impl Recipe {
    /// Refuses what no tables of `pair` can hold, before anything is computed.
    ///
    /// # Errors
    /// Root stress at run time in plane strain; tooth pairs one by one of teeth that they do not tell apart.
    pub fn check(&self, pair: &Pair, settings: &ModelSettings) -> Result<(), RecipeError> {
        if self.contact && self.root_stress && settings.plane_strain {
            return Err(RecipeError::PlaneStrain);
        }
        if self.teeth {
            TeethRecord::takes(&pair.teeth)?;
        }
        Ok(())
    }

    /// What the tables cover of the operating range of `pair`.
    fn coverage(&self, pair: &Pair) -> Coverage {
        Coverage::new(pair, self.center_distance, self.misalignment)
    }

    /// Computes the tables of the pair of `models`.
    ///
    /// # Errors
    /// Those of [`Recipe::check`]; the first solve that fails, with its operating point; [`RecipeError::MaxError`].
    pub fn compute(
        &self,
        models: &ElasticModels,
        progress: StageProgress,
    ) -> Result<Made, RecipeError> {
        let pair = &models.pair;
        self.check(pair, &models.settings)?;
        let coverage = &self.coverage(pair);
        let mut account = Account::default();

        let begin = Instant::now();
        let source = WatchedSolver::new(&models.solver, coverage.misalignment);
        let sweeps = Sweeps {
            models,
            coverage,
            misalignments: misalignments(&source, &pair.geometry, coverage)?,
            progress,
        };
        let (drive, coast, error) = sweeps.force(&source, self.max_error)?;
        account.quality = source.quality();
        let distances = drive.axes.center_distance_offset.len();
        let is_more = MORE_CENTER_DISTANCES.contains(&distances) && self.max_error.is_none();
        account.more_center_distances = is_more.then_some(distances);
        let mut file = TableFile::new(
            &pair.name,
            "static tooth contact by gearmesh",
            &pair.geometry,
            [coverage.nominal_torque, coverage.maximum_torque],
            &drive,
            coast.as_ref(),
        );
        file.interpolation_error = Some(error);
        if self.friction {
            file.friction = Some(sweeps.sliding()?);
        }
        account.contact_seconds = begin.elapsed().as_secs_f64();
        if self.body {
            file.bodies = body_orders(pair, &models.solver)?;
        }

        let begin = Instant::now();
        let mut roots = vec![];
        if self.root_stress {
            for flank in flanks(pair) {
                roots.push(sweeps.root_models(flank)?);
            }
            file.root_stress = Some(sweeps.root_stress(&roots)?);
            account.root_stress_seconds = Some(begin.elapsed().as_secs_f64());
        }

        // Tooth pairs one by one are measured against contact at run time.
        let mut contact = None;
        if self.contact || self.teeth {
            let solver = models.solver_at_run_time();
            let mut at_run_time = contact_file(pair, &solver)?;
            Arc::make_mut(&mut at_run_time.setup)
                .bodies
                .clone_from(&file.bodies);
            if self.contact && self.root_stress {
                if at_run_time.coast.is_some() && roots.len() == 1 {
                    // Teeth that differ have a coast flank of their own at run time, even where flanks are mirrored.
                    roots.push(sweeps.root_models(Flank::Coast)?);
                }
                add_roots(&mut at_run_time, &solver, &roots)?;
            }
            if self.teeth {
                let begin = Instant::now();
                file.teeth = Some(sweeps.teeth(&at_run_time, self.friction)?);
                account.teeth_seconds = Some(begin.elapsed().as_secs_f64());
            }
            if self.contact {
                at_run_time.error = Some(sweeps.error_at_run_time(&at_run_time)?);
                contact = Some(at_run_time);
            }
        }

        account.root_origins = roots.into_iter().map(|models| models.origins).collect();
        file.solver = description(models, &account.quality);
        let bent = on_bent_teeth(models)?;
        file.solver
            .insert("contact_on_bent_teeth".into(), json!(bent));
        file.seal();
        Ok(Made {
            file,
            contact,
            account,
        })
    }
}

/// Mesh positions at which the effect of bent teeth is measured.
const BENT_POSITIONS: usize = 16;

/// What contact that moves as teeth bend changes under the nominal torque.
fn on_bent_teeth(models: &ElasticModels) -> Result<String, ContactError> {
    let input = CycleInput {
        flank: Flank::Drive,
        center_distance_offset: 0.0,
        positions: BENT_POSITIONS,
    };
    let load = LoadCase {
        torque: models.pair.operating.nominal_torque,
        misalignment: 0.0,
    };
    let shares = match models.solver.settings().bent_teeth {
        true => MeshCycle::solve(&models.solver, &input, load)?.share_of_bent_teeth(),
        false => [0.0; 2],
    };
    let [mean, swing] = shares.map(|share| 100.0 * share);
    Ok(format!(
        "changes the mean transmission error by {mean:.2} %, its peak-to-peak value by {swing:.1} %, under the nominal torque"
    ))
}

/// Settings of the static solver and how well it went, as a tables file keeps them.
fn description(models: &ElasticModels, quality: &SolveQuality) -> BTreeMap<String, Value> {
    let [modified1, modified2] = modified(&models.pair);
    [
        ("elastic_model", json!(models.description())),
        ("tip_corner_contact", json!(models.pair.tip_corner_contact)),
        ("plane_strain", json!(models.settings.plane_strain)),
        (
            "stations_along_the_face",
            json!(models.solver.settings().stations),
        ),
        ("contact_solves", json!(quality.solves)),
        ("most_newton_steps", json!(quality.most_iterations)),
        ("newton_steps_allowed", json!(MAXIMUM_ITERATIONS)),
        ("largest_kkt_residual", json!(quality.kkt_residual)),
        (MODIFICATIONS[0], json!(modified1)),
        (MODIFICATIONS[1], json!(modified2)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

/// Names under which tables files have the modifications of both gears.
const MODIFICATIONS: [&str; 2] = ["modifications_of_gear_1", "modifications_of_gear_2"];

/// Modifications of both gears of `pair` in words.
fn modified(pair: &Pair) -> [String; 2] {
    [0, 1].map(|i| {
        let rows = modifications(pair, i);
        let rows: Vec<String> = rows
            .iter()
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        rows.join("; ")
    })
}

/// How the flanks that the tables `file` were made for differ from those of `pair`, in words; None: they do not, or the tables do not
/// say, as those of samples.
pub fn other_flanks(file: &TableFile, pair: &Pair) -> Option<String> {
    let gears = MODIFICATIONS.into_iter().zip(modified(pair)).zip(1..);
    let mut other = gears.filter_map(|((name, own), gear)| {
        let made_for = file.solver.get(name)?.as_str()?;
        (made_for != own).then(|| format!("gear {gear} has `{made_for}` there, and `{own}` here"))
    });
    other.next()
}

/// Flanks whose tables a pair needs: drive, and coast where it does not mirror drive.
fn flanks(pair: &Pair) -> Vec<Flank> {
    match pair.coast_mirrors_drive() {
        true => vec![Flank::Drive],
        false => vec![Flank::Drive, Flank::Coast],
    }
}

/// Adds the stress in the tooth roots to the contact at run time that `solver` has, by `roots` of its flanks.
fn add_roots(
    contact: &mut ContactFile,
    solver: &ContactSolver,
    roots: &[RootModels],
) -> Result<(), RecipeError> {
    let condensed = [&mut contact.drive].into_iter().chain(&mut contact.coast);
    let flanks = [Flank::Drive, Flank::Coast];
    for ((condensed, flank), models) in condensed.zip(flanks).zip(roots) {
        Arc::make_mut(condensed).roots = Some(condensed_roots(solver, flank, &models.maps)?);
    }
    Ok(())
}

/// Numbers of centre distances where the spline through the default ones falls, one after the other.
const MORE_CENTER_DISTANCES: [usize; 2] = [9, 17];

/// Name of the sweeps of the force in progress.
const FORCE: &str = "static contact";

/// Grids of the drive flank and of a coast flank of its own, and their error.
type Grids = (FlankGrid, Option<FlankGrid>, InterpolationError);

/// Sweeps of one pair.
struct Sweeps<'a> {
    models: &'a ElasticModels,
    coverage: &'a Coverage,
    /// Default ones of the tables, rad, see [`misalignments`].
    misalignments: Vec<f64>,
    progress: StageProgress<'a>,
}

impl Sweeps<'_> {
    /// Grids of the drive flank, within `max_error` if there is one, and of a coast flank that needs its own, on the same axes, and
    /// their error.
    fn force(&self, solver: &WatchedSolver, max_error: Option<f64>) -> Result<Grids, RecipeError> {
        let Some(bound) = max_error else {
            return Ok(self.default_grids(solver)?);
        };
        let (drive, error) = table_within(
            solver,
            &self.models.pair.geometry,
            self.coverage,
            &self.misalignments,
            bound,
            &self.stage(FORCE),
        )?;
        let grids = self.with_coast(solver, drive, error, FORCE)?;
        let reached = grids.2.force_rms;
        match reached > bound {
            true => Err(RecipeError::MaxError { bound, reached }),
            false => Ok(grids),
        }
    }

    /// The grids on default axes, with as few centre distances as the spline bears: where teeth deflect little beside their range, another
    /// tooth pair bears at the next one.
    fn default_grids(&self, solver: &WatchedSolver) -> Result<Grids, TableError> {
        let mut more = MORE_CENTER_DISTANCES.into_iter();
        let mut axes = Axes {
            misalignment: self.misalignments.clone(),
            ..default_axes(self.coverage)
        };
        let too_few = Axis::CenterDistance;
        let mut stage = FORCE.to_owned();
        loop {
            let drive = self.grid(&axes, solver, Flank::Drive, &stage);
            let made =
                drive.and_then(|(drive, error)| self.with_coast(solver, drive, error, &stage));
            match (made, more.next()) {
                (Err(TableError::TooCoarse { axis, .. }), Some(n)) if axis == too_few => {
                    axes.center_distance_offset = self.coverage.offsets(n);
                    stage = format!("{FORCE} at {n} centre distances");
                }
                (made, _) => return made,
            }
        }
    }

    /// `drive` with the grid of the coast flank on the same axes, where the pair needs it, and the `error` of both.
    fn with_coast(
        &self,
        solver: &WatchedSolver,
        drive: FlankGrid,
        error: InterpolationError,
        stage: &str,
    ) -> Result<Grids, TableError> {
        let coast = self.on_own_coast(|flank| self.grid(&drive.axes, solver, flank, stage))?;
        let error = coast.as_ref().map_or(error, |coast| error.with(coast.1));
        Ok((drive, coast.map(|(grid, _)| grid), error))
    }

    /// The grid of `flank` on `axes`, and its error at random operating points.
    fn grid(
        &self,
        axes: &Axes,
        solver: &WatchedSolver,
        flank: Flank,
        stage: &str,
    ) -> Result<(FlankGrid, InterpolationError), TableError> {
        let largest = self.coverage.maximum_torque;
        let grid = sweep(solver, flank, axes, largest, &self.stage(stage))?;
        let table = &FlankTable::new(&grid, Interpolation::Spline)?;
        let geometry = &self.models.pair.geometry;
        let error = measure(
            solver,
            geometry,
            flank,
            self.coverage,
            table,
            HELD_OUT_POINTS,
        )?;
        Ok((grid, error))
    }

    fn sliding(&self) -> Result<FrictionRecord, TableError> {
        let pair = &self.models.pair;
        let axes = default_sliding_axes(self.coverage, pair.geometry.gears[0].base_radius());
        let sample = |flank| {
            let progress = &self.stage("sliding");
            sweep_sliding(&self.models.solver, flank, &axes, progress)
        };
        Ok(FrictionRecord {
            law: pair.friction,
            drive: sample(Flank::Drive)?,
            coast: self.on_own_coast(sample)?,
            axes: axes.clone(),
        })
    }

    /// Models of the stress in the roots for `flank`.
    fn root_models(&self, flank: Flank) -> Result<RootModels, FiniteElementError> {
        let ElasticModels { settings, pair, .. } = self.models;
        settings.root_models(pair, flank, self.progress)
    }

    /// Root stress by `models` of the drive flank and, where it has its own, of the coast flank.
    fn root_stress(&self, models: &[RootModels]) -> Result<RootStressRecord, TableError> {
        let base_radius = self.models.pair.geometry.gears[0].base_radius();
        let axes = default_root_stress_axes(self.coverage, base_radius);
        let sample = |flank| {
            let sweep = RootStressSweep {
                solver: &self.models.solver,
                models: &models[usize::from(flank == Flank::Coast)].maps,
                flank,
            };
            let samples = sweep.samples(&axes, &self.stage("root stress"))?;
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

    /// Tooth pairs one by one, their error measured against `contact`.
    fn teeth(&self, contact: &ContactFile, friction: bool) -> Result<TeethRecord, TableError> {
        let sweep = TeethSweep {
            solver: &self.models.solver,
            contact,
            coverage: self.coverage,
            coast_mirrors_drive: self.models.pair.coast_mirrors_drive(),
            friction,
        };
        let nodes = &self.misalignments;
        let axes = Axes {
            misalignment: nodes[self.coverage.inside_of(nodes)].to_vec(),
            ..default_teeth_axes(self.coverage)
        };
        sweep.record(&axes, HELD_OUT_POINTS, &self.stage("tooth pairs"))
    }

    /// How far `contact` is over the whole operating range from the static contact on more stations.
    fn error_at_run_time(&self, contact: &ContactFile) -> Result<InterpolationError, RecipeError> {
        let pair = &self.models.pair;
        let settings = self.models.settings.contact(pair);
        let usual = contact_settings(pair).stations;
        let own = settings.stations;
        let finer = ContactSettings {
            // Twice as many, but no more than are solved in seconds.
            stations: (2 * own.max(usual)).min(MOST_STATIONS).max(own),
            ..settings
        };
        let solver = ContactSolver::new(pair, self.models.compliance.clone(), finer)?;
        let coverage = Coverage::new(pair, true, true);
        let error =
            |flank| measure_at_run_time(&solver, contact, flank, &coverage, RUN_TIME_POINTS);
        let drive = error(Flank::Drive)?;
        Ok(match contact.coast {
            Some(_) => drive.with(error(Flank::Coast)?),
            None => drive,
        })
    }

    /// `work` on the coast flank, where it has tables of its own.
    fn on_own_coast<R>(
        &self,
        work: impl FnOnce(Flank) -> Result<R, TableError>,
    ) -> Result<Option<R>, TableError> {
        match self.models.pair.coast_mirrors_drive() {
            true => Ok(None),
            false => work(Flank::Coast).map(Some),
        }
    }

    /// Progress of a sweep that `stage` names.
    fn stage<'s>(&'s self, stage: &'s str) -> impl Fn(usize, usize) + Sync + 's {
        move |done, total| (self.progress)(stage, done as f64 / total as f64)
    }
}
