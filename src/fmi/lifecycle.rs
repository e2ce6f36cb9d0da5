//! Which function may be called when: the state machine of FMI 2.0.5, section 4.2.4, as a table.

/// State of one instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// After fmi2Instantiate or fmi2Reset.
    Instantiated,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    InitializationMode,
    /// Ready for fmi2DoStep ("stepComplete" of the standard).
    StepComplete,
    /// After fmi2Terminate.
    Terminated,
    /// After a call returned fmi2Error: a stored state, fmi2Reset or fmi2FreeInstance lead out.
    Error,
    /// After a call returned fmi2Fatal.
    Fatal,
}

impl State {
    /// All states in the order of their discriminants.
    pub const ALL: [State; 6] = [
        State::Instantiated,
        State::InitializationMode,
        State::StepComplete,
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
const T: u8 = State::Terminated.bit();
const E: u8 = State::Error.bit();

/// Functions of the C interface that take an instance, in groups that share the states they may be
/// called in: `Get` and `Set` for all types and `Set` for input derivatives, `FmuState` for the six that
/// keep, restore and serialise states.
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
    Set,
    FmuState,
    GetDerivative,
    GetOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
}

impl Function {
    /// Bit mask of the states the function may be called in. Calling it in another one is fmi2Error.
    const fn allowed(self) -> u8 {
        match self {
            Function::SetDebugLogging => I | M | S | T | E,
            Function::SetupExperiment | Function::EnterInitializationMode => I,
            Function::ExitInitializationMode => M,
            Function::Terminate => S,
            Function::Reset => I | M | S | T | E,
            Function::Get => M | S | T | E,
            Function::Set => I | M | S,
            Function::FmuState => I | M | S | T | E,
            Function::GetDerivative => M | S | T | E,
            Function::GetOutputDerivatives => S | T | E,
            Function::DoStep => S,
            // A step is never in progress when a call returns, so there is nothing to cancel.
            Function::CancelStep => 0,
            Function::GetStatus => S | T | E,
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
            Function::Set.allowed_names(),
            "Instantiated, InitializationMode, StepComplete"
        );
        assert_eq!(
            Function::CancelStep.allowed_names(),
            "no state of this unit"
        );
    }
}
