//! The state of an instance: everything that a later result depends on, without pointers, so that it can be kept
//! (fmi2GetFMUstate and its relatives) and carried into another process.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::Refusal;
use super::clock::Clock;
use super::inputs::InputValues;
use super::instance::Instance;
use super::lifecycle::{Interface, State};
use super::parameters::Settings;
use super::variables::PARAMETERS;
use crate::element::{Latch, Loads, Step};

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
    /// Phase zeros; `None` until fmi2ExitInitializationMode takes them.
    pub latch: Option<Latch>,
    /// The last step, where a coupling predicts loads from it.
    pub step: Option<Step>,
    /// Loads that the last step gave, where a coupling does.
    pub loads: Option<Loads>,
    /// Whether the outputs last looked at were out of range, for the log.
    pub out_of_range: bool,
}

impl InstanceState {
    /// Refuses a state that no instance of `interface` has made, else gives its settings.
    ///
    /// # Errors
    /// What does not fit.
    pub fn check(&self, interface: Interface) -> Result<Settings, Refusal> {
        if self.interface != interface {
            return Err(Refusal::error(format!(
                "the stored state belongs to {:?}; this instance was made for {interface:?}",
                self.interface
            )));
        }
        let has_phases = self.latch.is_some();
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
        let steps = self.step.as_ref().is_none_or(Step::is_valid)
            && (has_phases || (self.step.is_none() && self.loads.is_none()));
        if !fits || !steps || self.inputs.check().is_err() {
            return Err(Refusal::error(format!(
                "the stored state is {:?} with phases, steps or inputs that no {interface:?} of this unit has",
                self.state
            )));
        }
        Settings::new("fmi2SetFMUstate", &self.parameters)
    }

    /// As bytes: magic, version (little-endian), JSON, and a checksum (SHA-256) over all before it.
    fn to_bytes(&self, guid: &str) -> Vec<u8> {
        let mut bytes = [MAGIC.as_slice(), &VERSION.to_le_bytes()].concat();
        // Numbers, strings and lists alone: this cannot fail.
        serde_json::to_writer(&mut bytes, &(guid, self)).expect("a state serialises");
        bytes.extend_from_slice(&Sha256::digest(&bytes));
        bytes
    }

    /// Reads [`InstanceState::to_bytes`] of the unit with this GUID.
    ///
    /// # Errors
    /// Bytes of another origin, version or unit, and altered ones.
    fn from_bytes(bytes: &[u8], guid: &str) -> Result<Self, Refusal> {
        let refuse = |reason: &str| {
            Refusal::error(format!(
                "serialised state of {} bytes: {reason}; pass what fmi2SerializeFMUstate wrote for this unit",
                bytes.len()
            ))
        };
        let rest = bytes.strip_prefix(MAGIC);
        let (version, _) = rest
            .and_then(|rest| rest.split_first_chunk())
            .ok_or_else(|| refuse("it is not a state of gearmesh"))?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            let reason = format!("it has version {version}, this library reads {VERSION}");
            return Err(refuse(&reason));
        }
        let (body, checksum) = bytes
            .split_last_chunk::<CHECKSUM>()
            .ok_or_else(|| refuse("it was cut"))?;
        if Sha256::digest(body)[..] != checksum[..] {
            return Err(refuse("it was cut or altered"));
        }
        let json = body.get(MAGIC.len() + size_of_val(&VERSION)..);
        let (own, state): (String, Self) = serde_json::from_slice(json.unwrap_or_default())
            .map_err(|error| refuse(&error.to_string()))?;
        if own != guid {
            return Err(refuse("it belongs to another unit"));
        }
        Ok(state)
    }
}

/// First bytes of a serialised state.
const MAGIC: &[u8; 8] = b"gearmesh";

/// Version of the layout of serialised states.
const VERSION: u32 = 5;

/// Length of the checksum, bytes.
const CHECKSUM: usize = 32;

/// Handles are unique in the process, so that a state of another instance, or one that was freed, is
/// told from a valid one.
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

impl Instance {
    /// fmi2GetFMUstate: keeps the state under `handle`, or under a new one.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn store(&mut self, handle: Option<usize>) -> Result<usize, Refusal> {
        if let Some(handle) = handle {
            self.stored(handle)?;
        }
        Ok(self.keep(handle, self.state.clone()))
    }

    fn keep(&mut self, handle: Option<usize>, state: InstanceState) -> usize {
        let handle = handle.unwrap_or_else(|| NEXT_HANDLE.fetch_add(1, Ordering::Relaxed));
        self.stored.insert(handle, state);
        handle
    }

    fn stored(&self, handle: usize) -> Result<&InstanceState, Refusal> {
        self.stored.get(&handle).ok_or_else(|| {
            Refusal::error(
                "the FMU state is none of this instance; it was freed, or belongs to another one",
            )
        })
    }

    /// fmi2SetFMUstate.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        let state = self.stored(handle)?.clone();
        self.go_to(state)
    }

    /// fmi2FreeFMUstate.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn discard(&mut self, handle: usize) -> Result<(), Refusal> {
        self.stored(handle)?;
        self.stored.remove(&handle);
        Ok(())
    }

    /// fmi2SerializeFMUstate, and with its length fmi2SerializedFMUstateSize.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(self.stored(handle)?.to_bytes(&self.resources.unit.guid))
    }

    /// fmi2DeSerializeFMUstate: a new handle.
    ///
    /// # Errors
    /// Bytes that are no state of this unit.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Refusal> {
        let state = InstanceState::from_bytes(bytes, &self.resources.unit.guid)?;
        state.check(self.state.interface)?;
        Ok(self.keep(None, state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::resources::tests::on_table;
    use crate::fmi::variables::{VARIABLES, index};

    fn reference(i: usize) -> u32 {
        VARIABLES[i].value_reference
    }

    /// An instance in the middle of a simulation, with numbers that are not round.
    fn running() -> Instance {
        let mut instance = on_table(
            [8, 1, 1, 6],
            &[(index::COUPLING, 3.0), (index::EFFECTIVE_MASS, 0.3)],
        );
        instance.setup(-1.0 / 3.0, None).unwrap();
        let sets = [
            (index::GEAR1_ANGLES_3, 1e-4),
            (index::GEAR2_ANGULAR_VELOCITY_3, -0.1),
            (index::GEAR1_VELOCITY_1, -0.0),
        ];
        instance
            .set_real(&sets.map(|(i, _)| reference(i)), &sets.map(|(_, x)| x))
            .unwrap();
        let rate = (reference(index::GEAR1_ANGLES_3), 1, 0.7);
        instance
            .set_input_derivatives(std::iter::once(rate))
            .unwrap();
        instance.exit_initialization().unwrap();
        instance.do_step(-1.0 / 3.0, 1e-5).unwrap();
        instance
    }

    #[test]
    fn a_state_survives_its_serialisation_to_the_last_bit() {
        let mut instance = running();
        let before = instance.state.clone();
        let bytes = before.to_bytes("{guid}");
        let after = InstanceState::from_bytes(&bytes, "{guid}").unwrap();
        assert_eq!(after, before);
        assert_eq!(after.to_bytes("{guid}"), bytes);
        let outputs: Vec<u32> = (100..131).collect();
        let read = |instance: &mut Instance| {
            let mut values = Vec::new();
            instance
                .get_real(&outputs, |x| values.push(x.to_bits()))
                .unwrap();
            values
        };
        let expected = read(&mut instance);
        let mut other = on_table([8, 1, 1, 6], &[]);
        other.go_to(after).unwrap();
        assert_eq!(read(&mut other), expected);
    }

    #[test]
    fn a_state_that_is_cut_altered_or_of_another_unit_or_version_is_refused() {
        let good = running().state.to_bytes("{guid}");
        let deserialize = InstanceState::from_bytes;
        for i in (0..good.len()).step_by(7) {
            let mut bad = good.clone();
            bad[i] ^= 1;
            assert!(deserialize(&bad, "{guid}").is_err(), "byte {i}");
        }
        for length in [0, 7, 12, 20, good.len() - 1] {
            assert!(deserialize(&good[..length], "{guid}").is_err());
        }
        assert!(deserialize(&[good.as_slice(), &[0]].concat(), "{guid}").is_err());
        let error = deserialize(&good, "{diug}").unwrap_err();
        assert!(error.message.contains("another unit"));
        let mut old = good;
        old[MAGIC.len()] = 1;
        let error = deserialize(&old, "{guid}").unwrap_err();
        assert!(error.message.contains("it has version 1"), "{error}");
    }

    #[test]
    fn a_state_of_model_exchange_is_none_of_a_co_simulation() {
        let mut co_simulation = running();
        let resources = co_simulation.resources.clone();
        let before = co_simulation.state.clone();
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
            ("\"latch\":{", "\"latch\":null,\"was\":{"),
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
