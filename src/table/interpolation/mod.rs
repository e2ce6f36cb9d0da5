//! Interpolants on the grid of a table: linear, C2 spline, Shepard, each one potential with analytic
//! derivatives, periodic in mesh position.

// Loops over the few lanes of a register read best by index, in step through several arrays.
#![allow(clippy::needless_range_loop)]

mod basis;
mod chain;
mod compiled;
mod continuation;
mod fit;
mod frame;
mod jet;
mod kernel;
mod lanes;
mod line;
mod scatter;
mod secant;
mod shepard;
mod tensor;

pub(crate) use basis::{Basis, Ends};
pub(crate) use compiled::ANY;
pub(crate) use fit::{Block, Fit, breaks, row_at};
pub(crate) use kernel::{Coefficients, over_displacement};
pub(crate) use lanes::Two;
pub(crate) use tensor::axis_basis;

use super::{FlankGrid, Potential, Query, TableError};
use compiled::{Interpolant, boxed, boxed_for};
use lanes::{Four, Registers};
use secant::Secant;
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
    /// derivatives, exactly zero up to the onset. The force is not kept from falling over the displacement
    /// ([`Checks::minimum_slope`] tells the least slope at many points); beyond the range of an axis the
    /// stiffness goes over into a constant within one cell. The onset itself, and a constant load, follow the spline.
    Shepard,
}

/// What was found when the interpolant was made. Forces over displacement are taken relative to the
/// top force of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checks {
    /// Lower bound of dF/du (u: displacement scaled to 1 at top load) through the samples as they
    /// are, before the correction below; negative where the samples would make the spline swing back.
    /// Shepard: the least dF/du at 8 000 points of the finished interpolant.
    pub minimum_slope: f64,
    /// Largest change of a spline coefficient that made the force increase with the displacement by a
    /// hundredth of the mean increments at least.
    pub monotone_correction: f64,
}

impl Default for Checks {
    fn default() -> Self {
        Checks {
            minimum_slope: f64::INFINITY,
            monotone_correction: 0.0,
        }
    }
}

/// One flank's potential over the coordinates of [`Query`].
trait Evaluate: std::fmt::Debug + Send + Sync {
    /// Whether four lanes are of use.
    const WIDE: bool;
    /// See [`FlankTable::evaluate`]; `H`: with all second derivatives; `AXES`: those that there are, see
    /// [`compiled::ANY`].
    fn at<const H: bool, const AXES: usize>(
        &self,
        registers: impl Registers,
        query: &Query,
    ) -> Potential;
    /// What was found when it was made.
    fn checks(&self) -> Checks;
    /// Memory of the coefficients.
    fn bytes(&self) -> usize;
}

/// The potential of one flank as the element asks it, with just the dimensions that are switched on.
#[derive(Debug)]
pub struct FlankTable {
    interpolant: Box<dyn Interpolant>,
    dimensions: usize,
    /// The registers that evaluations use.
    four: Option<Four>,
}

impl FlankTable {
    /// Variable load: the potential over displacement and whatever axes `grid` has.
    ///
    /// # Errors
    /// Nodes through which no spline passes; a span that is not positive everywhere.
    pub fn new(grid: &FlankGrid, interpolation: Interpolation) -> Result<Self, TableError> {
        grid.check("samples")?;
        // Shuttling comes from the potential where misalignment is a coordinate of it.
        let present = grid.axes.present();
        let own_moment = grid.moment.is_some() && !present[1];
        let spline = || Tensor::<5, 4>::new::<4>(grid);
        let interpolant = match interpolation {
            Interpolation::Linear => boxed_for(present, Tensor::<3, 2>::new::<2>(grid)?),
            Interpolation::Spline => boxed_for(present, spline()?),
            Interpolation::Shepard if own_moment => boxed(Shepard::<2>::new(grid, spline()?)?),
            Interpolation::Shepard => boxed(Shepard::<1>::new(grid, spline()?)?),
        };
        Ok(FlankTable {
            interpolant,
            dimensions: 1 + grid.axes.dimensions(),
            four: Four::detect(),
        })
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
        let interpolant = match interpolation {
            Interpolation::Linear => boxed(Secant::<2>::new(grid, loa_force)?),
            Interpolation::Spline | Interpolation::Shepard => {
                boxed(Secant::<4>::new(grid, loa_force)?)
            }
        };
        Ok(FlankTable {
            interpolant,
            dimensions: grid.axes.dimensions(),
            four: Four::detect(),
        })
    }

    /// The potential at `query`, with first derivatives and the tangent stiffness `hessian[0][0]`; the
    /// other second derivatives only if asked for. Exactly zero out of contact.
    ///
    /// Outside the range of an axis the force goes on linearly with a continuous slope, and
    /// `out_of_range` is set. Beyond a quarter of the range of C or M (less where that would make a stiffness
    /// negative) the stiffness levels out, never with a kink; the onset of contact goes on linearly.
    ///
    /// A NaN in the query gives NaN or zero, never a panic.
    #[inline]
    pub fn evaluate(&self, query: &Query, want_hessian: bool) -> Potential {
        self.interpolant.evaluate(self.four, query, want_hessian)
    }

    /// The same table evaluated with the vector registers that every processor of the family has. Results are
    /// the same to the bit; for comparisons.
    pub fn with_common_registers(self) -> Self {
        FlankTable { four: None, ..self }
    }

    /// What was found when the interpolant was made.
    pub fn checks(&self) -> Checks {
        self.interpolant.checks()
    }

    /// Memory of the coefficients, bytes.
    pub fn bytes(&self) -> usize {
        self.interpolant.bytes()
    }

    /// Number of coordinates that are switched on, displacement included (constant load: not).
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }
}

#[cfg(test)]
mod tests;
