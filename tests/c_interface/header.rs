//! The exports and types of src/fmi against the standard's header, as bindgen reads it for the crate `fmi`. All of it is
//! compared at compile time.

use ::fmi::fmi2::binding as standard;
use gearmesh::fmi::c_interface::*;
use gearmesh::fmi::header;
use std::mem::{align_of, offset_of, size_of};

/// The exports with the type that the header gives each.
macro_rules! same_signature {
    ($($function:ident: $type:ident,)*) => {
        $(const _: standard::$type = Some($function);)*
    };
}

same_signature! {
    fmi2GetTypesPlatform: fmi2GetTypesPlatformTYPE,
    fmi2GetVersion: fmi2GetVersionTYPE,
    fmi2FreeInstance: fmi2FreeInstanceTYPE,
    fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE,
    fmi2SetupExperiment: fmi2SetupExperimentTYPE,
    fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE,
    fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE,
    fmi2Terminate: fmi2TerminateTYPE,
    fmi2Reset: fmi2ResetTYPE,
    fmi2GetReal: fmi2GetRealTYPE,
    fmi2GetInteger: fmi2GetIntegerTYPE,
    fmi2GetBoolean: fmi2GetBooleanTYPE,
    fmi2GetString: fmi2GetStringTYPE,
    fmi2SetReal: fmi2SetRealTYPE,
    fmi2SetInteger: fmi2SetIntegerTYPE,
    fmi2SetBoolean: fmi2SetBooleanTYPE,
    fmi2SetString: fmi2SetStringTYPE,
    fmi2GetFMUstate: fmi2GetFMUstateTYPE,
    fmi2SetFMUstate: fmi2SetFMUstateTYPE,
    fmi2FreeFMUstate: fmi2FreeFMUstateTYPE,
    fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE,
    fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE,
    fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE,
    fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE,
    fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE,
    fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE,
    fmi2DoStep: fmi2DoStepTYPE,
    fmi2CancelStep: fmi2CancelStepTYPE,
    fmi2GetStatus: fmi2GetStatusTYPE,
    fmi2GetRealStatus: fmi2GetRealStatusTYPE,
    fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE,
    fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE,
    fmi2GetStringStatus: fmi2GetStringStatusTYPE,
    fmi2EnterEventMode: fmi2EnterEventModeTYPE,
    fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE,
    fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE,
    fmi2SetTime: fmi2SetTimeTYPE,
    fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE,
    fmi2GetDerivatives: fmi2GetDerivativesTYPE,
    fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE,
    fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE,
    fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE,
}

/// Two exports take a pointer to a struct, which is compared below: here all other arguments count.
unsafe extern "C" fn instantiate(
    name: standard::fmi2String,
    kind: standard::fmi2Type,
    guid: standard::fmi2String,
    location: standard::fmi2String,
    functions: *const standard::fmi2CallbackFunctions,
    visible: standard::fmi2Boolean,
    logging: standard::fmi2Boolean,
) -> standard::fmi2Component {
    let functions = functions.cast::<header::fmi2CallbackFunctions>();
    // Safety: as for the export.
    unsafe { fmi2Instantiate(name, kind, guid, location, functions, visible, logging) }
}
const _: standard::fmi2InstantiateTYPE = Some(instantiate);

unsafe extern "C" fn new_discrete_states(
    component: standard::fmi2Component,
    info: *mut standard::fmi2EventInfo,
) -> standard::fmi2Status {
    // Safety: as for the export.
    unsafe { fmi2NewDiscreteStates(component, info.cast::<header::fmi2EventInfo>()) }
}
const _: standard::fmi2NewDiscreteStatesTYPE = Some(new_discrete_states);

/// The struct has the size and the alignment of the header's, and each field its type and offset.
macro_rules! same_layout {
    ($($type:ident { $($field:ident),* })*) => {$(
        const _: () = {
            assert!(size_of::<header::$type>() == size_of::<standard::$type>());
            assert!(align_of::<header::$type>() == align_of::<standard::$type>());
            $(assert!(offset_of!(header::$type, $field) == offset_of!(standard::$type, $field));)*
        };
        const _: fn(standard::$type) -> header::$type = |other| header::$type {
            $($field: other.$field),*
        };
    )*};
}

same_layout! {
    fmi2CallbackFunctions { logger, allocateMemory, freeMemory, stepFinished, componentEnvironment }
    fmi2EventInfo {
        newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
        valuesOfContinuousStatesChanged, nextEventTimeDefined, nextEventTime
    }
}

/// The constants of the header have a prefix in the bindings: the name of their enumeration.
macro_rules! same_value {
    ($($own:ident = $other:ident,)*) => {
        $(const _: () = assert!(header::$own == standard::$other);)*
    };
}

same_value! {
    fmi2OK = fmi2Status_fmi2OK,
    fmi2Warning = fmi2Status_fmi2Warning,
    fmi2Discard = fmi2Status_fmi2Discard,
    fmi2Error = fmi2Status_fmi2Error,
    fmi2Fatal = fmi2Status_fmi2Fatal,
    fmi2ModelExchange = fmi2Type_fmi2ModelExchange,
    fmi2CoSimulation = fmi2Type_fmi2CoSimulation,
    fmi2DoStepStatus = fmi2StatusKind_fmi2DoStepStatus,
    fmi2LastSuccessfulTime = fmi2StatusKind_fmi2LastSuccessfulTime,
    fmi2Terminated = fmi2StatusKind_fmi2Terminated,
}

#[test]
fn platform_and_version_are_those_of_the_header() {
    // Safety: both are strings that end with a zero byte and live for ever.
    let strings = unsafe { [fmi2GetTypesPlatform(), fmi2GetVersion()] };
    let expected = [&standard::fmi2TypesPlatform[..], &standard::fmi2Version[..]];
    for (string, expected) in strings.into_iter().zip(expected) {
        let string = unsafe { std::ffi::CStr::from_ptr(string) };
        assert_eq!(string.to_bytes_with_nul(), expected);
    }
}
