//! `gearmesh pack`: tables or a pair, and the compiled library, into one .fmu file; `gearmesh build`: from a pair through its
//! tables.

use std::path::PathBuf;

use clap::Args;
use gearmesh::contact::ContactFile;
use gearmesh::table::TableFile;
use gearmesh_preprocessor::package::{self, Contents, Library, Setting, Starts};
use gearmesh_preprocessor::pair;

use crate::error::{Result, chain};
use crate::model::ModelArgs;
use crate::output;
use crate::recipe::{self, Computed, GridArgs};

/// Pack tables, or a pair with constant stiffness, into an FMU.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("source").required(true))]
pub struct Pack {
    /// Tables that `gearmesh tables` or `gearmesh import` wrote.
    #[arg(long, group = "source")]
    tables: Option<PathBuf>,
    /// Pair file: the FMU has constant stiffness and no tables.
    #[arg(long, group = "source")]
    pair: Option<PathBuf>,
    #[command(flatten)]
    unit: UnitArgs,
}

#[derive(Debug, Args)]
struct UnitArgs {
    /// FMU to write
    #[arg(short, long)]
    output: PathBuf,

    /// Compiled library of the FMU, once per platform [default: those in the folder of this program]
    #[arg(long)]
    library: Vec<PathBuf>,

    /// Start value of a parameter or input, such as damping=500 or interpolation=shepard; repeatable
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
}

impl UnitArgs {
    /// The libraries that were named, or those in the folder of this program.
    ///
    /// Start values given twice are refused before.
    fn libraries(&self) -> Result<Vec<Library>> {
        Setting::check_once(&self.set)?;
        if self.library.is_empty() {
            return Ok(package::libraries_beside(&std::env::current_exe()?)?);
        }
        let libraries = self.library.iter().map(|path| Library::read(path));
        Ok(libraries.collect::<Result<_, _>>()?)
    }

    /// Packs the FMU of these tables and of `contact` at run time; returns what is to be said of it.
    fn pack_tables(
        &self,
        tables: &TableFile,
        contact: Option<&ContactFile>,
        libraries: &[Library],
        more: &str,
    ) -> Result<String> {
        let contents = Contents {
            name: &tables.name,
            geometry: &tables.geometry,
            contact,
            starts: &Starts::of_tables(tables)?.with(&self.set),
        };
        self.pack(&contents, libraries, more)
    }

    /// Packs `contents`; returns what was packed and `more` about it, with a last line where it runs on one platform alone.
    fn pack(&self, contents: &Contents, libraries: &[Library], more: &str) -> Result<String> {
        let packed = package::pack(contents, libraries, &self.output)?;
        let words = format!(
            "{}: {:.2} MB, GUID {}, runs on {}{more}\n",
            self.output.display(),
            packed.bytes as f64 / 1e6,
            packed.guid,
            packed.platforms.join(" and ")
        );
        let [only] = &packed.platforms[..] else {
            return Ok(words);
        };
        let platform = only.split(' ').next().unwrap_or(only);
        let other = match platform {
            "win64" => "Linux",
            _ => "Windows",
        };
        Ok(format!(
            "{words}{platform} only: for {other} as well, give the libraries of a release, --library libgearmesh.so --library gearmesh.dll\n"
        ))
    }
}

impl Pack {
    pub fn run(self) -> Result<()> {
        output::check_writable(&self.unit.output, self.tables.iter().chain(&self.pair))?;
        let libraries = self.unit.libraries()?;
        let words = if let Some(tables) = &self.tables {
            let text = output::read_text(tables)?;
            let file = TableFile::from_json(&text).map_err(|error| {
                let (tables, error) = (tables.display(), chain(&error));
                let remedy = match output::is_tables(&text) {
                    true => "",
                    false => "; a pair file is packed by `--pair`",
                };
                format!("--tables = {tables}: {error}{remedy}")
            })?;
            self.unit.pack_tables(&file, None, &libraries, "")?
        } else {
            let pair = pair::read(self.pair.as_deref().unwrap_or("".as_ref()))?;
            let starts = Starts::constant_stiffness(&pair.geometry, pair.operating.nominal_torque);
            let contents = Contents {
                name: &pair.name,
                geometry: &pair.geometry,
                contact: None,
                starts: &starts.with(&self.unit.set),
            };
            self.unit.pack(&contents, &libraries, "")?
        };
        output::print(&words)
    }
}

/// Compute the tables of a pair and pack them into an FMU.
#[derive(Debug, Args)]
pub struct Build {
    /// Pair file
    pair: PathBuf,

    #[command(flatten)]
    unit: UnitArgs,

    /// Also what stiffnessModel = contact needs: static contact solved at every evaluation of the FMU
    #[arg(long)]
    contact: bool,

    #[command(flatten)]
    grid: GridArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Build {
    pub fn run(self) -> Result<()> {
        // A missing library shall not cost the time of the tables.
        let (unit, set) = (&self.unit, &self.unit.set);
        let libraries = unit.libraries()?;
        let (mut grid, mut model) = (self.grid, self.model);
        // What the FMU starts with must be in its tables.
        grid.friction |= set.contains(&Setting::FRICTION);
        model.root_stress |= set.contains(&Setting::ROOT_STRESS);
        grid.teeth |= set.contains(&Setting::TEETH);
        let contact = self.contact || set.contains(&Setting::CONTACT);
        let Computed { made, text } =
            recipe::compute(&self.pair, &unit.output, &grid, contact, &model)?;
        let more = format!("; {text}");
        let words = unit.pack_tables(&made.file, made.contact.as_ref(), &libraries, &more)?;
        output::print(&format!("Wrote {words}"))
    }
}
