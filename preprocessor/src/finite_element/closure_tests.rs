//! Condensation and ring closure against the whole gear in one piece, and meshes of extreme gears.

use super::condensation::condense;
use super::mesh::{LoadColumn, Mesh};
use super::model::Model;
use super::outline::Outline;
use super::tests::plane;
use super::*;
use crate::gear::Refinement;
use crate::gear::ToothProfile;
use crate::samples;
use approx::assert_relative_eq;
use gearmesh::gear::{Gear, GearKind};
use std::f64::consts::PI;

fn gear(kind: GearKind, teeth: u32, shift: f64, helix_deg: f64) -> Gear {
    let module = 2e-3;
    let mut gear = samples::with_module(samples::gear(kind, teeth, 1.0, helix_deg, shift), module);
    gear.face_width = 10e-3;
    let kappa = gear.kappa();
    gear.tip_radius = gear.reference_radius() + module * (shift + kappa);
    gear.held_radius = match kind {
        GearKind::External => 0.5 * gear.root_radius(),
        GearKind::Ring => gear.root_radius() + 3.0 * module,
    };
    gear
}

#[test]
fn ring_of_condensed_sectors_is_the_whole_gear_in_one_piece() {
    let gear = gear(GearKind::External, 12, 0.3, 0.0);
    let model = Model::new(&gear, &plane(Refinement::Coarse, 1)).unwrap();
    let sector = model.mesh();

    // All sectors with common sides, nothing kept: side 1 of sector s is side 0 of sector s + 1.
    let n = sector.points.len();
    let teeth = gear.teeth as usize;
    let mut twin = vec![usize::MAX; n];
    for (left, right) in sector.sides[0].iter().zip(&sector.sides[1]) {
        twin[*right] = *left;
    }
    let number = |node: usize, s: usize| match twin[node] {
        usize::MAX => s * n + node,
        left => (s + 1) % teeth * n + left,
    };
    let mut whole = Mesh {
        dimension: 2,
        material: sector.material,
        ..Mesh::default()
    };
    for s in 0..teeth {
        let turn = 2.0 * PI * s as f64 / teeth as f64;
        for (node, [x, y, _]) in sector.points.iter().enumerate() {
            let (r, angle) = (x.hypot(*y), sector.angles[node] + turn);
            whole.points.push([r * angle.cos(), r * angle.sin(), 0.0]);
            whole.angles.push(angle);
            let is_other_side = twin[node] != usize::MAX;
            whole.held.push(sector.held[node] || is_other_side);
        }
        for (nodes, cell) in sector.elements.iter().zip(&sector.cells) {
            let nodes = nodes.iter().map(|node| number(*node, s));
            whole.elements.push(nodes.collect());
            whole.cells.push([cell[0] + 100 * s as i32, cell[1], 0]);
        }
    }
    whole.body = whole.elements.len();
    let on_sector = |s: usize, load: &LoadColumn| -> LoadColumn {
        let unknown = |at: usize| 2 * number(at / 2, s) + at % 2;
        load.iter().map(|(at, n)| (unknown(*at), *n)).collect()
    };
    let columns: Vec<LoadColumn> = ([0, 1, 11].into_iter())
        .flat_map(|s| sector.loads.iter().map(move |load| on_sector(s, load)))
        .collect();
    let direct = condense(&whole, &columns, columns.len(), 1.0, &|_| true)
        .unwrap()
        .held_influence;

    let influence = model.influence(&mut None, &|_, _| true).unwrap();
    let m = sector.loads.len();
    let scale = influence[0].amax();
    for i in 0..m {
        for j in 0..m {
            assert!((influence[0][(i, j)] - direct[(i, j)]).abs() < 1e-9 * scale);
            // Rows tooth 1, columns tooth 0; tooth 11 is tooth -1.
            let next = direct[(m + i, j)];
            assert!((influence[1][(i, j)] - next).abs() < 1e-9 * scale);
            let previous = direct[(2 * m + i, j)];
            assert!((influence[1][(j, i)] - previous).abs() < 1e-9 * scale);
        }
    }
}

#[test]
fn meshes_of_usual_and_extreme_gears_are_sound() {
    // The volume of the solid is that of the plane section times the face width; the section's area is
    // the integral over the outline.
    let mut gears = vec![
        gear(GearKind::Ring, 40, 0.0, 0.0),
        gear(GearKind::Ring, 71, 0.5, 15.0),
        gear(GearKind::Ring, 100, -0.4, 0.0),
    ];
    for (teeth, shift, helix) in [
        (10, 0.5, 0.0),
        (12, 0.0, 0.0),
        (14, 0.0, 0.0),
        (17, 0.0, 0.0),
        (17, 0.8, 30.0),
        (20, -0.3, 13.0),
        (25, 1.0, 0.0),
        (43, -0.5, 0.0),
        (100, 0.0, 35.0),
        (100, -1.0, 0.0),
    ] {
        gears.push(gear(GearKind::External, teeth, shift, helix));
    }
    let [mut thin_rim, mut small_bore] = [3, 12].map(|i: usize| gears[i].clone());
    thin_rim.held_radius = thin_rim.root_radius() - 0.6e-3;
    small_bore.held_radius = 0.1 * small_bore.root_radius();
    gears.extend([thin_rim, small_bore]);
    for gear in &gears {
        for refinement in [Refinement::Coarse, Refinement::Normal, Refinement::Fine] {
            let solid = Model::new(gear, &Settings::new(refinement, 1)).unwrap();
            let (volume, quality) = solid.mesh().volume_and_quality();
            let (z, x) = (gear.teeth, gear.profile_shift);
            assert!(quality > 0.05, "z {z} x {x} quality {quality:.3}");
            let outline = Outline::new(&ToothProfile::new(gear).unwrap());
            let (low, high, steps) = (outline.space_arc(), outline.tip_arc, 20000);
            // Both halves of the tooth side: area between outline and the axis, less the held circle.
            let mut area = 0.0;
            let mut last = outline.point(low);
            for i in 1..=steps {
                let next = outline.point(low + (high - low) * f64::from(i) / f64::from(steps));
                area += 0.5 * (last[0] * last[0] + next[0] * next[0]) * (last[1] - next[1]);
                last = next;
            }
            area += last[0] * last[0] * last[1];
            area -= gear.held_radius.powi(2) * PI / gear.z();
            let expected = gear.kappa() * area * gear.face_width;
            assert_relative_eq!(volume, expected, max_relative = 1e-3);
        }
    }
}
