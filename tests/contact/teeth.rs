//! Teeth that differ, in contact at run time.

use super::*;
use gearmesh::contact::Segment;
use nalgebra::Complex;

fn ready(text: &str) -> Ready {
    Ready::new(text, Flank::Drive, |pair| {
        coarse_solver(pair, with_stations(12))
    })
}

static READY: LazyLock<Ready> = LazyLock::new(|| ready(PAPER));

impl Ready {
    /// What the tooth errors of `contact` add to the transmission error over a turn of gear 1, m, at `steps` positions of each
    /// mesh cycle.
    fn added(&self, contact: &RuntimeContact, steps: usize) -> Vec<f64> {
        let over_cycle = |contact: &RuntimeContact, cycle: i64| -> Vec<f64> {
            let place = (0..steps).map(|i| i as f64 / steps as f64);
            let errors = place.map(|tau| transmission_error(contact, self.force(), tau, cycle));
            errors.collect()
        };
        let alike = over_cycle(&self.alike(), 0);
        let cycles = 0..i64::from(self.pair.geometry.gears[0].teeth);
        let errors = cycles.flat_map(|cycle| over_cycle(contact, cycle));
        errors
            .zip(alike.iter().cycle())
            .map(|(error, alike)| error - alike)
            .collect()
    }

    fn force(&self) -> f64 {
        self.pair.operating.nominal_torque / self.pair.geometry.gears[0].base_radius()
    }

    fn approach(&self) -> f64 {
        transmission_error(&self.alike(), self.force(), 0.3, 0)
    }
}

/// Loads within `tolerance` of those of `known`, each over its size or a thousandth of the force.
fn assert_loads(found: &ContactPotential, known: &ContactPotential, tolerance: f64) {
    for k in 0..4 {
        let scale = known.gradient[k].abs() + 1e-3 * known.gradient[0];
        let error = (found.gradient[k] - known.gradient[k]).abs();
        assert!(error < tolerance * scale, "{k}: {found:?} {known:?}");
    }
}

/// Approach under `force` at the mesh position `tau` of the mesh cycle `cycle`.
fn transmission_error(contact: &RuntimeContact, force: f64, tau: f64, cycle: i64) -> f64 {
    let (mut warm, mut ends, mut approach) = (Warm::default(), [-1e-4, 3e-4], 3e-5);
    for _ in 0..100 {
        let found = contact.potential([approach, 0.0, 0.0, tau], [cycle; 2], &mut warm);
        let found = found.unwrap();
        let missing = force - found.gradient[0];
        if missing.abs() <= 1e-10 * force {
            return approach;
        }
        ends[usize::from(missing < 0.0)] = approach;
        let newton = approach + missing / found.tangent.force_by_approach;
        let is_inside = ends[0] < newton && newton < ends[1];
        approach = if is_inside { newton } else { mean(&ends) };
    }
    panic!("no approach for {force} N");
}

fn index(errors: Vec<f64>) -> ToothErrors {
    ToothErrors {
        index: errors,
        ..ToothErrors::default()
    }
}

fn runout(amount: f64, angle: f64) -> ToothErrors {
    ToothErrors {
        runout: Some(Runout { amount, angle }),
        ..ToothErrors::default()
    }
}

/// Size of the sum of values at places (in turns) that the harmonic `order` has.
fn harmonic(values: impl Iterator<Item = (f64, f64)>, order: f64) -> f64 {
    let terms = values.map(|(x, value)| Complex::from_polar(value, TAU * order * x));
    terms.sum::<Complex<f64>>().norm()
}

/// Amplitude of the shaft order `order` of a signal over one turn.
fn amplitude(signal: &[f64], order: usize) -> f64 {
    let n = signal.len() as f64;
    let values = signal.iter().enumerate();
    harmonic(
        values.map(|(i, x)| (i as f64 / n, 2.0 / n * x)),
        order as f64,
    )
}

/// All other teeth stand back farther than the deflection of the one that carries: its root is under the whole load.
#[test]
fn a_tooth_that_carries_alone_has_the_root_stress_of_the_whole_load() {
    let mut ready = ready(SPUR);
    let models = root_models(&ready.pair, Flank::Drive);
    let roots = condensed_roots(&ready.solver, Flank::Drive, &models).unwrap();
    Arc::make_mut(&mut ready.condensed).roots = Some(roots);
    let mut back = vec![-100e-6; ready.pair.geometry.gears[0].teeth as usize];
    back[0] = 0.0;
    let contact = ready.with_errors([index(back), ToothErrors::default()]);
    let (contact, alike) = (contact.with_root_stress(), ready.alike().with_root_stress());
    let force = ready.force();
    for tau in [0.02, 0.1, 0.3, 0.6] {
        let stress = |contact: &RuntimeContact| {
            let approach = transmission_error(contact, force, tau, 0);
            ask(contact, [approach, 0.0, 0.0, tau], [0; 2]).root_stress
        };
        let (alone, shared) = (stress(&contact), stress(&alike));
        // The next tooth pair bears its part from a third of the base pitch behind the pitch point on.
        let share = if tau < 0.2 { 0.999..1.001 } else { 0.3..0.93 };
        let problem = ready.solver.position(Flank::Drive, tau, 0.0).unwrap();
        let own = |c: &&Candidate| c.tooth_pair == 0;
        let candidate = problem.candidates().iter().find(own).unwrap();
        for i in 0..2 {
            let gear = &ready.pair.geometry.gears[i];
            let whole = Segment {
                tooth: 0,
                z: [0.0, gear.face_width],
                roll: [candidate.roll[i]; 2],
            };
            let part = shared[i] / alone[i];
            assert!(share.contains(&part), "{tau}: {shared:?} {alone:?}");
            let field = models[i]
                .of_tooth(0, &models[i].spread(&[whole]), &[force])
                .unwrap();
            assert_relative_eq!(alone[i], field.largest().stress, max_relative = 0.03);
        }
    }
}

#[test]
fn a_gear_whose_teeth_all_stand_out_alike_is_one_turned_ahead() {
    // Around the pitch point of a relieved spur pair, where no tip edge bears, whose arm is another.
    let ready = ready(SPUR);
    let approach = 0.5 * ready.approach();
    let alike = ready.alike();
    for gears in [[4e-6, 0.0], [0.0, 4e-6]] {
        let contact = ready.with_errors([0, 1].map(|i| {
            let teeth = ready.pair.geometry.gears[i].teeth as usize;
            index(vec![gears[i]; teeth])
        }));
        for tau in [0.0, 0.05, 0.95] {
            let at = [approach, 2e-5, 1e-4, tau];
            let ahead = [approach + 4e-6, 2e-5, 1e-4, tau];
            let [here, there] = [ask(&contact, at, [3, 5]), ask(&alike, ahead, [0; 2])];
            assert_loads(&here, &there, 1e-8);
        }
    }
}

#[test]
fn loads_on_unequal_teeth_are_the_gradient_of_one_potential() {
    for text in [PAPER, SPUR, RING] {
        let ready = ready(text);
        let mut random = Random::new(77);
        let drive = [0, 1].map(|i| {
            let z = ready.pair.geometry.gears[i].teeth;
            let weak = |tooth| WeakTooth { tooth, factor: 2.0 };
            ToothErrors {
                weak: (0..z).step_by(2).map(weak).collect(),
                index: (0..z).map(|_| random.within([-4e-6, 4e-6])).collect(),
                ..runout(10e-6, 1.0)
            }
        });
        let contact = ready.with_errors(drive);
        let approach = ready.approach();
        for cycle in 0..6 {
            let at = [
                approach + random.within([10e-6, 16e-6]),
                random.within(ready.pair.operating.center_distance_offset),
                random.within([-2e-4, 2e-4]),
                random.within([0.1, 0.9]),
            ];
            let potential = |at| ask(&contact, at, [cycle, cycle + 3]);
            let gradient = potential(at).gradient;
            assert!(gradient[0] > 0.0);
            // Force times a tenth of the approach, over the step.
            let work = gradient[0] * at[0].abs();
            for (k, step) in [2e-9, 2e-8, 1e-7, 2e-5].into_iter().enumerate() {
                let slope = slope(step, |by| {
                    let mut x = at;
                    x[k] += by;
                    potential(x).energy
                });
                let bound = 1e-5 * gradient[k].abs() + 1e-9 * work / step;
                assert_abs_diff_eq!(slope, gradient[k], epsilon = bound);
            }
        }
    }
}

#[test]
fn one_mesh_cycle_follows_on_the_other() {
    let ready = &*READY;
    let errors = (0..20).map(|j| 3e-6 * f64::from(j % 3)).collect();
    let contact = ready.with_errors([index(errors), runout(20e-6, 0.5)]);
    let approach = ready.approach();
    for cycle in [0, 4, 19] {
        let at = |tau| ask(&contact, [approach, 0.0, 0.0, tau], [cycle; 2]);
        let end = at(1.0 - 1e-12);
        let next = ask(&contact, [approach, 0.0, 0.0, 0.0], [cycle + 1; 2]);
        assert_loads(&next, &end, 1e-7);
        // Counted on from a position beyond the cycle, too.
        assert_eq!(at(1.0).gradient, next.gradient);
    }
}

#[test]
fn run_out_adds_its_eccentricity_at_the_shaft_order_and_leaves_the_mesh_orders() {
    let ready = &*READY;
    let (z, steps) = (20usize, 8usize);
    let contact = ready.with_errors([runout(14e-6, 0.7), ToothErrors::default()]);
    let added = ready.added(&contact, steps);
    for order in 0..=2 * z {
        let expected = if order == 1 { 7e-6 } else { 0.0 };
        // Tip edges see an eccentricity by their arm.
        let found = amplitude(&added, order);
        assert!((found - expected).abs() < 1e-9, "{order}: {found}");
    }
}

/// To first order a tooth that stands out by E turns its gear back by the share of the stiffness that its pair has at the time, which
/// tells the sidebands of a wave of index errors; shares of the load by the solver of the tables stand for those of the
/// stiffness.
#[test]
fn a_wave_of_index_errors_has_the_sidebands_of_the_share_of_the_load() {
    let ready = &*READY;
    let (z, steps, wave) = (20usize, 16usize, 0.05e-6);
    let errors = (0..z)
        .map(|j| wave * (TAU * j as f64 / z as f64).sin())
        .collect();
    let contact = ready.with_errors([index(errors), ToothErrors::default()]);
    let torque = ready.pair.operating.nominal_torque;
    let mut share = vec![];
    for i in 0..steps {
        let tau = i as f64 / steps as f64;
        let problem = ready.solver.position(Flank::Drive, tau, 0.0).unwrap();
        let result = problem.solve_torque(torque, 0.0, None).unwrap();
        let shares = result.load_share.iter();
        share.extend(shares.map(|(k, part)| (tau + f64::from(*k), *part)));
    }
    let added = ready.added(&contact, steps);
    for order in [1, z - 1, z + 1] {
        // The share over the way of one tooth pair, transformed.
        let window = harmonic(share.iter().copied(), order as f64 / z as f64);
        let expected = wave * window / steps as f64;
        assert_abs_diff_eq!(amplitude(&added, order), expected, epsilon = 0.05 * wave);
    }
    for order in [0, 2, z / 2, z, 2 * z] {
        assert_abs_diff_eq!(amplitude(&added, order), 0.0, epsilon = 0.01 * wave);
    }
}

#[test]
fn a_weak_tooth_yields_more_while_it_carries() {
    let ready = ready(SPUR);
    let (tooth, factor) = (3, 1.5);
    let weak = ToothErrors {
        weak: vec![WeakTooth { tooth, factor }],
        ..ToothErrors::default()
    };
    let contact = ready.with_errors([weak, ToothErrors::default()]);
    let z = i64::from(ready.pair.geometry.gears[0].teeth);
    let alike = transmission_error(&ready.alike(), ready.force(), 0.0, 0);
    // At the pitch point one tooth pair of a spur gear carries all: tooth 0 in cycle 0, tooth -n in cycle n.
    let share = ready.condensed.shares[0];
    assert!((0.2..0.8).contains(&share), "{share}");
    for cycle in 0..z {
        let found = transmission_error(&contact, ready.force(), 0.0, cycle);
        if (cycle + 3) % z == 0 {
            let more = (found - alike) / alike;
            // Half of the share, less what the local contact has of the deflection.
            assert!(more > 0.1 * share && more < 0.5 * share, "{more} {share}");
        } else {
            assert!((found - alike).abs() < 1e-9 * alike, "{cycle}");
        }
    }
}

#[test]
fn a_flank_of_its_own_that_is_lower_by_so_much_is_an_index_error() {
    let ready = &*READY;
    let (approach, removal) = (ready.approach(), 2e-6);
    let g = &ready.pair.geometry;
    let nominal = &ready.pair.microgeometry.drive[1];
    let places = vec![0.0, 0.01, 0.1];
    let grid = Topography::new(places.clone(), places, vec![vec![removal; 3]; 3]).unwrap();
    let own = ToothErrors {
        flanks: vec![OwnFlank {
            tooth: 2,
            microgeometry: Microgeometry {
                topography: Some(grid),
                ..nominal.clone()
            },
        }],
        ..ToothErrors::default()
    };
    let mut errors = vec![0.0; 20];
    errors[2] = -removal / g.base_helix_angle().cos();
    let own = ready.with_errors([ToothErrors::default(), own]);
    let shifted = ready.with_errors([ToothErrors::default(), index(errors)]);
    let mut differ = 0;
    for cycle in 0..20 {
        let at = [approach, 1e-5, 1e-4, 0.4];
        let [a, b] = [&own, &shifted].map(|contact| ask(contact, at, [cycle; 2]));
        assert_loads(&a, &b, 1e-5);
        let alike = ask(&ready.alike(), at, [0; 2]);
        differ += usize::from((a.gradient[0] / alike.gradient[0] - 1.0).abs() > 1e-3);
    }
    assert!((1..=4).contains(&differ), "{differ}");
}
