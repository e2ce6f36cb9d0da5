//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{Kind, VARIABLES, index, index_by_name};
use gearmesh::table::{InterpolationError, Table, TableFile};
use gearmesh::words::{count, shown};
use gearmesh_preprocessor::package::{self, MESH_FREQUENCY, start_in_words};
use gearmesh_preprocessor::{pair, storage, table};
use serde_json::{Map, Value, json};

use crate::columns::{Listing, rows};
use crate::error::Result;
use crate::output;
use crate::pair_summary::{as_json, pair_summary};
use crate::recipe::run_time_error;

/// Show what is in a pair file, in tables or in an FMU.
#[derive(Debug, Args)]
pub struct Inspect {
    /// The file
    file: PathBuf,

    /// JSON: a pair file with the quantities of a drawing; of tables and FMUs what the listing has
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub fn run(self) -> Result<()> {
        let name = self.file.display();
        let is_archive = is_archive(&self.file)?;
        let text = match is_archive {
            true => String::new(),
            false => output::read_text(&self.file)?,
        };
        let is_tables = output::is_tables(&text);
        let (text, json) = if is_archive {
            fmu(&self.file)?
        } else if is_tables {
            table_file(&TableFile::from_json(&text).map_err(|e| format!("{name}: {e}"))?)?
        } else {
            // Files that it names are sought in its folder.
            let read = pair::read_with_gauges(&self.file);
            let (pair, gauges) = read.map_err(|e| format!("{name}: {e}"))?;
            (pair_summary(&pair, gauges), as_json(&pair, gauges))
        };
        match self.json {
            true => output::print(&format!("{json:#}\n")),
            false => output::print(&text),
        }
    }
}

/// Whether the file begins as zip archives do.
fn is_archive(path: &Path) -> Result<bool> {
    let mut mark = Vec::new();
    storage::open(path)
        .and_then(|file| file.take(2).read_to_end(&mut mark))
        .map_err(|error| output::unreadable(path, &error))?;
    Ok(mark == b"PK")
}

/// Text and JSON of tables.
fn table_file(file: &TableFile) -> Result<(String, Value)> {
    // Tables that no FMU could use are no tables.
    Table::from_file(file.clone())?;
    let mut rows = Listing::default();
    for (name, value) in table::summary(file) {
        rows.row(name, value);
    }
    let text = format!("{}: tables\n{rows}", shown(&file.name));
    let json = json!({ "kind": "tables", "name": file.name, "listing": rows.object() });
    Ok((text, json))
}

/// Text and JSON of an FMU.
fn fmu(path: &Path) -> Result<(String, Value)> {
    let found = package::inspect(path)?;
    let unit = &found.unit;
    let tables = (found.tables.as_deref().map(TableFile::from_json)).transpose()?;
    if (tables.as_ref()).is_some_and(|tables| tables.geometry != unit.geometry) {
        refuse!(
            "{}: its tables are those of another pair; pack the FMU again",
            path.display()
        );
    }
    let contact_error = found.contact.as_ref().and_then(|contact| contact.error);
    let contact_error = contact_error.as_ref();
    let error = level_error(unit, tables.as_ref(), contact_error);
    let mut rows = Listing::default();
    rows! { rows;
        "GUID" => "{}", unit.guid;
        "platforms" => "{}", found.platforms.join(", ");
    }
    // What no host could use is no FMU.
    Resources::new(unit.clone(), tables.clone(), found.contact)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    let step = found.step_size;
    match package::step_error(unit, tables.as_ref(), step) {
        None => rows.row("communication step", format!("{step:?} s")),
        Some(error) => {
            let steady = error.steady.map_or_else(String::new, |error| {
                format!(", {:.2} % in steady state", 100.0 * error)
            });
            rows! { rows;
                "communication step" => "{step:?} s; costs {:.2} % rms of the variation of mesh.transmissionError under a load \
                     applied over 2 ms{steady}, at {MESH_FREQUENCY} tooth pitches a second; more near the resonance of the mesh", 100.0 * error.run;
            }
        }
    }
    if contact_error.is_some() && !error.starts_with("contact:") {
        rows! { rows; "error of contact at run time" => "{}", run_time_error(contact_error); }
    }
    rows.row("error", error);
    let listing = rows.object();
    let mut start = Map::new();
    for (name, value) in &unit.starts {
        rows.row(format!("start: {name}"), start_in_words(name, *value));
        start.insert(name.clone(), start_value(name, *value));
    }
    let mut files = Map::new();
    for (name, size) in &found.files {
        rows.row(format!("file: {name}"), count(*size as usize, "byte"));
        files.insert(name.clone(), json!(size));
    }
    let tables = tables.as_ref().map(table_file).transpose()?;
    let (tables_text, tables) = tables.unzip();
    let mut text = format!("{}: FMU\n{rows}", shown(&unit.name));
    if let Some(tables) = tables_text {
        text += &format!("\n{tables}");
    }
    let json = json!({
        "kind": "fmu",
        "name": unit.name,
        "platforms": found.platforms,
        "step_size_s": step,
        "listing": listing,
        "start": start,
        "files": files,
        "tables": tables,
    });
    Ok((text, json))
}

/// A start value as FMI has it: a number in SI units, a truth value, or the name of an item.
fn start_value(name: &str, value: f64) -> Value {
    match index_by_name(name).map(|i| VARIABLES[i].kind) {
        Some(Kind::Boolean) => json!(value != 0.0),
        Some(Kind::Enumeration) => json!(start_in_words(name, value)),
        _ => json!(value),
    }
}

/// The level that `unit` starts with, and how far its forces were from static contact when the FMU was made; `contact`: at run time.
fn level_error(
    unit: &UnitFile,
    tables: Option<&TableFile>,
    contact: Option<&InterpolationError>,
) -> String {
    let [level, interpolation] = [index::STIFFNESS_MODEL, index::INTERPOLATION]
        .map(|i| start_in_words(VARIABLES[i].name, unit.start(&VARIABLES[i])));
    let error = match (&*level, tables) {
        ("contact", _) => run_time_error(contact),
        ("teeth", Some(TableFile { teeth: Some(t), .. })) => {
            format!("{} against contact at run time", t.error)
        }
        ("table", Some(tables)) => {
            let error = tables.interpolation_error.map(|error| error.to_string());
            let error = error.unwrap_or("not measured".into());
            let mut less = Vec::new();
            let [distances, misalignments, ..] = tables.axes.lengths();
            for (i, nodes) in [
                (index::LOAD_DEPENDENT, 2),
                (index::CENTER_DISTANCE_EFFECT, distances),
                (index::MISALIGNMENT_EFFECT, misalignments),
            ] {
                if unit.start(&VARIABLES[i]) == 0.0 && nodes > 1 {
                    less.push(format!("{} = false", VARIABLES[i].name));
                }
            }
            if interpolation != "spline" {
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
