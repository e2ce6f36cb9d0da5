//! The C interface of FMI 2.0, with all unsafe code but that of vector registers (src/vector.rs).
//!
//! Every function that takes a component runs inside `call`, which refuses null components and wrong states, turns a
//! panic into fmi2Fatal, and reports to the host's logger. What a function does is in the standard and in
//! [`super::instance`]; tests/c_interface/header.rs compares each signature with the standard's header.
//!
//! # Safety
//! All functions require of the host what the standard requires: a component is null or came from
//! fmi2Instantiate and was not freed, arrays hold as many items as passed (null only with none), strings
//! end with a zero byte, and one instance is used by one thread at a time. Every
//! `unsafe fn` below relies on that where it follows a pointer; it is stated this once.
#![allow(
    missing_docs,
    unsafe_code,
    unsafe_op_in_unsafe_fn,
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc
)]

use std::any::Any;
use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use super::header::*;
use super::instance::Instance;
use super::lifecycle::{Function, Interface, State};
use super::resources;
use super::variables::{Kind, LOG_CATEGORIES};
use super::{Refusal, Severity};

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
    /// Which of [`LOG_CATEGORIES`], which are in the order of [`Severity`], are on.
    is_on: [bool; LOG_CATEGORIES.len()],
}

impl Log {
    /// What `loggingOn` and fmi2SetDebugLogging without categories mean by debug logging is events alone: why a call was
    /// refused reaches the logger until the host switches that category off by its name.
    fn categories(debug: bool) -> [bool; LOG_CATEGORIES.len()] {
        std::array::from_fn(|i| debug || i != Severity::Event as usize)
    }

    /// fmi2SetDebugLogging: switches `names`; without any, all of them on, or debug logging off. Nothing is changed if
    /// modelDescription.xml lacks one of them.
    fn switch(&mut self, on: bool, names: &[&str]) -> Result<(), Refusal> {
        let names = match (names, on) {
            ([], true) => &LOG_CATEGORIES[..],
            ([], false) => &LOG_CATEGORIES[..1],
            _ => names,
        };
        if let Some(unknown) = names.iter().find(|name| !LOG_CATEGORIES.contains(name)) {
            let known = LOG_CATEGORIES.join(", ");
            let text = format!("log category '{unknown}' is none of {known}");
            return Err(Refusal::error(text));
        }
        for (category, is_on) in LOG_CATEGORIES.iter().zip(&mut self.is_on) {
            if names.contains(category) {
                *is_on = on;
            }
        }
        Ok(())
    }

    fn write(&self, severity: Severity, text: &str) {
        let i = severity as usize;
        let (Some(logger), true) = (self.logger, self.is_on[i]) else {
            return;
        };
        // '#' starts a reference to a variable in a message, '##' is the character.
        let text = c_string(&text.replace('#', "##"));
        let category = c_string(LOG_CATEGORIES[i]);
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

/// The floating-point mode that compiled Rust takes for granted: round to nearest, subnormal numbers, no traps. A host may run in
/// another one, with traps where it looks for its own divisions by zero, say; it gets its own back when this is dropped.
struct DefaultFloats {
    /// Control and status register of the host (MXCSR; Intel 64 manual, volume 1, section 10.2.3).
    #[cfg(target_arch = "x86_64")]
    host: u32,
}

#[cfg(target_arch = "x86_64")]
impl DefaultFloats {
    const DEFAULT: u32 = 0x1f80;
    /// Flags of what has happened: no part of the mode.
    const FLAGS: u32 = 0x3f;

    #[inline]
    fn set() -> Self {
        let mut host = 0_u32;
        // Safety: writes the register to `host`.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut host, options(nostack, preserves_flags));
        }
        let own = Self { host };
        if own.differs() {
            Self::load(Self::DEFAULT);
        }
        own
    }

    fn differs(&self) -> bool {
        self.host & !Self::FLAGS != Self::DEFAULT
    }

    fn load(register: u32) {
        // Safety: reads the register from `register`, a valid value: the default one, or what the processor gave.
        unsafe {
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags, readonly));
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Drop for DefaultFloats {
    #[inline]
    fn drop(&mut self) {
        if self.differs() {
            Self::load(self.host);
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl DefaultFloats {
    fn set() -> Self {
        Self {}
    }
}

/// Runs `body` for `function`, with which messages begin, on the component `c`.
unsafe fn call(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Component) -> Result<(), Refusal>,
) -> fmi2Status {
    let _mode = DefaultFloats::set();
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
            message: format!("internal error: {}", panic_text(&*panic)),
        })
    });
    for (severity, text) in component.instance.take_events() {
        component.log.write(severity, &text);
    }
    let Err(mut refusal) = outcome else {
        return fmi2OK;
    };
    component.instance.fail(&mut refusal);
    let text = format!("{function:?}: {refusal}");
    component.log.write(refusal.severity, &text);
    refusal.severity as fmi2Status
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

/// The host's array for `count` results at `data`, which may be uninitialised.
unsafe fn results<'a, T>(data: *mut T, count: usize) -> Result<&'a mut [MaybeUninit<T>], Refusal> {
    check_array(data, count, "the array for results")?;
    if count == 0 {
        return Ok(&mut []);
    }
    Ok(std::slice::from_raw_parts_mut(data.cast(), count))
}

unsafe fn put_all<T>(
    data: *mut T,
    count: usize,
    values: impl IntoIterator<Item = T>,
) -> Result<(), Refusal> {
    for (result, value) in results(data, count)?.iter_mut().zip(values) {
        result.write(value);
    }
    Ok(())
}

unsafe fn put<T>(data: *mut T, value: T) -> Result<(), Refusal> {
    put_all(data, 1, [value])
}

/// Bytes after which a host's string must have ended.
const LONGEST_TEXT: usize = 1 << 16;

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

impl Component {
    unsafe fn get<T>(
        &mut self,
        kind: Kind,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *mut T,
        convert: impl Fn(f64) -> T,
    ) -> Result<(), Refusal> {
        let mut left = results(value, nvr)?;
        let references = array(vr, nvr, "vr")?;
        self.instance.get(kind, references, |values| {
            let (now, rest) = std::mem::take(&mut left).split_at_mut(values.len());
            for (result, x) in now.iter_mut().zip(values) {
                result.write(convert(*x));
            }
            left = rest;
        })
    }

    unsafe fn set<T: Copy + Into<f64>>(
        &mut self,
        kind: Kind,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *const T,
    ) -> Result<(), Refusal> {
        let (references, values) = (array(vr, nvr, "vr")?, array(value, nvr, "value")?);
        self.instance.set(kind, references, values)
    }

    fn enter(&mut self, state: State) -> Result<(), Refusal> {
        self.instance.state.state = state;
        Ok(())
    }
}

/// Refuses any item of what this FMU has none of.
fn none(count: usize) -> Result<(), Refusal> {
    match count {
        0 => Ok(()),
        _ => Err(Refusal::error(format!(
            "{count} items; this FMU has no String variables, no continuous states and no event indicators"
        ))),
    }
}

fn no_status(kind: fmi2StatusKind) -> Result<(), Refusal> {
    let text = format!("the FMU has no status of kind {kind}");
    Err(Refusal::discard(text))
}

/// Exports that take a component `c`: `body` runs inside [`call`].
macro_rules! exports {
    ($($(#[$doc:meta])* fn $name:ident($c:ident $(, $argument:ident: $type:ty)* $(,)?) $body:block)+) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: fmi2Component $(, $argument: $type)*) -> fmi2Status {
            call(c, Function::$name, |$c| $body)
        }
    )+};
}

type References = *const fmi2ValueReference;

exports! {
    /// Switches log categories, all of them if none is named.
    fn fmi2SetDebugLogging(c, on: fmi2Boolean, count: usize, categories: *const fmi2String) {
        let names = array(categories, count, "categories")?.iter();
        let names = names.map(|name| text(*name, "a log category"));
        c.log.switch(on != 0, &names.collect::<Result<Vec<_>, _>>()?)
    }

    /// Start and stop time; the tolerance is of no use here, since nothing is integrated.
    fn fmi2SetupExperiment(
        c,
        _tolerance_defined: fmi2Boolean,
        _tolerance: fmi2Real,
        start: fmi2Real,
        stop_defined: fmi2Boolean,
        stop: fmi2Real,
    ) {
        c.instance.setup(start, (stop_defined != 0).then_some(stop))
    }

    fn fmi2EnterInitializationMode(c) { c.enter(State::InitializationMode) }

    /// Closes the initialization: checks the parameters and takes the phase offset of the teeth.
    fn fmi2ExitInitializationMode(c) { c.instance.exit_initialization() }

    fn fmi2Terminate(c) { c.enter(State::Terminated) }

    fn fmi2Reset(c) {
        c.instance.reset();
        Ok(())
    }

    fn fmi2GetReal(c, vr: References, nvr: usize, value: *mut fmi2Real) {
        c.get(Kind::Real, vr, nvr, value, |x| x)
    }

    fn fmi2GetInteger(c, vr: References, nvr: usize, value: *mut fmi2Integer) {
        c.get(Kind::Enumeration, vr, nvr, value, |x| x as i32)
    }

    fn fmi2GetBoolean(c, vr: References, nvr: usize, value: *mut fmi2Boolean) {
        c.get(Kind::Boolean, vr, nvr, value, |x| x as i32)
    }

    fn fmi2GetString(_c, _vr: References, nvr: usize, _value: *mut fmi2String) { none(nvr) }

    fn fmi2SetReal(c, vr: References, nvr: usize, value: *const fmi2Real) {
        c.set(Kind::Real, vr, nvr, value)
    }

    fn fmi2SetInteger(c, vr: References, nvr: usize, value: *const fmi2Integer) {
        c.set(Kind::Enumeration, vr, nvr, value)
    }

    fn fmi2SetBoolean(c, vr: References, nvr: usize, value: *const fmi2Boolean) {
        c.set(Kind::Boolean, vr, nvr, value)
    }

    fn fmi2SetString(_c, _vr: References, nvr: usize, _value: *const fmi2String) { none(nvr) }

    /// Stores the state, over the given one if that is not null. A fmi2FMUstate is a number here, not an address.
    fn fmi2GetFMUstate(c, state: *mut fmi2FMUstate) {
        check_array(state, 1, "FMUstate")?;
        let given = Some((*state).addr()).filter(|handle| *handle != 0);
        put(state, ptr::without_provenance_mut(c.instance.store(given)?))
    }

    fn fmi2SetFMUstate(c, state: fmi2FMUstate) { c.instance.restore(state.addr()) }

    /// Frees a stored state and sets it to null; null is no state and nothing happens.
    fn fmi2FreeFMUstate(c, state: *mut fmi2FMUstate) {
        if !state.is_null() && !(*state).is_null() {
            c.instance.discard((*state).addr())?;
            *state = ptr::null_mut();
        }
        Ok(())
    }

    fn fmi2SerializedFMUstateSize(c, state: fmi2FMUstate, size: *mut usize) {
        put(size, c.instance.serialize(state.addr())?.len())
    }

    fn fmi2SerializeFMUstate(c, state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize) {
        let written = c.instance.serialize(state.addr())?;
        let needed = written.len();
        if size < needed {
            return Err(Refusal::error(format!("size = {size}; the state takes {needed} bytes")));
        }
        put_all(bytes.cast(), size, written)
    }

    fn fmi2DeSerializeFMUstate(c, bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate) {
        check_array(state, 1, "FMUstate")?;
        let bytes = array(bytes.cast::<u8>(), size, "serializedState")?;
        put(state, ptr::without_provenance_mut(c.instance.deserialize(bytes)?))
    }

    /// Partial derivatives of outputs by inputs, times the seed.
    fn fmi2GetDirectionalDerivative(
        c,
        unknown: References,
        nUnknown: usize,
        known: References,
        nKnown: usize,
        dvKnown: *const fmi2Real,
        dvUnknown: *mut fmi2Real,
    ) {
        let known = array(known, nKnown, "vKnown_ref")?;
        let seeds = array(dvKnown, nKnown, "dvKnown")?;
        let unknown = array(unknown, nUnknown, "vUnknown_ref")?;
        let slopes = c.instance.directional_derivative(unknown, known, seeds)?;
        put_all(dvUnknown, nUnknown, slopes)
    }

    fn fmi2SetRealInputDerivatives(
        c,
        vr: References,
        nvr: usize,
        order: *const fmi2Integer,
        value: *const fmi2Real,
    ) {
        let (orders, values) = (array(order, nvr, "order")?, array(value, nvr, "value")?);
        let references = array(vr, nvr, "vr")?;
        c.instance.set_input_derivatives(references, orders, values)
    }

    /// First time derivatives of outputs at the end of the last step.
    fn fmi2GetRealOutputDerivatives(
        c,
        vr: References,
        nvr: usize,
        order: *const fmi2Integer,
        value: *mut fmi2Real,
    ) {
        let (references, orders) = (array(vr, nvr, "vr")?, array(order, nvr, "order")?);
        put_all(value, nvr, c.instance.output_derivatives(references, orders)?)
    }

    fn fmi2DoStep(c, point: fmi2Real, step: fmi2Real, _no_set_state_prior: fmi2Boolean) {
        c.instance.do_step(point, step)
    }

    /// Refused by the states of lifecycle.rs: a step is never in progress when a call returns.
    fn fmi2CancelStep(_c) { Ok(()) }

    fn fmi2GetStatus(c, kind: fmi2StatusKind, value: *mut fmi2Status) {
        match (kind, c.instance.state()) {
            (fmi2DoStepStatus, State::Error) => put(value, fmi2Error),
            (fmi2DoStepStatus, _) => put(value, fmi2OK),
            _ => no_status(kind),
        }
    }

    fn fmi2GetRealStatus(c, kind: fmi2StatusKind, value: *mut fmi2Real) {
        match kind {
            fmi2LastSuccessfulTime => put(value, c.instance.time()),
            _ => no_status(kind),
        }
    }

    fn fmi2GetIntegerStatus(_c, kind: fmi2StatusKind, _value: *mut fmi2Integer) { no_status(kind) }

    /// Whether the FMU wants to end the simulation: never.
    fn fmi2GetBooleanStatus(_c, kind: fmi2StatusKind, value: *mut fmi2Boolean) {
        match kind {
            fmi2Terminated => put(value, 0),
            _ => no_status(kind),
        }
    }

    fn fmi2GetStringStatus(_c, kind: fmi2StatusKind, _value: *mut fmi2String) { no_status(kind) }

    fn fmi2EnterEventMode(c) { c.enter(State::EventMode) }

    /// There are no discrete states: one iteration is enough, and no event is to come.
    fn fmi2NewDiscreteStates(_c, info: *mut fmi2EventInfo) { put(info, fmi2EventInfo::default()) }

    fn fmi2EnterContinuousTimeMode(c) { c.enter(State::ContinuousTimeMode) }

    /// Requests nothing, and need not be called: outputs depend on nothing that came before.
    fn fmi2CompletedIntegratorStep(
        _c,
        _no_set_state_prior: fmi2Boolean,
        event: *mut fmi2Boolean,
        end: *mut fmi2Boolean,
    ) {
        put(event, 0)?;
        put(end, 0)
    }

    /// The time, on which nothing depends.
    fn fmi2SetTime(c, time: fmi2Real) { c.instance.state.clock.set(time) }

    fn fmi2SetContinuousStates(_c, _x: *const fmi2Real, nx: usize) { none(nx) }

    fn fmi2GetDerivatives(_c, _derivatives: *mut fmi2Real, nx: usize) { none(nx) }

    fn fmi2GetEventIndicators(_c, _indicators: *mut fmi2Real, ni: usize) { none(ni) }

    fn fmi2GetContinuousStates(_c, _x: *mut fmi2Real, nx: usize) { none(nx) }

    fn fmi2GetNominalsOfContinuousStates(_c, _nominals: *mut fmi2Real, nx: usize) { none(nx) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetTypesPlatform() -> fmi2String {
    c"default".as_ptr()
}

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
    let _mode = DefaultFloats::set();
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

/// For the interface of this `kind`.
fn instantiate(
    kind: fmi2Type,
    name: &str,
    guid: &str,
    location: &str,
) -> Result<Instance, Refusal> {
    let refuse = |message: String| Err(Refusal::error(message));
    let interface = match kind {
        fmi2ModelExchange => Interface::ModelExchange,
        fmi2CoSimulation => Interface::CoSimulation,
        _ => {
            return refuse(format!(
                "fmuType = {kind}; this FMU is for model exchange ({fmi2ModelExchange}) \
                 and co-simulation ({fmi2CoSimulation})"
            ));
        }
    };
    if name.is_empty() {
        return refuse("instanceName is empty; give the instance a name".into());
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

#[cfg(test)]
#[path = "c_interface_tests.rs"]
mod tests;
