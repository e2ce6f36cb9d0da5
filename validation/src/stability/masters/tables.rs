//! Tables of the experiments.

use super::bodies::{Bodies, systems};
use super::experiments::{
    ALIKE, BY_TURNS, Case, Errors, MASTERS, OfMass, SETTLING, STEPS, Stepping, given, of_masses,
    settling, swing_kept,
};
use super::packed::Packed;
use crate::data::Data;
use crate::driver::Master;
use crate::stability::cosimulation::TABLES;
use crate::{Context, Result};
use gearmesh::element::Coupling;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let p = Packed::new(TABLES[2])?;
    let steps = if context.quick { &STEPS[4..] } else { &STEPS };
    all_masters(&p, steps, data)?;
    with_derivatives(&p, data)?;
    free_swings(data)?;
    late_errors(&p, data)?;
    other_masses(&p, data)?;
    given_motion(&p, steps, data)
}

/// Errors of the approach with held loads, with the coupling of the master and with automatic coupling.
fn all_masters(p: &Packed, steps: &[f64], data: &Data) -> Result<()> {
    let mut rows = vec![];
    for bodies in systems(p) {
        let swept = bodies.sweep.is_some();
        for &count in if swept { &STEPS[4..] } else { steps } {
            let case = Case::new(p, bodies.clone(), count)?;
            let cycle = if swept {
                "sweep".into()
            } else {
                format!("{count}")
            };
            for (kind, steps) in [("alike", ALIKE), ("h, h/10", BY_TURNS)] {
                if steps == BY_TURNS && count < 160.0 {
                    continue;
                }
                for (master, known) in MASTERS {
                    for theta in [0.0, 0.5, 1.0] {
                        let find = |coupling| {
                            case.errors(Stepping {
                                theta,
                                ..Stepping::exact(coupling, master, steps)
                            })
                        };
                        let found = [
                            find(Coupling::Held)?,
                            find(known)?,
                            find(Coupling::Automatic)?,
                        ];
                        let cells = |part: fn(Errors) -> f64| {
                            found.map(|errors| cell(errors.map(part))).join(" | ")
                        };
                        rows.push(format!(
                            "{} | {cycle} | {kind} | {master:?} | {theta} | {} | {}",
                            case.bodies.name,
                            cells(|e| e.take_up),
                            cells(|e| e.steady),
                        ));
                    }
                }
            }
        }
    }
    let head = "system | steps a mesh cycle | steps | master | theta | held, % | known, % | automatic, % | held, steady, % \
        | known, steady, % | automatic, steady, %";
    data.table("masters", head, &rows)
}

/// Errors of the approach in the pair, without and with derivatives of the angles.
fn with_derivatives(p: &Packed, data: &Data) -> Result<()> {
    let mut rows = vec![];
    let case = Case::new(p, Bodies::pair(p), 160.0)?;
    for master in [Master::Sequential, Master::Parallel] {
        for theta in [0.0, 0.5, 1.0] {
            let find = |derivatives: bool| -> Result<String> {
                let found = case.errors(Stepping {
                    theta,
                    derivatives,
                    ..Stepping::exact(Coupling::Automatic, master, ALIKE)
                })?;
                Ok(cell(found.map(|e| e.take_up)))
            };
            let [without, with] = [find(false)?, find(true)?];
            rows.push(format!("{master:?} | {theta} | {without} | {with}"));
        }
    }
    let head = "master | theta | automatic, % | with input derivatives, %";
    data.table("input-derivatives", head, &rows)
}

/// Cells of [`swing_kept`], %, after 10 000 steps: of the exact motion, and of coupling that is told the master and that finds it.
fn swings(p: &Packed, bodies: &Bodies) -> Result<String> {
    const LENGTH: usize = 10_000;
    let kept = |coupling: Coupling, master: Master, steps: [usize; 2]| -> Result<String> {
        let stepping = Stepping::exact(coupling, master, steps);
        let kept = swing_kept(p, bodies, stepping, LENGTH)?;
        Ok(kept.map_or("unstable".into(), |kept| format!("{:.3}", 100.0 * kept)))
    };
    let columns = [
        kept(Coupling::Sequential, Master::Sequential, [1, 1])?,
        kept(Coupling::Sequential, Master::Sequential, ALIKE)?,
        kept(Coupling::Automatic, Master::Sequential, ALIKE)?,
        kept(Coupling::Parallel, Master::Parallel, ALIKE)?,
        kept(Coupling::Automatic, Master::Parallel, ALIKE)?,
    ];
    Ok(columns.join(" | "))
}

/// What is left of a free swing of a train, with the packed damping and with a tenth of it.
fn free_swings(data: &Data) -> Result<()> {
    let mut rows = vec![];
    for share in [1.0, 0.1] {
        let swinging = Packed::with_damping(TABLES[2], share)?;
        for bodies in systems(&swinging).iter().filter(|b| b.train) {
            let cells = swings(&swinging, bodies)?;
            rows.push(format!("{} | {share} | {cells}", bodies.name));
        }
    }
    let head = "system | damping of the mesh over the packed one | exact, % | known, sequential, % | automatic, sequential, % \
        | known, parallel, % | automatic, parallel, %";
    data.table("swings", head, &rows)
}

/// Errors of the approach in later and later parts of a run.
fn late_errors(p: &Packed, data: &Data) -> Result<()> {
    let mut rows = vec![];
    for bodies in systems(p).into_iter().filter(|b| b.train) {
        let name = bodies.name;
        for (master, coupling, errors) in settling(p, bodies)? {
            let cells = errors.map_or(["unstable".into(), "".into(), "".into()], |errors| {
                errors.map(|e| format!("{e:.3}"))
            });
            rows.push(format!(
                "{name} | {master:?} | {coupling:?} | {}",
                cells.join(" | ")
            ));
        }
    }
    let parts = SETTLING.map(|part| {
        let [from, to] = part.map(|t| 1e3 * t);
        format!("{from:.0} to {to:.0} ms, %")
    });
    let head = format!("system | master | coupling | {}", parts.join(" | "));
    data.table("settling", &head, &rows)
}

/// Errors of pairs of other masses than the packed one.
fn other_masses(p: &Packed, data: &Data) -> Result<()> {
    let rows = of_masses(p)?.into_iter().map(|found| {
        let OfMass {
            known, automatic, ..
        } = found;
        format!(
            "{} | {:?} | {} | {} | {} | {} | {}",
            found.share,
            found.master,
            found.theta,
            cell(known.map(|e| e.take_up)),
            cell(automatic.map(|e| e.take_up)),
            cell(known.map(|e| e.steady)),
            cell(automatic.map(|e| e.steady)),
        )
    });
    let head = "mass over the packed one | master | theta | known, % | automatic, % | known, steady, % | automatic, steady, %";
    data.table("masses", head, &rows.collect::<Vec<_>>())
}

/// Departure of automatic coupling from held loads along a given motion.
fn given_motion(p: &Packed, steps: &[f64], data: &Data) -> Result<()> {
    let mut rows = vec![];
    for &count in steps {
        let [alike, turns] = [given(p, count, ALIKE)?, given(p, count, BY_TURNS)?];
        rows.push(format!("{count} | {alike:.2e} | {turns:.2e}"));
    }
    let head = "steps a mesh cycle | alike, % | h and h/10, %";
    data.table("given-motion", head, &rows)
}

fn cell(error: Option<f64>) -> String {
    error.map_or("unstable".into(), |error| format!("{error:.3}"))
}
