use super::*;
use crate::fmi::instance::tests::constant_stiffness;
use std::ffi::CStr;
use std::sync::Mutex;

#[test]
fn log_categories_are_in_the_order_of_the_severities() {
    use Severity::*;
    let severities = [Event, Warning, Discard, Error, Fatal];
    let statuses = [fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal];
    assert_eq!(severities.map(|s| s as fmi2Status), statuses);
    let names = ["Warning", "Discard", "Error", "Fatal"].map(|s| format!("logStatus{s}"));
    assert_eq!(LOG_CATEGORIES[0], "logEvents");
    assert_eq!(LOG_CATEGORIES[1..], names);
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
        log: Log {
            logger,
            environment: ptr::null_mut(),
            name: c_string("mesh"),
            is_on: Log::categories(false),
        },
    };
    Box::into_raw(Box::new(component)).cast()
}

#[test]
fn a_panic_inside_a_call_is_fatal_to_the_instance_and_to_nothing_else() {
    let (broken, other) = (component(), component());
    unsafe {
        let status = call(broken, Function::fmi2Reset, |_| {
            panic!("forced by the test")
        });
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
