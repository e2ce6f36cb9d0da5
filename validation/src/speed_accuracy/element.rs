//! Ratios of the time of interpolants, alone and in the element, and of their errors.

use super::interpolants::{INTERPOLATIONS, force_error};
use super::{Posed, Sampled, Spread, everything, points, thinned};
use crate::data::Data;
use crate::timing::{Candidate, medians};
use crate::{Context, Result};
use gearmesh::element::Parameters;
use gearmesh::table::FlankTable;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let sampled = Sampled::of(context)?;
    let setup = &sampled.setup;
    let grid = thinned(&sampled.grid, [1, 1, 1, 2]);
    let table = setup.table(&grid)?;
    let (operating, nominal) = (&setup.pair.operating, setup.nominal_force());
    let spread = Spread {
        center_distance: 0.8 * operating.center_distance_offset[1],
        tilt: 0.5 * operating.misalignment[1],
        normal_force: [0.1 * nominal, 1.6 * nominal],
    };
    let exact = setup.exact(&setup.ranges(4), points(context))?;
    let exact_1d = setup.exact(&setup.ranges(1), points(context))?;
    let line = thinned(&grid, [1, 0, 0, 0]);
    let (mut elements, mut kernels) = (vec![], vec![]);
    for (interpolation, _) in INTERPOLATIONS {
        let parameters = Parameters {
            interpolation,
            ..everything(setup)
        };
        elements.push(Posed::new(setup, &parameters, &table, &spread)?);
        let [four, one] = [&grid, &line].map(|grid| FlankTable::new(grid, interpolation));
        kernels.push((four?, one?));
    }
    // All in the same turns. Each interpolation: the element's wrench, the 4-D and the 1-D kernel without and with
    // gradient.
    let mut candidates = vec![];
    for (
        Posed {
            element,
            latch,
            poses,
        },
        (four, one),
    ) in elements.iter().zip(&kernels)
    {
        candidates.push(Candidate::over(poses, move |x| element.evaluate(latch, x)));
        for (table, points) in [(four, &exact), (one, &exact_1d)] {
            for hessian in [false, true] {
                let evaluate = move |x: &crate::setup::Exact| table.evaluate(&x.query, hessian);
                candidates.push(Candidate::over(points, evaluate));
            }
        }
    }
    let times = medians(&mut candidates);
    drop(candidates);
    let [linear, spline, shepard] = [0, 1, 2].map(|i| &times[5 * i..][..5]);
    let errors: Vec<_> = kernels
        .iter()
        .map(|k| force_error(&k.0, &exact, nominal).rms)
        .collect();
    let (value, gradient, gradient_1d) = (spline[1], spline[2], spline[4]);
    let rows = [
        format!(
            "spline over linear kernel, 4-D with gradient | {:.2}",
            gradient / linear[2]
        ),
        format!(
            "spline over linear kernel, 4-D value | {:.2}",
            value / linear[1]
        ),
        format!(
            "spline over linear whole element, wrench | {:.2}",
            spline[0] / linear[0]
        ),
        format!(
            "rms error, spline over linear, same 4-D grid | {:.3}",
            errors[1] / errors[0]
        ),
        format!(
            "1-D over 4-D spline kernel, with gradient | {:.3}",
            gradient_1d / gradient
        ),
        format!(
            "shepard over spline kernel, 4-D with gradient | {:.1}",
            shepard[2] / gradient
        ),
        format!(
            "rms error, shepard over spline, same 4-D grid | {:.2}",
            errors[2] / errors[1]
        ),
        format!("spline kernel, 4-D value, ns | {value:.0}"),
        format!("spline kernel, 4-D with gradient, ns | {gradient:.0}"),
    ];
    data.table("ratios", "quantity | measured", &rows)
}
