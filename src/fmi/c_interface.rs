//! The C interface of FMI 2.0: the one file with unsafe code.
//!
//! Every function that takes a component runs inside `call`, which refuses null components and wrong states, turns a
//! panic into fmi2Fatal, and reports to the host's logger. What a function does is in [`super::instance`];
//! tests/header.rs compares each signature with the standard's header.
//!
//! # Safety
//! All functions require of the host what the standard requires: a component is null or came from
//! fmi2Instantiate and was not freed, arrays hold as many items as passed (null only with none), strings
//! end with a zero byte, and one instance is used by one thread at a time. Every
//! `unsafe fn` below relies on that where it follows a pointer; it is stated this once.
#![allow(
    unsafe_code,
    unsafe_op_in_unsafe_fn,
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc
)]

use std::any::Any;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use super::header::*;
use super::instance::Instance;
use super::lifecycle::{Function, Interface, State};
use super::resources;
use super::variables::LOG_CATEGORIES;
use super::{Refusal, Severity};

/// What a fmi2Component points to.
struct Component {
    instance: Instance,
    log: Log,
}

/// Log category of events.
const EVENTS: &str = "logEvents";

/// The host's logger. The callbacks are copied: their struct is valid during fmi2Instantiate alone.
struct Log {
    logger: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    name: CString,
    /// Which of [`LOG_CATEGORIES`] are on.
    is_on: [bool; LOG_CATEGORIES.len()],
}

impl Log {
    /// What `loggingOn` and fmi2SetDebugLogging without categories mean by debug logging is events alone: why a call was
    /// refused reaches the logger until the host switches that category off by its name.
    fn categories(debug: bool) -> [bool; LOG_CATEGORIES.len()] {
        LOG_CATEGORIES.map(|category| debug || category != EVENTS)
    }

    /// fmi2SetDebugLogging: switches `names`; without any, all of them on, or debug logging off. Nothing is changed if
    /// modelDescription.xml lacks one of them.
    fn switch(&mut self, on: bool, names: &[&str]) -> Result<(), Refusal> {
        let names = match (names, on) {
            ([], true) => &LOG_CATEGORIES[..],
            ([], false) => &[EVENTS],
            _ => names,
        };
        if let Some(unknown) = names.iter().find(|name| !LOG_CATEGORIES.contains(name)) {
            let known = LOG_CATEGORIES.join(", ");
            return Err(Refusal::error(format!(
                "log category '{unknown}' is none of {known}"
            )));
        }
        for (category, is_on) in LOG_CATEGORIES.iter().zip(&mut self.is_on) {
            if names.contains(category) {
                *is_on = on;
            }
        }
        Ok(())
    }

    fn write(&self, severity: Severity, text: &str) {
        let category = category(severity);
        let mut categories = LOG_CATEGORIES.iter().zip(self.is_on);
        let is_on = categories.any(|(name, is_on)| is_on && *name == category);
        let (Some(logger), true) = (self.logger, is_on) else {
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
                severity as fmi2Status,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

/// Log category of a message.
const fn category(severity: Severity) -> &'static str {
    match severity {
        Severity::Event => EVENTS,
        Severity::Warning => "logStatusWarning",
        Severity::Discard => "logStatusDiscard",
        Severity::Error => "logStatusError",
        Severity::Fatal => "logStatusFatal",
    }
}

/// `text` as a C string; a zero byte inside it ends it.
fn c_string(text: &str) -> CString {
    CString::new(text.split('\0').next().unwrap_or("")).unwrap_or_default()
}

/// The message of a panic.
fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown cause")
}

/// Runs `body` for `function` on the component `c`.
unsafe fn call(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Component) -> Result<(), Refusal>,
) -> fmi2Status {
    let Some(component) = c.cast::<Component>().as_mut() else {
        return fmi2Error;
    };
    if component.instance.state() == State::Fatal {
        return fmi2Fatal;
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        component.instance.admit(function)?;
        body(component)
    }))
    .unwrap_or_else(|panic| {
        Err(Refusal {
            severity: Severity::Fatal,
            message: format!("{function}: internal error: {}", panic_text(&*panic)),
        })
    });
    for (severity, text) in component.instance.take_events() {
        component.log.write(severity, &text);
    }
    let Err(mut refusal) = outcome else {
        return fmi2OK;
    };
    component.instance.fail(&mut refusal);
    let Refusal { severity, message } = refusal;
    component.log.write(severity, &message);
    severity as fmi2Status
}

/// Refuses what cannot be an array of `count` items; null is legal for none.
fn check_array<T>(data: *const T, count: usize, what: &str) -> Result<(), Refusal> {
    let most = isize::MAX as usize / size_of::<T>().max(1);
    if count > 0 && (data.is_null() || !data.is_aligned() || count > most) {
        return Err(Refusal::error(format!(
            "{what} is no array of {count} items: null, not aligned, or too long"
        )));
    }
    Ok(())
}

/// The host's array of `count` items at `data`; null is legal for none.
unsafe fn array<'a, T>(data: *const T, count: usize, what: &str) -> Result<&'a [T], Refusal> {
    check_array(data, count, what)?;
    if count == 0 {
        return Ok(&[]);
    }
    Ok(std::slice::from_raw_parts(data, count))
}

/// Writes into the host's array of `count` items at `data`, which may be uninitialised: from the first on at each call.
unsafe fn writer<T>(mut data: *mut T, count: usize) -> Result<impl FnMut(T), Refusal> {
    check_array(data, count, "the array for results")?;
    let end = data.wrapping_add(count);
    Ok(move |value| {
        if data < end {
            data.write(value);
            data = data.wrapping_add(1);
        }
    })
}

/// Writes results to the host's array of `count`.
unsafe fn put_all<T>(
    data: *mut T,
    count: usize,
    values: impl IntoIterator<Item = T>,
) -> Result<(), Refusal> {
    values.into_iter().for_each(writer(data, count)?);
    Ok(())
}

/// Writes one result to the host.
unsafe fn put<T>(data: *mut T, value: T) -> Result<(), Refusal> {
    put_all(data, 1, [value])
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

/// Takes the instance to `state`.
unsafe fn enter(c: fmi2Component, function: Function, state: State) -> fmi2Status {
    call(c, function, |c| {
        c.instance.enter(state);
        Ok(())
    })
}

/// Copies values to the host.
unsafe fn get<T>(
    c: fmi2Component,
    function: Function,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut T,
    convert: impl Fn(f64) -> T,
) -> fmi2Status {
    call(c, function, |c| {
        let mut put = writer(value, nvr)?;
        let references = array(vr, nvr, "vr")?;
        c.instance.get(function, references, |x| put(convert(x)))
    })
}

/// Sets variables to the host's values.
unsafe fn set<T: Copy + Into<f64>>(
    c: fmi2Component,
    function: Function,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const T,
) -> fmi2Status {
    call(c, function, |c| {
        let (references, values) = (array(vr, nvr, "vr")?, array(value, nvr, "value")?);
        c.instance.set(function, references, values)
    })
}

/// Refuses any variable: there are none of type String.
unsafe fn no_strings(
    c: fmi2Component,
    function: Function,
    vr: *const fmi2ValueReference,
    nvr: usize,
) -> fmi2Status {
    call(c, function, |c| {
        c.instance.get(function, array(vr, nvr, "vr")?, drop)
    })
}

/// The answer to the one question of this type that the FMU has a status for, if `kind` is that one.
unsafe fn get_status<T>(
    c: fmi2Component,
    function: Function,
    kind: fmi2StatusKind,
    known: Option<fmi2StatusKind>,
    value: *mut T,
    answer: impl FnOnce(&Instance) -> T,
) -> fmi2Status {
    call(c, function, |c| {
        if Some(kind) == known {
            return put(value, answer(&c.instance));
        }
        Err(Refusal::discard(format!(
            "{function}: the FMU has no status of kind {kind}"
        )))
    })
}

/// Refuses any item: there are no continuous states and no event indicators.
unsafe fn none_of(c: fmi2Component, function: Function, count: usize) -> fmi2Status {
    call(c, function, |_| match count {
        0 => Ok(()),
        _ => Err(Refusal::error(format!(
            "{function}: {count} items; this FMU has no continuous states and no event indicators"
        ))),
    })
}

/// What fmi2GetStatus says of the last step.
fn status_of_step(instance: &Instance) -> fmi2Status {
    match instance.state() {
        State::Error => fmi2Error,
        _ => fmi2OK,
    }
}

/// Exports that pass their arguments on to one of the functions above: `name(arguments) = function(what it gets)`.
macro_rules! exports {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) = $function:ident($which:ident $(, $passed:expr)*);)+) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: fmi2Component $(, $argument: $type)*) -> fmi2Status {
            $function(c, Function::$which $(, $passed)*)
        }
    )+};
}

type References = *const fmi2ValueReference;

exports! {
    /// Opens the initialization.
    fmi2EnterInitializationMode() = enter(EnterInitializationMode, State::InitializationMode);
    /// Closes the initialization: checks the parameters and takes the phases of the teeth.
    fmi2ExitInitializationMode() = call(ExitInitializationMode, |c| c.instance.exit_initialization());
    /// Ends the simulation.
    fmi2Terminate() = enter(Terminate, State::Terminated);
    /// Back to the state after fmi2Instantiate.
    fmi2Reset() = call(Reset, |c| { c.instance.reset(); Ok(()) });
    /// The host handles an event: inputs and tunable parameters may jump.
    fmi2EnterEventMode() = enter(EnterEventMode, State::EventMode);
    /// The host integrates.
    fmi2EnterContinuousTimeMode() = enter(EnterContinuousTimeMode, State::ContinuousTimeMode);

    /// Values of Real variables.
    fmi2GetReal(vr: References, nvr: usize, value: *mut fmi2Real) = get(GetReal, vr, nvr, value, |x| x);
    /// Values of Integer and Enumeration variables.
    fmi2GetInteger(vr: References, nvr: usize, value: *mut fmi2Integer) =
        get(GetInteger, vr, nvr, value, |x| x as i32);
    /// Values of Boolean variables.
    fmi2GetBoolean(vr: References, nvr: usize, value: *mut fmi2Boolean) =
        get(GetBoolean, vr, nvr, value, |x| x as i32);
    /// Refuses any variable: there are none of type String.
    fmi2GetString(vr: References, nvr: usize, _value: *mut fmi2String) = no_strings(GetString, vr, nvr);
    /// Sets Real inputs and parameters.
    fmi2SetReal(vr: References, nvr: usize, value: *const fmi2Real) = set(SetReal, vr, nvr, value);
    /// Sets Enumeration parameters.
    fmi2SetInteger(vr: References, nvr: usize, value: *const fmi2Integer) = set(SetInteger, vr, nvr, value);
    /// Sets Boolean parameters.
    fmi2SetBoolean(vr: References, nvr: usize, value: *const fmi2Boolean) = set(SetBoolean, vr, nvr, value);
    /// Refuses any variable: there are none of type String.
    fmi2SetString(vr: References, nvr: usize, _value: *const fmi2String) = no_strings(SetString, vr, nvr);

    /// Goes back to a stored state.
    fmi2SetFMUstate(state: fmi2FMUstate) = call(SetFMUstate, |c| c.instance.restore(state.addr()));
    /// Bytes that a stored state takes.
    fmi2SerializedFMUstateSize(state: fmi2FMUstate, size: *mut usize) =
        call(SerializedFMUstateSize, |c| put(size, c.instance.serialize(state.addr())?.len()));

    /// One communication step.
    fmi2DoStep(point: fmi2Real, step: fmi2Real, _no_set_state_prior: fmi2Boolean) =
        call(DoStep, |c| c.instance.do_step(point, step));
    /// Refused: a step is never in progress when a call returns.
    fmi2CancelStep() = call(CancelStep, |_| Ok(()));
    /// Status of the last step; pending steps there are none.
    fmi2GetStatus(kind: fmi2StatusKind, value: *mut fmi2Status) =
        get_status(GetStatus, kind, Some(fmi2DoStepStatus), value, status_of_step);
    /// Time up to which the last step came.
    fmi2GetRealStatus(kind: fmi2StatusKind, value: *mut fmi2Real) =
        get_status(GetRealStatus, kind, Some(fmi2LastSuccessfulTime), value, Instance::time);
    /// Discards: there is no status of type Integer.
    fmi2GetIntegerStatus(kind: fmi2StatusKind, value: *mut fmi2Integer) =
        get_status(GetIntegerStatus, kind, None, value, |_| 0);
    /// Whether the FMU wants to end the simulation: never.
    fmi2GetBooleanStatus(kind: fmi2StatusKind, value: *mut fmi2Boolean) =
        get_status(GetBooleanStatus, kind, Some(fmi2Terminated), value, |_| 0);
    /// Discards: there is no pending step to report on.
    fmi2GetStringStatus(kind: fmi2StatusKind, value: *mut fmi2String) =
        get_status(GetStringStatus, kind, None, value, |_| ptr::null());

    /// There are no discrete states: one iteration is enough, and no event is to come.
    fmi2NewDiscreteStates(info: *mut fmi2EventInfo) =
        call(NewDiscreteStates, |_| put(info, fmi2EventInfo::default()));
    /// The time, on which nothing depends.
    fmi2SetTime(time: fmi2Real) = call(SetTime, |c| c.instance.set_time(time));
    /// There are no continuous states.
    fmi2SetContinuousStates(_x: *const fmi2Real, nx: usize) = none_of(SetContinuousStates, nx);
    /// There are no continuous states.
    fmi2GetDerivatives(_derivatives: *mut fmi2Real, nx: usize) = none_of(GetDerivatives, nx);
    /// There are no event indicators.
    fmi2GetEventIndicators(_indicators: *mut fmi2Real, ni: usize) = none_of(GetEventIndicators, ni);
    /// There are no continuous states.
    fmi2GetContinuousStates(_x: *mut fmi2Real, nx: usize) = none_of(GetContinuousStates, nx);
    /// There are no continuous states.
    fmi2GetNominalsOfContinuousStates(_nominals: *mut fmi2Real, nx: usize) =
        none_of(GetNominalsOfContinuousStates, nx);
}

/// The platform of the types, "default".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetTypesPlatform() -> fmi2String {
    c"default".as_ptr()
}

/// The version of the interface, "2.0".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetVersion() -> fmi2String {
    c"2.0".as_ptr()
}

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
        let callbacks = functions.as_ref();
        let name = text(instanceName, "instanceName");
        let log = Log {
            logger: callbacks.and_then(|f| f.logger),
            environment: callbacks.map_or(ptr::null_mut(), |f| f.componentEnvironment),
            name: c_string(name.as_ref().map_or("", |n| n)),
            is_on: Log::categories(loggingOn != 0),
        };
        let instance = name.and_then(|name| {
            let guid = text(fmuGUID, "fmuGUID")?;
            let location = text(fmuResourceLocation, "fmuResourceLocation")?;
            instantiate(fmuType, name, guid, location)
        });
        match instance {
            Ok(instance) => Box::into_raw(Box::new(Component { instance, log })).cast(),
            Err(refusal) => {
                log.write(Severity::Error, &format!("fmi2Instantiate: {refusal}"));
                ptr::null_mut()
            }
        }
    });
    made.unwrap_or(ptr::null_mut())
}

/// A new instance for the interface that the host names.
fn instantiate(
    kind: fmi2Type,
    name: &str,
    guid: &str,
    location: &str,
) -> Result<Instance, Refusal> {
    let interface = match kind {
        fmi2ModelExchange => Interface::ModelExchange,
        fmi2CoSimulation => Interface::CoSimulation,
        _ => {
            return Err(Refusal::error(format!(
                "fmuType = {kind}; this FMU is for model exchange ({fmi2ModelExchange}) \
                 and co-simulation ({fmi2CoSimulation})"
            )));
        }
    };
    if name.is_empty() {
        let message = "instanceName is empty; give the instance a name";
        return Err(Refusal::error(message));
    }
    Ok(Instance::new(resources::load(location, guid)?, interface))
}

/// Frees the instance with all its stored states; null is no instance and nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    if c.is_null() {
        return;
    }
    // A panic ends here: the function has no status to return.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        drop(Box::from_raw(c.cast::<Component>()));
        resources::release();
    }));
}

/// Switches log categories, all of them if none is named.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    on: fmi2Boolean,
    count: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    call(c, Function::SetDebugLogging, |c| {
        let names = array(categories, count, "categories")?.iter();
        let names = names.map(|name| text(*name, "a log category"));
        c.log
            .switch(on != 0, &names.collect::<Result<Vec<_>, _>>()?)
    })
}

/// Start and stop time; the tolerance is of no use here, since nothing is integrated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    _tolerance_defined: fmi2Boolean,
    _tolerance: fmi2Real,
    start: fmi2Real,
    stop_defined: fmi2Boolean,
    stop: fmi2Real,
) -> fmi2Status {
    call(c, Function::SetupExperiment, |c| {
        c.instance.setup(start, (stop_defined != 0).then_some(stop))
    })
}

/// Stores the state, over the given one if that is not null. A fmi2FMUstate is a number here, not an address.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    call(c, Function::GetFMUstate, |c| {
        check_array(state, 1, "FMUstate")?;
        let given = Some((*state).addr()).filter(|handle| *handle != 0);
        put(state, ptr::without_provenance_mut(c.instance.store(given)?))
    })
}

/// Frees a stored state and sets it to null; null is no state and nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(
    c: fmi2Component,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    call(c, Function::FreeFMUstate, |c| {
        if !state.is_null() && !(*state).is_null() {
            c.instance.discard((*state).addr())?;
            *state = ptr::null_mut();
        }
        Ok(())
    })
}

/// Writes a stored state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    call(c, Function::SerializeFMUstate, |c| {
        let written = c.instance.serialize(state.addr())?;
        if size < written.len() {
            let needed = written.len();
            return Err(Refusal::error(format!(
                "size = {size}; the state takes {needed} bytes"
            )));
        }
        put_all(bytes.cast(), size, written)
    })
}

/// Reads a state that this FMU wrote, in this process or another one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    call(c, Function::DeSerializeFMUstate, |c| {
        check_array(state, 1, "FMUstate")?;
        let bytes = array(bytes.cast::<u8>(), size, "serializedState")?;
        let handle = c.instance.deserialize(bytes)?;
        put(state, ptr::without_provenance_mut(handle))
    })
}

/// Exact partial derivatives of outputs by inputs, times the seed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    unknown: *const fmi2ValueReference,
    nUnknown: usize,
    known: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    call(c, Function::GetDirectionalDerivative, |c| {
        let known = array(known, nKnown, "vKnown_ref")?;
        let seeds = array(dvKnown, nKnown, "dvKnown")?;
        let unknown = array(unknown, nUnknown, "vUnknown_ref")?;
        let slopes = c.instance.directional_derivative(unknown, known, seeds)?;
        put_all(dvUnknown, nUnknown, slopes)
    })
}

/// Time derivatives of inputs at the start of the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    call(c, Function::SetRealInputDerivatives, |c| {
        let orders = array(order, nvr, "order")?;
        let values = array(value, nvr, "value")?;
        let references = array(vr, nvr, "vr")?;
        c.instance.set_input_derivatives(references, orders, values)
    })
}

/// First time derivatives of outputs at the end of the last step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    call(c, Function::GetRealOutputDerivatives, |c| {
        let orders = array(order, nvr, "order")?;
        let references = array(vr, nvr, "vr")?;
        let slopes = c.instance.output_derivatives(references, orders)?;
        put_all(value, nvr, slopes)
    })
}

/// Requests nothing, and need not be called: outputs depend on nothing that came before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _no_set_state_prior: fmi2Boolean,
    event: *mut fmi2Boolean,
    end: *mut fmi2Boolean,
) -> fmi2Status {
    call(c, Function::CompletedIntegratorStep, |_| {
        put(event, 0)?;
        put(end, 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::resources::tests::constant_stiffness;
    use std::ffi::CStr;
    use std::sync::Mutex;

    fn log(logger: fmi2CallbackLogger) -> Log {
        Log {
            logger,
            environment: ptr::null_mut(),
            name: c_string("mesh"),
            is_on: Log::categories(false),
        }
    }

    #[test]
    fn refusals_are_logged_until_they_are_switched_off_by_name() {
        use Severity::*;
        let severities = [Event, Warning, Discard, Error, Fatal];
        let statuses = [fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal];
        for (severity, status) in severities.into_iter().zip(statuses) {
            assert_eq!(severity as fmi2Status, status);
            assert!(LOG_CATEGORIES.contains(&category(severity)));
        }
        let mut log = log(None);
        let unknown = log.switch(true, &[EVENTS, "logNonsense"]).unwrap_err();
        assert!(unknown.message.contains("logNonsense"));
        let on = |log: &Log, name: &str| {
            let i = LOG_CATEGORIES.iter().position(|c| *c == name);
            log.is_on[i.unwrap()]
        };
        assert!(on(&log, "logStatusError") && !on(&log, EVENTS));
        for (switched, names, error, events) in [
            (true, &[][..], true, true),
            (false, &[], true, false),
            (true, &[EVENTS], true, true),
            (false, &["logStatusError"], false, true),
            (false, &[], false, false),
        ] {
            log.switch(switched, names).unwrap();
            let found = [on(&log, "logStatusError"), on(&log, EVENTS)];
            assert_eq!(found, [error, events]);
            assert!(on(&log, "logStatusFatal"));
        }
    }

    #[test]
    fn arrays_that_cannot_be_are_refused_and_none_may_be_null() {
        let value = [1.0_f64];
        let odd = value.as_ptr().wrapping_byte_add(1);
        for (data, count, is_array) in [
            (ptr::null(), 0, true),
            (ptr::null(), 1, false),
            (value.as_ptr(), 1, true),
            (odd, 1, false),
            (value.as_ptr(), usize::MAX, false),
        ] {
            assert_eq!(check_array(data, count, "vr").is_ok(), is_array);
        }
    }

    #[test]
    fn the_message_of_a_panic_is_its_own_and_a_zero_byte_ends_a_string() {
        for panic in [
            catch_unwind(|| panic!("plain")),
            catch_unwind(|| panic!("{}", "plain")),
        ] {
            assert_eq!(panic_text(&*panic.unwrap_err()), "plain");
        }
        let odd = catch_unwind(|| std::panic::panic_any(7)).unwrap_err();
        assert_eq!(panic_text(&*odd), "unknown cause");
        assert_eq!(c_string("a\0b").as_c_str(), c"a");
    }

    static LOGGED: Mutex<Vec<(fmi2Status, String)>> = Mutex::new(Vec::new());

    unsafe extern "C" fn listen(
        _environment: fmi2ComponentEnvironment,
        _name: fmi2String,
        status: fmi2Status,
        _category: fmi2String,
        _format: fmi2String,
        text: fmi2String,
    ) {
        let text = CStr::from_ptr(text).to_string_lossy().into_owned();
        LOGGED.lock().unwrap().push((status, text));
    }

    fn component() -> fmi2Component {
        // A variadic function cannot be defined in stable Rust. This one is called with exactly its six
        // arguments, which the C conventions of x86-64 and AArch64 Linux pass alike for both.
        let logger =
            unsafe { std::mem::transmute::<*const (), fmi2CallbackLogger>(listen as *const ()) };
        let component = Component {
            instance: constant_stiffness(Interface::CoSimulation),
            log: log(logger),
        };
        Box::into_raw(Box::new(component)).cast()
    }

    #[test]
    fn a_panic_inside_a_call_is_fatal_to_the_instance_and_to_nothing_else() {
        let (broken, other) = (component(), component());
        unsafe {
            let status = call(broken, Function::Reset, |_| panic!("forced by the test"));
            assert_eq!(status, fmi2Fatal);
            let logged = std::mem::take(&mut *LOGGED.lock().unwrap());
            let text = "fmi2Reset: internal error: forced by the test";
            assert_eq!(logged, [(fmi2Fatal, text.to_owned())]);
            // Nothing but freeing is left for it; other instances go on.
            assert_eq!(fmi2Reset(broken), fmi2Fatal);
            assert_eq!(fmi2ExitInitializationMode(broken), fmi2Fatal);
            assert_eq!(fmi2ExitInitializationMode(other), fmi2OK);
            assert_eq!(fmi2DoStep(other, 0.0, 1e-5, 1), fmi2OK);
            fmi2FreeInstance(broken);
            fmi2FreeInstance(other);
        }
    }
}
