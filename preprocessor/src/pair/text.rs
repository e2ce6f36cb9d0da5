//! From the text of a pair file to its fields: JSON, in which comments, commas before a closing bracket and a
//! byte-order mark are allowed.

use std::io::Read;
use std::path::PathBuf;

use super::checks::Refusals;
use super::file::PairFile;
use super::misformed::{Misformed, all_misformed, form};

/// A pair file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PairError {
    /// The file cannot be read.
    #[error(
        "cannot read the pair file {}: {source}; name a pair file that exists and that you may read",
        path.display()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Not JSON, or JSON of another form: unknown or missing fields, wrong types, all that could be found.
    #[error("{}; docs/pair-file.md has every field and its form", in_lines(.0))]
    Form(Vec<Misformed>),
    /// Well-formed, but no gear pair that works.
    #[error(transparent)]
    Refused(#[from] Refusals),
}

/// Each of `fields` on a line of its own.
fn in_lines(fields: &[Misformed]) -> String {
    fields
        .iter()
        .map(|of| format!("pair file, at `{}`: {}", of.field, of.message))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Longest pair file or topography, bytes.
const LONGEST: u64 = 4 << 20;

/// The text of the file at `path`, of at most 4 MiB.
pub(super) fn read(path: &std::path::Path) -> std::io::Result<String> {
    read_up_to(path, LONGEST, "a pair file has a few thousand bytes")
}

/// The text of the file at `path` of at most so many bytes, a number of MiB; `usual` says what such files have.
pub(super) fn read_up_to(
    path: &std::path::Path,
    longest: u64,
    usual: &str,
) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    // One byte more than allowed shows a longer file, even where no length is known.
    let mut file = crate::storage::open(path)?.take(longest + 1);
    let is_long = file.read_to_end(&mut bytes)? as u64 > longest;
    let too_long = format!("longer than {} MiB, and {usual}", longest >> 20);
    let problem = match String::from_utf8(bytes) {
        Err(error) if error.as_bytes().starts_with(b"PK") => {
            "an archive, such as an FMU, and no text"
        }
        _ if is_long => &too_long,
        Err(_) => "no text in UTF-8",
        Ok(text) => return Ok(text),
    };
    Err(std::io::Error::other(format!("it is {problem}")))
}

/// The fields of the file at `path`.
///
/// # Errors
/// [`PairError::Read`] when the file cannot be read, else as [`parse`].
pub(super) fn read_fields(path: &std::path::Path) -> Result<PairFile, PairError> {
    let text = read(path).map_err(|source| PairError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&text)
}

/// The fields of `text`.
///
/// # Errors
/// [`PairError::Form`] with the path and place of each field.
pub(super) fn parse(text: &str) -> Result<PairFile, PairError> {
    let text = &with_line_feeds(text.trim_start_matches('\u{feff}'));
    let mut plain = text.as_bytes().to_vec();
    // A lone `/` ends it early, and what is left of it is an error of the parser at its place.
    let _ = json_strip_comments::strip_slice(&mut plain);
    // Blanks take the place of comments; with their ends of lines, too, places in the file stay what they are.
    for (byte, before) in plain.iter_mut().zip(text.bytes()) {
        if before == b'\n' {
            *byte = before;
        }
    }
    let mut json = serde_json::Deserializer::from_slice(&plain);
    let file = match serde_path_to_error::deserialize(&mut json) {
        Ok(file) => file,
        Err(error) => return Err(PairError::Form(all_misformed(text, &plain, error))),
    };
    json.end()
        .map_err(|error| PairError::Form(vec![form(text, ".", &error)]))?;
    Ok(file)
}

/// As [`parse`], of `fields` that stand in no text.
pub(super) fn parse_fields(fields: &serde_json::Value) -> Result<PairFile, PairError> {
    let file = serde_path_to_error::deserialize(fields);
    file.map_err(|error: serde_path_to_error::Error<serde_json::Error>| {
        PairError::Form(vec![form("", &error.path().to_string(), error.inner())])
    })
}

/// `text` with a line feed in place of each carriage return that ends a line alone, as old editors write them: a comment
/// ends there.
fn with_line_feeds(text: &str) -> String {
    let windows = text.replace("\r\n", " \n");
    windows.replace('\r', "\n")
}
