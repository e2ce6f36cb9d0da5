//! From poses to wrenches: the element on every interpolant, against a spring, and the ratios of one run.

use crate::document::{Document, Error};
use crate::interpolants::{INTERPOLATIONS, force_error};
use crate::poses::{self, Spread};
use crate::setting::{Setting, thinned};
use crate::timing::{Candidate, medians};
use gearmesh::element::{
    Element, Formulation, InputsChange, Jacobian, LoadedFlank, MotionChange, Parameters,
    StiffnessModel,
};
use gearmesh::table::{FlankGrid, FlankTable, Interpolation, Table};
use nalgebra::Vector3;
use std::hint::black_box;
use std::sync::Arc;

/// Poses per element.
const POSES: usize = 256;

/// Turns, small translations and velocities of both gears: a direction that touches every input.
pub fn direction() -> InputsChange {
    let change = |s: f64| MotionChange {
        p: Vector3::new(1.0, -0.5, 0.3) * s,
        rotation: Vector3::new(0.2, 0.4, 10.0) * s,
        v: Vector3::new(0.1, 0.2, 0.3),
        w: Vector3::new(0.3, 0.2, 0.1),
    };
    InputsChange {
        gears: [change(1.0), change(-0.7)],
        carrier: MotionChange::default(),
    }
}

/// Parameters with every effect on.
pub fn everything(setting: &Setting) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        nominal_torque: setting.pair.operating.nominal_torque,
        loaded_flank: LoadedFlank::Both,
        ..Parameters::default()
    }
}

/// Numbers of teeth.
pub fn teeth(setting: &Setting) -> [f64; 2] {
    [0, 1].map(|i| f64::from(setting.pair.geometry.gears[i].teeth))
}

/// The section.
pub fn report(
    document: &mut Document,
    setting: &Setting,
    samples: &FlankGrid,
    points: usize,
) -> Result<(), Error> {
    document.section("The whole element");
    let grid = thinned(samples, [1, 1, 1, 2]);
    let table = Arc::new(Table::from_file(setting.file(&grid))?);
    let operating = &setting.pair.operating;
    let nominal = setting.nominal_force();
    let spread = Spread {
        center_distance: 0.8 * operating.center_distance_offset[1],
        tilt: 0.5 * operating.misalignment[1],
        normal_force: [0.1 * nominal, 1.6 * nominal],
    };
    let mut kinds = vec![];
    for formulation in [Formulation::Conjugate, Formulation::Paper] {
        for (interpolation, name) in INTERPOLATIONS {
            let parameters = Parameters {
                interpolation,
                formulation,
                ..everything(setting)
            };
            kinds.push((
                format!("{formulation:?}, 4-D {name}").to_lowercase(),
                parameters,
            ));
        }
        let spring = Parameters {
            stiffness_model: StiffnessModel::Constant,
            formulation,
            loaded_flank: LoadedFlank::Both,
            ..Parameters::default()
        };
        kinds.push((
            format!("{formulation:?}, constant stiffness").to_lowercase(),
            spring,
        ));
    }
    let along = direction();
    let mut elements = vec![];
    for (name, parameters) in &kinds {
        let element = Element::new(&setting.pair.geometry, parameters, Some(table.clone()))?;
        let latch = element.latch(&element.nominal_inputs())?;
        let poses = poses::random(&element, &latch, teeth(setting), &spread, POSES)?;
        elements.push((name, element, latch, poses));
    }
    // A spring along one coordinate, as a one-dimensional model has it.
    let angles: Vec<[f64; 4]> = elements[0]
        .3
        .iter()
        .map(|x| {
            [
                x.gears[0].r[(1, 0)],
                x.gears[1].r[(1, 0)],
                x.gears[0].w.z,
                x.gears[1].w.z,
            ]
        })
        .collect();
    // The kernel alone, in the same turns.
    let exact = setting.exact(&setting.ranges(4), points)?;
    let exact_1d = setting.exact(&setting.ranges(1), points)?;
    let line = thinned(&grid, [1, 0, 0, 0]);
    let kernels = INTERPOLATIONS
        .iter()
        .map(|&(i, _)| Ok([FlankTable::new(&grid, i)?, FlankTable::new(&line, i)?]))
        .collect::<Result<Vec<_>, Error>>()?;
    let common = FlankTable::new(&grid, Interpolation::Spline)?.with_common_registers();
    let mut candidates = vec![];
    for (_, element, latch, poses) in &elements {
        candidates.push(Candidate::new(POSES, move || {
            for x in poses {
                let _ = black_box(element.evaluate(latch, black_box(x)));
            }
        }));
        candidates.push(Candidate::new(POSES, move || {
            for x in poses {
                let _ = black_box(element.directional_derivative(latch, black_box(x), &along));
            }
        }));
        let mut jacobian = Jacobian::zeros();
        candidates.push(Candidate::new(POSES, move || {
            for x in poses {
                let _ = black_box(element.jacobian(latch, black_box(x), &mut jacobian));
            }
        }));
    }
    candidates.push(Candidate::new(POSES, || {
        for a in &angles {
            black_box(spring(black_box(a)));
        }
    }));
    let kernel_start = candidates.len();
    for pair in &kernels {
        for (table, points) in pair.iter().zip([&exact, &exact_1d]) {
            for hessian in [false, true] {
                candidates.push(Candidate::new(points.len(), move || {
                    for x in points {
                        black_box(table.evaluate(black_box(&x.query), hessian));
                    }
                }));
            }
        }
    }
    let common_start = candidates.len();
    for hessian in [false, true] {
        let (common, points) = (&common, &exact);
        candidates.push(Candidate::new(points.len(), move || {
            for x in points {
                black_box(common.evaluate(black_box(&x.query), hessian));
            }
        }));
    }
    let times = medians(&mut candidates);
    drop(candidates);

    document.paragraph(&format!(
        "All effects on, both flanks able to carry, a 4-D table of {:?} (centre distances, \
         misalignments, displacements, mesh positions) nodes, {POSES} random poses in contact, \
         inputs as positions and rotation matrices. *Wrench*: all outputs. *Directional derivative*: \
         all outputs and their derivatives along one direction of all inputs, which is what \
         `fmi2GetDirectionalDerivative` does once per call. *Jacobian*: all outputs by all 24 (paper's \
         formulation: 36) freedoms of motion.",
        grid.axes.lengths()
    ));
    let rows: Vec<[String; 4]> = elements
        .iter()
        .enumerate()
        .map(|(k, (name, ..))| {
            let t = |j: usize| format!("{:.0}", times[3 * k + j]);
            [(*name).clone(), t(0), t(1), t(2)]
        })
        .chain([[
            "spring and damper over two angles, for comparison".to_owned(),
            format!("{:.1}", times[kernel_start - 1]),
            "–".to_owned(),
            "–".to_owned(),
        ]])
        .collect();
    document.table(
        [
            "element",
            "wrench, ns",
            "directional derivative, ns",
            "Jacobian, ns",
        ],
        &rows,
    );

    let errors: Vec<[f64; 2]> = kernels
        .iter()
        .map(|k| force_error(&k[0], &exact, nominal))
        .collect();
    let kernel = |i: usize, d: usize, h: usize| times[kernel_start + 4 * i + 2 * d + h];
    let position = |i: Interpolation| INTERPOLATIONS.iter().position(|x| x.0 == i).unwrap_or(0);
    let (linear, spline) = (
        position(Interpolation::Linear),
        position(Interpolation::Spline),
    );
    let mut bars = vec![
        [
            "spline over linear kernel, 4-D with gradient, same grid".to_owned(),
            format!("{:.2}", kernel(spline, 0, 1) / kernel(linear, 0, 1)),
            "≤ 5.5".to_owned(),
        ],
        [
            "spline over linear kernel, 4-D value".to_owned(),
            format!("{:.2}", kernel(spline, 0, 0) / kernel(linear, 0, 0)),
            "–".to_owned(),
        ],
        [
            "spline over linear whole element, wrench".to_owned(),
            format!("{:.2}", times[3 * spline] / times[3 * linear]),
            "≤ 2.5".to_owned(),
        ],
        [
            "spline over linear whole element, directional derivative".to_owned(),
            format!("{:.2}", times[3 * spline + 1] / times[3 * linear + 1]),
            "≤ 2.5".to_owned(),
        ],
        [
            "rms error, spline over linear, same 4-D grid".to_owned(),
            format!("{:.3}", errors[spline][0] / errors[linear][0]),
            "≤ 0.2".to_owned(),
        ],
        [
            "1-D over 4-D spline kernel, with gradient".to_owned(),
            format!("{:.3}", kernel(spline, 1, 1) / kernel(spline, 0, 1)),
            "≤ 0.1".to_owned(),
        ],
        [
            "1-D over 4-D spline kernel, value".to_owned(),
            format!("{:.3}", kernel(spline, 1, 0) / kernel(spline, 0, 0)),
            "≤ 0.1".to_owned(),
        ],
        [
            "whole element on the 4-D spline, wrench, ns".to_owned(),
            format!("{:.0}", times[3 * spline]),
            "goal 250".to_owned(),
        ],
        [
            "whole element on the 4-D spline, wrench and the table's second derivatives, ns"
                .to_owned(),
            format!(
                "{:.0}",
                times[3 * spline] + kernel(spline, 0, 1) - kernel(spline, 0, 0)
            ),
            "goal 350".to_owned(),
        ],
    ];
    for (i, (_, name)) in INTERPOLATIONS.iter().enumerate() {
        if i != linear && i != spline {
            bars.push([
                format!("{name} over spline kernel, 4-D with gradient"),
                format!("{:.1}", kernel(i, 0, 1) / kernel(spline, 0, 1)),
                "≥ 5".to_owned(),
            ]);
            bars.push([
                format!("rms error, {name} over spline, same 4-D grid"),
                format!("{:.2}", errors[i][0] / errors[spline][0]),
                "≥ 1".to_owned(),
            ]);
        }
    }
    for (h, what) in ["value", "with gradient"].into_iter().enumerate() {
        bars.push([
            format!("spline kernel, 4-D {what}, ns"),
            format!("{:.0}", kernel(spline, 0, h)),
            "–".to_owned(),
        ]);
        bars.push([
            "the same with two-lane registers, ns".to_owned(),
            format!("{:.0}", times[common_start + h]),
            "–".to_owned(),
        ]);
    }
    document.paragraph(
        "Ratios, all from the same turns of the same run. Goals are for 3.5 GHz. The table's kernel takes \
         four-lane registers where the processor has AVX, else two-lane ones; results are the same to the bit.",
    );
    document.table(["quantity", "measured", "wanted"], &bars);
    crate::floor::report(document, kernel(spline, 0, 0), times[3 * spline]);
    Ok(())
}

/// k x + c v along the line of action between two angles.
fn spring([a, b, v, w]: &[f64; 4]) -> [f64; 2] {
    let (k, c, r) = (4.35e8, 1e5, 38.2e-3);
    let force = (k * r * (a + b) + c * r * (v + w)).max(0.0);
    [-r * force, -r * force]
}
