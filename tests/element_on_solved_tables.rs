//! Claims about the element on the table of a real pair.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use gearmesh::contact::{ContactSettings, Prescribed};
use gearmesh::element::{
    Element, Formulation, Inputs, LoadedFlank, Outputs, Parameters, StiffnessModel,
};
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::pair::Refinement;
use gearmesh::random::Random;
use gearmesh::table::{
    Axes, FrictionRecord, LoadAxes, LoadSamples, RootStressRecord, Table, TableFile,
};
use gearmesh_preprocessor::contact::PositionRoots;
use gearmesh_preprocessor::finite_element::{Settings, pair_root_stress};
use gearmesh_preprocessor::pair;
use gearmesh_preprocessor::table::{
    Coverage, RootStressSweep, StaticSource, Watch, default_root_stress_axes, default_sliding_axes,
    displacement_nodes, mesh_positions, sweep, sweep_sliding,
};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

#[path = "common/solver.rs"]
mod solver;
use solver::coarse_solver;

/// Both formulations.
const FORMULATIONS: [Formulation; 2] = [Formulation::Paper, Formulation::Conjugate];

/// Constant stiffness without damping.
fn undamped(formulation: Formulation, loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        formulation,
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Loads at `inputs` with the phases of the nominal pose.
fn at(element: &Element, inputs: &Inputs) -> Outputs {
    let latch = element.latch(&element.nominal_inputs()).unwrap();
    element.evaluate(&latch, inputs).unwrap()
}

/// Gear `i` turned by `angle` about its own axis.
fn spun(inputs: &Inputs, i: usize, angle: f64) -> Inputs {
    let mut out = *inputs;
    out.gears[i].r *= Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
    out
}

/// The nominal pose with gear 1, of `geometry`, turned so far that its flank `s` is compressed by `delta` (m, line of action) against the
/// touching pose.
fn compressed(geometry: &PairGeometry, element: &Element, s: f64, delta: f64) -> Inputs {
    let turn = s * delta / geometry.gears[0].base_radius();
    spun(&element.nominal_inputs(), 0, turn)
}

/// The paper's modified pair with a lead slope, so that the flanks differ; coarse finite elements. The element at
/// rest under a torque has, on either flank, transmission error and axial position of the contact as the contact
/// solver has them there, between the table's nodes.
#[test]
fn a_real_pair_under_torque_stands_on_either_flank_as_the_contact_solver_says() {
    let text = include_str!("../resources/pairs/palermo2013.json");
    let sloped = text.replacen(
        r#""lead_crowning_um": 4.5"#,
        r#""lead_crowning_um": 4.5, "lead_slope_um": 8.0"#,
        1,
    );
    assert_ne!(text, sloped);
    let pair = pair::from_json(&sloped).unwrap();
    assert!(!pair.coast_mirrors_drive());
    let geometry = &pair.geometry;
    let solver = coarse_solver(&pair, ContactSettings::default());
    let axes = Axes {
        displacement_fraction: displacement_nodes(10, 1.6),
        center_distance_offset: vec![0.0],
        misalignment: vec![0.0],
        mesh_position: mesh_positions(24),
    };
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &std::sync::atomic::AtomicBool::new(false),
    };
    let [drive, coast] = [Flank::Drive, Flank::Coast]
        .map(|flank| sweep(&solver, flank, &axes, 200.0, &watch).unwrap());
    let mut file = TableFile::new(
        "palermo2013",
        "test",
        geometry,
        [100.0, 200.0],
        &drive,
        Some(&coast),
    );
    file.seal();
    let table = Arc::new(Table::from_file(file).unwrap());
    let mut levers = [Vec::new(), Vec::new()];
    for (flank, loaded) in [
        (Flank::Drive, LoadedFlank::Drive),
        (Flank::Coast, LoadedFlank::Coast),
    ] {
        for formulation in FORMULATIONS {
            let parameters = Parameters {
                stiffness_model: StiffnessModel::Table,
                center_distance_effect: false,
                misalignment_effect: false,
                ..undamped(formulation, loaded)
            };
            let element = Element::new(geometry, &parameters, Some(table.clone())).unwrap();
            for torque in [45.0, 100.0, 160.0] {
                for turn in [0.07, 0.31, 0.52, 0.9] {
                    let angle = turn * TAU / geometry.gears[0].z();
                    let loaded = |delta: f64| {
                        let pressed = compressed(geometry, &element, flank.sign(), delta);
                        at(&element, &spun(&spun(&pressed, 0, angle), 1, -angle))
                    };
                    // dW/dPMC is the part of the torque that the mesh takes as input work; statics of the
                    // solver hold the force on the line of action, so that is compared.
                    let (mut low, mut high) = (0.0, 30e-6);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        let out = loaded(middle);
                        let force =
                            out.tangential_force / element.line_of_action(out.center_distance);
                        if force * geometry.gears[0].base_radius() < torque {
                            low = middle;
                        } else {
                            high = middle;
                        }
                    }
                    let out = loaded(low);
                    let source: &dyn StaticSource = &solver;
                    let mut position = source.position(flank, out.mesh_position, 0.0).unwrap();
                    let found = position.solve(Prescribed::Torque(torque), 0.0).unwrap();
                    let dte = out.transmission_error * element.line_of_action(out.center_distance);
                    assert_relative_eq!(flank.sign() * dte, found.approach, max_relative = 3e-3);
                    let lever = found.moment / found.loa_force;
                    assert_abs_diff_eq!(out.contact_z - geometry.z_ref(), lever, epsilon = 3e-5);
                    levers[usize::from(flank == Flank::Coast)].push(lever);
                }
            }
        }
    }
    // The slope moves the contact to the same end on both flanks: no mirrored table would.
    let mean = |v: &Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
    assert!(mean(&levers[0]) * mean(&levers[1]) > 0.0);
    assert!(mean(&levers[0]).abs() > 1e-4);
}

/// A spur pair, whose friction turns round at the pitch point: what the element loses is what the line loads of the
/// contact solver lose, between the table's nodes, and over the mesh cycle the loss of `gearmesh solve`.
#[test]
fn a_real_pair_loses_what_its_line_loads_lose() {
    let text = include_str!("../resources/pairs/fzg-c.json");
    let mut pair = pair::from_json(text).unwrap();
    pair.friction = FrictionLaw::xu_kahraman(20e-3, [0.4e-6, 0.3e-6]);
    let geometry = &pair.geometry;
    let solver = coarse_solver(&pair, ContactSettings::default());
    let top = pair.operating.maximum_torque;
    let axes = Axes {
        displacement_fraction: displacement_nodes(10, 1.6),
        center_distance_offset: vec![0.0],
        misalignment: vec![0.0],
        mesh_position: mesh_positions(32),
    };
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &std::sync::atomic::AtomicBool::new(false),
    };
    let grid = sweep(&solver, Flank::Drive, &axes, top, &watch).unwrap();
    let coverage = Coverage {
        center_distance_offset: None,
        misalignment: None,
        nominal_torque: 0.5 * top,
        maximum_torque: top,
    };
    let axes = default_sliding_axes(&coverage, geometry.gears[0].base_radius());
    let mut file = TableFile::new("c", "test", geometry, [0.5 * top, top], &grid, None);
    file.friction = Some(FrictionRecord {
        law: pair.friction,
        drive: sweep_sliding(&solver, Flank::Drive, &axes, &watch).unwrap(),
        coast: None,
        axes,
    });
    file.seal();
    let table = Arc::new(Table::from_file(file).unwrap());
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        center_distance_effect: false,
        misalignment_effect: false,
        friction: true,
        ..undamped(Formulation::Conjugate, LoadedFlank::Drive)
    };
    let element = Element::new(geometry, &parameters, Some(table)).unwrap();
    let spin = 150.0;
    let ratio = geometry.gears[0].z() / geometry.gears[1].z();
    let rolling = spin * geometry.rolling_speed_per_spin(geometry.center_distance);
    let (mut found, mut listed) = (vec![], vec![]);
    for i in 0..40 {
        let turn = f64::from(i) / 40.0 * TAU / geometry.gears[0].z();
        let mut inputs = compressed(geometry, &element, 1.0, 12e-6);
        inputs = spun(&spun(&inputs, 0, turn), 1, -turn * ratio);
        inputs.gears[0].w.z = spin;
        inputs.gears[1].w.z = -spin * ratio;
        let out = at(&element, &inputs);
        let force = out.tangential_force / element.line_of_action(out.center_distance);
        let torque = force * geometry.gears[0].base_radius();
        let problem = solver
            .position(Flank::Drive, out.mesh_position, 0.0)
            .unwrap();
        let result = problem.solve_torque(torque, 0.0, None).unwrap();
        let sliding = solver.sliding(&problem, &result, &pair.friction);
        let law = pair.friction.coefficient(geometry).at(force, rolling);
        let loss =
            law * gearmesh::friction::loss_factor_of(geometry, sliding.distance) * torque * spin;
        found.push(-out.friction_power);
        listed.push(loss);
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    assert_relative_eq!(mean(&found), mean(&listed), max_relative = 5e-3);
    for (found, loss) in found.iter().zip(&listed) {
        assert_abs_diff_eq!(found, loss, epsilon = 0.05 * mean(&listed));
    }
}

/// The paper's pair, crowned and helical: what the element shows at random poses is the direct sum over the line loads of
/// the contact solver there.
#[test]
fn a_real_pair_has_the_root_stress_of_its_line_loads() {
    let text = include_str!("../resources/pairs/palermo2013.json");
    let mut pair = pair::from_json(text).unwrap();
    pair.refinement = Refinement::Coarse;
    let geometry = &pair.geometry;
    let settings = ContactSettings {
        stations: 12,
        ..ContactSettings::default()
    };
    let solver = coarse_solver(&pair, settings);
    let elastic = Settings::for_pair(&pair);
    let models = pair_root_stress(geometry, Flank::Drive, &elastic, None, &|_, _, _| true);
    let models = models.unwrap().map(|(model, _)| model);
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &std::sync::atomic::AtomicBool::new(false),
    };
    let coverage = Coverage {
        center_distance_offset: Some([-50e-6, 50e-6]),
        misalignment: Some([-1e-3, 1e-3]),
        nominal_torque: 100.0,
        maximum_torque: 200.0,
    };
    let axes = Axes {
        displacement_fraction: displacement_nodes(6, 1.6),
        center_distance_offset: vec![-50e-6, -20e-6, 20e-6, 50e-6],
        misalignment: vec![-1e-3, -0.4e-3, 0.0, 0.4e-3, 1e-3],
        mesh_position: mesh_positions(12),
    };
    let grid = sweep(&solver, Flank::Drive, &axes, 200.0, &watch).unwrap();
    let roots = RootStressSweep {
        solver: &solver,
        models: &models,
        flank: Flank::Drive,
    };
    let every = default_root_stress_axes(&coverage, geometry.gears[0].base_radius());
    let axes = LoadAxes {
        center_distance_offset_m: axes.center_distance_offset.clone(),
        misalignment_rad: every.misalignment_rad.iter().copied().step_by(2).collect(),
        mesh_position: mesh_positions(32),
        ..every
    };
    let drive = roots.samples(&axes, &watch).unwrap();
    let stress = drive.spline(&axes, [true; 2]).unwrap();
    let error = roots.measure(&coverage, &stress, 200, &watch).unwrap();
    assert!(error.rms < 0.01 && error.maximum < 0.05, "{error}");
    let mut file = TableFile::new("p", "test", geometry, [100.0, 200.0], &grid, None);
    file.root_stress = Some(RootStressRecord {
        axes,
        drive,
        coast: None,
        interpolation_error: error,
    });
    file.seal();
    let table = Table::from_json(&file.to_json()).unwrap();
    let mut random = Random::new(91u64.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut noise = || random.within([-1.0, 1.0]);
    let (mut compared, mut largest) = (0, 0.0f64);
    for formulation in FORMULATIONS {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            root_stress: true,
            ..undamped(formulation, LoadedFlank::Drive)
        };
        let table = Table::with_effects(
            Arc::new(table.file().clone()),
            parameters.table_effects(geometry),
        );
        let element = Element::new(geometry, &parameters, Some(Arc::new(table.unwrap()))).unwrap();
        for _ in 0..20 {
            let turn = noise() * TAU / geometry.gears[0].z();
            let mut inputs = compressed(geometry, &element, 1.0, 14e-6 + 4e-6 * noise());
            inputs = spun(&spun(&inputs, 0, turn), 1, -turn);
            inputs.gears[1].p.x += 40e-6 * noise();
            let tilt = Rotation3::from_euler_angles(0.8e-3 * noise(), 0.0, 0.0);
            inputs.gears[1].r = tilt.matrix() * inputs.gears[1].r;
            let out = at(&element, &inputs);
            if out.flank == 0 || out.out_of_range {
                continue;
            }
            let offset = out.center_distance - geometry.center_distance;
            let force = out.normal_force * geometry.base_helix_angle().cos();
            let torque = force * geometry.gears[0].base_radius();
            let place = (Flank::Drive, out.mesh_position, offset);
            let problem = solver.position(place.0, place.1, place.2).unwrap();
            let result = problem.solve_torque(torque, out.misalignment, None);
            let direct = PositionRoots::new(&solver, &problem, place, &models).unwrap();
            let direct = direct.largest(&result.unwrap()).unwrap();
            for (found, known) in out.root_stress.iter().zip(direct) {
                largest = largest.max((found / known - 1.0).abs());
            }
            compared += 1;
        }
    }
    assert!(compared > 20 && largest < 0.05, "{compared} {largest}");
}
