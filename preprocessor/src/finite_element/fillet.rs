//! Surface of the fillet beside the loaded flank: where stress is observed, and how it follows from displacements.
//!
//! Nothing acts on the fillet, so that the stress there lies in its tangent plane and follows from the strain in
//! that plane alone (plane stress). Strains are taken at the two Gauss points of every element along the profile, where the
//! derivatives of quadratic displacements converge fastest (Zienkiewicz, Taylor, The Finite Element Method,
//! vol. 1, section 14.2), in the middle of every layer, and at both faces by the straight line through the
//! Gauss points of the outermost layers.

use super::element::shape;
use super::flank::face_nodes;
use super::mesh::{LoadColumn, Mesh};
use super::model::Model;
use gearmesh::contact::{COMPONENTS, Fillet};
use gearmesh::gear::GearKind;
use nalgebra::Vector3;

/// 1/sqrt(3), abscissa of the two-point Gauss rule.
const GAUSS2: f64 = 0.577_350_269_189_625_8;

/// Over the normal module: distance from a load within which the stress is that of its spreading, without limit at a tip corner.
const LOCAL_OVER_MODULE: f64 = 0.45;

struct Place {
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
        let layers = stations.len() - 1;
        if layers == 0 {
            return vec![place(0, stations[0], vec![(-1.0, 1.0)])];
        }
        // On the straight line through both Gauss points, at zeta = -1 or 1.
        let near = 0.5 * (1.0 + 1.0 / GAUSS2);
        let far = 1.0 - near;
        let mut places = vec![place(0, stations[0], vec![(-GAUSS2, near), (GAUSS2, far)])];
        for (layer, ends) in stations.windows(2).enumerate() {
            places.push(place(layer, 0.5 * (ends[0] + ends[1]), vec![(0.0, 1.0)]));
        }
        let last = vec![(-GAUSS2, far), (GAUSS2, near)];
        places.push(place(layers - 1, stations[layers], last));
        places
    }
}

/// A point of the face of an element.
struct FacePoint {
    place: Vector3<f64>,
    normal: Vector3<f64>,
    /// Stress by the displacements.
    stress: [LoadColumn; COMPONENTS],
}

/// Points on the fillet of `model` with its `mesh`, and the stress at each: all of a place along the face one after the other, the [`COMPONENTS`]
/// of a point together.
pub(super) fn points(model: &Model, mesh: &Mesh) -> (Fillet, Vec<LoadColumn>) {
    let fillet = &model.section.fillet;
    let mut grid = Fillet {
        form_roll: model.grid.form_roll,
        arc_per_roll_squared: model.grid.arc_per_roll_squared,
        local: LOCAL_OVER_MODULE * model.gear.normal_module,
        standard_tangent: match model.gear.kind {
            GearKind::External => 30f64.to_radians(),
            GearKind::Ring => 60f64.to_radians(),
        },
        ..Fillet::default()
    };
    let mut columns = Vec::new();
    for (number, place) in Place::along(&model.grid.stations).iter().enumerate() {
        grid.z.push(place.z);
        for element in 0..fillet.len() / 2 {
            for xi in [-GAUSS2, GAUSS2] {
                let mut stress: [LoadColumn; COMPONENTS] = Default::default();
                for (at, (zeta, share)) in place.shares.iter().enumerate() {
                    let point = FacePoint::new(model, mesh, [element, place.layer], [xi, *zeta]);
                    if number == 0 && at == 0 {
                        add(&mut grid, &point, model.twist());
                        let [low, mid, high] = [0, 1, 2].map(|i| fillet[2 * element + i].1);
                        let curved = 0.5 * (low - 2.0 * mid + high) * xi * xi;
                        grid.arcs.push(mid + 0.5 * (high - low) * xi + curved);
                    }
                    for (column, part) in stress.iter_mut().zip(point.stress) {
                        column.extend(part.iter().map(|(unknown, f)| (*unknown, share * f)));
                    }
                }
                columns.extend(stress);
            }
        }
    }
    (grid, columns)
}

/// Adds a place along the profile of a gear that turns by `twist` rad per metre along z.
fn add(fillet: &mut Fillet, point: &FacePoint, twist: f64) {
    let [x, y, z] = point.place.into();
    fillet.radii.push(x.hypot(y));
    let (sin, cos) = (twist * z).sin_cos();
    let across = (point.normal[0] * cos + point.normal[1] * sin).abs();
    fillet.tangents.push(across.min(1.0).asin());
}

impl FacePoint {
    fn new(
        model: &Model,
        mesh: &Mesh,
        [element, layer]: [usize; 2],
        [xi, zeta]: [f64; 2],
    ) -> FacePoint {
        let plane = mesh.dimension == 2;
        let nodes: Vec<(usize, f64, [f64; 3])> =
            face_nodes(model.section.fillet.len() / 2, element, layer, plane)
                .map(|(node, c)| {
                    let (value, slope) = shape(2, c, &[xi, zeta, 0.0]);
                    (mesh.fillet[node], value, slope)
                })
                .collect();
        let (mut place, mut along) = (Vector3::zeros(), [Vector3::zeros(); 2]);
        for (node, value, slope) in &nodes {
            let point = Vector3::from(mesh.points[*node]);
            place += *value * point;
            along[0] += slope[0] * point;
            along[1] += slope[1] * point;
        }
        if plane {
            along[1] = Vector3::z();
        }
        // Orthonormal in the tangent plane: b along the helix, s across it.
        let helix = along[1].norm();
        let b = along[1] / helix;
        let lean = along[0].dot(&b);
        let s = along[0] - lean * b;
        let length = s.norm();
        let s = s / length;
        let [youngs_modulus, nu] = model.material();
        let stiff = youngs_modulus / (1.0 - nu * nu);
        let shear = youngs_modulus / (2.0 * (1.0 + nu));
        let mut stress: [LoadColumn; COMPONENTS] = Default::default();
        for (node, _, slope) in nodes {
            // Derivatives along s and b; those along z vanish in plane strain.
            let d_b = if plane { 0.0 } else { slope[1] / helix };
            let d_s = (slope[0] - lean * d_b) / length;
            let (sin, cos) = mesh.angles[node].sin_cos();
            let axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
            for (d, axis) in axes.iter().enumerate().take(mesh.dimension) {
                let (u_s, u_b) = (axis.dot(&s), axis.dot(&b));
                let (e_s, e_b) = (d_s * u_s, d_b * u_b);
                let unknown = mesh.dimension * node + d;
                stress[0].push((unknown, stiff * (e_s + nu * e_b)));
                stress[1].push((unknown, stiff * (e_b + nu * e_s)));
                stress[2].push((unknown, shear * (d_b * u_s + d_s * u_b)));
            }
        }
        FacePoint {
            place,
            normal: s.cross(&b),
            stress,
        }
    }
}
