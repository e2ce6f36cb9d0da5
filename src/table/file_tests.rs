//! Every defect of a file is refused by name.

use super::*;
use crate::gear::samples::paper_pair;
use crate::table::samples::Spring;
use serde_json::{Value, json};

fn file() -> TableFile {
    let grid = Spring::grid([8, 1, 5, 6]);
    TableFile::new(
        "spring",
        "a formula",
        &paper_pair(1.0),
        [100.0, 200.0],
        &grid,
        None,
    )
}

#[test]
fn tables_of_helical_gears_under_the_old_law_of_misalignment_are_refused_by_name() {
    let first = |helix_angle: f64, counts: [usize; 4], has_moment: bool| {
        let mut f = file();
        f.version = 1;
        for gear in &mut f.geometry.gears {
            gear.helix_angle = helix_angle;
        }
        f.geometry.center_distance = 0.083;
        let grid = Spring::grid(counts);
        (f.axes, f.drive) = (grid.axes.clone(), grid.for_file(&f.geometry));
        f.drive.moment = f.drive.moment.filter(|_| has_moment);
        f.seal();
        TableFile::from_json(&f.to_json())
    };
    for (counts, has_moment) in [([8, 1, 5, 6], false), ([8, 1, 1, 6], true)] {
        let error = first(0.2, counts, has_moment).unwrap_err().to_string();
        let names = ["version = 1", "gearmesh tables"];
        assert!(names.iter().all(|name| error.contains(name)), "{error}");
    }
    // What does not depend on it loads.
    first(0.0, [8, 1, 5, 6], true).unwrap();
    first(0.2, [8, 1, 1, 6], false).unwrap();
}

/// The record of root stress that a table of the element's tests has.
fn root_stress() -> RootStressRecord {
    use crate::element::tests::fixtures::rubbing_table;
    let table = rubbing_table(&paper_pair(1.0), Default::default(), false);
    table.file.root_stress.clone().unwrap()
}

/// Why the file `changed` at `pointer`, with a good checksum, is refused.
fn refusal(mut changed: Value, pointer: &str, value: Value) -> String {
    *changed.pointer_mut(&format!("/{pointer}")).unwrap() = value;
    changed["checksum_sha256"] = json!("");
    changed["checksum_sha256"] = json!(checksum(&changed.to_string()));
    let error = TableFile::from_json(&changed.to_string()).unwrap_err();
    error.to_string()
}

#[test]
fn each_change_of_a_sealed_file_is_noticed() {
    let text = file().to_json();
    for (from, to) in [
        ("\"teeth\":20", "\"teeth\":21"),
        ("\"nominal_torque_nm\":100.0", "\"nominal_torque_nm\":101.0"),
        ("\"spring\"", "\"Spring\""),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text);
        let error = TableFile::from_json(&changed).unwrap_err().to_string();
        assert!(error.starts_with("checksum_sha256 = "), "{error}");
    }
}

#[test]
fn defects_are_refused_by_field_even_with_a_good_checksum() {
    let mut with_stress = file();
    with_stress.root_stress = Some(root_stress());
    let good = serde_json::to_value(with_stress).unwrap();
    let many: Vec<u32> = (0..65_536).collect();
    // Field, what it is changed to, and what the refusal says after its name.
    for (field, value, text) in [
        ("version", json!(3), " = 3"),
        ("format", json!("other"), " = other"),
        ("drive.loa_force_n[0]", json!(-1), "[0] = -1"),
        ("drive.loa_force_n", json!([]), " = 0 values"),
        ("axes.mesh_position[2]", json!(0), "[2] = 0"),
        ("nominal_torque_nm", json!(-1), " = -1"),
        ("axes.misalignment_rad[1]", json!(-1), "[1] = -1"),
        ("drive.moment_nm", json!([0, 0]), " = 2 values"),
        ("drive.top_load_approach_m[3]", json!(-1), "[3] = -1"),
        ("root_stress.drive.gear_2_pa", json!([0]), " = 1 values"),
        ("root_stress.axes.loa_force_n[0]", json!(1), "[0] = 1"),
        ("root_stress.axes.mesh_position[2]", json!(0), "[2] = 0"),
        // Four such axes would have more samples than can be counted.
        ("axes.misalignment_rad", json!(many), " = 65536 values"),
        // Cells at the ends of the spline, which lie outside the nodes: too narrow, they would take memory without bound.
        ("axes.displacement_fraction[0]", json!(1e-12), " = 0 and"),
        ("axes.mesh_position[5]", json!(1.0 - 1e-12), " = 0.999"),
        // Geometry that no pair file gives.
        ("geometry.gear1.hand", json!(0.5), " = 0.5"),
        ("geometry.gear1.teeth", json!(0), " = 0"),
        ("geometry.center_distance_m", json!(0.01), " = 0.01"),
    ] {
        let pointer = field.replace(['.', '['], "/").replace(']', "");
        let error = refusal(good.clone(), &pointer, value);
        let name = field.trim_start_matches("geometry.");
        let name = name.split('[').next().unwrap();
        assert!(error.contains(&format!("{name}{text}")), "{error}");
    }
    // JSON has no NaN: it is written as null and refused as no number.
    let error = refusal(good, "drive/moment_nm/1", json!(f64::NAN));
    assert!(error.contains("null"), "{error}");
    let error = TableFile::from_json("{}").unwrap_err().to_string();
    assert!(error.contains("format"), "{error}");
    assert!(TableFile::from_json("").is_err());
}
