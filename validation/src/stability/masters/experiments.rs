//! Bodies under a master, and by how much they stray from their exact course.

use super::bodies::Bodies;
use super::packed::{Mesh, Packed};
use crate::Result;
use crate::data::rms;
use crate::driver::Master;
use gearmesh::element::Coupling;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

/// Of the fine steps that times are counted in, in a packed step.
const TICKS: usize = 20;

/// How a master steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// What the units are told.
    pub coupling: Coupling,
    pub master: Master,
    /// 0, 1/2 or 1.
    pub theta: f64,
    /// Lengths of the steps by turns, in ticks.
    pub steps: [usize; 2],
    /// Whether it gives the angles' derivatives, too (fmi2SetRealInputDerivatives).
    pub derivatives: bool,
}

impl Stepping {
    /// Loads act over the whole step, and the master gives no derivatives.
    pub fn exact(coupling: Coupling, master: Master, steps: [usize; 2]) -> Stepping {
        Stepping {
            coupling,
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

/// Runs `bodies` in steps of `tick` s times those of `stepping`, with `cycles` mesh cycles a second.
fn run(
    p: &Packed,
    bodies: &Bodies,
    stepping: Stepping,
    tick: f64,
    cycles: f64,
    duration: f64,
) -> Result<Course> {
    let (n, count) = bodies.meshes.shape();
    let inverse = bodies.mass.map(f64::recip);
    let flows = stepping.steps.map(|ticks| {
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
        .map(|_| Mesh::new(p, stepping.coupling))
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
                stepping.derivatives,
            )?;
        }
        course.push((ticks, approach.iter().copied().collect()));
        let before = late.replace(force.clone());
        let acting = match stepping.master {
            Master::Sequential => force,
            Master::Parallel => before.unwrap_or(force),
        };
        let share = ((t + 0.5 * h) / RISE).min(1.0);
        let load = &bodies.load * share - &bodies.meshes * acting;
        let mut whole = DVector::zeros(3 * n);
        let kick = load.component_mul(&inverse) * *h;
        whole.rows_mut(0, 2 * n).copy_from(&state);
        if stepping.theta == 0.5 {
            whole.rows_mut(2 * n, n).copy_from(&load);
        } else if stepping.theta == 1.0 {
            let mut rates = whole.rows_mut(n, n);
            rates += &kick;
        }
        let moved = flow * whole;
        state.copy_from(&moved.rows(0, 2 * n));
        if stepping.theta == 0.0 {
            let mut rates = state.rows_mut(n, n);
            rates += &kick;
        }
        ticks += stepping.steps[turn % 2];
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
        let stepping = Stepping::exact(Coupling::Sequential, Master::Sequential, [1, 1]);
        let exact = run(packed, &bodies, stepping, tick, cycles, duration)?;
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

    fn run(&self, stepping: Stepping) -> Result<Course> {
        let Self { packed, bodies, .. } = self;
        run(
            packed,
            bodies,
            stepping,
            self.tick,
            self.cycles,
            self.duration,
        )
    }

    /// `None`: unstable.
    pub fn errors(&self, stepping: Stepping) -> Result<Option<Errors>> {
        let found = self.run(stepping)?;
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
pub fn swing_kept(
    p: &Packed,
    bodies: &Bodies,
    stepping: Stepping,
    steps: usize,
) -> Result<Option<f64>> {
    let tick = p.step / TICKS as f64;
    let duration = steps as f64 * p.step;
    let Some(course) = run(p, bodies, stepping, tick, 0.0, duration)? else {
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

/// Ends of the parts of a long run, s, in which errors are shown; in the last one nothing is left of the first steps.
pub(super) const SETTLING: [[f64; 2]; 3] = [[14e-3, 24e-3], [54e-3, 64e-3], [134e-3, 144e-3]];

/// What a master is, what the units are told, and the errors, %, in later and later parts of a long run. `None`: unstable.
pub type Settling = (Master, Coupling, Option<[f64; 3]>);

/// Of `bodies` that move exactly between the loads, at 160 packed steps a mesh cycle.
pub fn settling(p: &Packed, bodies: Bodies) -> Result<Vec<Settling>> {
    let [.., [_, duration]] = SETTLING;
    let case = Case::lasting(p, bodies, STEPS[4], duration)?;
    let last = case.exact.len() - 1;
    let mut found = vec![];
    for (master, known) in MASTERS {
        for coupling in [known, Coupling::Automatic] {
            let stepping = Stepping::exact(coupling, master, ALIKE);
            let course = case.run(stepping)?;
            let errors = course.map(|course| {
                SETTLING.map(|part| {
                    let [from, to] = part.map(|t| (t / case.tick) as usize);
                    error(&course, &case.exact, from..=to.min(last))
                })
            });
            found.push((master, coupling, errors));
        }
    }
    Ok(found)
}

/// Errors of a pair of another mass than the packed one.
#[derive(Debug, Clone, Copy)]
pub struct OfMass {
    /// Over the packed mass.
    pub share: f64,
    pub master: Master,
    pub theta: f64,
    pub known: Option<Errors>,
    pub automatic: Option<Errors>,
}

/// Shares of the packed mass.
const MASSES: [f64; 7] = [0.18, 0.25, 0.35, 0.5, 1.0, 3.0, 10.0];

/// Pairs of a fifth to ten times the packed mass at 160 packed steps a mesh cycle, under masters that move the bodies exactly or set velocities first.
pub fn of_masses(p: &Packed) -> Result<Vec<OfMass>> {
    let mut all = vec![];
    for share in MASSES {
        let case = Case::new(p, Bodies::weighing(p, share), STEPS[4])?;
        for (master, coupling) in MASTERS {
            for theta in [0.5, 1.0] {
                let errors = |coupling| {
                    case.errors(Stepping {
                        theta,
                        ..Stepping::exact(coupling, master, ALIKE)
                    })
                };
                all.push(OfMass {
                    share,
                    master,
                    theta,
                    known: errors(coupling)?,
                    automatic: errors(Coupling::Automatic)?,
                });
            }
        }
    }
    Ok(all)
}

/// Largest departure of the force from that of held loads along a given motion, over the nominal load, %.
pub fn given(p: &Packed, steps: f64, lengths: [usize; 2]) -> Result<f64> {
    let tick = p.step / TICKS as f64;
    let omega = TAU / (steps * p.step);
    let deflection = p.load / p.stiffness;
    let course = |coupling: Coupling| -> Result<Vec<f64>> {
        let mut mesh = Mesh::new(p, coupling)?;
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
    let (held, found) = (course(Coupling::Held)?, course(Coupling::Automatic)?);
    let off = held.iter().zip(&found).map(|(a, b)| (a - b).abs());
    Ok(100.0 * off.fold(0.0, f64::max) / p.load)
}

/// Masters, and the coupling that says so.
pub const MASTERS: [(Master, Coupling); 2] = [
    (Master::Sequential, Coupling::Sequential),
    (Master::Parallel, Coupling::Parallel),
];

/// Packed steps in a mesh cycle.
pub const STEPS: [f64; 5] = [10.0, 20.0, 40.0, 80.0, 160.0];
