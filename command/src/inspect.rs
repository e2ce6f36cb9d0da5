//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use gearmesh_preprocessor::pair;
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::table::{Table, TableFile};
use gearmesh::words::{count, shown};
use gearmesh_preprocessor::package::{self, start_in_words};
use serde::de::IgnoredAny;

use crate::Error;
use crate::accuracy;
use crate::cost;
use crate::drawing::as_json;
use crate::output::{self, Listing};
use crate::pair_summary::pair_summary;

/// Show what is in a pair file, in tables or in an FMU.
#[derive(Debug, Args)]
pub struct Inspect {
    /// The file
    file: PathBuf,

    /// JSON of a pair file, with the quantities of a drawing
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub fn run(self) -> Result<(), Error> {
        let no_json = || {
            let place = self.file.display();
            match self.json {
                true => Err(format!(
                    "--json: {place} is no pair file; leave the option out"
                )),
                false => Ok(()),
            }
        };
        let text = if is_archive(&self.file)? {
            no_json()?;
            fmu(&self.file)?
        } else {
            let text = output::read_text(&self.file)?;
            let place = |error: Error| format!("{}: {error}", self.file.display());
            match is_tables(&text) {
                true => {
                    no_json()?;
                    table_file(&TableFile::from_json(&text).map_err(|e| place(e.into()))?)?
                }
                // Files that it names are sought in its folder.
                false => {
                    let read = pair::read_with_gauges(&self.file);
                    let (pair, gauges) = read.map_err(|e| place(e.into()))?;
                    match self.json {
                        true => format!("{:#}\n", as_json(&pair, gauges)),
                        false => pair_summary(&pair, gauges),
                    }
                }
            }
        };
        output::print(&text)?;
        Ok(())
    }
}

/// Whether the file begins as zip archives do.
fn is_archive(path: &Path) -> Result<bool, Error> {
    let mut mark = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(2).read_to_end(&mut mark))
        .map_err(|error| output::unreadable(path, &error))?;
    Ok(mark == b"PK")
}

/// Tables say their format; a pair file does not.
pub fn is_tables(text: &str) -> bool {
    #[derive(serde::Deserialize)]
    struct Marks {
        format: Option<IgnoredAny>,
        axes: Option<IgnoredAny>,
    }
    serde_json::from_str::<Marks>(text)
        .is_ok_and(|marks| marks.format.is_some() && marks.axes.is_some())
}

fn table_file(file: &TableFile) -> Result<String, Error> {
    // Tables that no unit could use are no tables.
    Table::from_file(file.clone())?;
    let mut rows = Listing::default();
    for (name, value) in file.summary() {
        rows.row(name, value);
    }
    Ok(format!("{}: tables\n{rows}", shown(&file.name)))
}

fn fmu(path: &Path) -> Result<String, Error> {
    let found = package::inspect(path)?;
    let mut rows = Listing::default();
    rows.row("GUID", &found.unit.guid)
        .row("platforms", found.platforms.join(", "));
    if let Some(time) = cost::evaluation(path, &found.unit.guid)? {
        let words = format!(
            "{:.2} us on this machine, under nominal torque and with the start values below",
            1e6 * time
        );
        rows.row("time of one evaluation", words);
    }
    let tables = found
        .tables
        .as_deref()
        .map(TableFile::from_json)
        .transpose()?;
    let step = format!("{:?} s", found.step_size);
    let error = package::step_error(&found.unit, tables.as_ref(), found.step_size);
    rows.row("communication step", match error {
        Some(error) => format!("{step}; costs {:.2} % rms of the variation of mesh.transmissionError under a load applied over 2 ms", 100.0 * error),
        None => step,
    });
    let contact_error = found.contact_error.as_ref();
    let error = accuracy::of_level(&found.unit, tables.as_ref(), contact_error);
    if contact_error.is_some() && !error.starts_with("contact:") {
        rows.row(
            "error of contact at run time",
            accuracy::at_run_time(contact_error),
        );
    }
    rows.row("error", error);
    for (name, value) in &found.unit.starts {
        rows.row(format!("start: {name}"), start_in_words(name, *value));
    }
    for (name, size) in &found.files {
        rows.row(format!("file: {name}"), count(*size as usize, "byte"));
    }
    let mut text = format!("{}: FMU\n{rows}", shown(&found.unit.name));
    if let Some(tables) = &tables {
        let _ = write!(text, "\n{}", table_file(tables)?);
    }
    Ok(text)
}
