//! What a contact solve refuses, and why.

use std::fmt;

use thiserror::Error;

use crate::words::{number, rounded};

/// What is prescribed at an operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prescribed {
    /// Torque on gear 1, N m.
    Torque(f64),
    /// Approach on the line of action, m.
    Approach(f64),
}

impl fmt::Display for Prescribed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Prescribed::Torque(torque) => write!(f, "torque = {} N m", number(rounded(torque))),
            Prescribed::Approach(delta) => write!(f, "approach = {} um", rounded(1e6 * delta)),
        }
    }
}

/// Why a load has no solution, or none that counts.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum Failure {
    /// The influence matrix is not positive definite.
    #[error(
        "the elastic model of the teeth is not positive definite; \
         choose another compliance.refinement in the pair file"
    )]
    NotPositiveDefinite,
    /// Newton's iteration stopped short of its tolerance, or where a force was NaN.
    #[error(
        "the contact solve stopped at a residual of {residual:.1e} after {iterations} iterations; \
         lower torque or misalignment"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Relative residual reached.
        residual: f64,
    },
    /// The load is beyond what any flank carries.
    #[error(
        "a contact pressure of {:.0} MPa, far beyond what these teeth can carry: \
         lower torque or misalignment, or widen the common face",
        1e-6 * pressure
    )]
    Overload {
        /// Largest pressure, Pa.
        pressure: f64,
    },
    /// The teeth approach farther than tip edges were followed, so that some contact would be missed.
    #[error(
        "the teeth approach by {:.1} um, but tip edges were followed for {:.1} um only; \
         lower torque or misalignment, or state the larger one as operating.maximum_torque_nm or \
         operating.misalignment_mrad in the pair file, from which that distance follows",
        1e6 * needed,
        1e6 * followed
    )]
    NotFollowed {
        /// Largest approach found, m.
        needed: f64,
        /// Approach up to which tip edges were followed, m.
        followed: f64,
    },
}

/// Errors of a contact solve.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ContactError {
    /// A setting, load, approach, misalignment or mesh position out of its range.
    #[error("contact input `{field}` = {value}: {remedy}")]
    Input {
        /// Name of the quantity.
        field: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        remedy: &'static str,
    },
    /// No tooth pair can touch at this centre distance.
    #[error(
        "center distance {:.4} mm leaves no path of contact; bring it nearer to the nominal one",
        1e3 * center_distance
    )]
    OutOfMesh {
        /// The centre distance, m.
        center_distance: f64,
    },
    /// A load without a solution, in the words of pair file and command line.
    #[error(
        "{prescribed}, misalignment = {} mrad, center distance offset = {} um: {failure}",
        rounded(1e3 * misalignment),
        rounded(1e6 * center_distance_offset)
    )]
    Unsolved {
        /// Load or approach.
        prescribed: Prescribed,
        /// Misalignment in the plane of action, rad.
        misalignment: f64,
        /// Deviation from the nominal centre distance, m.
        center_distance_offset: f64,
        /// Why.
        failure: Failure,
    },
}

impl ContactError {
    /// [`ContactError::Input`].
    pub fn input(field: &'static str, value: f64, remedy: &'static str) -> ContactError {
        ContactError::Input {
            field,
            value,
            remedy,
        }
    }
}

/// Refuses `value` unless it is finite.
///
/// # Errors
/// [`ContactError::Input`].
pub fn finite(field: &'static str, value: f64) -> Result<(), ContactError> {
    let refused = || ContactError::input(field, value, "give a finite number");
    value.is_finite().then_some(()).ok_or_else(refused)
}
