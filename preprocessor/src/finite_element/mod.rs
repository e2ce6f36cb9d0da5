//! Finite-element compliance of one gear: all teeth, rim and web down to the held surface.
//!
//! ```text
//!  gear::ToothProfile ─> outline ─> section ─> mesh ─> condensation ─> ring ─> influence
//!                        by arc     one tooth   along   Cholesky,       whole   of flank
//!                        length     sector      helix   sides left      gear    nodes
//! ```
//!
//! One tooth sector is meshed with 20-node hexahedra (plane strain: 8-node quadrilaterals) and reduced
//! to the displacements of its two sides and of the loaded flank; the ring of equal sectors then follows
//! by a Fourier transform, so that every tooth of the gear is a real one at the cost of one. The result
//! are the matrices C_k of normal displacements of the flank nodes of tooth k per unit normal load on
//! the flank nodes of tooth 0.
//!
//! A [`Segment`] is a line load spread across its contact line by a smooth kernel; weights f
//! on the flank nodes give the influence f_i^T C f_j. It contains the kernel's own local displacement, and
//! [`FiniteElementCompliance::reference_lengths`] says how much, so that the sum with the Hertz contact
//! does not depend on the kernel's width.

mod cache;
mod condensation;
mod dense;
mod element;
mod flank;
mod influence;
mod mesh;
mod model;
mod ring;
mod root_stress;
mod section;
mod settings;

pub use cache::{CachedModel, ModelCache, Origin};
pub use model::{centre_line_compliance, sector_unknowns};
pub use root_stress::{RootStress, SpreadSegments};
pub use settings::{Discretization, Settings};

use flank::{FlankGrid, Weights};
use gearmesh::compliance::{BeyondModel, Segment, ToothCompliance};
use gearmesh::gear::{Flank, Gear, PairGeometry, ProfileError};
use influence::Influence;
use model::Model;
use nalgebra::DMatrix;
use std::sync::Arc;

/// What a computation is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Mesh and stiffness matrix of one sector.
    Assembly,
    /// Sparse Cholesky factor and elimination of the inside of the sector.
    Condensation,
    /// Harmonics of the whole ring.
    Ring,
}

/// Progress of a computation: called with the stage and the share of it that is done; returns false to
/// stop with [`FiniteElementError::Cancelled`].
pub type Progress<'a> = dyn Fn(Stage, f64) -> bool + Sync + 'a;

/// Progress of both gears: the number of the gear (0 or 1) in front of what [`Progress`] is called with.
type PairProgress<'a> = dyn Fn(usize, Stage, f64) -> bool + Sync + 'a;

/// Why a finite-element compliance could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FiniteElementError {
    /// The gear has no usable tooth.
    #[error("the tooth cannot be generated: {0}")]
    Profile(#[from] ProfileError),
    /// Too little material below the root circle, or rim, web and hub that do not join: what, and what would be right.
    #[error("{0}")]
    Body(String),
    /// Plane strain of a gear whose body is not the same along the face.
    #[error(
        "plane strain knows no web: leave out `--plane-strain`, or take rim_thickness_mm and web_thickness_mm \
         out of the pair file"
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

/// Finite-element model of one gear, reduced to its loaded flank.
#[derive(Debug, Clone)]
pub struct FiniteElementCompliance {
    grid: FlankGrid,
    influence: Influence,
    plane_strain: bool,
    /// Of the base helix; plane strain alone needs it.
    cos_base_helix: f64,
    /// The gear turned end for end, if its body is another one then.
    turned: Option<Box<FiniteElementCompliance>>,
}

impl FiniteElementCompliance {
    /// Computes the model of `gear`; microgeometry plays no part.
    ///
    /// # Errors
    /// [`FiniteElementError`]: no usable tooth, too thin a rim, memory, or cancelled by `progress`.
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        progress: &Progress<'_>,
    ) -> Result<Self, FiniteElementError> {
        Ok(Self::cached(gear, settings, None, progress)?.0)
    }

    /// As [`FiniteElementCompliance::new`], by way of `cache` if there is one.
    fn cached(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let one = |gear: &Gear| -> Result<(Self, Origin), FiniteElementError> {
            let model = Model::new(gear, settings)?;
            let compute = || Ok(Influence::new(&model.influence(progress)?));
            let (influence, origin) = cache::get(cache, &model, "", compute)?;
            let found = FiniteElementCompliance {
                grid: model.grid,
                influence,
                plane_strain: settings.plane_strain,
                cos_base_helix: gear.base_helix_angle().cos(),
                turned: None,
            };
            Ok((found, origin))
        };
        let (mut model, mut origin) = one(gear)?;
        if let Some(gear) = gear.turned() {
            let (turned, of_turned) = one(&gear)?;
            // Of a gear with two models the one that was not simply read.
            if of_turned != Origin::Loaded {
                origin = of_turned;
            }
            model.turned = Some(Box::new(turned));
        }
        Ok((model, origin))
    }

    /// Largest difference of tooth numbers that [`ToothCompliance::bulk`] accepts.
    pub fn reach(&self) -> usize {
        self.influence.teeth() - 1
    }

    /// Factor of the influence of two segments on each other beyond that of their weights.
    fn slice_factor(&self, a: &Segment, b: &Segment) -> f64 {
        if !self.plane_strain {
            return 1.0;
        }
        // Independent slices: segments act on each other as far as they lie in the same slices. The force
        // per length of contact line is cos beta_b times that per metre of depth; so is the displacement
        // along the flank normal seen from the transverse plane, but one of the two factors is left
        // to the shorter path of the line load, as the local contact of `ToothCompliance` counts it.
        let overlap = (a.z[1].min(b.z[1]) - a.z[0].max(b.z[0])).max(0.0);
        let lengths = (a.z[1] - a.z[0]) * (b.z[1] - b.z[0]);
        self.cos_base_helix * overlap / lengths
    }
}

impl ToothCompliance for FiniteElementCompliance {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        let teeth = || segments.iter().map(|s| s.tooth);
        let (first, last) = (teeth().min().unwrap_or(0), teeth().max().unwrap_or(0));
        let (distance, reach) = (last.abs_diff(first) as usize, self.reach());
        if distance > reach {
            return Err(BeyondModel { distance, reach });
        }
        let weights: Vec<Weights> = segments.iter().map(|s| self.grid.weights(s)).collect();
        let mut matrix = DMatrix::zeros(segments.len(), segments.len());
        let mut displacement = vec![0.0; self.grid.len()];
        for (j, load) in weights.iter().enumerate() {
            for tooth in segments[j].tooth..=last {
                let offset = (tooth - segments[j].tooth) as usize;
                let on_tooth = |i: &usize| segments[*i].tooth == tooth && (offset > 0 || j <= *i);
                let observed: Vec<usize> = (0..segments.len()).filter(on_tooth).collect();
                if observed.is_empty() {
                    continue;
                }
                displacement.fill(0.0);
                for (node, weight) in load {
                    let weight = weight * self.influence.unit;
                    let column = self.influence.column(offset, *node);
                    for (u, c) in displacement.iter_mut().zip(column) {
                        *u += weight * f64::from(*c);
                    }
                }
                for i in observed {
                    let response = weights[i].iter();
                    let value: f64 = response.map(|(node, w)| w * displacement[*node]).sum();
                    let value = value * self.slice_factor(&segments[i], &segments[j]);
                    matrix[(i, j)] = value;
                    matrix[(j, i)] = value;
                }
            }
        }
        Ok(matrix)
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        segments
            .iter()
            .map(|s| self.grid.reference_length(s))
            .collect()
    }

    fn turned(&self) -> Option<&dyn ToothCompliance> {
        let turned: &dyn ToothCompliance = self.turned.as_deref()?;
        Some(turned)
    }

    fn corner_resolution(&self) -> f64 {
        self.grid.edge_resolution()
    }

    fn lengthwise_resolution(&self) -> f64 {
        self.grid.thickest_layer()
    }
}

/// Models of gear 1 and gear 2; the same one twice when the gears are equal but for hand and axial
/// position.
#[derive(Debug, Clone)]
pub struct PairCompliance {
    /// One model per gear.
    pub gears: [Arc<FiniteElementCompliance>; 2],
    /// Where each came from.
    pub origins: [Origin; 2],
}

impl PairCompliance {
    /// Whether `cache` holds both models, sound or not.
    ///
    /// # Errors
    /// Those of gears that cannot be meshed.
    pub fn is_kept(
        pair: &PairGeometry,
        settings: &Settings,
        cache: &ModelCache,
    ) -> Result<bool, FiniteElementError> {
        for gear in &pair.gears {
            for gear in gear.turned().iter().chain([gear]) {
                if !cache.holds(&Model::new(gear, settings)?) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Computes both models, or reads them from the cache if there is one.
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn new(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        let models = both(&pair.gears, progress, |gear, progress| {
            FiniteElementCompliance::cached(gear, settings, cache, progress)
        })?;
        let [(first, first_origin), (second, second_origin)] = models;
        Ok(PairCompliance {
            gears: [first, second],
            origins: [first_origin, second_origin],
        })
    }
}

/// The maps of gear 1 and gear 2 of `pair` loaded on `flank` (of gear 1), the same one twice for equal gears; `settings` are
/// those of its compliance.
///
/// # Errors
/// Those of [`RootStress::new`].
pub fn pair_root_stress(
    pair: &PairGeometry,
    flank: Flank,
    settings: &Settings,
    cache: Option<&ModelCache>,
    progress: &PairProgress<'_>,
) -> Result<[(Arc<RootStress>, Origin); 2], FiniteElementError> {
    let settings = settings.for_root_stress();
    // As segments see them: turned end for end where they are mirrored.
    let gears = [0, 1].map(|i| {
        let turned = pair.gears[i].turned();
        let turned = turned.filter(|_| pair.is_mirrored(flank, i));
        turned.unwrap_or_else(|| pair.gears[i].clone())
    });
    both(&gears, progress, |gear, progress| {
        RootStress::cached(gear, &settings, cache, progress)
    })
}

/// What `model` gives of the first and the second gear; of gears that are alike the same. Models are in canonical coordinates: hand
/// and axial position do not matter.
fn both<T>(
    gears: &[Gear; 2],
    progress: &PairProgress<'_>,
    model: impl Fn(&Gear, &Progress<'_>) -> Result<(T, Origin), FiniteElementError>,
) -> Result<[(Arc<T>, Origin); 2], FiniteElementError> {
    let one = |i: usize| {
        let found = model(&gears[i], &|stage, share| progress(i, stage, share));
        found.map(|(model, origin)| (Arc::new(model), origin))
    };
    let [first, second] = gears.each_ref().map(|gear| Gear {
        hand: 1.0,
        face_offset: 0.0,
        ..gear.clone()
    });
    let of_first = one(0)?;
    let of_second = match first == second {
        true => of_first.clone(),
        false => one(1)?,
    };
    Ok([of_first, of_second])
}

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod closure_tests;
#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod tests;
