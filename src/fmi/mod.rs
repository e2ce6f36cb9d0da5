//! The FMU (FMI 2.0) around the element.
//!
//! ```text
//! host ── c_interface ── instance ─┬─ inputs ── element
//!         pointers,      life and  ├─ parameters, variables (modelDescription.xml)
//!         panics, log    cache     └─ state: inputs, parameters, phase offsets, clock, last step
//! ```
//!
//! [`variables`] is generated from modelDescription.xml; [`resources`] reads what packing put into the archive. In the
//! product only [`c_interface`] and the vector registers of the table's kernel (src/vector.rs) have
//! unsafe code; the tests that call the interface as C does need it for that.

pub mod c_interface;
pub mod header;
pub mod inputs;
pub mod instance;
pub mod lifecycle;
pub mod parameters;
pub mod resources;
mod state;
pub mod variables;

use crate::element::ElementError;

/// What a message to the host is about, in the order of fmi2Status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// fmi2OK: an event.
    Event,
    /// fmi2Warning: the outputs are not to be trusted.
    Warning,
    /// fmi2Discard: not available, state unchanged.
    Discard,
    /// fmi2Error.
    Error,
    /// fmi2Fatal.
    Fatal,
}

/// A call that is refused, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Refusal {
    /// Status to return.
    pub severity: Severity,
    /// Names the field, the value and the remedy.
    pub message: String,
}

impl Refusal {
    /// fmi2Error with `message`.
    pub fn error(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: message.into(),
        }
    }

    /// fmi2Discard with `message`.
    pub fn discard(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Discard,
            message: message.into(),
        }
    }
}

/// Where a pose has no outputs, the host may try elsewhere; no pose mends a parameter.
impl From<ElementError> for Refusal {
    fn from(error: ElementError) -> Self {
        let severity = match error {
            ElementError::Parameter(_) => Severity::Error,
            ElementError::Pose(_) | ElementError::Law(_) => Severity::Discard,
        };
        Refusal {
            severity,
            message: error.to_string(),
        }
    }
}
