//! From a gear to the influence matrices of its flank nodes.

use super::condensation::condense;
use super::flank::FlankGrid;
use super::layers::Layers;
use super::mesh::{LoadColumn, Mesh};
use super::outline::Outline;
use super::section::Section;
use super::{FiniteElementError, Progress, Settings, harmonics, ring};
use gearmesh::gear::{Gear, LEAST_WALL, ToothProfile};
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

/// How much the section of `gear` turns along z, rad/m; right-handed.
pub(super) fn twist(gear: &Gear) -> f64 {
    gear.base_helix_angle().tan() / gear.base_radius()
}

/// What the mesh of one gear is made of.
pub(super) struct Model {
    pub gear: Gear,
    pub outline: Outline,
    pub section: Section,
    /// None in plane strain.
    pub layers: Option<Layers>,
    pub grid: FlankGrid,
}

impl Model {
    /// Meshes the section of one sector of `gear`.
    pub fn new(gear: &Gear, settings: &Settings) -> Result<Model, FiniteElementError> {
        let outline = Outline::new(&ToothProfile::new(gear)?);
        let m = gear.normal_module;
        let least = LEAST_WALL * m;
        let rim = gear.kappa() * (gear.root_radius() - gear.held_radius);
        if rim.is_nan() || rim < least {
            return Err(FiniteElementError::Rim {
                held_mm: 1e3 * gear.held_radius,
                root_mm: 1e3 * gear.root_radius(),
                least_mm: 1e3 * least,
            });
        }
        if let Some(body) = gear.body {
            let ([w0, w1], [h0, h1]) = (body.web, body.hub);
            let parts = match body.is_shaft() {
                true => body.hub_radius <= body.rim_radius && w0 <= 0.0 && gear.face_width <= w1,
                false => body.hub_radius < body.rim_radius && 0.0 <= w0 && w1 <= gear.face_width,
            };
            let joins = parts
                && gear.held_radius <= body.hub_radius
                && body.rim_radius < gear.root_radius() - least
                && w0 < w1
                && (h0 <= w0 && w1 <= h1 && (h1 - h0).is_finite());
            if !joins {
                return Err(FiniteElementError::Body {
                    rim_mm: 1e3 * body.rim_radius,
                    hub_mm: 1e3 * body.hub_radius,
                    held_mm: 1e3 * gear.held_radius,
                    root_mm: 1e3 * gear.root_radius(),
                });
            }
        }
        let sizes = settings.discretization;
        let section = Section::new(&outline, &sizes, m);
        if settings.plane_strain && gear.body.is_some() {
            return Err(FiniteElementError::PlaneBody);
        }
        let layers = (!settings.plane_strain).then(|| Layers::new(gear, &sizes));
        let stations = layers.as_ref().map_or(&[0.0][..], Layers::of_face);
        Ok(Model {
            grid: FlankGrid::new(&outline, &section, stations, sizes.kernel_half_width * m),
            gear: gear.clone(),
            outline,
            section,
            layers,
        })
    }

    /// The mesh of the sector.
    pub fn mesh(&self) -> Mesh {
        let twist = twist(&self.gear);
        Mesh::new(&self.section, &self.outline, self.layers.as_ref(), twist)
            .rested_on(self.gear.foundation)
    }

    /// Everything that the mesh and its stiffness depend on, in words.
    pub fn identity(&self) -> String {
        let rows = self
            .layers
            .as_ref()
            .map(|layers| layers.of_rows(&self.section.rows));
        let gear = (
            self.gear.teeth,
            self.material(),
            self.gear.foundation,
            twist(&self.gear),
        );
        let Model {
            outline,
            section,
            layers,
            ..
        } = self;
        format!("{:?}", (gear, outline, section, layers, rows))
    }

    /// Young's modulus, Pa, and Poisson ratio.
    pub fn material(&self) -> [f64; 2] {
        [self.gear.youngs_modulus, self.gear.poisson_ratio]
    }

    /// Influence of the flank nodes up to `reach` teeth away, see [`super::FiniteElementCompliance`].
    pub fn influence(
        &self,
        reach: usize,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        let mesh = self.mesh();
        let loads = mesh.loads();
        self.response(&mesh, &loads, loads.len(), 0..=reach as i32, progress)
    }

    /// Displacements of [`Model::mesh`] along the functionals, which are `columns` behind the first `loads` (all where there are no
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
            return Err(FiniteElementError::FoldedElement { quality });
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
