//! The C interface of FMI 2.0: the one file with unsafe code.
//!
//! Every function that takes a component runs inside `call`, which refuses null components and wrong states, turns a
//! panic into fmi2Fatal, and reports to the host's logger. tests/header.rs compares each signature with the
//! type that the standard's header gives it.
//!
//! # Safety
//! All functions ask of the host what the standard asks: a component is null or came from
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
use super::variables::{Kind, LOG_CATEGORIES};
use super::{Event, Refusal, Severity};

/// What a fmi2Component points to.
struct Component {
    instance: Instance,
    log: Log,
}

/// The host's logger. The callbacks are copied: their struct is valid during fmi2Instantiate alone.
struct Log {
    logger: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    name: CString,
    categories: Categories,
}

impl Log {
    fn refusal(&self, severity: Severity, text: &str) {
        let (status, category) = reported(severity);
        self.write(status, category, text);
    }

    fn write(&self, status: fmi2Status, category: &str, text: &str) {
        let (Some(logger), true) = (self.logger, self.categories.contains(category)) else {
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

/// Log category of events.
const EVENTS: &str = "logEvents";

/// The host's number of a severity, and the log category, one of [`LOG_CATEGORIES`].
const fn reported(severity: Severity) -> (fmi2Status, &'static str) {
    match severity {
        Severity::Warning => (fmi2Warning, "logStatusWarning"),
        Severity::Discard => (fmi2Discard, "logStatusDiscard"),
        Severity::Error => (fmi2Error, "logStatusError"),
        Severity::Fatal => (fmi2Fatal, "logStatusFatal"),
    }
}

/// Log categories that are switched on.
///
/// `loggingOn` of fmi2Instantiate and fmi2SetDebugLogging without categories speak of debug logging:
/// here, of events. Why a call was refused is no debug output. It reaches the logger until the host
/// switches the category off by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Categories([bool; LOG_CATEGORIES.len()]);

impl Categories {
    /// Reports of refused calls and, if `debug`, events.
    fn new(debug: bool) -> Self {
        Self(LOG_CATEGORIES.map(|category| debug || category != EVENTS))
    }

    fn contains(&self, category: &str) -> bool {
        let mut all = LOG_CATEGORIES.iter().zip(self.0);
        all.any(|(name, on)| on && *name == category)
    }

    /// fmi2SetDebugLogging: switches `names`; without any, all of them on, or debug logging off.
    ///
    /// # Errors
    /// A category that modelDescription.xml does not declare; nothing is changed.
    fn switch(&mut self, on: bool, names: &[&str]) -> Result<(), Refusal> {
        let all = if on { &LOG_CATEGORIES[..] } else { &[EVENTS] };
        let names = if names.is_empty() { all } else { names };
        let mut switched = *self;
        for name in names {
            let place = LOG_CATEGORIES.iter().position(|c| c == name);
            let i = place.ok_or_else(|| {
                let known = LOG_CATEGORIES.join(", ");
                Refusal::error(format!("log category '{name}' is none of {known}"))
            })?;
            switched.0[i] = on;
        }
        *self = switched;
        Ok(())
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

/// Runs `body` for the function `name` on the component `c`.
unsafe fn call(
    c: fmi2Component,
    function: Function,
    name: &str,
    body: impl FnOnce(&mut Component) -> Result<(), Refusal>,
) -> fmi2Status {
    let Some(component) = c.cast::<Component>().as_mut() else {
        return fmi2Error;
    };
    if component.instance.state() == State::Fatal {
        return fmi2Fatal;
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        component.instance.admit(function, name)?;
        body(component)
    }))
    .unwrap_or_else(|panic| {
        Err(Refusal {
            severity: Severity::Fatal,
            message: format!("{name}: internal error: {}", panic_text(&*panic)),
        })
    });
    for event in component.instance.take_events() {
        match event {
            Event::Info(text) => component.log.write(fmi2OK, EVENTS, &text),
            Event::Warning(text) => component.log.refusal(Severity::Warning, &text),
        }
    }
    let Err(refusal) = outcome else {
        return fmi2OK;
    };
    component.instance.fail(refusal.severity);
    component.log.refusal(refusal.severity, &refusal.message);
    reported(refusal.severity).0
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

/// Writes into the host's array of `count` items at `data`, which may hold anything before: from the first on at each call.
unsafe fn writer<T>(mut data: *mut T, count: usize) -> Result<impl FnMut(T), Refusal> {
    check_array(data, count, "the place for results")?;
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
        // Null or the host's callbacks, valid during this call.
        let callbacks = functions.as_ref();
        let name = text(instanceName, "instanceName");
        let log = Log {
            logger: callbacks.and_then(|f| f.logger),
            environment: callbacks.map_or(ptr::null_mut(), |f| f.componentEnvironment),
            name: c_string(name.as_ref().map_or("", |n| n)),
            categories: Categories::new(loggingOn != 0),
        };
        let instance = name.and_then(|name| {
            let guid = text(fmuGUID, "fmuGUID")?;
            let location = text(fmuResourceLocation, "fmuResourceLocation")?;
            instantiate(fmuType, name, guid, location)
        });
        match instance {
            Ok(instance) => Box::into_raw(Box::new(Component { instance, log })).cast(),
            Err(refusal) => {
                let message = format!("fmi2Instantiate: {refusal}");
                log.refusal(Severity::Error, &message);
                ptr::null_mut()
            }
        }
    });
    made.unwrap_or(ptr::null_mut())
}

/// A new instance for the interface that the host asks for.
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
                "fmuType = {kind}; this unit is for model exchange ({fmi2ModelExchange}) \
                 and co-simulation ({fmi2CoSimulation})"
            )));
        }
    };
    if name.is_empty() {
        return Err(Refusal::error(
            "instanceName is empty; give the instance a name",
        ));
    }
    Ok(Instance::new(resources::load(location, guid)?, interface))
}

/// Frees the instance with all its stored states; null is no instance and nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    if c.is_null() {
        return;
    }
    // From fmi2Instantiate, not freed before. A panic ends here: the function has no status to return.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        drop(Box::from_raw(c.cast::<Component>()));
        resources::release();
    }));
}

/// Copies Integer, Enumeration or Boolean values, all of them C's int, to the host.
unsafe fn get_discrete(
    c: fmi2Component,
    name: &str,
    kind: Kind,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    call(c, Function::Get, name, |c| {
        let references = array(vr, nvr, "vr")?;
        let put = writer(value, nvr)?;
        c.instance.get_discrete(name, kind, references, put)
    })
}

/// Sets Enumeration or Boolean variables to the host's values.
unsafe fn set_discrete(
    c: fmi2Component,
    name: &str,
    kind: Kind,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    call(c, Function::SetDiscrete, name, |c| {
        let (references, values) = (array(vr, nvr, "vr")?, array(value, nvr, "value")?);
        c.instance.set_discrete(name, kind, references, values)
    })
}

/// Refuses any reference: there are no variables of type String.
unsafe fn no_strings(
    c: fmi2Component,
    function: Function,
    name: &str,
    vr: *const fmi2ValueReference,
    nvr: usize,
) -> fmi2Status {
    call(c, function, name, |_| match array(vr, nvr, "vr")?.first() {
        None => Ok(()),
        Some(vr) => Err(Refusal::error(format!(
            "{name}: value reference {vr} belongs to no variable of type String"
        ))),
    })
}

/// Answers the question for a status of `kind`, if it is the one that the unit has an answer to.
unsafe fn get_status<T>(
    c: fmi2Component,
    name: &str,
    kind: fmi2StatusKind,
    known: Option<fmi2StatusKind>,
    value: *mut T,
    answer: impl FnOnce(&Instance) -> T,
) -> fmi2Status {
    call(c, Function::GetStatus, name, |c| {
        if Some(kind) == known {
            return put(value, answer(&c.instance));
        }
        Err(Refusal::discard(format!(
            "{name}: the unit has no status of kind {kind}"
        )))
    })
}

/// Refuses any: there are no continuous states and no event indicators.
unsafe fn none_of(c: fmi2Component, function: Function, name: &str, count: usize) -> fmi2Status {
    call(c, function, name, |_| match count {
        0 => Ok(()),
        _ => Err(Refusal::error(format!(
            "{name}: {count} items; this unit has no continuous states and no event indicators"
        ))),
    })
}

/// Switches log categories, all of them if none is named.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    on: fmi2Boolean,
    count: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    call(c, Function::SetDebugLogging, "fmi2SetDebugLogging", |c| {
        let names = array(categories, count, "categories")?.iter();
        let names = names.map(|name| text(*name, "a log category"));
        let names = names.collect::<Result<Vec<_>, _>>()?;
        c.log.categories.switch(on != 0, &names)
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
    call(c, Function::SetupExperiment, "fmi2SetupExperiment", |c| {
        c.instance.setup(start, (stop_defined != 0).then_some(stop))
    })
}

/// Opens the initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    call(
        c,
        Function::EnterInitializationMode,
        "fmi2EnterInitializationMode",
        |c| {
            c.instance.enter(State::InitializationMode);
            Ok(())
        },
    )
}

/// Closes the initialization: checks the parameters and latches the phases of the teeth.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    call(
        c,
        Function::ExitInitializationMode,
        "fmi2ExitInitializationMode",
        |c| c.instance.exit_initialization(),
    )
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    call(c, Function::Terminate, "fmi2Terminate", |c| {
        c.instance.enter(State::Terminated);
        Ok(())
    })
}

/// Back to the state after fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    call(c, Function::Reset, "fmi2Reset", |c| {
        c.instance.reset();
        Ok(())
    })
}

/// Values of Real variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    call(c, Function::Get, "fmi2GetReal", |c| {
        let references = array(vr, nvr, "vr")?;
        c.instance.get_real(references, writer(value, nvr)?)
    })
}

/// Values of Integer and Enumeration variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    get_discrete(c, "fmi2GetInteger", Kind::Integer, vr, nvr, value)
}

/// Values of Boolean variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    get_discrete(c, "fmi2GetBoolean", Kind::Boolean, vr, nvr, value)
}

/// Refuses any variable: there are none of type String.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *mut fmi2String,
) -> fmi2Status {
    no_strings(c, Function::Get, "fmi2GetString", vr, nvr)
}

/// Sets Real inputs and parameters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    call(c, Function::SetReal, "fmi2SetReal", |c| {
        c.instance
            .set_real(array(vr, nvr, "vr")?, array(value, nvr, "value")?)
    })
}

/// Sets Enumeration parameters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    set_discrete(c, "fmi2SetInteger", Kind::Integer, vr, nvr, value)
}

/// Sets Boolean parameters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    set_discrete(c, "fmi2SetBoolean", Kind::Boolean, vr, nvr, value)
}

/// Refuses any variable: there are none of type String.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    _value: *const fmi2String,
) -> fmi2Status {
    no_strings(c, Function::SetDiscrete, "fmi2SetString", vr, nvr)
}

/// Keeps the state, in the place of the given one if that is not null. A fmi2FMUstate is a number
/// here, not an address.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    call(c, Function::FmuState, "fmi2GetFMUstate", |c| {
        check_array(state, 1, "FMUstate")?;
        let kept = c
            .instance
            .store(Some((*state).addr()).filter(|h| *h != 0))?;
        put(state, ptr::without_provenance_mut(kept))
    })
}

/// Goes back to a kept state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status {
    call(c, Function::FmuState, "fmi2SetFMUstate", |c| {
        c.instance.restore(state.addr())
    })
}

/// Frees a kept state and sets it to null; null is no state and nothing happens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(
    c: fmi2Component,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    call(c, Function::FmuState, "fmi2FreeFMUstate", |c| {
        if !state.is_null() && !(*state).is_null() {
            c.instance.discard((*state).addr())?;
            *state = ptr::null_mut();
        }
        Ok(())
    })
}

/// Bytes that a kept state takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    call(c, Function::FmuState, "fmi2SerializedFMUstateSize", |c| {
        put(size, c.instance.serialize(state.addr())?.len())
    })
}

/// Writes a kept state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    call(c, Function::FmuState, "fmi2SerializeFMUstate", |c| {
        let written = c.instance.serialize(state.addr())?;
        if size < written.len() {
            let needed = written.len();
            return Err(Refusal::error(format!(
                "size = {size}; the state takes {needed} bytes"
            )));
        }
        put_all(
            bytes,
            size,
            written.into_iter().map(|byte| byte as fmi2Byte),
        )
    })
}

/// Reads a state that this unit wrote, in this process or another one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    call(c, Function::FmuState, "fmi2DeSerializeFMUstate", |c| {
        let bytes = array(bytes.cast::<u8>(), size, "serializedState")?;
        check_array(state, 1, "FMUstate")?;
        put(
            state,
            ptr::without_provenance_mut(c.instance.deserialize(bytes)?),
        )
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
    call(
        c,
        Function::GetDirectionalDerivative,
        "fmi2GetDirectionalDerivative",
        |c| {
            let known = array(known, nKnown, "vKnown_ref")?;
            let seeds = array(dvKnown, nKnown, "dvKnown")?;
            let unknown = array(unknown, nUnknown, "vUnknown_ref")?;
            let slopes = c.instance.directional_derivative(unknown, known, seeds)?;
            put_all(dvUnknown, nUnknown, slopes)
        },
    )
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
    call(
        c,
        Function::SetInputDerivatives,
        "fmi2SetRealInputDerivatives",
        |c| {
            let orders = array(order, nvr, "order")?.iter().copied();
            let values = array(value, nvr, "value")?.iter().copied();
            let items = array(vr, nvr, "vr")?
                .iter()
                .copied()
                .zip(orders)
                .zip(values);
            c.instance
                .set_input_derivatives(items.map(|((vr, order), value)| (vr, order, value)))
        },
    )
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
    call(
        c,
        Function::GetOutputDerivatives,
        "fmi2GetRealOutputDerivatives",
        |c| {
            let orders = array(order, nvr, "order")?;
            let references = array(vr, nvr, "vr")?;
            put_all(
                value,
                nvr,
                c.instance.output_derivatives(references, orders)?,
            )
        },
    )
}

/// One communication step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    point: fmi2Real,
    step: fmi2Real,
    _no_set_state_prior: fmi2Boolean,
) -> fmi2Status {
    call(c, Function::DoStep, "fmi2DoStep", |c| {
        c.instance.do_step(point, step)
    })
}

/// Refused: a step is never in progress when a call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    call(c, Function::CancelStep, "fmi2CancelStep", |_c| Ok(()))
}

/// Status of the last step; pending steps there are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Status,
) -> fmi2Status {
    let (name, known) = ("fmi2GetStatus", Some(fmi2DoStepStatus));
    get_status(c, name, kind, known, value, |instance| {
        match instance.state() {
            State::Error => fmi2Error,
            _ => fmi2OK,
        }
    })
}

/// Time up to which the last step came.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    let (name, known) = ("fmi2GetRealStatus", Some(fmi2LastSuccessfulTime));
    get_status(c, name, kind, known, value, Instance::time)
}

/// Discards: there is no status of type Integer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status {
    get_status(c, "fmi2GetIntegerStatus", kind, None, value, |_| 0)
}

/// Whether the unit wants to end the simulation: never.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let (name, known) = ("fmi2GetBooleanStatus", Some(fmi2Terminated));
    get_status(c, name, kind, known, value, |_| 0)
}

/// Discards: there is no pending step to tell about.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    get_status(c, "fmi2GetStringStatus", kind, None, value, |_| ptr::null())
}

/// The host handles an event: inputs and tunable parameters may jump.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: fmi2Component) -> fmi2Status {
    call(c, Function::EnterEventMode, "fmi2EnterEventMode", |c| {
        c.instance.enter(State::EventMode);
        Ok(())
    })
}

/// There are no discrete states: one iteration is enough, and no event is to come.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(
    c: fmi2Component,
    info: *mut fmi2EventInfo,
) -> fmi2Status {
    call(
        c,
        Function::NewDiscreteStates,
        "fmi2NewDiscreteStates",
        |_c| {
            put(
                info,
                fmi2EventInfo {
                    newDiscreteStatesNeeded: 0,
                    terminateSimulation: 0,
                    nominalsOfContinuousStatesChanged: 0,
                    valuesOfContinuousStatesChanged: 0,
                    nextEventTimeDefined: 0,
                    nextEventTime: 0.0,
                },
            )
        },
    )
}

/// The host integrates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status {
    call(
        c,
        Function::EnterContinuousTimeMode,
        "fmi2EnterContinuousTimeMode",
        |c| {
            c.instance.enter(State::ContinuousTimeMode);
            Ok(())
        },
    )
}

/// Asks for nothing, and need not be called: outputs depend on nothing that came before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: fmi2Component,
    _no_set_state_prior: fmi2Boolean,
    event: *mut fmi2Boolean,
    end: *mut fmi2Boolean,
) -> fmi2Status {
    call(
        c,
        Function::CompletedIntegratorStep,
        "fmi2CompletedIntegratorStep",
        |_c| {
            put(event, 0)?;
            put(end, 0)
        },
    )
}

/// The time, on which nothing depends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status {
    call(c, Function::SetTime, "fmi2SetTime", |c| {
        c.instance.set_time(time)
    })
}

/// There are no continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: fmi2Component,
    _x: *const fmi2Real,
    nx: usize,
) -> fmi2Status {
    none_of(
        c,
        Function::SetContinuousStates,
        "fmi2SetContinuousStates",
        nx,
    )
}

/// There are no continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(
    c: fmi2Component,
    _derivatives: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    none_of(c, Function::GetStates, "fmi2GetDerivatives", nx)
}

/// There are no event indicators.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: fmi2Component,
    _indicators: *mut fmi2Real,
    ni: usize,
) -> fmi2Status {
    none_of(
        c,
        Function::GetEventIndicators,
        "fmi2GetEventIndicators",
        ni,
    )
}

/// There are no continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(
    c: fmi2Component,
    _x: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    none_of(c, Function::GetStates, "fmi2GetContinuousStates", nx)
}

/// There are no continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: fmi2Component,
    _nominals: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    let name = "fmi2GetNominalsOfContinuousStates";
    none_of(c, Function::GetStates, name, nx)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::resources::{Resources, UNIT_VERSION, UnitFile};
    use std::ffi::CStr;
    use std::sync::Arc;

    #[test]
    fn every_category_in_use_is_declared() {
        use Severity::*;
        for (_, category) in [Warning, Discard, Error, Fatal].map(reported) {
            assert!(LOG_CATEGORIES.contains(&category), "{category}");
        }
        assert!(LOG_CATEGORIES.contains(&EVENTS));
    }

    #[test]
    fn an_undeclared_category_changes_nothing() {
        let mut categories = Categories::new(false);
        let error = categories
            .switch(true, &["logEvents", "logNonsense"])
            .unwrap_err();
        assert!(error.message.contains("logNonsense"));
        assert_eq!(categories, Categories::new(false));
        categories.switch(true, &["logEvents"]).unwrap();
        assert!(categories.contains("logEvents"));
    }

    #[test]
    fn refusals_are_heard_until_they_are_switched_off_by_name() {
        let mut categories = Categories::new(false);
        assert!(categories.contains("logStatusError") && !categories.contains("logEvents"));
        categories.switch(true, &[]).unwrap();
        assert!(categories.contains("logEvents"));
        categories.switch(false, &[]).unwrap();
        assert!(categories.contains("logStatusError") && !categories.contains("logEvents"));
        categories.switch(false, &["logStatusError"]).unwrap();
        assert!(!categories.contains("logStatusError") && categories.contains("logStatusFatal"));
        categories.switch(false, &[]).unwrap();
        assert!(!categories.contains("logStatusError"));
    }

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
    fn the_message_of_a_panic_is_its_own() {
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

    static LOGGED: std::sync::Mutex<Vec<(fmi2Status, String)>> = std::sync::Mutex::new(Vec::new());

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

    /// A component on the paper's pair with constant stiffness.
    fn component() -> fmi2Component {
        let geometry = crate::gear::samples::paper_pair(1.0);
        let unit = UnitFile {
            version: UNIT_VERSION,
            guid: "{guid}".into(),
            name: "paper".into(),
            starts: [("gear2.position[1]".to_owned(), geometry.center_distance)].into(),
            geometry,
        };
        let resources = Arc::new(Resources::new(unit, None, None).unwrap());
        // A variadic function cannot be defined in stable Rust. This one is called with exactly its six
        // arguments, which the C conventions of x86-64 and AArch64 Linux pass alike for both.
        let logger =
            unsafe { std::mem::transmute::<*const (), fmi2CallbackLogger>(listen as *const ()) };
        let component = Box::new(Component {
            instance: Instance::new(resources, Interface::CoSimulation),
            log: Log {
                logger,
                environment: ptr::null_mut(),
                name: c_string("mesh"),
                categories: Categories::new(true),
            },
        });
        Box::into_raw(component).cast()
    }

    #[test]
    fn a_panic_inside_a_call_is_fatal_to_the_instance_and_to_nothing_else() {
        let (broken, other) = (component(), component());
        unsafe {
            let status = call(broken, Function::Reset, "fmi2Reset", |_| {
                panic!("forced by the test")
            });
            assert_eq!(status, fmi2Fatal);
            let logged = std::mem::take(&mut *LOGGED.lock().unwrap());
            assert_eq!(logged.len(), 1);
            assert_eq!(logged[0].0, fmi2Fatal);
            assert_eq!(logged[0].1, "fmi2Reset: internal error: forced by the test");
            // Nothing but freeing is left for it; other instances go on.
            assert_eq!(fmi2Reset(broken), fmi2Fatal);
            assert_eq!(fmi2EnterInitializationMode(broken), fmi2Fatal);
            assert_eq!(fmi2EnterInitializationMode(other), fmi2OK);
            assert_eq!(fmi2ExitInitializationMode(other), fmi2OK);
            assert_eq!(fmi2DoStep(other, 0.0, 1e-5, 1), fmi2OK);
            fmi2FreeInstance(broken);
            fmi2FreeInstance(other);
        }
    }
}
