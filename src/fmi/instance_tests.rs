//! Poses that can be no mesh: refused at the start, reported once each time they are entered. Steps, derivatives.

use super::*;
use crate::fmi::resources::{UNIT_VERSION, UnitFile};
use crate::fmi::variables::index_by_name;
use crate::gear::PairGeometry;
use crate::table::TableFile;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/tables/");

fn shipped(name: &str) -> TableFile {
    TableFile::read(format!("{FOLDER}{name}.json")).unwrap()
}

/// An instance in initialization mode, in the nominal pose; without tables on constant stiffness.
fn start(geometry: PairGeometry, tables: Option<TableFile>) -> Instance {
    started_for(Interface::CoSimulation, geometry, tables)
}

/// The same through `interface`.
fn started_for(
    interface: Interface,
    geometry: PairGeometry,
    tables: Option<TableFile>,
) -> Instance {
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
    let mut instance = Instance::new(resources, interface);
    instance.enter(State::InitializationMode);
    instance
}

fn set(instance: &mut Instance, i: usize, value: f64) {
    let reference = VARIABLES[i].value_reference;
    instance.set_real(&[reference], &[value]).unwrap();
}

fn paper() -> (PairGeometry, TableFile) {
    let tables = shipped("palermo2013");
    (tables.geometry.clone(), tables)
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
            Event::Warning(text) => Some(text),
            Event::Info(_) => None,
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
        [0, tables.axes.misalignment.len() - 1].map(|i| 1e3 * tables.axes.misalignment[i]);
    let mut instance = start(geometry, Some(tables));
    set(&mut instance, index::GEAR2_ANGLES_1, 4e-3);
    instance.exit_initialization().unwrap();
    let said = instance.take_events();
    let range = format!("mrad (tables {low:.3} to {high:.3})");
    assert!(
        matches!(&said[..], [Event::Warning(text), ..] if text.contains(&range)),
        "{said:?}"
    );
}

fn get(instance: &mut Instance, i: usize) -> f64 {
    let mut value = f64::NAN;
    let reference = VARIABLES[i].value_reference;
    instance.get_real(&[reference], |x| value = x).unwrap();
    value
}

fn warnings(instance: &mut Instance) -> Vec<String> {
    let events = instance.take_events().into_iter();
    let warned = events.filter_map(|event| match event {
        Event::Warning(text) => Some(text),
        Event::Info(_) => None,
    });
    warned.collect()
}

#[test]
fn range_warnings_need_no_call_beside_the_outputs_and_end_after_a_hundred() {
    let (geometry, tables) = paper();
    let nominal = geometry.center_distance;
    let mut instance = started_for(Interface::ModelExchange, geometry, Some(tables));
    instance.exit_initialization().unwrap();
    instance.enter(State::ContinuousTimeMode);
    let mut said = Vec::new();
    for round in 0..150 {
        for apart in [10e-3, 11e-3, 0.0] {
            set(&mut instance, index::GEAR2_POSITION_1, nominal + apart);
            let out_of_range = get(&mut instance, index::MESH_OUT_OF_RANGE);
            assert_eq!(out_of_range, f64::from(u8::from(apart > 0.0)));
            // Reading on says nothing again.
            get(&mut instance, index::MESH_FLANK);
        }
        said.extend(warnings(&mut instance));
        assert_eq!(said.len(), (round + 1).min(101));
    }
    assert!(said[99].contains("centre distance"), "{}", said[99]);
    assert!(said[100].contains("no more warnings"), "{}", said[100]);
}

#[test]
fn the_range_flag_goes_with_the_state() {
    let (geometry, tables) = paper();
    let nominal = geometry.center_distance;
    let mut instance = start(geometry, Some(tables));
    instance.exit_initialization().unwrap();
    let within = instance.state.clone();
    set(&mut instance, index::GEAR2_POSITION_1, nominal + 10e-3);
    instance.do_step(0.0, 1e-6).unwrap();
    assert_eq!(warnings(&mut instance).len(), 1);
    let beyond = instance.state.clone();
    instance.go_to(within).unwrap();
    instance.do_step(0.0, 1e-6).unwrap();
    assert_eq!(instance.take_events(), [], "it never left the range");
    instance.go_to(beyond).unwrap();
    set(&mut instance, index::GEAR2_POSITION_1, nominal + 11e-3);
    instance.do_step(1e-6, 1e-6).unwrap();
    assert_eq!(instance.take_events(), [], "it has been out before");
}

#[test]
fn input_derivatives_hold_for_the_coming_step_whether_values_are_set_before_or_after() {
    let turn = VARIABLES[index::GEAR1_ANGLES_3].value_reference;
    let force = |sets: [bool; 2]| {
        let mut instance = start(paper().0, None);
        instance.exit_initialization().unwrap();
        for is_value in sets {
            if is_value {
                set(&mut instance, index::GEAR1_ANGLES_3, 1e-5);
            } else {
                let rate = std::iter::once((turn, 1, 10.0));
                instance.set_input_derivatives(rate).unwrap();
            }
        }
        instance.do_step(0.0, 1e-5).unwrap();
        let first = get(&mut instance, index::MESH_NORMAL_FORCE);
        // The next step has none.
        instance.do_step(1e-5, 1e-5).unwrap();
        assert_eq!(get(&mut instance, index::MESH_NORMAL_FORCE), first);
        assert!((get(&mut instance, index::GEAR1_ANGLES_3) - 1.1e-4).abs() < 1e-18);
        first
    };
    let before = force([true, false]);
    assert!(before > 100.0);
    assert_eq!(force([false, true]), before);
}

#[test]
fn a_pose_that_cannot_be_discards_the_step_and_the_same_again_is_an_error() {
    let mut instance = start(paper().0, None);
    instance.exit_initialization().unwrap();
    let mut tried = |tilt: f64, step: f64| {
        set(&mut instance, index::GEAR2_ANGLES_1, tilt);
        let refused = instance.do_step(0.0, step).unwrap_err();
        assert!(refused.message.contains("tilted"), "{refused}");
        refused.severity
    };
    assert_eq!(tried(0.2, 1e-5), Severity::Discard);
    assert_eq!(tried(0.2, 5e-6), Severity::Discard);
    assert_eq!(tried(0.15, 5e-6), Severity::Discard);
    assert_eq!(tried(0.15, 5e-6), Severity::Error);
    set(&mut instance, index::GEAR2_ANGLES_1, 0.0);
    instance.do_step(0.0, 1e-5).unwrap();
    // What a host may not ask at all is an error as before.
    let refused = instance.do_step(5.0, 1e-5).unwrap_err();
    assert_eq!(refused.severity, Severity::Error);
}

#[test]
fn in_initialization_mode_there_are_derivatives_by_real_parameters() {
    let mut instance = start(paper().0, None);
    let absolute = VARIABLES[index::PHASE_REFERENCE].value_reference;
    let chosen = instance.set_discrete("set", Kind::Integer, &[absolute], &[2]);
    chosen.unwrap();
    // At zero angles a tooth faces a tooth.
    let turn = -std::f64::consts::PI / 20.0;
    set(&mut instance, index::GEAR1_ANGLES_3, turn + 1e-4);
    let outputs = [
        index::MESH_NORMAL_FORCE,
        index::MESH_STIFFNESS,
        index::MESH_TRANSMISSION_ERROR,
    ];
    let values = outputs.map(|i| get(&mut instance, i));
    assert!(values[0] > 1000.0);
    let references = outputs.map(|i| VARIABLES[i].value_reference);
    let along = |instance: &mut Instance, i: usize| {
        let known = VARIABLES[i].value_reference;
        instance.directional_derivative(&references, &[known], &[2.0])
    };
    let stiffness = get(&mut instance, index::CONSTANT_STIFFNESS);
    let found = along(&mut instance, index::CONSTANT_STIFFNESS).unwrap();
    for (slope, right) in found.iter().zip([
        2.0 * values[0] / stiffness,
        2.0 * values[1] / stiffness,
        0.0,
    ]) {
        assert!((slope - right).abs() <= 1e-8 * right, "{slope} {right}");
    }
    // A fixed parameter is none of the things that change later.
    let count = VARIABLES
        .iter()
        .filter(|v| v.causality == Causality::Parameter);
    for v in count.filter(|v| v.kind == Kind::Real) {
        let i = index_by_name(v.name).unwrap();
        let slopes = along(&mut instance, i).unwrap();
        assert!(
            slopes.iter().all(|x| x.is_finite()),
            "{}: {slopes:?}",
            v.name
        );
    }
    instance.exit_initialization().unwrap();
    let refused = along(&mut instance, index::CONSTANT_STIFFNESS).unwrap_err();
    assert!(
        refused.message.contains("Initialization Mode alone"),
        "{refused}"
    );
}

#[test]
fn numbers_out_of_all_proportion_are_refused_in_few_digits() {
    for (i, value) in [
        (index::CONSTANT_STIFFNESS, 1e308),
        (index::NOMINAL_TORQUE, 1e308),
        (index::BACKLASH, 1e308),
        (index::GEAR2_POSITION_1, 1e308),
        (index::GEAR2_ANGLES_1, 1e-3),
    ] {
        let mut instance = start(paper().0, None);
        set(&mut instance, index::CONSTANT_STIFFNESS, 1e308);
        set(&mut instance, i, value);
        if let Err(refused) = instance.exit_initialization() {
            assert!(refused.message.len() < 500, "{refused}");
            continue;
        }
        set(&mut instance, index::GEAR1_ANGLES_3, 1e-3);
        if let Err(refused) = instance.do_step(0.0, 1e-6) {
            assert!(refused.message.len() < 500, "{refused}");
        }
    }
    let mut instance = start(paper().0, None);
    let damping = VARIABLES[index::DAMPING].value_reference;
    let refused = instance.set_real(&[damping], &[-1e308]).unwrap_err();
    assert_eq!(
        refused.message,
        "fmi2SetReal: damping = -1e308; set 0 or more"
    );
}

#[test]
fn inputs_that_a_host_fills_with_zeros_are_told_where_gear_2_belongs() {
    let rings = shipped("planet-ring-27-84").geometry;
    for geometry in [paper().0, rings] {
        let place = format!("gear2.position[1] starts as {} m", geometry.center_distance);
        let mut instance = start(geometry, None);
        let inputs: Vec<u32> = (0..48).collect();
        instance.set_real(&inputs, &[0.0; 48]).unwrap();
        let refused = instance.exit_initialization().unwrap_err();
        assert_eq!(refused.severity, Severity::Error);
        assert!(refused.message.contains(&place), "{refused}");
    }
}
