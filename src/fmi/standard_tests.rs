//! The standard's own headers, as the crate `fmi` binds them: types of the functions, and layouts beside ours.
#![allow(non_camel_case_types)]

use std::mem::offset_of;

pub(super) use ::fmi::fmi2::binding::*;

use crate::fmi::standard;

// Structs of other names but the same layout, see below, stand behind pointers in these two.
pub(super) type fmi2InstantiateTYPE = Option<
    unsafe extern "C" fn(
        fmi2String,
        fmi2Type,
        fmi2String,
        fmi2String,
        *const standard::fmi2CallbackFunctions,
        fmi2Boolean,
        fmi2Boolean,
    ) -> fmi2Component,
>;
pub(super) type fmi2NewDiscreteStatesTYPE =
    Option<unsafe extern "C" fn(fmi2Component, *mut standard::fmi2EventInfo) -> fmi2Status>;

/// Size, alignment and places of fields are those of the header's struct of the same name.
macro_rules! assert_layout {
    ($name:ident: $($field:ident),*) => {
        assert_eq!(size_of::<standard::$name>(), size_of::<$name>());
        assert_eq!(align_of::<standard::$name>(), align_of::<$name>());
        $(assert_eq!(
            offset_of!(standard::$name, $field),
            offset_of!($name, $field),
            stringify!($field)
        );)*
    };
}

#[test]
fn structs_lie_in_memory_as_the_header_says() {
    assert_layout!(fmi2CallbackFunctions:
        logger, allocateMemory, freeMemory, stepFinished, componentEnvironment);
    assert_layout!(fmi2EventInfo:
        newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
        valuesOfContinuousStatesChanged, nextEventTimeDefined, nextEventTime);
    // The types of the callbacks, too: a value of one is a value of the other.
    let ours = standard::fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::null_mut(),
    };
    let _ = fmi2CallbackFunctions {
        logger: ours.logger,
        allocateMemory: ours.allocateMemory,
        freeMemory: ours.freeMemory,
        stepFinished: ours.stepFinished,
        componentEnvironment: ours.componentEnvironment,
    };
}

#[test]
fn constants_are_those_of_the_header() {
    for (ours, theirs) in [
        (standard::fmi2Status_fmi2OK, fmi2Status_fmi2OK),
        (standard::fmi2Status_fmi2Warning, fmi2Status_fmi2Warning),
        (standard::fmi2Status_fmi2Discard, fmi2Status_fmi2Discard),
        (standard::fmi2Status_fmi2Error, fmi2Status_fmi2Error),
        (standard::fmi2Status_fmi2Fatal, fmi2Status_fmi2Fatal),
        (standard::fmi2Status_fmi2Pending, fmi2Status_fmi2Pending),
        (
            standard::fmi2Type_fmi2ModelExchange,
            fmi2Type_fmi2ModelExchange,
        ),
        (
            standard::fmi2Type_fmi2CoSimulation,
            fmi2Type_fmi2CoSimulation,
        ),
        (
            standard::fmi2StatusKind_fmi2DoStepStatus,
            fmi2StatusKind_fmi2DoStepStatus,
        ),
        (
            standard::fmi2StatusKind_fmi2PendingStatus,
            fmi2StatusKind_fmi2PendingStatus,
        ),
        (
            standard::fmi2StatusKind_fmi2LastSuccessfulTime,
            fmi2StatusKind_fmi2LastSuccessfulTime,
        ),
        (
            standard::fmi2StatusKind_fmi2Terminated,
            fmi2StatusKind_fmi2Terminated,
        ),
        (standard::fmi2True as u32, fmi2True),
        (standard::fmi2False as u32, fmi2False),
    ] {
        assert_eq!(ours, theirs);
    }
    assert_eq!(
        standard::fmi2TypesPlatform.to_bytes_with_nul(),
        fmi2TypesPlatform
    );
    assert_eq!(standard::fmi2Version.to_bytes_with_nul(), fmi2Version);
}
