//! `gearmesh pack`: tables or a pair, and the compiled library, into one .fmu file.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::contact::ContactFile;
use gearmesh::package::{self, Contents, Library, Packed, Setting, Starts};
use gearmesh::pair::Pair;
use gearmesh::table::TableFile;

use crate::{interrupt, output};

/// Pack tables, or a pair with constant stiffness, into an FMU.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("source").required(true))]
pub struct Pack {
    /// Tables that `gearmesh tables` or `gearmesh import` wrote.
    #[arg(long, group = "source")]
    tables: Option<PathBuf>,
    /// Pair file: the unit has constant stiffness and no tables.
    #[arg(long, group = "source")]
    pair: Option<PathBuf>,
    /// The FMU to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Compiled library of the unit, once per platform [default: those beside this program].
    #[arg(long)]
    library: Vec<PathBuf>,
    /// Start value of a parameter or input, such as damping=500 or interpolation=shepard; repeatable.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
}

impl Pack {
    /// Packs and prints name, GUID and size.
    pub fn run(self) -> Result<(), crate::Error> {
        let read = self.tables.iter().chain(&self.pair);
        let read: Vec<&Path> = read.map(PathBuf::as_path).collect();
        output::check_writable(&self.output, &read)?;
        let libraries = libraries(&self.library)?;
        let packed = if let Some(path) = &self.tables {
            let text = output::read_text(path)?;
            pack_tables(
                &TableFile::from_json(&text)?,
                None,
                &libraries,
                &self.set,
                &self.output,
            )?
        } else {
            let pair = Pair::read(self.pair.as_deref().unwrap_or("".as_ref()))?;
            let starts = Starts::constant_stiffness(&pair.geometry, pair.operating.nominal_torque);
            let contents = Contents {
                name: &pair.name,
                geometry: &pair.geometry,
                tables: None,
                contact: None,
                starts: &starts.with(&self.set),
            };
            interrupt::uninterrupted(|| package::pack(&contents, &libraries, &self.output))?
        };
        let (path, size) = (self.output.display(), packed.bytes as f64 / 1e6);
        output::print(&format!("{path}: {size:.2} MB, GUID {}\n", packed.guid))?;
        Ok(())
    }
}

/// Packs the unit of these tables and of `contact` at run time with the start values of `settings`.
pub fn pack_tables(
    tables: &TableFile,
    contact: Option<&ContactFile>,
    libraries: &[Library],
    settings: &[Setting],
    output: &Path,
) -> Result<Packed, crate::Error> {
    let contents = Contents {
        name: &tables.name,
        geometry: &tables.geometry.pair_geometry()?,
        tables: Some(tables),
        contact,
        starts: &Starts::of_tables(tables)?.with(settings),
    };
    let packed = interrupt::uninterrupted(|| package::pack(&contents, libraries, output))?;
    Ok(packed)
}

/// The libraries at `paths`, or those beside this program if there are none.
pub fn libraries(paths: &[PathBuf]) -> Result<Vec<Library>, crate::Error> {
    if paths.is_empty() {
        return Ok(package::libraries_beside(&std::env::current_exe()?)?);
    }
    Ok(paths
        .iter()
        .map(|p| Library::read(p))
        .collect::<Result<_, _>>()?)
}
