//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::fmi::resources::UnitFile;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::{InterpolationError, Table, TableFile};
use gearmesh::words::{count, shown};
use gearmesh_preprocessor::package::{self, start_in_words};
use gearmesh_preprocessor::pair;
use serde::de::IgnoredAny;

use crate::output::{self, Listing, rows};
use crate::pair_summary::{as_json, pair_summary};
use crate::{Error, cost};

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
        let name = self.file.display();
        let is_archive = is_archive(&self.file)?;
        let text = match is_archive {
            true => String::new(),
            false => output::read_text(&self.file)?,
        };
        let is_tables = is_tables(&text);
        if self.json && (is_archive || is_tables) {
            refuse!("--json: {name} is no pair file; leave the option out");
        }
        let shown = if is_archive {
            fmu(&self.file)?
        } else if is_tables {
            table_file(&TableFile::from_json(&text).map_err(|e| format!("{name}: {e}"))?)?
        } else {
            // Files that it names are sought in its folder.
            let read = pair::read_with_gauges(&self.file);
            let (pair, gauges) = read.map_err(|e| format!("{name}: {e}"))?;
            match self.json {
                true => format!("{:#}\n", as_json(&pair, gauges)),
                false => pair_summary(&pair, gauges),
            }
        };
        Ok(output::print(&shown)?)
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
    // Tables that no FMU could use are no tables.
    Table::from_file(file.clone())?;
    let mut rows = Listing::default();
    for (name, value) in file.summary() {
        rows.row(name, value);
    }
    Ok(format!("{}: tables\n{rows}", shown(&file.name)))
}

fn fmu(path: &Path) -> Result<String, Error> {
    let found = package::inspect(path)?;
    let unit = &found.unit;
    let tables = found.tables.as_deref().map(TableFile::from_json);
    let tables = tables.transpose()?;
    let contact_error = found.contact_error.as_ref();
    let error = level_error(unit, tables.as_ref(), contact_error);
    let mut rows = Listing::default();
    rows! { rows;
        "GUID" => "{}", unit.guid;
        "platforms" => "{}", found.platforms.join(", ");
    }
    if let Some(time) = cost::evaluation(path, &unit.guid)? {
        rows! { rows;
            "time of one evaluation" => "{:.2} us on this machine, under nominal torque and with the start values below", 1e6 * time;
        }
    }
    let mut step = format!("{:?} s", found.step_size);
    if let Some(error) = package::step_error(unit, tables.as_ref(), found.step_size) {
        step += &format!(
            "; costs {:.2} % rms of the variation of mesh.transmissionError under a load applied over 2 ms",
            100.0 * error
        );
    }
    rows.row("communication step", step);
    if contact_error.is_some() && !error.starts_with("contact:") {
        rows.row(
            "error of contact at run time",
            run_time_error(contact_error),
        );
    }
    rows.row("error", error);
    for (name, value) in &unit.starts {
        rows.row(format!("start: {name}"), start_in_words(name, *value));
    }
    for (name, size) in &found.files {
        rows.row(format!("file: {name}"), count(*size as usize, "byte"));
    }
    let mut text = format!("{}: FMU\n{rows}", shown(&unit.name));
    if let Some(tables) = &tables {
        text += &format!("\n{}", table_file(tables)?);
    }
    Ok(text)
}

pub fn run_time_error(error: Option<&InterpolationError>) -> String {
    error.map_or("not measured; build the FMU again".into(), |error| {
        format!("{error}; against static contact on more stations, all teeth alike")
    })
}

/// The level that `unit` starts with, and how far its forces were from static contact when the FMU was made; `contact`: at run time.
fn level_error(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    contact: Option<&InterpolationError>,
) -> String {
    let start = |i: usize| {
        let own = unit.starts.get(VARIABLES[i].name).copied();
        own.or(VARIABLES[i].start).unwrap_or(0.0)
    };
    // Items are counted from 1.
    let item = |i: usize| {
        let item = VARIABLES[i].items.get((start(i) as usize).wrapping_sub(1));
        item.copied().unwrap_or("")
    };
    let level = item(index::STIFFNESS_MODEL);
    let error = match (level, tables) {
        ("contact", _) => run_time_error(contact),
        ("teeth", Some(TableFile { teeth: Some(t), .. })) => {
            format!("{} against contact at run time", t.error)
        }
        ("table", Some(tables)) => {
            let error = tables.interpolation_error.map(|error| error.to_string());
            let error = error.unwrap_or("not measured".into());
            let offsets = tables.axes.center_distance_offset.len();
            let effects = [
                (index::LOAD_DEPENDENT, 2),
                (index::CENTER_DISTANCE_EFFECT, offsets),
                (index::MISALIGNMENT_EFFECT, tables.axes.misalignment.len()),
            ];
            let is_less = |(i, nodes): &(usize, usize)| start(*i) == 0.0 && *nodes > 1;
            let less = effects.into_iter().filter(is_less);
            let less = less.map(|(i, _)| format!("{} = false", VARIABLES[i].name));
            let mut less: Vec<String> = less.collect();
            if item(index::INTERPOLATION) != "spline" {
                less.push("another interpolation".into());
            }
            match less.join(", ").as_str() {
                "" => error,
                less => format!("{error}; that of the spline with all axes, more with {less}"),
            }
        }
        _ => "not measured: one stiffness for all loads and mesh positions".to_owned(),
    };
    format!("{level}: {error}")
}
