//! The pair file: from a drawing in JSON to a checked gear pair in SI.
//!
//! [`from_json`] knows every field ([`mod@file`]), fills in the defaults stated there and refuses what
//! cannot work, naming field, value and remedy ([`Refusal`]). What is legal but worth knowing comes as
//! [`Pair::warnings`].

mod bodies;
mod checks;
mod draft;
mod error;
pub mod file;
mod friction;
mod interference;
mod mesh_checks;
mod modifications;
mod resolve;
mod slips;
mod teeth;
mod text;
mod topography;

use std::path::Path;

pub use checks::TORQUES;
pub use draft::PairDraft;
pub use error::{PairError, Refusal};
pub use teeth::note_on_teeth;

use gearmesh::pair::{Operating, Pair};

/// Reads and checks the text of a pair file: JSON in which comments (`//`, `/* */`, `#`), commas before a
/// closing bracket and a byte-order mark are allowed. Files it names are sought in the working folder.
///
/// # Errors
/// [`PairError::Form`] for text of another form (unknown, missing or mistyped field),
/// [`PairError::Refused`] for a pair that cannot work.
pub fn from_json(text: &str) -> Result<Pair, PairError> {
    let file = text::parse(text)?;
    Ok(resolve::resolve(&file, Path::new(""))?)
}

/// Reads and checks the pair file at `path`.
///
/// Files it names are sought in its folder.
///
/// # Errors
/// [`PairError::Read`] when the file cannot be read, else as [`from_json`].
pub fn read(path: impl AsRef<Path>) -> Result<Pair, PairError> {
    let path = path.as_ref();
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(resolve::resolve(&text::read_fields(path)?, folder)?)
}

#[cfg(test)]
mod tests;
