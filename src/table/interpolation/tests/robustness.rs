//! Jagged samples, NaN, refusals.

use super::{moved, point};
use crate::table::samples::Spring;
use crate::table::{Axes, FlankGrid, FlankTable, Interpolation};
use proptest::prelude::*;

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

#[test]
fn a_nan_gives_no_panic() {
    let table = FlankTable::new(&Spring::grid([8, 4, 4, 6]), Interpolation::Spline).unwrap();
    for i in 0..4 {
        let _ = table.evaluate(&moved(&point(3, 1.0), i, f64::NAN), true);
    }
}

#[test]
fn samples_that_fall_or_have_the_wrong_shape_are_refused_by_name() {
    let refused = |change: fn(&mut FlankGrid)| {
        let mut grid = Spring::grid([8, 4, 4, 6]);
        change(&mut grid);
        FlankTable::new(&grid, Interpolation::Spline)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(|g| g.loa_force[6] = -1.0).contains("loa_force_n[6] = -1"));
    assert!(refused(|g| g.loa_force[6] = f64::NAN).contains("loa_force_n[6] = NaN"));
    assert!(
        refused(|g| g.axes = Axes {
            misalignment: vec![0.0, 0.0, 1.0, 2.0],
            ..g.axes.clone()
        })
        .contains("misalignment_rad[1] = 0")
    );
    assert!(refused(|g| g.axes.mesh_position.push(1.0)).contains("mesh_position"));
    assert!(
        refused(|g| g.axes.center_distance_offset = vec![0.0, 1e-6])
            .contains("center_distance_offset_m")
    );
    assert!(
        refused(|g| {
            g.moment.as_mut().unwrap().pop();
        })
        .contains("moment_nm")
    );
    assert!(refused(|g| g.top_load_approach[3] = -1.0).contains("top_load_approach_m[3] = -1"));
}
