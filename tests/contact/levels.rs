//! Claims about the element on the table of a real pair.

use super::element::{FORMULATIONS, at, spun, undamped};
use super::tooth_pairs::Ready;
use super::*;
use gearmesh::element::*;
use nalgebra::{Rotation3, Vector3};

/// The nominal pose with gear 1, of `geometry`, turned so far that its flank `s` is compressed by `delta` (m, line of action) against the
/// touching pose.
fn compressed(geometry: &PairGeometry, element: &Element, s: f64, delta: f64) -> Inputs {
    let turn = s * delta / geometry.gears[0].base_radius();
    spun(&element.nominal_inputs(), 0, turn)
}

/// Axes of displacement and mesh position alone.
fn axes(positions: usize) -> Axes {
    Axes {
        displacement_fraction: displacement_nodes(10, 1.6),
        center_distance_offset: vec![0.0],
        misalignment: vec![0.0],
        mesh_position: mesh_positions(positions),
    }
}

fn made(
    geometry: &PairGeometry,
    parameters: &Parameters,
    table: &Arc<TableFile>,
    contact: &ContactFile,
) -> Result<Element, ElementError> {
    if parameters.stiffness_model == StiffnessModel::Contact {
        return Element::with_contact(geometry, parameters, contact);
    }
    let table = Table::with_effects(table.clone(), parameters.table_effects(geometry)).unwrap();
    Element::new(geometry, parameters, Some(Arc::new(table)))
}

/// A real pair with the sliding of its load at every level of stiffness that knows of it.
struct Rubbing {
    ready: Ready,
    table: Arc<TableFile>,
}

const LEVELS: [StiffnessModel; 3] = [
    StiffnessModel::Table,
    StiffnessModel::Teeth,
    StiffnessModel::Contact,
];

impl Rubbing {
    fn new(text: &str, friction: FrictionLaw) -> Self {
        let mut pair = pair::from_json(text).unwrap();
        pair.friction = friction;
        pair.operating.center_distance_offset = [0.0; 2];
        let settings = contact_settings(&pair);
        let ready = Ready::new(pair, settings, None);
        let Ready {
            pair,
            solver,
            coverage,
            ..
        } = &ready;
        let torques = [coverage.nominal_torque, coverage.maximum_torque];
        let grid = sweep(solver, Flank::Drive, &axes(32), torques[1], QUIET).unwrap();
        let mut table = TableFile::new("c", "test", &pair.geometry, torques, &grid, None);
        table.teeth = Some(ready.record(&default_teeth_axes(coverage), 1));
        let axes = default_sliding_axes(coverage, pair.geometry.gears[0].base_radius());
        table.friction = Some(FrictionRecord {
            law: friction,
            drive: sweep_sliding(solver, Flank::Drive, &axes, QUIET).unwrap(),
            coast: None,
            axes,
        });
        table.seal();
        let table = Arc::new(table);
        Rubbing { ready, table }
    }

    fn element(&self, stiffness_model: StiffnessModel, friction: bool) -> Element {
        let parameters = Parameters {
            stiffness_model,
            center_distance_effect: false,
            misalignment_effect: false,
            friction,
            friction_transition_speed: 1e-6,
            ..undamped(Formulation::Conjugate, LoadedFlank::Both)
        };
        let Ready { pair, contact, .. } = &self.ready;
        made(&pair.geometry, &parameters, &self.table, contact).unwrap()
    }

    /// Turned by `cycles` base pitches under load, gear 1 with `spin`.
    fn turning(&self, element: &Element, cycles: f64, spin: f64) -> Inputs {
        let geometry = &self.ready.pair.geometry;
        let [z1, z2] = geometry.gears.each_ref().map(|g| g.z());
        let turn = cycles * TAU / z1;
        let inputs = compressed(geometry, element, 1.0, 12e-6);
        let mut inputs = spun(&spun(&inputs, 0, turn), 1, -turn * z1 / z2);
        inputs.gears[0].w.z = spin;
        inputs.gears[1].w.z = -spin * z1 / z2;
        inputs
    }
}

/// What friction adds to the forces on gear 1 and to the moments on both gears, over the normal force.
fn friction_share(rubbed: &Outputs, free: &Outputs) -> [f64; 4] {
    let force = (rubbed.force[0] - free.force[0]) / free.normal_force;
    let [m1, m2] = [0, 1].map(|i| (rubbed.moment[i].z - free.moment[i].z) / free.normal_force);
    [force.x, force.y, m1, m2]
}

/// Friction turns round at the pitch point: what the element loses is what the line loads of the contact solver lose, whatever
/// its level, and over the mesh cycle the loss of `gearmesh solve`. Forces and moments are those of the table.
#[test]
fn a_real_pair_loses_what_its_line_loads_lose_at_every_level() {
    let schlenk = FrictionLaw::schlenk(20e-3, [0.4e-6; 2], 0.846);
    let xu_kahraman = FrictionLaw::xu_kahraman(20e-3, [0.4e-6, 0.3e-6]);
    let spin = 150.0;
    for (name, text, law) in [("spur", SPUR, xu_kahraman), ("helical", PAPER, schlenk)] {
        let real = Rubbing::new(text, law);
        let geometry = &real.ready.pair.geometry;
        let rolling = spin * geometry.rolling_speed_per_spin(geometry.center_distance);
        let mut by_table = vec![];
        for level in LEVELS {
            let [element, free] = [true, false].map(|friction| real.element(level, friction));
            let (mut found, mut listed, mut shares) = (vec![], vec![], vec![]);
            for i in 0..40 {
                let cycles = (f64::from(i) + 0.25) / 40.0;
                let inputs = real.turning(&element, cycles, spin);
                let [out, bare] = [&element, &free].map(|element| at(element, &inputs));
                let back = at(&element, &real.turning(&element, cycles, -spin));
                assert_relative_eq!(out.friction_power, back.friction_power, max_relative = 1e-6);
                let added = |i: usize| (out.moment[i] - bare.moment[i]).dot(&inputs.gears[i].w);
                let work = added(0) + added(1);
                assert!(out.friction_power < 0.0);
                assert_relative_eq!(work, out.friction_power, max_relative = 1e-6);
                let force = out.tangential_force / element.line_of_action(out.center_distance);
                let torque = force * geometry.gears[0].base_radius();
                let position = real
                    .ready
                    .solver
                    .position(Flank::Drive, out.mesh_position, 0.0);
                let problem = position.unwrap();
                let result = problem.solve_torque(torque, 0.0, None).unwrap();
                let sliding = real.ready.solver.sliding(&problem, &result, &law);
                let mu = law.coefficient(geometry).at(force, rolling);
                let lost = loss_factor_of(geometry, sliding.distance);
                found.push(-out.friction_power);
                listed.push(mu * lost * torque * spin);
                shares.push(friction_share(&out, &bare));
            }
            let off: Vec<f64> = found.iter().zip(&listed).map(|(f, l)| f - l).collect();
            let largest = most(&off) / mean(&listed);
            assert_relative_eq!(mean(&found), mean(&listed), max_relative = 5e-3);
            assert!(largest < 0.05, "{name} {level:?}: {largest}");
            if level == StiffnessModel::Table {
                by_table = shares.clone();
            }
            for part in 0..4 {
                let [own, known] = [&shares, &by_table]
                    .map(|shares| shares.iter().map(|share| share[part]).collect::<Vec<f64>>());
                let off: Vec<f64> = own.iter().zip(&known).map(|(a, b)| a - b).collect();
                // Tables round off the steps where tooth pairs come, go and pass the pitch point.
                assert!(rms(&off) < 0.04 * rms(&known), "{name} {level:?} {part}");
            }
        }
    }
}

/// Of a spur pair whose load is on one tooth pair, friction has the lengths of roll as its arms, and turns round where the tooth pair
/// passes the pitch point.
#[test]
fn friction_of_one_spur_tooth_pair_has_the_lengths_of_roll_as_arms() {
    let mu = 0.07;
    let law = FrictionLaw::Constant { coefficient: mu };
    let real = Rubbing::new(SPUR, law);
    let geometry = &real.ready.pair.geometry;
    let (c, pitch) = (geometry.center_distance, geometry.base_pitch());
    for level in LEVELS {
        let [element, free] = [true, false].map(|friction| real.element(level, friction));
        let mut senses = [0, 0];
        for i in 0..100 {
            let inputs = real.turning(&element, f64::from(i) / 100.0, 150.0);
            let [out, bare] = [&element, &free].map(|element| at(element, &inputs));
            let s = (out.mesh_position - out.mesh_position.round()) * pitch;
            let path = geometry.path_of_contact(c);
            // Ahead of the next base pitch and behind the last one by more than the load bends teeth into contact.
            let alone = s - pitch < path.start - 0.1 * pitch && s + pitch > path.end + 0.1 * pitch;
            if !alone || s.abs() < 0.08 * pitch {
                continue;
            }
            senses[usize::from(s > 0.0)] += 1;
            let [_, _, m1, m2] = friction_share(&out, &bare);
            let [rho1, rho2] = [0, 1].map(|i| geometry.roll_at(i, c, s));
            // The driver is braked in recess and pushed on in approach, the driven gear likewise by its own arm.
            for (found, arm) in [(m1, -s.signum() * rho1), (m2, -s.signum() * rho2)] {
                assert_relative_eq!(found, mu * arm, max_relative = 0.04);
            }
        }
        assert!(senses.iter().all(|n| *n > 5), "{level:?} {senses:?}");
    }
}

/// Derivatives of the outputs by a `freedom` of gear 2 (position, then rotation): exact ones, and by differences.
fn slopes(element: &Element, inputs: &Inputs, freedom: usize) -> [[f64; CONTINUOUS_OUTPUTS]; 2] {
    let phase = element.phase_offset(&element.nominal_inputs()).unwrap();
    let mut jacobian = Jacobian::zeros();
    element.jacobian(&phase, inputs, &mut jacobian).unwrap();
    let step = 1e-8;
    let [up, down] = [step, -step].map(|step| {
        let mut inputs = *inputs;
        let direction = Vector3::ith(freedom % 3, step);
        match freedom < 3 {
            true => inputs.gears[1].p += direction,
            false => inputs.gears[1].r = Rotation3::new(direction).matrix() * inputs.gears[1].r,
        }
        element.evaluate(&phase, &inputs).unwrap().to_array()
    });
    let differences = std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * step));
    [
        jacobian.column(BODY_COLUMNS + freedom).into_owned().into(),
        differences,
    ]
}

/// Derivatives under friction are those of differences, at the levels that find sliding themselves.
#[test]
fn derivatives_know_how_friction_of_tooth_pairs_and_segments_changes() {
    let real = Rubbing::new(PAPER, FrictionLaw::default());
    for level in [StiffnessModel::Teeth, StiffnessModel::Contact] {
        let element = real.element(level, true);
        for cycles in [0.13, 0.62] {
            let inputs = real.turning(&element, cycles, 30.0);
            let [slopes, differences] = slopes(&element, &inputs, 5);
            // Forces, moments and power of friction.
            for i in (0..12).chain([26]) {
                let size = slopes[i].abs().max(1e-3 * slopes[0].abs());
                assert_abs_diff_eq!(slopes[i], differences[i], epsilon = 2e-3 * size);
            }
        }
    }
}

/// The paper's pair, crowned and helical: what the element shows at random poses is the direct sum over the line loads of
/// the contact solver there.
#[test]
fn a_real_pair_has_the_root_stress_of_its_line_loads() {
    let pair = pair::from_json(PAPER).unwrap();
    let ready = Ready::new(pair, with_stations(12), Some([-1e-3, 1e-3]));
    let Ready { pair, solver, .. } = &ready;
    let geometry = &pair.geometry;
    let models = root_models(pair, Flank::Drive);
    let coverage = Coverage {
        center_distance_offset: Some([-50e-6, 50e-6]),
        ..ready.coverage
    };
    let axes = Axes {
        center_distance_offset: vec![-50e-6, -20e-6, 20e-6, 50e-6],
        misalignment: vec![-1e-3, -0.4e-3, 0.0, 0.4e-3, 1e-3],
        ..axes(12)
    };
    let grid = sweep(solver, Flank::Drive, &axes, 200.0, QUIET).unwrap();
    let roots = RootStressSweep {
        solver,
        models: &models,
        flank: Flank::Drive,
    };
    let every = default_root_stress_axes(&coverage, geometry.gears[0].base_radius());
    let axes = LoadAxes {
        center_distance_offset_m: axes.center_distance_offset,
        misalignment_rad: every.misalignment_rad.iter().copied().step_by(2).collect(),
        mesh_position: mesh_positions(32),
        ..every
    };
    let drive = roots.samples(&axes, QUIET).unwrap();
    let stress = LoadSpline::new(axes.nodes(), &drive.columns(), [true; 2]).unwrap();
    let error = roots.measure(&coverage, &stress, 200).unwrap();
    assert!(error.rms < 0.01 && error.maximum < 0.05, "{error}");
    let mut file = TableFile::new("p", "test", geometry, [100.0, 200.0], &grid, None);
    file.root_stress = Some(RootStressRecord {
        axes,
        drive,
        coast: None,
        interpolation_error: error,
    });
    file.seal();
    let table = Arc::new(TableFile::from_json(&file.to_json()).unwrap());
    let mut contact = ready.contact.clone();
    let condensed = condensed_roots(solver, Flank::Drive, &models).unwrap();
    Arc::make_mut(&mut contact.drive).roots = Some(condensed);
    let contact = ContactFile::from_bytes(&contact.to_bytes()).unwrap();
    let level = |formulation, stiffness_model, contact: &ContactFile| {
        let parameters = Parameters {
            stiffness_model,
            root_stress: true,
            ..undamped(formulation, LoadedFlank::Drive)
        };
        made(geometry, &parameters, &table, contact)
    };
    let mut random = Random::new(91u64.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut noise = || random.within([-1.0, 1.0]);
    let (mut compared, mut largest) = (0, 0.0f64);
    for formulation in FORMULATIONS {
        let elements = [StiffnessModel::Table, StiffnessModel::Contact]
            .map(|model| level(formulation, model, &contact).unwrap());
        for _ in 0..20 {
            let turn = noise() * TAU / geometry.gears[0].z();
            let mut inputs = compressed(geometry, &elements[0], 1.0, 14e-6 + 4e-6 * noise());
            inputs = spun(&spun(&inputs, 0, turn), 1, -turn);
            inputs.gears[1].p.x += 40e-6 * noise();
            let tilt = Rotation3::from_euler_angles(0.8e-3 * noise(), 0.0, 0.0);
            inputs.gears[1].r = tilt.matrix() * inputs.gears[1].r;
            for out in elements.each_ref().map(|element| at(element, &inputs)) {
                if out.flank == 0 || out.out_of_range {
                    continue;
                }
                let offset = out.center_distance - geometry.center_distance;
                let force = out.normal_force * geometry.base_helix_angle().cos();
                let torque = force * geometry.gears[0].base_radius();
                let problem = solver.position(Flank::Drive, out.mesh_position, offset);
                let problem = problem.unwrap();
                let result = problem.solve_torque(torque, out.misalignment, None);
                let direct = PositionRoots::new(&problem, &models).largest(&result.unwrap());
                let direct = direct.unwrap();
                for (found, known) in out.root_stress.iter().zip(direct) {
                    largest = largest.max((found / known - 1.0).abs());
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 40 && largest < 0.05, "{compared} {largest}");
    let element = level(Formulation::Conjugate, StiffnessModel::Contact, &contact).unwrap();
    let inputs = compressed(geometry, &element, 1.0, 14e-6);
    // Along the line of centres, about it and about the axis.
    for freedom in [0, 3, 5] {
        let [slopes, differences] = slopes(&element, &inputs, freedom);
        for i in [CONTINUOUS_OUTPUTS - 2, CONTINUOUS_OUTPUTS - 1] {
            assert_relative_eq!(slopes[i], differences[i], max_relative = 5e-3);
        }
    }
    let refused = level(
        Formulation::Conjugate,
        StiffnessModel::Contact,
        &ready.contact,
    );
    let text = refused.err().unwrap().to_string();
    let words = ["rootStress = true", "--contact --root-stress"];
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
}

#[test]
fn digits_of_a_file_hold_the_place_of_the_force_where_misalignments_lie_close() {
    let pair = pair::from_json(UNMODIFIED).unwrap();
    let axes = Axes {
        displacement_fraction: (1..=10).map(|i| (0.1 * f64::from(i)).powi(2)).collect(),
        center_distance_offset: vec![0.0],
        misalignment: [-2e-4, -2e-5, -2e-6, -2e-7, 0.0, 2e-7, 2e-6, 2e-5, 2e-4].to_vec(),
        mesh_position: (0..12).map(|i| f64::from(i) / 12.0).collect(),
    };
    let solver = coarse_solver(&pair, with_stations(16));
    let torque = pair.operating.maximum_torque;
    let grid = sweep(&solver, Flank::Drive, &axes, torque, QUIET).unwrap();
    let geometry = &pair.geometry;
    let file = TableFile::new(
        "unmodified",
        "a test",
        geometry,
        [100.0, torque],
        &grid,
        None,
    );
    let read = TableFile::from_json(&file.to_json())
        .unwrap()
        .drive
        .on(&axes);
    let [exact, read] = [grid, read].map(|g| FlankTable::new(&g, Interpolation::Spline).unwrap());
    let half_face = 0.5 * geometry.face_overlap().1;
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    for _ in 0..500 {
        let mut q = Query::from([0.0, 0.0, random.within([-5e-7, 5e-7]), random.next()]);
        q.delta = exact.approach_at(random.within([200.0, 5000.0]), &q);
        let [exact, read] = [&exact, &read].map(|table| table.evaluate(&q, false).gradient);
        let apart = exact[2] / exact[0] - read[2] / read[0];
        assert!(apart.abs() < 2e-3 * half_face, "{apart:e} m at {q:?}");
    }
}
