//! From the drawing of a gear pair to what the FMU of `gearmesh` needs.
//!
//! [`pair`] reads and checks the pair file, [`shaft`] bends its shafts, [`finite_element`] computes how teeth and blanks give way,
//! [`contact`] solves mesh cycles and condenses the elastic models for contact at run time, [`table`] sweeps the static contact,
//! [`package`] packs the FMU, and [`run_up`] sweeps its speed.

pub mod contact;
pub mod finite_element;
pub mod import;
mod iso_6336_1;
mod iso_6336_3;
pub mod package;
pub mod pair;
pub mod run_up;
pub mod shaft;
pub mod storage;
pub mod table;

pub use iso_6336_1::{NominalContactStress, NominalStiffness};
pub use iso_6336_3::{NominalRootStress, RootSection};

// Shared with tests/.
#[cfg(test)]
#[path = "../../tests/common/gears.rs"]
mod samples;
#[cfg(test)]
#[path = "../../tests/common/spring.rs"]
mod spring;
