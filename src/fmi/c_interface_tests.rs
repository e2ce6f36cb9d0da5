//! What no host may provoke: a panic inside an export.

use super::*;
use crate::fmi::lifecycle::Interface;
use crate::fmi::resources::{Resources, UNIT_VERSION, UnitFile};
use std::ffi::CStr;
use std::sync::Arc;

static SAID: std::sync::Mutex<Vec<(fmi2Status, String)>> = std::sync::Mutex::new(Vec::new());

unsafe extern "C" fn listen(
    _environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    status: fmi2Status,
    _category: fmi2String,
    _format: fmi2String,
    text: fmi2String,
) {
    let text = CStr::from_ptr(text).to_string_lossy().into_owned();
    SAID.lock().unwrap().push((status, text));
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
    let component = Component {
        instance: Instance::new(resources, Interface::CoSimulation),
        log: Log {
            logger,
            environment: ptr::null_mut(),
            name: c_string("mesh"),
            wanted: Wanted::new(true),
        },
    };
    // Safety: freed by fmi2FreeInstance alone.
    unsafe { component.hand_over() }
}

#[test]
fn a_panic_inside_a_call_is_fatal_to_the_instance_and_to_nothing_else() {
    let (broken, other) = (component(), component());
    unsafe {
        let status = call(broken, Function::Reset, "fmi2Reset", |_| {
            panic!("forced by the test")
        });
        assert_eq!(status, fmi2Status_fmi2Fatal);
        let said = std::mem::take(&mut *SAID.lock().unwrap());
        assert_eq!(said.len(), 1);
        assert_eq!(said[0].0, fmi2Status_fmi2Fatal);
        assert_eq!(said[0].1, "fmi2Reset: internal error: forced by the test");
        // Nothing but freeing is left for it; other instances go on.
        assert_eq!(fmi2Reset(broken), fmi2Status_fmi2Fatal);
        assert_eq!(fmi2EnterInitializationMode(broken), fmi2Status_fmi2Fatal);
        assert_eq!(fmi2EnterInitializationMode(other), fmi2Status_fmi2OK);
        assert_eq!(fmi2ExitInitializationMode(other), fmi2Status_fmi2OK);
        assert_eq!(fmi2DoStep(other, 0.0, 1e-5, 1), fmi2Status_fmi2OK);
        fmi2FreeInstance(broken);
        fmi2FreeInstance(other);
    }
}
