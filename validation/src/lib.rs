//! Measures what docs/ says of gearmesh, as CSV files in docs/data:
//! `cargo run --release --package gearmesh-validation -- --help`.

pub mod contact_at_run_time;
pub mod data;
pub mod driver;
pub mod finite_elements;
pub mod setup;
pub mod speed_accuracy;
#[rustfmt::skip] // formatted where it stands
#[path = "../../tests/common/spring.rs"]
mod spring;
pub mod stability;
pub mod tables;
pub mod timing;

use std::path::PathBuf;

/// Whatever a measurement may fail with.
pub type Error = Box<dyn std::error::Error + Send + Sync>;
/// What a measurement gives.
pub type Result<T> = std::result::Result<T, Error>;

/// What every chapter is run with.
pub struct Context {
    /// Fewer points and coarser elements: for trying out, not for the record.
    pub quick: bool,
    /// The interpreter that has fmpy.
    pub python: String,
}

/// `path` of the repository, wherever the program is started.
pub fn in_repository(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}
