//! The file round-trips and every defect is refused by name.

use super::*;
use crate::gear::samples::paper_pair;
use crate::table::samples::Spring;
use crate::table::{Effects, Load, Table};

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
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tables with ü.json");
    std::fs::write(&path, file().to_json()).unwrap();
    let read = TableFile::read(&path).unwrap();
    assert_eq!(read, file());
    assert_eq!(read.geometry, paper_pair(1.0));
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
        (f.axes, f.drive) = (grid.axes.clone(), grid.for_file());
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
        let error = TableFile::from_json(&changed).unwrap_err();
        assert!(matches!(error, TableError::Checksum { .. }), "{error}");
    }
}

/// The record of root stress that a table of the element's tests has.
fn root_stress() -> RootStressRecord {
    use crate::element::tests::fixtures::rubbing_table;
    let table = rubbing_table(&paper_pair(1.0), Default::default(), false);
    table.file().root_stress.clone().unwrap()
}

#[test]
fn defects_are_refused_by_field_even_with_a_good_checksum() {
    type Change = fn(&mut TableFile);
    fn of_stress(f: &mut TableFile, change: fn(&mut RootStressRecord)) {
        change(f.root_stress.insert(root_stress()));
    }
    let changes: [(Change, &str); 19] = [
        (|f| f.version = 3, "version = 3"),
        (|f| f.format = "other".into(), "format = other"),
        (|f| f.drive.loa_force[0] = -1.0, "drive.loa_force_n[0] = -1"),
        (
            |f| f.drive.loa_force.clear(),
            "drive.loa_force_n = 0 values",
        ),
        (
            |f| f.axes.mesh_position[2] = 0.0,
            "axes.mesh_position[2] = 0",
        ),
        (|f| f.nominal_torque_nm = -1.0, "nominal_torque_nm = -1"),
        (
            |f| f.axes.misalignment[1] = -1.0,
            "axes.misalignment_rad[1] = -1",
        ),
        (
            |f| f.drive.moment.as_mut().unwrap().truncate(9),
            "drive.moment_nm = 9 values",
        ),
        (
            |f| f.drive.top_load_approach[3] = -1.0,
            "drive.top_load_approach_m[3] = -1",
        ),
        (
            |f| of_stress(f, |r| r.drive.gear_2_pa.truncate(9)),
            "root_stress.drive.gear_2_pa = 9 values",
        ),
        (
            |f| of_stress(f, |r| r.axes.loa_force_n[0] = 1.0),
            "root_stress.axes.loa_force_n[0] = 1",
        ),
        (
            |f| of_stress(f, |r| r.axes.mesh_position[2] = 0.0),
            "root_stress.axes.mesh_position[2] = 0",
        ),
        // Four such axes would have more samples than can be counted.
        (
            |f| f.axes.misalignment = (0..65_536).map(f64::from).collect(),
            "at most 10000",
        ),
        // Cells at the ends of the spline, which lie outside the nodes: too narrow, they would take memory without bound.
        (
            |f| f.axes.displacement_fraction[0] = 1e-12,
            "0 and 0.000000000001",
        ),
        (
            |f| f.axes.mesh_position[5] = 1.0 - 1e-12,
            "closer than 1e-5",
        ),
        // JSON has no NaN: it is written as null and refused as no number.
        (|f| f.drive.moment.as_mut().unwrap()[1] = f64::NAN, "null"),
        // Geometry that no pair file gives.
        (|f| f.geometry.gears[0].hand = 0.5, "gear1.hand = 0.5"),
        (|f| f.geometry.gears[0].teeth = 0, "gear1.teeth = 0"),
        (
            |f| f.geometry.center_distance = 0.01,
            "center_distance_m = 0.01",
        ),
    ];
    for (change, name) in changes {
        let mut f = file();
        change(&mut f);
        f.seal();
        let error = TableFile::from_json(&f.to_json()).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    let error = TableFile::from_json("{}").unwrap_err().to_string();
    assert!(error.contains("format"), "{error}");
    assert!(TableFile::from_json("").is_err());
}

#[test]
fn a_constant_load_beyond_the_table_is_refused_by_name() {
    let table = Table::from_file(file()).unwrap();
    let effects = Effects {
        load: Load::Constant { loa_force: 1e9 },
        ..*table.effects()
    };
    let error = table.sliced(&effects).unwrap_err().to_string();
    assert!(error.contains("nominalTorque"), "{error}");
}
