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
mod error;
mod fillet;
mod flank;
mod grading;
mod harmonics;
mod influence;
mod layers;
mod mesh;
mod model;
mod outline;
mod pair;
mod ring;
mod root_stress;
mod section;
mod settings;

pub use cache::{CachedModel, ModelCache, Origin};
pub use error::FiniteElementError;
pub use model::{Stage, centre_line_compliance, sector_unknowns};
pub use pair::{PairCompliance, pair_root_stress};
pub use root_stress::{RootStress, SpreadSegments};
pub use settings::{Discretization, Settings};

use flank::{FlankGrid, Weights};
use gearmesh::compliance::{BeyondModel, Segment, ToothCompliance};
use gearmesh::gear::Gear;
use influence::Influence;
use model::Model;
use nalgebra::DMatrix;

/// Progress of a computation: called with the stage and the share of it that is done; returns false to
/// stop with [`FiniteElementError::Cancelled`].
pub type Progress<'a> = dyn Fn(Stage, f64) -> bool + Sync + 'a;

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
                    let weight = weight * self.influence.unit();
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

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod closure_tests;
#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod tests;
