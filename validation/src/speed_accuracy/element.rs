//! From poses to wrenches: the element on every interpolant, against a spring, and the ratios of one run.

use super::interpolants::{INTERPOLATIONS, force_error};
use super::{Posed, Sampled, Spread, direction, everything, points, thinned};
use crate::page::{Page, fixed};
use crate::timing::{Candidate, medians};
use crate::{Context, Result, row};
use gearmesh::element::{Formulation, Jacobian, Parameters, StiffnessModel};
use gearmesh::table::{FlankTable, Interpolation};
use std::hint::black_box;

pub fn report(context: &Context, page: &mut Page) -> Result<()> {
    let sampled = Sampled::of(context)?;
    let setup = &sampled.setup;
    let grid = sampled.half();
    let table = setup.table(&grid)?;
    let (operating, nominal) = (&setup.pair.operating, setup.nominal_force());
    let spread = Spread {
        center_distance: 0.8 * operating.center_distance_offset[1],
        tilt: 0.5 * operating.misalignment[1],
        normal_force: [0.1 * nominal, 1.6 * nominal],
    };
    let mut elements = vec![];
    for formulation in [Formulation::Conjugate, Formulation::Paper] {
        let all = Parameters { formulation, ..everything(setup) };
        let mut kinds = INTERPOLATIONS
            .map(|(interpolation, name)| (format!("4-D {name}"), Parameters { interpolation, ..all }))
            .to_vec();
        let spring = Parameters { stiffness_model: StiffnessModel::Constant, ..all };
        kinds.push(("constant stiffness".into(), spring));
        for (name, parameters) in kinds {
            let name = format!("{formulation:?}, {name}").to_lowercase();
            elements.push((name, Posed::new(setup, &parameters, &table, &spread)?));
        }
    }
    // A spring along one coordinate, as a one-dimensional model has it.
    let angle = |x: &gearmesh::element::Inputs| x.gears.each_ref().map(|gear| [gear.r[(1, 0)], gear.w.z]);
    let angles: Vec<[[f64; 2]; 2]> = elements[0].1.poses.iter().map(angle).collect();
    // The kernel alone, in the same turns.
    let exact = setup.exact(&setup.ranges(4), points(context))?;
    let exact_1d = setup.exact(&setup.ranges(1), points(context))?;
    let line = thinned(&grid, [1, 0, 0, 0]);
    let kernels: [[FlankTable; 2]; 3] = [
        [FlankTable::new(&grid, Interpolation::Linear)?, FlankTable::new(&line, Interpolation::Linear)?],
        [FlankTable::new(&grid, Interpolation::Spline)?, FlankTable::new(&line, Interpolation::Spline)?],
        [FlankTable::new(&grid, Interpolation::Shepard)?, FlankTable::new(&line, Interpolation::Shepard)?],
    ];
    let common = FlankTable::new(&grid, Interpolation::Spline)?.with_common_registers();

    let along = direction();
    let mut candidates = vec![];
    for (_, Posed { element, latch, poses }) in &elements {
        let mut jacobian = Jacobian::zeros();
        candidates.push(Candidate::over(poses, move |x| element.evaluate(latch, x)));
        candidates.push(Candidate::over(poses, move |x| element.directional_derivative(latch, x, &along)));
        candidates.push(Candidate::over(poses, move |x| element.jacobian(latch, x, &mut jacobian)));
    }
    candidates.push(Candidate::over(&angles, spring));
    let kernel_start = candidates.len();
    let tables = kernels.iter().flat_map(|[four, one]| [(four, &exact), (one, &exact_1d)]).chain([(&common, &exact)]);
    for (table, points) in tables {
        for hessian in [false, true] {
            candidates.push(Candidate::over(points, move |x| table.evaluate(&x.query, hessian)));
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);

    let mut rows = vec![];
    for ((name, _), t) in elements.iter().zip(times.chunks_exact(3)) {
        rows.push(row![name, fixed(t[0], 0), fixed(t[1], 0), fixed(t[2], 0)]);
    }
    let spring = fixed(times[kernel_start - 1], 1);
    rows.push(row!["spring and damper over two angles, for comparison", spring, "–", "–"]);
    page.table("elements", &["element", "wrench, ns", "directional derivative, ns", "Jacobian, ns"], &rows)?;

    let errors = kernels.each_ref().map(|k| force_error(&k[0], &exact, nominal)[0]);
    // Interpolation by dimension (4-D, 1-D) by with gradient or not; the last is the spline with two-lane registers.
    let kernel = |i: usize, d: usize, h: usize| times[kernel_start + 4 * i + 2 * d + h];
    let [linear, spline, shepard] = [0, 1, 2];
    let (wrench, value, gradient) = (times[3 * spline], kernel(spline, 0, 0), kernel(spline, 0, 1));
    let floor = floor();
    let rows = [
        row![
            "spline over linear kernel, 4-D with gradient, same grid",
            fixed(gradient / kernel(linear, 0, 1), 2),
            "≤ 5.5"
        ],
        row!["spline over linear kernel, 4-D value", fixed(value / kernel(linear, 0, 0), 2), "–"],
        row!["spline over linear whole element, wrench", fixed(wrench / times[3 * linear], 2), "≤ 2.5"],
        row![
            "spline over linear whole element, directional derivative",
            fixed(times[3 * spline + 1] / times[3 * linear + 1], 2),
            "≤ 2.5"
        ],
        row!["rms error, spline over linear, same 4-D grid", fixed(errors[spline] / errors[linear], 3), "≤ 0.2"],
        row!["1-D over 4-D spline kernel, with gradient", fixed(kernel(spline, 1, 1) / gradient, 3), "≤ 0.1"],
        row!["1-D over 4-D spline kernel, value", fixed(kernel(spline, 1, 0) / value, 3), "≤ 0.1"],
        row!["whole element on the 4-D spline, wrench, ns", fixed(wrench, 0), "goal 250"],
        row![
            "whole element on the 4-D spline, wrench and the table's second derivatives, ns",
            fixed(wrench + gradient - value, 0),
            "goal 350"
        ],
        row!["shepard over spline kernel, 4-D with gradient", fixed(kernel(shepard, 0, 1) / gradient, 1), "≥ 5"],
        row!["rms error, shepard over spline, same 4-D grid", fixed(errors[shepard] / errors[spline], 2), "≥ 1"],
        row!["spline kernel, 4-D value, ns", fixed(value, 0), "–"],
        row!["the same with two-lane registers, ns", fixed(kernel(3, 0, 0), 0), "–"],
        row!["spline kernel, 4-D with gradient, ns", fixed(gradient, 0), "–"],
        row!["the same with two-lane registers, ns", fixed(kernel(3, 0, 1), 0), "–"],
        row!["floor: the arithmetic of a 4-D value alone, ns", fixed(floor, 0), "–"],
        row!["spline kernel, 4-D value, over the floor", fixed(value / floor, 1), "–"],
        row!["whole element on the 4-D spline over the floor", fixed(wrench / floor, 1), "–"],
    ];
    page.table("ratios", &["quantity", "measured", "wanted"], &rows)
}

/// k x + c v along the line of action between two angles.
fn spring([[a, v], [b, w]]: &[[f64; 2]; 2]) -> [f64; 2] {
    let (k, c, r) = (4.35e8, 1e5, 38.2e-3);
    let force = (k * r * (a + b) + c * r * (v + w)).max(0.0);
    [-r * force; 2]
}

/// The least multiplications and additions of a 4-D spline evaluation, ns: every coefficient under one cell, 4 x 4 (centre
/// distance, misalignment) x 5 displacement rows x 4 positions, into each of the sums for potential, force and stiffness,
/// nothing else, from a block that stays in the nearest cache, with as many independent chains as the sums allow.
fn floor() -> f64 {
    const SUMS: usize = 3;
    let block: Vec<f64> = (0..4 * 4 * 5 * 4).map(|i| 1.0 + f64::from(i)).collect();
    let weights: [[f64; SUMS]; 5] = std::array::from_fn(|r| std::array::from_fn(|s| 0.1 + (r + s) as f64));
    let evaluation = |_: &()| {
        let (block, weights): (&[f64], _) = (black_box(&block), black_box(&weights));
        let mut sums = [[0.0_f64; 4]; SUMS];
        for rows in block.chunks_exact(20) {
            for (row, w) in rows.chunks_exact(4).zip(weights) {
                for s in 0..SUMS {
                    for k in 0..4 {
                        sums[s][k] += w[s] * row[k];
                    }
                }
            }
        }
        sums
    };
    medians(&mut [Candidate::over(&[(); 64], evaluation)])[0]
}
