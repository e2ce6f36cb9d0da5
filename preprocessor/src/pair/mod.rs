//! The pair file: from a drawing in JSON to a checked gear pair in SI.
//!
//! [`from_json`] knows every field ([`mod@file`]), fills in the defaults stated there and refuses what
//! cannot work, naming field, value and remedy ([`Refusal`]). What is legal but worth knowing comes as
//! [`Pair::warnings`].

mod bodies;
mod checks;
mod draft;
pub mod drawing;
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
pub use drawing::Gauges;
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
    Ok(read_with_gauges(path)?.0)
}

/// The pair as [`read`] gives it, and with what the tooth thickness of each gear is measured: what the file names, else what
/// is usual.
///
/// # Errors
/// Those of [`read`].
pub fn read_with_gauges(path: impl AsRef<Path>) -> Result<(Pair, [Gauges; 2]), PairError> {
    let path = path.as_ref();
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = text::read_fields(path)?;
    let pair = resolve::resolve(&file, folder)?;
    let gauges = [0, 1].map(|i| {
        let (given, usual) = (
            resolve::gear_file(&file, i),
            Gauges::usual(&pair.geometry.gears[i]),
        );
        Gauges {
            span_teeth: given.span_teeth.unwrap_or(usual.span_teeth),
            ball_diameter: given
                .ball_diameter_mm
                .map_or(usual.ball_diameter, |mm| mm * resolve::MM),
        }
    });
    Ok((pair, gauges))
}

#[cfg(test)]
mod tests;
