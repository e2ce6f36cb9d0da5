//! The C interface called from Rust, on a unit unpacked by hand: what a Python host cannot pass.

#![allow(unsafe_code)] // it calls what C calls

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;
use std::sync::Mutex;

use ::fmi::fmi2::binding::*;
use gearmesh::fmi::c_interface::*;
use gearmesh::fmi::resources::{UNIT_FILE, UNIT_VERSION, UnitFile};

#[path = "units/mod.rs"]
mod units;
use units::{GUID, resources, spur as unit, tabulated};

static LOG: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Takes the one string that the unit's format "%s" has: the symbol of a logger with one argument
/// stands in for the variadic one, which Rust cannot define.
unsafe extern "C" fn logger(
    _environment: *mut c_void,
    _name: *const c_char,
    _status: fmi2Status,
    _category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // Safety: the unit passes strings.
    let (format, text) = unsafe { (CStr::from_ptr(format), CStr::from_ptr(text)) };
    assert_eq!(format, c"%s");
    LOG.lock().unwrap().push(text.to_str().unwrap().to_owned());
}

fn callbacks() -> fmi2CallbackFunctions {
    type OneArgument = unsafe extern "C" fn(
        *mut c_void,
        *const c_char,
        fmi2Status,
        *const c_char,
        *const c_char,
        *const c_char,
    );
    // Safety: on the platforms the tests run on, one variadic pointer is passed like a plain one.
    let logger = unsafe {
        std::mem::transmute::<OneArgument, <fmi2CallbackLogger as IntoIterator>::Item>(logger)
    };
    fmi2CallbackFunctions {
        logger: Some(logger),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: ptr::null_mut(),
    }
}

fn instantiate(uri: &CStr, guid: &CStr, kind: fmi2Type) -> fmi2Component {
    let callbacks = callbacks();
    // The callbacks end with this call: the unit must have copied them.
    // Safety: all pointers are valid during the call.
    unsafe {
        fmi2Instantiate(
            c"one".as_ptr(),
            kind,
            guid.as_ptr(),
            uri.as_ptr(),
            ptr::from_ref(&callbacks).cast(),
            fmi2False as fmi2Boolean,
            fmi2True as fmi2Boolean,
        )
    }
}

#[test]
fn an_instance_lives_from_instantiation_to_freeing() {
    let folder = tempfile::tempdir().unwrap();
    let uri = resources(folder.path(), &unit());
    let guid = CString::new(GUID).unwrap();

    for (guid, kind, said) in [
        (
            c"{other}",
            fmi2Type_fmi2CoSimulation,
            "the host passed GUID {other}",
        ),
        (
            guid.as_c_str(),
            2,
            "model exchange (0) and co-simulation (1)",
        ),
    ] {
        assert!(instantiate(&uri, guid, kind).is_null());
        let last = LOG.lock().unwrap().pop().unwrap();
        assert!(last.contains(said), "{last}");
    }

    let c = instantiate(&uri, &guid, fmi2Type_fmi2CoSimulation);
    assert!(!c.is_null());
    // Safety: `c` is a component, arrays are as long as said or wrong on purpose in a way that the
    // unit can see.
    unsafe {
        assert_eq!(
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            fmi2Status_fmi2OK
        );
        assert_eq!(fmi2EnterInitializationMode(c), fmi2Status_fmi2OK);
        assert_eq!(fmi2ExitInitializationMode(c), fmi2Status_fmi2OK);

        // All inputs and all outputs in one call each.
        let inputs: Vec<u32> = (0..48).collect();
        let mut values = vec![0.0; 48];
        assert_eq!(
            fmi2GetReal(c, inputs.as_ptr(), 48, values.as_mut_ptr()),
            fmi2Status_fmi2OK
        );
        assert_eq!(values[16], 80e-3);
        values[5] = 1e-3; // gear1.angles[3]
        assert_eq!(
            fmi2SetReal(c, inputs.as_ptr(), 48, values.as_ptr()),
            fmi2Status_fmi2OK
        );
        assert_eq!(fmi2DoStep(c, 0.0, 1e-5, 1), fmi2Status_fmi2OK);
        let outputs: Vec<u32> = (100..131).collect();
        let mut results = vec![0.0; 31];
        assert_eq!(
            fmi2GetReal(c, outputs.as_ptr(), 31, results.as_mut_ptr()),
            fmi2Status_fmi2OK
        );
        assert_eq!(
            results[24..26],
            [1.0, 0.0],
            "mesh.flank and mesh.outOfRange"
        );
        // 1 mrad on a pitch radius of 40 mm.
        assert!((results[15] - 40e-6).abs() < 1e-15, "{}", results[15]);
        assert!(results[7] > 0.0, "gear 2 is pushed along +y");

        // A length that no array can have is seen before anything is read.
        assert_eq!(
            fmi2GetReal(c, inputs.as_ptr(), usize::MAX, values.as_mut_ptr()),
            fmi2Status_fmi2Error
        );
        assert_eq!(fmi2Reset(c), fmi2Status_fmi2OK);
        assert_eq!(fmi2FreeFMUstate(c, ptr::null_mut()), fmi2Status_fmi2OK);
        fmi2FreeInstance(c);
        fmi2FreeInstance(ptr::null_mut());
    }
}

#[test]
fn text_without_an_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let uri = resources(folder.path(), &unit());
    let endless = CString::new(vec![b'a'; 1 << 16]).unwrap();
    assert!(instantiate(&uri, &endless, fmi2Type_fmi2CoSimulation).is_null());
    let said = LOG.lock().unwrap().join("\n");
    assert!(said.contains("fmuGUID does not end within"), "{said}");
}

/// Loads the library that lies beside this test, runs an instance, and unloads it again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn load_and_unload(library: &CStr, uri: &CStr, guid: &CStr, kind: fmi2Type) {
    // Safety: the symbols have the types of the standard (checked where they are made), the library
    // stays loaded while they are called, and all pointers are valid during the calls.
    unsafe {
        let handle = libc::dlopen(library.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL);
        assert!(!handle.is_null(), "{:?}", CStr::from_ptr(libc::dlerror()));
        let symbol = |name: &CStr| libc::dlsym(handle, name.as_ptr());
        macro_rules! function {
            ($name:literal: $type:ty) => {
                std::mem::transmute::<*mut c_void, $type>(symbol($name)).expect("exported")
            };
        }
        let instantiate = function!(c"fmi2Instantiate": fmi2InstantiateTYPE);
        let enter = function!(c"fmi2EnterInitializationMode": fmi2EnterInitializationModeTYPE);
        let exit = function!(c"fmi2ExitInitializationMode": fmi2ExitInitializationModeTYPE);
        let store = function!(c"fmi2GetFMUstate": fmi2GetFMUstateTYPE);
        let reset = function!(c"fmi2Reset": fmi2ResetTYPE);
        let free = function!(c"fmi2FreeInstance": fmi2FreeInstanceTYPE);
        let (guid, uri) = (guid.as_ptr(), uri.as_ptr());
        let c = instantiate(c"one".as_ptr(), kind, guid, uri, ptr::null(), 0, 0);
        assert!(!c.is_null());
        assert_eq!(enter(c), fmi2Status_fmi2OK);
        assert_eq!(exit(c), fmi2Status_fmi2OK);
        let mut state = ptr::null_mut();
        assert_eq!(store(c, &mut state), fmi2Status_fmi2OK);
        assert_eq!(reset(c), fmi2Status_fmi2OK);
        free(c);
        assert_eq!(libc::dlclose(handle), 0);
        // Gone, not only counted down.
        let flags = libc::RTLD_NOW | libc::RTLD_NOLOAD;
        assert!(libc::dlopen(library.as_ptr(), flags).is_null());
    }
}

/// To the byte: what malloc has given out before and after.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn loading_and_unloading_leaves_no_byte_behind() {
    // In a process of its own: other tests allocate at the same time.
    const ALONE: &str = "GEARMESH_TEST_ALONE";
    if std::env::var_os(ALONE).is_none() {
        let test = "loading_and_unloading_leaves_no_byte_behind";
        let status = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", test, "--test-threads=1", "--nocapture"])
            .env(ALONE, "1")
            // Without lists of freed blocks that would count as given out, and in one heap.
            .env(
                "GLIBC_TUNABLES",
                "glibc.malloc.tcache_count=0:glibc.malloc.arena_max=1",
            )
            .status();
        assert!(status.unwrap().success());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let libraries =
        gearmesh_preprocessor::package::libraries_beside(&std::env::current_exe().unwrap())
            .unwrap();
    let library = &libraries[0];
    // With tables, since these are what instances share.
    let (unit, guid) = (tabulated(folder.path()), CString::new(GUID).unwrap());
    let uri = resources(folder.path(), &unit);
    let path = CString::new(library.path.to_str().unwrap()).unwrap();
    // Safety: it asks for statistics.
    let given_out = || unsafe { libc::mallinfo2() }.uordblks;
    let mut before = 0;
    for cycle in 0..12 {
        let kind = [fmi2Type_fmi2CoSimulation, fmi2Type_fmi2ModelExchange][cycle % 2];
        load_and_unload(&path, &uri, &guid, kind);
        // The loader and C's library keep a few things of the first cycles.
        if cycle == 3 {
            before = given_out();
        }
    }
    assert_eq!(given_out(), before);
}

#[test]
fn altered_resources_are_refused_with_file_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let read = |unit: &UnitFile| {
        let uri = resources(folder.path(), unit);
        gearmesh::fmi::resources::load(uri.to_str().unwrap(), GUID)
            .unwrap_err()
            .to_string()
    };
    let newer = UnitFile {
        version: UNIT_VERSION + 1,
        ..unit()
    };
    let foreign = UnitFile {
        starts: [("gear3.position[1]".to_owned(), 0.0)].into(),
        ..unit()
    };
    for (unit, said) in [(newer, "version 2"), (foreign, "gear3.position[1]")] {
        let error = read(&unit);
        assert!(error.contains(said) && error.contains(UNIT_FILE), "{error}");
    }
}
