//! A packed unit driven by the importer of the crate `fmi`.
