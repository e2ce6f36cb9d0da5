//! Claims of the interpolants, against a spring with a known potential and finite differences.

mod accuracy;
mod continuity;
mod derivatives;

use super::*;

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
