//! What is measured: evaluations of tables, of the element and of contact at run time at fixed points, by name.

mod contact;
#[path = "../../tests/common/spring.rs"]
mod spring;

use gearmesh::element::{
    BODY_COLUMNS, Direction, Element, Formulation, Inputs, Jacobian, LoadedFlank, Parameters,
    StiffnessModel,
};
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::{Resources, UNIT_VERSION, UnitFile};
use gearmesh::fmi::variables::{INPUTS, Kind, VARIABLES, index};
use gearmesh::random::Random;
use gearmesh::table::{FlankTable, Interpolation, Query, Table, TableFile};
use gearmesh_preprocessor::pair;
use nalgebra::{Rotation3, Vector3};
use spring::Spring;
use std::hint::black_box;
use std::sync::Arc;

/// Points that each case walks through, so that an evaluation meets another cell than the last one.
pub const POINTS: usize = 1024;

/// An evaluation; the argument counts up.
pub type Run = Box<dyn FnMut(usize)>;

/// A named evaluation, made only when it is wanted.
pub struct Case {
    pub name: String,
    pub make: Box<dyn FnOnce() -> Run>,
}

const INTERPOLATIONS: [(Interpolation, &str); 3] = [
    (Interpolation::Linear, "linear"),
    (Interpolation::Spline, "spline"),
    (Interpolation::Shepard, "shepard"),
];

fn queries() -> Vec<Query> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut next = || random.next();
    (0..POINTS)
        .map(|_| {
            let (c, m) = (200e-6 * next() - 100e-6, 6e-3 * next() - 3e-3);
            Query {
                delta: 1e-6 * (0.7 + 6.0 * next()) + 3e-3 * c - 0.2 * m * m,
                center_distance_offset: c,
                misalignment: m,
                mesh_position: next(),
            }
        })
        .collect()
}

/// Tables of one to four dimensions under every interpolant.
fn kernels(cases: &mut Vec<Case>) {
    let shapes = [
        ("1d", [10, 1, 1, 1]),
        ("2d", [10, 1, 1, 32]),
        ("3d", [10, 1, 9, 32]),
        ("4d", [10, 9, 9, 32]),
    ];
    for (interpolation, name) in INTERPOLATIONS {
        for (dimensions, counts) in shapes {
            for (what, hessian) in [("value", false), ("gradient", true)] {
                cases.push(Case {
                    name: format!("kernel/{name}/{dimensions}/{what}"),
                    make: Box::new(move || kernel(counts, interpolation, hessian)),
                });
            }
        }
    }
}

fn kernel(counts: [usize; 4], interpolation: Interpolation, hessian: bool) -> Run {
    let mut grid = Spring::grid(counts);
    grid.moment = None;
    let table = FlankTable::new(&grid, interpolation).expect("a legal grid");
    let queries = queries();
    Box::new(move |i| {
        black_box(table.evaluate(black_box(&queries[i % POINTS]), hessian));
    })
}

/// Poses that load the drive flank by some micrometres.
fn poses(element: &Element) -> Vec<Inputs> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut next = || random.next();
    let mut both = move |x: f64| x * (2.0 * next() - 1.0);
    (0..POINTS)
        .map(|_| {
            let mut x = element.nominal_inputs();
            let turn = both(3.0);
            let spin = |a: f64| *Rotation3::from_axis_angle(&Vector3::z_axis(), a).matrix();
            x.gears[0].r = spin(turn + 1.2e-4 + both(4e-5));
            x.gears[1].r =
                Rotation3::from_euler_angles(both(1e-4), both(1e-4), 0.0).matrix() * spin(-turn);
            x.gears[0].w = Vector3::z() * 100.0;
            x.gears[1].w = Vector3::z() * -100.0;
            x
        })
        .collect()
}

/// The element with constant stiffness and with a 4-D table.
fn elements(cases: &mut Vec<Case>) {
    let springs = [(StiffnessModel::Constant, Interpolation::Spline, "constant")];
    let tables = INTERPOLATIONS.map(|(i, name)| (StiffnessModel::Table, i, name));
    for formulation in [Formulation::Conjugate, Formulation::Paper] {
        for (stiffness_model, interpolation, name) in springs.into_iter().chain(tables) {
            let parameters = Parameters {
                stiffness_model,
                interpolation,
                formulation,
                loaded_flank: LoadedFlank::Both,
                ..Parameters::default()
            };
            for ask in [Ask::Wrench, Ask::DirectionalDerivative, Ask::Jacobian] {
                cases.push(Case {
                    name: format!("element/{formulation:?}/{name}/{ask}").to_lowercase(),
                    make: Box::new(move || element(&parameters, ask)),
                });
            }
        }
    }
}

/// What an element is asked for.
#[derive(Debug, Clone, Copy)]
enum Ask {
    Wrench,
    DirectionalDerivative,
    Jacobian,
}

impl std::fmt::Display for Ask {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Ask::Wrench => "wrench",
            Ask::DirectionalDerivative => "directional-derivative",
            Ask::Jacobian => "jacobian",
        })
    }
}

fn element(parameters: &Parameters, ask: Ask) -> Run {
    let pair = pair::from_json(include_str!("../../resources/pairs/palermo2013.json"))
        .expect("a shipped pair");
    let grid = Spring::grid([10, 9, 9, 32]);
    let file = TableFile::new(
        "bench",
        "formula",
        &pair.geometry,
        [100.0, 200.0],
        &grid,
        None,
    );
    let table = Arc::new(Table::from_file(file).expect("a legal table"));
    let element = Element::new(&pair.geometry, parameters, Some(table)).expect("legal parameters");
    let phase = element
        .phase_offset(&element.nominal_inputs())
        .expect("a mesh");
    let poses = poses(&element);
    let loaded = poses
        .iter()
        .filter(|x| element.evaluate(&phase, x).is_ok_and(|y| y.flank != 0))
        .count();
    assert!(10 * loaded > 9 * POINTS, "only {loaded} poses in contact");
    // Gear 1 turns, gear 2 moves.
    let mut direction = Direction::zeros();
    direction[5] = 1.0;
    direction
        .fixed_rows_mut::<3>(BODY_COLUMNS)
        .copy_from_slice(&[1e-2, 2e-2, 3e-2]);
    let mut jacobian = Jacobian::zeros();
    Box::new(move |i| {
        let x = black_box(&poses[i % POINTS]);
        match ask {
            Ask::Wrench => {
                let _ = black_box(element.evaluate(&phase, x));
            }
            Ask::DirectionalDerivative => {
                let _ = element.jacobian(&phase, x, &mut jacobian);
                let slopes: &Jacobian = &jacobian; // a product with the matrix itself would copy it
                black_box(slopes * direction);
            }
            Ask::Jacobian => {
                let _ = black_box(element.jacobian(&phase, x, &mut jacobian));
            }
        }
    })
}

/// A communication step of the FMU as hosts make it, but for the call boundary: all inputs set, the step, the main outputs read.
fn steps(cases: &mut Vec<Case>) {
    for (coupling, name) in [(1.0, "held"), (4.0, "automatic")] {
        for (model, stiffness) in [(1.0, "constant"), (2.0, "spline")] {
            cases.push(Case {
                name: format!("step/{name}/{stiffness}"),
                make: Box::new(move || step(coupling, model)),
            });
        }
    }
}

/// Outputs that a host reads in one call: loads, contact point and what follows in one block.
const MAIN_OUTPUTS: usize = 24;

fn step(coupling: f64, stiffness_model: f64) -> Run {
    const LENGTH: f64 = 1e-6;
    /// Of gear 1, kg m², N m s.
    const INERTIA: f64 = 4e-4;
    /// See there.
    const DAMPING: f64 = 1.0;
    /// Of gear 1 about its axis, among the outputs.
    const MOMENT: usize = index::GEAR1_MOMENT_3 - INPUTS;
    let tables = TableFile::from_json(include_str!("../../resources/tables/palermo2013.json"))
        .expect("shipped tables");
    let geometry = tables.geometry.clone();
    let starts = [
        (index::GEAR2_POSITION_1, geometry.center_distance),
        (index::STIFFNESS_MODEL, stiffness_model),
        (index::COUPLING, coupling),
        (
            index::CENTER_DISTANCE_EFFECT,
            f64::from(u8::from(stiffness_model > 1.0)),
        ),
        (
            index::MISALIGNMENT_EFFECT,
            f64::from(u8::from(stiffness_model > 1.0)),
        ),
        (
            index::SHUTTLING_EFFECT,
            f64::from(u8::from(stiffness_model > 1.0)),
        ),
    ];
    let unit = UnitFile {
        version: UNIT_VERSION,
        guid: String::new(),
        name: "bench".into(),
        starts: starts
            .map(|(i, value)| (VARIABLES[i].name.to_owned(), value))
            .into(),
        geometry,
    };
    let resources = Resources::new(unit, Some(tables), None).expect("a legal FMU");
    let mut inputs: Vec<f64> = resources.starts[..INPUTS].to_vec();
    let mut fmu = Instance::new(Arc::new(resources), Interface::CoSimulation);
    fmu.setup(0.0, None).expect("a start time");
    fmu.exit_initialization().expect("a mesh");
    let references: Vec<u32> = VARIABLES.iter().map(|v| v.value_reference).collect();
    let outputs = INPUTS..INPUTS + MAIN_OUTPUTS;
    let (mut angle, mut rate, mut moment) = (1.3e-4, 0.0, 0.0);
    Box::new(move |i| {
        // Both gears turn. Gear 1 swings beside it as a body under the moment of the contact, which keeps the teeth together, and a
        // torque that swings, too.
        let time = i as f64 * LENGTH;
        inputs[index::GEAR1_ANGLES_3] = 100.0 * time + angle;
        inputs[index::GEAR1_ANGULAR_VELOCITY_3] = 100.0 + rate;
        inputs[index::GEAR2_ANGLES_3] = -100.0 * time;
        inputs[index::GEAR2_ANGULAR_VELOCITY_3] = -100.0;
        fmu.set(Kind::Real, &references[..INPUTS], &inputs)
            .expect("legal inputs");
        fmu.do_step(time, LENGTH).expect("a step");
        fmu.get(Kind::Real, &references[outputs.clone()], |values| {
            moment = black_box(values)[MOMENT];
        })
        .expect("outputs");
        let torque = 100.0 + 50.0 * (4e4 * time).sin();
        let acceleration = (moment + torque - DAMPING * rate) / INERTIA;
        angle += LENGTH * (rate + 0.5 * LENGTH * acceleration);
        rate += LENGTH * acceleration;
    })
}

/// Everything.
pub fn all() -> Vec<Case> {
    let mut cases = vec![];
    kernels(&mut cases);
    elements(&mut cases);
    cases.push(Case {
        name: "contact/run-time".into(),
        make: Box::new(contact::at_run_time),
    });
    steps(&mut cases);
    cases
}
