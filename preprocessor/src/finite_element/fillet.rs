//! Surface of the fillet beside the loaded flank: where stress is observed, and how it follows from displacements.
//!
//! Nothing acts on the fillet, so that the stress there lies in its tangent plane and follows from the strain in
//! that plane alone (plane stress). Strains are taken at the two Gauss points of every element along the profile, where the
//! derivatives of quadratic displacements converge fastest (Zienkiewicz, Taylor, The Finite Element Method,
//! vol. 1, section 14.2), in the middle of every layer, and at both faces by the straight line through the
//! Gauss points of the outermost layers.

use super::condensation::LoadColumn;
use super::element::{QUAD8, shape};
use super::mesh::Mesh;

/// 1/sqrt(3), abscissa of the two-point Gauss rule.
const GAUSS2: f64 = 0.577_350_269_189_625_8;

/// The points of the fillet at which stress is observed: a grid of places along the profile and along the face.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FilletGrid {
    /// Places along the profile from the middle of the space to the form point: radius, m.
    pub radii: Vec<f64>,
    /// Angle between the tangent plane and the tooth's centre line there, rad.
    pub tangents: Vec<f64>,
    /// Arc length from the form point, m, ascending, <= 0.
    pub arcs: Vec<f64>,
    /// Places along the face, m, ascending; a single one in plane strain.
    pub z: Vec<f64>,
}

/// Components of stress at each point: along the profile, along the helix, shear; Pa.
pub(super) const COMPONENTS: usize = 3;

/// Displacement functionals of the stress at one point, before the unknowns are numbered: node, and the factors of its
/// radial, circumferential and axial displacement.
type Functional = Vec<(usize, [f64; 3])>;

/// A place along the face where stress is observed.
struct Place {
    /// Layer of elements.
    layer: usize,
    /// m.
    z: f64,
    /// Points zeta of the layer, and their shares in the stress here.
    shares: Vec<(f64, f64)>,
}

impl Place {
    /// Both faces and the middles of the layers between `stations`; the station itself in plane strain.
    fn along(stations: &[f64]) -> Vec<Place> {
        let place = |layer, z, shares| Place { layer, z, shares };
        let middle = vec![(0.0, 1.0)];
        let layers = stations.len() - 1;
        if layers == 0 {
            return vec![place(0, stations[0], middle)];
        }
        // On the straight line through both Gauss points, at zeta = -1 or 1.
        let near = 0.5 * (1.0 + 1.0 / GAUSS2);
        let far = 1.0 - near;
        let mut places = vec![place(0, stations[0], vec![(-GAUSS2, near), (GAUSS2, far)])];
        for (layer, ends) in stations.windows(2).enumerate() {
            places.push(place(layer, 0.5 * (ends[0] + ends[1]), middle.clone()));
        }
        let last = vec![(-GAUSS2, far), (GAUSS2, near)];
        places.push(place(layers - 1, stations[layers], last));
        places
    }
}

/// Value and derivatives along xi and zeta of a shape function.
type Shape = (f64, [f64; 2]);

/// One face of an element, in the order of [`QUAD8`]: xi along the profile, zeta along the face.
struct Face<'a> {
    mesh: &'a Mesh,
    nodes: Vec<usize>,
    material: [f64; 2],
}

/// What a face gives at one of its points.
struct FacePoint {
    place: [f64; 3],
    /// Unit normal, either way.
    normal: [f64; 3],
    stress: [Functional; COMPONENTS],
}

impl FilletGrid {
    /// Points on `mesh`, whose fillet has the arc lengths `arcs` (corner, mid-edge, corner, ...) and whose layers end at
    /// `stations`, m; `twist` rad per m along z. With them the stress at each, for the unknowns numbered by `first`: all of a
    /// place along the face one after the other, the [`COMPONENTS`] of a point together.
    pub fn new(
        mesh: &Mesh,
        arcs: &[f64],
        (stations, twist): (&[f64], f64),
        material: [f64; 2],
        first: &[usize],
    ) -> (FilletGrid, Vec<LoadColumn>) {
        let elements = arcs.len() / 2;
        let mut grid = FilletGrid {
            radii: Vec::new(),
            tangents: Vec::new(),
            arcs: Vec::new(),
            z: Vec::new(),
        };
        let abscissae = [-GAUSS2, GAUSS2];
        let places = Place::along(stations);
        let mut columns = Vec::new();
        for (number, place) in places.iter().enumerate() {
            grid.z.push(place.z);
            for element in 0..elements {
                let face = Face::new(mesh, elements, element, place.layer, material);
                for xi in abscissae {
                    if number == 0 {
                        let point = face.at(xi, place.shares[0].0);
                        grid.add(&point, twist);
                        let [low, mid, high] = [0, 1, 2].map(|i| arcs[2 * element + i]);
                        let curved = 0.5 * (low - 2.0 * mid + high) * xi * xi;
                        grid.arcs.push(mid + 0.5 * (high - low) * xi + curved);
                    }
                    let mut stress: [LoadColumn; COMPONENTS] = Default::default();
                    for (zeta, share) in &place.shares {
                        for (column, part) in stress.iter_mut().zip(face.at(xi, *zeta).stress) {
                            for (node, factors) in part {
                                let unknowns = factors.iter().take(mesh.dimension).enumerate();
                                column.extend(unknowns.map(|(d, f)| (first[node] + d, share * f)));
                            }
                        }
                    }
                    columns.extend(stress);
                }
            }
        }
        (grid, columns)
    }

    fn add(&mut self, point: &FacePoint, twist: f64) {
        let [x, y, z] = point.place;
        self.radii.push(x.hypot(y));
        let (sin, cos) = (twist * z).sin_cos();
        let across = (point.normal[0] * cos + point.normal[1] * sin).abs();
        self.tangents.push(across.min(1.0).asin());
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.radii.len() * self.z.len()
    }
}

impl<'a> Face<'a> {
    fn new(
        mesh: &'a Mesh,
        elements: usize,
        element: usize,
        layer: usize,
        material: [f64; 2],
    ) -> Face<'a> {
        let nodes = if mesh.dimension == 2 {
            (0..3).map(|i| mesh.fillet[2 * element + i]).collect()
        } else {
            // Planes of all nodes alternate with planes of corners alone.
            let node = |i: usize, k: usize| {
                let base = (k / 2) * (3 * elements + 2);
                mesh.fillet[match k % 2 {
                    0 => base + i,
                    _ => base + 2 * elements + 1 + i / 2,
                }]
            };
            let half = |c: f64| (1.0 + c) as usize;
            let corner = |c: &[f64; 3]| node(2 * element + half(c[0]), 2 * layer + half(c[1]));
            QUAD8.iter().map(corner).collect()
        };
        Face {
            mesh,
            nodes,
            material,
        }
    }

    /// Value and both derivatives of the shape function of each node.
    fn shapes(&self, xi: f64, zeta: f64) -> Vec<Shape> {
        if self.mesh.dimension == 2 {
            return vec![
                (0.5 * xi * (xi - 1.0), [xi - 0.5, 0.0]),
                (1.0 - xi * xi, [-2.0 * xi, 0.0]),
                (0.5 * xi * (xi + 1.0), [xi + 0.5, 0.0]),
            ];
        }
        let at = [xi, zeta, 0.0];
        let of = |c| {
            let (value, slope) = shape(2, c, &at);
            (value, [slope[0], slope[1]])
        };
        QUAD8.iter().map(of).collect()
    }

    fn at(&self, xi: f64, zeta: f64) -> FacePoint {
        let shapes = self.shapes(xi, zeta);
        let points = self.mesh.coordinates(&self.nodes);
        let sum = |of: fn(&Shape) -> f64| -> [f64; 3] {
            std::array::from_fn(|d| shapes.iter().zip(&points).map(|(s, p)| of(s) * p[d]).sum())
        };
        let place = sum(|s| s.0);
        let along_profile = sum(|s| s.1[0]);
        let plane = self.mesh.dimension == 2;
        let along_face = match plane {
            true => [0.0, 0.0, 1.0],
            false => sum(|s| s.1[1]),
        };
        // Orthonormal in the tangent plane: b along the helix, s across it.
        let helix = norm(along_face);
        let b = along_face.map(|c| c / helix);
        let lean = dot(along_profile, b);
        let s: [f64; 3] = std::array::from_fn(|d| along_profile[d] - lean * b[d]);
        let length = norm(s);
        let s = s.map(|c| c / length);
        let (youngs_modulus, nu) = (self.material[0], self.material[1]);
        let stiff = youngs_modulus / (1.0 - nu * nu);
        let shear = youngs_modulus / (2.0 * (1.0 + nu));
        let mut stress: [Functional; COMPONENTS] = Default::default();
        for ((_, slope), node) in shapes.iter().zip(&self.nodes) {
            // Derivatives along s and b; those along z vanish in plane strain.
            let d_b = if plane { 0.0 } else { slope[1] / helix };
            let d_s = (slope[0] - lean * d_b) / length;
            let (sin, cos) = self.mesh.angles[*node].sin_cos();
            let axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
            let strains = axes.map(|axis| {
                let (u_s, u_b) = (dot(axis, s), dot(axis, b));
                [d_s * u_s, d_b * u_b, d_b * u_s + d_s * u_b]
            });
            stress[0].push((*node, strains.map(|e| stiff * (e[0] + nu * e[1]))));
            stress[1].push((*node, strains.map(|e| stiff * (e[1] + nu * e[0]))));
            stress[2].push((*node, strains.map(|e| shear * e[2])));
        }
        FacePoint {
            place,
            normal: cross(s, b),
            stress,
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}
