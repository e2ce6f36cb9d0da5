//! Types and constants of the FMI 2.0 standard (fmi2TypesPlatform.h, fmi2FunctionTypes.h), as far as the unit and its
//! callers need them; names and layout are the standard's.
//!
//! They are spelled out here so that whoever builds the library needs neither a C compiler's headers nor libclang. The
//! tests compare every function and layout with bindings made from the headers themselves.
#![allow(non_camel_case_types, non_snake_case, non_upper_case_globals)]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};

/// What fmi2GetTypesPlatform answers.
pub const fmi2TypesPlatform: &CStr = c"default";
/// What fmi2GetVersion answers.
pub const fmi2Version: &CStr = c"2.0";

/// An instance of the unit.
pub type fmi2Component = *mut c_void;
/// What the host's callbacks take back.
pub type fmi2ComponentEnvironment = *mut c_void;
/// A kept state.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// Real.
pub type fmi2Real = f64;
/// Integer and enumeration.
pub type fmi2Integer = c_int;
/// Boolean: [`fmi2True`] or [`fmi2False`].
pub type fmi2Boolean = c_int;
/// Character.
pub type fmi2Char = c_char;
/// Text that a zero byte ends, UTF-8.
pub type fmi2String = *const fmi2Char;
/// Part of a serialised state.
pub type fmi2Byte = c_char;

/// No.
pub const fmi2False: fmi2Boolean = 0;
/// Yes.
pub const fmi2True: fmi2Boolean = 1;

/// What a call returns: one of the six that follow.
pub type fmi2Status = c_uint;
/// All well.
pub const fmi2Status_fmi2OK: fmi2Status = 0;
/// Done, with something to say.
pub const fmi2Status_fmi2Warning: fmi2Status = 1;
/// Not possible here; a shorter step may be.
pub const fmi2Status_fmi2Discard: fmi2Status = 2;
/// Refused; the instance needs a reset or an earlier state.
pub const fmi2Status_fmi2Error: fmi2Status = 3;
/// The instance is lost.
pub const fmi2Status_fmi2Fatal: fmi2Status = 4;
/// Under way, which nothing here ever is.
pub const fmi2Status_fmi2Pending: fmi2Status = 5;

/// Interface of an instance.
pub type fmi2Type = c_uint;
/// The host integrates.
pub const fmi2Type_fmi2ModelExchange: fmi2Type = 0;
/// The unit steps.
pub const fmi2Type_fmi2CoSimulation: fmi2Type = 1;

/// What fmi2GetStatus and its relatives are asked for.
pub type fmi2StatusKind = c_uint;
/// Of fmi2GetStatus.
pub const fmi2StatusKind_fmi2DoStepStatus: fmi2StatusKind = 0;
/// Of fmi2GetStringStatus.
pub const fmi2StatusKind_fmi2PendingStatus: fmi2StatusKind = 1;
/// Of fmi2GetRealStatus.
pub const fmi2StatusKind_fmi2LastSuccessfulTime: fmi2StatusKind = 2;
/// Of fmi2GetBooleanStatus.
pub const fmi2StatusKind_fmi2Terminated: fmi2StatusKind = 3;

/// The host's logger: environment, name of the instance, status, category, format as printf has it, its arguments.
pub type fmi2CallbackLogger = Option<
    unsafe extern "C" fn(
        fmi2ComponentEnvironment,
        fmi2String,
        fmi2Status,
        fmi2String,
        fmi2String,
        ...
    ),
>;
/// The host's allocation: number and size of objects.
pub type fmi2CallbackAllocateMemory = Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>;
/// Its counterpart.
pub type fmi2CallbackFreeMemory = Option<unsafe extern "C" fn(*mut c_void)>;
/// Called at the end of a step that was pending.
pub type fmi2StepFinished = Option<unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2Status)>;

/// What the host offers the unit.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct fmi2CallbackFunctions {
    /// May be absent.
    pub logger: fmi2CallbackLogger,
    /// Not used here.
    pub allocateMemory: fmi2CallbackAllocateMemory,
    /// Not used here.
    pub freeMemory: fmi2CallbackFreeMemory,
    /// Not used here.
    pub stepFinished: fmi2StepFinished,
    /// For the logger.
    pub componentEnvironment: fmi2ComponentEnvironment,
}

/// What fmi2NewDiscreteStates answers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct fmi2EventInfo {
    /// Whether it must be called again.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// Whether the unit asks for the end.
    pub terminateSimulation: fmi2Boolean,
    /// Whether fmi2GetNominalsOfContinuousStates has something new.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// Whether fmi2GetContinuousStates has something new.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// Whether the next one counts.
    pub nextEventTimeDefined: fmi2Boolean,
    /// Of the next event in time, s.
    pub nextEventTime: fmi2Real,
}
