//! States that the host keeps: fmi2GetFMUstate and its relatives.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::instance::Instance;
use super::report::Refusal;
use super::snapshot::{self, Snapshot};

/// Handles are unique in the process, so that a state of another instance, or one that was freed, is
/// told from a valid one.
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

/// Stored states of one instance by handle; they go with the instance.
#[derive(Debug, Default)]
pub(super) struct Stored(HashMap<usize, Snapshot>);

impl Instance {
    /// fmi2GetFMUstate: keeps the state under `handle`, or under a new one.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn store(&mut self, handle: Option<usize>) -> Result<usize, Refusal> {
        let handle = match handle {
            Some(handle) => {
                self.stored(handle)?;
                handle
            }
            None => NEXT_HANDLE.fetch_add(1, Ordering::Relaxed),
        };
        let snapshot = self.snapshot();
        self.stored.0.insert(handle, snapshot);
        Ok(handle)
    }

    fn stored(&self, handle: usize) -> Result<&Snapshot, Refusal> {
        self.stored.0.get(&handle).ok_or_else(|| {
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
        self.go_to(&state)
    }

    /// fmi2FreeFMUstate.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn discard(&mut self, handle: usize) -> Result<(), Refusal> {
        self.stored(handle)?;
        self.stored.0.remove(&handle);
        Ok(())
    }

    /// fmi2SerializeFMUstate, and with its length fmi2SerializedFMUstateSize.
    ///
    /// # Errors
    /// A handle that is none of this instance.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(snapshot::serialize(
            self.stored(handle)?,
            &self.resources().unit.guid,
        ))
    }

    /// fmi2DeSerializeFMUstate: a new handle.
    ///
    /// # Errors
    /// Bytes that are no state of this unit.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Refusal> {
        let state = snapshot::deserialize(bytes, &self.resources().unit.guid)?;
        self.check(&state)?;
        let handle = NEXT_HANDLE.fetch_add(1, Ordering::Relaxed);
        self.stored.0.insert(handle, state);
        Ok(handle)
    }
}
