//! Interpolants on the grid of a table: linear, C2 spline, Shepard, each one potential with analytic
//! derivatives, periodic in mesh position.

// Loops over the few lanes of a register read best by index, in step through several arrays.
#![allow(clippy::needless_range_loop)]

mod basis;
mod fit;
mod kernel;
mod load;
mod shepard;
mod tensor;

pub(crate) use basis::{Basis, Ends};
pub(crate) use fit::{at_zero, axis};
pub use load::{LoadJet, LoadSpline};

use super::{FlankGrid, Potential, Query, TableError};
use crate::root::bisection;
use crate::vector::Lanes;
use shepard::Shepard;
use tensor::Tensor;

/// How values between the nodes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Multilinear force: continuous, kinks at the nodes.
    Linear,
    /// Tensor cubic spline: force twice continuously differentiable.
    Spline,
    /// Shepard's method with C2 weights, as in the paper: one potential with continuous second
    /// derivatives, exactly zero up to the onset. The force is not kept from falling over the displacement; beyond the range of an axis the
    /// stiffness goes over into a constant within one cell. The onset itself, and a constant load, follow the spline.
    Shepard,
}

/// The potential of one flank as the element needs it, with just the dimensions that are switched on.
#[derive(Debug)]
pub struct FlankTable {
    interpolant: Interpolant,
    lanes: Lanes,
}

#[derive(Debug)]
enum Interpolant {
    Linear(Tensor<3, 2>),
    Spline(Tensor<5, 4>),
    /// Constant load over smooth coordinates.
    Secant(Tensor<3, 4>),
    Shepard(Box<Shepard>),
}

impl FlankTable {
    /// Variable load: the potential over displacement and whatever axes `grid` has.
    ///
    /// # Errors
    /// Nodes through which no spline passes; a span that is not positive everywhere.
    pub fn new(grid: &FlankGrid, interpolation: Interpolation) -> Result<Self, TableError> {
        grid.check("samples")?;
        let spline = || Tensor::<5, 4>::new::<4>(grid);
        Ok(Self::evaluated_widest(match interpolation {
            Interpolation::Linear => Interpolant::Linear(Tensor::new::<2>(grid)?),
            Interpolation::Spline => Interpolant::Spline(spline()?),
            Interpolation::Shepard => {
                Interpolant::Shepard(Box::new(Shepard::new(grid, spline()?)?))
            }
        }))
    }

    fn evaluated_widest(interpolant: Interpolant) -> Self {
        FlankTable {
            interpolant,
            lanes: Lanes::widest(),
        }
    }

    /// Constant load: the stiffness is the secant at the force `loa_force` (N, transverse, line of
    /// action), paper (21)-(22): F = `loa_force` (delta - O) / (STE - O) with STE(C, M, PMC) at that force.
    ///
    /// O is zero without misalignment, as in the paper. With it, O is the way by which the misalignment moves
    /// the first touch of the mesh cycle: measured at mid-face, STE is negative for a few tenths of
    /// a milliradian already, and a secant through delta = 0 would have a negative stiffness.
    ///
    /// The moment of shuttling is F (z_c - z_ref) with z_c at that force; it is not dW/dM, since a secant
    /// law does not follow the contact.
    ///
    /// # Errors
    /// A force that is not positive or above the range; an STE that is not positive.
    pub fn constant_load(
        grid: &FlankGrid,
        interpolation: Interpolation,
        loa_force: f64,
    ) -> Result<Self, TableError> {
        grid.check("samples")?;
        Ok(Self::evaluated_widest(match interpolation {
            Interpolation::Linear => Interpolant::Linear(Tensor::constant_load(grid, loa_force)?),
            Interpolation::Spline | Interpolation::Shepard => {
                Interpolant::Secant(Tensor::constant_load(grid, loa_force)?)
            }
        }))
    }

    /// The potential at `query`, with first derivatives and the tangent stiffness `hessian[0][0]`; the
    /// other second derivatives only if `want_hessian`. Exactly zero out of contact.
    ///
    /// Outside the range of an axis loads go on with continuous slopes, and `out_of_range` is set. Beyond the largest displacement
    /// the force is linear. Beyond an end of C or M the onset of contact is linear, and the slopes of stiffness and of the moment
    /// under a force fall to zero: far out the resultant is where the teeth touch first, and the force never decreases over
    /// the displacement.
    ///
    /// A NaN in the query gives NaN or zero, never a panic.
    #[inline]
    pub fn evaluate(&self, query: &Query, want_hessian: bool) -> Potential {
        match &self.interpolant {
            Interpolant::Linear(tensor) => tensor.evaluate(self.lanes, query, want_hessian),
            Interpolant::Spline(tensor) => tensor.evaluate(self.lanes, query, want_hessian),
            Interpolant::Secant(tensor) => tensor.evaluate(self.lanes, query, want_hessian),
            Interpolant::Shepard(shepard) => shepard.evaluate(self.lanes, query),
        }
    }

    /// Displacement at `query` in units of the grid: 0 where contact begins, 1 at the top load.
    pub fn fraction(&self, query: &Query) -> f64 {
        match &self.interpolant {
            Interpolant::Linear(tensor) => tensor.frame.fraction(query),
            Interpolant::Spline(tensor) => tensor.frame.fraction(query),
            Interpolant::Secant(tensor) => tensor.frame.fraction(query),
            Interpolant::Shepard(shepard) => shepard.frame.fraction(query),
        }
    }

    /// Approach (m) at which the transverse force on the line of action is `force` (N), > 0, with the rest as in `pose`.
    pub fn approach_at(&self, force: f64, pose: &Query) -> f64 {
        let carried = |delta| self.evaluate(&Query { delta, ..*pose }, false).gradient[0];
        let below = |delta: f64| carried(delta) < force;
        let mut high = 1e-3;
        while below(high) && high < 1.0 {
            high *= 2.0;
        }
        bisection([-1e-3, high], 60, below)
    }

    /// Memory of the coefficients, bytes.
    pub fn bytes(&self) -> usize {
        match &self.interpolant {
            Interpolant::Linear(tensor) => tensor.bytes(),
            Interpolant::Spline(tensor) => tensor.bytes(),
            Interpolant::Secant(tensor) => tensor.bytes(),
            Interpolant::Shepard(shepard) => shepard.bytes(),
        }
    }
}

#[cfg(test)]
mod tests;
