//! Claims of the interpolants: here values against springs with a known potential, and jagged samples.

mod continuity;
mod derivatives;

use super::*;
use crate::table::Axis;
use crate::table::samples::Spring;
use proptest::prelude::*;

const ALL: [Interpolation; 3] = [
    Interpolation::Linear,
    Interpolation::Spline,
    Interpolation::Shepard,
];

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
fn point(n: usize, spread: f64) -> Query {
    let s = |k| spread * (2.0 * sequence(n, k) - 1.0);
    let mut q = Query::from([0.0, 100e-6 * s(1), 3e-3 * s(2), s(3)]);
    let onset = q.center_distance_offset * 3e-3 - 0.2 * q.misalignment.powi(2);
    q.delta = onset + 8e-6 * sequence(n, 0) * spread;
    q
}

/// `q` with the coordinate `i` at `value`.
fn with(q: &Query, i: usize, value: f64) -> Query {
    let mut coordinates = q.coordinates();
    coordinates[i] = value;
    Query::from(coordinates)
}

fn moved(q: &Query, i: usize, by: f64) -> Query {
    with(q, i, q.coordinates()[i] + by)
}

/// Size of each coordinate.
const SCALE: [f64; 4] = [1e-6, 1e-4, 3e-3, 1.0];

/// All combinations of axes, by their counts.
fn shapes() -> impl Iterator<Item = [usize; 4]> {
    (0..8).map(|bits: usize| {
        let n = |bit: usize, count| if bits & bit != 0 { count } else { 1 };
        [10, n(1, 5), n(2, 7), n(4, 12)]
    })
}

#[test]
fn the_spline_finds_all_slopes_of_a_smooth_spring_and_shepard_errs_no_more_than_linear() {
    let grid = Spring::grid([12, 9, 9, 32]);
    let tables = ALL.map(|interpolation| FlankTable::new(&grid, interpolation).unwrap());
    let (mut errors, mut squares) = ([[0.0_f64; 4]; 3], [0.0; 3]);
    let mut size = [0.0_f64; 4];
    for n in 0..3000 {
        let q = point(n, 1.0);
        let exact = Spring::potential(&q).gradient;
        for (t, table) in tables.iter().enumerate() {
            let found = table.evaluate(&q, false);
            if found.out_of_range {
                continue;
            }
            for i in 0..4 {
                errors[t][i] = errors[t][i].max((found.gradient[i] - exact[i]).abs());
                size[i] = size[i].max(exact[i].abs());
            }
            squares[t] += (found.gradient[0] - exact[0]).powi(2);
        }
    }
    let [linear, spline, _] = errors;
    for i in 0..4 {
        assert!(spline[i] < 1e-3 * size[i], "{i}: {spline:?} of {size:?}");
        assert!(spline[i] < 0.1 * linear[i], "{i}: {spline:?} {linear:?}");
    }
    assert!(squares[2] < squares[0], "{squares:?}");
}

#[test]
fn nodes_too_far_apart_are_refused_with_the_axis_along_which_the_spline_falls() {
    // Notches at one node of an axis, beside which the coefficient falls 1.73 times as deep.
    let shape = [7, 9, 12];
    for (axis, notches, level) in [
        (Axis::CenterDistance, [1.0, 0.0, 0.0], 1.1),
        (Axis::Misalignment, [0.0, 1.0, 0.0], 1.1),
        (Axis::MeshPosition, [0.0, 0.0, 1.0], 1.1),
        (Axis::Misalignment, [0.2, 1.0, 0.2], 1.5),
        // Together alone: closer nodes of either help, those of the centre distance first.
        (Axis::CenterDistance, [1.0, 1.0, 0.0], 3.1),
    ] {
        let mut grid = Spring::grid([10, shape[0], shape[1], shape[2]]);
        let ends = (grid.top_load_approach.iter_mut()).zip(&grid.no_load_approach);
        for (k, (top, low)) in ends.enumerate() {
            let [_, m, p] = shape;
            let place = [k / (m * p), k / p % m, k % p];
            let depth = (0..3).map(|i| match place[i] == shape[i] / 2 {
                true => notches[i],
                false => 0.0,
            });
            *top = low + 1e-6 * (level - depth.sum::<f64>());
        }
        let refused = FlankTable::new(&grid, Interpolation::Spline);
        match refused.map(|_| ()) {
            Err(TableError::TooCoarse { least_m, axis: of }) => {
                assert_eq!(of, axis, "{notches:?}");
                assert!(least_m < 0.0);
            }
            other => panic!("{notches:?}: {other:?}"),
        }
    }
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
            // Far enough above zero to be so beyond the ends, too.
            100.0 * (8.0 + x.powi(3) * y - y * y),
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn force_never_falls_over_displacement_whatever_the_samples(steps in prop::collection::vec(0.0..1.0_f64, 8 * 4 * 4 * 6)) {
        // Steep, flat and jagged: cubes of random steps, independent from node to node.
        let mut grid = Spring::grid([8, 4, 4, 6]);
        for (block, forces) in grid.loa_force.chunks_mut(8 * 6).enumerate() {
            for p in 0..6 {
                let mut sum = 0.0;
                for u in 0..8 {
                    sum += steps[(block * 8 + u) * 6 + p].powi(6);
                    forces[u * 6 + p] = 100.0 * sum + 1e-9;
                }
            }
        }
        for interpolation in [Interpolation::Linear, Interpolation::Spline] {
            let table = FlankTable::new(&grid, interpolation).unwrap();
            for n in 0..30 {
                let mut q = point(n, 1.8);
                let mut below = 0.0;
                for k in 0..200 {
                    q.delta = -5e-6 + 0.15e-6 * f64::from(k);
                    let w = table.evaluate(&q, false);
                    prop_assert!(w.gradient[0] >= below - 1e-9, "{interpolation:?} {q:?}");
                    prop_assert!(w.hessian[0][0] >= -1e-3);
                    below = w.gradient[0];
                }
            }
        }
    }
}
