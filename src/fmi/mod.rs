//! The FMI 2.0 unit around the element.
//!
//! ```text
//! host ── c_interface ── instance ── element
//!         pointers,      state       pure function
//!         panics, log    machine     of poses
//! ```
//!
//! [`variables`] is generated from modelDescription.xml; [`resources`] reads what packing put beside
//! the library. Only [`c_interface`] has unsafe code.

mod boundary;
pub mod c_interface;
mod derivatives;
pub mod instance;
pub mod lifecycle;
mod parameters;
pub mod report;
pub mod resources;
mod signals;
mod snapshot;
mod stored;
mod values;
pub mod variables;
