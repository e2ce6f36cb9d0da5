//! Why a finite-element compliance could not be computed.

use crate::gear::ProfileError;

/// Why a finite-element compliance could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FiniteElementError {
    /// The gear has no usable tooth.
    #[error("the tooth cannot be generated: {0}")]
    Profile(#[from] ProfileError),
    /// Plane strain of a gear whose body is not the same along the face.
    #[error(
        "plane strain knows no web and no body of another shape: leave out `--plane-strain`, or take rim_thickness_mm and \
         web_thickness_mm, or the body, out of the pair file"
    )]
    PlaneBody,
    /// An element is folded: smallest ratio of the Jacobian inside an element to its largest value.
    #[error(
        "the mesh of this tooth has a folded element (quality {0:.3}); choose another refinement, or \
         a larger tip thickness, tool tip radius or rim"
    )]
    FoldedElement(f64),
    /// The stiffness matrix could not be factored.
    #[error(
        "the stiffness matrix is not positive definite; check youngs_modulus_gpa (> 0) and poisson_ratio \
         (above -1, below 0.5)"
    )]
    NotPositiveDefinite,
    /// A load line that crosses the tooth's centre line outside of the gear, at this radius, mm.
    #[error(
        "the load line crosses the centre line of the tooth at the radius {0:.3} mm, where there is no \
         material; choose a load nearer to the tip"
    )]
    NoCrossing(f64),
    /// The model takes more memory than the system has left.
    #[error(
        "the finite-element model takes {needed_gb:.1} GB of memory, and {available_gb:.1} GB are available; choose a coarser \
         refinement"
    )]
    Memory {
        /// What it takes, GB.
        needed_gb: f64,
        /// What there is, GB.
        available_gb: f64,
    },
    /// The caller asked to stop.
    #[error("the computation was cancelled")]
    Cancelled,
}
