//! Resources of FMUs, written by hand.

#[path = "../common/gears.rs"]
mod gears;

use std::ffi::CString;
use std::path::Path;

use gearmesh::fmi::resources::{UNIT_FILE, UNIT_VERSION, UnitFile};

/// Of the FMUs below.
pub const GUID: &str = "{00000000-0000-0000-0000-000000000001}";

/// A spur pair of constant stiffness.
pub fn spur() -> UnitFile {
    UnitFile {
        version: UNIT_VERSION,
        guid: GUID.into(),
        name: "spur".into(),
        starts: [("gear2.position[1]".to_owned(), 80e-3)].into(),
        geometry: gears::spur_pair(),
    }
}

/// The paper's pair on its shipped tables, which are copied into `folder`.
pub fn tabulated(folder: &Path) -> UnitFile {
    let tables = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/resources/tables/palermo2013.json"
    );
    let file = gearmesh::table::TableFile::read(tables).unwrap();
    let geometry = file.geometry.clone();
    let place = ("gear2.position[1]".to_owned(), geometry.center_distance);
    std::fs::copy(tables, folder.join("tables.json")).unwrap();
    UnitFile {
        starts: [place, ("stiffnessModel".to_owned(), 2.0)].into(),
        geometry,
        ..spur()
    }
}

/// Writes the resources of `unit` and returns their URI.
pub fn resources(folder: &Path, unit: &UnitFile) -> CString {
    let text = serde_json::to_string(unit).unwrap();
    std::fs::write(folder.join(UNIT_FILE), text).unwrap();
    CString::new(format!("file://{}", folder.display())).unwrap()
}
