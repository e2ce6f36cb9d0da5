//! Constant loads for a communication step, for masters that hold the loads while the bodies move.
//!
//! The effective mass m of both gears along the line of action turns the element's own force F into the acceleration F/m. Two
//! communication points tell the mean acceleration of approach; what it has beyond -F/m comes from everything else
//! and is taken to stay as it is over the coming steps:
//!
//! ```text
//! a = (v_n - v_(n-1)) / H + F_(n-1) / m,      x'' = a - F(x, x', t) / m
//! ```
//!
//! with x the approach of the loaded flank, signed as the turn of gear 1, v its rate and F_(n-1) the force over the last
//! step. The bodies go on with their velocities otherwise. The element returns the constant wrench that moves the bodies over the step in
//! which it acts as the changing one would (the idea of the interface models of Peiret, Gonzalez, Kovecses and Teichmann, Multibody System
//! Dynamics 46 (2019) 261-281, with the law itself in place of its linearisation).

use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};

use super::Element;
use super::constants::FLANKS;
use super::contact::{Mesh, Solution};
use super::law::Workspace;
use super::motion::{ElementError, Inputs, Motion, Outputs, PhaseOffset};

/// In which step a master lets the loads act that it reads after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// The loads are those at the communication point.
    Held,
    /// In the step that starts from the poses they were computed from.
    Sequential,
    /// In the step after that one.
    Parallel,
}

/// What is asked of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRequest {
    /// When the loads act.
    pub coupling: Coupling,
    /// Length of the step, s, > 0; that in which the loads act is taken to be as long.
    pub length: f64,
    /// Least effective mass along the line of action, kg; 0: not known, the bodies go on with their velocities.
    pub effective_mass: f64,
}

/// What the prediction remembers of one communication step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Turn part of the penetration and half the gap at the start of the step, m.
    position: [f64; 2],
    /// Their rates, m/s.
    rate: [f64; 2],
    /// Flank that the approach refers to: +1 drive, -1 coast.
    sign: f64,
    /// s.
    pub length: f64,
    /// Forces along the turn that act in the step, in the one after it as far as it is known, and in the one before it, N,
    /// positive from the drive flank.
    force: f64,
    next: f64,
    before: f64,
    /// Mean rate of change of the approach's rate in the step before it, m/s²; `None`: no step before, or none of the same motion.
    acceleration: Option<f64>,
    /// By how much that force and that acceleration differ from those one step earlier, N, m/s².
    change: Option<[f64; 2]>,
    sums: Sums,
}

/// What the steps showed of the mass: sums of products of second differences, of which the last count most. (First differences of a
/// load that rises slowly look like those of an infinite mass.)
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Sums {
    /// The force that was taken to act, squared, N², and times the acceleration that it brought, N m/s².
    ours: [f64; 2],
    /// The same for the force of the step after: that of a sequential master where a parallel one was expected.
    other: [f64; 2],
    /// The acceleration squared, m²/s⁴.
    acceleration: f64,
}

/// Contact loads, of a moment or constant over a step: the outputs of [`Loads::ROWS`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Loads(pub [f64; Loads::ROWS.len()]);

/// Loads for a step, and what they are made of.
#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    /// At the communication point.
    pub outputs: Outputs,
    /// For the step in which they act.
    pub loads: Loads,
    /// For the next prediction; `None`: the gears are out of reach of one another.
    pub step: Option<Step>,
    /// Whether the master, taken for a parallel one, lets the loads act in the step just asked for.
    pub seems_sequential: bool,
}

/// Angle omega H of the mesh's own oscillation over a step, from which on the loads are those at the communication point: beyond it no
/// weights below are stable.
const LONGEST_STEP: f64 = 1.7;

/// Weights of the loads at begin, middle (twice) and end of a step for the constant load over it under which the bodies stand where the
/// changing one moves them at every communication point: the mean less H²/12 times the second derivative, so that
/// (x_(n+1) - 2 x_n + x_(n-1)) / H² is the mean of both steps' accelerations, as it is in the exact motion to H⁴. The mean alone makes the
/// mesh slower by (omega H)²/24.
const EQUIVALENT: [f64; 4] = [-1.0 / 6.0, 2.0 / 3.0, 2.0 / 3.0, -1.0 / 6.0];

/// The same for the mean: where teeth part or meet the load has no second derivative, and would come out negative.
const MEAN: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// Weight of what the step before showed of the mass.
const MEMORY: f64 = 0.98;

/// Changes of the force from step to step, over the nominal one, below which they show nothing of the mass.
const NOISE: f64 = 1e-3;

/// Poses and velocities of one body that agree better than this, m, are of one motion.
const AGREEMENT: f64 = 1e-9;

impl Element {
    /// Loads for the step of `request`, from the communication point with `inputs`, `last` being the step that ended there.
    /// The first step, one whose poses and velocities do not follow from the last, and one too long for the mesh's
    /// oscillation get the loads at the communication point.
    ///
    /// # Errors
    /// As [`Element::evaluate`], at the communication point.
    pub fn predict(
        &self,
        phase: &PhaseOffset,
        inputs: &Inputs,
        last: Option<&Step>,
        request: &StepRequest,
        workspace: &mut Workspace,
    ) -> Result<Prediction, ElementError> {
        self.check(inputs)?;
        let solution = Solution::new(self, phase, inputs, false, workspace)?;
        let outputs = solution.outputs;
        let mut prediction = Prediction {
            outputs,
            loads: Loads::at(&outputs),
            step: None,
            seems_sequential: false,
        };
        let Some(mesh) = &solution.mesh else {
            return Ok(prediction);
        };
        let force = mesh.force_along_turn();
        let [drive, coast] = mesh.flanks.each_ref().map(|flank| flank.penetration);
        let mut step = Step {
            position: [0.5 * (drive - coast), -0.5 * (drive + coast)],
            rate: [mesh.rates.turn, mesh.rates.half_gap],
            sign: match outputs.flank {
                0 => last.map_or(FLANKS[self.reference_flank].sign(), |last| last.sign),
                flank => f64::from(flank),
            },
            length: request.length,
            force: match (request.coupling, last) {
                (Coupling::Parallel, Some(last)) => last.next,
                _ => force,
            },
            next: force,
            before: 0.0,
            acceleration: None,
            change: None,
            sums: Sums::default(),
        };
        if let Some(last) = last {
            step.follow(last);
        }
        let now = (prediction.loads, force);
        if let Some((loads, acting)) =
            self.step_loads(phase, inputs, now, &step, request, workspace)
        {
            prediction.loads = loads;
            step.next = acting;
            if request.coupling == Coupling::Sequential {
                step.force = acting;
            }
        }
        prediction.step = Some(step);
        prediction.seems_sequential =
            request.coupling == Coupling::Parallel && step.sums.look_sequential(self.noise());
        Ok(prediction)
    }

    /// Square of a change of the force that shows nothing of the mass, N².
    fn noise(&self) -> f64 {
        (NOISE * self.constants.nominal_force).powi(2)
    }

    /// Constant loads for the step of `request`, and their part along the turn, N, after the start of `step` with the loads `now`.
    /// `None`: loads are held, nothing is known of the motion, the step is too long for it, or it leads where there are no loads.
    fn step_loads(
        &self,
        phase: &PhaseOffset,
        inputs: &Inputs,
        now: (Loads, f64),
        step: &Step,
        request: &StepRequest,
        workspace: &mut Workspace,
    ) -> Option<(Loads, f64)> {
        let (h, mass) = (request.length, request.effective_mass);
        // From the communication point to the begin of the step in which the loads act, s.
        let start = match request.coupling {
            Coupling::Held => return None,
            Coupling::Sequential => 0.0,
            Coupling::Parallel => h,
        };
        // 1/m, the acceleration by all but the mesh, and the one until the loads act, under loads that are given, m/s².
        let (mut mobility, mut others, mut given) = (0.0, 0.0, 0.0);
        if mass > 0.0 {
            let stiffness = self.parameters.constant_stiffness / self.constants.cos_phi.powi(2);
            if h * (stiffness / mass).sqrt() > LONGEST_STEP {
                return None;
            }
            mobility = step.sums.mobility(mass, self.noise());
            others = step.acceleration? + step.before * mobility;
            given = others - step.force * mobility;
        }
        // Displacement beside the drift with the present velocities, m, and its rate.
        let (y, u) = (0.5 * given * start.powi(2), given * start);
        // One step of the classical Runge-Kutta method for y'' = a - F/m.
        let mut stages = [now; 4];
        let (mut dy, mut du) = (0.0, 0.0);
        for (stage, ahead) in stages.iter_mut().zip([0.0, 0.5 * h, 0.5 * h, h]) {
            let (y, u) = (y + ahead * dy, u + ahead * du);
            let time = start + ahead;
            if time > 0.0 {
                let there = self.moved(inputs, time, y, u);
                let solution = Solution::new(self, phase, &there, false, workspace).ok()?;
                let force = solution.mesh.map_or(0.0, |mesh| mesh.force_along_turn());
                *stage = (Loads::at(&solution.outputs), force);
            }
            (dy, du) = (u, others - stage.1 * mobility);
        }
        let parted = stages.iter().any(|(_, force)| *force == 0.0);
        let weights = if parted { MEAN } else { EQUIVALENT };
        let (mut loads, mut force) = (Loads([0.0; Loads::ROWS.len()]), 0.0);
        for ((stage, f), weight) in stages.iter().zip(weights) {
            for (sum, x) in loads.0.iter_mut().zip(stage.0) {
                *sum += weight * x;
            }
            force += weight * f;
        }
        Some((loads, force))
    }

    /// The bodies `time` s on with their velocities, gear 1 turned so that the approach is `y` m larger and its rate `u` m/s. The line
    /// of centres turns as it does now, as on a planet carrier: on straight lines the centres would part by half the square of its angle.
    pub(super) fn moved(&self, inputs: &Inputs, time: f64, y: f64, u: f64) -> Inputs {
        let after = |body: &Motion| Motion {
            p: body.p + body.v * time,
            r: Rotation3::new(body.w * time).matrix() * body.r,
            ..*body
        };
        let mut there = Inputs {
            gears: inputs.gears.each_ref().map(after),
            carrier: after(&inputs.carrier),
        };
        let [gear1, gear2] = &inputs.gears;
        let (p, v) = (gear2.p - gear1.p, gear2.v - gear1.v);
        let turning = p.cross(&v) / p.norm_squared();
        let turn = Rotation3::new(turning * time);
        there.gears[1].p = there.gears[0].p + turn * (p + (v - turning.cross(&p)) * time);
        there.gears[1].v = gear1.v + turn * v;
        let per_radius = 1.0 / self.constants.rb[0];
        let gear = &mut there.gears[0];
        let axis = gear.r.column(2).into_owned();
        gear.r = Rotation3::new(axis * (y * per_radius)).matrix() * gear.r;
        gear.w += axis * (u * per_radius);
        there
    }
}

impl Mesh<f64> {
    /// N, positive from the drive flank.
    fn force_along_turn(&self) -> f64 {
        self.flanks[0].force() - self.flanks[1].force()
    }
}

impl Step {
    /// Whether a prediction can have made it, its numbers being finite as all in JSON are.
    pub fn is_valid(&self) -> bool {
        let Sums { ours, other, .. } = self.sums;
        self.length > 0.0
            && self.sign.abs() == 1.0
            && ours[0].min(other[0]).min(self.sums.acceleration) >= 0.0
    }

    /// Takes over from the step `last` before it what it shows, if the motion of this one follows from it.
    fn follow(&mut self, last: &Step) {
        let sign = self.sign;
        let [x0, x1] = [last.position, self.position].map(|x| x[0] - sign * x[1]);
        let [v0, v1] = [last.rate, self.rate].map(|v| v[0] - sign * v[1]);
        let acceleration = (v1 - v0) / last.length;
        let change = 0.5 * (v0 + v1) * last.length;
        let tolerance = acceleration.abs() * last.length.powi(2) + AGREEMENT;
        if ((x1 - x0) - change).abs() > tolerance {
            return;
        }
        self.acceleration = Some(acceleration);
        self.before = last.force;
        if let Some(before) = last.acceleration {
            let change = [last.force - last.before, acceleration - before];
            self.change = Some(change);
            self.sums = last.sums;
            if let Some(old) = last.change {
                let next = (self.force - last.force) - change[0];
                self.sums.add(change[0] - old[0], next, old[1] - change[1]);
            }
        }
    }
}

impl Sums {
    /// Adds one step: second differences of both forces, N, and of the acceleration that they brought, m/s².
    fn add(&mut self, ours: f64, other: f64, acceleration: f64) {
        for (sums, force) in [(&mut self.ours, ours), (&mut self.other, other)] {
            sums[0] = MEMORY * sums[0] + force * force;
            sums[1] = MEMORY * sums[1] + force * acceleration;
        }
        self.acceleration = MEMORY * self.acceleration + acceleration * acceleration;
    }

    /// 1/m, 1/kg, from the changes of force and acceleration so far, or where they show less than changes of the square `weight`, N²,
    /// from twice the least mass.
    fn mobility(&self, least_mass: f64, weight: f64) -> f64 {
        let mobility = (weight * 0.5 / least_mass + self.ours[1]) / (weight + self.ours[0]);
        mobility.clamp(0.0, 2.0 / least_mass)
    }

    /// Whether the accelerations follow the forces of the step after, and not those that were taken to act.
    fn look_sequential(&self, noise: f64) -> bool {
        /// Share of the accelerations that the force taken to act leaves unexplained, at least, and of that what the other one does, at
        /// most: a swing whose period is 20 steps leaves a tenth, and nothing.
        const LEFT: f64 = 1e-3;
        const LEFT_BY_OTHER: f64 = 0.05;
        let [ours, other] = [self.ours, self.other]
            .map(|[square, product]| self.acceleration - product * product / square);
        self.ours[0].min(self.other[0]) > 100.0 * noise
            && ours > LEFT * self.acceleration
            && other < LEFT_BY_OTHER * ours
    }
}

impl Loads {
    /// Rows of [`Outputs::to_array`]: forces and moments on both gears, tangential and normal force.
    pub const ROWS: [usize; 14] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 20, 21];

    /// Those of `outputs`.
    pub fn at(outputs: &Outputs) -> Self {
        let rows = outputs.to_array();
        Self(Self::ROWS.map(|row| rows[row]))
    }
}
