//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use super::Setup;
use crate::Error;
use crate::case::Case;
use crate::columns::{Column, columns, csv};
use crate::output;

/// A result of a mesh cycle: in samples.csv; with a head also in correlations and charts.
pub type Outcome = Column<'static, Case>;

/// The results of a sample at a torque, the last two only with `root_stress`.
pub fn outcomes(root_stress: bool) -> Vec<Outcome> {
    let mut all = columns! { |c: &Case|
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
    pub fn result(&self, t: usize, k: usize) -> Option<f64> {
        Some(self.outcome.as_ref().ok()?[t][k])
    }
}

impl Setup {
    /// Number, fields, results, and what went wrong if something did.
    fn columns<'s>(&self) -> Vec<Column<'_, (usize, &'s Sample)>> {
        let mut all = columns! { |(_, s): &(usize, &Sample)|
            "point" => s.point;
            "sample" => s.number;
        };
        if self.plan.grid.is_empty() {
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
        let error = |s: &Sample| s.outcome.as_ref().err().cloned();
        all.extend(columns! { |(_, s): &(usize, &Sample)| "error" => error(s); });
        all
    }

    pub fn write(&self, path: &Path, samples: &[Sample]) -> Result<(), Error> {
        let rows = |sample| (0..self.torques.len()).map(move |t| (t, sample));
        let table = csv(&[], &self.columns(), samples, rows)?;
        Ok(output::write_whole(path, &table)?)
    }

    /// The samples that are there, none if there is no such file; one of another form is refused.
    pub fn read(&self, path: &Path) -> Result<Vec<Sample>, Error> {
        if !path.exists() {
            return Ok(Vec::new());
        }
        let wrong = |what: &str| {
            let path = path.display();
            format!("{path}: {what}; name another folder, or begin anew with --restart")
        };
        let text = output::read_text(path)?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let columns = self.columns();
        let names = columns.iter().map(|column| &*column.name);
        if reader.headers()?.iter().ne(names) {
            return Err(wrong("columns of another study").into());
        }
        let fields = self.plan.fields.len();
        let first = columns.len() - 1 - self.outcomes.len() - fields;
        let mut samples: Vec<Sample> = Vec::new();
        for record in reader.records() {
            let record = record?;
            let error = &record[columns.len() - 1];
            // A refused sample has no results.
            let number = |(k, text): (usize, &str)| match text {
                "" if k >= first + fields && !error.is_empty() => Ok(f64::NAN),
                _ => (text.parse::<f64>()).map_err(|_| wrong(&format!("`{text}` is no number"))),
            };
            let numbers = record.iter().take(columns.len() - 1).enumerate();
            let numbers: Vec<f64> = numbers.map(number).collect::<Result<_, _>>()?;
            let [point, own] = match self.plan.grid.is_empty() {
                true => [0, numbers[0] as usize],
                false => [numbers[0], numbers[1]].map(|number| number as usize),
            };
            let (fields, results) = numbers[first..].split_at(fields);
            let known = samples.last_mut();
            match known.filter(|s| (s.point, s.number) == (point, own)) {
                None => samples.push(Sample {
                    point,
                    number: own,
                    fields: fields.into(),
                    outcome: match error {
                        "" => Ok(vec![results.into()]),
                        error => Err(error.into()),
                    },
                }),
                Some(sample) => sample
                    .outcome
                    .iter_mut()
                    .for_each(|all| all.push(results.into())),
            }
        }
        Ok(samples)
    }
}
