//! The FMI 2.0 unit around the element.
//!
//! ```text
//! host ── c_interface ── instance ── element
//!         pointers,      state       pure function
//!         panics, log    machine     of poses
//! ```
//!
//! [`variables`] is generated from modelDescription.xml; [`resources`] reads what packing put beside
//! the library. In the product only [`c_interface`] and the vector registers of the table's kernel
//! (src/table/interpolation/lanes.rs) have unsafe code; the tests that call the interface as C does
//! (c_interface_tests.rs here and tests/c_interface.rs) need it for that, and nothing else may have any.

mod boundary;
pub mod c_interface;
mod derivatives;
pub mod instance;
pub mod lifecycle;
mod location;
mod parameters;
pub mod report;
pub mod resources;
mod signals;
mod snapshot;
mod stored;
mod values;
pub mod variables;
