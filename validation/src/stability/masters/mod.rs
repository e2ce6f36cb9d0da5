//! Packed units under every kind of master: which loads act in a step, how the bodies move under them, and what hangs on the gears.
//!
//! Bodies are linear and move exactly between the loads: along the line of action q, with M q'' + C q' + K q = load - B F and the approaches
//! B^T q of the meshes. Loads act over the step (theta = 1/2), as an impulse at its begin (1, as in `v += h a; x += h v`) or at its
//! end (0, the explicit Euler rule).

mod bodies;
mod packed;

pub use bodies::{Bodies, systems};
pub use packed::{Packed, Told};

use super::cosimulation::TABLES;
use crate::data::{Data, rms};
use crate::driver::Master;
use crate::{Context, Result};
use nalgebra::{DMatrix, DVector};
use packed::Mesh;
use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

/// Of the fine steps that times are counted in, in a packed step.
const TICKS: usize = 20;

/// How a master steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    pub told: Told,
    pub master: Master,
    /// 0, 1/2 or 1.
    pub theta: f64,
    /// Lengths of the steps by turns, in ticks.
    pub steps: [usize; 2],
    /// Whether it gives the angles' derivatives, too (fmi2SetRealInputDerivatives).
    pub derivatives: bool,
}

impl Way {
    /// Loads act over the whole step, and the master gives no derivatives.
    pub fn exact(told: Told, master: Master, steps: [usize; 2]) -> Way {
        Way {
            told,
            master,
            theta: 0.5,
            steps,
            derivatives: false,
        }
    }
}

/// Rising time of the load, and time after which what it sets swinging has mostly settled, s.
const RISE: f64 = 2e-3;
const TAKE_UP: f64 = 8e-3;
/// Length of a run, of which the last two fifths count as steady, and of a sweep up and down, s.
const DURATION: f64 = 24e-3;
const SWEEP: f64 = 40e-3;
/// Mesh cycles of a planet's meshes against those of the first one.
const PHASE: f64 = 0.3;

/// Angle and speed of gear 1, rad and rad/s, at `t` s in a run of `duration` s with `cycles` mesh cycles a second, or in its sweep.
fn turning(p: &Packed, bodies: &Bodies, cycles: f64, t: f64, duration: f64) -> [f64; 2] {
    let Some(sweep) = bodies.sweep else {
        let speed = cycles * TAU / p.teeth;
        return [speed * t, speed];
    };
    let [low, high] = sweep.map(|ratio| ratio * p.omega() / p.teeth);
    let (mean, swing) = (0.5 * (low + high), 0.5 * (high - low));
    let rate = TAU / duration;
    [
        mean * t - swing / rate * (rate * t).sin(),
        mean - swing * (rate * t).cos(),
    ]
}

/// Approaches of all meshes by tick, where a step starts; `None`: the motion ran away.
type Course = Option<Vec<(usize, Vec<f64>)>>;

/// Runs `bodies` in steps of `tick` s times those of `way`, with `cycles` mesh cycles a second.
fn run(
    p: &Packed,
    bodies: &Bodies,
    way: Way,
    tick: f64,
    cycles: f64,
    duration: f64,
) -> Result<Course> {
    let (n, count) = bodies.meshes.shape();
    let inverse = bodies.mass.map(f64::recip);
    let flows = way.steps.map(|ticks| {
        let h = tick * ticks as f64;
        let mut a = DMatrix::zeros(3 * n, 3 * n);
        for i in 0..n {
            a[(i, n + i)] = h;
            a[(n + i, 2 * n + i)] = h * inverse[i];
            for j in 0..n {
                a[(n + i, j)] = -h * inverse[i] * bodies.stiffness[(i, j)];
                a[(n + i, n + j)] = -h * inverse[i] * bodies.damping[(i, j)];
            }
        }
        (h, a.exp())
    });
    let mut meshes = (0..count)
        .map(|_| Mesh::new(p, way.told))
        .collect::<Result<Vec<_>>>()?;
    let mut state = DVector::zeros(2 * n);
    let mut late: Option<DVector<f64>> = None;
    let mut course = vec![];
    let (mut ticks, mut turn) = (0, 0);
    while (ticks as f64) * tick < duration {
        let t = ticks as f64 * tick;
        let (h, flow) = &flows[turn % 2];
        let approach = bodies.meshes.tr_mul(&state.rows(0, n));
        let rate = bodies.meshes.tr_mul(&state.rows(n, n));
        if approach.amax() > 1e-3 {
            return Ok(None);
        }
        let [angle, speed] = turning(p, bodies, cycles, t, duration);
        let mut force = DVector::zeros(count);
        for (j, mesh) in meshes.iter_mut().enumerate() {
            let shifted = angle + j as f64 * PHASE * TAU / p.teeth;
            force[j] = mesh.step(
                p,
                [shifted, speed],
                [approach[j], rate[j]],
                *h,
                way.derivatives,
            )?;
        }
        course.push((ticks, approach.iter().copied().collect()));
        let before = late.replace(force.clone());
        let acting = match way.master {
            Master::Sequential => force,
            Master::Parallel => before.unwrap_or(force),
        };
        let share = ((t + 0.5 * h) / RISE).min(1.0);
        let load = &bodies.load * share - &bodies.meshes * acting;
        let mut whole = DVector::zeros(3 * n);
        let kick = load.component_mul(&inverse) * *h;
        whole.rows_mut(0, 2 * n).copy_from(&state);
        if way.theta == 0.5 {
            whole.rows_mut(2 * n, n).copy_from(&load);
        } else if way.theta == 1.0 {
            let mut rates = whole.rows_mut(n, n);
            rates += &kick;
        }
        let moved = flow * whole;
        state.copy_from(&moved.rows(0, 2 * n));
        if way.theta == 0.0 {
            let mut rates = state.rows_mut(n, n);
            rates += &kick;
        }
        ticks += way.steps[turn % 2];
        turn += 1;
    }
    Ok(Some(course))
}

/// rms error of the approach over its standard deviation, worst mesh, %: while the load is taken up (a sweep: all over it), and
/// after all has settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    pub take_up: f64,
    pub steady: f64,
}

/// The part of it between two ticks.
fn error(
    found: &[(usize, Vec<f64>)],
    exact: &[(usize, Vec<f64>)],
    ticks: RangeInclusive<usize>,
) -> f64 {
    let rows = || found.iter().filter(|(tick, _)| ticks.contains(tick));
    let worst = (0..exact[0].1.len()).map(|j| {
        let off = rms(rows().map(|(tick, x)| x[j] - exact[*tick].1[j]));
        let all = || exact[ticks.clone()].iter().map(|(_, x)| x[j]);
        let mean = crate::data::mean(all());
        100.0 * off / rms(all().map(|x| x - mean))
    });
    worst.fold(0.0, f64::max)
}

/// A system, its exact course, and how often it was asked for.
pub struct Case<'a> {
    packed: &'a Packed,
    pub bodies: Bodies,
    tick: f64,
    cycles: f64,
    duration: f64,
    exact: Vec<(usize, Vec<f64>)>,
}

impl<'a> Case<'a> {
    /// With so many packed steps in a mesh cycle.
    pub fn new(packed: &'a Packed, bodies: Bodies, steps: f64) -> Result<Self> {
        let duration = if bodies.sweep.is_some() {
            SWEEP
        } else {
            DURATION
        };
        Self::lasting(packed, bodies, steps, duration)
    }

    /// The same over `duration` s.
    fn lasting(packed: &'a Packed, bodies: Bodies, steps: f64, duration: f64) -> Result<Self> {
        let tick = packed.step / TICKS as f64;
        let cycles = 1.0 / (steps * packed.step);
        let way = Way::exact(Told::Sequential, Master::Sequential, [1, 1]);
        let exact = run(packed, &bodies, way, tick, cycles, duration)?;
        let exact = exact.ok_or_else(|| format!("{}: no exact course", bodies.name))?;
        Ok(Self {
            packed,
            bodies,
            tick,
            cycles,
            duration,
            exact,
        })
    }

    fn run(&self, way: Way) -> Result<Course> {
        let Self { packed, bodies, .. } = self;
        run(packed, bodies, way, self.tick, self.cycles, self.duration)
    }

    /// `None`: unstable.
    pub fn errors(&self, way: Way) -> Result<Option<Errors>> {
        let found = self.run(way)?;
        let last = self.exact.len() - 1;
        let take_up = match self.bodies.sweep {
            Some(_) => last,
            None => (TAKE_UP / self.tick) as usize,
        };
        Ok(found.map(|found| Errors {
            take_up: error(&found, &self.exact, 0..=take_up),
            steady: error(&found, &self.exact, last * 6 / 10..=last),
        }))
    }
}

/// Steps by turns: alike, and one in ten.
pub const ALIKE: [usize; 2] = [TICKS, TICKS];
pub const BY_TURNS: [usize; 2] = [TICKS, TICKS / 10];

/// rms of the approach about its mean late in a run of `steps` packed steps over that early in it, worst mesh, where gears that stand
/// take up their load; more than 1: the coupling feeds the swing. `None`: the motion ran away.
pub fn swing_kept(p: &Packed, bodies: &Bodies, way: Way, steps: usize) -> Result<Option<f64>> {
    let tick = p.step / TICKS as f64;
    let duration = steps as f64 * p.step;
    let Some(course) = run(p, bodies, way, tick, 0.0, duration)? else {
        return Ok(None);
    };
    let swing = |mesh: usize, from: f64, to: f64| {
        let [from, to] = [from, to].map(|share| (share * course.len() as f64) as usize);
        let part = || course[from..to].iter().map(|(_, x)| x[mesh]);
        let mean = crate::data::mean(part());
        rms(part().map(|x| x - mean))
    };
    let kept = |mesh| swing(mesh, 0.8, 1.0) / swing(mesh, 0.1, 0.3);
    Ok(Some((0..course[0].1.len()).map(kept).fold(0.0, f64::max)))
}

/// Cells of [`swing_kept`], %, after 10 000 steps: of the exact motion, and of coupling that is told the master and that finds it.
fn swings(p: &Packed, bodies: &Bodies) -> Result<String> {
    const LENGTH: usize = 10_000;
    let kept = |told: Told, master: Master, steps: [usize; 2]| -> Result<String> {
        let way = Way::exact(told, master, steps);
        let kept = swing_kept(p, bodies, way, LENGTH)?;
        Ok(kept.map_or("unstable".into(), |kept| format!("{:.3}", 100.0 * kept)))
    };
    let columns = [
        kept(Told::Sequential, Master::Sequential, [1, 1])?,
        kept(Told::Sequential, Master::Sequential, ALIKE)?,
        kept(Told::Automatic, Master::Sequential, ALIKE)?,
        kept(Told::Parallel, Master::Parallel, ALIKE)?,
        kept(Told::Automatic, Master::Parallel, ALIKE)?,
    ];
    Ok(columns.join(" | "))
}

/// Ends of the parts of a long run, s, in which errors are shown; in the last one nothing is left of the first steps.
const SETTLING: [[f64; 2]; 3] = [[14e-3, 24e-3], [54e-3, 64e-3], [134e-3, 144e-3]];

/// What a master is, what the units are told, and the errors, %, in later and later parts of a long run. `None`: unstable.
pub type Settling = (Master, Told, Option<[f64; 3]>);

/// Of `bodies` that move exactly between the loads, at 160 packed steps a mesh cycle.
pub fn settling(p: &Packed, bodies: Bodies) -> Result<Vec<Settling>> {
    let [.., [_, duration]] = SETTLING;
    let case = Case::lasting(p, bodies, STEPS[4], duration)?;
    let last = case.exact.len() - 1;
    let mut found = vec![];
    for (master, known) in MASTERS {
        for told in [known, Told::Automatic] {
            let way = Way::exact(told, master, ALIKE);
            let course = case.run(way)?;
            let errors = course.map(|course| {
                SETTLING.map(|part| {
                    let [from, to] = part.map(|t| (t / case.tick) as usize);
                    error(&course, &case.exact, from..=to.min(last))
                })
            });
            found.push((master, told, errors));
        }
    }
    Ok(found)
}

/// Largest departure of the force from that of held loads along a given motion, over the nominal load, %.
pub fn given(p: &Packed, steps: f64, lengths: [usize; 2]) -> Result<f64> {
    let tick = p.step / TICKS as f64;
    let omega = TAU / (steps * p.step);
    let deflection = p.load / p.stiffness;
    let course = |told: Told| -> Result<Vec<f64>> {
        let mut mesh = Mesh::new(p, told)?;
        let (mut ticks, mut turn, mut forces) = (0, 0, vec![]);
        while (ticks as f64) * tick < DURATION {
            let t = ticks as f64 * tick;
            let speed = omega / p.teeth;
            let phase = omega * t;
            // Rising to the nominal load, and swinging with the mesh.
            let rise = 0.5 - 0.5 * (PI * (t / RISE).min(1.0)).cos();
            let rising = if t < RISE {
                0.5 * PI / RISE * (PI * t / RISE).sin()
            } else {
                0.0
            };
            let swing = 1.0 + 0.2 * phase.sin();
            let motion = [
                deflection * rise * swing,
                deflection * (rising * swing + rise * 0.2 * omega * phase.cos()),
            ];
            let h = tick * lengths[turn % 2] as f64;
            forces.push(mesh.step(p, [speed * t, speed], motion, h, false)?);
            ticks += lengths[turn % 2];
            turn += 1;
        }
        Ok(forces)
    };
    let (held, found) = (course(Told::Held)?, course(Told::Automatic)?);
    let off = held.iter().zip(&found).map(|(a, b)| (a - b).abs());
    Ok(100.0 * off.fold(0.0, f64::max) / p.load)
}

/// Masters, and the coupling that says so.
pub const MASTERS: [(Master, Told); 2] = [
    (Master::Sequential, Told::Sequential),
    (Master::Parallel, Told::Parallel),
];

/// Packed steps in a mesh cycle.
pub const STEPS: [f64; 5] = [10.0, 20.0, 40.0, 80.0, 160.0];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let p = Packed::new(TABLES[2])?;
    let mut rows = vec![];
    let steps = if context.quick { &STEPS[4..] } else { &STEPS };
    for bodies in systems(&p) {
        let swept = bodies.sweep.is_some();
        for &count in if swept { &STEPS[4..] } else { steps } {
            let case = Case::new(&p, bodies.clone(), count)?;
            for (kind, lengths) in [("alike", ALIKE), ("h, h/10", BY_TURNS)] {
                if lengths == BY_TURNS && count < 160.0 {
                    continue;
                }
                for (master, known) in MASTERS {
                    for theta in [0.0, 0.5, 1.0] {
                        let find = |told: Told| {
                            case.errors(Way {
                                told,
                                master,
                                theta,
                                steps: lengths,
                                derivatives: false,
                            })
                        };
                        let [held, known, found] =
                            [find(Told::Held)?, find(known)?, find(Told::Automatic)?];
                        let cell = |e: Option<Errors>, part: fn(Errors) -> f64| {
                            e.map_or("unstable".into(), |e| format!("{:.3}", part(e)))
                        };
                        let take_up: fn(Errors) -> f64 = |e| e.take_up;
                        let steady: fn(Errors) -> f64 = |e| e.steady;
                        let cycle = if swept {
                            "sweep".into()
                        } else {
                            format!("{count}")
                        };
                        rows.push(format!(
                            "{} | {cycle} | {kind} | {master:?} | {theta} | {} | {} | {} | {} | {} | {}",
                            case.bodies.name,
                            cell(held, take_up),
                            cell(known, take_up),
                            cell(found, take_up),
                            cell(held, steady),
                            cell(known, steady),
                            cell(found, steady),
                        ));
                    }
                }
            }
        }
    }
    let head = "system | steps a mesh cycle | steps | master | theta | held, % | known, % | automatic, % | held, steady, % \
        | known, steady, % | automatic, steady, %";
    data.table("masters", head, &rows)?;
    let mut rows = vec![];
    let case = Case::new(&p, Bodies::pair(&p), 160.0)?;
    for master in [Master::Sequential, Master::Parallel] {
        for theta in [0.0, 0.5, 1.0] {
            let find = |derivatives: bool| -> Result<String> {
                let found = case.errors(Way {
                    told: Told::Automatic,
                    master,
                    theta,
                    steps: ALIKE,
                    derivatives,
                })?;
                Ok(found.map_or("unstable".into(), |e| format!("{:.3}", e.take_up)))
            };
            let [without, with] = [find(false)?, find(true)?];
            rows.push(format!("{master:?} | {theta} | {without} | {with}"));
        }
    }
    data.table(
        "input-derivatives",
        "master | theta | automatic, % | with input derivatives, %",
        &rows,
    )?;
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
    data.table("swings", head, &rows)?;
    let mut rows = vec![];
    for bodies in systems(&p).into_iter().filter(|b| b.train) {
        let name = bodies.name;
        for (master, told, errors) in settling(&p, bodies)? {
            let cells = errors.map_or(["unstable".into(), "".into(), "".into()], |errors| {
                errors.map(|e| format!("{e:.3}"))
            });
            rows.push(format!(
                "{name} | {master:?} | {told:?} | {}",
                cells.join(" | ")
            ));
        }
    }
    let parts = SETTLING.map(|part| {
        let [from, to] = part.map(|t| 1e3 * t);
        format!("{from:.0} to {to:.0} ms, %")
    });
    let head = format!("system | master | coupling | {}", parts.join(" | "));
    data.table("settling", &head, &rows)?;
    let mut rows = vec![];
    for &count in steps {
        let [alike, turns] = [given(&p, count, ALIKE)?, given(&p, count, BY_TURNS)?];
        rows.push(format!("{count} | {alike:.2e} | {turns:.2e}"));
    }
    data.table(
        "given-motion",
        "steps a mesh cycle | alike, % | h and h/10, %",
        &rows,
    )
}
