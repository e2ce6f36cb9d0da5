//! Derivatives against finite differences; the width of the registers changes no bit.

use super::*;

const EVERY: [usize; 4] = [0, 1, 2, 3];

/// Fourth-order central difference of `f` at `q` by coordinate `i` with the step `h`.
fn difference<const K: usize>(
    q: &Query,
    i: usize,
    h: f64,
    f: impl Fn(&Query) -> [f64; K],
) -> [f64; K] {
    let at = |k: f64| f(&moved(q, i, k * h));
    let (near, far) = ([at(1.0), at(-1.0)], [at(2.0), at(-2.0)]);
    std::array::from_fn(|k| {
        (8.0 * (near[0][k] - near[1][k]) - (far[0][k] - far[1][k])) / (12.0 * h)
    })
}

/// Largest error of the derivatives `exact` of `f` by the `coordinates`, with points as far out as `spread`, relative to the
/// largest of each derivative.
fn worst<const K: usize>(
    [spread, step]: [f64; 2],
    coordinates: &[usize],
    f: impl Fn(&Query) -> [f64; K],
    exact: impl Fn(&Query, usize) -> [f64; K],
) -> f64 {
    let mut worst: f64 = 0.0;
    for &i in coordinates {
        let (mut size, mut error) = ([1e-12_f64; K], [0.0_f64; K]);
        // From 1: point 0 is the very middle, a node, where the linear interpolant has a kink.
        for q in (1..300).map(|n| point(n, spread)) {
            let (found, exact) = (difference(&q, i, step * SCALE[i], &f), exact(&q, i));
            for k in 0..K {
                size[k] = size[k].max(exact[k].abs());
                error[k] = error[k].max((found[k] - exact[k]).abs());
            }
        }
        worst = (0..K).map(|k| error[k] / size[k]).fold(worst, f64::max);
    }
    worst
}

/// Of the gradient of `table` against its values.
fn worst_gradient(table: &FlankTable, steps: [f64; 2], coordinates: &[usize]) -> f64 {
    let at = |q: &Query| table.evaluate(q, true);
    worst(
        steps,
        coordinates,
        |q| [at(q).value],
        |q, i| [at(q).gradient[i]],
    )
}

/// Of the second derivatives of `table` against its gradient.
fn worst_hessian(table: &FlankTable, steps: [f64; 2]) -> f64 {
    let at = |q: &Query| table.evaluate(q, true);
    let column = |q: &Query, i: usize| at(q).hessian.map(|row| row[i]);
    worst(steps, &EVERY, |q| at(q).gradient, column)
}

#[test]
fn gradient_and_second_derivatives_are_those_of_one_potential_in_every_dimension() {
    use Interpolation::{Linear, Shepard, Spline};
    // Farthest points, step and bounds; the linear force has no second derivative.
    for (interpolation, far, steps, bounds) in [
        (Linear, 2.5, [4e-6, 1e-5], [2e-7, f64::INFINITY]),
        (Spline, 2.5, [4e-6, 1e-5], [2e-7, 2e-4]),
        (Shepard, 1.5, [1e-5, 1e-5], [1e-8, 1e-6]),
    ] {
        for (shape, with_moment) in shapes().flat_map(|shape| [(shape, false), (shape, true)]) {
            let mut grid = Spring::grid(shape);
            grid.moment = grid.moment.filter(|_| with_moment);
            let table = FlankTable::new(&grid, interpolation).unwrap();
            // Where shuttling has a table of its own, W's derivative by M is none of its business.
            let own_moment = with_moment && shape[2] == 1;
            let coordinates = if own_moment { &[0, 1, 3][..] } else { &EVERY };
            for spread in [1.0, far] {
                let first = worst_gradient(&table, [spread, steps[0]], coordinates);
                let second = match interpolation {
                    Linear => 0.0,
                    _ => worst_hessian(&table, [spread, steps[1]]),
                };
                assert!(
                    first < bounds[0] && second < bounds[1],
                    "{interpolation:?} {shape:?} {with_moment} {spread}: {first} {second}"
                );
            }
        }
    }
}

#[test]
fn constant_load_has_consistent_second_derivatives_and_passes_through_its_load() {
    for shape in shapes() {
        let grid = Spring::grid(shape);
        let table = FlankTable::constant_load(&grid, Interpolation::Spline, 60.0).unwrap();
        let worst = worst_hessian(&table, [2.0, 1e-5]);
        assert!(worst < 2e-5, "{shape:?}: {worst}");
        let variable = FlankTable::new(&grid, Interpolation::Spline).unwrap();
        let [nc, nm, _, np] = grid.axes.lengths();
        for n in 0..nc * nm * np {
            let node = grid.query([n / np / nm, n / np % nm, 0, n % np]);
            let at = |delta| Query { delta, ..node };
            let delta = bisection([-1e-5, 2e-5], 60, |delta| {
                variable.evaluate(&at(delta), false).gradient[0] < 60.0
            });
            let force = table.evaluate(&at(delta), false).gradient[0];
            assert!((force - 60.0).abs() < 1e-5, "{force} N at {node:?}");
        }
    }
}

#[test]
fn next_to_a_node_shepard_derivatives_are_those_of_differences_too() {
    let grid = Spring::grid([10, 5, 7, 12]);
    let table = FlankTable::new(&grid, Interpolation::Shepard).unwrap();
    // Of the grid.
    let spacing = [1e-6, 50e-6, 1e-3, 1.0 / 12.0];
    for n in 0..40 {
        // Nodes inside the range: at its ends the onset goes on with another curvature.
        let node = grid.query([1 + n % 3, 1 + n % 5, n % 9, n % 12]);
        for far in [0.0, 1e-5, 1e-4, 1e-3] {
            let q = moved(&node, n % 4, far * spacing[n % 4]);
            let exact = table.evaluate(&q, true);
            for i in 0..4 {
                let gradient = |q: &Query| table.evaluate(q, true).gradient;
                let found = difference(&q, i, 1e-5 * spacing[i], gradient);
                for (k, row) in exact.hessian.iter().enumerate() {
                    // The whole force over one spacing, in units of both coordinates.
                    let scale = spacing[0] / (spacing[k] * spacing[i]) * exact.gradient[0];
                    let error = (found[k] - row[i]).abs() / scale;
                    assert!(error < 1e-6, "node {n}, {far} off, row {k} by {i}: {error}");
                }
            }
        }
    }
}

/// Everything in `w`, as bits; of a NaN only that it is one.
fn bits(w: &Potential) -> Vec<u64> {
    let all = [w.value].into_iter().chain(w.gradient);
    all.chain(w.hessian.into_iter().flatten())
        .map(|x| if x.is_nan() { f64::NAN } else { x }.to_bits())
        .chain([u64::from(w.out_of_range)])
        .collect()
}

#[test]
fn results_depend_neither_on_the_width_of_the_registers_nor_on_whether_second_derivatives_are_asked_for()
 {
    for shape in shapes() {
        for interpolation in ALL {
            let grid = Spring::grid(shape);
            for constant_load in [false, true] {
                let make = || match constant_load {
                    true => FlankTable::constant_load(&grid, interpolation, 60.0).unwrap(),
                    false => FlankTable::new(&grid, interpolation).unwrap(),
                };
                let (widest, mut common) = (make(), make());
                common.lanes = Lanes::COMMON;
                for n in 0..200 {
                    // Inside, outside, and at an end of a coordinate.
                    let mut q = point(n, if n % 2 == 0 { 1.0 } else { 2.5 });
                    if n % 5 == 0 {
                        q.misalignment = 3e-3;
                    }
                    if n % 50 == 1 {
                        q = moved(&q, n / 50, f64::NAN);
                    }
                    let [values, all] = [false, true].map(|hessian| {
                        let [a, b] = [&widest, &common].map(|t| bits(&t.evaluate(&q, hessian)));
                        assert_eq!(a, b, "{shape:?} {interpolation:?} {q:?}");
                        a
                    });
                    // W, its gradient and the tangent stiffness.
                    assert_eq!(values[..6], all[..6], "{shape:?} {interpolation:?} {q:?}");
                }
            }
        }
    }
}
