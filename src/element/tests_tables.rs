//! Claims about the element on the table of a real pair.

use super::testing::compressed;
use super::*;
use crate::gear::{Flank, PairGeometry};
use crate::table::{FlankGrid, TableFile};
use approx::assert_relative_eq;
use nalgebra::Rotation3;
use std::f64::consts::TAU;

fn table(pair: &PairGeometry, drive: &FlankGrid) -> Arc<Table> {
    let mut file = TableFile::new("palermo2013", "test", pair, [100.0, 200.0], drive, None);
    file.seal();
    Arc::new(Table::from_file(file).unwrap())
}

fn parameters(loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        stiffness_model: StiffnessModel::Table,
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

fn at(element: &Element, inputs: &Inputs) -> Outputs {
    let latch = element.latch(&element.nominal_inputs()).unwrap();
    element.evaluate(&latch, inputs).unwrap()
}

/// The paper's modified pair with closed-form compliance: the element at rest under a torque has the
/// transmission error of the contact solver there, between the table's nodes.
#[test]
fn a_real_pair_under_torque_has_the_static_transmission_error_of_the_contact_solver() {
    use crate::compliance::ToothCompliance;
    use crate::compliance::analytical::{AnalyticalCompliance, AxialState};
    use crate::contact::{ContactSettings, ContactSolver};
    use crate::table::source::StaticSource;
    use crate::table::sweep::{Watch, sweep};
    use crate::table::{Axes, plan};

    let pair = crate::pair::Pair::from_json(include_str!("../../resources/pairs/palermo2013.json"))
        .unwrap();
    let compliance = [0, 1].map(|i| -> Arc<dyn ToothCompliance> {
        let gear = &pair.geometry.gears[i];
        Arc::new(AnalyticalCompliance::new(gear, AxialState::Free).unwrap())
    });
    let solver = ContactSolver::new(&pair, compliance, ContactSettings::default()).unwrap();
    let axes = Axes {
        displacement_fraction: plan::displacement_nodes(10, 1.6),
        center_distance_offset: vec![0.0],
        misalignment: vec![0.0],
        mesh_position: plan::mesh_positions(24),
    };
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &std::sync::atomic::AtomicBool::new(false),
    };
    let drive = sweep(&solver, Flank::Drive, &axes, 200.0, &watch).unwrap();
    let table = table(&pair.geometry, &drive);
    for formulation in [Formulation::Paper, Formulation::Conjugate] {
        let element = Element::new(
            &pair.geometry,
            &Parameters {
                formulation,
                center_distance_effect: false,
                misalignment_effect: false,
                ..parameters(LoadedFlank::Drive)
            },
            Some(table.clone()),
        )
        .unwrap();
        for torque in [45.0, 100.0, 160.0] {
            for turn in [0.07, 0.31, 0.52, 0.9] {
                let loaded = |delta: f64| {
                    let mut inputs = compressed(&element, 1.0, delta);
                    for (i, sense) in [1.0, -1.0].into_iter().enumerate() {
                        let angle = sense * turn * TAU / pair.geometry.gears[i].z();
                        inputs.gears[i].r *=
                            Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
                    }
                    at(&element, &inputs)
                };
                // dW/dPMC is the part of the torque that the mesh takes as input work; statics of the
                // solver hold the force on the line of action, so that is compared.
                let (mut low, mut high) = (0.0, 30e-6);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let out = loaded(middle);
                    let force = out.tangential_force / element.line_of_action(out.center_distance);
                    if force * pair.geometry.gears[0].base_radius() < torque {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let out = loaded(low);
                let source: &dyn StaticSource = &solver;
                let mut position = source
                    .position(Flank::Drive, out.mesh_position, 0.0)
                    .unwrap();
                let ste = position.at_torque(torque, 0.0).unwrap().approach;
                let dte = out.transmission_error * element.line_of_action(out.center_distance);
                assert_relative_eq!(dte, ste, max_relative = 3e-3);
            }
        }
    }
}
