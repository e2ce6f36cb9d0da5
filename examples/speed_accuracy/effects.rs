//! What leaving out an effect saves and what it costs in accuracy, where it matters and where it does not.

use crate::document::{Document, Error};
use crate::poses::{self, Spread};
use crate::setting::{Exact, Ranges, Setting};
use crate::timing::{Candidate, medians};
use crate::whole_element::{everything, teeth};
use gearmesh::element::{Element, Parameters, StiffnessModel};
use gearmesh::gear::Flank;
use gearmesh::table::{FlankGrid, Query, Table};
use std::hint::black_box;
use std::sync::Arc;

const POSES: usize = 256;

/// An effect, how to leave it out, and the two scenes.
struct Effect {
    name: &'static str,
    without: Parameters,
    matters: (&'static str, Ranges),
    does_not: (&'static str, Ranges),
}

fn effects(setting: &Setting) -> Vec<Effect> {
    let all = everything(setting);
    let operating = &setting.pair.operating;
    let nominal = operating.nominal_torque;
    let wide = Ranges {
        torque: [0.1 * nominal, operating.maximum_torque],
        ..setting.ranges(2)
    };
    let narrow = |share: f64, range: [f64; 2]| range.map(|x| share * x);
    vec![
        Effect {
            name: "centre distance",
            without: Parameters {
                center_distance_effect: false,
                ..all
            },
            matters: (
                "shafts that part by ±100 µm",
                Ranges {
                    center_distance_offset: operating.center_distance_offset,
                    ..wide
                },
            ),
            does_not: (
                "stiff bearings, ±1 µm",
                Ranges {
                    center_distance_offset: narrow(0.01, operating.center_distance_offset),
                    ..wide
                },
            ),
        },
        Effect {
            name: "misalignment",
            without: Parameters {
                misalignment_effect: false,
                ..all
            },
            matters: (
                "shafts that tilt by ±3 mrad",
                Ranges {
                    misalignment: operating.misalignment,
                    ..wide
                },
            ),
            does_not: (
                "stiff shafts, ±0.003 mrad",
                Ranges {
                    misalignment: narrow(0.001, operating.misalignment),
                    ..wide
                },
            ),
        },
        Effect {
            name: "load dependence",
            without: Parameters {
                load_dependent: false,
                ..all
            },
            matters: ("torque from a tenth of the nominal to the maximum", wide),
            does_not: (
                "torque within 1 % of the nominal",
                Ranges {
                    torque: [0.99 * nominal, 1.01 * nominal],
                    ..wide
                },
            ),
        },
        Effect {
            name: "table at all (constant stiffness instead)",
            without: Parameters {
                stiffness_model: StiffnessModel::Constant,
                ..all
            },
            matters: ("torque from a tenth of the nominal to the maximum", wide),
            does_not: (
                "torque within 1 % of the nominal",
                Ranges {
                    torque: [0.99 * nominal, 1.01 * nominal],
                    ..wide
                },
            ),
        },
    ]
}

/// rms error of the force over the nominal one at `points`, with `parameters`.
fn error(
    setting: &Setting,
    table: &Arc<Table>,
    parameters: &Parameters,
    points: &[Exact],
) -> Result<f64, Error> {
    let squares: f64 = if parameters.stiffness_model == StiffnessModel::Constant {
        // The best constant there is for these points at the nominal torque: nominal force over mean STE.
        let at_nominal = setting.exact(
            &Ranges {
                torque: [setting.pair.operating.nominal_torque; 2],
                ..setting.ranges(2)
            },
            64,
        )?;
        let mean = at_nominal.iter().map(|x| x.query.delta).sum::<f64>() / at_nominal.len() as f64;
        let stiffness = setting.nominal_force() / mean;
        points
            .iter()
            .map(|x| (stiffness * x.query.delta.max(0.0) - x.force).powi(2))
            .sum()
    } else {
        let cut = table.sliced(&parameters.table_effects(&setting.pair.geometry))?;
        let (flank, _) = cut.flank(Flank::Drive);
        points
            .iter()
            .map(|x| {
                let on = |on: bool, v: f64| if on { v } else { 0.0 };
                let query = Query {
                    center_distance_offset: on(
                        parameters.center_distance_effect,
                        x.query.center_distance_offset,
                    ),
                    misalignment: on(parameters.misalignment_effect, x.query.misalignment),
                    ..x.query
                };
                (flank.evaluate(&query, false).gradient[0] - x.force).powi(2)
            })
            .sum()
    };
    Ok((squares / points.len() as f64).sqrt() / setting.nominal_force())
}

/// rms error of the shuttling moment when it is left out, over nominal force times half the face.
fn moment_left_out(setting: &Setting, points: &[Exact]) -> f64 {
    let squares: f64 = points.iter().map(|x| x.moment * x.moment).sum();
    (squares / points.len() as f64).sqrt() / (setting.nominal_force() * setting.half_face())
}

/// The section. `spur` is a spur pair.
pub fn report(
    document: &mut Document,
    setting: &Setting,
    spur: &Setting,
    samples: &FlankGrid,
    points: usize,
) -> Result<(), Error> {
    document.section("Leaving effects out");
    let table = Arc::new(Table::from_file(setting.file(samples))?);
    let all = everything(setting);
    let mut effects = effects(setting);
    let mut rows = vec![];
    for e in &effects {
        let mut cells = vec![];
        for (_, ranges) in [&e.matters, &e.does_not] {
            let exact = setting.exact(ranges, points)?;
            for parameters in [&all, &e.without] {
                cells.push(100.0 * error(setting, &table, parameters, &exact)?);
            }
        }
        rows.push([
            e.name.to_owned(),
            e.matters.0.to_owned(),
            format!("{:.2} / {:.2}", cells[0], cells[1]),
            e.does_not.0.to_owned(),
            format!("{:.2} / {:.2}", cells[2], cells[3]),
        ]);
    }
    let tilted = Ranges {
        misalignment: setting.pair.operating.misalignment,
        ..setting.ranges(2)
    };
    rows.push([
        "shuttling (error of the moment)".to_owned(),
        "shafts that tilt by ±3 mrad".to_owned(),
        format!(
            "– / {:.2}",
            100.0 * moment_left_out(setting, &setting.exact(&tilted, points)?)
        ),
        "spur pair, parallel shafts".to_owned(),
        format!(
            "– / {:.2}",
            100.0 * moment_left_out(spur, &spur.exact(&spur.ranges(2), points)?)
        ),
    ]);
    document.paragraph(
        "Errors, in % of nominal force (moment: of nominal force times half the face), rms over random \
         operating points of a scene against direct solutions: with all effects on / with this one off.",
    );
    document.table(
        [
            "effect",
            "scene where it matters",
            "error, %",
            "scene where it does not",
            "error, %",
        ],
        &rows,
    );

    effects.push(Effect {
        name: "shuttling",
        without: Parameters {
            shuttling_effect: false,
            ..all
        },
        ..Effect {
            name: "",
            without: all,
            matters: ("", setting.ranges(2)),
            does_not: ("", setting.ranges(2)),
        }
    });
    let rotation_only = Parameters {
        center_distance_effect: false,
        misalignment_effect: false,
        shuttling_effect: false,
        ..all
    };
    let mut variants = vec![("all on".to_owned(), all)];
    variants.extend(
        effects
            .iter()
            .map(|e| (format!("without {}", e.name), e.without)),
    );
    variants.push((
        "without centre distance, misalignment, shuttling".to_owned(),
        rotation_only,
    ));
    let nominal = setting.nominal_force();
    let spread = Spread {
        center_distance: 5e-5,
        tilt: 1e-3,
        normal_force: [0.2 * nominal, 1.5 * nominal],
    };
    let mut elements = vec![];
    for (name, parameters) in &variants {
        let element = Element::new(&setting.pair.geometry, parameters, Some(table.clone()))?;
        let latch = element.latch(&element.nominal_inputs())?;
        let poses = poses::random(&element, &latch, teeth(setting), &spread, POSES)?;
        let bytes = if parameters.stiffness_model == StiffnessModel::Constant {
            0
        } else {
            let cut = table.sliced(&parameters.table_effects(&setting.pair.geometry))?;
            cut.flank(Flank::Drive).0.bytes()
        };
        elements.push((name, element, latch, poses, bytes));
    }
    let along = crate::whole_element::direction();
    let mut candidates = vec![];
    for (_, element, latch, poses, _) in &elements {
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
    }
    let times = medians(&mut candidates);
    drop(candidates);
    let rows: Vec<[String; 4]> = elements
        .iter()
        .enumerate()
        .map(|(i, (name, .., bytes))| {
            [
                (*name).clone(),
                format!("{:.0}", times[2 * i]),
                format!("{:.0}", times[2 * i + 1]),
                format!("{:.0}", *bytes as f64 / 1e3),
            ]
        })
        .collect();
    document.paragraph("Price of the whole element and memory of its table:");
    document.table(
        [
            "element",
            "wrench, ns",
            "directional derivative, ns",
            "table, kB",
        ],
        &rows,
    );
    Ok(())
}
