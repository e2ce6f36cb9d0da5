//! Static tooth contact: where teeth may touch, what separates them there, and the forces that follow.
//!
//! ```text
//! transverse section ──> candidates: segments of all ──> position: influence matrix, gaps ──> complementarity
//! (extended path)        contact lines on it           local contact law                     (load or approach)
//! ```
//!
//! [`RuntimeContact`] is the solve in the FMU: influence matrices condensed over the mesh cycle ([`CondensedFlank`]), all else from the
//! pose. The preprocessor solves the same [`ContactProblem`] on influence matrices of elastic models, and says more of its solutions.
//!
//! Everything is measured on the line of action at mid-face (docs/theory/contact.md): the approach delta (STE) counts from where
//! the unmodified involutes just touch at the same centre distance, M > 0 closes the side of larger z. The gap of a segment is that
//! of the modified flanks where they come closest (`transverse.rs`), minus what the misalignment closes. It is taken at several points
//! of each segment, so that the edge of the contact moves in small steps; forces and bulk displacements are those of whole segments.
//!
//! Force and approach on the line of action are those of both gears in the mean: F_bt = cos beta_b sum a_i F_i is half the sum of their torques
//! over their base radii, a_i the mean arm of the transverse force about both axes over the base radii; either gear turns half of the
//! approach. The arm is 1, but for a tip edge on the flank of its mate, whose normals touch its own base circle: there the torques are
//! not quite in the ratio of the base radii. So nothing depends on which gear is called gear 1.
//!
//! On bent teeth contact moves along the profile (`bent.rs`).

mod bent;
mod bulk;
mod candidates;
mod complementarity;
mod condensed;
mod error;
mod gap;
mod local_law;
mod position;
mod root_stress;
mod runtime;
mod segment;
mod setup;
mod transverse;

pub use bent::Placed;
pub use bulk::{Influence, Motion};
pub use candidates::{Candidate, ContactLines, along_segment};
pub use complementarity::{MAXIMUM_ITERATIONS, Solution, Start};
pub use condensed::{CondensedFlank, CondensedNode, ContactFile};
pub use error::{ContactError, Failure, Prescribed, finite};
pub use gap::GapProfile;
pub use local_law::{LocalContact, POINTS, PointLoads};
pub use position::{ContactProblem, Tangent};
pub use root_stress::{COMPONENTS, CondensedRoots, Fillet, ROLLS, RootField, RootPoint};
pub use runtime::{ContactPotential, RuntimeContact, Warm};
pub use segment::Segment;
pub use setup::{ContactSettings, ContactSetup, STIFFNESS_OVER_MODULUS};
pub use transverse::TransverseSection;

#[cfg(test)]
mod tests;
