//! Which function may be called when: the state machines of FMI 2.0.5, sections 3.2.3 (model exchange)
//! and 4.2.4 (co-simulation), as one table.

use std::fmt;

use State::*;
use serde::{Deserialize, Serialize};

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
        /// Functions of the C interface that take an instance, by their names without fmi2; fmi2FreeInstance is never
        /// refused.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs)]
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
    SetDebugLogging Reset GetFMUstate SetFMUstate FreeFMUstate: &STATES, None;
    SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate: &STATES, None;
    SetupExperiment EnterInitializationMode: &[Instantiated], None;
    ExitInitializationMode: &[InitializationMode], None;
    GetReal GetInteger GetBoolean GetString GetDirectionalDerivative: STATES.split_at(1).1, None;
    SetReal: STATES.split_at(5).0, None;
    SetInteger SetBoolean SetString: STATES.split_at(4).0, None;
    Terminate: &[StepComplete, EventMode, ContinuousTimeMode], None;

    SetRealInputDerivatives: &[Instantiated, InitializationMode, StepComplete], CS;
    DoStep: &[StepComplete], CS;
    GetRealOutputDerivatives: &[StepComplete, Terminated, Error], CS;
    GetStatus GetRealStatus GetIntegerStatus: &[StepComplete, Terminated, Error], CS;
    GetBooleanStatus GetStringStatus: &[StepComplete, Terminated, Error], CS;
    // A step is never in progress when a call returns, so there is nothing to cancel.
    CancelStep: &[], CS;

    EnterEventMode SetTime: &[EventMode, ContinuousTimeMode], ME;
    NewDiscreteStates EnterContinuousTimeMode: &[EventMode], ME;
    CompletedIntegratorStep SetContinuousStates: &[ContinuousTimeMode], ME;
    GetDerivatives GetContinuousStates GetNominalsOfContinuousStates: &STATES, ME;
    GetEventIndicators: STATES.split_at(1).1, ME;
}

/// The name in the standard.
impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "fmi2{self:?}")
    }
}

impl Function {
    /// Why the function may not be called in `state` of an instance of `interface`; `None`: it may.
    #[inline]
    pub fn refusal(self, state: State, interface: Interface) -> Option<String> {
        let (states, own) = self.rule();
        if let Some(other) = own.filter(|own| *own != interface) {
            return Some(format!(
                "{self} belongs to {other:?}; this instance was made for {interface:?}"
            ));
        }
        if states.contains(&state) {
            return None;
        }
        let allowed = match states {
            [] => "no state of this FMU".to_owned(),
            _ => {
                let states = states.iter().map(|state| format!("{state:?}"));
                states.collect::<Vec<_>>().join(", ")
            }
        };
        Some(format!(
            "{self} is not allowed in the state {state:?}; it is in {allowed}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_lists_the_states_that_are_allowed() {
        use Interface::CoSimulation;
        for (function, allowed) in [
            (Function::DoStep, "StepComplete"),
            (
                Function::SetInteger,
                "Instantiated, InitializationMode, StepComplete, EventMode",
            ),
            (Function::CancelStep, "no state of this FMU"),
            (Function::Reset, "Instantiated"),
            (Function::GetReal, "InitializationMode"),
            (Function::GetFMUstate, "Instantiated"),
        ] {
            let refusal = function.refusal(State::Fatal, CoSimulation).unwrap();
            let start =
                format!("fmi2{function:?} is not allowed in the state Fatal; it is in {allowed}");
            assert!(refusal.starts_with(&start), "{refusal}");
        }
    }
}
