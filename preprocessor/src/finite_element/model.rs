//! From a gear to the influence matrices of its flank nodes.

use super::condensation::{CondensedSector, condense};
use super::element::{QUAD8, place_and_tangents, shape};
use super::error::FiniteElementError;
use super::flank::FlankGrid;
use super::mesh::{Layers, LoadColumn, Mesh, twist};
use super::outline::Outline;
use super::section::Section;
use super::{Settings, harmonics, mirror, ring};
use crate::gear::ToothProfile;
use gearmesh::contact::Segment;
use gearmesh::gear::Gear;
use gearmesh::words::rounded;
use nalgebra::{DMatrix, Matrix2, Vector2};
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

/// Progress of a computation: called with the stage and the share of it that is done; returns false to
/// stop with [`FiniteElementError::Cancelled`].
pub type Progress<'a> = dyn Fn(Stage, f64) -> bool + Sync + 'a;

pub(super) struct Model {
    pub gear: Gear,
    pub outline: Outline,
    pub section: Section,
    /// None in plane strain.
    pub layers: Option<Layers>,
    pub grid: FlankGrid,
    /// Largest difference of tooth numbers between load and displacement.
    pub reach: usize,
    /// Share of the memory that is left which it may take.
    memory_share: f64,
}

impl Model {
    pub fn new(gear: &Gear, settings: &Settings) -> Result<Model, FiniteElementError> {
        let outline = Outline::new(&ToothProfile::new(gear)?);
        let m = gear.normal_module;
        if settings.plane_strain && gear.body.is_some() {
            return Err(FiniteElementError::PlaneBody);
        }
        let mut sizes = settings.discretization;
        if settings.plane_strain {
            sizes.fine_depth = f64::INFINITY;
        }
        let section = Section::new(gear, &outline, &sizes);
        let layers = (!settings.plane_strain).then(|| Layers::new(gear, &sizes));
        let stations = layers.as_ref().map_or(&[0.0][..], Layers::of_face);
        Ok(Model {
            grid: FlankGrid::new(&outline, &section, stations, sizes.kernel_half_width * m),
            gear: gear.clone(),
            outline,
            section,
            layers,
            reach: settings.reach,
            memory_share: settings.memory_share,
        })
    }

    pub fn mesh(&self) -> Mesh {
        let layers = self.layers.as_ref();
        Mesh::new(&self.gear, &self.outline, &self.section, layers)
    }

    /// Everything that the mesh, its stiffness and what is asked of it depend on, in words.
    pub fn identity(&self) -> String {
        let g = &self.gear;
        let gear = (g.teeth, [g.youngs_modulus, g.poisson_ratio], g.foundation);
        let mesh = (twist(g), &self.outline, &self.section, &self.layers);
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

    /// Influence of the flank nodes, see [`super::FiniteElementCompliance`]. `condensed` is the sector of a gear with the same teeth, if one
    /// is at hand, and becomes that of this one.
    pub fn influence(
        &self,
        condensed: &mut Option<(Mesh, CondensedSector)>,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        if let Some(upper) = self.upper_half() {
            return self.influence_by_halves(&upper, progress);
        }
        let mesh = self.mesh();
        let known = condensed.take();
        let known = known.and_then(|(of, sector)| sector.on_body_of(&of, &mesh));
        let sector = match known {
            Some(sector) => sector,
            None => self.condensed(&mesh, &mesh.loads, mesh.loads.len(), progress)?,
        };
        let influence = self.closed(&sector, 0..=self.reach as i32, progress);
        *condensed = Some((mesh, sector));
        influence
    }

    /// The layers of half the face, if mid-face mirrors the gear.
    pub fn upper_half(&self) -> Option<Layers> {
        mirror::upper_half(&self.gear, self.layers.as_ref()?)
    }

    fn influence_by_halves(
        &self,
        upper: &Layers,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        let of_half = |half: usize| {
            move |stage: Stage, share: f64| progress(stage, 0.5 * (half as f64 + share))
        };
        let mut sectors = Vec::new();
        for (half, fixed) in mirror::FIXED.iter().enumerate() {
            let mut mesh = Mesh::new(&self.gear, &self.outline, &self.section, Some(upper));
            mesh.fix_on_plane(upper.stations[0], fixed);
            sectors.push(self.condensed(&mesh, &mesh.loads, mesh.loads.len(), &of_half(half))?);
        }
        let mut halves = Vec::new();
        for (half, sector) in sectors.iter().enumerate() {
            halves.push(self.closed(sector, 0..=self.reach as i32, &of_half(half))?);
        }
        let both = halves[0].iter().zip(&halves[1]);
        Ok(both
            .map(|(even, odd)| mirror::of_whole_face(&self.grid, [even, odd]))
            .collect())
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
        let sector = self.condensed(mesh, columns, loads, progress)?;
        self.closed(&sector, sectors, progress)
    }

    fn condensed(
        &self,
        mesh: &Mesh,
        columns: &[LoadColumn],
        loads: usize,
        progress: &Progress<'_>,
    ) -> Result<CondensedSector, FiniteElementError> {
        let (_, quality) = mesh.volume_and_quality();
        if quality.is_nan() || quality <= 0.0 {
            return Err(FiniteElementError::FoldedElement(quality));
        }
        if !progress(Stage::Assembly, 0.0) {
            return Err(FiniteElementError::Cancelled);
        }
        condense(mesh, columns, loads, self.memory_share, &|share| {
            progress(Stage::Condensation, share)
        })
    }

    fn closed(
        &self,
        sector: &CondensedSector,
        sectors: RangeInclusive<i32>,
        progress: &Progress<'_>,
    ) -> Result<Vec<DMatrix<f64>>, FiniteElementError> {
        let teeth = self.gear.teeth;
        let solved = harmonics::solved(teeth as usize, *sectors.end() as usize);
        ring::response(sector, teeth, sectors, &solved, &|share| {
            progress(Stage::Ring, share)
        })
    }
}

/// How many displacements of one sector of `gear` are free.
///
/// # Errors
/// As [`super::FiniteElementCompliance::new`]: no usable tooth.
pub fn sector_unknowns(gear: &Gear, settings: &Settings) -> Result<usize, FiniteElementError> {
    let mesh = Model::new(gear, settings)?.mesh();
    let free = mesh.held.iter().filter(|held| !**held).count();
    Ok(mesh.dimension * (free - mesh.hanging.len()))
}

/// The transverse section of a sector of `gear`: of each quadrilateral corners and middles of its sides in their order around it, x and y in m
/// from the axis, the centre line of the tooth along y.
///
/// # Errors
/// As [`super::FiniteElementCompliance::new`]: no usable tooth.
pub fn sector_section(
    gear: &Gear,
    settings: &Settings,
) -> Result<Vec<[[f64; 2]; 8]>, FiniteElementError> {
    let section = Model::new(gear, settings)?.section;
    let around = |quad: &[usize; 8]| {
        [0, 4, 1, 5, 2, 6, 3, 7].map(|at| {
            let [radius, angle] = section.nodes[quad[at]];
            [radius * angle.sin(), radius * angle.cos()]
        })
    };
    Ok(section.quads.iter().map(around).collect())
}

/// Compliance of a tooth in plane strain, m²/N: displacement along the load line where it crosses the tooth's
/// centre line, per load and length of face, for a load on the involute at the radius `radius`, m. Bending, shear,
/// base and body are in it, the contact is not.
///
/// # Errors
/// As [`super::FiniteElementCompliance::new`]; [`FiniteElementError::NoCrossing`] if the load line does not cross
/// the centre line within the gear.
pub fn centre_line_compliance(
    gear: &Gear,
    settings: &Settings,
    radius: f64,
) -> Result<f64, FiniteElementError> {
    let plane = Settings {
        plane_strain: true,
        ..*settings
    };
    let model = Model::new(gear, &plane)?;
    let roll = gear.roll_length(radius);
    let segment = Segment {
        tooth: 0,
        z: [0.0, 1.0],
        roll: [roll; 2],
    };
    let mesh = model.mesh();
    let weights = model.grid.weights(&segment);
    let load = (weights.iter())
        .flat_map(|(node, w)| mesh.loads[*node].iter().map(move |(at, n)| (*at, w * n)))
        .collect();
    // Direction of the normal, from the x axis; the load line touches the base circle.
    let pressure_angle = (roll / gear.base_radius()).atan();
    let angle = gear.half_base_angle() - (roll / gear.base_radius() - pressure_angle);
    let direction = angle + std::f64::consts::FRAC_PI_2 - pressure_angle;
    let crossing = gear.base_radius() / direction.sin();
    let observed = shape_functions_at(&mesh, crossing)
        .ok_or(FiniteElementError::NoCrossing(1e3 * crossing))?;
    // Components in the node's own axes.
    let observed = observed.into_iter().flat_map(|(node, n)| {
        let (sin, cos) = (direction - mesh.angles[node]).sin_cos();
        [(2 * node, n * cos), (2 * node + 1, n * sin)]
    });
    let columns = [load, observed.collect()];
    let influence = model.response(&mesh, &columns, 2, 0..=0, &|_, _| true)?;
    Ok(influence[0][(1, 0)])
}

/// Shape functions at the point (x, 0) of a plane mesh, by node; None outside of it.
fn shape_functions_at(mesh: &Mesh, x: f64) -> Option<Vec<(usize, f64)>> {
    mesh.elements.iter().find_map(|nodes| {
        let corners = mesh.coordinates(nodes);
        let mut xi = Vector2::zeros();
        for _ in 0..20 {
            let (place, tangents) = place_and_tangents(&shapes(&xi), &corners);
            let jacobian = Matrix2::from_columns(&[tangents[0].xy(), tangents[1].xy()]);
            xi -= jacobian.try_inverse()? * (place.xy() - Vector2::new(x, 0.0));
            xi = xi.map(|v| v.clamp(-2.0, 2.0));
        }
        let shapes = nodes.iter().zip(shapes(&xi));
        let weights = shapes.map(|(node, (n, _))| (*node, n));
        (xi.amax() <= 1.0 + 1e-9).then(|| weights.collect())
    })
}

/// Shape functions of a plane element at its local coordinates `xi`.
fn shapes(xi: &Vector2<f64>) -> [(f64, [f64; 3]); 8] {
    QUAD8.map(|c| shape(2, &c, &[xi[0], xi[1], 0.0]))
}
