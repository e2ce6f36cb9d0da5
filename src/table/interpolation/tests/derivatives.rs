//! Derivatives against finite differences.

use super::{SCALE, moved, point, shapes};
use crate::root::bisection;
use crate::table::samples::Spring;
use crate::table::{FlankTable, Interpolation, Potential, Query};

/// Largest difference between derivative and central difference over the points, relative to the
/// scale of that derivative.
fn worst_difference(
    table: &FlankTable,
    spread: f64,
    step: f64,
    f: impl Fn(&Potential) -> Vec<f64>,
    df: impl Fn(&Potential, usize) -> Vec<f64>,
    coordinates: &[usize],
) -> f64 {
    let mut worst: f64 = 0.0;
    let mut size = [1e-300_f64; 16];
    let mut differences = vec![];
    // From 1: point 0 is the very middle, a node, where the linear interpolant has a kink.
    for n in 1..300 {
        let q = point(n, spread);
        for &i in coordinates {
            let h = step * SCALE[i];
            // Fourth-order central difference.
            let at = |k: f64| f(&table.evaluate(&moved(&q, i, k * h), true));
            let (near, far) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)));
            let exact = df(&table.evaluate(&q, true), i);
            for (k, &value) in exact.iter().enumerate() {
                let slot = &mut size[4 * i + k];
                *slot = slot.max(value.abs());
                let difference =
                    (8.0 * (near.0[k] - near.1[k]) - (far.0[k] - far.1[k])) / (12.0 * h);
                differences.push((4 * i + k, (difference - value).abs()));
            }
        }
    }
    for (slot, difference) in differences {
        worst = worst.max(difference / size[slot].max(1e-12));
    }
    worst
}

#[test]
fn gradient_is_that_of_the_potential_in_every_dimension() {
    for shape in shapes() {
        for interpolation in [Interpolation::Linear, Interpolation::Spline] {
            let mut grid = Spring::grid(shape);
            grid.moment = None;
            let table = FlankTable::new(&grid, interpolation).unwrap();
            for spread in [1.0, 2.5] {
                let worst = worst_difference(
                    &table,
                    spread,
                    4e-6,
                    |w| vec![w.value],
                    |w, i| vec![w.gradient[i]],
                    &[0, 1, 2, 3],
                );
                assert!(
                    worst < 2e-7,
                    "{shape:?} {interpolation:?} {spread}: {worst}"
                );
            }
        }
    }
}

#[test]
fn second_derivatives_are_those_of_the_gradient() {
    for shape in shapes() {
        // Every coordinate, with the separate moment where there is no misalignment axis.
        let table = FlankTable::new(&Spring::grid(shape), Interpolation::Spline).unwrap();
        for spread in [1.0, 2.5] {
            let worst = worst_difference(
                &table,
                spread,
                1e-5,
                |w| w.gradient.to_vec(),
                |w, i| w.hessian.iter().map(|row| row[i]).collect(),
                &[0, 1, 2, 3],
            );
            assert!(worst < 2e-4, "{shape:?} {spread}: {worst}");
        }
    }
}

#[test]
fn constant_load_has_consistent_second_derivatives_and_passes_through_its_load() {
    for shape in shapes() {
        let grid = Spring::grid(shape);
        let table = FlankTable::constant_load(&grid, Interpolation::Spline, 60.0).unwrap();
        let worst = worst_difference(
            &table,
            2.0,
            1e-5,
            |w| w.gradient.to_vec(),
            |w, i| w.hessian.iter().map(|row| row[i]).collect(),
            &[0, 1, 2, 3],
        );
        assert!(worst < 2e-5, "{shape:?}: {worst}");
        let variable = FlankTable::new(&grid, Interpolation::Spline).unwrap();
        for &c in &grid.axes.center_distance_offset {
            for &m in &grid.axes.misalignment {
                for &p in &grid.axes.mesh_position {
                    let at = |delta| Query {
                        delta,
                        center_distance_offset: c,
                        misalignment: m,
                        mesh_position: p,
                    };
                    let delta = bisection([-1e-5, 2e-5], 60, |delta| {
                        variable.evaluate(&at(delta), false).gradient[0] < 60.0
                    });
                    let force = table.evaluate(&at(delta), false).gradient[0];
                    assert!((force - 60.0).abs() < 1e-5, "{force} N at {c} {m} {p}");
                }
            }
        }
    }
}

#[test]
fn shepard_is_one_potential_with_consistent_derivatives_in_every_dimension() {
    for shape in shapes() {
        for with_moment in [false, true] {
            let mut grid = Spring::grid(shape);
            if !with_moment {
                grid.moment = None;
            }
            let table = FlankTable::new(&grid, Interpolation::Shepard).unwrap();
            // Where shuttling has a table of its own, W's derivative by M is none of its business.
            let coordinates: &[usize] = if with_moment && shape[2] == 1 {
                &[0, 1, 3]
            } else {
                &[0, 1, 2, 3]
            };
            for spread in [1.0, 1.5] {
                let first = worst_difference(
                    &table,
                    spread,
                    1e-5,
                    |w| vec![w.value],
                    |w, i| vec![w.gradient[i]],
                    coordinates,
                );
                assert!(first < 1e-8, "{shape:?} {spread}: {first}");
                let second = worst_difference(
                    &table,
                    spread,
                    1e-5,
                    |w| w.gradient.to_vec(),
                    |w, i| w.hessian.iter().map(|row| row[i]).collect(),
                    &[0, 1, 2, 3],
                );
                assert!(second < 1e-6, "{shape:?} {spread}: {second}");
            }
        }
    }
}

#[test]
fn next_to_a_node_shepard_derivatives_are_those_of_differences_too() {
    let grid = Spring::grid([10, 5, 7, 12]);
    let table = FlankTable::new(&grid, Interpolation::Shepard).unwrap();
    let (axes, [nc, nm, np]) = (&grid.axes, [5, 7, 12]);
    // Of the grid.
    let spacing = [1e-6, 50e-6, 1e-3, 1.0 / 12.0];
    for n in 0..40 {
        // Nodes inside the range: at its ends the onset goes on with another curvature.
        let [c, m, p, u] = [1 + n % (nc - 2), 1 + n % (nm - 2), n % np, n % 9];
        let at = (c * nm + m) * np + p;
        let low = grid.no_load_approach[at];
        let span = grid.top_load_approach[at] - low;
        let node = Query {
            delta: low + axes.displacement_fraction[u] * span,
            center_distance_offset: axes.center_distance_offset[c],
            misalignment: axes.misalignment[m],
            mesh_position: axes.mesh_position[p],
        };
        for far in [0.0, 1e-5, 1e-4, 1e-3] {
            let q = moved(&node, n % 4, far * spacing[n % 4]);
            let exact = table.evaluate(&q, true);
            for i in 0..4 {
                let h = 1e-5 * spacing[i];
                let at = |k: f64| table.evaluate(&moved(&q, i, k * h), true).gradient;
                let (near, wide) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)));
                for (k, row) in exact.hessian.iter().enumerate() {
                    let difference =
                        (8.0 * (near.0[k] - near.1[k]) - (wide.0[k] - wide.1[k])) / (12.0 * h);
                    // The whole force over one spacing, in units of both coordinates.
                    let scale = spacing[0] / (spacing[k] * spacing[i]) * exact.gradient[0];
                    let error = (difference - row[i]).abs() / scale;
                    assert!(error < 1e-6, "node {n}, {far} off, row {k} by {i}: {error}");
                }
            }
        }
    }
}
