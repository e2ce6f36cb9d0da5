//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::package;
use gearmesh::pair::Pair;
use gearmesh::table::{Table, TableFile};

use crate::Error;
use crate::output::{self, Listing};
use crate::pair_summary::pair_summary;
use crate::tables;

/// Show what is in a pair file, in tables or in an FMU.
#[derive(Debug, Args)]
pub struct Inspect {
    /// The file
    file: PathBuf,
}

impl Inspect {
    /// Prints the summary.
    pub fn run(self) -> Result<(), Error> {
        let bytes =
            std::fs::read(&self.file).map_err(|error| output::unreadable(&self.file, &error))?;
        let text = if bytes.starts_with(b"PK") {
            fmu(&self.file)?
        } else {
            let text = String::from_utf8(bytes).map_err(|_| {
                format!(
                    "{}: neither text nor an archive; name a pair file, tables or an FMU",
                    self.file.display()
                )
            })?;
            let place = |error: Error| format!("{}: {error}", self.file.display());
            match is_tables(&text) {
                true => table_file(&TableFile::from_json(&text).map_err(|e| place(e.into()))?)?,
                false => pair_summary(&Pair::from_json(&text).map_err(|e| place(e.into()))?),
            }
        };
        output::print(&text)?;
        Ok(())
    }
}

/// Tables say their format; a pair file does not.
fn is_tables(text: &str) -> bool {
    serde_json::from_str::<serde_json::Value>(text)
        .is_ok_and(|value| value.get("format").is_some() && value.get("axes").is_some())
}

fn table_file(file: &TableFile) -> Result<String, Error> {
    let table = Table::from_file(file.clone())?;
    let mut rows = Listing::default();
    rows.row("made by", &file.generator)
        .row("from", &file.source)
        .row("size and error", tables::in_words(file))
        .row(
            "torque on gear 1",
            format!(
                "nominal {} Nm, up to {} Nm",
                file.nominal_torque_nm, file.maximum_torque_nm
            ),
        )
        .row(
            "displacement",
            range(
                &file.axes.displacement_fraction,
                1.0,
                "from no-load to top-load approach",
            ),
        )
        .row(
            "centre distance offset",
            range(&file.axes.center_distance_offset_m, 1e6, "um"),
        )
        .row(
            "misalignment",
            range(&file.axes.misalignment_rad, 1e3, "mrad"),
        )
        .row(
            "mesh position",
            range(&file.axes.mesh_position, 1.0, "base pitches, periodic"),
        )
        .row(
            "centre distance",
            format!("{:.4} mm", table.geometry().center_distance * 1e3),
        )
        .row("checksum", &file.checksum_sha256);
    for (name, value) in &file.solver {
        rows.row(format!("solver: {name}"), value.to_string());
    }
    Ok(format!("{}: tables\n{rows}", file.name))
}

fn range(nodes: &[f64], scale: f64, unit: &str) -> String {
    match nodes {
        [] => "none".into(),
        [only] => format!("{:.4} {unit}, no axis", only * scale),
        [first, .., last] => format!(
            "{:.4} to {:.4} {unit}, {} nodes",
            first * scale,
            last * scale,
            nodes.len()
        ),
    }
}

fn fmu(path: &Path) -> Result<String, Error> {
    let found = package::inspect(path)?;
    let mut rows = Listing::default();
    rows.row("GUID", &found.unit.guid)
        .row("platforms", found.platforms.join(", "));
    for (name, value) in &found.unit.starts {
        rows.row(format!("start: {name}"), format!("{value}"));
    }
    for (name, size) in &found.files {
        rows.row(format!("file: {name}"), format!("{size} bytes"));
    }
    let mut text = format!("{}: FMU\n{rows}", found.unit.name);
    if let Some(tables) = &found.tables {
        let _ = write!(text, "\n{}", table_file(&TableFile::from_json(tables)?)?);
    }
    Ok(text)
}
