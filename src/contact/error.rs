//! What the contact solver refuses, and why.

use std::fmt;

use thiserror::Error;

use crate::compliance::BeyondModel;
use crate::gear::ProfileError;
use crate::words::{number, rounded};

/// What is prescribed at an operating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prescribed {
    /// Torque on gear 1, N m.
    Torque(f64),
    /// Approach on the line of action, m.
    Approach(f64),
}

/// The point at which a contact solve failed, in the words of pair file and command line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// Load or approach.
    pub prescribed: Prescribed,
    /// Misalignment in the plane of action, rad.
    pub misalignment: f64,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
}

impl fmt::Display for OperatingPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.prescribed {
            Prescribed::Torque(torque) => write!(f, "torque = {} N m", number(rounded(torque)))?,
            Prescribed::Approach(approach) => {
                write!(f, "approach = {} um", rounded(1e6 * approach))?
            }
        }
        write!(
            f,
            ", misalignment = {} mrad, center distance offset = {} um",
            rounded(1e3 * self.misalignment),
            rounded(1e6 * self.center_distance_offset)
        )
    }
}

/// Errors of the contact solver.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ContactError {
    /// A setting out of its range.
    #[error("contact setting `{field}` = {value}: {remedy}")]
    Setting {
        /// Name of the setting.
        field: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        remedy: &'static str,
    },
    /// A gear has no usable tooth.
    #[error("no tooth to touch: {0}; check module, profile shift and tip diameter")]
    Profile(#[from] ProfileError),
    /// A load, approach, misalignment or mesh position that is not a usable number.
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
        "center distance {center_distance_mm:.4} mm leaves no path of contact; \
         bring it nearer to the nominal one"
    )]
    OutOfMesh {
        /// The centre distance, mm.
        center_distance_mm: f64,
    },
    /// The teeth approach farther than the candidates for contact reach, so that some contact would
    /// be missed.
    #[error(
        "{at}: the teeth approach by {needed_um:.1} um, but tip edges were followed for {reach_um:.1} um only; \
         lower torque or misalignment, or state the larger one as operating.maximum_torque_nm or \
         operating.misalignment_mrad in the pair file, from which that distance follows"
    )]
    BeyondReach {
        /// Where.
        at: OperatingPoint,
        /// Largest approach found, um.
        needed_um: f64,
        /// How far candidates were followed, um.
        reach_um: f64,
    },
    /// The load is beyond what any flank carries.
    #[error(
        "{at}: a contact pressure of {pressure_mpa:.0} MPa, far beyond what these teeth can carry: \
         lower torque or misalignment, or widen the common face"
    )]
    Overload {
        /// Where.
        at: OperatingPoint,
        /// Largest pressure there, MPa.
        pressure_mpa: f64,
    },
    /// The influence matrix is not positive definite.
    #[error(
        "{at}: the elastic model of the teeth is not positive definite; \
         choose another compliance.refinement in the pair file"
    )]
    NotPositiveDefinite {
        /// Where.
        at: OperatingPoint,
    },
    /// Teeth may touch that lie farther apart than the elastic model was computed for.
    #[error(
        "center distance offset = {} um: {model}; state it in \
         operating.center_distance_offset_um in the pair file, from which the model's reach follows, or bring \
         it nearer to zero",
        rounded(*center_distance_offset_um)
    )]
    BeyondModel {
        /// Deviation from the nominal centre distance, um.
        center_distance_offset_um: f64,
        /// What the elastic model said.
        model: BeyondModel,
    },
    /// Newton's iteration stopped short of its tolerance.
    #[error(
        "{at}: the contact solve stopped at a residual of {residual:.1e} after {iterations} iterations; \
         lower torque or misalignment"
    )]
    NotConverged {
        /// Where.
        at: OperatingPoint,
        /// Iterations done.
        iterations: usize,
        /// Relative residual reached.
        residual: f64,
    },
}
