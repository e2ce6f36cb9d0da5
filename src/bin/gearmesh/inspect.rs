//! `gearmesh inspect FILE`: what is in a file that gearmesh reads or writes.

use std::path::PathBuf;

use clap::Args;
use gearmesh::pair::Pair;

use crate::output;
use crate::pair_summary::pair_summary;

/// Show what is in a pair file.
#[derive(Debug, Args)]
pub struct Inspect {
    /// The file.
    file: PathBuf,
}

impl Inspect {
    /// Prints the summary.
    pub fn run(self) -> Result<(), crate::Error> {
        let pair = Pair::read(&self.file)?;
        output::print(&pair_summary(&pair))?;
        Ok(())
    }
}
