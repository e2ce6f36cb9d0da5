//! `gearmesh build PAIR.json -o OUT.fmu`: tables and packing in one.

use std::path::PathBuf;

use clap::Args;
use gearmesh::package::Setting;

use crate::model::ModelArgs;
use crate::output;
use crate::pack;
use crate::tables::{self, GridArgs};

/// Compute the tables of a pair and pack them into an FMU.
#[derive(Debug, Args)]
pub struct Build {
    /// Pair file
    pair: PathBuf,

    /// FMU to write
    #[arg(short, long)]
    output: PathBuf,

    /// Compiled library of the unit, once per platform [default: those beside this program]
    #[arg(long)]
    library: Vec<PathBuf>,

    /// Start value of a parameter or input, such as damping=500 or interpolation=shepard; repeatable
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Setting>,

    /// Also what stiffnessModel = contact needs: static contact solved at every evaluation of the unit
    #[arg(long)]
    contact: bool,

    #[command(flatten)]
    grid: GridArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Build {
    /// Computes, packs and says what was made.
    pub fn run(self) -> Result<(), crate::Error> {
        // A missing library shall not cost the time of the tables.
        let libraries = pack::libraries(&self.library)?;
        let mut grid = self.grid;
        // What the unit starts with must be in its tables.
        grid.friction |= self.set.iter().any(Setting::is_friction);
        grid.root_stress |= self.set.iter().any(Setting::is_root_stress);
        grid.teeth |= self.set.iter().any(Setting::is_teeth);
        let contact = self.contact || self.set.iter().any(Setting::is_contact);
        let made = tables::compute(&self.pair, &self.output, &grid, contact, &self.model)?;
        let contact = made.contact.as_ref();
        let packed = pack::pack_tables(&made.file, contact, &libraries, &self.set, &self.output)?;
        output::print(&format!(
            "Wrote {}: {:.2} MB, GUID {}; {made}\n",
            self.output.display(),
            packed.bytes as f64 / 1e6,
            packed.guid,
        ))?;
        Ok(())
    }
}
