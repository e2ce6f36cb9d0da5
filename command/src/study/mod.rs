//! `gearmesh study PAIR.json`: what modifications and tolerances do to transmission error, pressure and root stress.

mod judgement;
mod search;
mod setup;
mod show;
mod variation;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use gearmesh::words::hex;
use gearmesh_preprocessor::contact::ModelSettings;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::gear::tolerance;
use gearmesh_preprocessor::pair::{self, PairDraft};
use indicatif::HumanDuration;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::model::{Model, ModelArgs, ShaftArgs, widen};
use crate::output::Job;
use crate::page::origin;
use crate::statistics::{Sample, outcomes};
use crate::{limits, output};
use judgement::{BestArgs, Nearest};
use setup::{FLANK, MOST_CYCLES, Setup};
use show::{Known, Summary};
use variation::{Plan, Requested, Variation};

/// Points that the optimizer tries by default for each range: some CMA-ES needs to gather within the last hundredth of it.
const POINTS: usize = 150;

/// On what such a study takes its time.
const NOTE_ON_THICKNESS: &str = "the thickness of teeth is varied: every sample has an elastic model of its own, which takes most of the time";

/// Solve the mesh cycle of a pair on a grid of modifications or where an optimizer looks for the best one, and of samples within
/// tolerances.
///
/// A grid has every combination of its values; the optimizer tries points within ranges. The best point is written as a pair file.
/// A study that was stopped goes on where it was when it is started again.
#[derive(Debug, Args)]
pub struct Study {
    /// Pair file
    pair: PathBuf,

    /// Field of the pair file, or torque_nm, misalignment_mrad or center_distance_offset_um, and its values; repeatable.
    /// FIELD=LOW..HIGH/POINTS: on a grid; FIELD=LOW..HIGH/optimize: for the optimizer to choose; in both several fields with
    /// commas between them share a value. FIELD=LOW..HIGH: drawn in that interval. FIELD=+-TOLERANCE: drawn about the value
    /// in the file, or about that of the point
    #[arg(long, value_name = "FIELD=VALUES", value_parser = Requested::parse)]
    vary: Vec<Requested>,

    /// Tolerance class of ISO 1328-1:2013, 1 to 11: profile and helix slope of both gears are drawn within its f_HaT and f_HbT, times cos beta_b
    #[arg(long, value_name = "CLASS", value_parser = class)]
    iso_1328_class: Option<u8>,

    /// Most points that the optimizer tries [default: 150 for each range]
    #[arg(long, value_parser = limits::within(1..=MOST_CYCLES))]
    points: Option<usize>,

    /// Number of samples of what is drawn [default: 500; on a grid or for the optimizer 20 for each point]
    #[arg(long, value_parser = limits::within(1..=MOST_CYCLES))]
    samples: Option<usize>,

    /// Another seed draws other samples, and has the optimizer try other points
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Torques on gear 1, N m, with commas between them [default: the pair's nominal torque]
    #[arg(long, visible_alias = "torque-nm", value_name = "TORQUES", value_delimiter = ',', value_parser = limits::torque)]
    torques_nm: Vec<f64>,

    #[command(flatten)]
    best: BestArgs,

    /// Number of positions over the mesh cycle; its first harmonic takes three
    #[arg(long, default_value_t = 32, value_parser = limits::within(3..=limits::MOST_POSITIONS))]
    positions: usize,

    /// Folder for samples.csv, study.json, study.html, its charts, and the best point as best.json; it is made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Leave out what the folder holds of an earlier run
    #[arg(long)]
    restart: bool,

    #[command(flatten)]
    shafts: ShaftArgs,

    #[command(flatten)]
    model: ModelArgs,
}

fn class(text: &str) -> Result<u8, String> {
    let class = text.parse().ok().filter(|c| tolerance::CLASSES.contains(c));
    class.ok_or_else(|| "give a class from 1 to 11, a bare number".into())
}

impl Study {
    /// Samples and points of `plan`.
    fn counts(&self, plan: &Plan) -> Result<[usize; 2]> {
        let samples = match (plan.drawn.is_empty(), self.samples) {
            (true, _) => 0,
            (_, Some(samples)) => samples,
            _ if plan.axes.is_empty() => 500,
            _ => 20,
        };
        match (plan.is_optimized(), self.points) {
            (true, Some(points)) => Ok([samples, points]),
            (true, None) => Ok([samples, POINTS * plan.axes.len()]),
            (false, None) => Ok([samples, plan.points()]),
            (false, Some(points)) => refuse!(
                "--points = {points}: nothing is optimized; give --vary FIELD=LOW..HIGH/optimize, too, or leave it out"
            ),
        }
    }

    /// What is varied and looked for, the pair with the operating range that it takes, and how many samples and points.
    fn setup(&self) -> Result<(Setup, Pair, [usize; 2])> {
        let draft = PairDraft::read(&self.pair)?;
        let drawn = self.model.applied_to(draft.pair()?);
        let mut pair = self.shafts.applied_to(drawn.clone());
        let mut torques = self.torques_nm.clone();
        if torques.is_empty() {
            torques.push(pair.operating.nominal_torque);
        }
        let plan = Plan::new(&self.vary, self.iso_1328_class, &draft, &pair, torques[0])?;
        let [samples, points] = self.counts(&plan)?;
        let outcomes = outcomes(self.model.root_stress);
        let setup = Setup {
            measure: self.best.measure(&outcomes, &torques)?,
            requirements: self.best.requirements(&outcomes)?,
            draft,
            plan,
            torques,
            outcomes,
            seed: self.seed,
            positions: self.positions,
            own: ModelSettings {
                cache: None,
                ..self.model.settings()
            },
            has_roots: self.model.root_stress,
        };
        setup.check(&drawn, samples, points)?;
        let tilts = setup
            .plan
            .range("misalignment_mrad")
            .map(|mrad| 1e-3 * mrad);
        let offsets = setup
            .plan
            .range("center_distance_offset_um")
            .map(|um| 1e-6 * um);
        let [_, largest] = setup.plan.range("torque_nm");
        for torque in setup.torques.iter().copied().chain([largest]) {
            widen(&mut pair, torque, tilts, offsets);
        }
        Ok((setup, pair, [samples, points]))
    }

    pub fn run(self) -> Result<()> {
        let origin = origin(&self.pair)?;
        let (mut setup, pair, [samples, points]) = self.setup()?;

        output::make_folder("--output", &self.output)?;
        let names = ["samples.csv", "study.json", "study.html", "best.json"];
        let [table, summary, page, best] = names.map(|name| self.output.join(name));
        for path in [&table, &summary, &page, &best] {
            output::check_writable(path, [&self.pair])?;
        }
        let identity = self.identity(&pair, &setup, samples);
        let done = match !self.restart && is_begun(&summary, &identity)? {
            true => setup.read(&table)?,
            false => Vec::new(),
        };
        let varies_thickness = setup.plan.all().any(Variation::is_thickness);
        let known = Known {
            pair: pair.name.clone(),
            identity,
            notes: (pair::note_on_teeth(&pair.teeth).into_iter())
                .chain(varies_thickness.then_some(NOTE_ON_THICKNESS))
                .collect(),
        };
        // Samples of another study do not stand beside the new identity, wherever this one is stopped.
        if done.is_empty() {
            setup.write(&table, &[])?;
        }
        Summary::new(&setup, &known, Vec::new(), samples).write(&summary)?;

        let job = self.model.start()?;
        let roots = self.model.root_stress.then_some(FLANK);
        let model = self.model.model(&pair, roots, &job)?;
        let mut work = Work {
            table,
            pair,
            model,
            done,
            total: (points + 1) * (samples + 1),
            loads: setup.torques.len(),
            is_optimized: setup.plan.is_optimized(),
            forecast: None,
            job,
        };
        let search_ended = work.solve_all(&mut setup, samples, points)?;
        let Work {
            done, job, table, ..
        } = work;
        drop(job);
        // Other requirements mark the same samples anew.
        setup.write(&table, &done)?;

        let all = judged(&setup, &known, done, search_ended)?;
        let found = all.best.as_ref().map(|found| found.point);
        self.write_best(&setup, found, &known.pair, &best)?;
        all.write(&summary)?;
        let text = all.text();
        let figures = self.output.join("figures");
        output::make_folder("--output", &figures)?;
        all.page(&text, origin).write(&page, Some(&figures))?;
        output::print(&text)?;
        match all.nearest {
            None => Ok(()),
            Some(Nearest { point, violates }) => refuse!(
                "no point meets all requirements, so that best.json is not written; point {point} comes nearest and violates \
                 {violates}: relax a requirement, or vary more fields or wider"
            ),
        }
    }

    /// Writes the pair of the `best` point, as a variant of the pair `name`, to `path`. Where there is none, the file of an earlier run with
    /// other requirements goes.
    fn write_best(
        &self,
        setup: &Setup,
        best: Option<usize>,
        name: &str,
        path: &Path,
    ) -> Result<()> {
        let Some(point) = best else {
            if path.exists() {
                std::fs::remove_file(path)
                    .map_err(|error| format!("cannot remove {}: {error}", path.display()))?;
            }
            return Ok(());
        };
        let mut draft = setup.changed(point, &setup.plan.values(point, 0, self.seed))?;
        draft.rename(&format!("{name}-best"));
        output::write_whole(path, draft.to_json().as_bytes())
    }

    fn identity(&self, pair: &Pair, setup: &Setup, samples: usize) -> String {
        let Setup { plan, torques, .. } = setup;
        let (seed, positions, args) = (self.seed, self.positions, &self.model);
        let (settings, plane_strain) = (args.settings().contact(pair), args.plane_strain);
        let roots = if args.root_stress { " root stress" } else { "" };
        // What the optimizer tries depends on how it judges.
        let judged = match plan.is_optimized() {
            true => format!(" {:?} {:?} {samples}", setup.measure, setup.requirements),
            false => String::new(),
        };
        let version = env!("CARGO_PKG_VERSION");
        let all = format!(
            "{version} {pair:?} {plan:?} {seed} {positions} {torques:?} {settings:?} {plane_strain}{roots}{judged}"
        );
        hex(&Sha256::digest(all)[..16])
    }
}

/// The summary of all samples that are `done`.
fn judged<'a>(
    setup: &'a Setup,
    known: &'a Known,
    done: Vec<Sample>,
    search_ended: Option<bool>,
) -> Result<Summary<'a>> {
    let found = setup.best(&done)?;
    let mut statistics = setup.spread(&done, 0)?;
    let mut violations = setup.violations(&done, 0);
    if let Some(found) = &found {
        statistics.extend(setup.spread(&done, found.point)?);
        violations.extend(setup.violations(&done, found.point));
    }
    // More samples than requested now stay in the table.
    let samples = done.iter().map(|s| s.number).max().unwrap_or(0);
    let nearest = setup.nearest(&done).filter(|_| found.is_none());
    Ok(Summary {
        best: found,
        nearest,
        statistics,
        violations,
        search_ended,
        ..Summary::new(setup, known, done, samples)
    })
}

/// A time ahead, as exact as a forecast is.
fn about(time: Duration) -> String {
    match time.as_secs() {
        0 => "less than a second".into(),
        _ => format!("about {}", HumanDuration(time)),
    }
}

/// What is solved, and where it is kept.
struct Work {
    table: PathBuf,
    pair: Pair,
    model: Model,
    done: Vec<Sample>,
    /// Most samples of the study.
    total: usize,
    /// Of each sample.
    loads: usize,
    is_optimized: bool,
    /// Since when how many samples were solved; None before the first.
    forecast: Option<(Instant, usize)>,
    job: Job,
}

impl Work {
    /// Solves the `samples` of all points, or of those that the optimizer tries, `points` at most; returns whether its search came to an
    /// end, None without one.
    fn solve_all(
        &mut self,
        setup: &mut Setup,
        samples: usize,
        points: usize,
    ) -> Result<Option<bool>> {
        let of_point = |point: usize| (0..=samples).map(move |number| (point, number));
        if setup.plan.is_optimized() {
            self.solve(setup, of_point(0))?;
            return self.optimize(setup, samples, points).map(Some);
        }
        self.solve(setup, (0..=points).flat_map(of_point))?;
        Ok(None)
    }

    /// Solves those of `samples`, by point and number, that are not there, and keeps them on disk.
    fn solve(
        &mut self,
        setup: &Setup,
        samples: impl Iterator<Item = (usize, usize)>,
    ) -> Result<()> {
        let is_done: HashSet<(usize, usize)> =
            self.done.iter().map(|s| (s.point, s.number)).collect();
        let missing: Vec<(usize, usize)> = samples.filter(|id| !is_done.contains(id)).collect();
        let mut rest = &missing[..];
        while !rest.is_empty() {
            let threads = rayon::current_num_threads();
            // A block at a time is written, so that little is lost by a kill; the first one shows how long they take.
            let size = if self.forecast.is_some() {
                4 * threads
            } else {
                threads
            };
            let (block, more) = rest.split_at(size.min(rest.len()));
            let begin = Instant::now();
            let (pair, model) = (&self.pair, &self.model);
            let solved = block
                .par_iter()
                .map(|&(point, number)| setup.sample(pair, model, point, number));
            self.done.par_extend(solved);
            self.done
                .sort_by_key(|sample| (sample.point, sample.number));
            setup.write(&self.table, &self.done)?;
            self.show(block.len(), begin);
            rest = more;
        }
        Ok(())
    }

    /// Says after the first samples how long all will take, then how far they are.
    fn show(&mut self, solved: usize, begin: Instant) {
        let left = self.total.saturating_sub(self.done.len());
        let (since, before) = *self.forecast.get_or_insert_with(|| {
            let each = begin.elapsed() / solved as u32;
            let loads = match self.loads {
                1 => String::new(),
                loads => format!(" at {loads} torques"),
            };
            let most = if self.is_optimized { "at most " } else { "" };
            let words = format!(
                "{most}{left} of {} samples{loads} to solve, {:.2} s each: {}; Ctrl-C stops, the same command goes on",
                self.total,
                each.as_secs_f64(),
                about(each * left as u32)
            );
            self.job.note(&words);
            (begin, self.done.len() - solved)
        });
        let each = since.elapsed() / (self.done.len() - before).max(1) as u32;
        let left = about(each * left as u32);
        let share = self.done.len() as f64 / self.total as f64;
        self.job
            .show(&format!("samples, {left} left"), share.min(1.0));
    }

    /// Has the optimizer try at most `most` points with their `samples`, and returns whether they gathered in one place.
    fn optimize(&mut self, setup: &mut Setup, samples: usize, most: usize) -> Result<bool> {
        let axes = setup.plan.axes.clone();
        let has_ended = search::search(axes.len(), setup.seed, |shares| {
            let values = axes
                .iter()
                .zip(shares)
                .map(|(axis, share)| axis.at_share(*share));
            let values: Vec<f64> = values.collect();
            let tried = &mut setup.plan.tried;
            let known = tried.iter().position(|known| *known == values);
            let point = match known {
                Some(known) => known + 1,
                None if tried.len() == most => return Ok(None),
                None => {
                    tried.push(values);
                    tried.len()
                }
            };
            let mut known = self.done.iter().filter(|s| s.point == point);
            if known.any(|s| !setup.is_own(s)) {
                let table = self.table.display();
                refuse!(
                    "{table}: point {point} is not the one that the optimizer tries; begin anew with --restart"
                );
            }
            self.solve(setup, (0..=samples).map(|number| (point, number)))?;
            Ok(Some(setup.cost(&self.done, point)))
        })?;
        // Those of an earlier run that was allowed more count, too.
        for sample in self.done.iter().filter(|s| s.number == 0) {
            if sample.point == setup.plan.tried.len() + 1 {
                let values = setup.plan.axes_of(&sample.fields);
                setup.plan.tried.push(values);
            }
        }
        Ok(has_ended)
    }
}

/// Whether `summary` is there, of an earlier run of the study with this `identity`.
fn is_begun(summary: &Path, identity: &str) -> Result<bool> {
    if !summary.exists() {
        return Ok(false);
    }
    let path = summary.display();
    let found = serde_json::from_str(&output::read_text(summary)?);
    let found: serde_json::Value =
        found.map_err(|error| format!("{path}: {error}; begin anew with --restart"))?;
    if found["identity"] != identity {
        refuse!(
            "{path}: another study, with other fields, seed, pair or settings; name another folder, or begin anew with --restart"
        );
    }
    Ok(true)
}
