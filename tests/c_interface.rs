//! The library loaded and unloaded as a host does, and resources that were altered.

#![allow(unsafe_code)] // it calls what C calls

use gearmesh::fmi::header::*;
use gearmesh::fmi::resources::{UNIT_FILE, UNIT_VERSION, UnitFile};
use std::ffi::{CStr, CString, c_void};
use std::ptr;

#[path = "units/mod.rs"]
mod units;
use units::{GUID, resources, spur as unit, tabulated};

/// Loads the library in the folder of this test, runs an instance, and unloads it again.
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
        use ::fmi::fmi2::binding as standard;
        let instantiate = function!(c"fmi2Instantiate": standard::fmi2InstantiateTYPE);
        let exit =
            function!(c"fmi2ExitInitializationMode": standard::fmi2ExitInitializationModeTYPE);
        let enter =
            function!(c"fmi2EnterInitializationMode": standard::fmi2EnterInitializationModeTYPE);
        let store = function!(c"fmi2GetFMUstate": standard::fmi2GetFMUstateTYPE);
        let free = function!(c"fmi2FreeInstance": standard::fmi2FreeInstanceTYPE);
        let (guid, uri) = (guid.as_ptr(), uri.as_ptr());
        let c = instantiate(c"one".as_ptr(), kind, guid, uri, ptr::null(), 0, 0);
        assert!(!c.is_null());
        assert_eq!([enter(c), exit(c)], [fmi2OK; 2]);
        let mut state = ptr::null_mut();
        assert_eq!(store(c, &mut state), fmi2OK);
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
    // Safety: it reads statistics.
    let given_out = || unsafe { libc::mallinfo2() }.uordblks;
    let mut before = 0;
    for cycle in 0..12 {
        let kind = [fmi2CoSimulation, fmi2ModelExchange][cycle % 2];
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
