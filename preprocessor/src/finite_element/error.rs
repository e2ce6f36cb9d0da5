//! Why a finite-element compliance could not be computed.

use gearmesh::gear::ProfileError;

/// Why a finite-element compliance could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FiniteElementError {
    /// The gear has no usable tooth.
    #[error("the tooth cannot be generated: {0}")]
    Profile(#[from] ProfileError),
    /// No material between the root circle and the held surface.
    #[error(
        "the held surface (bore_diameter_mm or rim_diameter_mm) at the radius {held_mm:.3} mm leaves less \
         than {least_mm:.3} mm of rim to the root circle at {root_mm:.3} mm; change that diameter"
    )]
    Rim {
        /// Radius of the held surface, mm.
        held_mm: f64,
        /// Root radius, mm.
        root_mm: f64,
        /// Least rim that can be meshed, mm.
        least_mm: f64,
    },
    /// Rim, web and hub do not follow each other.
    #[error(
        "rim, web and hub do not join: the inside of the rim at the radius {rim_mm:.3} mm, the hub at {hub_mm:.3} mm, \
         the held surface at {held_mm:.3} mm; give radii that fall in this order from the root circle at \
         {root_mm:.3} mm, a web within the face and a hub that encloses it"
    )]
    Body {
        /// Inner radius of the rim, mm.
        rim_mm: f64,
        /// Outer radius of the hub, mm.
        hub_mm: f64,
        /// Radius of the held surface, mm.
        held_mm: f64,
        /// Root radius, mm.
        root_mm: f64,
    },
    /// Plane strain of a gear whose body is not the same along the face.
    #[error(
        "plane strain knows no web: leave out `--plane-strain`, or take rim_thickness_mm and web_thickness_mm \
         out of the pair file"
    )]
    PlaneBody,
    /// An element is folded.
    #[error(
        "the mesh of this tooth has a folded element (quality {quality:.3}); choose another refinement, or \
         a larger tip thickness, tool tip radius or rim"
    )]
    FoldedElement {
        /// Smallest ratio of the Jacobian inside an element to its largest value.
        quality: f64,
    },
    /// The stiffness matrix could not be factored.
    #[error(
        "the stiffness matrix is not positive definite; check youngs_modulus_gpa (> 0) and poisson_ratio \
         (above -1, below 0.5)"
    )]
    NotPositiveDefinite,
    /// A load line that crosses the tooth's centre line outside of the gear.
    #[error(
        "the load line crosses the centre line of the tooth at the radius {radius_mm:.3} mm, where there is no \
         material; choose a load nearer to the tip"
    )]
    NoCrossing {
        /// Radius of the crossing, mm.
        radius_mm: f64,
    },
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
