//! What the contact solver refuses, and why.

use thiserror::Error;

use crate::gear::ProfileError;

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
        "teeth approach by {needed_um:.1} um where tip corners were followed to {reach_um:.1} um only; \
         raise the contact setting `reach` or lower load or misalignment"
    )]
    BeyondReach {
        /// Largest approach found, um.
        needed_um: f64,
        /// How far candidates were followed, um.
        reach_um: f64,
    },
    /// The contact ellipse has outgrown the half-plane of the local contact law.
    #[error(
        "the contact half-width exceeds three reference lengths of the local contact at strip {strip} \
         ({pressure_mpa:.0} MPa); the load is far beyond what these teeth can carry, lower it"
    )]
    ContactTooWide {
        /// Index of the strip.
        strip: usize,
        /// Hertz pressure there, MPa.
        pressure_mpa: f64,
    },
    /// The influence matrix is not positive definite: the compliance model is at fault.
    #[error("the influence matrix of the contact is not positive definite (pivot {pivot})")]
    NotPositiveDefinite {
        /// Index of the failing pivot among the strips in contact.
        pivot: usize,
    },
    /// Newton's iteration stopped short of its tolerance; this is a defect worth reporting.
    #[error(
        "contact solve stopped at a residual of {residual:.1e} after {iterations} iterations; \
         please report the pair and the operating point"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Relative residual reached.
        residual: f64,
    },
}
