//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use gearmesh::contact::{GearRoots, MeshCycle};

use super::variation::Variation;
use crate::Error;
use crate::output;

/// Results of a sample, with their units; the last ones stand there only if they are asked for.
const RESULTS: [&str; 8] = [
    "peak_to_peak_ste_loa_um",
    "mean_ste_loa_um",
    "harmonic_1_loa_um",
    "maximum_pressure_mpa",
    "edge_line_load_n_per_mm",
    "face_load_factor",
    "root_stress_1_mpa",
    "root_stress_2_mpa",
];

/// The results of a study with or without the largest root stress of both gears.
pub fn names(root_stress: bool) -> &'static [&'static str] {
    let roots = if root_stress { 0 } else { 2 };
    &RESULTS[..RESULTS.len() - roots]
}

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// From 1 on; 0 is the pair as drawn.
    pub number: usize,
    /// Values of the varied fields.
    pub fields: Vec<f64>,
    /// Those of [`names`], or why there are none.
    pub outcome: Result<Vec<f64>, String>,
}

/// The results of a mesh cycle, with the largest stress in its `roots`.
pub fn results(
    cycle: &MeshCycle,
    face_load_factor: f64,
    roots: Option<&[GearRoots; 2]>,
) -> Vec<f64> {
    let stress = |gear: &GearRoots| gear.largest().map_or(0.0, |tooth| tooth.largest.stress);
    let contact = [
        cycle.peak_to_peak_ste() * 1e6,
        cycle.mean_ste() * 1e6,
        cycle.harmonics()[0].map_or(f64::NAN, |h| h.amplitude * 1e6),
        cycle.max_pressure() * 1e-6,
        cycle.edge_load().map_or(0.0, |edge| edge.line_load * 1e-3),
        face_load_factor,
    ];
    let roots = roots.into_iter().flatten().map(|gear| stress(gear) * 1e-6);
    contact.into_iter().chain(roots).collect()
}

/// Writes `samples` to the CSV file `path`: number, fields, results, and what went wrong if something did.
pub fn write(
    path: &Path,
    variations: &[Variation],
    names: &[&str],
    samples: &[Sample],
) -> Result<(), Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(variations, names))?;
    for sample in samples {
        let mut row = vec![sample.number.to_string()];
        row.extend(sample.fields.iter().map(f64::to_string));
        match &sample.outcome {
            Ok(results) => {
                row.extend(results.iter().map(f64::to_string));
                row.push(String::new());
            }
            Err(error) => {
                row.extend(names.iter().map(|_| String::new()));
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
pub fn read(path: &Path, variations: &[Variation], names: &[&str]) -> Result<Vec<Sample>, Error> {
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
    if reader.headers()?.iter().ne(header(variations, names)) {
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
        let error = text(first + names.len());
        let outcome = if error.is_empty() {
            let results = (first..first + names.len()).map(number);
            Ok(results.collect::<Result<_, _>>()?)
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

fn header<'a>(variations: &'a [Variation], names: &'a [&str]) -> impl Iterator<Item = &'a str> {
    let fields = variations.iter().map(|v| v.field.as_str());
    (["sample"].into_iter().chain(fields))
        .chain(names.iter().copied())
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
        let names = names(false);
        assert_eq!(read(&path, &variations, names).unwrap(), []);
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
        write(&path, &variations, names, &samples).unwrap();
        assert_eq!(read(&path, &variations, names).unwrap(), samples);
        for refused in [
            read(&path, &variations[..1], names),
            read(&path, &variations, super::names(true)),
        ] {
            let error = refused.unwrap_err().to_string();
            assert!(error.contains("another study"), "{error}");
        }
    }
}
