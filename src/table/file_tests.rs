//! The file round-trips and every defect is refused by name.

use super::*;
use crate::gear::samples::paper_pair;
use crate::table::samples::Spring;
use crate::table::{Effects, Interpolation, Load, Table};

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

const EFFECTS: Effects = Effects {
    interpolation: Interpolation::Spline,
    load: Load::Variable,
    center_distance: false,
    misalignment: true,
    shuttling: true,
    friction: false,
    root_stress: false,
    teeth: false,
};

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
    let first = |hand: f64, change: fn(&mut TableFile)| {
        let mut pair = paper_pair(hand);
        if hand == 0.0 {
            pair.gears
                .iter_mut()
                .for_each(|gear| gear.helix_angle = 0.0);
            pair.gears.iter_mut().for_each(|gear| gear.hand = 1.0);
            pair.center_distance = 0.082;
        }
        let mut f = file();
        (f.version, f.geometry) = (1, pair);
        change(&mut f);
        f.seal();
        TableFile::from_json(&f.to_json())
    };
    let error = first(1.0, |_| ()).unwrap_err().to_string();
    assert!(
        error.contains("version = 1") && error.contains("gearmesh tables"),
        "{error}"
    );
    // What does not depend on it loads.
    assert_eq!(first(0.0, |_| ()).unwrap().version, 1);
    let without = first(1.0, |f| {
        let grid = Spring::grid([8, 1, 1, 6]);
        (f.axes, f.drive) = (grid.axes.clone(), grid.for_file());
        f.drive.moment = None;
    });
    assert_eq!(without.unwrap().version, 1);
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

#[test]
fn defects_are_refused_by_field_even_with_a_good_checksum() {
    let refused = |change: fn(&mut TableFile)| {
        let mut f = file();
        change(&mut f);
        f.seal();
        TableFile::from_json(&f.to_json()).unwrap_err().to_string()
    };
    assert!(refused(|f| f.version = 3).contains("version = 3"));
    assert!(refused(|f| f.format = "other".into()).contains("format = other"));
    assert!(refused(|f| f.drive.loa_force[0] = -1.0).contains("drive.loa_force_n[0] = -1"));
    assert!(refused(|f| f.drive.loa_force.clear()).contains("drive.loa_force_n = 0 values"));
    assert!(refused(|f| f.axes.mesh_position[2] = 0.0).contains("axes.mesh_position[2] = 0"));
    assert!(refused(|f| f.nominal_torque_nm = -1.0).contains("nominal_torque_nm = -1"));
    // The record of root stress, by its name.
    fn record(change: fn(&mut RootStressRecord)) -> Option<RootStressRecord> {
        let table = crate::element::tests::fixtures::rubbing_table(
            &paper_pair(1.0),
            Default::default(),
            false,
        );
        let mut record = table.file().root_stress.clone()?;
        change(&mut record);
        Some(record)
    }
    let named = refused(|f| f.root_stress = record(|r| r.drive.gear_2_pa.truncate(9)));
    assert!(
        named.contains("root_stress.drive.gear_2_pa = 9 values"),
        "{named}"
    );
    let named = refused(|f| f.root_stress = record(|r| r.axes.loa_force_n[0] = 1.0));
    assert!(
        named.contains("root_stress.axes.loa_force_n[0] = 1"),
        "{named}"
    );
    let named = refused(|f| f.root_stress = record(|r| r.axes.mesh_position[2] = 0.0));
    assert!(
        named.contains("root_stress.axes.mesh_position[2] = 0"),
        "{named}"
    );
    // Four such axes would have more samples than can be counted.
    let long = refused(|f| f.axes.misalignment = (0..65_536).map(f64::from).collect());
    assert!(long.contains("at most 10000"), "{long}");
    // Cells at the ends of the spline, which lie outside the nodes: too narrow, they would take memory without bound.
    assert!(refused(|f| f.axes.displacement_fraction[0] = 1e-12).contains("0 and 0.000000000001"));
    assert!(refused(|f| f.axes.mesh_position[5] = 1.0 - 1e-12).contains("closer than 1e-5"));
    // JSON has no NaN: it is written as null and refused as no number.
    assert!(refused(|f| f.drive.moment.as_mut().unwrap()[1] = f64::NAN).contains("null"));
    assert!(
        TableFile::from_json("{}")
            .unwrap_err()
            .to_string()
            .contains("format")
    );
    assert!(TableFile::from_json("").is_err());
}

#[test]
fn damaged_geometry_is_refused_by_field() {
    let text = file().to_json();
    for (from, to, name) in [
        ("\"hand\":1.0", "\"hand\":0.5", "gear1.hand = 0.5"),
        ("\"teeth\":20", "\"teeth\":0", "gear1.teeth = 0"),
        (
            "\"center_distance_m\":0.082104",
            "\"center_distance_m\":0.01",
            "center_distance_m = 0.01",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let mut f: TableFile = serde_json::from_str(&text.replacen(from, to, 1)).unwrap();
        f.seal();
        let error = TableFile::from_json(&f.to_json()).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn an_effect_without_its_axis_is_refused_by_name() {
    let table = Table::from_file(file()).unwrap();
    let error = table
        .sliced(&Effects {
            center_distance: true,
            ..EFFECTS
        })
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("centerDistanceEffect") && error.contains("center_distance_offset_m"),
        "{error}"
    );
    let error = table
        .sliced(&Effects {
            load: Load::Constant { loa_force: 1e9 },
            ..EFFECTS
        })
        .unwrap_err()
        .to_string();
    assert!(error.contains("nominalTorque"), "{error}");
}
