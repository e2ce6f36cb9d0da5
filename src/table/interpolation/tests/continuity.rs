//! The onset, the cells' ends, the turn of the mesh cycle, and what lies beyond the ends of the axes.

use super::*;

#[test]
fn force_is_exactly_zero_up_to_the_onset_and_starts_without_a_kink() {
    for interpolation in ALL {
        let table = FlankTable::new(&Spring::grid([10, 5, 5, 16]), interpolation).unwrap();
        for n in 0..500 {
            let mut q = point(n, 1.5);
            q.delta = -1.0;
            assert_eq!(table.evaluate(&q, true).gradient, [0.0; 4]);
            let onset = bisection([-1e-4, 1e-4], 200, |delta| {
                let force = table.evaluate(&Query { delta, ..q }, false).gradient[0];
                force <= 0.0
            });
            if interpolation != Interpolation::Linear {
                q.delta = onset + 1e-10;
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
    let axes = &grid.axes;
    for (i, nodes) in [
        (1, &axes.center_distance_offset),
        (2, &axes.misalignment),
        (3, &axes.mesh_position),
    ] {
        let ends = usize::from(i != 3);
        for &node in &nodes[ends..nodes.len() - ends] {
            for n in 0..20 {
                let q = with(&point(n, 1.0), i, node);
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
    for interpolation in ALL {
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

/// In the middle of the range of [`Spring::grid`]; the top load is reached at 8 um (5 um at M = -3 mrad).
const INSIDE: Query = Query {
    delta: 3e-6,
    center_distance_offset: 0.0,
    misalignment: 0.0,
    mesh_position: 0.3,
};

/// Lower and upper end of the range in C and M.
const ENDS: [(usize, f64); 4] = [(1, -100e-6), (1, 100e-6), (2, -3e-3), (2, 3e-3)];

#[test]
fn leaving_the_range_of_any_axis_is_said_and_staying_within_it_is_not() {
    let grid = Spring::grid([10, 5, 7, 16]);
    let secant = |i| FlankTable::constant_load(&grid, i, 60.0).unwrap();
    let tables = ALL.map(|i| FlankTable::new(&grid, i).unwrap());
    let is_outside = |table: &FlankTable, i: usize, by: f64| {
        let w = table.evaluate(&moved(&INSIDE, i, by), true);
        w.out_of_range
    };
    for table in &tables {
        assert!(!is_outside(table, 0, 0.0) && is_outside(table, 0, 6e-6));
    }
    for table in tables.iter().chain(&ALL.map(secant)) {
        for (i, end) in ENDS {
            let [within, beyond, far] =
                [0.999, 1.001, 100.0].map(|share| is_outside(table, i, share * end));
            assert!(!within && beyond && far, "axis {i}, {end}");
        }
        assert!(!is_outside(table, 3, 1e4));
    }
}

#[test]
fn beyond_top_load_the_force_goes_on_linearly_by_shepards_method_as_by_the_spline() {
    let grid = Spring::grid([10, 9, 9, 16]);
    let forces = ALL.map(|interpolation| {
        let table = FlankTable::new(&grid, interpolation).unwrap();
        let at = |d: f64| table.evaluate(&moved(&INSIDE, 0, d), false).gradient[0];
        let forces = [14e-6, 24e-6, 34e-6].map(at);
        let second = forces[0] - 2.0 * forces[1] + forces[2];
        assert!(
            second.abs() < 1e-9 * forces[2],
            "{interpolation:?}: {second:e}"
        );
        forces[2]
    });
    let of = |method| forces[ALL.iter().position(|found| *found == method).unwrap()];
    let [spline, shepard] = [Interpolation::Spline, Interpolation::Shepard].map(of);
    assert!((shepard / spline - 1.0).abs() < 2e-3, "{shepard} {spline}");
}

/// Samples with plateaus: force over the displacement that rises by leaps, another one at each end of C and M, and
/// next to no slope between.
fn plateaus(counts: [usize; 4]) -> FlankGrid {
    let mut grid = Spring::grid(counts);
    let [nc, nm, nu, np] = grid.axes.lengths();
    for (k, force) in grid.loa_force.iter_mut().enumerate() {
        let (p, u) = (k % np, k / np % nu);
        let (m, c) = (k / np / nu % nm, k / np / nu / nm);
        let edge = c == 0 || m == 0 || c + 1 == nc || m + 1 == nm;
        let leap = 2 + (p + 3 * m + 5 * c) % (nu - 3);
        let flat = edge && u >= leap && u < leap + 3;
        let step = |u: usize| (u + 1) as f64 / nu as f64;
        *force = 300.0 * if flat { step(leap) } else { step(u) };
    }
    grid
}

#[test]
fn force_and_side_terms_have_continuous_slopes_across_the_ends_whatever_the_samples() {
    for grid in [Spring::grid([10, 9, 9, 16]), plateaus([10, 5, 7, 8])] {
        for interpolation in ALL {
            let table = FlankTable::new(&grid, interpolation).unwrap();
            let mut size = [0.0_f64; 4];
            let mut jump = [0.0_f64; 4];
            for n in 0..200 {
                let q = point(n, 0.9);
                for (i, end) in ENDS {
                    let edge = with(&q, i, end);
                    let side = |by: f64| {
                        let w = table.evaluate(&moved(&edge, i, by * end), true);
                        // dF/dC or dF/dM, and the derivatives of W that are loads.
                        [
                            w.hessian[0][i] * SCALE[i],
                            w.gradient[0],
                            w.gradient[1] * SCALE[1],
                            w.gradient[2] * SCALE[2],
                        ]
                    };
                    let (inside, outside) = (side(-1e-8), side(1e-8));
                    for k in 0..4 {
                        size[k] = size[k].max(inside[k].abs());
                        jump[k] = jump[k].max((inside[k] - outside[k]).abs());
                    }
                }
            }
            for k in 0..4 {
                let named = format!("{interpolation:?} {k}: {jump:?} of {size:?}");
                assert!(jump[k] < 1e-4 * size[k], "{named}");
            }
        }
    }
}

/// Springs side by side along a face, W = int k (delta + M z - r z²)₊² / 2 dz: load on a part of a crowned face (Winkler's
/// foundation).
struct Foundation;

impl Foundation {
    const HALF_FACE: f64 = 10e-3;
    const LARGEST_TILT: f64 = 1e-3;
    const SLICES: i32 = 400;

    /// Force and moment.
    fn loads(delta: f64, m: f64) -> [f64; 2] {
        let width = 2.0 * Self::HALF_FACE / f64::from(Self::SLICES);
        (0..Self::SLICES).fold([0.0; 2], |[force, moment], i| {
            let z = (f64::from(i) + 0.5) * width - Self::HALF_FACE;
            let load = 1e10 * (delta + m * z - 0.02 * z * z).max(0.0) * width;
            [force + load, moment + load * z]
        })
    }

    fn approach(force: f64, m: f64) -> f64 {
        bisection([-1e-4, 1e-4], 60, |delta| Self::loads(delta, m)[0] < force)
    }

    fn grid(top: f64) -> FlankGrid {
        let mut grid = Spring::grid([12, 1, 17, 1]);
        let tilts = (0..17).map(|i| Self::LARGEST_TILT * (f64::from(i) / 8.0 - 1.0));
        grid.axes.misalignment = tilts.collect();
        grid.loa_force.clear();
        for (i, &m) in grid.axes.misalignment.iter().enumerate() {
            let [low, high] = [1e-6 * top, top].map(|force| Self::approach(force, m));
            grid.no_load_approach[i] = low;
            grid.top_load_approach[i] = high;
            let approaches =
                (grid.axes.displacement_fraction.iter()).map(|u| low + u * (high - low));
            grid.loa_force
                .extend(approaches.map(|delta| Self::loads(delta, m)[0]));
        }
        grid.moment = None;
        grid
    }
}

#[test]
fn beyond_the_misalignments_the_moment_under_a_force_follows_a_face_that_bears_in_part() {
    let top = 500.0;
    let table = FlankTable::new(&Foundation::grid(top), Interpolation::Spline).unwrap();
    for force in [0.02, 0.1, 0.4, 1.0].map(|part| part * top) {
        for side in [-1.0, 1.0] {
            let mut last = None;
            for part in [0.9999, 1.0001, 1.1, 1.2, 1.5, 3.0] {
                let m = side * part * Foundation::LARGEST_TILT;
                let pose = Query::from([0.0, 0.0, m, 0.0]);
                let delta = table.approach_at(force, &pose);
                let found = table.evaluate(&Query { delta, ..pose }, false).gradient[2];
                let exact = Foundation::loads(Foundation::approach(force, m), m)[1];
                let largest = force * Foundation::HALF_FACE;
                let named = format!("{force} N, {part}: {found} for {exact} of {largest} N m");
                // Farther out it is at the end of the face, sooner than the springs.
                let allowed = if part > 2.0 { 0.2 } else { 0.1 };
                assert!((found - exact).abs() < allowed * largest, "{named}");
                assert!(found.abs() < 1.05 * largest, "{named}");
                if part == 1.0001 {
                    let last: f64 = last.unwrap_or(f64::NAN);
                    assert!((found - last).abs() < 1e-3 * largest, "{named}");
                }
                last = Some(found);
            }
        }
    }
}

#[test]
fn a_secant_stays_positive_however_far_the_axes_are_left() {
    let mut grid = Spring::grid([10, 5, 7, 8]);
    // Softer towards one corner: a linear continuation of STE would pass through zero.
    let np = grid.axes.mesh_position.len();
    for (k, top) in grid.top_load_approach.iter_mut().enumerate() {
        let (m, c) = (k / np % 7, k / np / 7);
        grid.no_load_approach[k] += 2e-6;
        *top = grid.no_load_approach[k] + 1e-6 * (1.0 + 2.0 * (m + c) as f64);
    }
    let table = FlankTable::constant_load(&grid, Interpolation::Spline, 60.0).unwrap();
    for n in 0..2000 {
        let q = Query {
            delta: 1e-3,
            ..point(n, 20.0)
        };
        let w = table.evaluate(&q, false);
        assert!(w.hessian[0][0] > 0.0 && w.gradient[0] > 0.0, "{q:?} {w:?}");
    }
}
