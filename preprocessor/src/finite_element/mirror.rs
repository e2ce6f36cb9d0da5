//! Two halves of the face in place of all of it, where the plane in its middle mirrors teeth and body.
//!
//! Any load on such a gear is the sum of one that is alike on both sides of the plane and one that is opposite. Under the first the plane
//! does not move along z, under the second along z only; so the half of the face above it, fixed either way, is enough:
//!
//! ```text
//! C_ij = (C^even_|i||j| + s_i s_j C^odd_|i||j|) / 2 ,
//! ```
//!
//! |i| the node of the upper half that node i is or mirrors, s_i = -1 for nodes below the plane and 1 for the others. Two halves take
//! half the work of the whole, and a quarter in the harmonics of the ring.

use super::flank::FlankGrid;
use super::mesh::Layers;
use crate::gear::body;
use gearmesh::gear::Gear;
use nalgebra::DMatrix;
use std::ops::Range;

/// Components (radial, tangential, along z) of the displacement that are zero on the plane under loads that are alike on both sides, and
/// under opposite ones.
pub(super) const FIXED: [Range<usize>; 2] = [2..3, 0..2];

/// Those of `layers` above the middle of the face, if its plane mirrors `gear`.
pub(super) fn upper_half(gear: &Gear, layers: &Layers) -> Option<Layers> {
    let is_mirrored = gear.helix_angle == 0.0 && body::turned(gear).is_none();
    is_mirrored.then(|| layers.above(0.5 * gear.face_width))?
}

/// Influence of the flank nodes of `grid` by that of its upper half, fixed as in [`FIXED`].
pub(super) fn of_whole_face(grid: &FlankGrid, [even, odd]: [&DMatrix<f64>; 2]) -> DMatrix<f64> {
    let nodes = mirrored_nodes(grid);
    DMatrix::from_fn(nodes.len(), nodes.len(), |i, j| {
        let [(i, sign_i), (j, sign_j)] = [nodes[i], nodes[j]];
        0.5 * (even[(i, j)] + sign_i * sign_j * odd[(i, j)])
    })
}

/// |i| and s_i of the nodes of `grid`.
fn mirrored_nodes(grid: &FlankGrid) -> Vec<(usize, f64)> {
    let first_of: Vec<usize> = grid.planes().map(|plane| plane.start).collect();
    let middle = first_of.len() / 2;
    let mut nodes = Vec::new();
    for (plane, of_plane) in grid.planes().enumerate() {
        let sign = if plane < middle { -1.0 } else { 1.0 };
        let first = first_of[plane.abs_diff(middle)];
        nodes.extend((0..of_plane.len()).map(|i| (first + i, sign)));
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_element::Settings;
    use crate::finite_element::model::Model;
    use crate::finite_element::ring::LEFT_OUT;
    use crate::gear::Refinement;
    use crate::gear::body::Stub;
    use crate::samples;
    use gearmesh::gear::{Body, GearKind};

    /// A disc, a ring on a foundation, a thin rim on a web and a shaft held at both ends.
    fn mirrored_gears() -> [Gear; 4] {
        let mut disc = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        disc.face_width = 8e-3;
        let mut ring = samples::gear(GearKind::Ring, 60, 1.0, 0.0, 0.0);
        ring.face_width = 8e-3;
        ring.foundation = Some(1e9);
        ring.held_radius = ring.root_radius() + 50e-3;
        let mut webbed = samples::gear(GearKind::External, 61, 1.0, 0.0, 0.0);
        webbed.face_width = 8e-3;
        webbed.body = Some(Body {
            rim_radius: webbed.root_radius() - 4e-3,
            web: [3e-3, 5e-3],
            hub_radius: webbed.held_radius + 5e-3,
            hub: [-1e-3, 9e-3],
            held_ends: [false; 2],
        });
        let mut shaft = samples::gear(GearKind::External, 30, 1.0, 0.0, 0.0);
        shaft.face_width = 8e-3;
        let stub = Stub {
            radius: 30e-3,
            length: 20e-3,
            held: true,
        };
        shaft.body = Some(body::shaft([stub; 2], shaft.face_width));
        shaft.held_radius = 3e-3;
        [disc, ring, webbed, shaft]
    }

    #[test]
    fn two_halves_give_the_influence_of_the_whole_face() {
        // Gears of whose body few elements stand for a pitch, on whose edges nodes of the plane hang.
        let mut bodies_apart = 0;
        for gear in mirrored_gears() {
            let model = Model::new(&gear, &Settings::new(Refinement::Coarse, 1)).unwrap();
            assert!(model.upper_half().is_some());
            let found = model.influence(&mut None, &|_, _| true).unwrap();
            let mesh = model.mesh();
            bodies_apart += usize::from(mesh.body < mesh.elements.len());
            let all = mesh.loads.len();
            let whole = model.response(&mesh, &mesh.loads, all, 0..=1, &|_, _| true);
            for (found, whole) in found.iter().zip(&whole.unwrap()) {
                let (error, largest) = ((found - whole).amax(), whole.amax());
                // Both leave that much out.
                assert!(error < 2.0 * LEFT_OUT * largest, "{error:e} of {largest:e}");
            }
        }
        assert!(bodies_apart >= 2, "{bodies_apart}");
    }

    #[test]
    fn helical_gears_and_bodies_that_stand_to_one_side_have_no_halves() {
        let has_halves = |gear: &Gear| {
            let model = Model::new(gear, &Settings::new(Refinement::Coarse, 1)).unwrap();
            model.upper_half().is_some()
        };
        let [disc, _, webbed, shaft] = mirrored_gears();
        assert!(has_halves(&disc));
        let mut helical = disc.clone();
        helical.helix_angle = 0.1;
        assert!(!has_halves(&helical));
        let mut aside = webbed.clone();
        aside.body.as_mut().unwrap().web = [3e-3, 4e-3];
        assert!(!has_halves(&aside));
        let mut held_once = shaft.clone();
        held_once.body.as_mut().unwrap().held_ends = [true, false];
        assert!(!has_halves(&held_once));
    }
}
