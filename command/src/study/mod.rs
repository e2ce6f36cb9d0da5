//! `gearmesh study PAIR.json`: what modifications and tolerances do to transmission error, pressure and root stress.

mod setup;
mod show;
mod statistics;
mod variation;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use gearmesh::gear::tolerance;
use gearmesh::pair::Pair;
use gearmesh::words::hex;
use gearmesh_preprocessor::pair::{self, PairDraft};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use crate::error::Result;
use crate::model::{ModelArgs, ShaftArgs, widen};
use crate::page::origin;
use crate::{limits, output};
use setup::{FLANK, MOST_CYCLES, Setup};
use show::Summary;
pub use show::bands_of;
use statistics::{BestArgs, outcomes};
use variation::{Plan, Requested};

/// Solve the mesh cycle of a pair on a grid of modifications, and of samples within tolerances.
///
/// A grid has every combination of its values, and its best point is written as a pair file. A study that was stopped goes on
/// where it was when it is started again.
#[derive(Debug, Args)]
pub struct Study {
    /// Pair file
    pair: PathBuf,

    /// Field of the pair file, or torque_nm, misalignment_mrad or center_distance_offset_um, and its values; repeatable.
    /// FIELD=LOW..HIGH/POINTS: on a grid, several fields with commas between them share a value. FIELD=LOW..HIGH: drawn in
    /// that interval. FIELD=+-TOLERANCE: drawn about the value in the file, or about that of the grid
    #[arg(long, value_name = "FIELD=VALUES", value_parser = Requested::parse)]
    vary: Vec<Requested>,

    /// Tolerance class of ISO 1328-1:2013, 1 to 11: profile and helix slope of both gears are drawn within its f_HaT and f_HbT, times cos beta_b
    #[arg(long, value_name = "CLASS", value_parser = class)]
    iso_1328_class: Option<u8>,

    /// Number of samples of what is drawn [default: 500; on a grid 20 for each point]
    #[arg(long, value_parser = limits::within(1..=MOST_CYCLES))]
    samples: Option<usize>,

    /// Another seed draws other samples
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

    /// Folder for samples.csv, study.json, study.html, its charts, and of a grid best.json; it is made if it is not there
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
    pub fn run(self) -> Result<()> {
        let draft = PairDraft::read(&self.pair)?;
        let origin = origin(&self.pair)?;
        let drawn = self.model.applied_to(draft.pair()?);
        let mut pair = self.shafts.applied_to(drawn.clone());
        let mut torques = self.torques_nm.clone();
        if torques.is_empty() {
            torques.push(pair.operating.nominal_torque);
        }
        let plan = Plan::new(&self.vary, self.iso_1328_class, &draft, &pair, torques[0])?;
        let samples = match (plan.drawn.is_empty(), self.samples) {
            (true, _) => 0,
            (_, Some(samples)) => samples,
            _ if plan.grid.is_empty() => 500,
            _ => 20,
        };
        let outcomes = outcomes(self.model.root_stress);
        let setup = Setup {
            measure: self.best.measure(&outcomes, &torques)?,
            draft,
            plan,
            torques,
            outcomes,
            seed: self.seed,
            positions: self.positions,
        };
        setup.check(&drawn, samples)?;
        let Setup { plan, torques, .. } = &setup;
        let range = |field: &str, unit: f64| {
            let varied = plan.all().filter(|v| v.fields().any(|f| f == field));
            let ends = varied.map(|v| [v.low, v.high].map(|end| end * unit));
            let wider = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [low.min(a), high.max(b)];
            ends.fold([0.0; 2], wider)
        };
        let tilts = range("misalignment_mrad", 1e-3);
        let offsets = range("center_distance_offset_um", 1e-6);
        let [_, largest] = range("torque_nm", 1.0);
        for torque in torques.iter().copied().chain([largest]) {
            widen(&mut pair, torque, tilts, offsets);
        }

        output::make_folder("--output", &self.output)?;
        let names = ["samples.csv", "study.json", "study.html", "best.json"];
        let [table, summary, page, best] = names.map(|name| self.output.join(name));
        for path in [&table, &summary, &page, &best] {
            output::check_writable(path, [&self.pair])?;
        }
        let identity = self.identity(&pair, &setup);
        let done = match !self.restart && is_begun(&summary, &identity)? {
            true => setup.read(&table)?,
            false => Vec::new(),
        };
        // More samples than requested now stay in the table.
        let all = (0..=plan.points()).flat_map(|p| (0..=samples).map(move |number| (p, number)));
        let is_missing = |id: &(usize, usize)| done.iter().all(|s| (s.point, s.number) != *id);
        let missing: Vec<(usize, usize)> = all.filter(is_missing).collect();
        let name = pair.name.clone();
        let mut all = Summary {
            setup: &setup,
            done,
            pair: &name,
            identity: &identity,
            seed: self.seed,
            distribution: "even",
            varied: plan.all().collect(),
            torques_nm: torques,
            samples,
            refused: 0,
            best: None,
            statistics: Vec::new(),
            notes: pair::note_on_teeth(&pair.teeth).into_iter().collect(),
        };
        all.write(&summary)?;

        let job = self.model.start()?;
        let roots = self.model.root_stress.then_some(FLANK);
        let model = self.model.model(&pair, roots, &job)?;
        let finished = AtomicUsize::new(0);
        // A block at a time is written, so that little is lost by a kill.
        for block in missing.chunks(4 * rayon::current_num_threads()) {
            let solved = block.par_iter().map(|&(point, number)| {
                let sample = setup.sample(&pair, &model, point, number);
                let count = finished.fetch_add(1, Ordering::Relaxed) + 1;
                job.show("samples", count as f64 / missing.len() as f64);
                sample
            });
            all.done.par_extend(solved);
            all.done.sort_by_key(|sample| (sample.point, sample.number));
            setup.write(&table, &all.done)?;
        }
        drop(job);

        let done = &all.done;
        all.best = setup.best(done)?;
        all.statistics.extend(setup.spread(done, 0)?);
        if let Some(found) = &all.best {
            all.statistics.extend(setup.spread(done, found.point)?);
            let mut draft = setup.changed(&plan.values(found.point, 0, self.seed))?;
            draft.rename(&format!("{name}-best"));
            output::write_whole(&best, draft.to_json().as_bytes())?;
        }
        all.refused = done.iter().filter(|s| s.outcome.is_err()).count();
        all.samples = done.iter().map(|s| s.number).max().unwrap_or(0);
        all.write(&summary)?;
        let text = all.text();
        let figures = self.output.join("figures");
        output::make_folder("--output", &figures)?;
        all.page(&text, origin).write(&page, Some(&figures))?;
        output::print(&text)
    }

    fn identity(&self, pair: &Pair, Setup { plan, torques, .. }: &Setup) -> String {
        let (seed, positions, args) = (self.seed, self.positions, &self.model);
        let (settings, plane_strain) = (args.settings().contact(pair), args.plane_strain);
        let roots = if args.root_stress { " root stress" } else { "" };
        let version = env!("CARGO_PKG_VERSION");
        let all = format!(
            "{version} {pair:?} {plan:?} {seed} {positions} {torques:?} {settings:?} {plane_strain}{roots}"
        );
        hex(&Sha256::digest(all)[..16])
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
