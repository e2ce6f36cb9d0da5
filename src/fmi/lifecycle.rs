//! Which function may be called when: the state machines of FMI 2.0.5, sections 3.2.3 (model exchange)
//! and 4.2.4 (co-simulation), as one table, and the communication points.

use State::*;
use serde::{Deserialize, Serialize};

use super::Refusal;
use super::variables::check_finite;
use crate::words::number;

/// State of one instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// After fmi2Instantiate or fmi2Reset.
    Instantiated,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    InitializationMode,
    /// Co-simulation: ready for fmi2DoStep ("stepComplete" of the standard).
    StepComplete,
    /// Model exchange: between fmi2ExitInitializationMode or fmi2EnterEventMode and
    /// fmi2EnterContinuousTimeMode.
    EventMode,
    /// Model exchange: the host integrates.
    ContinuousTimeMode,
    /// After fmi2Terminate.
    Terminated,
    /// After a call returned fmi2Error: a stored state, fmi2Reset or fmi2FreeInstance lead out.
    Error,
    /// After a call returned fmi2Fatal.
    Fatal,
}

/// What an instance was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interface {
    /// fmi2CoSimulation.
    CoSimulation,
    /// fmi2ModelExchange.
    ModelExchange,
}

/// Defines [`Function`] with the states in which each function may be called, and the interface that it belongs to if it
/// does not belong to both.
macro_rules! functions {
    ($($($name:ident)+: $states:expr, $interface:expr;)+) => {
        /// Functions of the C interface that take an instance; fmi2FreeInstance is never refused.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs, non_camel_case_types)]
        pub enum Function {
            $($($name,)+)+
        }

        impl Function {
            const fn rule(self) -> (&'static [State], Option<Interface>) {
                match self {
                    $($(Self::$name)|+ => ($states, $interface),)+
                }
            }
        }
    };
}

const ALL: &[State] = &[
    Instantiated,
    InitializationMode,
    StepComplete,
    EventMode,
    ContinuousTimeMode,
    Terminated,
    Error,
];
/// In which there are outputs.
const INITIALIZED: &[State] = &[
    InitializationMode,
    StepComplete,
    EventMode,
    ContinuousTimeMode,
    Terminated,
    Error,
];
/// In which inputs may be set.
const RUNNING: &[State] = &[
    Instantiated,
    InitializationMode,
    StepComplete,
    EventMode,
    ContinuousTimeMode,
];
/// In which discrete variables may be set: not while a solver integrates.
const AT_EVENTS: &[State] = &[Instantiated, InitializationMode, StepComplete, EventMode];
const CS: Option<Interface> = Some(Interface::CoSimulation);
const ME: Option<Interface> = Some(Interface::ModelExchange);

functions! {
    fmi2SetDebugLogging fmi2Reset fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate: ALL, None;
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate: ALL, None;
    fmi2SetupExperiment fmi2EnterInitializationMode: &[Instantiated], None;
    fmi2ExitInitializationMode: &[InitializationMode], None;
    fmi2GetReal fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2GetDirectionalDerivative: INITIALIZED, None;
    fmi2SetReal: RUNNING, None;
    fmi2SetInteger fmi2SetBoolean fmi2SetString: AT_EVENTS, None;
    fmi2Terminate: &[StepComplete, EventMode, ContinuousTimeMode], None;

    fmi2SetRealInputDerivatives: &[Instantiated, InitializationMode, StepComplete], CS;
    fmi2DoStep: &[StepComplete], CS;
    fmi2GetRealOutputDerivatives: &[StepComplete, Terminated, Error], CS;
    fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus: &[StepComplete, Terminated, Error], CS;
    fmi2GetBooleanStatus fmi2GetStringStatus: &[StepComplete, Terminated, Error], CS;
    // A step is never in progress when a call returns, so there is nothing to cancel.
    fmi2CancelStep: &[], CS;

    fmi2EnterEventMode fmi2SetTime: &[EventMode, ContinuousTimeMode], ME;
    fmi2NewDiscreteStates fmi2EnterContinuousTimeMode: &[EventMode], ME;
    fmi2CompletedIntegratorStep fmi2SetContinuousStates: &[ContinuousTimeMode], ME;
    fmi2GetDerivatives fmi2GetContinuousStates fmi2GetNominalsOfContinuousStates: ALL, ME;
    fmi2GetEventIndicators: INITIALIZED, ME;
}

impl Function {
    /// Whether the function may be called in `state` of an instance of `interface`.
    /// Errors: it may not; named are the states in which it may be, or the interface it belongs to.
    #[inline]
    pub fn admit(self, state: State, interface: Interface) -> Result<(), Refusal> {
        let (states, own) = self.rule();
        let reason = match own {
            Some(other) if other != interface => {
                format!("belongs to {other:?}; this instance was made for {interface:?}")
            }
            _ if states.contains(&state) => return Ok(()),
            _ => format!("not allowed in the state {state:?}, only in {states:?}"),
        };
        Err(Refusal::error(reason))
    }
}

/// Units in the last place by which the host's communication point may differ from ours. Its own point counts at every
/// step, so differences do not add up: one addition against ours is two or three roundings; the rest is for hosts that
/// count in nanoseconds.
const ROUNDINGS: f64 = 16.0;

/// The same over the step: hosts that add up their steps, or print and read their times, slip by that much.
const SLIP: f64 = 1e-6;

/// Where the simulation stands.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Clock {
    /// Start of the experiment, s.
    start: f64,
    /// Current communication point, s.
    pub time: f64,
    /// End of the experiment, s, if the host set one.
    stop: Option<f64>,
    /// Start of the last step, s; `None` before the first one.
    previous: Option<f64>,
}

impl Clock {
    /// fmi2SetupExperiment.
    /// Errors: times that are not finite or in the wrong order.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        check_finite("startTime", start)?;
        if let Some(stop) = stop.filter(|stop| stop.is_nan() || *stop < start) {
            return Err(Refusal::error(format!(
                "stopTime = {} lies before startTime = {}",
                number(stop),
                number(start)
            )));
        }
        *self = Self {
            start,
            time: start,
            stop,
            previous: None,
        };
        Ok(())
    }

    /// fmi2SetTime of model exchange.
    /// Errors: a time that is not finite.
    pub fn set(&mut self, time: f64) -> Result<(), Refusal> {
        check_finite("time", time)?;
        self.time = time;
        Ok(())
    }

    /// The clock after the step from `point` over `step` s.
    /// Errors: a step that is not positive, does not start where the last one ended, or passes the stop time.
    pub fn after(&self, point: f64, step: f64) -> Result<Self, Refusal> {
        let refuse = |reason: String| Err(Refusal::error(reason));
        if !step.is_finite() || step <= 0.0 {
            return refuse(format!(
                "communicationStepSize = {}; it must be positive and finite",
                number(step)
            ));
        }
        let follows = (point - self.time).abs() <= self.tolerance(point, step); // never for NaN
        if !follows {
            return refuse(format!(
                "currentCommunicationPoint = {}, but the last step ended at {}; restore a stored state to go back",
                number(point),
                number(self.time)
            ));
        }
        let end = point + step;
        if end <= point {
            return refuse(format!(
                "communicationStepSize = {} is lost in the rounding of the time {}; take longer steps, or \
                 start the experiment at time 0",
                number(step),
                number(point)
            ));
        }
        // Hosts that add up their steps come to the stop time with the sum of all roundings.
        let late = 1e-3 * step + 1e-9 * self.time.abs();
        if let Some(stop) = self.stop.filter(|stop| end > stop + late) {
            return refuse(format!(
                "the step ends at {}, after stopTime = {}; shorten it",
                number(end),
                number(stop)
            ));
        }
        Ok(Self {
            time: end,
            previous: Some(point),
            ..self.clone()
        })
    }

    /// Largest distance of the host's `point` from ours: roundings of additions or a slip that is small against the `step`, and less
    /// than half the last step, so that no step is ever taken twice however short it is.
    fn tolerance(&self, point: f64, step: f64) -> f64 {
        // Near time 0 the summands are larger than the sum.
        let size = self.start.abs().max(self.time.abs()).max(point.abs());
        let slip = (SLIP * step).max(ROUNDINGS * f64::EPSILON * size);
        let half = |previous| 0.5 * (self.time - previous);
        self.previous.map_or(slip, |p| slip.min(half(p)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_hundreds_of_digits_are_said_with_an_exponent() {
        let mut clock = Clock::default();
        clock.setup(1e300, Some(1.5e300)).unwrap();
        for (point, step) in [
            (1e300, 1e-300),
            (2e300, 1.0),
            (1e300, 1e301),
            (1e300, -1e300),
        ] {
            let message = clock.after(point, step).unwrap_err().message;
            assert!(message.len() < 150 && message.contains("e30"), "{message}");
        }
        let message = clock.setup(1e300, Some(-1e300)).unwrap_err().message;
        assert!(message.contains("stopTime = -1e300 lies"), "{message}");
    }

    #[test]
    fn a_refusal_lists_the_states_that_are_allowed() {
        for (function, allowed) in [
            (Function::fmi2DoStep, "[StepComplete]"),
            (Function::fmi2CancelStep, "[]"),
            (Function::fmi2GetReal, "[InitializationMode, "),
        ] {
            let refusal = function.admit(State::Fatal, Interface::CoSimulation);
            let text = refusal.unwrap_err().message;
            let start = format!("not allowed in the state Fatal, only in {allowed}");
            assert!(text.starts_with(&start), "{text}");
        }
    }

    fn started(start: f64) -> Clock {
        let mut clock = Clock::default();
        clock.setup(start, None).unwrap();
        clock
    }

    /// The next point of a host: from start, last point, step and number of the step.
    type Next = fn(f64, f64, f64, f64) -> f64;

    /// Steps of hosts that add up, multiply, count ticks, or mix these.
    #[test]
    fn every_honest_way_to_count_time_is_followed_over_a_million_steps() {
        for (start, h) in [
            (0.0_f64, 1e-3_f64),
            (1000.0, 1e-7),
            (0.3, 1e-5),
            (-7.0, 1.0 / 3.0),
        ] {
            let hosts: [Next; 4] = [
                |_, last, h, _| last + h,
                |start, _, h, n| start + n * h,
                |start, _, h, n| start + ((n * h) * 1e9).round() * 1e-9,
                |start, last, h, n| {
                    if n % 2.0 == 0.0 {
                        last + h
                    } else {
                        start + n * h
                    }
                },
            ];
            for (k, next) in hosts.into_iter().enumerate() {
                // Ticks are whole nanoseconds only for steps that are.
                if k == 2 && (h * 1e9 - (h * 1e9).round()).abs() > 1e-9 {
                    continue;
                }
                let mut clock = started(start);
                let mut point = start;
                for n in 1..=1_000_000 {
                    clock = clock.after(point, h).unwrap();
                    point = next(start, point, h, f64::from(n));
                }
            }
        }
    }

    #[test]
    fn no_step_is_taken_twice_however_short() {
        for time in [0.0, 1e-3, 1.0, 1000.0, -1000.0, 1e9] {
            for h in [1e-13, 1e-12, 1e-9, 1e-7, 1e-3] {
                let Ok(once) = started(time).after(time, h) else {
                    let lost = time + h == time;
                    assert!(lost, "t = {time}, h = {h}");
                    continue;
                };
                for again in [h, 1e-6, 1.0] {
                    assert!(once.after(time, again).is_err(), "t = {time}, h = {h}");
                }
                let next = once.time;
                assert!(once.after(next, h).is_ok(), "t = {time}, h = {h}");
            }
        }
    }

    #[test]
    fn a_slip_that_is_small_against_the_step_is_the_same_point() {
        let mut clock = started(0.0);
        for n in 0..295_000 {
            clock = clock.after(f64::from(n) * 1e-5, 1e-5).unwrap();
        }
        let slipped = clock.after(2.950000000003, 1e-5).unwrap();
        assert_eq!(slipped.time, 2.950000000003 + 1e-5);
        let refused = clock.after(2.95 + 2e-11, 1e-5).unwrap_err().message;
        assert!(refused.contains("restore a stored state"), "{refused}");
    }

    #[test]
    fn a_point_off_by_more_than_rounding_is_refused_with_both_times() {
        let clock = started(1000.0).after(1000.0, 1e-7).unwrap();
        let said = clock.after(1000.0 + 2e-7, 1e-7).unwrap_err().message;
        assert!(said.contains("1000.0000001"), "{said}");
        assert!(clock.after(f64::NAN, 1e-7).is_err());
        let lost = started(1e9).after(1e9, 1e-9).unwrap_err().message;
        assert!(lost.contains("lost in the rounding"), "{lost}");
    }
}
