//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use gearmesh::contact::MeshCycle;

use super::variation::Variation;
use crate::Error;
use crate::output;

/// Results of a sample, with their units.
pub const RESULTS: [&str; 6] = [
    "peak_to_peak_ste_loa_um",
    "mean_ste_loa_um",
    "harmonic_1_loa_um",
    "maximum_pressure_mpa",
    "edge_line_load_n_per_mm",
    "face_load_factor",
];

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// From 1 on; 0 is the pair as drawn.
    pub number: usize,
    /// Values of the varied fields.
    pub fields: Vec<f64>,
    /// [`RESULTS`], or why there are none.
    pub outcome: Result<[f64; RESULTS.len()], String>,
}

/// The results of a mesh cycle.
pub fn results(cycle: &MeshCycle, face_load_factor: f64) -> [f64; RESULTS.len()] {
    [
        cycle.peak_to_peak_ste() * 1e6,
        cycle.mean_ste() * 1e6,
        cycle.harmonics()[0].map_or(f64::NAN, |h| h.amplitude * 1e6),
        cycle.max_pressure() * 1e-6,
        cycle.edge_load().map_or(0.0, |edge| edge.line_load * 1e-3),
        face_load_factor,
    ]
}

/// Writes `samples` to the CSV file `path`: number, fields, results, and what went wrong if something did.
pub fn write(path: &Path, variations: &[Variation], samples: &[Sample]) -> Result<(), Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(variations))?;
    for sample in samples {
        let mut row = vec![sample.number.to_string()];
        row.extend(sample.fields.iter().map(f64::to_string));
        match &sample.outcome {
            Ok(results) => {
                row.extend(results.map(|r| r.to_string()));
                row.push(String::new());
            }
            Err(error) => {
                row.extend(RESULTS.map(|_| String::new()));
                row.push(error.clone());
            }
        }
        writer.write_record(row)?;
    }
    Ok(output::write_whole(path, &writer.into_inner()?)?)
}

/// The samples in `path`; none if there is no such file.
///
/// # Errors
/// A file of another form.
pub fn read(path: &Path, variations: &[Variation]) -> Result<Vec<Sample>, Error> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let wrong = |what: &str| -> Error {
        format!(
            "{}: {what}; name another folder, or begin anew with --restart",
            path.display()
        )
        .into()
    };
    let text = output::read_text(path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    if reader.headers()?.iter().ne(header(variations)) {
        return Err(wrong("columns of another study"));
    }
    let mut samples = Vec::new();
    for record in reader.records() {
        let record = record?;
        let text = |i: usize| record.get(i).unwrap_or_default();
        let number = |i: usize| -> Result<f64, Error> {
            let value = text(i).parse();
            value.map_err(|_| wrong(&format!("`{}` is no number", text(i))))
        };
        let first = 1 + variations.len();
        let error = text(first + RESULTS.len());
        let outcome = if error.is_empty() {
            let mut results = [0.0; RESULTS.len()];
            for (k, result) in results.iter_mut().enumerate() {
                *result = number(first + k)?;
            }
            Ok(results)
        } else {
            Err(error.to_owned())
        };
        samples.push(Sample {
            number: number(0)? as usize,
            fields: (1..first).map(number).collect::<Result<_, _>>()?,
            outcome,
        });
    }
    Ok(samples)
}

fn header(variations: &[Variation]) -> impl Iterator<Item = &str> {
    let fields = variations.iter().map(|v| v.field.as_str());
    (["sample"].into_iter().chain(fields))
        .chain(RESULTS)
        .chain(["error"])
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
        assert_eq!(read(&path, &variations).unwrap(), []);
        let samples = [
            Sample {
                number: 0,
                fields: vec![0.1, -2.0],
                outcome: Ok([1.0, 0.1 + 0.2, 3.0, 4e-7, 5.0, 6.0]),
            },
            Sample {
                number: 1,
                fields: vec![0.3, 1.0],
                outcome: Err("too much, \"far\"".into()),
            },
        ];
        write(&path, &variations, &samples).unwrap();
        assert_eq!(read(&path, &variations).unwrap(), samples);
        let error = read(&path, &variations[..1]).unwrap_err().to_string();
        assert!(error.contains("another study"), "{error}");
    }
}
