//! From poses to wrenches: the element on every interpolant, against a spring, and the ratios of one run.

use super::interpolants::{INTERPOLATIONS, force_error};
use super::{Posed, Sampled, Spread, direction, everything, points, thinned};
use crate::data::{Data, fixed};
use crate::timing::{Candidate, medians};
use crate::{Context, Result, row};
use gearmesh::element::{Formulation, Jacobian, Parameters, StiffnessModel};
use gearmesh::table::{FlankTable, Interpolation};

pub fn report(context: &Context, data: &Data) -> Result<()> {
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
    let tables = kernels.iter().flat_map(|[four, one]| [(four, &exact), (one, &exact_1d)]);
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
    rows.push(row!["spring and damper over two angles, for comparison", spring, "", ""]);
    data.table("elements", &["element", "wrench, ns", "directional derivative, ns", "Jacobian, ns"], &rows)?;

    let errors = kernels.each_ref().map(|k| force_error(&k[0], &exact, nominal)[0]);
    // Interpolation by dimension (4-D, 1-D) by with gradient or not.
    let kernel = |i: usize, d: usize, h: usize| times[kernel_start + 4 * i + 2 * d + h];
    let [linear, spline, shepard] = [0, 1, 2];
    let (wrench, value, gradient) = (times[3 * spline], kernel(spline, 0, 0), kernel(spline, 0, 1));
    let rows = [
        row!["spline over linear kernel, 4-D with gradient", fixed(gradient / kernel(linear, 0, 1), 2)],
        row!["spline over linear kernel, 4-D value", fixed(value / kernel(linear, 0, 0), 2)],
        row!["spline over linear whole element, wrench", fixed(wrench / times[3 * linear], 2)],
        row!["rms error, spline over linear, same 4-D grid", fixed(errors[spline] / errors[linear], 3)],
        row!["1-D over 4-D spline kernel, with gradient", fixed(kernel(spline, 1, 1) / gradient, 3)],
        row!["shepard over spline kernel, 4-D with gradient", fixed(kernel(shepard, 0, 1) / gradient, 1)],
        row!["rms error, shepard over spline, same 4-D grid", fixed(errors[shepard] / errors[spline], 2)],
        row!["spline kernel, 4-D value, ns", fixed(value, 0)],
        row!["spline kernel, 4-D with gradient, ns", fixed(gradient, 0)],
    ];
    data.table("ratios", &["quantity", "measured"], &rows)
}

/// k x + c v along the line of action between two angles.
fn spring([[a, v], [b, w]]: &[[f64; 2]; 2]) -> [f64; 2] {
    let (k, c, r) = (4.35e8, 1e5, 38.2e-3);
    let force = (k * r * (a + b) + c * r * (v + w)).max(0.0);
    [-r * force; 2]
}
