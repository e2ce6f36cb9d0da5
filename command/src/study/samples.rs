//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use gearmesh::contact::ContactSolver;

use super::variation::Variation;
use crate::Error;
use crate::case::Case;
use crate::columns::{Column, columns, csv};
use crate::output;

pub type Solved<'a> = (&'a ContactSolver, &'a Case);

/// The results of a sample, the last two only with `root_stress`. Those with a head have correlations and a distribution.
pub fn outcomes<'r>(root_stress: bool) -> Vec<Column<'static, Solved<'r>>> {
    let mut all = columns! { |(solver, c): &Solved|
        "peak_to_peak_ste_loa_um", ["p-p STE", "um", 3] => 1e6 * c.cycle.peak_to_peak_ste();
        "mean_ste_loa_um" => 1e6 * c.cycle.mean_ste();
        "harmonic_1_loa_um" => c.cycle.harmonics()[0].map(|h| 1e6 * h.amplitude);
        "maximum_pressure_mpa", ["pressure", "MPa", 1] => 1e-6 * c.cycle.max_pressure();
        "edge_line_load_n_per_mm" => c.cycle.edge_load().map_or(0.0, |edge| 1e-3 * edge.line_load);
        "face_load_factor", ["K_Hbeta", "", 3] => c.face_load(solver).face_load_factor();
    };
    if root_stress {
        all.extend(columns! { |(_, c): &Solved|
            "root_stress_1_mpa", ["root 1", "MPa", 1] => c.root_stress(0);
            "root_stress_2_mpa", ["root 2", "MPa", 1] => c.root_stress(1);
        });
    }
    all
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// From 1 on; 0 is the pair as drawn.
    pub number: usize,
    pub fields: Vec<f64>,
    /// Those of [`outcomes`], or why there are none.
    pub outcome: Result<Vec<f64>, String>,
}

impl Sample {
    /// Result `k` of [`outcomes`].
    pub fn result(&self, k: usize) -> Option<f64> {
        Some(self.outcome.as_ref().ok()?[k])
    }
}

/// Number, fields, results, and what went wrong if something did.
fn columns<'a, 'r>(
    variations: &[Variation],
    outcomes: &[Column<Solved>],
) -> Vec<Column<'a, &'r Sample>> {
    let mut all = columns! { |s: &&Sample| "sample" => s.number; };
    for (k, variation) in variations.iter().enumerate() {
        all.extend(columns! { |s: &&Sample| variation.field.as_str() => s.fields[k]; });
    }
    for (k, outcome) in outcomes.iter().enumerate() {
        all.extend(columns! { |s: &&Sample| outcome.name.as_str() => s.result(k); });
    }
    all.extend(columns! { |s: &&Sample| "error" => s.outcome.as_ref().err().cloned(); });
    all
}

/// Writes `samples` to the CSV file `path`.
pub fn write(
    path: &Path,
    variations: &[Variation],
    outcomes: &[Column<Solved>],
    samples: &[Sample],
) -> Result<(), Error> {
    let table = csv(&[], &columns(variations, outcomes), &[()], |()| samples)?;
    Ok(output::write_whole(path, &table)?)
}

/// The samples in `path`; none if there is no such file.
///
/// # Errors
/// A file of another form.
pub fn read(
    path: &Path,
    variations: &[Variation],
    outcomes: &[Column<Solved>],
) -> Result<Vec<Sample>, Error> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let place = path.display();
    let wrong =
        |what: &str| format!("{place}: {what}; name another folder, or begin anew with --restart");
    let text = output::read_text(path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let expected = columns(variations, outcomes);
    let names = expected.iter().map(|column| column.name.as_str());
    if reader.headers()?.iter().ne(names) {
        return Err(wrong("columns of another study").into());
    }
    let sample = |record: csv::StringRecord| {
        let number = |text: &str| {
            let value = text.parse::<f64>();
            value.map_err(|_| wrong(&format!("`{text}` is no number")))
        };
        let numbers = |from: usize, count: usize| record.iter().skip(from).take(count).map(number);
        let error = record.iter().next_back().unwrap_or_default();
        let outcome = match error {
            "" => Ok(numbers(1 + variations.len(), outcomes.len()).collect::<Result<_, _>>()?),
            error => Err(error.to_owned()),
        };
        Ok(Sample {
            number: number(&record[0])? as usize,
            fields: numbers(1, variations.len()).collect::<Result<_, _>>()?,
            outcome,
        })
    };
    reader.records().map(|record| sample(record?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_again_and_another_study_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("samples.csv");
        let of = |field: &str| Variation {
            field: field.into(),
            low: 0.0,
            high: 1.0,
        };
        let variations = [of("a"), of("b")];
        let found = &outcomes(false);
        assert_eq!(read(&path, &variations, found).unwrap(), []);
        let samples = [
            Sample {
                number: 0,
                fields: vec![0.1, -2.0],
                outcome: Ok(vec![1.0, 0.1 + 0.2, 3.0, 4e-7, 5.0, 6.0]),
            },
            Sample {
                number: 1,
                fields: vec![0.3, 1.0],
                outcome: Err("too much, \"far\"".into()),
            },
        ];
        write(&path, &variations, found, &samples).unwrap();
        assert_eq!(read(&path, &variations, found).unwrap(), samples);
        for refused in [
            read(&path, &variations[..1], found),
            read(&path, &variations, &outcomes(true)),
        ] {
            let error = refused.unwrap_err().to_string();
            assert!(error.contains("another study"), "{error}");
        }
    }
}
