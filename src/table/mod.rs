//! Tables of force and shuttling over (displacement, centre distance, misalignment, mesh position).
//!
//! # Coordinates
//! The displacement delta is scaled between the no-load approach D0(C, M, PMC) and the top-load approach D1(C, M, PMC):
//! u = (delta - D0) / (D1 - D0). The onset of contact is u = 0 everywhere, never inside a cell.
//!
//! # One potential
//! A flank is a potential W(delta, C, M, PMC) (see [`Potential`]): the force is dW/d delta, shuttling dW/dM, and
//! dW/dC and dW/dPMC close the energy balance.

mod error;
mod file;
mod grid;
mod interpolation;
mod records;
mod runtime;
#[cfg(test)]
#[path = "../../tests/common/spring.rs"]
pub mod samples;
mod summary;
mod teeth;

pub use crate::accuracy::{InterpolationError, RootStressError, rms_and_largest};
pub use error::TableError;
pub use file::{TableFile, VERSION};
pub use grid::{Axes, Axis, FlankGrid};
pub use interpolation::{FlankTable, Interpolation};
pub use records::{
    Columns, FrictionRecord, LoadAxes, LoadJet, LoadSpline, RootStressRecord, RootStressSamples,
    SlidingSamples,
};
pub use runtime::{Effects, Load, Table};
pub use teeth::{GearTeethRecord, TeethFlank, TeethRecord};

/// A point of the table of one flank (coast flank: after mapping to its own table).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Query {
    /// Approach of the teeth on the line of action at mid-face, m; > 0 in contact.
    pub delta: f64,
    /// Actual minus nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Misalignment in the plane of action, rad; > 0: more penetration at larger z.
    pub misalignment: f64,
    /// Position on the mesh cycle, in base pitches; periodic.
    pub mesh_position: f64,
}

/// Number of coordinates of a [`Query`], in the order of its fields.
pub const COORDINATES: usize = 4;

impl Query {
    /// Its fields, in their order.
    pub fn coordinates(&self) -> [f64; COORDINATES] {
        let Query {
            delta,
            center_distance_offset,
            misalignment,
            mesh_position,
        } = *self;
        [delta, center_distance_offset, misalignment, mesh_position]
    }
}

impl From<[f64; COORDINATES]> for Query {
    fn from(coordinates: [f64; COORDINATES]) -> Self {
        let [delta, center_distance_offset, misalignment, mesh_position] = coordinates;
        Query {
            delta,
            center_distance_offset,
            misalignment,
            mesh_position,
        }
    }
}

/// The potential of one flank and its derivatives by the coordinates of [`Query`] in their order
/// (delta, centre distance offset, misalignment, mesh position). All zero out of contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Potential {
    /// W, J.
    pub value: f64,
    /// First derivatives: F_bt = `gradient[0]`, shuttling moment F_bt (z_c - z_ref) = `gradient[2]`, z_c where the resultant
    /// crosses the pitch plane.
    pub gradient: [f64; COORDINATES],
    /// `hessian[i][j]` = d `gradient[i]` / d coordinate j. `hessian[0][0]`, the tangent stiffness on the
    /// line of action, is always there, the rest zero unless requested. Symmetric, but for row 2 where
    /// the moment is not dW/dM: tables without a misalignment axis, and constant load.
    pub hessian: [[f64; COORDINATES]; COORDINATES],
    /// True where a coordinate lies outside the table's range (continued linearly).
    pub out_of_range: bool,
}
