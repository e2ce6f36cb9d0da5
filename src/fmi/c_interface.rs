//! The C interface of FMI 2.0: the one file with unsafe code.
//!
//! Every function runs inside `call`, which refuses null components and wrong states, turns a
//! panic into fmi2Fatal, and reports to the host's logger. The compiler compares each signature with
//! the type that the standard's header gives it (`TYPE`).
//!
//! # Safety
//! All functions ask of the host what the standard asks: a component is null or came from
//! fmi2Instantiate and was not freed, arrays hold as many items as said (null only with none), strings
//! end with a zero byte, and one instance is used by one thread at a time. Every
//! `unsafe fn` below relies on that where it follows a pointer; it is stated this once.
#![allow(
    unsafe_code,
    unsafe_op_in_unsafe_fn,
    non_snake_case,
    clippy::missing_safety_doc
)]

use std::ffi::CString;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use ::fmi::fmi2::binding::*;
use libc::c_char;

use super::boundary::{
    c_string, check_array, expect_status, instantiate, no_strings, none_of, status,
};
use super::instance::Instance;
use super::lifecycle::{Function, State};
use super::report::{EVENTS, Event, Refusal, Severity, Wanted};
use super::resources;
use super::variables::Kind;

/// What a fmi2Component points to.
struct Component {
    instance: Instance,
    log: Log,
}

impl Component {
    /// Moves the component to C's memory, since C holds it from now on: a host that watches its
    /// allocations sees it, and where there is no memory left the answer is null.
    unsafe fn hand_over(self) -> fmi2Component {
        const { assert!(align_of::<Component>() <= align_of::<f64>()) }; // malloc serves any C type
        let place = libc::malloc(size_of::<Component>()).cast::<Component>();
        if !place.is_null() {
            place.write(self);
        }
        place.cast()
    }

    /// Ends the component at `c`, which came from [`Component::hand_over`].
    unsafe fn free(c: fmi2Component) {
        ptr::drop_in_place(c.cast::<Component>());
        libc::free(c);
    }
}

/// The host's logger. The callbacks are copied: their struct is valid during fmi2Instantiate alone.
struct Log {
    logger: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    name: CString,
    wanted: Wanted,
}

impl Log {
    /// In the category of `severity`.
    fn refused(&self, severity: Severity, text: &str) {
        self.write(status(severity), severity.category(), text);
    }

    fn write(&self, status: fmi2Status, category: &str, text: &str) {
        let (Some(logger), true) = (self.logger, self.wanted.contains(category)) else {
            return;
        };
        // '#' starts a reference to a variable in a message, '##' is the character.
        let text = c_string(&text.replace('#', "##"));
        let category = c_string(category);
        // Safety: the logger is the host's; the format takes one string, and all strings outlive it.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

/// Runs `body` for the function `name` on the component `c`.
unsafe fn call(
    c: fmi2Component,
    function: Function,
    name: &str,
    body: impl FnOnce(&mut Component) -> Result<(), Refusal>,
) -> fmi2Status {
    let Some(component) = c.cast::<Component>().as_mut() else {
        return fmi2Status_fmi2Error;
    };
    if component.instance.state() == State::Fatal {
        return fmi2Status_fmi2Fatal;
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        component.instance.admit(function, name)?;
        body(component)
    }))
    .unwrap_or_else(|panic| Err(Refusal::fatal(name, &*panic)));
    for event in component.instance.take_events() {
        match event {
            Event::Told(text) => component.log.write(fmi2Status_fmi2OK, EVENTS, &text),
            Event::Warned(text) => component.log.refused(Severity::Warning, &text),
        }
    }
    let Err(refusal) = outcome else {
        return fmi2Status_fmi2OK;
    };
    component.instance.fail(refusal.severity);
    component.log.refused(refusal.severity, &refusal.message);
    status(refusal.severity)
}

/// The host's array of `count` items at `data`; null is legal for none.
unsafe fn array<'a, T>(data: *const T, count: usize, what: &str) -> Result<&'a [T], Refusal> {
    check_array(data, count, what)?;
    if count == 0 {
        return Ok(&[]);
    }
    Ok(std::slice::from_raw_parts(data, count))
}

/// As [`array`], to be written.
unsafe fn array_mut<'a, T>(
    data: *mut T,
    count: usize,
    what: &str,
) -> Result<&'a mut [MaybeUninit<T>], Refusal> {
    check_array(data, count, what)?;
    if count == 0 {
        return Ok(&mut []);
    }
    Ok(std::slice::from_raw_parts_mut(data.cast(), count)) // MaybeUninit asks nothing of it
}

/// Writes results to the host's array of `count`.
unsafe fn put_all<T>(
    places: *mut T,
    count: usize,
    values: impl IntoIterator<Item = T>,
) -> Result<(), Refusal> {
    for (place, value) in array_mut(places, count, "the place for results")?
        .iter_mut()
        .zip(values)
    {
        place.write(value);
    }
    Ok(())
}

/// Writes one result to the host.
unsafe fn put<T>(place: *mut T, value: T) -> Result<(), Refusal> {
    put_all(place, 1, [value])
}

/// Bytes after which a host's string must have ended.
const LONGEST_TEXT: usize = 1 << 16;

/// The host's string.
unsafe fn text<'a>(data: *const c_char, what: &str) -> Result<&'a str, Refusal> {
    let refuse = |reason: &str| Err(Refusal::error(format!("{what} {reason}")));
    if data.is_null() {
        return refuse("is null");
    }
    let length = libc::strnlen(data, LONGEST_TEXT);
    if length == LONGEST_TEXT {
        return refuse("does not end within 65536 bytes");
    }
    let bytes = std::slice::from_raw_parts(data.cast::<u8>(), length);
    std::str::from_utf8(bytes).or_else(|_| refuse("is not UTF-8"))
}

/// Exports functions that take a component and return a status, each checked against its type in the
/// standard's header.
macro_rules! export {
    ($($(#[$doc:meta])* fn $name:ident: $type:ident, $function:ident
        ($c:ident $(, $arg:ident: $arg_type:ty)* $(,)?) $body:block)*) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: fmi2Component $(, $arg: $arg_type)*) -> fmi2Status {
            call(c, Function::$function, stringify!($name), |$c| $body)
        }
        const _: $type = Some($name);
    )*};
}

/// The platform of the types, "default".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    fmi2TypesPlatform.as_ptr().cast()
}
const _: fmi2GetTypesPlatformTYPE = Some(fmi2GetTypesPlatform);

/// The version of the interface, "2.0".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetVersion() -> *const c_char {
    fmi2Version.as_ptr().cast()
}
const _: fmi2GetVersionTYPE = Some(fmi2GetVersion);

/// A new instance, or null with the reason in the log.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    let made = catch_unwind(|| {
        // Null or the host's callbacks, valid during this call.
        let callbacks = functions.as_ref();
        let name = text(instanceName, "instanceName");
        let log = Log {
            logger: callbacks.and_then(|f| f.logger),
            environment: callbacks.map_or(ptr::null_mut(), |f| f.componentEnvironment),
            name: c_string(name.as_ref().map_or("", |n| n)),
            wanted: Wanted::new(loggingOn != 0),
        };
        let instance = name.and_then(|name| {
            let guid = text(fmuGUID, "fmuGUID")?;
            let location = text(fmuResourceLocation, "fmuResourceLocation")?;
            instantiate(fmuType, name, guid, location)
        });
        match instance {
            Ok(instance) => Component { instance, log }.hand_over(),
            Err(refusal) => {
                let message = format!("fmi2Instantiate: {refusal}");
                log.write(fmi2Status_fmi2Error, Severity::Error.category(), &message);
                ptr::null_mut()
            }
        }
    });
    made.unwrap_or(ptr::null_mut())
}
const _: fmi2InstantiateTYPE = Some(fmi2Instantiate);

/// Frees the instance with all its stored states; null is no instance and nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    if c.is_null() {
        return;
    }
    // From fmi2Instantiate, not freed before. A panic ends here: the function has no status to return.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        Component::free(c);
        resources::release();
    }));
}
const _: fmi2FreeInstanceTYPE = Some(fmi2FreeInstance);

/// Copies Integer, Enumeration or Boolean values, all of them C's int, to the host.
unsafe fn get(
    c: &mut Component,
    function: &str,
    kind: Kind,
    (vr, nvr): (*const fmi2ValueReference, usize),
    value: *mut fmi2Integer,
) -> Result<(), Refusal> {
    let references = array(vr, nvr, "vr")?.iter().copied();
    let mut places = array_mut(value, nvr, "value")?.iter_mut();
    c.instance.get_discrete(function, kind, references, |v| {
        if let Some(place) = places.next() {
            place.write(v);
        }
    })
}

/// Sets Enumeration or Boolean variables to the host's values.
unsafe fn set(
    c: &mut Component,
    function: &str,
    kind: Kind,
    (vr, nvr): (*const fmi2ValueReference, usize),
    value: *const fmi2Integer,
) -> Result<(), Refusal> {
    let values = array(value, nvr, "value")?.iter().copied();
    let references = array(vr, nvr, "vr")?.iter().copied();
    c.instance
        .set_discrete(function, kind, references.zip(values))
}

export! {
    /// Switches log categories, all of them if none is named.
    fn fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE, SetDebugLogging
        (c, on: fmi2Boolean, count: usize, categories: *const fmi2String) {
        let names = array(categories, count, "categories")?.iter();
        let names = names.map(|name| text(*name, "a log category"));
        c.log.wanted.switch(on != 0, &names.collect::<Result<Vec<_>, _>>()?)
    }
    /// Start and stop time; the tolerance is of no use here, since nothing is integrated.
    fn fmi2SetupExperiment: fmi2SetupExperimentTYPE, SetupExperiment
        (c, _tolerance_defined: fmi2Boolean, _tolerance: fmi2Real, start: fmi2Real,
         stop_defined: fmi2Boolean, stop: fmi2Real) {
        c.instance.setup(start, (stop_defined != 0).then_some(stop))
    }
    /// Opens the initialization.
    fn fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE, EnterInitializationMode (c) {
        c.instance.enter(State::InitializationMode);
        Ok(())
    }
    /// Closes the initialization: checks the parameters and latches the phases of the teeth.
    fn fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE, ExitInitializationMode (c) {
        c.instance.exit_initialization()
    }
    /// Ends the simulation.
    fn fmi2Terminate: fmi2TerminateTYPE, Terminate (c) {
        c.instance.enter(State::Terminated);
        Ok(())
    }
    /// Back to the state after fmi2Instantiate.
    fn fmi2Reset: fmi2ResetTYPE, Reset (c) {
        c.instance.reset();
        Ok(())
    }
    /// Values of Real variables.
    fn fmi2GetReal: fmi2GetRealTYPE, Get
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Real) {
        let references = array(vr, nvr, "vr")?;
        if let Some(values) = c.instance.outputs_at_hand(references) {
            return put_all(value, nvr, values.iter().copied());
        }
        let mut places = array_mut(value, nvr, "value")?.iter_mut();
        c.instance.get_real(references.iter().copied(), |v| {
            if let Some(place) = places.next() {
                place.write(v);
            }
        })
    }
    /// Values of Integer and Enumeration variables.
    fn fmi2GetInteger: fmi2GetIntegerTYPE, Get
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer) {
        get(c, "fmi2GetInteger", Kind::Integer, (vr, nvr), value)
    }
    /// Values of Boolean variables.
    fn fmi2GetBoolean: fmi2GetBooleanTYPE, Get
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean) {
        get(c, "fmi2GetBoolean", Kind::Boolean, (vr, nvr), value)
    }
    /// Refuses any variable: there are none of type String.
    fn fmi2GetString: fmi2GetStringTYPE, Get
        (_c, vr: *const fmi2ValueReference, nvr: usize, _value: *mut fmi2String) {
        no_strings("fmi2GetString", array(vr, nvr, "vr")?)
    }
    /// Sets Real inputs and parameters.
    fn fmi2SetReal: fmi2SetRealTYPE, SetReal
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Real) {
        c.instance.set_real(array(vr, nvr, "vr")?, array(value, nvr, "value")?)
    }
    /// Sets Enumeration parameters.
    fn fmi2SetInteger: fmi2SetIntegerTYPE, SetDiscrete
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer) {
        set(c, "fmi2SetInteger", Kind::Integer, (vr, nvr), value)
    }
    /// Sets Boolean parameters.
    fn fmi2SetBoolean: fmi2SetBooleanTYPE, SetDiscrete
        (c, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean) {
        set(c, "fmi2SetBoolean", Kind::Boolean, (vr, nvr), value)
    }
    /// Refuses any variable: there are none of type String.
    fn fmi2SetString: fmi2SetStringTYPE, SetDiscrete
        (_c, vr: *const fmi2ValueReference, nvr: usize, _value: *const fmi2String) {
        no_strings("fmi2SetString", array(vr, nvr, "vr")?)
    }
    /// Keeps the state, in the place of the given one if that is not null. A fmi2FMUstate is a number
    /// here, not an address.
    fn fmi2GetFMUstate: fmi2GetFMUstateTYPE, FmuState (c, state: *mut fmi2FMUstate) {
        check_array(state, 1, "FMUstate")?;
        let kept = c.instance.store(Some((*state).addr()).filter(|h| *h != 0))?;
        put(state, ptr::without_provenance_mut(kept))
    }
    /// Goes back to a kept state.
    fn fmi2SetFMUstate: fmi2SetFMUstateTYPE, FmuState (c, state: fmi2FMUstate) {
        c.instance.restore(state.addr())
    }
    /// Frees a kept state and sets it to null; null is no state and nothing happens.
    fn fmi2FreeFMUstate: fmi2FreeFMUstateTYPE, FmuState (c, state: *mut fmi2FMUstate) {
        if !state.is_null() && !(*state).is_null() {
            c.instance.discard((*state).addr())?;
            *state = ptr::null_mut();
        }
        Ok(())
    }
    /// Bytes that a kept state takes.
    fn fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE, FmuState
        (c, state: fmi2FMUstate, size: *mut usize) {
        put(size, c.instance.serialize(state.addr())?.len())
    }
    /// Writes a kept state as bytes.
    fn fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE, FmuState
        (c, state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize) {
        let written = c.instance.serialize(state.addr())?;
        if size < written.len() {
            let needed = written.len();
            return Err(Refusal::error(format!("size = {size}; the state takes {needed} bytes")));
        }
        put_all(bytes, size, written.into_iter().map(|byte| byte as fmi2Byte))
    }
    /// Reads a state that this unit wrote, in this process or another one.
    fn fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE, FmuState
        (c, bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate) {
        let bytes = array(bytes.cast::<u8>(), size, "serializedState")?;
        check_array(state, 1, "FMUstate")?;
        put(state, ptr::without_provenance_mut(c.instance.deserialize(bytes)?))
    }
    /// Exact partial derivatives of outputs by inputs, times the seed.
    fn fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE, GetDirectionalDerivative
        (c, unknown: *const fmi2ValueReference, nUnknown: usize, known: *const fmi2ValueReference,
         nKnown: usize, dvKnown: *const fmi2Real, dvUnknown: *mut fmi2Real) {
        let known = array(known, nKnown, "vKnown_ref")?.iter().copied();
        let seed = array(dvKnown, nKnown, "dvKnown")?.iter().copied();
        let unknown = array(unknown, nUnknown, "vUnknown_ref")?;
        put_all(dvUnknown, nUnknown, c.instance.directional_derivative(unknown, known.zip(seed))?)
    }
    /// Time derivatives of inputs at the start of the next step.
    fn fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE, SetInputDerivatives
        (c, vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer,
         value: *const fmi2Real) {
        let orders = array(order, nvr, "order")?.iter().copied();
        let values = array(value, nvr, "value")?.iter().copied();
        let items = array(vr, nvr, "vr")?.iter().copied().zip(orders).zip(values);
        c.instance.set_input_derivatives(items.map(|((vr, order), value)| (vr, order, value)))
    }
    /// First time derivatives of outputs at the end of the last step.
    fn fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE, GetOutputDerivatives
        (c, vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer,
         value: *mut fmi2Real) {
        let orders = array(order, nvr, "order")?.iter().copied();
        let items = array(vr, nvr, "vr")?.iter().copied().zip(orders);
        put_all(value, nvr, c.instance.output_derivatives(items)?)
    }
    /// One communication step.
    fn fmi2DoStep: fmi2DoStepTYPE, DoStep
        (c, point: fmi2Real, step: fmi2Real, _no_set_state_prior: fmi2Boolean) {
        c.instance.do_step(point, step)
    }
    /// Refused: a step is never in progress when a call returns.
    fn fmi2CancelStep: fmi2CancelStepTYPE, CancelStep (_c) {
        Ok(())
    }
    /// Status of the last step; pending steps there are none.
    fn fmi2GetStatus: fmi2GetStatusTYPE, GetStatus
        (c, kind: fmi2StatusKind, value: *mut fmi2Status) {
        expect_status(kind, fmi2StatusKind_fmi2DoStepStatus, "fmi2GetStatus")?;
        let failed = c.instance.state() == State::Error;
        put(value, if failed { fmi2Status_fmi2Error } else { fmi2Status_fmi2OK })
    }
    /// Time up to which the last step came.
    fn fmi2GetRealStatus: fmi2GetRealStatusTYPE, GetStatus
        (c, kind: fmi2StatusKind, value: *mut fmi2Real) {
        expect_status(kind, fmi2StatusKind_fmi2LastSuccessfulTime, "fmi2GetRealStatus")?;
        put(value, c.instance.time())
    }
    /// Discards: there is no status of type Integer.
    fn fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE, GetStatus
        (_c, kind: fmi2StatusKind, _value: *mut fmi2Integer) {
        expect_status(kind, fmi2StatusKind::MAX, "fmi2GetIntegerStatus")
    }
    /// Whether the unit wants to end the simulation: never.
    fn fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE, GetStatus
        (_c, kind: fmi2StatusKind, value: *mut fmi2Boolean) {
        expect_status(kind, fmi2StatusKind_fmi2Terminated, "fmi2GetBooleanStatus")?;
        put(value, 0)
    }
    /// Discards: there is no pending step to tell about.
    fn fmi2GetStringStatus: fmi2GetStringStatusTYPE, GetStatus
        (_c, kind: fmi2StatusKind, _value: *mut fmi2String) {
        expect_status(kind, fmi2StatusKind::MAX, "fmi2GetStringStatus")
    }
    /// The host handles an event: inputs and tunable parameters may jump.
    fn fmi2EnterEventMode: fmi2EnterEventModeTYPE, EnterEventMode (c) {
        c.instance.enter(State::EventMode);
        Ok(())
    }
    /// There are no discrete states: one iteration is enough, and no event is to come.
    fn fmi2NewDiscreteStates: fmi2NewDiscreteStatesTYPE, NewDiscreteStates
        (_c, info: *mut fmi2EventInfo) {
        put(info, fmi2EventInfo {
            newDiscreteStatesNeeded: 0,
            terminateSimulation: 0,
            nominalsOfContinuousStatesChanged: 0,
            valuesOfContinuousStatesChanged: 0,
            nextEventTimeDefined: 0,
            nextEventTime: 0.0,
        })
    }
    /// The host integrates.
    fn fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE, EnterContinuousTimeMode (c) {
        c.instance.enter(State::ContinuousTimeMode);
        Ok(())
    }
    /// Asks for nothing, and need not be called: outputs depend on nothing that came before.
    fn fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE, CompletedIntegratorStep
        (_c, _no_set_state_prior: fmi2Boolean, event: *mut fmi2Boolean, end: *mut fmi2Boolean) {
        put(event, 0)?;
        put(end, 0)
    }
    /// The time, on which nothing depends.
    fn fmi2SetTime: fmi2SetTimeTYPE, SetTime (c, time: fmi2Real) {
        c.instance.set_time(time)
    }
    /// There are no continuous states.
    fn fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE, SetContinuousStates
        (_c, _x: *const fmi2Real, nx: usize) {
        none_of(nx, "continuous states")
    }
    /// There are no continuous states.
    fn fmi2GetDerivatives: fmi2GetDerivativesTYPE, GetStates
        (_c, _derivatives: *mut fmi2Real, nx: usize) {
        none_of(nx, "derivatives of continuous states")
    }
    /// There are no event indicators.
    fn fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE, GetEventIndicators
        (_c, _indicators: *mut fmi2Real, ni: usize) {
        none_of(ni, "event indicators")
    }
    /// There are no continuous states.
    fn fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE, GetStates
        (_c, _x: *mut fmi2Real, nx: usize) {
        none_of(nx, "continuous states")
    }
    /// There are no continuous states.
    fn fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE, GetStates
        (_c, _nominals: *mut fmi2Real, nx: usize) {
        none_of(nx, "nominals of continuous states")
    }
}

#[cfg(test)]
#[path = "c_interface_tests.rs"]
mod tests;
