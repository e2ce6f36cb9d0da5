//! `gearmesh tables PAIR.json -o TABLES.json`: the static contact of a pair over its operating range; `gearmesh import
//! SAMPLES.csv --pair PAIR.json -o TABLES.json`: that of another contact program.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::table::import::{Imported, import_csv};
use gearmesh_preprocessor::{pair, table};

use crate::error::Result;
use crate::model::ModelArgs;
use crate::output;
use crate::recipe::{Computed, GridArgs, compute};

/// Compute the tables of a pair.
#[derive(Debug, Args)]
pub struct Tables {
    /// Pair file
    pair: PathBuf,

    /// Tables to write
    #[arg(short, long)]
    output: PathBuf,

    #[command(flatten)]
    grid: GridArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Tables {
    pub fn run(self) -> Result<()> {
        let Computed { made, text } =
            compute(&self.pair, &self.output, &self.grid, false, &self.model)?;
        output::write_whole(&self.output, made.file.to_json().as_bytes())?;
        output::print(&format!("Wrote {}: {text}\n", self.output.display()))
    }
}

/// Make tables of the samples of another contact program.
///
/// CSV with a header and the columns torque_nm, mesh_position, center_distance_offset_um,
/// misalignment_mrad, ste_loa_um, contact_z_mm; one row for every point of a full grid. At least four torques above 0; of mesh
/// positions, centre distances and misalignments at least four each, or one, which leaves that axis out.
#[derive(Debug, Args)]
pub struct Import {
    /// Samples of the drive flank
    samples: PathBuf,

    /// Pair file that the samples belong to
    #[arg(long)]
    pair: PathBuf,

    /// Samples of the coast flank [default: the drive flank's, mirrored]
    #[arg(long)]
    coast: Option<PathBuf>,

    /// Tables to write
    #[arg(short, long)]
    output: PathBuf,
}

impl Import {
    pub fn run(self) -> Result<()> {
        let files = [&self.pair, &self.samples].into_iter().chain(&self.coast);
        output::check_writable(&self.output, files)?;
        let pair = pair::read(&self.pair)?;
        let nominal = pair.operating.nominal_torque;
        let drive = samples(&self.samples, &pair)?;
        let coast = self.coast.as_ref().map(|path| samples(path, &pair));
        let coast = coast.transpose()?;
        if coast.is_none() && !pair.coast_mirrors_drive() {
            refuse!(
                "{}: modifications or face offset make the flanks differ; give the samples of the coast flank with --coast",
                self.pair.display()
            );
        }
        let file = TableFile::new(
            &pair.name,
            &format!("samples in {}", self.samples.display()),
            &pair.geometry,
            [nominal, drive.maximum_torque],
            &drive.grid,
            coast.as_ref().map(|c| &c.grid),
        );
        file.check()?;
        output::write_whole(&self.output, file.to_json().as_bytes())?;
        let (path, words) = (self.output.display(), table::size_and_error(&file));
        output::print(&format!("Wrote {path}: {words}\n"))
    }
}

/// The samples of `pair` in the file at `path`; standard error has a note on what is doubtful in them.
fn samples(path: &Path, pair: &Pair) -> Result<Imported> {
    let file = path.display();
    let imported = import_csv(&output::read_text(path)?, &pair.geometry)
        .map_err(|error| format!("{file}: {error}"))?;
    let doubt = imported
        .doubt(&pair.geometry, pair.operating.nominal_torque)
        .map_err(|error| format!("{file}: {error}"))?;
    if let Some(doubt) = doubt {
        eprintln!("gearmesh: note: {file}: {doubt}");
    }
    Ok(imported)
}
