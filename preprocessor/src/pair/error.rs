//! Why a pair file is refused.

use std::path::PathBuf;

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
    /// Not JSON, or JSON of another form: unknown or missing field, wrong type.
    #[error("pair file, at `{field}`: {message}; docs/pair-file.md has every field and its form")]
    Form {
        /// Path of the field, such as `gear1.tip_relief.shape`; `.` is the whole file.
        field: String,
        /// What is wrong, the names expected, line and column.
        message: String,
    },
    /// Well-formed, but no gear pair that works.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// One value that cannot be, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("pair file: `{field}` = {value}: {problem}; {remedy}")]
pub struct Refusal {
    /// Path of the field, such as `gear1.teeth`.
    pub field: String,
    /// The value given, or the default that stood in for it, in the unit of the field.
    pub value: String,
    /// What is wrong with it.
    pub problem: String,
    /// What to change.
    pub remedy: String,
}

/// The refusal of a value: field `=>` value; problem; remedy, both as for `format!`.
macro_rules! refusal {
    ($field:expr => $value:expr; $problem:literal $(, $p:expr)*; $remedy:literal $(, $r:expr)*) => {
        $crate::pair::Refusal {
            field: String::from($field),
            value: gearmesh::words::shown(&($value).to_string()),
            problem: format!($problem $(, $p)*),
            remedy: format!($remedy $(, $r)*),
        }
    };
}

/// Returns the [`refusal!`] of a value unless it is fine; a comparison with NaN is not.
macro_rules! ensure {
    ($fine:expr, $($refusal:tt)*) => {
        let is_fine: bool = $fine;
        if !is_fine {
            return Err($crate::pair::error::refusal!($($refusal)*));
        }
    };
}

pub(super) use {ensure, refusal};
