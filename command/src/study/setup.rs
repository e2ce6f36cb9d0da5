//! What a study varies and solves: its samples, which are kept on disk so that it goes on where it was stopped.

use std::path::Path;

use gearmesh::gear::Flank;
use gearmesh::words::{number, rounded, shown};
use gearmesh_preprocessor::contact::{CycleInput, ElasticModels, LoadCase, ModelSettings};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::pair::PairDraft;
use gearmesh_preprocessor::shaft::held_by_its_shafts;
use gearmesh_preprocessor::static_contact::ContactSolver;
use gearmesh_preprocessor::storage::csv_reader;

use super::judgement::{Best, Measure, Nearest, Requirement, Violations};
use super::variation::{Plan, Variation};
use crate::case::Case;
use crate::columns::{Column, columns, csv};
use crate::error::Result;
use crate::model::{Compliance, Fillets, Model};
use crate::statistics::{Outcome, Sample, Statistics};
use crate::{limits, output};

pub const FLANK: Flank = Flank::Drive;

pub const MOST_CYCLES: usize = 1_000_000;

/// What can be varied in addition to fields of the pair file.
const LOADS: &str = "torque_nm, misalignment_mrad or center_distance_offset_um";

/// What a study varies and solves, and how its points are judged.
pub struct Setup {
    pub draft: PairDraft,
    pub plan: Plan,
    pub torques: Vec<f64>,
    pub outcomes: Vec<Outcome>,
    pub measure: Measure,
    pub requirements: Vec<Requirement>,
    pub seed: u64,
    pub positions: usize,
    /// How teeth of another thickness than drawn are modelled: like the others, and not kept.
    pub own: ModelSettings,
    /// Whether the stress in their roots is solved.
    pub has_roots: bool,
}

/// Whether a load may have `value`; None where `field` is no load.
fn load_limit(field: &str, value: f64) -> Option<Result<f64, String>> {
    let range = match field {
        "torque_nm" => return Some(limits::check_torque(value)),
        "misalignment_mrad" => limits::MISALIGNMENTS,
        "center_distance_offset_um" => limits::CENTER_DISTANCE_OFFSETS,
        _ => return None,
    };
    Some(limits::check(Some(value), &range))
}

impl Setup {
    /// The pair file with the `values` of varied fields that differ from those as drawn, loads apart; at a `point` of its own also
    /// those of its axes that the file does not have.
    pub fn changed(&self, point: usize, values: &[f64]) -> Result<PairDraft> {
        let mut draft = self.draft.clone();
        for ((field, drawn), value) in self.plan.fields.iter().zip(values) {
            let is_changed = value != drawn || (point > 0 && self.plan.is_on_axis(field));
            if is_changed && load_limit(field, *value).is_none() {
                draft.set(field, *value)?;
            }
        }
        Ok(draft)
    }

    /// Refuses what is not there, what `pair` may not have, what changes the teeth or nothing, and more than can be solved,
    /// before anything is computed.
    pub fn check(&self, pair: &Pair, samples: usize, points: usize) -> Result<()> {
        let Setup { plan, torques, .. } = self;
        // Fields of the axes may need each other.
        let base = self.corner(|axis| axis.low)?;
        for variation in plan.all() {
            let field = &variation.field;
            let mut acts = false;
            let drawn = pair.microgeometry.flank(FLANK);
            for value in [variation.low, variation.high] {
                let mut changed = base.clone();
                for name in variation.fields() {
                    match load_limit(name, value) {
                        Some(load) => {
                            load.map_err(|e| format!("--vary {name} = {}: {e}", number(value)))?;
                            acts = true;
                        }
                        None => changed.set(name, value)?,
                    }
                }
                let found = changed.pair().map_err(|e| format!("--vary {field}: {e}"))?;
                if found.teeth != pair.teeth {
                    refuse!(
                        "--vary {field}: a study takes all teeth as alike, so that it would change nothing; vary what all teeth \
                         have, {LOADS}"
                    );
                }
                acts |= variation.is_thickness();
                if found.geometry != pair.geometry && !variation.is_thickness() {
                    refuse!(
                        "--vary {field}: it changes the teeth or where they stand, so that every sample needed an elastic model of \
                         its own; vary modifications, measures of the tooth thickness, backlash, {LOADS}"
                    );
                }
                acts |= found.microgeometry.flank(FLANK) != drawn || found.shafts != pair.shafts;
            }
            // At zero relief its start says nothing.
            let at_high = [variation.low, variation.high].map(|value| {
                let mut changed = self.corner(|axis| axis.high).ok()?;
                let mut fields = variation.fields();
                fields.try_for_each(|name| changed.set(name, value)).ok()?;
                let found = changed.pair().ok()?;
                Some((found.microgeometry.flank(FLANK).clone(), found.shafts))
            });
            acts |= matches!(&at_high, [Some(low), Some(high)] if low != high);
            if !acts {
                refuse!(
                    "--vary {field}: no result of a study depends on it, which takes the drive flank at the torque, misalignment \
                     and centre distance of the command line; vary modifications of that flank, {LOADS}"
                );
            }
        }
        if (plan.axes.iter()).any(|axis| axis.fields().any(|field| field == "torque_nm")) {
            refuse!(
                "--vary = torque_nm on a grid or to optimize: torques have no best; give them as --torques-nm"
            );
        }
        if plan.is_varied("torque_nm") && torques.len() > 1 {
            refuse!(
                "--torques-nm: torque_nm is varied, too; give one torque, or vary something else"
            );
        }
        let factors = [points, samples].map(|count| count.saturating_add(1));
        let factors = factors.into_iter().chain([torques.len()]);
        let count = factors.fold(1, usize::saturating_mul);
        if let Err(e) = limits::check(Some(count), &(1..=MOST_CYCLES)) {
            refuse!("points times samples times torques = {count}: {e}");
        }
        Ok(())
    }

    /// Sample `number` (0: the point itself) at `point` (0: as drawn).
    pub fn sample(&self, pair: &Pair, model: &Model, point: usize, number: usize) -> Sample {
        let fields = self.plan.values(point, number, self.seed);
        let outcome = self.solve(pair, model, point, &fields);
        Sample {
            point,
            number,
            outcome: outcome.map_err(|error| error.to_string()),
            fields,
        }
    }

    /// The pair file at this `end` of all axes.
    fn corner(&self, end: fn(&Variation) -> f64) -> Result<PairDraft> {
        let values: Vec<f64> = self.plan.axes.iter().map(end).collect();
        self.changed(values.len(), &self.plan.placed(&values))
    }

    /// The outcomes at each torque of `pair`, whose operating range is widened to what is varied, with the `values` of the fields.
    fn solve(
        &self,
        pair: &Pair,
        model: &Model,
        point: usize,
        values: &[f64],
    ) -> Result<Vec<Vec<f64>>> {
        let load = |name: &str| {
            let index = self.plan.fields.iter().position(|(field, _)| field == name);
            index.map(|k| values[k])
        };
        let misalignment = 1e-3 * load("misalignment_mrad").unwrap_or(0.0);
        let torque = load("torque_nm").map(|torque| vec![torque]);
        let loads = LoadCase::matrix(&torque.unwrap_or(self.torques.clone()), &[misalignment]);
        let input = CycleInput {
            flank: FLANK,
            center_distance_offset: 1e-6 * load("center_distance_offset_um").unwrap_or(0.0),
            positions: self.positions,
        };
        let mut changed = self.changed(point, values)?.pair()?;
        if pair.shafts.iter().all(Option::is_none) {
            changed.shafts = [None, None];
        }
        let changed = held_by_its_shafts(&changed);
        let pair = Pair {
            microgeometry: changed.microgeometry,
            shafts: changed.shafts,
            geometry: changed.geometry,
            ..pair.clone()
        };
        // Teeth of another thickness deflect differently.
        let own = match pair.geometry == *model.solver.geometry() {
            true => None,
            false => Some(self.own_models(&pair)?),
        };
        let (compliance, fillets) = match &own {
            Some((compliance, fillets)) => (compliance, fillets),
            None => (&model.compliance, &model.fillets),
        };
        let solver = ContactSolver::new(&pair, compliance.clone(), *model.solver.settings())?;
        let cases = Case::solve_all(
            (&solver, &pair.shafts),
            fillets.as_ref(),
            &input,
            &loads,
            &|_| (),
        )?;
        Ok(cases
            .iter()
            .map(|case| {
                let values = self.outcomes.iter().map(|outcome| outcome.number(case));
                values.map(|v| v.map_or(f64::NAN, rounded)).collect()
            })
            .collect())
    }

    /// Elastic models for one sample, whose teeth are those of `pair`.
    fn own_models(&self, pair: &Pair) -> Result<(Compliance, Option<Fillets>)> {
        let models = ElasticModels::new(pair, &self.own, &|_, _| ())?;
        let roots = self
            .has_roots
            .then(|| self.own.root_models(pair, FLANK, &|_, _| ()));
        let fillets = roots.transpose()?.map(|roots| Fillets {
            maps: roots.maps,
            effort: String::new(),
        });
        Ok((models.compliance, fillets))
    }

    /// Statistics of every result at every torque over the samples of `point` that were solved; where none is drawn, of the
    /// point itself.
    pub fn spread(&self, done: &[Sample], point: usize) -> Result<Vec<Statistics>> {
        let all: Vec<&Sample> = done.iter().filter(|s| s.point == point).collect();
        let drawn = all.iter().find(|s| s.number == 0);
        let drawn = drawn.ok_or("the pair as drawn was not solved; begin anew with --restart")?;
        if let Err(error) = &drawn.outcome {
            refuse!("the pair as drawn: {error}");
        }
        let is_drawn = all.iter().any(|s| s.number > 0);
        let mut solved = all.clone();
        solved.retain(|s| s.outcome.is_ok() && (s.number > 0) == is_drawn);
        if solved.is_empty() {
            refuse!("no sample could be solved; samples.csv says why");
        }
        let mut statistics = Vec::new();
        for (t, &torque) in self.torques.iter().enumerate() {
            for (k, Outcome { name, .. }) in self.outcomes.iter().enumerate() {
                statistics.push(Statistics::new(name, k, (t, torque), drawn, &solved));
            }
        }
        Ok(statistics)
    }

    /// Number, fields, results, and what went wrong if something did.
    fn columns<'s>(&self) -> Vec<Column<'_, (usize, &'s Sample)>> {
        let mut all = columns! { |(_, s): &(usize, &Sample)|
            "point" => s.point;
            "sample" => s.number;
        };
        if self.plan.axes.is_empty() {
            all.remove(0);
        }
        if !self.plan.is_varied("torque_nm") {
            all.extend(columns! { |(t, _): &(usize, &Sample)| "torque_nm" => self.torques[*t]; });
        }
        for (k, (field, _)) in self.plan.fields.iter().enumerate() {
            all.extend(columns! { |(_, s): &(usize, &Sample)| field => s.fields[k]; });
        }
        for (k, Outcome { name, .. }) in self.outcomes.iter().enumerate() {
            all.extend(columns! { |(t, s): &(usize, &Sample)| name => s.result(*t, k); });
        }
        all.extend(columns! { |(_, s): &(usize, &Sample)|
            "violates" => self.violated(s);
            "error" => s.outcome.as_ref().err().cloned();
        });
        all
    }

    /// The requirements that `sample` violates at any torque, with semicolons between them.
    fn violated(&self, sample: &Sample) -> String {
        let violated = self
            .requirements
            .iter()
            .filter(|r| r.missed(sample).is_some());
        violated
            .map(Requirement::words)
            .collect::<Vec<_>>()
            .join("; ")
    }

    /// The result that the measure takes.
    pub fn measured(&self) -> &str {
        &self.outcomes[self.measure.result].name
    }

    /// How many of the solved samples of `point` violate each requirement.
    pub fn violations(&self, done: &[Sample], point: usize) -> Vec<Violations> {
        let samples = done.iter().filter(|s| s.point == point);
        let solved: Vec<&Sample> = samples.filter(|s| s.outcome.is_ok()).collect();
        let violating = self.requirements.iter().map(|requirement| Violations {
            point,
            requirement: requirement.words(),
            samples: solved.len(),
            violated: (solved.iter().filter(|s| requirement.missed(s).is_some())).count(),
        });
        violating.collect()
    }

    /// By how much `point` misses the requirements together; None where it meets them all.
    fn missed(&self, done: &[Sample], point: usize) -> Option<f64> {
        self.requirements
            .iter()
            .filter_map(|requirement| {
                let samples = self.measure.counting(done, point);
                samples
                    .filter_map(|s| requirement.missed(s))
                    .reduce(f64::max)
            })
            .reduce(|a, b| a + b)
    }

    /// The measure of the pair as drawn where it meets all requirements and that is below `value`.
    pub fn drawn_below(&self, done: &[Sample], value: f64) -> Option<f64> {
        let drawn = self.measure.of(done, 0)?;
        (drawn < value && self.missed(done, 0).is_none()).then_some(drawn)
    }

    /// What the optimizer makes least at `point`: from 0 to 1 the measure where the point meets all requirements, from 1 to 2
    /// by how much it misses them, 2 where it was refused. Only the order of points counts (Deb, Computer Methods in Applied
    /// Mechanics and Engineering 186 (2000) 311-338).
    pub fn cost(&self, done: &[Sample], point: usize) -> f64 {
        let Some(measure) = self.measure.of(done, point) else {
            return 2.0;
        };
        let scale = self
            .measure
            .of(done, 0)
            .filter(|drawn| *drawn > 0.0)
            .unwrap_or(1.0);
        match self.missed(done, point) {
            None => measure / (measure + scale),
            Some(missed) if missed.is_finite() => 1.0 + missed / (1.0 + missed),
            Some(_) => 2.0,
        }
    }

    pub fn write(&self, path: &Path, samples: &[Sample]) -> Result<()> {
        let table = csv(&[], &self.columns(), samples, |sample| {
            (0..self.torques.len()).map(move |t| (t, sample))
        })?;
        output::write_whole(path, &table)
    }

    /// The samples that are there, none if there is no such file; one of another form is refused.
    pub fn read(&self, path: &Path) -> Result<Vec<Sample>> {
        if !path.exists() {
            return Ok(Vec::new());
        }
        let text = output::read_text(path)?;
        let mut reader = csv_reader(&text);
        let columns = self.columns();
        let header = reader
            .headers()
            .map_err(|error| unusable(path, &error.to_string()))?;
        let names: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
        if header != names {
            return Err(unusable(path, "columns of another study").into());
        }
        let last = columns.len() - 1;
        // Before it stands what a sample violates, which follows from its results.
        let judged = last - 1;
        let results = judged - self.outcomes.len();
        let fields = results - self.plan.fields.len();
        let ids = if self.plan.axes.is_empty() { 1 } else { 2 };
        let mut samples: Vec<Sample> = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| unusable(path, &error.to_string()))?;
            let row = Row {
                path,
                names: &names,
                record: &record,
            };
            let error = &record[last];
            let number_of = ids - 1;
            let point = if ids == 2 { row.whole(0)? } else { 0 };
            let sample = row.whole(number_of)?;
            let numbers = (fields..judged).map(|k| match record[k].is_empty() {
                // A refused sample has no results.
                true if k >= results && !error.is_empty() => Ok(f64::NAN),
                _ => row.number(k),
            });
            let numbers: Vec<f64> = numbers.collect::<Result<_>>()?;
            let (values, found) = numbers.split_at(results - fields);
            match samples.last_mut() {
                // Another torque of the same sample.
                Some(s) if (s.point, s.number) == (point, sample) => {
                    s.outcome.iter_mut().for_each(|all| all.push(found.into()));
                }
                _ => samples.push(Sample {
                    point,
                    number: sample,
                    fields: values.into(),
                    outcome: match error {
                        "" => Ok(vec![found.into()]),
                        error => Err(error.into()),
                    },
                }),
            }
            let rows = samples
                .last()
                .and_then(|s| s.outcome.as_ref().ok())
                .map_or(1, Vec::len);
            if rows > self.torques.len() {
                let what = "stands in more rows than there are torques";
                return Err(row.refused(number_of, what).into());
            }
        }
        let torques = self.torques.len();
        if let Some(s) = samples
            .iter()
            .find(|s| s.outcome.as_ref().is_ok_and(|all| all.len() < torques))
        {
            let (point, sample) = (s.point, s.number);
            let what = format!(
                "sample {sample} of point {point} has fewer rows than the {torques} torques"
            );
            return Err(unusable(path, &what).into());
        }
        // Points of the optimizer are known when it tries them.
        let is_known = |s: &&Sample| s.point == 0 || !self.plan.is_optimized();
        if let Some(s) = samples.iter().filter(is_known).find(|s| !self.is_own(s)) {
            let (point, sample) = (s.point, s.number);
            let what = format!("sample {sample} of point {point} has values of another study");
            return Err(unusable(path, &what).into());
        }
        Ok(samples)
    }

    /// Whether the fields of `sample`, of a point that is known, have the values of this study.
    pub fn is_own(&self, sample: &Sample) -> bool {
        let Sample { point, number, .. } = *sample;
        point <= self.plan.points() && sample.fields == self.plan.values(point, number, self.seed)
    }

    /// The points that have a measure and meet all requirements, best first.
    pub fn ranking(&self, done: &[Sample]) -> Vec<(usize, f64)> {
        let mut all: Vec<_> = (1..=self.plan.points())
            .filter_map(|point| {
                let value = self.measure.of(done, point)?;
                self.missed(done, point).is_none().then_some((point, value))
            })
            .collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    }

    /// The solved point that misses the requirements by least.
    pub fn nearest(&self, done: &[Sample]) -> Option<Nearest> {
        let points = (1..=self.plan.points()).filter_map(|point| {
            self.measure.of(done, point)?;
            Some((point, self.missed(done, point)?))
        });
        let (point, _) = points.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut violated = Vec::new();
        for requirement in &self.requirements {
            let mut samples = self.measure.counting(done, point);
            if samples.any(|s| requirement.missed(s).is_some()) {
                violated.push(requirement.words());
            }
        }
        let violates = violated.join(" and ");
        Some(Nearest { point, violates })
    }

    /// The best point; None where there is no axis, or where no point meets the requirements; that none could be solved is
    /// refused.
    pub fn best(&self, done: &[Sample]) -> Result<Option<Best>> {
        let Setup { plan, measure, .. } = self;
        if plan.axes.is_empty() {
            return Ok(None);
        }
        let Some(&(point, value)) = self.ranking(done).first() else {
            if self.nearest(done).is_some() {
                return Ok(None);
            }
            refuse!("no point could be solved; samples.csv says why");
        };
        let fields = plan.fields.iter().map(|(field, _)| field.clone());
        Ok(Some(Best {
            point,
            measure: measure.words.clone(),
            value,
            as_drawn: measure.of(done, 0),
            fields: fields.zip(plan.values(point, 0, 0)).collect(),
        }))
    }
}

/// A row of the file of samples.
struct Row<'a> {
    path: &'a Path,
    /// Those of the columns.
    names: &'a [&'a str],
    record: &'a csv::StringRecord,
}

impl Row<'_> {
    fn refused(&self, k: usize, what: &str) -> String {
        let line = self.record.position().map_or(0, csv::Position::line);
        let (name, text) = (self.names[k], shown(&self.record[k]));
        unusable(self.path, &format!("line {line}: {name} = {text}: {what}"))
    }

    fn whole(&self, k: usize) -> Result<usize> {
        let whole = self.record[k].parse();
        whole.map_err(|_| self.refused(k, "not a whole number").into())
    }

    fn number(&self, k: usize) -> Result<f64> {
        let value = self.record[k].parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| self.refused(k, "not a finite number").into())
    }
}

fn unusable(path: &Path, what: &str) -> String {
    let path = path.display();
    format!("{path}: {what}; name another folder, or begin anew with --restart")
}
