//! What the C interface needs and what is safe: strings, numbers of the standard, checks.

use std::any::Any;
use std::ffi::CString;

use ::fmi::fmi2::binding::{
    fmi2Status, fmi2Status_fmi2Discard, fmi2Status_fmi2Error, fmi2Status_fmi2Fatal,
    fmi2Status_fmi2Warning, fmi2StatusKind, fmi2Type, fmi2Type_fmi2CoSimulation,
    fmi2Type_fmi2ModelExchange,
};

use super::instance::Instance;
use super::lifecycle::Interface;
use super::report::{Refusal, Severity};
use super::resources;

/// `text` as a C string; a zero byte inside it ends it.
pub(super) fn c_string(text: &str) -> CString {
    CString::new(text.split('\0').next().unwrap_or("")).unwrap_or_default()
}

/// The host's number of a severity.
pub(super) const fn status(severity: Severity) -> fmi2Status {
    match severity {
        Severity::Warning => fmi2Status_fmi2Warning,
        Severity::Discard => fmi2Status_fmi2Discard,
        Severity::Error => fmi2Status_fmi2Error,
        Severity::Fatal => fmi2Status_fmi2Fatal,
    }
}

impl Refusal {
    /// fmi2Fatal after `function` panicked.
    pub(super) fn fatal(function: &str, panic: &(dyn Any + Send)) -> Self {
        Self {
            severity: Severity::Fatal,
            message: format!("{function}: internal error: {}", panic_text(panic)),
        }
    }
}

/// What a panic said.
fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown cause")
}

/// Refuses what cannot be an array of `count` items; null is legal for none.
pub(super) fn check_array<T>(data: *const T, count: usize, what: &str) -> Result<(), Refusal> {
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if count > 0 && (data.is_null() || !data.is_aligned() || count > most) {
        return Err(Refusal::error(format!(
            "{what} is no array of {count} items: null, not aligned, or too long"
        )));
    }
    Ok(())
}

/// The unit has no continuous states and no event indicators: any are refused.
pub(super) fn none_of(count: usize, what: &str) -> Result<(), Refusal> {
    match count {
        0 => Ok(()),
        _ => Err(Refusal::error(format!(
            "{count} {what}; this unit has none"
        ))),
    }
}

/// The unit has no variable of type String: any reference is refused.
pub(super) fn no_strings(function: &str, references: &[u32]) -> Result<(), Refusal> {
    match references.first() {
        None => Ok(()),
        Some(vr) => Err(Refusal::error(format!(
            "{function}: value reference {vr} belongs to no variable of type String"
        ))),
    }
}

/// Discards a question for a status that the unit has no answer to.
pub(super) fn expect_status(
    kind: fmi2StatusKind,
    known: fmi2StatusKind,
    function: &str,
) -> Result<(), Refusal> {
    if kind == known {
        return Ok(());
    }
    Err(Refusal::discard(format!(
        "{function}: the unit has no status of kind {kind}"
    )))
}

/// A new instance for the interface that the host asks for.
pub(super) fn instantiate(
    kind: fmi2Type,
    name: &str,
    guid: &str,
    location: &str,
) -> Result<Instance, Refusal> {
    #[allow(non_upper_case_globals)] // names of the standard
    let interface = match kind {
        fmi2Type_fmi2ModelExchange => Interface::ModelExchange,
        fmi2Type_fmi2CoSimulation => Interface::CoSimulation,
        _ => {
            return Err(Refusal::error(format!(
                "fmuType = {kind}; this unit is for model exchange ({fmi2Type_fmi2ModelExchange}) \
                 and co-simulation ({fmi2Type_fmi2CoSimulation})"
            )));
        }
    };
    if name.is_empty() {
        return Err(Refusal::error(
            "instanceName is empty; give the instance a name",
        ));
    }
    let resources =
        resources::load(location, guid).map_err(|error| Refusal::error(error.to_string()))?;
    Ok(Instance::new(resources, interface))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_that_cannot_be_are_refused_and_none_may_be_null() {
        let null = std::ptr::null::<f64>();
        assert!(check_array(null, 0, "vr").is_ok());
        assert!(check_array(null, 1, "vr").is_err());
        let value = [1.0_f64];
        assert!(check_array(value.as_ptr(), 1, "vr").is_ok());
        assert!(
            check_array(
                value.as_ptr().cast::<u8>().wrapping_add(1).cast::<f64>(),
                1,
                "vr"
            )
            .is_err()
        );
        assert!(check_array(value.as_ptr(), usize::MAX, "vr").is_err());
    }

    #[test]
    fn a_panic_is_told_in_its_own_words() {
        for panic in [
            std::panic::catch_unwind(|| panic!("plain")),
            std::panic::catch_unwind(|| panic!("{}", "plain")),
        ] {
            assert_eq!(panic_text(&*panic.unwrap_err()), "plain");
        }
        let odd = std::panic::catch_unwind(|| std::panic::panic_any(7)).unwrap_err();
        assert_eq!(panic_text(&*odd), "unknown cause");
    }

    #[test]
    fn a_zero_byte_ends_a_string() {
        assert_eq!(c_string("a\0b").as_c_str(), c"a");
    }
}
