//! The FMI 2.0 unit around the element.

pub mod variables;
