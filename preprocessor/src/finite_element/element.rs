//! Serendipity elements: the 8-node quadrilateral and the 20-node hexahedron.
//!
//! Both follow one formula (Zienkiewicz, Taylor, The Finite Element Method, vol. 1, section 8.7): a node is given by its
//! local coordinates c in {-1, 0, 1}^d; a corner has no zero among them, a mid-edge node exactly one.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// Local coordinates of the nodes of the 8-node quadrilateral: corners, then mid-edges.
pub(super) const QUAD8: [[f64; 3]; 8] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
];

/// The same of the 20-node hexahedron: those of the quadrilateral at zeta = -1 and at +1, then the four mid-edges along zeta.
pub(super) const HEX20: [[f64; 3]; 20] = {
    let mut nodes = [[0.0; 3]; 20];
    let mut i = 0;
    while i < 8 {
        nodes[i] = [QUAD8[i][0], QUAD8[i][1], -1.0];
        nodes[i + 8] = [QUAD8[i][0], QUAD8[i][1], 1.0];
        if i < 4 {
            nodes[16 + i] = [QUAD8[i][0], QUAD8[i][1], 0.0];
        }
        i += 1;
    }
    nodes
};

/// Abscissae and weights of the three-point Gauss rule on [-1, 1], exact to degree 5.
pub(super) const GAUSS3: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// Value of the shape function of the node at `c`, and its gradient in local coordinates, at `xi`.
pub(super) fn shape(dimension: usize, c: &[f64; 3], xi: &[f64; 3]) -> (f64, [f64; 3]) {
    let mut factor = [1.0; 3];
    let mut slope = [0.0; 3];
    let mut sum = -(dimension as f64 - 1.0);
    let mut corner = true;
    for d in 0..dimension {
        if c[d] == 0.0 {
            corner = false;
            factor[d] = 1.0 - xi[d] * xi[d];
            slope[d] = -2.0 * xi[d];
        } else {
            factor[d] = 0.5 * (1.0 + xi[d] * c[d]);
            slope[d] = 0.5 * c[d];
            sum += xi[d] * c[d];
        }
    }
    let product = factor[0] * factor[1] * factor[2];
    let mut gradient = [0.0; 3];
    for d in 0..dimension {
        gradient[d] = slope[d] * (factor[(d + 1) % 3] * factor[(d + 2) % 3]);
        if corner {
            gradient[d] = gradient[d] * sum + product * c[d];
        }
    }
    (if corner { product * sum } else { product }, gradient)
}

/// Place, m, and its derivatives by the local coordinates, where the shape functions of the nodes `x` are these.
pub(super) fn place_and_tangents(
    shapes: &[(f64, [f64; 3])],
    x: &[[f64; 3]],
) -> (Vector3<f64>, [Vector3<f64>; 3]) {
    let (mut place, mut tangents) = (Vector3::zeros(), [Vector3::zeros(); 3]);
    for ((value, gradient), x) in shapes.iter().zip(x) {
        let x = Vector3::from(*x);
        place += *value * x;
        for (tangent, slope) in tangents.iter_mut().zip(gradient) {
            *tangent += *slope * x;
        }
    }
    (place, tangents)
}

/// An integration point of an element.
pub(super) struct IntegrationPoint {
    /// Values of the nodes' shape functions.
    pub shapes: Vec<f64>,
    pub place: Vector3<f64>,
    /// Gradients of the nodes' shape functions in space, 1/m.
    pub gradient: Vec<[f64; 3]>,
    /// Determinant of the Jacobian, m^d; <= 0 on a folded element.
    pub jacobian: f64,
    /// Its volume, m^d: the Jacobian times the weight.
    pub volume: f64,
}

/// Dimension and local coordinates of the nodes of an element with so many `nodes`.
fn kind(nodes: usize) -> (usize, &'static [[f64; 3]]) {
    if nodes == 8 { (2, &QUAD8) } else { (3, &HEX20) }
}

fn gauss(axis: usize, dimension: usize) -> &'static [(f64, f64)] {
    if axis < dimension {
        &GAUSS3
    } else {
        &[(0.0, 1.0)]
    }
}

/// The point at the local coordinates `at` of the element with the nodes `x`.
fn integration_point(x: &[[f64; 3]], at: [f64; 3], weight: f64) -> IntegrationPoint {
    let (dimension, nodes) = kind(x.len());
    let shapes: Vec<_> = nodes.iter().map(|c| shape(dimension, c, &at)).collect();
    // dx_j / dxi_i; a plane element is one unit deep.
    let (place, mut tangents) = place_and_tangents(&shapes, x);
    if dimension == 2 {
        tangents[2] = Vector3::z();
    }
    let j = Matrix3::from_columns(&tangents).transpose();
    let jacobian = j.determinant();
    let inverse = j.try_inverse().unwrap_or_default();
    let gradients = shapes.iter().map(|(_, gradient)| Vector3::from(*gradient));
    IntegrationPoint {
        gradient: gradients
            .map(|gradient| (inverse * gradient).into())
            .collect(),
        shapes: shapes.iter().map(|(value, _)| *value).collect(),
        place,
        jacobian,
        volume: jacobian * weight,
    }
}

/// All 3^d integration points of an element with the nodes `x`, m (8 nodes: plane, 20: solid), or of each of its `parts` by `parts` parts in its
/// plane.
pub(super) fn integration_points(x: &[[f64; 3]], parts: usize) -> Vec<IntegrationPoint> {
    let (dimension, _) = kind(x.len());
    let scale = 1.0 / parts as f64;
    let mut points = Vec::with_capacity(27 * parts * parts);
    for part in 0..parts * parts {
        let [i, j] = [part / parts, part % parts].map(|k| (2 * k + 1) as f64 * scale - 1.0);
        for &(zeta, w2) in gauss(2, dimension) {
            for &(eta, w1) in &GAUSS3 {
                points.extend(GAUSS3.map(|(xi, w0)| {
                    let at = [i + scale * xi, j + scale * eta, zeta];
                    integration_point(x, at, w0 * w1 * w2 * scale * scale)
                }));
            }
        }
    }
    points
}

/// Stiffness matrix of an element of `material` (Young's modulus, Pa, and Poisson ratio), N/m (plane strain: N/m per metre of
/// depth), `dimension` displacements per node, from its [`integration_points`].
pub(super) fn stiffness(points: &[IntegrationPoint], material: [f64; 2]) -> DMatrix<f64> {
    let nodes = points[0].shapes.len();
    let (dimension, _) = kind(nodes);
    let [youngs_modulus, poisson_ratio] = material;
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    let lambda = 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio);
    let size = dimension * nodes;
    let mut k = vec![0.0; size * size];
    for point in points {
        for (a, ga) in point.gradient.iter().enumerate() {
            for (b, gb) in point.gradient.iter().enumerate().skip(a) {
                let dot = mu * point.volume * (ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2]);
                for i in 0..dimension {
                    let row = (dimension * a + i) * size + dimension * b;
                    for m in 0..dimension {
                        k[row + m] += point.volume * (lambda * ga[i] * gb[m] + mu * ga[m] * gb[i]);
                    }
                    k[row + i] += dot;
                }
            }
        }
    }
    for row in 0..size {
        for column in 0..row {
            // Blocks below the diagonal were skipped; inside a diagonal block both halves agree.
            if row / dimension != column / dimension {
                k[row * size + column] = k[column * size + row];
            }
        }
    }
    DMatrix::from_vec(size, size, k)
}

/// An integration point of a face of an element.
pub(super) struct FacePoint {
    /// Values of the shape functions of the element's nodes.
    pub shapes: Vec<f64>,
    pub place: Vector3<f64>,
    /// Its area, m² (plane: length, m).
    pub area: f64,
}

/// The integration points of the face of an element with the nodes `x` whose nodes are those that `rest`; none without such a face.
pub(super) fn face_points(x: &[[f64; 3]], rest: &[bool]) -> Vec<FacePoint> {
    let (dimension, nodes) = kind(x.len());
    let mut sides = (0..dimension).flat_map(|d| [(d, -1.0), (d, 1.0)]);
    let Some((normal, end)) = sides.find(|(d, end)| {
        let mut face = nodes.iter().zip(rest).filter(|(c, _)| c[*d] == *end);
        face.all(|(_, rests)| *rests)
    }) else {
        return vec![];
    };
    let along: Vec<usize> = (0..dimension).filter(|d| *d != normal).collect();
    let mut points = Vec::with_capacity(9);
    for &(a, wa) in &GAUSS3 {
        for &(b, wb) in gauss(2, dimension) {
            let mut xi = [0.0; 3];
            xi[normal] = end;
            xi[along[0]] = a;
            if let Some(d) = along.get(1) {
                xi[*d] = b;
            }
            let shapes: Vec<_> = nodes.iter().map(|c| shape(dimension, c, &xi)).collect();
            let (place, tangents) = place_and_tangents(&shapes, x);
            // A plane element is one unit deep.
            let second = along.get(1).map_or(Vector3::z(), |d| tangents[*d]);
            points.push(FacePoint {
                place,
                area: wa * wb * tangents[along[0]].cross(&second).norm(),
                shapes: shapes.into_iter().map(|(value, _)| value).collect(),
            });
        }
    }
    points
}

/// Adds to the stiffness matrix `k` of an element (see [`stiffness`]) a foundation of `stiffness` N/m³, alike in all
/// directions, under the face whose nodes are those that `rest`; without such a face nothing.
pub(super) fn add_foundation(x: &[[f64; 3]], rest: &[bool], stiffness: f64, k: &mut DMatrix<f64>) {
    let (dimension, _) = kind(x.len());
    for point in face_points(x, rest) {
        add_springs(&point.shapes, stiffness * point.area, dimension, k);
    }
}

/// Adds springs of the `stiffness` N/m, alike in all directions, where the shape functions have the values `shapes`.
pub(super) fn add_springs(shapes: &[f64], stiffness: f64, dimension: usize, k: &mut DMatrix<f64>) {
    for (i, ni) in shapes.iter().enumerate() {
        for (j, nj) in shapes.iter().enumerate() {
            let value = stiffness * ni * nj;
            for d in 0..dimension {
                k[(dimension * i + d, dimension * j + d)] += value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use nalgebra::DVector;

    #[test]
    fn a_foundation_bears_its_area_and_no_other_face() {
        // A brick of 2 x 3 x 5 on the face zeta = -1: a push along any axis meets 6 times the stiffness.
        let x: Vec<[f64; 3]> = HEX20.map(|c| [c[0], 1.5 * c[1], 2.5 * c[2]]).to_vec();
        let rest = HEX20.map(|c| c[2] == -1.0);
        let mut k = DMatrix::zeros(60, 60);
        add_foundation(&x, &rest, 7.0, &mut k);
        for d in 0..3 {
            let blocks = (0..400).map(|at| (3 * (at / 20) + d, 3 * (at % 20) + d));
            let total: f64 = blocks.map(|at| k[at]).sum();
            assert_relative_eq!(total, 42.0, max_relative = 1e-12);
        }
        let mut none = DMatrix::zeros(60, 60);
        add_foundation(&x, &[false; 20], 7.0, &mut none);
        assert!(none.iter().all(|v| *v == 0.0));
        // One edge alone is no face.
        add_foundation(
            &x,
            &HEX20.map(|c| c[2] == -1.0 && c[0] == 1.0),
            7.0,
            &mut none,
        );
        assert!(none.iter().all(|v| *v == 0.0));
    }

    #[test]
    fn shape_functions_are_one_at_their_node_and_sum_to_one() {
        for (nodes, dimension) in [(&QUAD8[..], 2), (&HEX20[..], 3)] {
            for (i, at) in nodes.iter().enumerate() {
                for (j, c) in nodes.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert_abs_diff_eq!(shape(dimension, c, at).0, expected, epsilon = 1e-15);
                }
            }
            let xi = [0.31, -0.57, if dimension == 3 { 0.83 } else { 0.0 }];
            let sum: f64 = nodes.iter().map(|c| shape(dimension, c, &xi).0).sum();
            assert_abs_diff_eq!(sum, 1.0, epsilon = 1e-14);
        }
    }

    #[test]
    fn a_distorted_element_stores_the_energy_of_an_even_strain_and_none_of_a_rotation() {
        let (lambda, mu) = (0.3 / (1.3 * 0.4), 0.5 / 1.3);
        let x = HEX20.map(|c| {
            [
                c[0] + 0.1 * c[1] + 0.05 * c[0] * c[1],
                c[1] - 0.07 * c[2] + 0.04 * c[0] * c[2],
                c[2] + 0.06 * c[0] * c[1],
            ]
        });
        let points = integration_points(&x, 1);
        let k = stiffness(&points, [1.0, 0.3]);
        let volume: f64 = points.iter().map(|p| p.volume).sum();
        let stretch = [[0.3, 0.1, -0.2], [0.05, -0.4, 0.15], [0.25, 0.0, 0.2]];
        let rotation = [[0.0, 0.3, -0.1], [-0.3, 0.0, 0.2], [0.1, -0.2, 0.0]];
        for g in [stretch, rotation] {
            // u = G x: the energy density is exact where the integration is.
            let u = DVector::from_fn(60, |at, _| {
                (0..3).map(|j| g[at % 3][j] * x[at / 3][j]).sum::<f64>()
            });
            let energy = 0.5 * u.dot(&(&k * &u));
            let trace: f64 = g[0][0] + g[1][1] + g[2][2];
            let mut density = 0.5 * lambda * trace * trace;
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                density += mu * (0.5f64 * (g[i][j] + g[j][i])).powi(2);
            }
            assert_abs_diff_eq!(energy, density * volume, epsilon = 1e-12);
        }
    }
}
