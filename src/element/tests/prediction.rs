//! Loads that are predicted for a communication step.

use super::*;

const STEP: f64 = 5e-6;

/// Gear 2 as a disc that only spins, gear 1 at rest.
struct Disc {
    element: Element,
    phase: PhaseOffset,
    inertia: f64,
    torque: f64,
    angle: f64,
    rate: f64,
}

impl Disc {
    /// One on each of the three pairs, pressed against the drive flank of gear 1.
    fn all() -> Vec<Self> {
        let mut discs = vec![];
        for pair in three_pairs(1.0) {
            let element = made(&pair, &Parameters::default());
            let phase = nominal_phase(&element);
            discs.push(Self {
                element,
                phase,
                inertia: 0.5 * pair.gears[1].base_radius().powi(2),
                torque: 100.0 * pair.e(),
                angle: 0.0,
                rate: 0.0,
            });
        }
        discs
    }

    /// kg, on the line of action.
    fn mass(&self) -> f64 {
        0.5
    }

    fn inputs(&self) -> Inputs {
        let mut inputs = spun(&self.element.nominal_inputs(), 1, self.angle);
        inputs.gears[1].w = Vector3::z() * self.rate;
        inputs
    }

    fn predict(
        &self,
        last: Option<&History>,
        coupling: Coupling,
        length: f64,
        mass: f64,
    ) -> Prediction {
        let request = StepRequest {
            coupling,
            length,
            effective_mass: mass,
        };
        let (inputs, workspace) = (self.inputs(), &mut Workspace::default());
        let found = self
            .element
            .predict(&self.phase, &inputs, last, &request, workspace);
        found.unwrap()
    }

    /// Angles after every 4 steps of `STEP`, by a master with `length` that divides it.
    fn run(&mut self, coupling: Coupling, length: f64, effective_mass: f64) -> Vec<f64> {
        let (mut last, mut pending) = (None::<History>, None::<Loads>);
        let every = (4.0 * STEP / length).round() as usize;
        let mut angles = vec![];
        for n in 0..every * 50 {
            let found = self.predict(last.as_ref(), coupling, length, effective_mass);
            let acting = match coupling {
                Coupling::Parallel => pending.unwrap_or(Loads::at(&found.outputs)),
                _ => found.loads,
            };
            (last, pending) = (found.history, Some(found.loads));
            if n % every == 0 {
                angles.push(self.angle);
            }
            let acceleration = (acting.0[11] + self.torque) / self.inertia;
            self.angle += self.rate * length + 0.5 * acceleration * length * length;
            self.rate += acceleration * length;
        }
        angles
    }
}

#[test]
fn a_turn_of_gear_1_brings_the_teeth_together_by_as_much_on_the_line_of_action() {
    for disc in Disc::all() {
        let (y, u) = (3e-6, 0.02);
        let inputs = disc.inputs();
        let moved = disc.element.moved(&inputs, 0.0, y, u);
        let [before, after] =
            [&inputs, &moved].map(|i| disc.element.evaluate(&disc.phase, i).unwrap());
        let cosine = disc.element.line_of_action(before.center_distance);
        let approach = (after.transmission_error - before.transmission_error) * cosine;
        assert_relative_eq!(approach, y, max_relative = 1e-9);
        let rate = (after.transmission_error_rate - before.transmission_error_rate) * cosine;
        assert_relative_eq!(rate, u, max_relative = 1e-9);
    }
}

#[test]
fn a_disc_under_predicted_loads_moves_as_with_steps_fifty_times_shorter_whatever_mass_is_given() {
    for coupling in [Coupling::Sequential, Coupling::Parallel] {
        for share in [0.3, 1.0, 2.0] {
            for (mut disc, mut fine) in Disc::all().into_iter().zip(Disc::all()) {
                let mass = share * disc.mass();
                let found = disc.run(coupling, STEP, mass);
                let exact = fine.run(Coupling::Sequential, STEP / 50.0, fine.mass());
                let swing = exact.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                for (a, b) in found.iter().zip(&exact) {
                    assert!(
                        (a - b).abs() < 0.02 * swing,
                        "{coupling:?}, mass x {share}: {a} {b}"
                    );
                }
            }
        }
    }
}

#[test]
fn poses_that_do_not_follow_from_the_velocities_and_steps_too_long_get_the_loads_of_the_point() {
    for mut disc in Disc::all() {
        let ask = |disc: &Disc, last: Option<&History>, length: f64| {
            disc.predict(last, Coupling::Parallel, length, disc.mass())
        };
        // Pressed, and coming nearer.
        let toward = disc.torque.signum();
        (disc.angle, disc.rate) = (toward * 1e-4, toward * 0.1);
        let first = ask(&disc, None, STEP);
        assert_eq!(first.loads, Loads::at(&first.outputs));
        assert!(first.outputs.normal_force > 100.0);
        disc.angle += disc.rate * STEP;
        let second = ask(&disc, first.history.as_ref(), STEP);
        assert_ne!(second.loads, Loads::at(&second.outputs));
        let long = ask(&disc, first.history.as_ref(), 1e-3);
        assert_eq!(long.loads, Loads::at(&long.outputs));
        disc.angle += toward * 1e-5;
        let moved = ask(&disc, second.history.as_ref(), STEP);
        assert_eq!(moved.loads, Loads::at(&moved.outputs));
    }
}

/// A loaded mesh that turns with its line of centres, as on a planet carrier, has the loads of the pose, turned.
#[test]
fn predicted_loads_do_not_depend_on_how_fast_the_line_of_centres_turns() {
    const LENGTH: f64 = 10e-6;
    for (formulation, pair) in formulations_and_pairs(1.0) {
        for coupling in [Coupling::Sequential, Coupling::Parallel] {
            let element = constant(&pair, formulation, LoadedFlank::Drive);
            let phase = nominal_phase(&element);
            let start = compressed(&element, 1.0, 5e-6);
            let predicted = |rate: f64| {
                let (mut last, mut loads) = (None, Loads([0.0; Loads::ROWS.len()]));
                for n in 0..4 {
                    let turn = Rotation3::new(Vector3::z() * (rate * LENGTH * f64::from(n)));
                    let mut inputs = moved(&start, &turn, &Vector3::zeros());
                    let w = Vector3::z() * rate;
                    for body in inputs.gears.iter_mut().chain([&mut inputs.carrier]) {
                        (body.v, body.w) = (w.cross(&body.p), w);
                    }
                    let request = StepRequest {
                        coupling,
                        length: LENGTH,
                        effective_mass: 0.5,
                    };
                    let workspace = &mut Workspace::default();
                    let found =
                        element.predict(&phase, &inputs, last.as_ref(), &request, workspace);
                    let found = found.unwrap();
                    (last, loads) = (found.history, found.loads);
                }
                loads.0[13]
            };
            assert_relative_eq!(predicted(600.0), predicted(0.0), max_relative = 1e-6);
        }
    }
}
