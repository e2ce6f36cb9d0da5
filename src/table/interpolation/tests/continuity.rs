//! The onset, the cells' ends and the turn of the mesh cycle.

use super::{SCALE, moved, point, sequence};
use crate::table::samples::Spring;
use crate::table::{FlankTable, Interpolation};

#[test]
fn force_is_exactly_zero_up_to_the_onset_and_starts_without_a_kink() {
    for interpolation in [
        Interpolation::Linear,
        Interpolation::Spline,
        Interpolation::Shepard,
    ] {
        let table = FlankTable::new(&Spring::grid([10, 5, 5, 16]), interpolation).unwrap();
        for n in 0..500 {
            let mut q = point(n, 1.5);
            q.delta = -1.0;
            assert_eq!(table.evaluate(&q, true).gradient, [0.0; 4]);
            let (mut low, mut high) = (-1e-4, 1e-4);
            for _ in 0..200 {
                q.delta = 0.5 * (low + high);
                if table.evaluate(&q, false).gradient[0] > 0.0 {
                    high = q.delta;
                } else {
                    low = q.delta;
                }
            }
            if interpolation != Interpolation::Linear {
                q.delta = high + 1e-10;
                let w = table.evaluate(&q, true);
                assert!(w.gradient[0] < 1e-6 && w.hessian[0][0] < 1e5, "{w:?}");
            }
        }
    }
}

#[test]
fn spline_force_is_twice_continuously_differentiable_across_every_cell() {
    let grid = Spring::grid([8, 6, 6, 12]);
    let table = FlankTable::new(&grid, Interpolation::Spline).unwrap();
    let step = 1e-9;
    let mut largest: f64 = 0.0;
    let ways: [(usize, Vec<f64>); 3] = [
        (1, grid.axes.center_distance_offset.clone()),
        (2, grid.axes.misalignment.clone()),
        (3, grid.axes.mesh_position.clone()),
    ];
    for (i, nodes) in ways {
        for &node in &nodes {
            for n in 0..20 {
                let mut q = point(n, 1.0);
                match i {
                    1 => q.center_distance_offset = node,
                    2 => q.misalignment = node,
                    _ => q.mesh_position = node,
                }
                if i != 3 && (node == nodes[0] || node == nodes[nodes.len() - 1]) {
                    continue;
                }
                let a = table.evaluate(&moved(&q, i, -step * SCALE[i]), true);
                let b = table.evaluate(&moved(&q, i, step * SCALE[i]), true);
                for r in 0..4 {
                    for c in 0..4 {
                        let jump = (a.hessian[r][c] - b.hessian[r][c]) * SCALE[r] * SCALE[c];
                        largest = largest.max(jump.abs() / 1e-3);
                    }
                }
            }
        }
    }
    // Relative to 1 mJ, the size of W: a jump of a second derivative would be of order 1.
    assert!(largest < 1e-6, "{largest}");
}

#[test]
fn everything_is_periodic_in_mesh_position() {
    for interpolation in [
        Interpolation::Linear,
        Interpolation::Spline,
        Interpolation::Shepard,
    ] {
        let table = FlankTable::new(&Spring::grid([8, 1, 5, 16]), interpolation).unwrap();
        for n in 0..200 {
            let mut q = point(n, 1.0);
            // A multiple of 2^-10, so that adding whole turns rounds nothing.
            q.mesh_position = (q.mesh_position * 1024.0).round() / 1024.0;
            let turned = moved(&q, 3, 4_000_000.0 * (sequence(n, 1) - 0.5).round() + 7.0);
            assert_eq!(table.evaluate(&q, true), table.evaluate(&turned, true));
        }
    }
}
