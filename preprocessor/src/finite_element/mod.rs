//! Finite-element compliance of one gear: all teeth, rim and web down to the held surface.
//!
//! ```text
//!  gear::ToothProfile ─> outline ─> section ─> mesh ─> condensation ─> ring ─> influence
//!                        by arc     one tooth   along   fronts,         whole   of flank
//!                        length     sector      helix   sides left      gear,   nodes
//!                                                                       periodic
//!                                                                       body
//! ```
//!
//! The result are the matrices C_k of normal displacements of the flank nodes of tooth k per unit normal load on the flank
//! nodes of tooth 0 (docs/theory/compliance.md). A [`Segment`](gearmesh::contact::Segment) is a line load spread across its contact line by a smooth
//! kernel; weights f on the flank nodes give the influence f_i^T C f_j. It contains the kernel's own local displacement,
//! and [`reference_lengths`](crate::compliance::ToothCompliance::reference_lengths) says how much, so that the sum with the Hertz contact does not depend
//! on the kernel's width.

mod cache;
mod condensation;
mod cylinder;
mod dense;
mod element;
mod error;
mod flank;
mod fronts;
mod gear_model;
mod harmonics;
mod influence;
mod mesh;
mod mirror;
mod model;
mod outline;
mod pair_models;
mod periodic_body;
mod ring;
mod root_stress;
mod section;
mod sector_nodes;
mod settings;
mod uneven;
mod work;

pub use cache::{CachedModel, ModelCache, Origin};
pub use error::FiniteElementError;
pub use gear_model::FiniteElementCompliance;
pub use model::{Progress, Stage, centre_line_compliance, sector_section, sector_unknowns};
pub use pair_models::{PairCompliance, PairModels, pair_root_stress};
pub use root_stress::{RootStress, SpreadSegments};
pub use settings::{Discretization, Settings};
pub(crate) use uneven::{basis as body_basis, stiffness as body_stiffness};

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod closure_tests;
#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod tests;
