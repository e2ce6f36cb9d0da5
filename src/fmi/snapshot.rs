//! The state of an instance: everything that a later result depends on, without pointers, so that it
//! can be kept, restored, and carried into another process.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::instance::Simulation;
use super::lifecycle::State;
use super::report::Refusal;
use super::unit::Point;

/// State of one instance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Snapshot {
    /// Where in its life the instance is.
    pub state: State,
    /// Clock, and the inputs' polynomials in co-simulation.
    pub simulation: Simulation,
    /// Inputs, parameters and phase zeros.
    pub point: Point,
    /// Whether the outputs last looked at were out of range.
    pub out_of_range: bool,
}

/// First bytes of a serialised state.
const MAGIC: &[u8; 8] = b"gearmesh";

/// Version of the layout below.
const VERSION: u32 = 3;

/// Length of the checksum: SHA-256.
const CHECKSUM: usize = 32;

/// A state with the unit it belongs to.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    guid: String,
    snapshot: Snapshot,
}

/// Writes `snapshot` as bytes: magic, version (little-endian), JSON, and a checksum over all before it.
pub(super) fn serialize(snapshot: &Snapshot, guid: &str) -> Vec<u8> {
    let mut bytes = [MAGIC.as_slice(), &VERSION.to_le_bytes()].concat();
    let document = Document {
        guid: guid.to_owned(),
        snapshot: snapshot.clone(),
    };
    // Numbers, strings and lists alone: this cannot fail.
    serde_json::to_writer(&mut bytes, &document).expect("a state serialises");
    bytes.extend_from_slice(&Sha256::digest(&bytes));
    bytes
}

/// Reads what [`serialize`] wrote for the unit with this GUID.
///
/// # Errors
/// Bytes of another origin, version or unit, and altered ones.
pub(super) fn deserialize(bytes: &[u8], guid: &str) -> Result<Snapshot, Refusal> {
    let refuse = |reason: &str| {
        Refusal::error(format!(
            "serialised state of {} bytes: {reason}; pass what fmi2SerializeFMUstate wrote for this unit",
            bytes.len()
        ))
    };
    let version = bytes
        .strip_prefix(MAGIC)
        .and_then(|rest| rest.first_chunk())
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
    let text = body
        .get(MAGIC.len() + size_of::<u32>()..)
        .unwrap_or_default();
    let document: Document =
        serde_json::from_slice(text).map_err(|error| refuse(&error.to_string()))?;
    if document.guid != guid {
        return Err(refuse("it belongs to another unit"));
    }
    Ok(document.snapshot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::instance::Instance;
    use crate::fmi::lifecycle::Interface;
    use crate::fmi::resources::tests::on_table;
    use crate::fmi::variables::{VARIABLES, index};

    fn reference(i: usize) -> u32 {
        VARIABLES[i].value_reference
    }

    /// An instance in the middle of a simulation, with numbers that are not round.
    fn running() -> Instance {
        let mut instance = on_table([8, 1, 1, 6], &[(index::EXTRAPOLATE_POSES, 1.0)]);
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
        let before = instance.snapshot();
        let bytes = serialize(&before, "{guid}");
        let after = deserialize(&bytes, "{guid}").unwrap();
        assert_eq!(after, before);
        assert_eq!(serialize(&after, "{guid}"), bytes);
        let outputs: Vec<u32> = (100..131).collect();
        let read = |instance: &mut Instance| {
            let mut values = Vec::new();
            instance
                .get_real(outputs.iter().copied(), |x| values.push(x.to_bits()))
                .unwrap();
            values
        };
        let expected = read(&mut instance);
        let mut other = on_table([8, 1, 1, 6], &[]);
        other.go_to(&after).unwrap();
        assert_eq!(read(&mut other), expected);
    }

    #[test]
    fn a_state_that_is_cut_altered_or_of_another_unit_or_version_is_refused() {
        let good = serialize(&running().snapshot(), "{guid}");
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
        let resources = co_simulation.resources().clone();
        let before = co_simulation.snapshot();
        let other = Instance::new(resources, Interface::ModelExchange).snapshot();
        let error = co_simulation.go_to(&other).unwrap_err();
        assert!(
            error.message.contains("belongs to ModelExchange"),
            "{error}"
        );
        assert_eq!(co_simulation.snapshot(), before);
    }

    /// Whoever forges a state can put its checksum right, too.
    #[test]
    fn a_state_that_no_instance_has_made_is_refused_like_any_input() {
        let mut instance = running();
        let good = instance.snapshot();
        let text = serde_json::to_string(&good).unwrap();
        let damping =
            |x: f64| format!("\"parameters\":[2.0,435000000.0,1.0,100.0,0.0,0.0,0.0,2.0,2.0,{x:?}");
        for (from, to) in [
            (
                "\"state\":\"StepComplete\"",
                "\"state\":\"ContinuousTimeMode\"",
            ),
            ("\"state\":\"StepComplete\"", "\"state\":\"Fatal\""),
            ("\"given\":{\"5\":", "\"given\":{\"48\":"),
            ("\"latch\":{", "\"latch\":null,\"was\":{"),
            (&damping(0.0), &damping(-1.0)),
            ("\"parameters\":[2.0,", "\"parameters\":[9.0,"),
        ] {
            let forged = text.replacen(from, to, 1);
            assert_ne!(forged, text, "{from} in {text}");
            let forged: Snapshot = serde_json::from_str(&forged).unwrap();
            assert!(
                instance.deserialize(&serialize(&forged, "{guid}")).is_err(),
                "{to}"
            );
            assert!(instance.go_to(&forged).is_err(), "{to}");
            assert_eq!(instance.snapshot(), good);
        }
        assert!(instance.deserialize(&serialize(&good, "{guid}")).is_ok());
    }
}
