//! Values against springs with a known potential.

use super::{point, sequence};
use crate::table::samples::Spring;
use crate::table::{Axis, FlankTable, Interpolation, Query};

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
fn tables_cut_at_nominal_agree_with_the_whole() {
    let grid = Spring::grid([10, 7, 8, 16]);
    let cut = grid
        .sliced(Axis::CenterDistance)
        .unwrap()
        .sliced(Axis::Misalignment)
        .unwrap();
    let whole = FlankTable::new(&grid, Interpolation::Spline).unwrap();
    let small = FlankTable::new(&cut, Interpolation::Spline).unwrap();
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
