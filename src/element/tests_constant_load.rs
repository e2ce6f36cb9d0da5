//! Claims about the element with constant load, (21)-(24): a secant stiffness at the nominal torque.

use super::testing::{FORMULATIONS, at, compressed, loop_work};
use super::*;
use crate::gear::samples::paper_pair;
use crate::table::TableFile;
use crate::table::samples::Spring;
use approx::assert_relative_eq;
use nalgebra::Rotation3;
use std::f64::consts::TAU;

/// Torque whose force, 80 N, every point of the grid below reaches.
fn nominal_torque() -> f64 {
    80.0 * paper_pair(1.0).gears[0].base_radius()
}

const GRID: [usize; 4] = [10, 5, 7, 12];

/// The paper's pair on the table of a spring that is known by formula.
fn element(parameters: Parameters) -> Element {
    let pair = paper_pair(1.0);
    let torques = [nominal_torque(), 2.0 * nominal_torque()];
    let grid = Spring::grid(GRID);
    let mut file = TableFile::new("spring", "a formula", &pair, torques, &grid, None);
    file.seal();
    let table = Arc::new(Table::from_file(file).unwrap());
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        nominal_torque: nominal_torque(),
        damping: 0.0,
        ..parameters
    };
    Element::new(&pair, &parameters, Some(table)).unwrap()
}

/// At mesh position node `n` and centre distance offset `dc`, gear 2 turned until the elongation is `delta`.
fn pressed(element: &Element, n: usize, dc: f64, delta: f64) -> Inputs {
    let mut inputs = element.nominal_inputs();
    inputs.gears[1].p.x += dc;
    let turn = TAU / 20.0 * n as f64 / GRID[3] as f64;
    let [r1, r2] = [turn, -turn].map(|a| Rotation3::from_axis_angle(&Vector3::z_axis(), a));
    inputs.gears[0].r = *r1.matrix();
    inputs.gears[1].r = *r2.matrix();
    let out = at(element, &inputs);
    let missing = delta - out.transmission_error * element.line_of_action(out.center_distance);
    let more = missing / paper_pair(1.0).gears[1].base_radius();
    inputs.gears[1].r *= Rotation3::from_axis_angle(&Vector3::z_axis(), more).matrix();
    inputs
}

fn loa_force(element: &Element, inputs: &Inputs) -> f64 {
    let out = at(element, inputs);
    out.tangential_force / element.line_of_action(out.center_distance)
}

#[test]
fn the_force_is_the_line_through_the_static_transmission_error_at_the_nominal_torque() {
    for formulation in FORMULATIONS {
        let choice = |load_dependent| {
            element(Parameters {
                formulation,
                load_dependent,
                ..Parameters::default()
            })
        };
        let (variable, constant) = (choice(true), choice(false));
        for n in [0, 2, 7, 9] {
            for dc in [-50e-6, 0.0, 50e-6] {
                // STE by formula: the spring's force over the displacement is the nominal one there.
                let at_node = |delta| crate::table::Query {
                    delta,
                    center_distance_offset: dc,
                    misalignment: 0.0,
                    mesh_position: n as f64 / GRID[3] as f64,
                };
                let (mut low, mut high) = (-1e-6, 20e-6);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if Spring::potential(&at_node(middle)).gradient[0] < 80.0 {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let ste = low;
                let force = |e: &Element, delta: f64| loa_force(e, &pressed(e, n, dc, delta));
                // The table's own error at this load.
                assert_relative_eq!(force(&variable, ste), 80.0, max_relative = 5e-3);
                assert_relative_eq!(force(&constant, ste), 80.0, max_relative = 5e-3);
                let stiffness = force(&constant, ste) / ste;
                for share in [0.2, 0.6, 3.0] {
                    let found = force(&constant, share * ste);
                    assert_relative_eq!(found, stiffness * share * ste, max_relative = 1e-8);
                }
                assert_eq!(force(&constant, -1e-9), 0.0);
            }
        }
    }
}

#[test]
fn closed_loops_do_no_work_but_for_shuttling_that_is_no_gradient() {
    let with = |misalignment_effect, shuttling_effect| {
        element(Parameters {
            load_dependent: false,
            misalignment_effect,
            shuttling_effect,
            ..Parameters::default()
        })
    };
    let worst = |element: &Element, freedoms: &[usize]| {
        let mut start = compressed(element, 1.0, 14e-6);
        start.gears[1].p.x += 20e-6;
        let mut worst = 0.0_f64;
        for (n, &i) in freedoms.iter().enumerate() {
            for &j in &freedoms[..n] {
                let size = [i, j].map(|k| if k % 6 < 3 { 1e-6 } else { 1e-6 / 40e-3 });
                let (work, energy) = loop_work(element, &start, i, j, size);
                worst = worst.max(work.abs() / energy);
            }
        }
        worst
    };
    let all: Vec<usize> = (0..12).collect();
    // Shifts and spins, which leave the axes parallel.
    let parallel = [0, 1, 2, 5, 6, 7, 8, 11];
    let closed = worst(&with(false, false), &all);
    assert!(closed < 1e-9, "{closed:.1e}");
    let closed = worst(&with(true, true), &parallel);
    assert!(closed < 1e-9, "{closed:.1e}");
    // The lever at the nominal load, as in the paper, is not the slope of a secant's energy over M: tilts of
    // 25 urad do work.
    let open = worst(&with(true, true), &all);
    assert!(open > 1e-8, "{open:.1e}");
}

#[test]
fn a_nominal_torque_beyond_the_table_is_refused_by_name() {
    let pair = paper_pair(1.0);
    let grid = Spring::grid(GRID);
    let torques = [nominal_torque(), 2.0 * nominal_torque()];
    let mut file = TableFile::new("spring", "a formula", &pair, torques, &grid, None);
    file.seal();
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        load_dependent: false,
        nominal_torque: 100.0,
        ..Parameters::default()
    };
    let table = Some(Arc::new(Table::from_file(file).unwrap()));
    let Err(error) = Element::new(&pair, &parameters, table) else {
        panic!("accepted");
    };
    let text = error.to_string();
    assert!(
        text.contains("nominalTorque") && text.contains("choose"),
        "{text}"
    );
}

#[test]
fn a_nominal_torque_that_leaves_the_damping_beyond_all_loads_is_refused_by_name() {
    let pair = paper_pair(1.0);
    let torques = [nominal_torque(), 2.0 * nominal_torque()];
    let mut file = TableFile::new(
        "spring",
        "a formula",
        &pair,
        torques,
        &Spring::grid(GRID),
        None,
    );
    file.seal();
    let table = Arc::new(Table::from_file(file).unwrap());
    for (nominal_torque, taken) in [(2.0 * nominal_torque(), true), (1e300, false)] {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            nominal_torque,
            damping_onset: 1.0,
            ..Parameters::default()
        };
        let made = Element::new(&pair, &parameters, Some(table.clone()));
        let said = made.err().map(|error| error.to_string());
        assert_eq!(said.is_none(), taken, "{said:?}");
        assert!(said.is_none_or(|said| said.starts_with("nominalTorque = 1e300 N m: ")));
    }
}
