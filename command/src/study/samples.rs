//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use super::variation::Plan;
use crate::Error;
use crate::case::Case;
use crate::columns::{Column, columns, csv};
use crate::output;

/// A result of a mesh cycle: in samples.csv; with a head also in correlations and charts.
pub type Outcome<'r> = Column<'static, &'r Case>;

/// The results of a sample at a torque, the last two only with `root_stress`.
pub fn outcomes<'r>(root_stress: bool) -> Vec<Outcome<'r>> {
    let mut all = columns! { |c: &&Case|
        "peak_to_peak_ste_loa_um", ["p-p STE", "um", None] => 1e6 * c.cycle.peak_to_peak_ste();
        "mean_ste_loa_um" => 1e6 * c.cycle.mean_ste();
        "harmonic_1_loa_um", ["1st harm.", "um", None] => c.cycle.harmonics()[0].map(|h| 1e6 * h.amplitude);
        "maximum_pressure_mpa", ["pressure", "MPa", None] => 1e-6 * c.cycle.max_pressure();
        "edge_line_load_n_per_mm" => c.cycle.edge_load().map_or(0.0, |edge| 1e-3 * edge.line_load);
        "face_load_factor", ["K_Hbeta", "", None] => c.face_load.face_load_factor();
        "root_stress_1_mpa", ["root 1", "MPa", None] => c.root_stress(0);
        "root_stress_2_mpa", ["root 2", "MPa", None] => c.root_stress(1);
    };
    all.truncate(if root_stress { 8 } else { 6 });
    all
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Of the grid, from 1 on; 0: the pair as drawn.
    pub point: usize,
    /// From 1 on; 0: the point itself.
    pub number: usize,
    pub fields: Vec<f64>,
    /// Those of [`outcomes`] at each torque, or why there are none.
    pub outcome: Result<Vec<Vec<f64>>, String>,
}

impl Sample {
    /// Result `k` of [`outcomes`] at torque `t`.
    pub fn result(&self, t: usize, k: usize) -> Option<f64> {
        Some(self.outcome.as_ref().ok()?[t][k])
    }
}

/// The table of samples: a row for each and each torque.
pub struct Table<'a> {
    pub path: &'a Path,
    pub plan: &'a Plan,
    pub torques: &'a [f64],
    pub outcomes: &'a [Outcome<'static>],
}

impl Table<'_> {
    /// Number, fields, results, and what went wrong if something did.
    fn columns<'s>(&self) -> Vec<Column<'_, (usize, &'s Sample)>> {
        let mut all = Vec::new();
        if !self.plan.grid.is_empty() {
            all.extend(columns! { |(_, s): &(usize, &Sample)| "point" => s.point; });
        }
        all.extend(columns! { |(_, s): &(usize, &Sample)| "sample" => s.number; });
        if !self.plan.is_varied("torque_nm") {
            all.extend(columns! { |(t, _): &(usize, &Sample)| "torque_nm" => self.torques[*t]; });
        }
        for (k, (field, _)) in self.plan.fields.iter().enumerate() {
            all.extend(columns! { |(_, s): &(usize, &Sample)| field => s.fields[k]; });
        }
        for (k, outcome) in self.outcomes.iter().enumerate() {
            let name = &outcome.name;
            all.extend(columns! { |(t, s): &(usize, &Sample)| name => s.result(*t, k); });
        }
        let error = |s: &Sample| s.outcome.as_ref().err().cloned();
        all.extend(columns! { |(_, s): &(usize, &Sample)| "error" => error(s); });
        all
    }

    pub fn write(&self, samples: &[Sample]) -> Result<(), Error> {
        let rows = |sample| (0..self.torques.len()).map(move |t| (t, sample));
        let table = csv(&[], &self.columns(), samples, rows)?;
        Ok(output::write_whole(self.path, &table)?)
    }

    /// The samples that are there; none if there is no such file.
    ///
    /// # Errors
    /// A file of another form.
    pub fn read(&self) -> Result<Vec<Sample>, Error> {
        if !self.path.exists() {
            return Ok(Vec::new());
        }
        let path = self.path.display();
        let wrong = |what: &str| {
            format!("{path}: {what}; name another folder, or begin anew with --restart")
        };
        let text = output::read_text(self.path)?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let expected = self.columns();
        let names = expected.iter().map(|column| column.name.as_str());
        if reader.headers()?.iter().ne(names) {
            return Err(wrong("columns of another study").into());
        }
        let fields = self.plan.fields.len();
        let is_first = |column: &Column<_>| column.name == self.plan.fields[0].0;
        let first = expected.iter().position(is_first).unwrap_or(0);
        let mut samples: Vec<Sample> = Vec::new();
        for record in reader.records() {
            let record = record?;
            let number = |text: &str| {
                let value = text.parse::<f64>();
                value.map_err(|_| wrong(&format!("`{text}` is no number")))
            };
            let numbers = |from: usize, count: usize| -> Result<Vec<f64>, String> {
                record.iter().skip(from).take(count).map(number).collect()
            };
            let results = match record.iter().next_back().unwrap_or_default() {
                "" => Ok(numbers(first + fields, self.outcomes.len())?),
                error => Err(error.to_owned()),
            };
            let [point, own] = match self.plan.grid.is_empty() {
                true => [0.0, number(&record[0])?],
                false => [number(&record[0])?, number(&record[1])?],
            }
            .map(|number| number as usize);
            let known = samples.last_mut();
            match known.filter(|s| (s.point, s.number) == (point, own)) {
                None => samples.push(Sample {
                    point,
                    number: own,
                    fields: numbers(first, fields)?,
                    outcome: results.map(|results| vec![results]),
                }),
                Some(sample) => {
                    if let (Ok(all), Ok(more)) = (&mut sample.outcome, results) {
                        all.push(more);
                    }
                }
            }
        }
        Ok(samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_again_and_another_study_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = &folder.path().join("samples.csv");
        let plan = |fields: &[&str]| Plan {
            grid: vec![],
            drawn: vec![],
            fields: fields.iter().map(|field| ((*field).into(), 0.0)).collect(),
        };
        let (plan, fewer) = (&plan(&["a", "b"]), &plan(&["a"]));
        let (found, more) = (&outcomes(false), &outcomes(true));
        let table = |plan, outcomes| Table {
            path,
            plan,
            torques: &[50.0, 100.0],
            outcomes,
        };
        assert_eq!(table(plan, found).read().unwrap(), []);
        let sample = |number, fields: [f64; 2], outcome| Sample {
            point: 0,
            number,
            fields: fields.into(),
            outcome,
        };
        let results = vec![vec![1.0, 0.1 + 0.2, 3.0, 4e-7, 5.0, 6.0], vec![7.0; 6]];
        let samples = [
            sample(0, [0.1, -2.0], Ok(results)),
            sample(1, [0.3, 1.0], Err("too much, \"far\"".into())),
        ];
        table(plan, found).write(&samples).unwrap();
        assert_eq!(table(plan, found).read().unwrap(), samples);
        for refused in [table(fewer, found).read(), table(plan, more).read()] {
            assert!(refused.unwrap_err().to_string().contains("another study"));
        }
    }
}
