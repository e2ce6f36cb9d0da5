//! Claims of the interpolants, against a spring with a known potential and finite differences.

use super::*;
use crate::table::SlicedAxis;
use crate::table::samples::Spring;

/// A fixed sequence of numbers in [0, 1) (additive recurrence; no seed to forget).
fn sequence(n: usize, k: usize) -> f64 {
    let root = [
        0.856_674_883_854_502_9,
        0.733_891_856_627_126_8,
        0.628_706_721_037_080_8,
        0.538_597_257_223_611_3,
    ];
    (0.5 + root[k] * n as f64).fract()
}

/// The n-th point inside, or `spread` times as far out, with delta from before the onset to the top.
pub(super) fn point(n: usize, spread: f64) -> Query {
    let s = |k| spread * (2.0 * sequence(n, k) - 1.0);
    let mut q = Query {
        delta: 0.0,
        center_distance_offset: 100e-6 * s(1),
        misalignment: 3e-3 * s(2),
        mesh_position: s(3),
    };
    let onset = q.center_distance_offset * 3e-3 - 0.2 * q.misalignment.powi(2);
    q.delta = onset + 8e-6 * sequence(n, 0) * spread;
    q
}

pub(super) fn moved(q: &Query, i: usize, by: f64) -> Query {
    let mut q = *q;
    match i {
        0 => q.delta += by,
        1 => q.center_distance_offset += by,
        2 => q.misalignment += by,
        _ => q.mesh_position += by,
    }
    q
}

/// Size of each coordinate.
pub(super) const SCALE: [f64; 4] = [1e-6, 1e-4, 3e-3, 1.0];

/// All combinations of axes, by their counts.
fn shapes() -> impl Iterator<Item = [usize; 4]> {
    (0..8).map(|bits: usize| {
        let n = |bit: usize, count| if bits & bit != 0 { count } else { 1 };
        [10, n(1, 5), n(2, 7), n(4, 12)]
    })
}

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
fn the_gradient_of_the_stiffness_is_that_of_the_stiffness() {
    for shape in shapes() {
        let table = FlankTable::new(&Spring::grid(shape), Interpolation::Spline).unwrap();
        for spread in [1.0, 2.5] {
            let worst = worst_difference(
                &table,
                spread,
                1e-5,
                |w| vec![w.hessian[0][0]],
                |w, i| vec![w.stiffness_gradient.unwrap_or_default()[i]],
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
                    let (mut low, mut high) = (-1e-5, 2e-5);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if variable.evaluate(&at(middle), false).gradient[0] < 60.0 {
                            low = middle;
                        } else {
                            high = middle;
                        }
                    }
                    let force = table.evaluate(&at(low), false).gradient[0];
                    assert!((force - 60.0).abs() < 1e-5, "{force} N at {c} {m} {p}");
                }
            }
        }
    }
}

#[test]
fn spline_finds_a_smooth_springs_force_shuttling_and_other_gradients() {
    let table = FlankTable::new(&Spring::grid([12, 9, 9, 32]), Interpolation::Spline).unwrap();
    let linear = FlankTable::new(&Spring::grid([12, 9, 9, 32]), Interpolation::Linear).unwrap();
    let mut errors = [[0.0_f64; 4]; 2];
    let mut size = [0.0_f64; 4];
    for n in 0..3000 {
        let q = point(n, 1.0);
        let exact = Spring::potential(&q);
        for (t, error) in [&table, &linear].iter().zip(&mut errors) {
            let found = t.evaluate(&q, false);
            if found.out_of_range {
                continue;
            }
            for (e, (f, x)) in error
                .iter_mut()
                .zip(found.gradient.iter().zip(exact.gradient))
            {
                *e = e.max((f - x).abs());
            }
        }
        for (s, x) in size.iter_mut().zip(exact.gradient) {
            *s = s.max(x.abs());
        }
    }
    for i in 0..4 {
        assert!(
            errors[0][i] < 1e-3 * size[i],
            "coordinate {i}: {} of {}",
            errors[0][i],
            size[i]
        );
        assert!(
            errors[0][i] < 0.1 * errors[1][i],
            "coordinate {i}: linear {}",
            errors[1][i]
        );
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
                assert!(first < 1e-5, "{shape:?} {spread}: {first}");
                let second = worst_difference(
                    &table,
                    spread,
                    1e-5,
                    |w| w.gradient.to_vec(),
                    |w, i| w.hessian.iter().map(|row| row[i]).collect(),
                    &[0, 1, 2, 3],
                );
                assert!(second < 1e-3, "{shape:?} {spread}: {second}");
            }
        }
    }
}

#[test]
fn shepard_passes_through_the_samples_and_errs_no_more_than_linear() {
    let grid = Spring::grid([10, 5, 7, 16]);
    let shepard = FlankTable::new(&grid, Interpolation::Shepard).unwrap();
    let linear = FlankTable::new(&grid, Interpolation::Linear).unwrap();
    let mut squares = [0.0_f64; 2];
    for n in 0..2000 {
        let q = point(n, 1.0);
        let exact = Spring::potential(&q).gradient[0];
        for (t, sum) in [&shepard, &linear].iter().zip(&mut squares) {
            *sum += (t.evaluate(&q, false).gradient[0] - exact).powi(2);
        }
    }
    assert!(squares[0] < squares[1], "{squares:?}");
}

#[test]
fn spline_reproduces_cubics_exactly() {
    // No mesh position: a cubic is not periodic.
    let mut grid = Spring::grid([9, 6, 7, 1]);
    let (mut k, mut n) = (0, 0);
    let shape = |c: f64, m: f64| {
        let (x, y) = (c / 1e-4, m / 3e-3);
        let low = 1e-6 * (x.powi(3) - 2.0 * x * y * y + y.powi(3));
        (
            low,
            1e-6 * (8.0 + x * x * y + y),
            100.0 * (3.0 + x.powi(3) * y - y * y),
        )
    };
    let axes = grid.axes.clone();
    for &c in &axes.center_distance_offset {
        for &m in &axes.misalignment {
            let (low, span, force) = shape(c, m);
            grid.no_load_approach[n] = low;
            grid.top_load_approach[n] = low + span;
            n += 1;
            for &u in &axes.displacement_fraction {
                grid.loa_force[k] = force * u.powi(3);
                k += 1;
            }
        }
    }
    let table = FlankTable::new(&grid, Interpolation::Spline).unwrap();
    for n in 0..500 {
        let mut q = point(n, 1.0);
        let (low, span, force) = shape(q.center_distance_offset, q.misalignment);
        let u = sequence(n, 0);
        q.delta = low + u * span;
        let w = table.evaluate(&q, false);
        assert!((w.gradient[0] - force * u.powi(3)).abs() < 1e-9);
        assert!((w.value - span * force * u.powi(4) / 4.0).abs() < 1e-15);
        assert!((w.hessian[0][0] * span - 3.0 * force * u * u).abs() < 1e-7);
    }
}

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

#[test]
fn tables_cut_at_nominal_agree_with_the_whole() {
    let grid = Spring::grid([10, 7, 8, 16]);
    let cut = grid
        .sliced(SlicedAxis::CenterDistance)
        .unwrap()
        .sliced(SlicedAxis::Misalignment)
        .unwrap();
    let whole = FlankTable::new(&grid, Interpolation::Spline).unwrap();
    let small = FlankTable::new(&cut, Interpolation::Spline).unwrap();
    assert_eq!((whole.dimensions(), small.dimensions()), (4, 2));
    assert!(small.bytes() * 10 < whole.bytes());
    for n in 0..200 {
        let q = Query {
            center_distance_offset: 0.0,
            misalignment: 0.0,
            ..point(n, 1.0)
        };
        let (a, b) = (whole.evaluate(&q, false), small.evaluate(&q, false));
        assert!((a.value - b.value).abs() < 1e-12);
        assert!((a.gradient[0] - b.gradient[0]).abs() < 1e-8);
        assert!((a.gradient[3] - b.gradient[3]).abs() < 1e-12);
    }
}
