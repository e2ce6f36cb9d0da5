//! The state of an instance: everything that a later result depends on, without pointers, so that it
//! can be kept, restored, and carried into another process.

use super::lifecycle::State;
use super::report::Refusal;
use super::signals::{MAXIMUM_ORDER, Signals};
use super::variables::{INPUT_COUNT, VARIABLE_COUNT};
use crate::element::Latch;

/// State of one instance.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Where in its life the instance is.
    pub state: State,
    /// Current communication point, s.
    pub time: f64,
    /// Start of the experiment, s.
    pub start_time: f64,
    /// End of the experiment, s, if the host set one.
    pub stop_time: Option<f64>,
    /// Parameters by variable index; places of inputs and outputs are not used.
    pub parameters: [f64; VARIABLE_COUNT],
    /// The inputs and their derivatives.
    pub signals: Signals,
    /// Phase zeros, from fmi2ExitInitializationMode on.
    pub latch: Option<Latch>,
}

/// First bytes of a serialised state.
const MAGIC: &[u8; 8] = b"gearmesh";

/// Version of the layout below.
const VERSION: u32 = 1;

/// Numbers in a serialised state.
const NUMBERS: usize = 7 + VARIABLE_COUNT + INPUT_COUNT * (2 + MAXIMUM_ORDER);

/// Length of a serialised state in bytes for a unit with this GUID.
pub fn serialized_size(guid: &str) -> usize {
    MAGIC.len() + 4 + 4 + guid.len() + 8 * NUMBERS + 8
}

/// Writes `snapshot` as bytes, little-endian: magic, version, GUID with its length, the numbers, and
/// a checksum over all before it.
pub fn serialize(snapshot: &Snapshot, guid: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(serialized_size(guid));
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(guid.len() as u32).to_le_bytes());
    bytes.extend_from_slice(guid.as_bytes());
    let s = &snapshot.signals;
    let latch = snapshot.latch;
    let numbers = [
        f64::from(snapshot.state as u8),
        snapshot.time,
        snapshot.start_time,
        // NaN says: no stop time, no latch. Neither is ever NaN itself.
        snapshot.stop_time.unwrap_or(f64::NAN),
        latch.map_or(f64::NAN, |l| l.tooth_angle),
        latch.map_or(f64::NAN, |l| l.mesh_position),
        INPUT_COUNT as f64,
    ];
    let all = numbers
        .iter()
        .copied()
        .chain(snapshot.parameters.iter().copied())
        .chain(s.value.iter().copied())
        .chain(s.derivative.iter().flatten().copied())
        .chain(s.given.iter().map(|g| f64::from(u8::from(*g))));
    for number in all {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes.extend_from_slice(&checksum(&bytes).to_le_bytes());
    bytes
}

/// Reads what [`serialize`] wrote for the unit with this GUID.
///
/// # Errors
/// Bytes of another origin, version, unit, length, or altered ones.
pub fn deserialize(bytes: &[u8], guid: &str) -> Result<Snapshot, Refusal> {
    let refuse = |reason: &str| {
        Err(Refusal::error(format!(
            "serialised state of {} bytes: {reason}; pass what fmi2SerializeFMUstate wrote for this unit",
            bytes.len()
        )))
    };
    let mut rest = bytes;
    let mut take = |count: usize| {
        let (head, tail) = rest.split_at_checked(count)?;
        rest = tail;
        Some(head)
    };
    if take(MAGIC.len()) != Some(MAGIC) {
        return refuse("it is not a state of gearmesh");
    }
    let mut word = || Some(u32::from_le_bytes(take(4)?.try_into().ok()?));
    let (version, length) = (word(), word());
    if version != Some(VERSION) {
        return refuse("it has another version");
    }
    if length.and_then(|n| take(n as usize)) != Some(guid.as_bytes()) {
        return refuse("it belongs to another unit");
    }
    if bytes.len() != serialized_size(guid) {
        return refuse("it has another length");
    }
    let (body, sum) = bytes.split_at(bytes.len() - 8);
    if checksum(body).to_le_bytes() != sum {
        return refuse("it was altered");
    }
    let mut numbers = rest[..8 * NUMBERS]
        .chunks_exact(8)
        .map(|c| f64::from_le_bytes(c.try_into().expect("chunks of eight bytes")));
    let mut next = || numbers.next().expect("the length was compared above");
    let [
        state,
        time,
        start_time,
        stop,
        tooth_angle,
        mesh_position,
        inputs,
    ] = std::array::from_fn(|_| next());
    let state = State::ALL
        .into_iter()
        .find(|s| f64::from(*s as u8) == state);
    let (Some(state), true) = (state, inputs == INPUT_COUNT as f64) else {
        return refuse("it has another layout");
    };
    Ok(Snapshot {
        state,
        time,
        start_time,
        stop_time: (!stop.is_nan()).then_some(stop),
        parameters: std::array::from_fn(|_| next()),
        signals: Signals {
            value: std::array::from_fn(|_| next()),
            derivative: std::array::from_fn(|_| std::array::from_fn(|_| next())),
            given: std::array::from_fn(|_| next() != 0.0),
        },
        latch: (!tooth_angle.is_nan()).then_some(Latch {
            tooth_angle,
            mesh_position,
        }),
    })
}

/// FNV-1a, 64 bit: against damage, not against malice.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::variables::template_starts;

    fn snapshot() -> Snapshot {
        let mut signals = Signals::constant(std::array::from_fn(|i| (i as f64).sqrt()));
        signals.set_derivative(3, 2, -7.25);
        Snapshot {
            state: State::StepComplete,
            time: 0.125,
            start_time: -1.0,
            stop_time: None,
            parameters: template_starts(),
            signals,
            latch: Some(Latch {
                tooth_angle: 1.5,
                mesh_position: 0.25,
            }),
        }
    }

    #[test]
    fn a_state_survives_its_serialisation_to_the_last_bit() {
        let before = snapshot();
        let bytes = serialize(&before, "{guid}");
        assert_eq!(bytes.len(), serialized_size("{guid}"));
        assert_eq!(deserialize(&bytes, "{guid}").unwrap(), before);
        let without = Snapshot {
            latch: None,
            stop_time: Some(2.0),
            ..before
        };
        let bytes = serialize(&without, "{guid}");
        assert_eq!(deserialize(&bytes, "{guid}").unwrap(), without);
    }

    #[test]
    fn a_state_that_is_cut_altered_or_of_another_unit_is_refused() {
        let good = serialize(&snapshot(), "{guid}");
        for i in (0..good.len()).step_by(7) {
            let mut bad = good.clone();
            bad[i] ^= 1;
            assert!(deserialize(&bad, "{guid}").is_err(), "byte {i}");
        }
        for length in [0, 7, 20, good.len() - 1] {
            assert!(deserialize(&good[..length], "{guid}").is_err());
        }
        assert!(deserialize(&[good.as_slice(), &[0]].concat(), "{guid}").is_err());
        let error = deserialize(&good, "{diug}").unwrap_err();
        assert!(error.message.contains("another unit"));
    }
}
