//! What a fmi2Component points to, and how the functions of the C interface reach it: pointers, panics, log.
//!
//! Every function runs inside [`call`], which refuses null components and wrong states, turns a
//! panic into fmi2Fatal, and reports to the host's logger.
//!
//! # Safety
//! As in [`c_interface`](super::c_interface).
#![allow(unsafe_code, unsafe_op_in_unsafe_fn, clippy::missing_safety_doc)]

use std::ffi::CString;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

use ::fmi::fmi2::binding::*;
use libc::c_char;

use super::boundary::{c_string, check_array, status};
use super::instance::Instance;
use super::lifecycle::{Function, State};
use super::report::{EVENTS, Event, Refusal, Severity, Wanted};

/// What a fmi2Component points to.
pub(super) struct Component {
    pub instance: Instance,
    pub log: Log,
}

impl Component {
    /// Moves the component to C's memory, since C holds it from now on: a host that watches its
    /// allocations sees it, and where there is no memory left the answer is null.
    pub unsafe fn hand_over(self) -> fmi2Component {
        const { assert!(align_of::<Component>() <= align_of::<f64>()) }; // malloc serves any C type
        let place = libc::malloc(size_of::<Component>()).cast::<Component>();
        if !place.is_null() {
            place.write(self);
        }
        place.cast()
    }

    /// Ends the component at `c`, which came from [`Component::hand_over`].
    pub unsafe fn free(c: fmi2Component) {
        ptr::drop_in_place(c.cast::<Component>());
        libc::free(c);
    }
}

/// The host's logger. The callbacks are copied: their struct is valid during fmi2Instantiate alone.
pub(super) struct Log {
    pub logger: fmi2CallbackLogger,
    pub environment: fmi2ComponentEnvironment,
    pub name: CString,
    pub wanted: Wanted,
}

impl Log {
    /// In the category of `severity`.
    fn refused(&self, severity: Severity, text: &str) {
        self.write(status(severity), severity.category(), text);
    }

    /// To the host, if it wants to hear of `category`.
    pub fn write(&self, status: fmi2Status, category: &str, text: &str) {
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
pub(super) unsafe fn call(
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
pub(super) unsafe fn array<'a, T>(
    data: *const T,
    count: usize,
    what: &str,
) -> Result<&'a [T], Refusal> {
    check_array(data, count, what)?;
    if count == 0 {
        return Ok(&[]);
    }
    Ok(std::slice::from_raw_parts(data, count))
}

/// As [`array`], to be written.
pub(super) unsafe fn array_mut<'a, T>(
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
pub(super) unsafe fn put_all<T>(
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
pub(super) unsafe fn put<T>(place: *mut T, value: T) -> Result<(), Refusal> {
    put_all(place, 1, [value])
}

/// Bytes after which a host's string must have ended.
const LONGEST_TEXT: usize = 1 << 16;

/// The host's string.
pub(super) unsafe fn text<'a>(data: *const c_char, what: &str) -> Result<&'a str, Refusal> {
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
