//! `gearmesh build PAIR.json -o OUT.fmu`: tables and packing in one.

use std::path::PathBuf;

use clap::Args;
use gearmesh_preprocessor::package::Setting;

use crate::model::ModelArgs;
use crate::output::print;
use crate::pack::{self, UnitArgs};
use crate::tables::{self, GridArgs};

/// Compute the tables of a pair and pack them into an FMU.
#[derive(Debug, Args)]
pub struct Build {
    /// Pair file
    pair: PathBuf,

    #[command(flatten)]
    unit: UnitArgs,

    /// Also what stiffnessModel = contact needs: static contact solved at every evaluation of the unit
    #[arg(long)]
    contact: bool,

    #[command(flatten)]
    grid: GridArgs,

    #[command(flatten)]
    model: ModelArgs,
}

impl Build {
    pub fn run(self) -> Result<(), crate::Error> {
        // A missing library shall not cost the time of the tables.
        let libraries = pack::libraries(&self.unit.library)?;
        let UnitArgs { output, set, .. } = &self.unit;
        let mut grid = self.grid;
        // What the unit starts with must be in its tables.
        grid.friction |= set.contains(&Setting::FRICTION);
        grid.root_stress |= set.contains(&Setting::ROOT_STRESS);
        grid.teeth |= set.contains(&Setting::TEETH);
        let contact = self.contact || set.contains(&Setting::CONTACT);
        let made = tables::compute(&self.pair, output, &grid, contact, &self.model)?;
        let contact = made.contact.as_ref();
        let packed = pack::pack_tables(&made.file, contact, &libraries, set, output)?;
        let packed = pack::in_words(&packed, output, &format!("; {}", made.text));
        print(&format!("Wrote {packed}"))?;
        Ok(())
    }
}
