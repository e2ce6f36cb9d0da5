//! Two lanes or four: the same numbers.

use super::{moved, point, shapes};
use crate::table::samples::Spring;
use crate::table::{FlankTable, Interpolation, Potential};

/// Everything in `w`, as bits; of a NaN only that it is one.
fn bits(w: &Potential) -> Vec<u64> {
    let all = [w.value].into_iter().chain(w.gradient);
    all.chain(w.hessian.into_iter().flatten())
        .map(|x| if x.is_nan() { f64::NAN } else { x }.to_bits())
        .chain([u64::from(w.out_of_range)])
        .collect()
}

#[test]
fn results_do_not_depend_on_the_width_of_the_registers() {
    for shape in shapes() {
        for interpolation in [
            Interpolation::Linear,
            Interpolation::Spline,
            Interpolation::Shepard,
        ] {
            let grid = Spring::grid(shape);
            for constant_load in [false, true] {
                let make = || {
                    let table = if constant_load {
                        FlankTable::constant_load(&grid, interpolation, 60.0)
                    } else {
                        FlankTable::new(&grid, interpolation)
                    };
                    table.unwrap()
                };
                let (widest, common) = (make(), make().with_common_registers());
                for n in 0..200 {
                    // Inside, outside, and at an end of a coordinate.
                    let mut q = point(n, if n % 2 == 0 { 1.0 } else { 2.5 });
                    if n % 5 == 0 {
                        q.misalignment = 3e-3;
                    }
                    if n % 50 == 1 {
                        q = moved(&q, n / 50, f64::NAN);
                    }
                    for hessian in [false, true] {
                        let [a, b] = [&widest, &common].map(|t| t.evaluate(&q, hessian));
                        assert_eq!(bits(&a), bits(&b), "{shape:?} {interpolation:?} {q:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn values_do_not_depend_on_whether_second_derivatives_are_asked_for() {
    for shape in shapes() {
        for interpolation in [Interpolation::Linear, Interpolation::Spline] {
            let table = FlankTable::new(&Spring::grid(shape), interpolation).unwrap();
            for n in 0..200 {
                let q = point(n, if n % 2 == 0 { 1.0 } else { 2.5 });
                let [a, b] = [false, true].map(|hessian| table.evaluate(&q, hessian));
                assert_eq!(a.value.to_bits(), b.value.to_bits());
                assert_eq!(a.gradient.map(f64::to_bits), b.gradient.map(f64::to_bits));
                assert_eq!(a.hessian[0][0].to_bits(), b.hessian[0][0].to_bits());
            }
        }
    }
}
