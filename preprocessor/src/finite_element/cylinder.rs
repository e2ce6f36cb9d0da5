//! A gear cut at a cylinder below its teeth, on a body that is no solid of revolution.
//!
//! Teeth and rim rest on a foundation of the stiffness k (N/m³) on the cylinder in place of the body: a solid of revolution, of which the
//! model is that of any gear. On the cylinder displacements are smooth (Saint-Venant), and taken in a basis that is orthonormal there:
//! harmonics of the angle times Legendre polynomials along the axis times the three cylindrical directions. With P the
//! coordinates of the cylinder under unit loads on the flanks, F those under loads of the basis, and B the stiffness of the body, which
//! takes the place of the foundation, the influence of loads on the flanks is
//!
//! ```text
//! C = C_k - P^T dB (I + F dB)^{-1} P ,    dB = B - k I
//! ```
//!
//! (Woodbury). Turned about the axis, the body is the same with its harmonics turned; the mean over all angles keeps of the change what
//! couples no harmonic with another one and does not depend on the angle.

use super::condensation::{CondensedSector, condense};
use super::element::face_points;
use super::error::FiniteElementError;
use super::mesh::{LoadColumn, Mesh};
use super::ring::Waves;
use gearmesh::gear::Gear;
use nalgebra::{Complex, DMatrix, DMatrixViewMut};
use std::f64::consts::{PI, TAU};

/// Displacements of a cylinder, or of a part of it along the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis {
    /// m.
    pub radius: f64,
    /// Ends along the axis, m from the z = 0 face of the gear.
    pub z: [f64; 2],
    /// Highest harmonic of the angle.
    pub orders: usize,
    /// Number of polynomials along the axis.
    pub polynomials: usize,
}

/// Harmonics of the basis: below, the body is felt as the foundation is.
const ORDERS: [f64; 2] = [12.0, 24.0];
/// Polynomials along the axis, at most.
const POLYNOMIALS: f64 = 8.0;
/// Layers of elements at level coarse, normal modules.
const COARSE_LAYER: f64 = 1.25;

impl Basis {
    /// For the body of `gear` on the cylinder of `radius` (m) between the ends `z` (m).
    pub fn new(gear: &Gear, radius: f64, z: [f64; 2]) -> Basis {
        // What loads on the teeth do fades within the depth of the cylinder below them.
        let depth = (gear.root_radius() - radius).abs() + gear.normal_module;
        let length = z[1] - z[0];
        // As many as the layers of elements can follow.
        let layers = (length / (COARSE_LAYER * gear.normal_module)).max(2.0);
        let polynomials = (3.0 + 2.0 * length / depth).min(2.0 + layers);
        Basis {
            radius,
            z,
            orders: (5.0 * radius / depth).clamp(ORDERS[0], ORDERS[1]) as usize,
            polynomials: polynomials.min(POLYNOMIALS) as usize,
        }
    }

    /// Coordinates of one harmonic, as cosine or as sine: by polynomial, direction fastest.
    fn of_wave(&self) -> usize {
        3 * self.polynomials
    }

    /// Number of coordinates: those of order 0, then of each order cosine and sine.
    pub fn len(&self) -> usize {
        (2 * self.orders + 1) * self.of_wave()
    }

    /// The functions of angle and polynomial at `theta` (rad) and `z` (m), 1/m, in the order of the coordinates.
    pub fn values(&self, theta: f64, z: f64) -> Vec<f64> {
        let [low, high] = self.z;
        let x = (2.0 * z - low - high) / (high - low);
        let mut along = vec![1.0, x];
        for p in 1..self.polynomials {
            let p_ = p as f64;
            along.push(((2.0 * p_ + 1.0) * x * along[p] - p_ * along[p - 1]) / (p_ + 1.0));
        }
        along.truncate(self.polynomials);
        let area = self.radius * (high - low);
        for (p, value) in along.iter_mut().enumerate() {
            *value *= ((2 * p + 1) as f64 / area).sqrt();
        }
        let around = (0..=2 * self.orders).map(|wave| {
            let (sin, cos) = (wave.div_ceil(2) as f64 * theta).sin_cos();
            match wave {
                0 => TAU.sqrt().recip(),
                _ if wave % 2 == 1 => cos / PI.sqrt(),
                _ => sin / PI.sqrt(),
            }
        });
        let along = &along;
        around
            .flat_map(|c| along.iter().map(move |a| c * a))
            .collect()
    }

    /// Turns the displacements with these coordinates (rows) by `angle` about the axis.
    pub fn turn(&self, mut coordinates: DMatrixViewMut<'_, f64>, angle: f64) {
        let size = self.of_wave();
        for order in 1..=self.orders {
            let (sin, cos) = (order as f64 * angle).sin_cos();
            let first = (2 * order - 1) * size;
            for mut column in coordinates.column_iter_mut() {
                for row in first..first + size {
                    let (c, s) = (column[row], column[row + size]);
                    (column[row], column[row + size]) = (cos * c - sin * s, sin * c + cos * s);
                }
            }
        }
    }

    /// `matrix` of a body seen in mirrors of theta and of z.
    pub fn mirrored(&self, matrix: &DMatrix<f64>, theta: bool, z: bool) -> DMatrix<f64> {
        let size = self.of_wave();
        let sign = |row: usize| {
            let (wave, polynomial, direction) = (row / size, row % size / 3, row % 3);
            let is_sine = wave > 0 && wave.is_multiple_of(2);
            let by_theta = theta && (is_sine != (direction == 1));
            let by_z = z && ((polynomial % 2 == 1) != (direction == 2));
            if by_theta == by_z { 1.0 } else { -1.0 }
        };
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            sign(i) * sign(j) * matrix[(i, j)]
        })
    }

    /// The mean of `matrix` over all angles by which it may be turned.
    pub fn mean(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let size = self.of_wave();
        let mut mean = DMatrix::zeros(matrix.nrows(), matrix.ncols());
        let alone = matrix.view((0, 0), (size, size));
        mean.view_mut((0, 0), (size, size)).copy_from(&alone);
        for order in 1..=self.orders {
            let [c, s] = [1, 0].map(|back| (2 * order - back) * size);
            let block = |i: usize, j: usize| matrix.view((i, j), (size, size));
            let even = 0.5 * (block(c, c) + block(s, s));
            let odd = 0.5 * (block(c, s) - block(s, c));
            for (i, j, block) in [(c, c, &even), (s, s, &even), (c, s, &odd), (s, c, &-&odd)] {
                mean.view_mut((i, j), (size, size)).copy_from(block);
            }
        }
        mean
    }

    /// The stiffness (N/m) of a body in this basis, from its `stiffness` (N/m) by the Cartesian displacements of nodes at `points` (m) on
    /// the cylinder: those of a node follow each other.
    pub fn projected(&self, points: &[[f64; 3]], stiffness: &DMatrix<f64>) -> DMatrix<f64> {
        let mut shapes = DMatrix::zeros(3 * points.len(), self.len());
        for (node, [x, y, z]) in points.iter().enumerate() {
            let theta = y.atan2(*x);
            let (sin, cos) = theta.sin_cos();
            for (at, value) in self.values(theta, *z).into_iter().enumerate() {
                // Cartesian components of the radial, the circumferential and the axial direction.
                let axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
                for (direction, axis) in axes.iter().enumerate() {
                    for (d, component) in axis.iter().enumerate() {
                        shapes[(3 * node + d, 3 * at + direction)] = value * component;
                    }
                }
            }
        }
        let projected = shapes.transpose() * (stiffness * &shapes);
        0.5 * (&projected + projected.transpose())
    }

    /// Stiffness of the foundation, N/m³, about that of a half-space of the material of `gear` under the waves that the basis leaves
    /// out.
    pub fn foundation(&self, gear: &Gear) -> f64 {
        gear.youngs_modulus * self.orders as f64 / self.radius
    }

    /// The basis as loads on the surface of `mesh` that rests on its foundation: a column of one sector for each coordinate.
    pub(super) fn columns(&self, mesh: &Mesh) -> Vec<LoadColumn> {
        let mut columns = vec![LoadColumn::new(); self.len()];
        for nodes in &mesh.elements {
            let rest: Vec<bool> = nodes.iter().map(|n| mesh.on_held_surface[*n]).collect();
            for point in face_points(&mesh.coordinates(nodes), &rest) {
                let theta = point.place.y.atan2(point.place.x);
                let values = self.values(theta, point.place.z);
                for (node, shape) in nodes
                    .iter()
                    .zip(&point.shapes)
                    .filter(|(n, _)| mesh.on_held_surface[**n])
                {
                    let (sin, cos) = (theta - mesh.angles[*node]).sin_cos();
                    // Components of the directions of the place in the axes of the node.
                    let axes: [&[(usize, f64)]; 3] =
                        [&[(0, cos), (1, sin)], &[(0, -sin), (1, cos)], &[(2, 1.0)]];
                    for (at, value) in values.iter().enumerate() {
                        let value = value * shape * point.area;
                        for (direction, axis) in axes.iter().enumerate() {
                            let entries = axis.iter().map(|(d, c)| (3 * node + d, value * c));
                            columns[3 * at + direction].extend(entries);
                        }
                    }
                }
            }
        }
        columns.into_iter().map(summed).collect()
    }

    /// Coordinates of the cylinder, m/N: under unit loads on the first `flank` functionals of sector 0, and under loads of the basis, the
    /// other functionals; of a ring of `sectors` under loads of the basis.
    fn responses(
        &self,
        sector: &CondensedSector,
        sectors: u32,
        flank: usize,
    ) -> Result<[DMatrix<f64>; 2], FiniteElementError> {
        let size = self.of_wave();
        let waves = Waves::new(sector, sectors, self.orders)?;
        let mut by_flank = DMatrix::zeros(self.len(), flank);
        let mut compliance = DMatrix::zeros(self.len(), self.len());
        for order in 0..=self.orders {
            let first = (2 * order).saturating_sub(1) * size;
            let sine = (order > 0).then_some(first + size);
            let response = waves.response(order, [Some(first), sine], size);
            let count = if order > 0 { 2 } else { 1 };
            for wave in 0..count {
                // Cosine and sine are the real and the imaginary part.
                let first = first + wave * size;
                let part = |x: Complex<f64>| [x.re, x.im][wave];
                let flank = response.rows(0, flank).map(part).transpose();
                by_flank.rows_mut(first, size).copy_from(&flank);
                let own = response.rows_range(flank.ncols()..);
                for sector in 0..sectors {
                    let angle = TAU * f64::from(sector) / f64::from(sectors);
                    let phase = Complex::from_polar(1.0, order as f64 * angle);
                    let mut turned = own.map(|x| part(x * phase));
                    self.turn(turned.as_view_mut(), angle);
                    let mut sum = compliance.columns_mut(first, size);
                    sum += turned;
                }
            }
        }
        let compliance = 0.5 * (&compliance + compliance.transpose());
        Ok([by_flank, compliance])
    }
}

impl Basis {
    /// Stiffness (N/m) in this basis of a body of so many sectors like that of `mesh`, which holds the cylinder by a foundation of
    /// `foundation` (N/m³) in addition.
    pub(super) fn stiffness(
        &self,
        mesh: &Mesh,
        sectors: u32,
        foundation: f64,
    ) -> Result<DMatrix<f64>, FiniteElementError> {
        let columns = self.columns(mesh);
        let sector = condense(mesh, &columns, columns.len(), 1.0, &|_| true)?;
        let [_, compliance] = self.responses(&sector, sectors, 0)?;
        let whole = compliance
            .try_inverse()
            .ok_or(FiniteElementError::NotPositiveDefinite)?;
        let stiffness = whole - DMatrix::identity(self.len(), self.len()) * foundation;
        Ok(0.5 * (&stiffness + stiffness.transpose()))
    }
}

/// `column` with the values of each unknown added, ascending.
fn summed(mut column: LoadColumn) -> LoadColumn {
    column.sort_by_key(|(unknown, _)| *unknown);
    let same = column.chunk_by(|a, b| a.0 == b.0);
    same.map(|same| (same[0].0, same.iter().map(|(_, value)| value).sum()))
        .collect()
}

/// Teeth and rim on the foundation: what an exchange of the foundation for a body takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// P, m/N: by coordinates and flank nodes of the tooth at angle 0.
    pub by_flank: DMatrix<f64>,
    /// F, m/N.
    pub compliance: DMatrix<f64>,
}

impl Cut {
    /// Of the `mesh` of a sector whose foundation lies under the cylinder of `basis`, of a gear with so many `teeth`.
    pub fn new(
        basis: &Basis,
        mesh: &Mesh,
        teeth: u32,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Cut, FiniteElementError> {
        let own = basis.columns(mesh);
        let columns: Vec<LoadColumn> = [&own[..], &mesh.loads, &own].concat();
        let sector = condense(mesh, &columns, own.len(), 1.0, progress)?;
        let [by_flank, compliance] = basis.responses(&sector, teeth, mesh.loads.len())?;
        Ok(Cut {
            by_flank,
            compliance,
        })
    }

    /// D of the change P^T D P of the influences where a body of the stiffness `body` (N/m, in the basis) takes the place of the
    /// `foundation` (N/m³).
    ///
    /// # Errors
    /// A body that holds nothing.
    pub fn change(
        &self,
        body: &DMatrix<f64>,
        foundation: f64,
    ) -> Result<DMatrix<f64>, FiniteElementError> {
        let n = body.nrows();
        let change = body - DMatrix::identity(n, n) * foundation;
        let both = DMatrix::identity(n, n) + &self.compliance * &change;
        // -dB (I + F dB)^{-1} = -(I + dB F)^{-1} dB.
        let change = both
            .transpose()
            .lu()
            .solve(&change)
            .ok_or(FiniteElementError::NotPositiveDefinite)?;
        Ok(-0.5 * (&change + change.transpose()))
    }
}
