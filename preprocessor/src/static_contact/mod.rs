//! Static contact of a pair at one position of the mesh: elastic models of both gears in, forces, pressures and approach out.
//!
//! The problem is that which the FMU solves, [`gearmesh::contact::ContactProblem`]. What a solution says of pressures and tip edges, how
//! elastic models become influence matrices, and how far tip edges have to be followed is known here alone.

mod deflection;
mod edge_load;
mod error;
mod influence;
mod motion;
mod position;
mod settings;
mod solver;
#[cfg(test)]
mod tests;
mod trials;

pub use deflection::Deflection;
pub use error::ContactError;
pub use position::{ContactResult, EdgeLoad, PositionProblem, Resultant, SegmentLoad};
pub use settings::contact_settings;
pub use solver::ContactSolver;
