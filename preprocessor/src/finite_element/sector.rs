//! Figures of one sector, for studies.

use super::element::{QUAD8, shape};
use super::mesh::Mesh;
use super::model::Model;
use super::{FiniteElementError, Settings};
use gearmesh::compliance::Segment;
use gearmesh::gear::Gear;

/// How many displacements of one sector of `gear` are free.
///
/// # Errors
/// As [`super::FiniteElementCompliance::new`]: no usable tooth, too thin a rim.
pub fn sector_unknowns(gear: &Gear, settings: &Settings) -> Result<usize, FiniteElementError> {
    let mesh = Mesh::new(&Model::new(gear, settings)?);
    let free = mesh.held.iter().filter(|held| !**held).count();
    Ok(mesh.dimension * free)
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
    let mesh = Mesh::new(&model);
    let of_nodes = mesh.loads();
    let weights = model.grid.weights(&segment);
    let load = (weights.iter())
        .flat_map(|(node, w)| of_nodes[*node].iter().map(move |(at, n)| (*at, w * n)))
        .collect();
    // Direction of the normal, from the x axis; the load line touches the base circle.
    let pressure_angle = (roll / gear.base_radius()).atan();
    let angle = gear.half_base_angle() - (roll / gear.base_radius() - pressure_angle);
    let direction = angle + std::f64::consts::FRAC_PI_2 - pressure_angle;
    let crossing = gear.base_radius() / direction.sin();
    let observed = shape_functions_at(&mesh, crossing)
        .ok_or(FiniteElementError::NoCrossing(1e3 * crossing))?
        .into_iter()
        .flat_map(|(node, n)| {
            // Components in the node's own axes.
            let turned = direction - mesh.angles[node];
            [
                (2 * node, n * turned.cos()),
                (2 * node + 1, n * turned.sin()),
            ]
        })
        .collect();
    let influence = model.response(&mesh, &[load, observed], 2, 0..=0, &|_, _| true)?;
    Ok(influence[0][(1, 0)])
}

/// Shape functions at the point (x, 0) of a plane mesh, by node; None outside of it.
fn shape_functions_at(mesh: &Mesh, x: f64) -> Option<Vec<(usize, f64)>> {
    for nodes in mesh.connectivity() {
        let at = mesh.coordinates(nodes);
        let mut xi = [0.0; 3];
        for _ in 0..20 {
            let (mut p, mut j) = ([-x, 0.0], [[0.0; 2]; 2]);
            for (c, at) in QUAD8.iter().zip(&at) {
                let (n, g) = shape(2, c, &xi);
                for d in 0..2 {
                    p[d] += n * at[d];
                    j[d][0] += g[0] * at[d];
                    j[d][1] += g[1] * at[d];
                }
            }
            let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
            xi[0] -= (j[1][1] * p[0] - j[0][1] * p[1]) / det;
            xi[1] -= (j[0][0] * p[1] - j[1][0] * p[0]) / det;
            xi = xi.map(|v: f64| v.clamp(-2.0, 2.0));
        }
        if xi[0].abs() <= 1.0 + 1e-9 && xi[1].abs() <= 1.0 + 1e-9 {
            let weights = nodes.iter().zip(&QUAD8);
            return Some(
                weights
                    .map(|(node, c)| (*node, shape(2, c, &xi).0))
                    .collect(),
            );
        }
    }
    None
}
