//! Which function may be called when: the state machines of FMI 2.0.5, sections 3.2.3 (model exchange)
//! and 4.2.4 (co-simulation), as one table.

/// State of one instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
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

impl State {
    /// All states in the order of their discriminants.
    pub const ALL: [State; 8] = [
        State::Instantiated,
        State::InitializationMode,
        State::StepComplete,
        State::EventMode,
        State::ContinuousTimeMode,
        State::Terminated,
        State::Error,
        State::Fatal,
    ];

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

const I: u8 = State::Instantiated.bit();
const M: u8 = State::InitializationMode.bit();
const S: u8 = State::StepComplete.bit();
const V: u8 = State::EventMode.bit();
const C: u8 = State::ContinuousTimeMode.bit();
const T: u8 = State::Terminated.bit();
const E: u8 = State::Error.bit();

/// Functions of the C interface that take an instance, in groups that share the states they may be
/// called in: `Get` for all types, `SetReal` for Real, `SetDiscrete` for all others, `FmuState` for the six
/// that keep, restore and serialise states, `GetStates` for the derivatives and values of continuous
/// states and their nominals.
///
/// fmi2FreeInstance stands outside the table: it is never refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get,
    SetReal,
    SetDiscrete,
    FmuState,
    GetDirectionalDerivative,
    // Co-simulation.
    SetInputDerivatives,
    GetOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
    // Model exchange.
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime,
    SetContinuousStates,
    GetStates,
    GetEventIndicators,
}

/// What an instance was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Interface {
    /// fmi2CoSimulation.
    CoSimulation,
    /// fmi2ModelExchange.
    ModelExchange,
}

impl Function {
    /// Bit mask of the states the function may be called in. Calling it in another one is fmi2Error.
    const fn allowed(self) -> u8 {
        match self {
            Function::SetDebugLogging => I | M | S | V | C | T | E,
            Function::SetupExperiment | Function::EnterInitializationMode => I,
            Function::ExitInitializationMode => M,
            Function::Terminate => S | V | C,
            Function::Reset => I | M | S | V | C | T | E,
            Function::Get => M | S | V | C | T | E,
            Function::SetReal => I | M | S | V | C,
            Function::SetDiscrete => I | M | S | V,
            Function::FmuState => I | M | S | V | C | T | E,
            Function::GetDirectionalDerivative => M | S | V | C | T | E,
            Function::SetInputDerivatives => I | M | S,
            Function::GetOutputDerivatives => S | T | E,
            Function::DoStep => S,
            // A step is never in progress when a call returns, so there is nothing to cancel.
            Function::CancelStep => 0,
            Function::GetStatus => S | T | E,
            Function::EnterEventMode => V | C,
            Function::NewDiscreteStates | Function::EnterContinuousTimeMode => V,
            Function::CompletedIntegratorStep | Function::SetContinuousStates => C,
            Function::SetTime => V | C,
            Function::GetStates => I | M | V | C | T | E,
            Function::GetEventIndicators => M | V | C | T | E,
        }
    }

    /// The one interface that the function belongs to; `None` for both.
    pub const fn interface(self) -> Option<Interface> {
        match self {
            Function::SetInputDerivatives
            | Function::GetOutputDerivatives
            | Function::DoStep
            | Function::CancelStep
            | Function::GetStatus => Some(Interface::CoSimulation),
            Function::EnterEventMode
            | Function::NewDiscreteStates
            | Function::EnterContinuousTimeMode
            | Function::CompletedIntegratorStep
            | Function::SetTime
            | Function::SetContinuousStates
            | Function::GetStates
            | Function::GetEventIndicators => Some(Interface::ModelExchange),
            _ => None,
        }
    }

    /// Whether the function may be called in `state`.
    pub const fn is_allowed(self, state: State) -> bool {
        self.allowed() & state.bit() != 0
    }

    /// The states the function may be called in, for a message.
    pub fn allowed_names(self) -> String {
        let names: Vec<String> = State::ALL
            .into_iter()
            .filter(|&s| self.is_allowed(s))
            .map(|s| format!("{s:?}"))
            .collect();
        if names.is_empty() {
            "no state of this unit".into()
        } else {
            names.join(", ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_allowed_after_a_fatal_error() {
        for function in [Function::Reset, Function::Get, Function::FmuState] {
            assert!(!function.is_allowed(State::Fatal));
        }
    }

    #[test]
    fn a_message_lists_the_states_that_are_allowed() {
        assert_eq!(Function::DoStep.allowed_names(), "StepComplete");
        assert_eq!(
            Function::SetDiscrete.allowed_names(),
            "Instantiated, InitializationMode, StepComplete, EventMode"
        );
        assert_eq!(
            Function::CancelStep.allowed_names(),
            "no state of this unit"
        );
    }
}
