//! From the drawing of a gear pair to the FMU of `gearmesh`.
//!
//! | module | in | out |
//! |---|---|---|
//! | [`pair`], [`import`] | pair file, file of another program | checked pair in SI, [`gear::Pair`] |
//! | [`gear`] | checked pair | generated teeth, bodies, flank tolerances |
//! | [`finite_element`] | gear | displacement of its flanks under load, stress in its tooth roots |
//! | [`static_contact`] | pair, elastic models ([`compliance`]) | contact at one position of the mesh |
//! | [`shaft`] | shafts on bearings | how far they take the flanks apart |
//! | [`contact`] | pair | elastic models, static contact over mesh cycles, contact for run time |
//! | [`table`] | elastic models, a recipe | tables of static contact with their error |
//! | [`package`] | tables | FMU |
//! | [`run_up`] | FMU | vibration over the speed |
//!
//! The whole way, `examples/drawing_to_fmu.rs`:
//!
//! ```no_run
#![doc = include_str!("../../examples/drawing_to_fmu.rs")]
//! ```

pub mod compliance;
pub mod contact;
pub mod finite_element;
pub mod gear;
pub mod import;
mod iso_6336_1;
mod iso_6336_3;
pub mod package;
pub mod pair;
pub mod run_up;
pub mod shaft;
pub mod static_contact;
pub mod storage;
pub mod table;

pub use iso_6336_1::{NominalContactStress, NominalStiffness, theoretical_pair_stiffness};
pub use iso_6336_3::{NominalRootStress, RootSection};

// Shared with tests/.
#[cfg(test)]
#[path = "../../tests/common/gears.rs"]
mod samples;
#[cfg(test)]
#[path = "../../tests/common/spring.rs"]
mod spring;
