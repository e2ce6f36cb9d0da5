//! The samples of a study on disk: what makes it resume.

use std::path::Path;

use gearmesh_preprocessor::contact::{GearRoots, MeshCycle};

use super::variation::Variation;
use crate::Error;
use crate::output;

/// A result of a sample.
pub struct Outcome {
    /// With its unit.
    pub name: &'static str,
    /// Above its correlations, and at the axis of its distribution, where they are shown.
    pub head: Option<(&'static str, &'static str)>,
    value: fn(&Solved) -> f64,
}

/// What a sample is solved for.
pub struct Solved {
    pub cycle: MeshCycle,
    pub face_load_factor: f64,
    /// Where it is asked for.
    pub roots: Option<[GearRoots; 2]>,
}

/// The results; the last two only where root stress is asked for.
const OUTCOMES: [Outcome; 8] = [
    outcome(
        "peak_to_peak_ste_loa_um",
        Some(("p-p STE", "p-p STE (um)")),
        |s| s.cycle.peak_to_peak_ste() * 1e6,
    ),
    outcome("mean_ste_loa_um", None, |s| s.cycle.mean_ste() * 1e6),
    outcome("harmonic_1_loa_um", None, |s| {
        s.cycle.harmonics()[0].map_or(f64::NAN, |h| h.amplitude * 1e6)
    }),
    outcome(
        "maximum_pressure_mpa",
        Some(("pressure", "largest flank pressure (MPa)")),
        |s| s.cycle.max_pressure() * 1e-6,
    ),
    outcome("edge_line_load_n_per_mm", None, |s| {
        s.cycle
            .edge_load()
            .map_or(0.0, |edge| edge.line_load * 1e-3)
    }),
    outcome("face_load_factor", Some(("K_Hbeta", "K_Hbeta")), |s| {
        s.face_load_factor
    }),
    outcome(
        "root_stress_1_mpa",
        Some(("root 1", "root stress of gear 1 (MPa)")),
        |s| s.root_stress(0),
    ),
    outcome(
        "root_stress_2_mpa",
        Some(("root 2", "root stress of gear 2 (MPa)")),
        |s| s.root_stress(1),
    ),
];

const fn outcome(
    name: &'static str,
    head: Option<(&'static str, &'static str)>,
    value: fn(&Solved) -> f64,
) -> Outcome {
    Outcome { name, head, value }
}

/// The results of a study with or without the largest root stress of both gears.
pub fn outcomes(root_stress: bool) -> &'static [Outcome] {
    let roots = if root_stress { 0 } else { 2 };
    &OUTCOMES[..OUTCOMES.len() - roots]
}

impl Solved {
    /// In the order of [`outcomes`].
    pub fn results(&self) -> Vec<f64> {
        let outcomes = outcomes(self.roots.is_some()).iter();
        outcomes.map(|outcome| (outcome.value)(self)).collect()
    }

    fn root_stress(&self, i: usize) -> f64 {
        let largest = self.roots.as_ref().and_then(|gears| gears[i].largest());
        largest.map_or(0.0, |tooth| tooth.largest.stress * 1e-6)
    }
}

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// From 1 on; 0 is the pair as drawn.
    pub number: usize,
    /// Values of the varied fields.
    pub fields: Vec<f64>,
    /// Those of [`outcomes`], or why there are none.
    pub outcome: Result<Vec<f64>, String>,
}

/// Writes `samples` to the CSV file `path`: number, fields, results, and what went wrong if something did.
pub fn write(
    path: &Path,
    variations: &[Variation],
    outcomes: &[Outcome],
    samples: &[Sample],
) -> Result<(), Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(variations, outcomes))?;
    for sample in samples {
        let mut row = vec![sample.number.to_string()];
        row.extend(sample.fields.iter().map(f64::to_string));
        match &sample.outcome {
            Ok(results) => {
                row.extend(results.iter().map(f64::to_string));
                row.push(String::new());
            }
            Err(error) => {
                row.extend(outcomes.iter().map(|_| String::new()));
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
pub fn read(
    path: &Path,
    variations: &[Variation],
    outcomes: &[Outcome],
) -> Result<Vec<Sample>, Error> {
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
    if reader.headers()?.iter().ne(header(variations, outcomes)) {
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
        let error = text(first + outcomes.len());
        let outcome = if error.is_empty() {
            let results = (first..first + outcomes.len()).map(number);
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

fn header<'a>(
    variations: &'a [Variation],
    outcomes: &'a [Outcome],
) -> impl Iterator<Item = &'a str> {
    let fields = variations.iter().map(|v| v.field.as_str());
    (["sample"].into_iter().chain(fields))
        .chain(outcomes.iter().map(|outcome| outcome.name))
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
        let found = outcomes(false);
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
            read(&path, &variations, outcomes(true)),
        ] {
            let error = refused.unwrap_err().to_string();
            assert!(error.contains("another study"), "{error}");
        }
    }
}
