//! From a gear to the influence matrices of its flank nodes.

use super::condensation::condense;
use super::flank::FlankGrid;
use super::layers::Layers;
use super::mesh::{LoadColumn, Mesh};
use super::outline::Outline;
use super::section::Section;
use super::{FiniteElementError, Progress, Settings, harmonics, ring};
use gearmesh::gear::{Gear, LEAST_WALL, ToothProfile};
use gearmesh::words::rounded;
use nalgebra::DMatrix;
use std::ops::RangeInclusive;

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

/// What the mesh of one gear is made of.
pub(super) struct Model {
    pub gear: Gear,
    pub outline: Outline,
    pub section: Section,
    /// None in plane strain.
    pub layers: Option<Layers>,
    pub grid: FlankGrid,
    /// Largest difference of tooth numbers between load and displacement.
    pub reach: usize,
}

impl Model {
    /// Meshes the section of one sector of `gear`.
    pub fn new(gear: &Gear, settings: &Settings) -> Result<Model, FiniteElementError> {
        let outline = Outline::new(&ToothProfile::new(gear)?);
        let m = gear.normal_module;
        let (held, root, least) = (gear.held_radius, gear.root_radius(), LEAST_WALL * m);
        let [held_mm, root_mm, least_mm] = [held, root, least].map(|length| 1e3 * length);
        let rim = gear.kappa() * (root - held);
        if rim.is_nan() || rim < least {
            return Err(FiniteElementError::Body(format!(
                "the held surface (bore_diameter_mm or rim_diameter_mm) at the radius {held_mm:.3} mm leaves less \
                 than {least_mm:.3} mm of rim to the root circle at {root_mm:.3} mm; change that diameter"
            )));
        }
        if let Some(body) = gear.body {
            let ([w0, w1], [h0, h1]) = (body.web, body.hub);
            let parts = match body.is_shaft() {
                true => body.hub_radius <= body.rim_radius && w0 <= 0.0 && gear.face_width <= w1,
                false => body.hub_radius < body.rim_radius && 0.0 <= w0 && w1 <= gear.face_width,
            };
            let joins = parts
                && held <= body.hub_radius
                && body.rim_radius < root - least
                && w0 < w1
                && (h0 <= w0 && w1 <= h1 && (h1 - h0).is_finite());
            if !joins {
                let [rim_mm, hub_mm] = [body.rim_radius, body.hub_radius].map(|r| 1e3 * r);
                return Err(FiniteElementError::Body(format!(
                    "rim, web and hub do not join: the inside of the rim at the radius {rim_mm:.3} mm, the hub at \
                     {hub_mm:.3} mm, the held surface at {held_mm:.3} mm; give radii that fall in this order from \
                     the root circle at {root_mm:.3} mm, a web within the face and a hub that encloses it"
                )));
            }
            if settings.plane_strain {
                return Err(FiniteElementError::PlaneBody);
            }
        }
        let sizes = settings.discretization;
        let section = Section::new(&outline, &sizes, m);
        let layers = (!settings.plane_strain).then(|| Layers::new(gear, &sizes));
        let stations = layers.as_ref().map_or(&[0.0][..], Layers::of_face);
        Ok(Model {
            grid: FlankGrid::new(&outline, &section, stations, sizes.kernel_half_width * m),
            gear: gear.clone(),
            outline,
            section,
            layers,
            reach: settings.reach,
        })
    }

    /// How much the section turns along z, rad/m; right-handed.
    pub fn twist(&self) -> f64 {
        self.gear.base_helix_angle().tan() / self.gear.base_radius()
    }

    /// Everything that the mesh, its stiffness and what is asked of it depend on, in words.
    pub fn identity(&self) -> String {
        let gear = (self.gear.teeth, self.material(), self.gear.foundation);
        let mesh = (self.twist(), &self.outline, &self.section, &self.layers);
        format!("{:?}", (self.reach, gear, mesh))
    }

    /// The gear, for people.
    pub fn in_words(&self) -> String {
        let gear = &self.gear;
        format!(
            "{} teeth, module {} mm, helix {} deg, face width {} mm",
            gear.teeth,
            rounded(1e3 * gear.normal_module),
            rounded(gear.helix_angle.to_degrees()),
            rounded(1e3 * gear.face_width)
        )
    }

    /// Young's modulus, Pa, and Poisson ratio.
    pub fn material(&self) -> [f64; 2] {
        [self.gear.youngs_modulus, self.gear.poisson_ratio]
    }

    /// Influence of the flank nodes, see [`super::FiniteElementCompliance`].
    pub fn influence(
        &self,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        let mesh = Mesh::new(self);
        let loads = mesh.loads();
        self.response(&mesh, &loads, loads.len(), 0..=self.reach as i32, progress)
    }

    /// Displacements of the `mesh` of this model along the functionals, which are `columns` behind the first `loads` (all where there are no
    /// others), in `sectors` under unit loads in sector 0.
    pub fn response(
        &self,
        mesh: &Mesh,
        columns: &[LoadColumn],
        loads: usize,
        sectors: RangeInclusive<i32>,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        let (_, quality) = mesh.volume_and_quality();
        if quality.is_nan() || quality <= 0.0 {
            return Err(FiniteElementError::FoldedElement(quality));
        }
        if !progress(Stage::Assembly, 0.0) {
            return Err(FiniteElementError::Cancelled);
        }
        let sector = condense(mesh, self.material(), columns, loads, &|share| {
            progress(Stage::Condensation, share)
        })?;
        let teeth = self.gear.teeth;
        let solved = harmonics::solved(teeth as usize, *sectors.end() as usize);
        ring::response(&sector, teeth, sectors, &solved, &|share| {
            progress(Stage::Ring, share)
        })
    }
}
