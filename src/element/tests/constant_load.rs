//! Claims about the element with constant load, (21)-(24): a secant stiffness at the nominal torque.

use super::*;
use crate::root::bisection;
use crate::table::Query;
use crate::table::samples::Spring;

const GRID: [usize; 4] = [10, 5, 7, 12];

/// The paper's pair on the table of a spring that is known by formula; at the nominal torque the force is 80 N, which every
/// point of the grid reaches.
fn element(parameters: Parameters) -> Element {
    let pair = paper_pair(1.0);
    let nominal_torque = 80.0 * pair.gears[0].base_radius();
    let table = sealed(spring_file(
        &pair,
        [nominal_torque, 2.0 * nominal_torque],
        GRID,
    ));
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        nominal_torque,
        damping: 0.0,
        ..parameters
    };
    Element::new(&pair, &parameters, Some(table)).unwrap()
}

/// At mesh position node `n` and centre distance offset `dc`, gear 2 turned until the approach is `delta`.
fn pressed(element: &Element, n: usize, dc: f64, delta: f64) -> Inputs {
    let mut inputs = element.nominal_inputs();
    inputs.gears[1].p.x += dc;
    let turn = TAU / 20.0 * n as f64 / GRID[3] as f64;
    inputs = spun(&spun(&inputs, 0, turn), 1, -turn);
    let out = at(element, &inputs);
    let missing = delta - out.transmission_error * element.line_of_action(out.center_distance);
    spun(&inputs, 1, missing / element.constants.base_radius[1])
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
                let below = |delta| {
                    let query = [delta, dc, 0.0, n as f64 / GRID[3] as f64];
                    Spring::potential(&Query::from(query)).gradient[0] < 80.0
                };
                let ste = bisection([-1e-6, 20e-6], 60, below);
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
