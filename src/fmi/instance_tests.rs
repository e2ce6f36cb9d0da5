//! Poses that can be no mesh: refused at the start, told once each time they are come to.

use std::sync::Arc;

use super::instance::Instance;
use super::lifecycle::{Interface, State};
use super::report::{Event, Refusal};
use super::resources::{Resources, UNIT_VERSION, UnitFile};
use super::variables::{VARIABLES, index};
use crate::gear::PairGeometry;
use crate::table::TableFile;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/tables/");

fn shipped(name: &str) -> TableFile {
    TableFile::read(format!("{FOLDER}{name}.json")).unwrap()
}

/// An instance in initialization mode, in the nominal pose; without tables on constant stiffness.
fn start(geometry: PairGeometry, tables: Option<TableFile>) -> Instance {
    let [torque, _] = tables.as_ref().map_or([100.0, 200.0], |t| {
        [t.nominal_torque_nm, t.maximum_torque_nm]
    });
    let unit = UnitFile {
        version: UNIT_VERSION,
        guid: "{guid}".into(),
        name: "paper".into(),
        starts: [
            ("gear2.position[1]".to_owned(), geometry.center_distance),
            (
                "gear2.position[3]".to_owned(),
                geometry.gears[1].face_offset,
            ),
            ("nominalTorque".to_owned(), torque),
            (
                "stiffnessModel".to_owned(),
                if tables.is_some() { 2.0 } else { 1.0 },
            ),
            (
                "misalignmentEffect".to_owned(),
                f64::from(u8::from(tables.is_some())),
            ),
        ]
        .into(),
        geometry,
    };
    let resources = Arc::new(Resources::new(unit, tables, None).unwrap());
    let mut instance = Instance::new(resources, Interface::CoSimulation);
    instance.enter(State::InitializationMode);
    instance
}

fn set(instance: &mut Instance, i: usize, value: f64) {
    let reference = VARIABLES[i].value_reference;
    instance.set_real(&[reference], &[value]).unwrap();
}

fn paper() -> (PairGeometry, TableFile) {
    let tables = shipped("palermo2013");
    (tables.geometry.pair_geometry().unwrap(), tables)
}

fn started_with(i: usize, value: f64, tables: bool) -> Result<(), Refusal> {
    let (geometry, file) = paper();
    let mut instance = start(geometry, tables.then_some(file));
    set(&mut instance, i, value);
    instance.exit_initialization()
}

#[test]
fn a_start_that_can_be_no_mesh_is_refused_with_its_value_and_what_would_be_right() {
    let nominal = paper().0.center_distance;
    for tables in [true, false] {
        for (i, value, parts) in [
            (
                index::GEAR2_POSITION_1,
                1e3 * nominal,
                vec![
                    "centre distance 82104.000 mm (nominal 82.104 mm)",
                    "in metres",
                ],
            ),
            (
                index::GEAR2_POSITION_1,
                nominal + 10e-3,
                vec!["centre distance 92.104 mm (nominal 82.104 mm), in mesh below"],
            ),
            (
                index::GEAR2_POSITION_3,
                30e-3,
                vec![
                    "z = 30.000 mm of gear 1 (nominal 0.000 mm)",
                    "5.000 mm apart",
                ],
            ),
            (
                index::GEAR2_ANGLES_1,
                2f64.to_radians(),
                vec!["jams the teeth", "misalignment", "mrad ("],
            ),
        ] {
            let said = started_with(i, value, tables).unwrap_err().message;
            for part in parts {
                assert!(said.contains(part), "{said}");
            }
        }
    }
}

#[test]
fn a_start_within_reach_is_none_of_these() {
    let nominal = paper().0.center_distance;
    for tables in [true, false] {
        for (i, value) in [
            (index::GEAR2_POSITION_1, nominal + 1e-3),
            (index::GEAR2_POSITION_1, nominal - 20e-6),
            (index::GEAR2_POSITION_3, -10e-3),
            (index::GEAR2_ANGLES_1, 1e-3),
            (index::GEAR2_ANGLES_2, -1e-3),
        ] {
            started_with(i, value, tables).unwrap();
        }
    }
}

#[test]
fn gears_lifted_apart_later_are_told_once_each_time() {
    let (geometry, tables) = paper();
    let nominal = geometry.center_distance;
    let mut instance = start(geometry, Some(tables));
    instance.exit_initialization().unwrap();
    let mut warnings = Vec::new();
    let mut time = 0.0;
    for center_distance in [0.0, 10e-3, 11e-3, 0.0, 0.0, 12e-3, 0.0].map(|apart| nominal + apart) {
        set(&mut instance, index::GEAR2_POSITION_1, center_distance);
        instance.do_step(time, 1e-6).unwrap();
        time += 1e-6;
        warnings.extend(instance.take_events().into_iter().filter_map(|e| match e {
            Event::Warned(text) => Some(text),
            Event::Told(_) => None,
        }));
    }
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("out of range: centre distance 92.104 mm (nominal 82.104 mm)"));
    assert!(warnings[1].contains("94.104 mm"));
}

#[test]
fn what_lies_outside_the_tables_is_told_with_what_they_cover() {
    let (geometry, tables) = paper();
    let [low, high] =
        [0, tables.axes.misalignment_rad.len() - 1].map(|i| 1e3 * tables.axes.misalignment_rad[i]);
    let mut instance = start(geometry, Some(tables));
    set(&mut instance, index::GEAR2_ANGLES_1, 4e-3);
    instance.exit_initialization().unwrap();
    let said = instance.take_events();
    let range = format!("mrad (tables {low:.3} to {high:.3})");
    assert!(
        matches!(&said[..], [Event::Warned(text), ..] if text.contains(&range)),
        "{said:?}"
    );
}
