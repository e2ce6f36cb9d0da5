//! Condensation and ring closure against closed forms and against the whole gear in one piece.

use super::condensation::condense;
use super::mesh::{LoadColumn, Mesh};
use super::outline::Outline;
use super::*;
use crate::samples;
use approx::assert_relative_eq;
use gearmesh::gear::{GearKind, ToothProfile};
use gearmesh::pair::Refinement;
use std::f64::consts::PI;

const E: f64 = 206e9;

/// Sector of a plane ring from `inner` (held) to `outer`, one of `teeth`; `rows` elements along the
/// radius, two around.
fn ring_sector(inner: f64, outer: f64, teeth: u32, rows: usize) -> Mesh {
    let half_pitch = PI / f64::from(teeth);
    let columns = 2;
    let id = |i: usize, j: usize| i * (2 * rows + 1) + j;
    let mut mesh = Mesh {
        dimension: 2,
        ..Mesh::default()
    };
    for i in 0..=2 * columns {
        let angle = half_pitch * (i as f64 / columns as f64 - 1.0);
        for j in 0..=2 * rows {
            let r = inner + (outer - inner) * j as f64 / (2 * rows) as f64;
            mesh.points.push([r * angle.cos(), r * angle.sin(), 0.0]);
            mesh.angles.push(angle);
            // Element centres carry no node of the element: held, they do no harm.
            mesh.held.push(j == 0 || (i % 2 == 1 && j % 2 == 1));
        }
    }
    for i in (0..2 * columns).step_by(2) {
        for j in (0..2 * rows).step_by(2) {
            mesh.elements.extend([
                id(i, j),
                id(i, j + 2),
                id(i + 2, j + 2),
                id(i + 2, j),
                id(i, j + 1),
                id(i + 1, j + 2),
                id(i + 2, j + 1),
                id(i + 1, j),
            ]);
            mesh.cells.push([i as i32 / 2, j as i32 / 2, 0]);
        }
    }
    mesh.sides = [0, 2 * columns].map(|i| (1..=2 * rows).map(|j| id(i, j)).collect());
    mesh
}

#[test]
fn blank_under_torque_turns_like_a_disk() {
    // A ring held at a under a shear flow at R: u_theta(R) = T R / (4 pi G) (1/a² - 1/R²) per metre.
    let (inner, outer, teeth) = (10e-3, 30e-3, 24);
    let mesh = ring_sector(inner, outer, teeth, 12);
    // Consistent nodal forces of an even shear flow on both outer edges: 1/6, 4/6, 1/6 of each.
    let shares = [1.0, 4.0, 2.0, 4.0, 1.0].map(|w: f64| w / 12.0);
    let top = 24;
    let load: LoadColumn = (0..5)
        .map(|i| (2 * (i * (top + 1) + top) + 1, shares[i]))
        .collect();
    let sector = condense(&mesh, [E, 0.3], &[load], 1, &|_| true).unwrap();
    let reach = teeth as usize - 1;
    let solved = harmonics::solved(teeth as usize, reach);
    let influence = ring::response(&sector, teeth, 0..=reach as i32, &solved, &|_| true).unwrap();
    // A unit force on every sector: torque = teeth * outer.
    let found: f64 = influence.iter().map(|c| c[(0, 0)]).sum();
    let shear_modulus = E / 2.6;
    let torque = f64::from(teeth) * outer;
    let expected = torque * outer / (4.0 * PI * shear_modulus)
        * (1.0 / (inner * inner) - 1.0 / (outer * outer));
    assert_relative_eq!(found, expected, max_relative = 1e-4);
}

#[test]
fn cantilever_of_solid_elements_bends_like_timoshenko() {
    // A straight beam along x: no twist, no sides, angles 0 make the axes Cartesian. nu = 0, so that the
    // clamping does not stiffen it; shear coefficient 5/6.
    let (length, height, width) = (100e-3, 10e-3, 10e-3);
    let (nx, ny, nz) = (10usize, 2usize, 1usize);
    let id = |i: usize, j: usize, k: usize| (i * (2 * ny + 1) + j) * (2 * nz + 1) + k;
    let mut mesh = Mesh {
        dimension: 3,
        ..Mesh::default()
    };
    for i in 0..=2 * nx {
        for j in 0..=2 * ny {
            for k in 0..=2 * nz {
                let at = |n: usize, of: usize, size: f64| size * n as f64 / (2 * of) as f64;
                mesh.points
                    .push([at(i, nx, length), at(j, ny, height), at(k, nz, width)]);
                mesh.angles.push(0.0);
                mesh.held.push(i == 0 || i % 2 + j % 2 + k % 2 > 1);
            }
        }
    }
    for (i, j, k) in
        (0..nx * ny * nz).map(|n| (2 * (n / (ny * nz)), 2 * ((n / nz) % ny), 2 * (n % nz)))
    {
        mesh.elements.extend(element::HEX20.iter().map(|c| {
            let half = |c: f64| (1.0 + c) as usize;
            id(i + half(c[0]), j + half(c[1]), k + half(c[2]))
        }));
        mesh.cells.push([i as i32 / 2, j as i32 / 2, k as i32 / 2]);
    }
    let load: LoadColumn = [0, 2 * nz]
        .map(|k| (3 * id(2 * nx, ny, k) + 1, 0.5))
        .to_vec();
    let sector = condense(&mesh, [E, 0.0], &[load], 1, &|_| true).unwrap();
    let inertia = width * height.powi(3) / 12.0;
    let shear = 5.0 / 6.0 * width * height * E / 2.0;
    let expected = length.powi(3) / (3.0 * E * inertia) + length / shear;
    assert_relative_eq!(sector.held_influence[(0, 0)], expected, max_relative = 5e-3);
}

fn gear(kind: GearKind, teeth: u32, shift: f64, helix_deg: f64) -> Gear {
    let module = 2e-3;
    let mut gear = samples::with_module(samples::gear(kind, teeth, 1.0, helix_deg, shift), module);
    gear.face_width = 10e-3;
    gear.youngs_modulus = E;
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
    let settings = Settings {
        plane_strain: true,
        ..Settings::new(Refinement::Coarse, 1)
    };
    let model = Model::new(&gear, &settings).unwrap();
    let sector = Mesh::new(&model);

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
        points: Vec::new(),
        angles: Vec::new(),
        elements: Vec::new(),
        cells: Vec::new(),
        held: Vec::new(),
        sides: [Vec::new(), Vec::new()],
        ..sector.clone()
    };
    for s in 0..teeth {
        let turn = 2.0 * PI * s as f64 / teeth as f64;
        for (node, [x, y, _]) in sector.points.iter().enumerate() {
            let (r, angle) = (x.hypot(*y), sector.angles[node] + turn);
            whole.points.push([r * angle.cos(), r * angle.sin(), 0.0]);
            whole.angles.push(angle);
            whole
                .held
                .push(sector.held[node] || twin[node] != usize::MAX);
        }
        whole
            .elements
            .extend(sector.elements.iter().map(|node| number(*node, s)));
        whole.cells.extend(
            sector
                .cells
                .iter()
                .map(|c| [c[0] + 100 * s as i32, c[1], 0]),
        );
    }
    let columns: Vec<LoadColumn> = [0, 1, 11]
        .iter()
        .flat_map(|s| sector.flank.iter().map(move |f| (*s, f)))
        .map(|(s, f)| {
            (0..2)
                .map(|d| (2 * number(f.node, s) + d, f.normal[d]))
                .collect()
        })
        .collect();
    let direct = condense(&whole, [E, 0.3], &columns, columns.len(), &|_| true)
        .unwrap()
        .held_influence;

    let influence = model.influence(&|_, _| true).unwrap();
    let m = sector.flank.len();
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
    let thin_rim = Gear {
        held_radius: gears[3].root_radius() - 0.6e-3,
        ..gears[3].clone()
    };
    let thick_web = Gear {
        held_radius: 0.1 * gears[12].root_radius(),
        ..gears[12].clone()
    };
    gears.extend([thin_rim, thick_web]);
    for gear in &gears {
        for refinement in [Refinement::Coarse, Refinement::Normal, Refinement::Fine] {
            let solid = model::Model::new(gear, &Settings::new(refinement, 1)).unwrap();
            let (volume, quality) = Mesh::new(&solid).volume_and_quality();
            assert!(
                quality > 0.05,
                "z {} x {} quality {quality:.3}",
                gear.teeth,
                gear.profile_shift
            );
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
