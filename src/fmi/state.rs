//! The state of an instance: everything that a later result depends on, without pointers, so that it can be stored
//! (fmi2GetFMUstate and its relatives) and carried into another process.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use super::Refusal;
use super::inputs::InputValues;
use super::lifecycle::{Clock, Interface, State};
use super::parameters::Settings;
use super::variables::PARAMETERS;
use crate::element::{History, Loads, PhaseOffset};
use crate::sealed;

/// Changes with the layout of serialised states.
const MAGIC: &[u8; 32] = b"gearmesh state of instance v010\n";

/// Loads that a step gave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepLoads {
    /// What it gave.
    pub given: Loads,
    /// The same without those of the pose.
    pub beyond: Loads,
    /// Whether inputs have changed since.
    pub moved: bool,
}

/// State of one instance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InstanceState {
    pub interface: Interface,
    /// Where in its life the instance is.
    pub state: State,
    pub clock: Clock,
    pub inputs: InputValues,
    /// Numbers of the parameters in the order of their variables; see [`Settings::new`].
    pub parameters: [f64; PARAMETERS],
    /// Phase offsets; `None` until fmi2ExitInitializationMode takes them.
    pub phase_offset: Option<PhaseOffset>,
    /// The steps so far, where a coupling predicts loads from them.
    pub history: Option<History>,
    /// Loads that the last step gave, where a coupling does.
    pub loads: Option<StepLoads>,
    /// Whether the outputs last looked at were out of range, for the log.
    pub out_of_range: bool,
}

impl InstanceState {
    /// Refuses a state that no instance of `interface` has made, else gives its settings.
    pub fn check(&self, interface: Interface) -> Result<Settings, Refusal> {
        if self.interface != interface {
            return Err(Refusal::error(format!(
                "the stored state belongs to {:?}; this instance was made for {interface:?}",
                self.interface
            )));
        }
        let has_phases = self.phase_offset.is_some();
        let fits = match self.state {
            State::Instantiated | State::InitializationMode => !has_phases,
            State::Error => true,
            State::StepComplete => interface == Interface::CoSimulation && has_phases,
            State::EventMode | State::ContinuousTimeMode => {
                interface == Interface::ModelExchange && has_phases
            }
            State::Terminated => has_phases,
            State::Fatal => false,
        };
        let steps = self.history.as_ref().is_none_or(History::is_valid)
            && (has_phases || (self.history.is_none() && self.loads.is_none()));
        if !fits || !steps || self.inputs.fault().is_some() {
            return Err(Refusal::error(format!(
                "the stored state is {:?} with phases, steps or inputs that no {interface:?} of this FMU has",
                self.state
            )));
        }
        Settings::new(&self.parameters)
    }

    /// As bytes, for the FMU with this GUID.
    pub fn to_bytes(&self, guid: &str) -> Vec<u8> {
        // Numbers, strings and lists alone: this cannot fail.
        let json = serde_json::to_vec(&(guid, self)).expect("a state serialises");
        sealed::seal(MAGIC, &json)
    }

    /// Reads [`InstanceState::to_bytes`] of the FMU with this GUID; refuses altered ones, and those of another version or FMU.
    pub fn from_bytes(bytes: &[u8], guid: &str) -> Result<Self, Refusal> {
        let read = || -> Result<Self, String> {
            let json = sealed::open(MAGIC, bytes)?;
            let (own, state): (String, Self) =
                serde_json::from_slice(json).map_err(|error| error.to_string())?;
            if own != guid {
                return Err("it belongs to another FMU".into());
            }
            Ok(state)
        };
        read().map_err(|reason| {
            Refusal::error(format!(
                "serialised state of {} bytes: {reason}; pass what fmi2SerializeFMUstate wrote for this FMU",
                bytes.len()
            ))
        })
    }
}

/// A handle for a stored state: unique in the process, so that one of another instance, or one that was freed, is never valid.
pub(super) fn new_handle() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A handle that is none of an instance.
pub(super) fn unknown() -> Refusal {
    Refusal::error(
        "the FMU state is none of this instance; it was freed, or belongs to another one",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::instance::Instance;
    use crate::fmi::instance::tests::{on_table, reference, set};
    use crate::fmi::variables::index;

    /// An instance in the middle of a simulation, with numbers that are not round.
    fn running() -> Instance {
        let mut instance = on_table(
            [8, 1, 1, 6],
            &[(index::COUPLING, 3.0), (index::EFFECTIVE_MASS, 0.3)],
        );
        instance.setup(-1.0 / 3.0, None).unwrap();
        set(&mut instance, index::GEAR1_ANGLES_3, 1e-4);
        set(&mut instance, index::GEAR2_ANGULAR_VELOCITY_3, -0.1);
        set(&mut instance, index::GEAR1_VELOCITY_1, -0.0);
        let spin = [reference(index::GEAR1_ANGLES_3)];
        instance.set_input_derivatives(&spin, &[1], &[0.7]).unwrap();
        instance.exit_initialization().unwrap();
        instance.do_step(-1.0 / 3.0, 1e-5).unwrap();
        instance
    }

    #[test]
    fn a_state_that_is_altered_or_of_another_unit_or_interface_is_refused() {
        let mut co_simulation = running();
        let before = co_simulation.state.clone();
        let good = before.to_bytes("{guid}");
        let mut altered = good.clone();
        altered[200] ^= 1;
        for (bytes, guid, reason) in [
            (&altered[..], "{guid}", "cut or altered"),
            (&good[..60], "{guid}", "cut or altered"),
            (&good[..20], "{guid}", "format and version"),
            (&good[..], "{diug}", "another FMU"),
        ] {
            let error = InstanceState::from_bytes(bytes, guid).unwrap_err();
            assert!(error.message.contains(reason), "{error}");
        }
        let resources = co_simulation.resources.clone();
        let other = Instance::new(resources, Interface::ModelExchange).state;
        let error = co_simulation.go_to(other).unwrap_err();
        assert!(
            error.message.contains("belongs to ModelExchange"),
            "{error}"
        );
        assert_eq!(co_simulation.state, before);
    }

    /// Whoever forges a state can put its checksum right, too.
    #[test]
    fn a_state_that_no_instance_has_made_is_refused_like_any_input() {
        let mut instance = running();
        let good = instance.state.clone();
        let text = serde_json::to_string(&good).unwrap();
        let damping =
            |x: f64| format!("\"parameters\":[2.0,435000000.0,1.0,100.0,0.0,0.0,0.0,2.0,2.0,{x:?}");
        for (from, to) in [
            (
                "\"state\":\"StepComplete\"",
                "\"state\":\"ContinuousTimeMode\"",
            ),
            ("\"state\":\"StepComplete\"", "\"state\":\"Fatal\""),
            ("\"derivatives\":{\"5\":", "\"derivatives\":{\"48\":"),
            ("\"phase_offset\":{", "\"phase_offset\":null,\"was\":{"),
            (&damping(0.0), &damping(-1.0)),
            ("\"parameters\":[2.0,", "\"parameters\":[9.0,"),
        ] {
            let forged = text.replacen(from, to, 1);
            assert_ne!(forged, text, "{from} in {text}");
            if let Ok(forged) = serde_json::from_str::<InstanceState>(&forged) {
                let read = instance.deserialize(&forged.to_bytes("{guid}"));
                assert!(read.is_err(), "{to}");
                assert!(instance.go_to(forged).is_err(), "{to}");
            }
            assert_eq!(instance.state, good);
        }
        assert!(instance.deserialize(&good.to_bytes("{guid}")).is_ok());
    }
}
