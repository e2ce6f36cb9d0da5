//! Poses that can be no mesh: refused at the start, reported once each time they are entered. Steps, derivatives.

use super::*;
use crate::fmi::resources::{UNIT_VERSION, UnitFile};
use crate::gear::PairGeometry;
use crate::gear::samples::paper_pair;
use crate::table::TableFile;
use crate::table::samples::Spring;

/// An instance of `interface` in initialization mode, in the nominal pose, with these start values besides.
pub(in crate::fmi) fn instance(
    interface: Interface,
    geometry: PairGeometry,
    tables: Option<TableFile>,
    starts: &[(usize, f64)],
) -> Instance {
    let touching = [
        (index::GEAR2_POSITION_1, geometry.center_distance),
        (index::GEAR2_POSITION_3, geometry.gears[1].face_offset),
    ];
    let starts = touching.iter().chain(starts);
    let unit = UnitFile {
        version: UNIT_VERSION,
        guid: "{guid}".into(),
        name: "pair".into(),
        starts: starts
            .map(|&(i, value)| (VARIABLES[i].name.to_owned(), value))
            .collect(),
        geometry,
    };
    let resources = Arc::new(Resources::new(unit, tables, None).unwrap());
    let mut instance = Instance::new(resources, interface);
    instance.state.state = State::InitializationMode;
    instance
}

/// The paper's pair with constant stiffness.
pub(in crate::fmi) fn constant_stiffness(interface: Interface) -> Instance {
    let geometry = paper_pair(1.0);
    instance(interface, geometry, None, &[])
}

/// An instance on a table of a spring with a known potential; `counts` as in [`Spring::grid`].
pub(in crate::fmi) fn on_table(counts: [usize; 4], starts: &[(usize, f64)]) -> Instance {
    let pair = paper_pair(1.0);
    let grid = Spring::grid(counts);
    let torques = [100.0, 200.0];
    let tables = TableFile::new("spring", "a formula", &pair, torques, &grid, None);
    let on_table = [(index::STIFFNESS_MODEL, 2.0), (index::DAMPING, 0.0)];
    let starts = [&on_table, starts].concat();
    instance(Interface::CoSimulation, pair, Some(tables), &starts)
}

fn shipped(name: &str) -> TableFile {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/tables");
    TableFile::read(format!("{folder}/{name}.json")).unwrap()
}

/// An instance on the tables of the paper's pair, in initialization mode, with its nominal centre distance.
fn on_tables(interface: Interface) -> (Instance, f64) {
    let tables = shipped("palermo2013");
    let geometry = tables.geometry.clone();
    let nominal = geometry.center_distance;
    let starts = [
        (index::NOMINAL_TORQUE, tables.nominal_torque_nm),
        (index::STIFFNESS_MODEL, 2.0),
        (index::MISALIGNMENT_EFFECT, 1.0),
    ];
    let instance = instance(interface, geometry, Some(tables), &starts);
    (instance, nominal)
}

pub(in crate::fmi) fn reference(i: usize) -> u32 {
    VARIABLES[i].value_reference
}

pub(in crate::fmi) fn set(instance: &mut Instance, i: usize, value: f64) {
    instance.set(Kind::Real, &[reference(i)], &[value]).unwrap();
}

pub(in crate::fmi) fn get(instance: &mut Instance, i: usize) -> f64 {
    let mut value = f64::NAN;
    let read = instance.get(Kind::Real, &[reference(i)], |x| value = x[0]);
    read.unwrap();
    value
}

fn warnings(instance: &mut Instance) -> Vec<String> {
    let events = instance.take_events().into_iter();
    let warned = events.filter(|(severity, _)| *severity == Severity::Warning);
    warned.map(|(_, text)| text).collect()
}

#[test]
fn a_start_that_can_be_no_mesh_is_refused_with_its_value_and_what_would_be_right() {
    let nominal = on_tables(Interface::CoSimulation).1;
    let [x, z] = [index::GEAR2_POSITION_1, index::GEAR2_POSITION_3];
    let tilt = index::GEAR2_ANGLES_1;
    let far = ["82104.000 mm (nominal 82.104 mm)", "in metres"];
    let apart = [
        "z = 30.000 mm of gear 1 (nominal 0.000 mm)",
        "5.000 mm apart",
    ];
    for (i, value, parts) in [
        (x, 1e3 * nominal, &far[..]),
        (
            x,
            nominal + 10e-3,
            &["92.104 mm (nominal 82.104 mm), in mesh below"],
        ),
        (z, 30e-3, &apart),
        (
            tilt,
            2f64.to_radians(),
            &["jams the teeth", "misalignment", "mrad ("],
        ),
        (x, nominal + 1e-3, &[]),
        (x, nominal - 20e-6, &[]),
        (z, -10e-3, &[]),
        (tilt, 1e-3, &[]),
        (index::GEAR2_ANGLES_2, -1e-3, &[]),
    ] {
        for mut instance in [
            on_tables(Interface::CoSimulation).0,
            constant_stiffness(Interface::CoSimulation),
        ] {
            set(&mut instance, i, value);
            let refused = instance.exit_initialization().err();
            assert_eq!(refused.is_some(), !parts.is_empty(), "{refused:?}");
            let text = refused.map_or(String::new(), |refusal| refusal.message);
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}

#[test]
fn inputs_that_a_host_fills_with_zeros_are_refused_with_where_gear_2_belongs() {
    for geometry in [paper_pair(1.0), shipped("planet-ring-27-84").geometry] {
        let start = format!("gear2.position[1] starts as {} m", geometry.center_distance);
        let mut instance = instance(Interface::CoSimulation, geometry, None, &[]);
        let inputs: Vec<u32> = (0..48).collect();
        instance.set(Kind::Real, &inputs, &[0.0; 48]).unwrap();
        let mut refused = instance.exit_initialization().unwrap_err();
        assert!(refused.message.contains(&start), "{refused}");
        instance.fail(&mut refused);
        assert_eq!(refused.severity, Severity::Error);
        assert_eq!(instance.state(), State::Error);
    }
}

#[test]
fn what_lies_outside_the_tables_is_reported_with_what_they_cover() {
    let (mut instance, _) = on_tables(Interface::CoSimulation);
    set(&mut instance, index::GEAR2_ANGLES_1, 6e-3);
    instance.exit_initialization().unwrap();
    let said = warnings(&mut instance);
    assert!(
        said[0].contains("mrad (tables -4.800 to 4.800)"),
        "{said:?}"
    );
}

#[test]
fn leaving_the_range_is_reported_once_each_time_and_the_flag_goes_with_the_state() {
    let (mut instance, nominal) = on_tables(Interface::CoSimulation);
    instance.exit_initialization().unwrap();
    instance.take_events();
    let mut step = |apart: f64, from: Option<InstanceState>| {
        if let Some(state) = from {
            instance.go_to(state).unwrap();
        }
        set(&mut instance, index::GEAR2_POSITION_1, nominal + apart);
        let time = instance.time();
        instance.do_step(time, 1e-6).unwrap();
        let said = instance.take_events();
        let said = said.into_iter().map(|(_, text)| text);
        (said.collect::<Vec<_>>(), instance.state.clone())
    };
    let (_, within) = step(0.0, None);
    let (said, beyond) = step(10e-3, None);
    let text = "out of range: centre distance 92.104 mm (nominal 82.104 mm)";
    assert!(said.len() == 1 && said[0].contains(text), "{said:?}");
    assert!(step(11e-3, None).0.is_empty());
    assert!(step(0.0, None).0[0].contains("in range again"));
    assert!(step(0.0, None).0.is_empty());
    assert!(step(12e-3, None).0[0].contains("94.104 mm"));
    assert!(step(0.0, Some(within)).0.is_empty(), "it never left");
    assert!(step(11e-3, Some(beyond)).0.is_empty(), "it has been out");
}

#[test]
fn input_derivatives_hold_for_the_coming_step_whether_values_are_set_before_or_after() {
    let turn = index::GEAR1_ANGLES_3;
    let force = |sets: [bool; 2]| {
        let mut instance = constant_stiffness(Interface::CoSimulation);
        instance.exit_initialization().unwrap();
        for is_value in sets {
            if is_value {
                set(&mut instance, turn, 1e-5);
            } else {
                let rate = instance.set_input_derivatives(&[reference(turn)], &[1], &[10.0]);
                rate.unwrap();
            }
        }
        instance.do_step(0.0, 1e-5).unwrap();
        let first = get(&mut instance, index::MESH_NORMAL_FORCE);
        // The next step has none.
        instance.do_step(1e-5, 1e-5).unwrap();
        assert_eq!(get(&mut instance, index::MESH_NORMAL_FORCE), first);
        assert!((get(&mut instance, turn) - 1.1e-4).abs() < 1e-18);
        first
    };
    let before = force([true, false]);
    assert!(before > 100.0);
    assert_eq!(force([false, true]), before);
}

#[test]
fn range_warnings_come_with_the_outputs_and_end_after_a_hundred() {
    let (mut instance, nominal) = on_tables(Interface::ModelExchange);
    instance.exit_initialization().unwrap();
    instance.state.state = State::ContinuousTimeMode;
    let mut said = Vec::new();
    for round in 0..150 {
        for apart in [10e-3, 11e-3, 0.0] {
            set(&mut instance, index::GEAR2_POSITION_1, nominal + apart);
            // Inputs tell nothing of the range.
            get(&mut instance, index::GEAR2_POSITION_1);
            let out_of_range = get(&mut instance, index::MESH_OUT_OF_RANGE);
            assert_eq!(out_of_range, f64::from(u8::from(apart > 0.0)));
            get(&mut instance, index::MESH_FLANK);
        }
        said.extend(warnings(&mut instance));
        assert_eq!(said.len(), (round + 1).min(101));
    }
    assert!(said[99].contains("centre distance"), "{}", said[99]);
    assert!(said[100].contains("no more warnings"), "{}", said[100]);
}

#[test]
fn a_parameter_that_makes_no_element_is_an_error_and_a_pose_without_outputs_is_discarded() {
    for (i, value, severity) in [
        (index::BACKLASH, 1.0, Severity::Error),
        (index::GEAR2_ANGLES_1, 1.0, Severity::Discard),
        (index::GEAR2_POSITION_1, 0.0, Severity::Discard),
    ] {
        let mut instance = constant_stiffness(Interface::CoSimulation);
        set(&mut instance, i, value);
        let refused = instance.exit_initialization().unwrap_err();
        assert_eq!(refused.severity, severity, "{refused}");
    }
}

#[test]
fn in_initialization_mode_there_are_derivatives_by_real_parameters() {
    let mut instance = constant_stiffness(Interface::CoSimulation);
    let absolute = [reference(index::PHASE_REFERENCE)];
    instance.set(Kind::Enumeration, &absolute, &[2]).unwrap();
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
    let along = |instance: &mut Instance, i: usize| {
        instance.directional_derivative(&outputs.map(reference), &[reference(i)], &[2.0])
    };
    let stiffness = get(&mut instance, index::CONSTANT_STIFFNESS);
    let found = along(&mut instance, index::CONSTANT_STIFFNESS).unwrap();
    let right = [
        2.0 * values[0] / stiffness,
        2.0 * values[1] / stiffness,
        0.0,
    ];
    for (slope, right) in found.iter().zip(right) {
        assert!((slope - right).abs() <= 1e-8 * right, "{slope} {right}");
    }
    for (i, variable) in VARIABLES.iter().enumerate().skip(FIRST_PARAMETER) {
        if variable.kind == Kind::Real {
            let slopes = along(&mut instance, i).unwrap();
            let finite = slopes.iter().all(|x| x.is_finite());
            assert!(finite, "{}: {slopes:?}", variable.name);
        }
    }
    instance.exit_initialization().unwrap();
    let refused = along(&mut instance, index::CONSTANT_STIFFNESS).unwrap_err();
    assert!(
        refused.message.contains("Initialization Mode alone"),
        "{refused}"
    );
}

#[test]
fn the_derivative_of_the_mesh_position_goes_on_through_its_seam() {
    let mut instance = constant_stiffness(Interface::CoSimulation);
    let position = [reference(index::MESH_POSITION)];
    // A pitch of 20 teeth is 2 pi / 20 of phase.
    let right = 20.0 / std::f64::consts::TAU;
    for phase in [0.0, 0.1, std::f64::consts::TAU / 20.0] {
        set(&mut instance, index::MESH_PHASE, phase);
        let known = [reference(index::MESH_PHASE)];
        let slopes = instance.directional_derivative(&position, &known, &[1.0]);
        let slope = slopes.unwrap()[0];
        assert!((slope / right - 1.0).abs() < 1e-6, "{phase}: {slope}");
    }
}

#[test]
fn a_derivative_that_overflows_is_refused_with_its_output() {
    let mut instance = constant_stiffness(Interface::CoSimulation);
    let absolute = [reference(index::PHASE_REFERENCE)];
    instance.set(Kind::Enumeration, &absolute, &[2]).unwrap();
    let turn = -std::f64::consts::PI / 20.0;
    set(&mut instance, index::GEAR1_ANGLES_3, turn + 1e-4);
    let unknown = [reference(index::MESH_NORMAL_FORCE)];
    for i in [
        index::CONSTANT_STIFFNESS,
        index::BACKLASH,
        index::MESH_PHASE,
        index::GEAR1_ANGLES_3,
    ] {
        let found = instance.directional_derivative(&unknown, &[reference(i)], &[1e308]);
        let is_right = match &found {
            Ok(slopes) => slopes[0].is_finite(),
            Err(refused) => refused.message.contains("mesh.normalForce"),
        };
        assert!(is_right, "{}: {found:?}", VARIABLES[i].name);
    }
}

#[test]
fn outputs_that_overflow_are_refused_with_the_input_or_parameter_out_of_all_proportion() {
    for (i, value, named) in [
        (index::DAMPING, 1e308, "damping = 1e308"),
        (
            index::GEAR1_ANGULAR_VELOCITY_3,
            1e307,
            "gear1.angularVelocity[3] = 1e307",
        ),
    ] {
        let mut instance = constant_stiffness(Interface::CoSimulation);
        let absolute = [reference(index::PHASE_REFERENCE)];
        instance.set(Kind::Enumeration, &absolute, &[2]).unwrap();
        let turn = -std::f64::consts::PI / 20.0;
        set(&mut instance, index::GEAR1_ANGLES_3, turn + 1e-4);
        set(&mut instance, index::GEAR1_ANGULAR_VELOCITY_3, 1e3);
        set(&mut instance, i, value);
        let refused = match instance.exit_initialization() {
            Err(refused) => refused,
            Ok(()) => instance.do_step(0.0, 1e-5).unwrap_err(),
        };
        assert!(refused.message.contains(named), "{refused}");
    }
}

#[test]
fn derivatives_by_parameters_share_the_interpolants_of_the_tables() {
    let (mut instance, _) = on_tables(Interface::CoSimulation);
    let unknown = [reference(index::MESH_NORMAL_FORCE)];
    let known = [reference(index::DAMPING)];
    instance
        .directional_derivative(&unknown, &known, &[1.0])
        .unwrap();
    assert_eq!(instance.resources.interpolants(), 1);
}

#[test]
fn a_tunable_parameter_may_be_set_to_its_own_value_at_any_time() {
    let mut instance = constant_stiffness(Interface::ModelExchange);
    let damping = get(&mut instance, index::DAMPING);
    instance.exit_initialization().unwrap();
    instance.state.state = State::ContinuousTimeMode;
    let write = |instance: &mut Instance, value: f64| {
        instance.set(Kind::Real, &[reference(index::DAMPING)], &[value])
    };
    write(&mut instance, damping).unwrap();
    let refused = write(&mut instance, damping + 1.0).unwrap_err();
    assert!(
        refused.message.contains("changes at events only"),
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
        let mut instance = constant_stiffness(Interface::CoSimulation);
        set(&mut instance, index::CONSTANT_STIFFNESS, 1e308);
        set(&mut instance, i, value);
        let mut outcome = instance.exit_initialization();
        if outcome.is_ok() {
            set(&mut instance, index::GEAR1_ANGLES_3, 1e-3);
            outcome = instance.do_step(0.0, 1e-6);
        }
        if let Err(refused) = outcome {
            assert!(refused.message.len() < 500, "{refused}");
        }
    }
}
