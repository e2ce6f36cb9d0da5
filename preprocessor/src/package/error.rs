//! Why an FMU cannot be packed or read.

use std::path::Path;

/// Why an FMU could not be packed or read: a file that cannot be read or written or is not what it should be, or start values
/// that no host could start with.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct PackageError(String);

impl PackageError {
    pub(super) fn file(path: &Path, source: std::io::Error) -> Self {
        let remedy = "name a file that can be read, or a folder that can be written";
        PackageError::contents(path, format!("{source}; {remedy}"))
    }

    pub(super) fn archive(path: &Path, source: zip::result::ZipError) -> Self {
        let remedy = "name an FMU that `gearmesh pack` or `gearmesh build` wrote, or pack it again";
        PackageError::contents(path, format!("{source}; {remedy}"))
    }

    pub(super) fn contents(path: &Path, reason: impl std::fmt::Display) -> Self {
        PackageError(format!("{}: {reason}", path.display()))
    }

    pub(super) fn starts(reason: &str) -> Self {
        let problem = "the FMU does not start with these values";
        PackageError(format!("{problem}: {reason}"))
    }
}
