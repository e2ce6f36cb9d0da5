//! Which function may be called when: the state machines of FMI 2.0.5, sections 3.2.3 (model exchange)
//! and 4.2.4 (co-simulation), as one table.

use State::*;
use serde::{Deserialize, Serialize};

use super::Refusal;

/// State of one instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
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

/// In the order of the life of an instance, so that ranges of it are the rules.
const STATES: [State; 7] = [
    Instantiated,
    InitializationMode,
    StepComplete,
    EventMode,
    ContinuousTimeMode,
    Terminated,
    Error,
];
const CS: Option<Interface> = Some(Interface::CoSimulation);
const ME: Option<Interface> = Some(Interface::ModelExchange);

functions! {
    fmi2SetDebugLogging fmi2Reset fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate: &STATES, None;
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate: &STATES, None;
    fmi2SetupExperiment fmi2EnterInitializationMode: &[Instantiated], None;
    fmi2ExitInitializationMode: &[InitializationMode], None;
    fmi2GetReal fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2GetDirectionalDerivative: STATES.split_at(1).1, None;
    fmi2SetReal: STATES.split_at(5).0, None;
    fmi2SetInteger fmi2SetBoolean fmi2SetString: STATES.split_at(4).0, None;
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
    fmi2GetDerivatives fmi2GetContinuousStates fmi2GetNominalsOfContinuousStates: &STATES, ME;
    fmi2GetEventIndicators: STATES.split_at(1).1, ME;
}

impl Function {
    /// Whether the function may be called in `state` of an instance of `interface`.
    ///
    /// # Errors
    /// It may not: names the states in which it may be, or the interface it belongs to.
    #[inline]
    pub fn admit(self, state: State, interface: Interface) -> Result<(), Refusal> {
        let (states, own) = self.rule();
        let reason = match own {
            Some(other) if other != interface => {
                format!("belongs to {other:?}; this instance was made for {interface:?}")
            }
            _ if states.contains(&state) => return Ok(()),
            _ => format!("not allowed in the state {state:?}; it is in {states:?}"),
        };
        Err(Refusal::error(reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_lists_the_states_that_are_allowed() {
        for (function, allowed) in [
            (Function::fmi2DoStep, "[StepComplete]"),
            (Function::fmi2CancelStep, "[]"),
            (Function::fmi2GetReal, "[InitializationMode, "),
        ] {
            let refusal = function.admit(State::Fatal, Interface::CoSimulation);
            let text = refusal.unwrap_err().message;
            let start = format!("not allowed in the state Fatal; it is in {allowed}");
            assert!(text.starts_with(&start), "{text}");
        }
    }
}
