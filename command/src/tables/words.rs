//! What is said of tables, on the terminal and in their file.

use gearmesh::contact::MAXIMUM_ITERATIONS;
use gearmesh::pair::Pair;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::table::source::SolveQuality;

use super::Made;
use crate::accuracy;
use crate::flank_summary::modifications;
use crate::model::{Model, ModelArgs};
use crate::output::Listing;

/// Error of the force, rms over the nominal one, from which on tooth pairs one by one are warned of: several times that of
/// the shipped pairs.
const LARGE_ERROR: f64 = 0.03;

impl std::fmt::Display for Made {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}\n  elastic model: {}\n  static contact: {:.1} s, {}",
            self.file.size_and_error(),
            self.elastic_model,
            self.contact_seconds,
            solves_in_words(&self.file)
        )?;
        for line in &self.about_pair {
            write!(f, "\n  {line}")?;
        }
        if let Some(root_stress) = &self.file.root_stress {
            write!(
                f,
                "\n  root stress: {:.1} s, {}",
                self.root_stress_seconds, root_stress.interpolation_error
            )?;
        }
        if let Some(teeth) = &self.file.teeth {
            write!(
                f,
                "\n  tooth pairs one by one: {:.1} s, {}",
                self.teeth_seconds,
                teeth.in_words()
            )?;
            if teeth.error.force_rms > LARGE_ERROR {
                write!(
                    f,
                    "\n  warning: tooth pairs one by one carry {:.1} % rms of the nominal force more or less than they \
                     should; for this pair build with --contact and set stiffnessModel = contact",
                    100.0 * teeth.error.force_rms
                )?;
            }
        }
        if let Some(contact) = &self.contact {
            let error = accuracy::at_run_time(contact.error.as_ref());
            write!(f, "\n  contact at run time: {error}")?;
        }
        if let Some(note) = self.note_on_teeth {
            let table = "`stiffnessModel = table` takes all teeth as alike";
            let words = match (&self.file.teeth, &self.contact) {
                (Some(_), Some(_)) => format!(
                    "units start with `stiffnessModel = teeth`, which takes the tooth errors, as `contact` does; {table}"
                ),
                (Some(_), None) => format!(
                    "units start with `stiffnessModel = teeth`, which takes the tooth errors; {table}"
                ),
                (None, Some(_)) => {
                    format!("{table}; `stiffnessModel = contact` takes the tooth errors")
                }
                (None, None) => note.to_owned(),
            };
            write!(f, "\n  note: {words}")?;
        }
        Ok(())
    }
}

/// What the tables file keeps of how it was made.
pub(super) fn settings(
    pair: &Pair,
    model: &Model,
    args: &ModelArgs,
    quality: SolveQuality,
) -> std::collections::BTreeMap<String, serde_json::Value> {
    let contact = model.solver.settings();
    [
        ("elastic_model", model.description.clone().into()),
        ("tip_corner_contact", pair.tip_corner_contact.into()),
        ("plane_strain", args.is_plane_strain().into()),
        ("stations_along_the_face", contact.stations.into()),
        ("contact_solves", quality.solves.into()),
        ("most_newton_steps", quality.most_iterations.into()),
        ("newton_steps_allowed", MAXIMUM_ITERATIONS.into()),
        ("largest_kkt_residual", quality.kkt_residual.into()),
        (
            "modifications_of_gear_1",
            modifications_in_words(pair, 0).into(),
        ),
        (
            "modifications_of_gear_2",
            modifications_in_words(pair, 1).into(),
        ),
    ]
    .into_iter()
    .map(|(name, value): (&str, serde_json::Value)| (name.to_owned(), value))
    .collect()
}

fn modifications_in_words(pair: &Pair, i: usize) -> String {
    let mut rows = Listing::default();
    modifications(pair, i, &mut rows);
    rows.in_one_line()
}

/// How the static solves of tables went, as their file says.
fn solves_in_words(file: &TableFile) -> String {
    let of = |name: &str| match file.solver.get(name) {
        None => "an unknown number".into(),
        Some(value) => match value.as_f64() {
            Some(number) if number.fract() != 0.0 => format!("{number:.1e}"),
            _ => value.to_string(),
        },
    };
    format!(
        "{} contact solves, Newton steps {} at most of {} allowed, KKT residual {} at most",
        of("contact_solves"),
        of("most_newton_steps"),
        of("newton_steps_allowed"),
        of("largest_kkt_residual")
    )
}
