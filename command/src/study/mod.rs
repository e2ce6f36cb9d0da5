//! `gearmesh study PAIR.json`: what tolerances do to transmission error, pressure and root stress.

mod samples;
mod show;
mod statistics;
mod variation;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use gearmesh::contact::ContactSolver;
use gearmesh::gear::{Flank, tolerance};
use gearmesh::pair::Pair;
use gearmesh::words::{hex, number, rounded};
use gearmesh_preprocessor::contact::{CycleInput, MeshCycle};
use gearmesh_preprocessor::pair::{self, PairDraft};
use rayon::prelude::*;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::Error;
use crate::case::Case;
use crate::limits;
use crate::model::{Fillets, Model, ModelArgs, widen};
use crate::output;
use samples::{Sample, outcomes};
use statistics::Statistics;
use variation::{Requested, Variation};

const FLANK: Flank = Flank::Drive;

const MOST_SAMPLES: usize = 1_000_000;

/// What can be varied beside fields of the pair file.
const LOADS: &str = "torque_nm, misalignment_mrad or center_distance_offset_um";

/// Draw samples of a pair within its tolerances and solve the mesh cycle of each.
///
/// Every sample is the same in every run with the same seed. A study that was stopped goes on where it was when it is
/// started again.
#[derive(Debug, Args)]
pub struct Study {
    /// Pair file
    pair: PathBuf,

    /// Field of the pair file, or torque_nm, misalignment_mrad or center_distance_offset_um, and the interval in which
    /// it is drawn: FIELD=LOW..HIGH, or FIELD=+-TOLERANCE about the value in the file; repeatable
    #[arg(long, value_name = "FIELD=INTERVAL")]
    vary: Vec<Requested>,

    /// Tolerance class of ISO 1328-1:2013, 1 to 11: profile slope and helix slope of both gears are drawn within its
    /// f_HaT and f_HbT about the values in the file
    #[arg(long, value_name = "CLASS", value_parser = class)]
    iso_1328_class: Option<u8>,

    /// Number of samples
    #[arg(long, default_value_t = 500, value_parser = limits::within(1..=MOST_SAMPLES))]
    samples: usize,

    /// Another seed draws other samples
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Torque on gear 1, N m, where it is not varied [default: the pair's nominal torque]
    #[arg(long, value_parser = limits::torque)]
    torque_nm: Option<f64>,

    /// Number of positions over the mesh cycle; its first harmonic takes three
    #[arg(long, default_value_t = 32, value_parser = limits::within(3..=limits::MOST_POSITIONS))]
    positions: usize,

    /// The largest root stress of both gears, too; its elastic model takes two to three times as long as that of the
    /// contact
    #[arg(long, conflicts_with = "plane_strain")]
    root_stress: bool,

    /// Folder for samples.csv, study.json and study.html; it is made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Leave out what the folder holds of an earlier run
    #[arg(long)]
    restart: bool,

    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Debug, Serialize)]
struct Summary<'a> {
    pair: &'a str,
    /// Of everything that the samples depend on.
    identity: &'a str,
    seed: u64,
    distribution: &'static str,
    varied: &'a [Variation],
    samples: usize,
    refused: usize,
    statistics: Vec<Statistics>,
    /// What is to be known of the results, one sentence each; empty where there is nothing.
    notes: Vec<&'static str>,
}

/// Everything that solving a sample takes.
struct Bench<'a> {
    draft: PairDraft,
    /// The pair as drawn, its operating range widened to what is varied.
    pair: Pair,
    model: Model,
    /// For the stress in the roots, where it is asked for.
    fillets: Option<Fillets>,
    variations: &'a [Variation],
    torque: f64,
    positions: usize,
}

/// A tolerance class of ISO 1328-1.
fn class(text: &str) -> Result<u8, String> {
    let class = text.parse().ok().filter(|c| tolerance::CLASSES.contains(c));
    class.ok_or_else(|| "give a class from 1 to 11, a bare number".into())
}

impl Study {
    pub fn run(self) -> Result<(), Error> {
        let draft = PairDraft::read(&self.pair)?;
        let mut pair = self.model.applied_to(draft.pair()?);
        let torque = self.torque_nm.unwrap_or(pair.operating.nominal_torque);
        let variations = Variation::all(&self.vary, self.iso_1328_class, &draft, &pair, torque)?;
        for variation in &variations {
            check(variation, &draft, &pair)?;
        }
        let range = |field: &str, unit: f64, drawn: f64| {
            let varied = variations.iter().find(|v| v.field == field);
            varied.map_or([drawn; 2], |v| [v.low * unit, v.high * unit])
        };
        widen(
            &mut pair,
            torque.max(range("torque_nm", 1.0, torque)[1]),
            range("misalignment_mrad", 1e-3, 0.0),
            range("center_distance_offset_um", 1e-6, 0.0),
        );

        output::make_folder("--output", &self.output)?;
        let [table, summary, page] =
            ["samples.csv", "study.json", "study.html"].map(|name| self.output.join(name));
        for path in [&table, &summary, &page] {
            output::check_writable(path, [&self.pair])?;
        }
        let identity = self.identity(&pair, &variations, torque);
        let outcomes = outcomes(self.root_stress);
        let mut done = Vec::new();
        if !self.restart && is_begun(&summary, &identity)? {
            done = samples::read(&table, &variations, &outcomes)?;
        }
        // More samples than asked for now stay in the table.
        let missing: Vec<usize> = (0..=self.samples)
            .filter(|n| !done.iter().any(|sample| sample.number == *n))
            .collect();
        let name = pair.name.clone();
        let mut all = Summary {
            pair: &name,
            identity: &identity,
            seed: self.seed,
            distribution: "even",
            varied: &variations,
            samples: self.samples,
            refused: 0,
            statistics: Vec::new(),
            notes: pair::note_on_teeth(&pair.teeth).into_iter().collect(),
        };
        write_json(&summary, &all)?;

        self.model.use_threads()?;
        let job = self.model.job();
        let bench = Bench {
            model: self.model.solver(&pair, &job)?,
            fillets: match self.root_stress {
                true => Some(self.model.fillets(&pair, FLANK, &job)?),
                false => None,
            },
            draft,
            pair,
            variations: &variations,
            torque,
            positions: self.positions,
        };
        let finished = AtomicUsize::new(0);
        // A block at a time is written, so that little is lost by a kill.
        for block in missing.chunks(4 * rayon::current_num_threads()) {
            let solved = block.par_iter().map(|&number| {
                let sample = bench.sample(number, self.seed);
                let count = finished.fetch_add(1, Ordering::Relaxed) + 1;
                job.tell("samples", count as f64 / missing.len() as f64);
                sample
            });
            done.par_extend(solved);
            done.sort_by_key(|sample| sample.number);
            samples::write(&table, &variations, &outcomes, &done)?;
        }
        drop(job);

        let names = outcomes.iter().map(|outcome| &outcome.name);
        all.statistics = spread(&done, names)?;
        all.samples = done.len() - 1;
        all.refused = done.iter().filter(|s| s.outcome.is_err()).count();
        write_json(&summary, &all)?;
        let text = show::text(&bench, self.seed, &done, &outcomes, &all.statistics);
        let html = show::page(&name, &text, &outcomes, &done)?;
        output::write_whole(&page, html.as_bytes())?;
        output::print(&text)?;
        Ok(())
    }

    /// Hash of everything that the samples depend on.
    fn identity(&self, pair: &Pair, variations: &[Variation], torque: f64) -> String {
        let all = format!(
            "{} {pair:?} {variations:?} {} {} {torque} {:?}",
            env!("CARGO_PKG_VERSION"),
            self.seed,
            self.positions,
            self.model.contact_settings(pair)
        );
        let roots = if self.root_stress { " root stress" } else { "" };
        let plane = self.model.is_plane_strain();
        hex(&Sha256::digest(format!("{all} {plane}{roots}"))[..16])
    }
}

/// Whether `summary` is there, of an earlier run of the study with this `identity`.
fn is_begun(summary: &Path, identity: &str) -> Result<bool, Error> {
    if !summary.exists() {
        return Ok(false);
    }
    let place = summary.display();
    let found: serde_json::Value = serde_json::from_str(&output::read_text(summary)?)
        .map_err(|error| format!("{place}: {error}; begin anew with --restart"))?;
    if found["identity"] != identity {
        return Err(format!(
            "{place}: another study, with other fields, seed, pair or settings; name another folder, or begin anew with \
             --restart"
        )
        .into());
    }
    Ok(true)
}

fn write_json(path: &Path, summary: &Summary) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(summary)? + "\n";
    Ok(output::write_whole(path, text.as_bytes())?)
}

/// Refuses a field that there is not, values that the pair file may not have, and what changes the teeth
/// themselves, before anything is computed.
fn check(variation: &Variation, draft: &PairDraft, pair: &Pair) -> Result<(), Error> {
    let field = &variation.field;
    let mut acts = false;
    for value in [variation.low, variation.high] {
        let load = match field.as_str() {
            "torque_nm" => Some(limits::check_torque(value)),
            "misalignment_mrad" => Some(limits::check(Some(value), &limits::MISALIGNMENTS)),
            "center_distance_offset_um" => {
                Some(limits::check(Some(value), &limits::CENTER_DISTANCE_OFFSETS))
            }
            _ => None,
        };
        if let Some(load) = load {
            load.map_err(|error| format!("--vary {field} = {}: {error}", number(value)))?;
            acts = true;
            continue;
        }
        let mut changed = draft.clone();
        changed.set(field, value)?;
        let found = (changed.pair()).map_err(|error| format!("--vary {field}: {error}"))?;
        let vain = if found.teeth != pair.teeth {
            "a study takes all teeth as alike, so that it would change nothing; vary what all teeth have"
        } else if found.geometry != pair.geometry {
            "it changes the teeth or where they stand, so that every sample needed an elastic model of its own; vary modifications"
        } else {
            acts |= found.microgeometry.flank(FLANK) != pair.microgeometry.flank(FLANK);
            continue;
        };
        return Err(format!("--vary {field}: {vain}, {LOADS}").into());
    }
    if !acts {
        return Err(format!(
            "--vary {field}: no result of a study depends on it, which takes the drive flank at the torque, misalignment and \
             centre distance of the command line; vary modifications of that flank, {LOADS}"
        )
        .into());
    }
    Ok(())
}

impl Bench<'_> {
    /// Sample `number`; 0 is the pair as drawn.
    fn sample(&self, number: usize, seed: u64) -> Sample {
        let fields = match number {
            0 => {
                let drawn = |v: &Variation| match v.field.as_str() {
                    "torque_nm" => self.torque,
                    field => self.draft.number(field).unwrap_or(0.0),
                };
                self.variations.iter().map(drawn).collect()
            }
            number => variation::draw(self.variations, seed, number),
        };
        Sample {
            number,
            outcome: self.solve(&fields).map_err(|error| error.to_string()),
            fields,
        }
    }

    fn solve(&self, fields: &[f64]) -> Result<Vec<f64>, Error> {
        let mut input = CycleInput {
            flank: FLANK,
            torque: self.torque,
            center_distance_offset: 0.0,
            misalignment: 0.0,
            positions: self.positions,
        };
        let mut draft = self.draft.clone();
        for (v, value) in self.variations.iter().zip(fields) {
            match v.field.as_str() {
                "torque_nm" => input.torque = *value,
                "misalignment_mrad" => input.misalignment = value * 1e-3,
                "center_distance_offset_um" => input.center_distance_offset = value * 1e-6,
                field => draft.set(field, *value)?,
            }
        }
        let pair = Pair {
            microgeometry: draft.pair()?.microgeometry,
            ..self.pair.clone()
        };
        let compliance = self.model.compliance.clone();
        let solver = ContactSolver::new(&pair, compliance, *self.model.solver.settings())?;
        let mut case = Case {
            cycle: MeshCycle::solve(&solver, &input)?,
            input,
            roots: None,
        };
        case.solve_roots(&solver, self.fillets.as_ref())?;
        let outcomes = outcomes(self.fillets.is_some());
        let results = outcomes
            .iter()
            .map(|outcome| (outcome.value)(&(&solver, &case)).as_f64());
        Ok(results
            .map(|result| result.map_or(f64::NAN, rounded))
            .collect())
    }
}

/// Statistics of every result, called `names`, over the samples that were solved.
fn spread<'n>(
    done: &[Sample],
    names: impl Iterator<Item = &'n String>,
) -> Result<Vec<Statistics>, Error> {
    let drawn = done.iter().find(|s| s.number == 0);
    let drawn = drawn.ok_or("the pair as drawn was not solved; begin anew with --restart")?;
    if let Err(error) = &drawn.outcome {
        return Err(format!("the pair as drawn: {error}").into());
    }
    let solved = done.iter().filter(|s| s.number > 0 && s.outcome.is_ok());
    let solved: Vec<&Sample> = solved.collect();
    if solved.is_empty() {
        return Err("no sample could be solved; samples.csv says why".into());
    }
    let statistics = |(k, name): (usize, &String)| Statistics::new(name, k, drawn, &solved);
    Ok(names.enumerate().map(statistics).collect())
}
