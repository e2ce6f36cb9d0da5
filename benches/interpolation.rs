//! Time of one evaluation of a table: every interpolant, one to four dimensions, value with gradient
//! (and tangent stiffness) and with all second derivatives.
//!
//! Points are drawn beforehand and walked through in turn, so that each evaluation meets another cell, as
//! it does under random excitation; neighbouring points (a simulation) are cheaper.

use criterion::{Criterion, criterion_group, criterion_main};
use gearmesh::table::samples::Spring;
use gearmesh::table::{FlankTable, Interpolation, Query};
use std::hint::black_box;

/// A fixed sequence of operating points inside the range.
fn points() -> Vec<Query> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = || {
        // xorshift64: Marsaglia, Xorshift RNGs (2003).
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..1024)
        .map(|_| {
            let (c, m) = (200e-6 * next() - 100e-6, 6e-3 * next() - 3e-3);
            Query {
                delta: 1e-6 * (0.7 + 6.0 * next()) + 3e-3 * c - 0.2 * m * m,
                center_distance_offset: c,
                misalignment: m,
                mesh_position: next(),
            }
        })
        .collect()
}

fn evaluations(criterion: &mut Criterion) {
    let points = points();
    let shapes = [
        ("1d", [10, 1, 1, 1]),
        ("2d", [10, 1, 1, 32]),
        ("3d", [10, 1, 9, 32]),
        ("4d", [10, 9, 9, 32]),
    ];
    for (interpolation, name) in [
        (Interpolation::Linear, "linear"),
        (Interpolation::Spline, "spline"),
    ] {
        for (dimensions, counts) in shapes {
            let mut grid = Spring::grid(counts);
            grid.moment = None;
            let table = FlankTable::new(&grid, interpolation).expect("a legal grid");
            for (what, hessian) in [("gradient", false), ("hessian", true)] {
                let mut i = 0;
                criterion.bench_function(&format!("{name}/{dimensions}/{what}"), |b| {
                    b.iter(|| {
                        i = (i + 1) % 1024;
                        black_box(table.evaluate(black_box(&points[i]), hessian))
                    });
                });
            }
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(500));
    targets = evaluations
}
criterion_main!(benches);
