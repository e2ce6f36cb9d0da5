//! The FMI 2.0 unit around the element.
//!
//! ```text
//! host ── c_interface ── instance ─┬─ co_simulation ── unit ── mesh ── element
//!         pointers,      state     │  clock, inputs    pure function of inputs,
//!         panics, log    machine   └─ model exchange   parameters and phases
//! ```
//!
//! [`variables`] is generated from modelDescription.xml, and [`layout`] alone knows how many bodies and
//! meshes there are; [`resources`] reads what packing put beside
//! the library. In the product only [`c_interface`] and the vector registers of the table's kernel
//! (src/table/interpolation/lanes.rs) have unsafe code; the tests that call the interface as C does
//! (c_interface_tests.rs here and tests/c_interface.rs) need it for that, and nothing else may have any.

mod boundary;
pub mod c_interface;
mod clock;
mod co_simulation;
pub mod contact_law;
mod inputs;
pub mod instance;
#[cfg(test)]
mod instance_tests;
pub mod layout;
pub mod lifecycle;
mod location;
mod mesh;
mod polynomials;
pub mod report;
pub mod resources;
pub mod settings;
mod snapshot;
mod stored;
pub(crate) mod unit;
pub mod values;
pub mod variables;
