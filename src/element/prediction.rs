//! Constant loads for a communication step, for masters that hold the loads while the bodies move.
//!
//! [`Master`] tells from the motion in which step the loads act, how the master moves its bodies under them (theta), and what the step
//! to come holds beside the mesh. The bodies go on with their velocities otherwise. For theta = 1 the plain law at the start of the step in which the
//! loads act is right, for theta = 0 that at its end: with q = x + (1 - theta) H v either is the symplectic Euler rule, stable to
//! omega H = 2 and without damping. For theta = 1/2 the motion under the changing force is integrated over the step,
//!
//! ```text
//! x'' = g - w F(x, x', t)
//! ```
//!
//! with x the approach of the loaded flank, signed as the turn of gear 1, and the element returns the constant wrench that moves the bodies
//! as the changing one would (the idea of the interface models of Peiret, Gonzalez, Kovecses and Teichmann, Multibody System
//! Dynamics 46 (2019) 261-281, with the law itself in place of its linearisation).

use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};

use super::Element;
use super::constants::FLANKS;
use super::contact::{Mesh, Solution};
use super::law::Workspace;
use super::master::{Lag, Master, Outlook};
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
    /// Found from the motion; held until then.
    Automatic,
}

impl Coupling {
    fn lag(self) -> Option<Lag> {
        match self {
            Self::Held | Self::Automatic => None,
            Self::Sequential => Some(Lag::None),
            Self::Parallel => Some(Lag::One),
        }
    }
}

/// What is asked of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRequest {
    /// When the loads act.
    pub coupling: Coupling,
    /// Length of the step, s, > 0.
    pub length: f64,
    /// Effective mass of the gears along the line of action, kg, about. 0: that of both as discs, and bodies that are in the first step go on with their velocities.
    pub effective_mass: f64,
}

/// What the prediction remembers of the steps so far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// Turn part of the penetration and half the gap at the start of the last step, m.
    position: [f64; 2],
    /// Their rates, m/s.
    rate: [f64; 2],
    /// Flank that the approach refers to: +1 drive, -1 coast.
    sign: f64,
    /// Of the last step, s.
    length: f64,
    master: Master,
    /// Acceleration of the approach over the last step as it was foreseen, m/s².
    foreseen: Option<f64>,
    /// How the loads of the last step were made, and what was known then.
    pub report: Report,
}

/// How the loads of a step were made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// How.
    pub mode: Mode,
    /// Effective mass along the line of action, kg; found from the motion, or the given one.
    pub effective_mass: f64,
    /// By how much the mean force on the line of action that the last step shows exceeds the foreseen one, N.
    pub error: f64,
    /// Of the master's rule, and the angle omega H of the mesh's own oscillation over the step, rad; 0 where loads are held.
    pub theta: f64,
    /// See there.
    pub angle: f64,
}

/// How loads of a step are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Mode {
    /// Those at the communication point: the master is not known, or the motion does not follow the loads.
    #[default]
    Held,
    /// Those at the communication point: the step is too long for the mesh's oscillation.
    TooLong,
    /// For the step that starts at the communication point.
    Sequential,
    /// For the step after it.
    Parallel,
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
    /// For the next prediction; `None`: loads are held, or the gears out of mesh.
    pub history: Option<History>,
}

/// Angle omega H of the mesh's own oscillation over a step, from which on the loads are those at the communication point: beyond it no
/// weights below are stable.
const LARGEST_STEP_ANGLE: f64 = 1.7;

/// Weights of the loads at begin, middle (twice) and end of a step for the constant load over it under which the bodies stand where the
/// changing one moves them at every communication point: the mean less H²/12 times the second derivative, so that
/// (x_(n+1) - 2 x_n + x_(n-1)) / H² is the mean of both steps' accelerations, as it is in the exact motion to H⁴. The mean alone makes the
/// mesh slower by (omega H)²/24.
const EQUIVALENT: [f64; 4] = [-1.0 / 6.0, 2.0 / 3.0, 2.0 / 3.0, -1.0 / 6.0];

/// The same for the mean: where teeth part or meet the load has no second derivative, and would come out negative.
const MEAN: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// Poses and velocities of one body that agree better than this, m, are of one motion.
const AGREEMENT: f64 = 1e-9;

/// Values of theta from which on a master's rule counts as the explicit Euler rule, exact, or the symplectic Euler rule.
const RULES: [f64; 2] = [0.25, 0.75];

/// Way, over the accelerations times H², by which poses that follow from the velocities may depart from their mean.
const DEPARTURE: f64 = 2.0;

/// Accelerations above it, m/s², are no motion of gears.
const MOST_ACCELERATION: f64 = 1e12;

/// Mobility over the given one below which it says nothing of a mass.
const LEAST_MOBILITY: f64 = 1e-6;

/// Where the step begins in which the loads act, beside the drift with the present velocities: after `time` s, by a displacement, m,
/// and a rate, m/s, under the accelerations of `outlook`, over `length` s.
struct Acting {
    time: f64,
    displaced: [f64; 2],
    /// Mean rate over the step before it less that where it begins, m/s.
    held_back: f64,
    outlook: Outlook,
    length: f64,
}

impl Element {
    /// Loads for the step of `request`, from the communication point with `inputs`, `last` being what the steps before it left.
    /// The first step, one whose poses and velocities do not follow from the last, one too long for the mesh's
    /// oscillation and all until the master is known get the loads at the communication point.
    ///
    /// # Errors
    /// As [`Element::evaluate`], at the communication point.
    pub fn predict(
        &self,
        phase: &PhaseOffset,
        inputs: &Inputs,
        last: Option<&History>,
        request: &StepRequest,
        workspace: &mut Workspace,
    ) -> Result<Prediction, ElementError> {
        self.check(inputs)?;
        let solution = Solution::new(self, phase, inputs, false, workspace)?;
        let outputs = solution.outputs;
        let mut prediction = Prediction {
            outputs,
            loads: Loads::at(&outputs),
            history: None,
        };
        let Some(mesh) = (solution.mesh.as_ref()).filter(|_| request.coupling != Coupling::Held)
        else {
            return Ok(prediction);
        };
        let force = mesh.force_along_turn();
        let mass = match request.effective_mass {
            0.0 => self.constants.disc_mass,
            given => given,
        };
        let mobility = mass.recip();
        let mut history = self.observe(mesh, &outputs, last, request, mobility);
        let now = (prediction.loads, force);
        let mut given = force;
        let starts = history.master.steps() == 0;
        if let Some(lag) = (history.master.lag).filter(|_| !starts || request.effective_mass == 0.0)
        {
            let (found, next, length) = match starts {
                true => lag.drift(request.length),
                false => history.master.ahead(lag, request.length),
            };
            let stiffness = self.parameters.constant_stiffness / self.constants.cos_phi.powi(2);
            let report = &mut history.report;
            if found.mobility[0] > LEAST_MOBILITY * mobility {
                report.effective_mass = found.mobility[0].recip();
            }
            report.angle = request.length * (stiffness * found.mobility[0].max(0.0)).sqrt();
            report.theta = found.theta();
            let acting = match next {
                None => Acting {
                    time: 0.0,
                    displaced: [0.0; 2],
                    held_back: history.master.rate_held_back(),
                    outlook: found,
                    length,
                },
                Some([a, d]) => Acting {
                    time: request.length,
                    displaced: [d * request.length.powi(2), a * request.length],
                    held_back: (d - a) * request.length,
                    outlook: found,
                    length,
                },
            };
            if history.report.angle > LARGEST_STEP_ANGLE {
                history.report.mode = Mode::TooLong;
            } else if let Some((loads, force)) =
                self.step_loads(phase, inputs, now, &acting, workspace)
            {
                (prediction.loads, given) = (loads, force);
                history.report.mode = match lag {
                    Lag::None => Mode::Sequential,
                    Lag::One => Mode::Parallel,
                };
                history.foreseen = Some(match next {
                    None => found.under(force)[0],
                    Some([a, _]) => a,
                });
            }
        }
        history.master.give(given);
        prediction.history = Some(history);
        Ok(prediction)
    }

    /// The history with the step that ended here.
    fn observe(
        &self,
        mesh: &Mesh<f64>,
        outputs: &Outputs,
        last: Option<&History>,
        request: &StepRequest,
        mobility: f64,
    ) -> History {
        let [drive, coast] = mesh.flanks.each_ref().map(|flank| flank.penetration);
        let mut history = History {
            position: [0.5 * (drive - coast), -0.5 * (drive + coast)],
            rate: [mesh.rates.turn, mesh.rates.half_gap],
            sign: match outputs.flank {
                0 => last.map_or(FLANKS[self.reference_flank].sign(), |last| last.sign),
                flank => f64::from(flank),
            },
            length: request.length,
            master: last.map_or_else(
                || Master::new(request.coupling.lag(), mesh.force_along_turn(), mobility),
                |last| last.master,
            ),
            foreseen: None,
            report: Report {
                mode: Mode::Held,
                effective_mass: request.effective_mass,
                error: 0.0,
                theta: 0.0,
                angle: 0.0,
            },
        };
        if let Some(last) = last {
            let h = last.length;
            let approach = |x: &[f64; 2]| x[0] - history.sign * x[1];
            let [x0, x1] = [approach(&last.position), approach(&history.position)];
            let [v0, v1] = [approach(&last.rate), approach(&history.rate)];
            let acceleration = (v1 - v0) / h;
            let mean = 0.5 * (v0 + v1) * h;
            let nominal = self.constants.nominal_force;
            // Bodies on stiff shafts accelerate to and fro within a step.
            let most = acceleration.abs() + mobility * mesh.force_along_turn().abs().max(nominal);
            let tolerance = DEPARTURE * most * h.powi(2) + AGREEMENT;
            let follows =
                (x1 - x0 - mean).abs() <= tolerance && acceleration.abs() < MOST_ACCELERATION;
            if !follows {
                history.master.interrupt();
            } else {
                let displacement = (x1 - x0 - v0 * h) / h.powi(2);
                history
                    .master
                    .observe([acceleration, displacement], h, nominal);
                if let Some(foreseen) = last.foreseen {
                    history.report.error = (acceleration - foreseen) * last.report.effective_mass;
                }
            }
        }
        history
    }

    /// The `history` of a step whose loads are those of `outputs`, where derivatives of the inputs lead, in place of those where it began.
    pub fn held_at(&self, history: &History, outputs: &Outputs) -> History {
        let force = outputs.normal_force / self.constants.per_cos_beta_b;
        let mut history = *history;
        history
            .master
            .give_instead(f64::from(outputs.flank) * force);
        history
    }

    /// Constant loads for the step of `acting`, and their part along the turn, N, from the communication point with the loads `now`.
    /// `None`: it leads where there are no loads.
    fn step_loads(
        &self,
        phase: &PhaseOffset,
        inputs: &Inputs,
        now: (Loads, f64),
        acting: &Acting,
        workspace: &mut Workspace,
    ) -> Option<(Loads, f64)> {
        let (h, [y, u]) = (acting.length, acting.displaced);
        let Outlook {
            free,
            slope,
            mobility,
        } = acting.outlook;
        let mut at = |ahead: f64, dy: f64, du: f64| -> Option<(Loads, f64)> {
            let time = acting.time + ahead;
            if time == 0.0 && du == 0.0 {
                return Some(now);
            }
            // The approach is that of the drift with the present velocities, and beside it:
            let there = self.moved(inputs, time, y + ahead * u + dy, u + du);
            let solution = Solution::new(self, phase, &there, false, workspace).ok()?;
            let force = solution.mesh.map_or(0.0, |mesh| mesh.force_along_turn());
            Some((Loads::at(&solution.outputs), force))
        };
        let theta = acting.outlook.theta();
        if theta > RULES[1] {
            // The kick falls on the point where the step begins: the damper takes the rate in its middle, that of the ways to both sides.
            let before = acting.held_back;
            let force = at(0.0, 0.0, before)?.1;
            let after = acting.outlook.under(force)[1] * h;
            return at(0.0, 0.0, 0.5 * (before + after));
        }
        if theta < RULES[0] {
            return at(h, free[1] * h.powi(2), 0.0);
        }
        // One step of the classical Runge-Kutta method for y'' = g - w F, with g linear in time.
        let mut stages = [now; 4];
        let (mut dy, mut du) = (0.0, 0.0);
        for (stage, ahead) in stages.iter_mut().zip([0.0, 0.5 * h, 0.5 * h, h]) {
            let (y, u) = (ahead * dy, ahead * du);
            *stage = at(ahead, y, u)?;
            let without = free[0] + slope * (ahead - 0.5 * h);
            (dy, du) = (u, without - stage.1 * mobility[0]);
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
        Some((loads, force)).filter(|(loads, _)| loads.0.iter().all(|x| x.is_finite()))
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
        let per_radius = 1.0 / self.constants.base_radius[0];
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

impl History {
    /// Whether loads of the last step are those of a pose.
    pub fn is_held(&self) -> bool {
        matches!(self.report.mode, Mode::Held | Mode::TooLong)
    }

    /// Whether a prediction can have made it, its numbers being finite as all in JSON are.
    pub fn is_valid(&self) -> bool {
        self.length > 0.0 && self.sign.abs() == 1.0 && self.master.is_valid()
    }
}

impl Loads {
    /// Rows of [`Outputs::to_array`]: forces and moments on both gears, tangential and normal force.
    pub const ROWS: [usize; 14] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 20, 21];

    /// Puts them into the outputs `rows`.
    pub(crate) fn write(&self, rows: &mut [f64]) {
        for (row, load) in Self::ROWS.into_iter().zip(self.0) {
            rows[row] = load;
        }
    }

    /// Adds them to the outputs `rows`.
    pub(crate) fn add_to(&self, rows: &mut [f64]) {
        for (row, load) in Self::ROWS.into_iter().zip(self.0) {
            rows[row] += load;
        }
    }

    /// These less `other`.
    pub(crate) fn without(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }

    /// Those of `outputs`.
    pub fn at(outputs: &Outputs) -> Self {
        let rows = outputs.to_array();
        Self(Self::ROWS.map(|row| rows[row]))
    }
}
