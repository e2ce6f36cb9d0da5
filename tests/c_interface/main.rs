//! The C interface against the standard's header and under random calls, the library loaded and unloaded as a host does, and resources that
//! were altered.

#![allow(unsafe_code)] // it calls what C calls

#[path = "../common/gears.rs"]
mod gears;
mod header;
mod random_calls;

use ::fmi::fmi2::binding::Fmi2Binding;
use gearmesh::fmi::c_interface::*;
use gearmesh::fmi::header::*;
use gearmesh::fmi::resources::{TABLES_FILE, UNIT_FILE, UNIT_VERSION, UnitFile};
use gearmesh::table::TableFile;
use std::ffi::{CStr, CString};
use std::path::Path;
use std::ptr;

/// Of the FMUs below.
const GUID: &str = "{00000000-0000-0000-0000-000000000001}";

/// A spur pair of constant stiffness.
fn spur() -> UnitFile {
    UnitFile {
        version: UNIT_VERSION,
        guid: GUID.into(),
        name: "spur".into(),
        starts: [("gear2.position[1]".to_owned(), 80e-3)].into(),
        geometry: gears::spur_pair(),
    }
}

/// The paper's pair on its shipped tables, which are written into `folder`.
fn tabulated(folder: &Path) -> UnitFile {
    let tables = include_str!("../../resources/tables/palermo2013.json");
    let geometry = TableFile::from_json(tables).unwrap().geometry;
    let place = ("gear2.position[1]".to_owned(), geometry.center_distance);
    std::fs::write(folder.join(TABLES_FILE), tables).unwrap();
    UnitFile {
        starts: [place, ("stiffnessModel".to_owned(), 2.0)].into(),
        geometry,
        ..spur()
    }
}

/// Writes the resources of `unit` and returns their URI.
fn resources(folder: &Path, unit: &UnitFile) -> CString {
    let text = serde_json::to_string(unit).unwrap();
    std::fs::write(folder.join(UNIT_FILE), text).unwrap();
    CString::new(format!("file://{}", folder.display())).unwrap()
}

/// Loads the library as a host does, runs an instance, and unloads it again.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn load_and_unload(library: &CStr, uri: &CStr, guid: &CStr, kind: fmi2Type) {
    // Safety: the symbols have the types of the standard (checked where they are made), and all pointers are valid during the calls.
    unsafe {
        let fmu = Fmi2Binding::new(library.to_str().unwrap()).unwrap();
        let (guid, uri) = (guid.as_ptr(), uri.as_ptr());
        let c = fmu.fmi2Instantiate(c"one".as_ptr(), kind, guid, uri, ptr::null(), 0, 0);
        assert!(!c.is_null());
        assert_eq!(fmu.fmi2EnterInitializationMode(c), fmi2OK);
        assert_eq!(fmu.fmi2ExitInitializationMode(c), fmi2OK);
        let mut state = ptr::null_mut();
        assert_eq!(fmu.fmi2GetFMUstate(c, &mut state), fmi2OK);
        fmu.fmi2FreeInstance(c);
        drop(fmu);
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
fn missing_and_altered_resources_are_refused_with_file_and_remedy() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("resources");
    let uri = format!("file://{}", folder.display());
    let assert_refused = |words: [&str; 2]| {
        let refused = gearmesh::fmi::resources::load(&uri, GUID).unwrap_err();
        let text = refused.to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    };
    assert_refused(["resources", ""]);
    std::fs::create_dir(&folder).unwrap();
    assert_refused([UNIT_FILE, ""]);
    let newer = UnitFile {
        version: UNIT_VERSION + 1,
        ..spur()
    };
    let foreign = UnitFile {
        starts: [("gear3.position[1]".to_owned(), 0.0)].into(),
        ..spur()
    };
    for (unit, word) in [(newer, "version 2"), (foreign, "gear3.position[1]")] {
        resources(&folder, &unit);
        assert_refused([UNIT_FILE, word]);
    }
    resources(&folder, &tabulated(&folder));
    let tables = folder.join(TABLES_FILE);
    let good = std::fs::read_to_string(&tables).unwrap();
    let (head, tail) = good.split_at(good.len() / 2);
    let digit = head.to_owned() + &tail.replacen('3', "4", 1);
    let other = include_str!("../../resources/tables/fzg-c.json").to_owned();
    for altered in [digit, other] {
        std::fs::write(&tables, altered).unwrap();
        assert_refused([TABLES_FILE, ""]);
    }
}
