//! A co-simulation master: the contact element and the gears exchange loads and motion only at
//! communication points, as an FMU and its host do.

use super::fixed_step::runge_kutta_4;
use super::scene::Scene;
use super::state::State;
use gearmesh::element::{ElementError, Inputs, InputsChange, MotionChange, Outputs};
use nalgebra::{Rotation3, Vector3};

/// Order in which a master lets both sides step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Master {
    /// The element first: the gears step from t to t + H under the loads of the motion at t.
    Sequential,
    /// Both at once: the gears step from t to t + H under the loads of the motion at t - H.
    Parallel,
}

/// What crosses the boundary besides values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extrapolation {
    /// Loads are held.
    Hold,
    /// The element moves its inputs on inside its step by their velocities (input derivatives) to the
    /// middle of the interval over which its loads will act, and the loads are held.
    Inputs,
    /// Loads run on linearly with their time derivatives (output derivatives), taken by the exact
    /// gradient along the velocities.
    Outputs,
}

/// Loads on both gears and their rates.
#[derive(Debug, Clone, Copy)]
struct Loads {
    at: f64,
    force: [Vector3<f64>; 2],
    moment: [Vector3<f64>; 2],
    force_rate: [Vector3<f64>; 2],
    moment_rate: [Vector3<f64>; 2],
}

/// A running co-simulation.
pub struct Coupling<'a> {
    scene: &'a Scene,
    master: Master,
    extrapolation: Extrapolation,
    /// Communication step H, s.
    step: f64,
    /// Runge-Kutta steps of the gears within one communication step.
    substeps: usize,
    time: f64,
    state: State,
    loads: Loads,
}

impl<'a> Coupling<'a> {
    /// Start at `state` and time zero, with communication step `step` (s) that the gears' own integrator
    /// divides into `substeps`.
    ///
    /// # Errors
    /// As the element's evaluation.
    pub fn new(
        scene: &'a Scene,
        master: Master,
        extrapolation: Extrapolation,
        state: State,
        step: f64,
        substeps: usize,
    ) -> Result<Self, ElementError> {
        let mut coupling = Self {
            scene,
            master,
            extrapolation,
            step,
            substeps,
            time: 0.0,
            state,
            loads: Loads {
                at: 0.0,
                force: [Vector3::zeros(); 2],
                moment: [Vector3::zeros(); 2],
                force_rate: [Vector3::zeros(); 2],
                moment_rate: [Vector3::zeros(); 2],
            },
        };
        coupling.loads = coupling.element()?;
        Ok(coupling)
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// State of the gears.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// One communication step.
    ///
    /// # Errors
    /// As the element's evaluation.
    pub fn advance(&mut self) -> Result<(), ElementError> {
        let new = self.element()?;
        let loads = match self.master {
            Master::Sequential => new,
            Master::Parallel => self.loads,
        };
        let h = self.step / self.substeps as f64;
        for n in 0..self.substeps {
            let t = self.time + n as f64 * h;
            self.state = runge_kutta_4(t, &self.state, h, |t, y| {
                let ahead = t - loads.at;
                let run = |x: &[Vector3<f64>; 2], rate: &[Vector3<f64>; 2]| {
                    [x[0] + rate[0] * ahead, x[1] + rate[1] * ahead]
                };
                Ok::<_, ElementError>(self.scene.rates(
                    t,
                    y,
                    &run(&loads.force, &loads.force_rate),
                    &run(&loads.moment, &loads.moment_rate),
                ))
            })?;
        }
        self.time += self.step;
        self.loads = new;
        Ok(())
    }

    /// The element's answer to the motion now.
    fn element(&self) -> Result<Loads, ElementError> {
        let scene = self.scene;
        let inputs = scene.inputs(self.time, &self.state);
        let mut loads = Loads {
            at: self.time,
            force: [Vector3::zeros(); 2],
            moment: [Vector3::zeros(); 2],
            force_rate: [Vector3::zeros(); 2],
            moment_rate: [Vector3::zeros(); 2],
        };
        let take = |loads: &mut Loads, out: &Outputs| {
            loads.force = out.force;
            loads.moment = out.moment;
        };
        match self.extrapolation {
            Extrapolation::Hold => {
                take(&mut loads, &scene.element.evaluate(&scene.latch, &inputs)?);
            }
            Extrapolation::Inputs => {
                let ahead = match self.master {
                    Master::Sequential => 0.5 * self.step,
                    Master::Parallel => 1.5 * self.step,
                };
                let inputs = run_on(&inputs, ahead);
                take(&mut loads, &scene.element.evaluate(&scene.latch, &inputs)?);
            }
            Extrapolation::Outputs => {
                take(&mut loads, &scene.element.evaluate(&scene.latch, &inputs)?);
                let slopes = scene.element.directional_derivative(
                    &scene.latch,
                    &inputs,
                    &along_velocities(&inputs),
                )?;
                for i in 0..2 {
                    let part = |k: usize| Vector3::from_column_slice(&slopes[6 * i + k..][..3]);
                    loads.force_rate[i] = part(0);
                    loads.moment_rate[i] = part(3);
                }
            }
        }
        Ok(loads)
    }
}

/// `inputs` moved on by `dt` (s) at constant velocities.
fn run_on(inputs: &Inputs, dt: f64) -> Inputs {
    let mut out = *inputs;
    for m in &mut out.gears {
        m.p += m.v * dt;
        m.r = Rotation3::new(m.w * dt).matrix() * m.r;
    }
    out
}

/// The change of `inputs` per second at constant velocities.
fn along_velocities(inputs: &Inputs) -> InputsChange {
    let mut change = InputsChange::default();
    for (c, m) in change.gears.iter_mut().zip(&inputs.gears) {
        *c = MotionChange {
            p: m.v,
            rotation: m.w,
            ..MotionChange::default()
        };
    }
    change
}
