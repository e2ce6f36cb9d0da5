//! From a gear to the influence matrices of its flank nodes.

use super::assembly;
use super::condensation::{self, LoadColumn};
use super::cyclic;
use super::dissection::Elimination;
use super::flank::FlankGrid;
use super::layers::Layers;
use super::mesh::{Foundation, Mesh};
use super::outline::Outline;
use super::section::Section;
use super::{FiniteElementError, Progress, Settings};
use gearmesh::gear::{Gear, LEAST_WALL, ToothProfile};
use nalgebra::DMatrix;
use std::time::Instant;

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

/// What a computation took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Elements of one sector.
    pub elements: usize,
    /// Free displacements of one sector.
    pub unknowns: usize,
    /// Entries of the sparse Cholesky factor of the inside of a sector.
    pub factor_entries: usize,
    /// Loaded flank nodes.
    pub flank_nodes: usize,
    /// Wall-clock time of assembly, condensation and ring, s.
    pub seconds: [f64; 3],
    /// Estimate of the largest working memory, bytes.
    pub memory_bytes: usize,
}

/// Mesh and matrices of one gear.
pub(super) struct Model {
    pub mesh: Mesh,
    pub grid: FlankGrid,
    pub gear: Gear,
    /// Arc lengths of the nodes of the fillet, see [`Section::fillet`].
    pub fillet_arcs: Vec<f64>,
}

impl Model {
    /// Meshes one sector of `gear`.
    pub fn new(gear: &Gear, settings: &Settings) -> Result<Model, FiniteElementError> {
        let profile = ToothProfile::new(gear)?;
        let outline = Outline::new(&profile);
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
            let joins = gear.held_radius <= body.hub_radius
                && body.hub_radius < body.rim_radius
                && body.rim_radius < gear.root_radius() - least
                && (0.0 <= w0 && w0 < w1 && w1 <= gear.face_width)
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
        let section = Section::new(&outline, &sizes.section(m));
        let (mesh, stations) = if settings.plane_strain {
            if gear.body.is_some() {
                return Err(FiniteElementError::PlaneBody);
            }
            (Mesh::plane(&section, &outline, gear.foundation), vec![0.0])
        } else {
            let layers = Layers::new(gear, &sizes);
            let twist = gear.base_helix_angle().tan() / gear.base_radius();
            (
                Mesh::extruded(&section, &outline, &layers, twist, gear.foundation),
                layers.of_face().to_vec(),
            )
        };
        let arcs: Vec<f64> = section.flank.iter().map(|(_, arc)| *arc).collect();
        let half_width = sizes.kernel_half_width * m;
        Ok(Model {
            grid: FlankGrid::new(&outline, &arcs, &stations, half_width),
            mesh,
            gear: gear.clone(),
            fillet_arcs: section.fillet.iter().map(|(_, arc)| *arc).collect(),
        })
    }

    /// Hands everything that the influence of the flank nodes depends on to `take`, piece by piece: mesh,
    /// material, number of teeth, and one element's stiffness for how elements are computed.
    pub fn identify(&self, take: &mut dyn FnMut(&[u8])) {
        // Taken apart by name, so that a new field cannot be forgotten.
        let Mesh {
            dimension,
            points,
            angles,
            elements,
            cells: _, // they order the elimination and change no result
            held,
            sides,
            flank,
            fillet: _, // where stress may be observed
            foundation,
            hanging,
        } = &self.mesh;
        let mut whole = |number: usize| take(&(number as u64).to_le_bytes());
        whole(*dimension);
        whole(self.gear.teeth as usize);
        // The lengths keep lists apart that follow each other.
        for list in [elements, &sides[0], &sides[1]] {
            whole(list.len());
            list.iter().for_each(|node| whole(*node));
        }
        whole(flank.len());
        flank.iter().for_each(|f| whole(f.node));
        held.iter().for_each(|held| whole((*held).into()));
        whole(hanging.len());
        for (node, carriers) in hanging {
            [*node, carriers.len()].into_iter().for_each(&mut whole);
            carriers.iter().for_each(|(carrier, _)| whole(*carrier));
        }
        let element = assembly::first_element(&self.mesh, self.material());
        let numbers = points.iter().flatten().chain(angles);
        let normals = flank.iter().flat_map(|f| &f.normal);
        let shares = hanging.values().flatten().map(|(_, share)| share);
        for number in numbers.chain(normals).chain(&element).chain(shares) {
            take(&number.to_le_bytes());
        }
        if let Some(Foundation { nodes, stiffness }) = foundation {
            nodes.iter().for_each(|node| take(&[u8::from(*node)]));
            take(&stiffness.to_le_bytes());
        }
    }

    /// Young's modulus, Pa, and Poisson ratio.
    pub fn material(&self) -> [f64; 2] {
        [self.gear.youngs_modulus, self.gear.poisson_ratio]
    }

    /// Unit normal loads on the flank nodes, in the numbering `first` of the unknowns.
    pub fn load_columns(&self, first: &[usize]) -> Vec<LoadColumn> {
        self.mesh
            .flank
            .iter()
            .map(|flank| {
                (0..self.mesh.dimension)
                    .map(|d| (first[flank.node] + d, flank.normal[d]))
                    .collect()
            })
            .collect()
    }

    /// Influence of the flank nodes, see [`super::FiniteElementCompliance`].
    pub fn solve(
        &self,
        reach: usize,
        progress: &Progress<'_>,
    ) -> Result<(Vec<DMatrix<f64>>, Cost), FiniteElementError> {
        self.check()?;
        let elimination = Elimination::new(&self.mesh);
        let first = assembly::number_unknowns(&self.mesh, &elimination.order);
        self.influence_of(&elimination, &self.load_columns(&first), reach, progress)
    }

    /// Refuses a mesh with a folded element.
    pub fn check(&self) -> Result<(), FiniteElementError> {
        let (_, quality) = self.mesh.volume_and_quality();
        if quality.is_nan() || quality <= 0.0 {
            return Err(FiniteElementError::FoldedElement { quality });
        }
        Ok(())
    }

    /// Influence of any load columns of sector 0 on the same functionals of sectors 0 to `reach`.
    pub fn influence_of(
        &self,
        elimination: &Elimination,
        columns: &[LoadColumn],
        reach: usize,
        progress: &Progress<'_>,
    ) -> Result<(Vec<DMatrix<f64>>, Cost), FiniteElementError> {
        if !progress(Stage::Assembly, 0.0) {
            return Err(FiniteElementError::Cancelled);
        }
        let mut clock = Instant::now();
        let mut lap = || {
            std::mem::replace(&mut clock, Instant::now())
                .elapsed()
                .as_secs_f64()
        };
        let stiffness = assembly::assemble(&self.mesh, &elimination.order, self.material());
        let assembled = lap();
        let sector = condensation::condense(&stiffness, &elimination.parts, columns, &|share| {
            progress(Stage::Condensation, share)
        })?;
        let unknowns = stiffness.column_starts.len() - 1;
        let entries = stiffness.values.len();
        drop(stiffness);
        let condensed = lap();
        let teeth = self.gear.teeth as usize;
        let influence =
            cyclic::ring_influence(&sector, teeth, reach, &|share| progress(Stage::Ring, share))?;
        let ring = lap();
        let n = columns.len();
        let cost = Cost {
            elements: self.mesh.cells.len(),
            unknowns,
            factor_entries: sector.factor_entries,
            flank_nodes: n,
            seconds: [assembled, condensed, ring],
            memory_bytes: 8 * (sector.numbers + 2 * entries),
        };
        let matrices = influence
            .into_iter()
            .map(|c| DMatrix::from_fn(n, n, |i, j| c[(i, j)]))
            .collect();
        Ok((matrices, cost))
    }
}
