//! Claims about which teeth the element says are in mesh.

use super::*;
use crate::gear::teeth::{Counts, PairTeeth, Passing, Runout};
use crate::gear::{Flank, GearKind, PairGeometry};
use crate::table::{Potential, Query};
use std::sync::Mutex;

/// The potential of a linear spring.
fn spring(delta: f64) -> Potential {
    let mut w = Potential::default();
    if delta > 0.0 {
        (w.value, w.gradient[0], w.hessian[0][0]) = (0.5e8 * delta * delta, 1e8 * delta, 1e8);
    }
    w
}

/// A spring that keeps what it is told of the teeth.
#[derive(Default)]
struct Listener(Mutex<Vec<Counts>>);

impl Elasticity for Listener {
    fn evaluate(&self, query: &Query, counts: Counts, _: bool) -> Result<Potential, String> {
        self.0.lock().unwrap().push(counts);
        Ok(spring(query.delta))
    }

    fn tells_teeth_apart(&self) -> bool {
        true
    }
}

/// `pair` with `law` on both flanks.
fn under(
    law: &Arc<impl Elasticity + 'static>,
    pair: &PairGeometry,
    formulation: Formulation,
    flank: LoadedFlank,
) -> Element {
    let parameters = undamped(formulation, flank);
    Element::with_laws(pair, &parameters, law.clone(), Some(law.clone())).unwrap()
}

/// The drive flank of the paper's pair under `law`.
fn element(law: &Arc<impl Elasticity + 'static>) -> Element {
    let pair = paper_pair(1.0);
    under(law, &pair, Formulation::Conjugate, LoadedFlank::Drive)
}

/// Gears that turn through all combinations of their teeth: bodies forget whole turns, the teeth in mesh do not.
#[test]
fn the_pose_alone_says_which_teeth_of_either_gear_are_in_mesh() {
    for (formulation, pair) in [1.0, -1.0]
        .map(formulations_and_pairs)
        .into_iter()
        .flatten()
    {
        let [z1, z2] = [0, 1].map(|i| i64::from(pair.gears[i].teeth));
        for (flank, s, _) in SINGLE_FLANKS {
            let listener = Arc::new(Listener::default());
            let element = under(&listener, &pair, formulation, flank);
            let start = element.nominal_inputs();
            let phase = element.phase_offset(&start).unwrap();
            listener.0.lock().unwrap().clear();
            for cycles in (-z1..z1 * z2).step_by(7) {
                let turn = s * (cycles as f64 + 0.37) * TAU / z1 as f64;
                let follows = -pair.e() * turn * z1 as f64 / z2 as f64;
                let pose = spun(&spun(&start, 0, turn), 1, follows);
                element.evaluate(&phase, &pose).unwrap();
                let heard = listener.0.lock().unwrap().drain(..).collect::<Vec<_>>();
                assert_eq!(heard.len(), 1);
                let [first, second] = heard[0];
                assert_eq!((first - cycles).rem_euclid(z1), 0, "{flank:?} {cycles}");
                assert_eq!((second - cycles).rem_euclid(z2), 0, "{flank:?} {cycles}");
            }
        }
    }
}

#[test]
fn phases_are_found_and_derivatives_made_with_few_questions_to_the_law() {
    let listener = Arc::new(Listener::default());
    let element = element(&listener);
    let asked = || listener.0.lock().unwrap().drain(..).count();
    let start = element.nominal_inputs();
    let phase = element.phase_offset(&start).unwrap();
    assert!(asked() <= 10);
    let inputs = compressed(&element, 1.0, 5e-6);
    asked();
    let mut jacobian = Jacobian::zeros();
    // The derivative of the stiffness alone takes two more.
    let mut slopes = |phase: Option<&PhaseOffset>, stiffness| {
        let workspace = &mut Workspace::default();
        let made = element.slopes(phase, &inputs, stiffness, &mut jacobian, workspace);
        made.unwrap();
        asked()
    };
    assert_eq!(slopes(Some(&phase), false), 1);
    assert_eq!(slopes(Some(&phase), true), 3);
    // While phases follow the pose: those of it and of four beside it.
    assert!(slopes(None, false) <= 51);
}

/// A law that knows nothing beyond the touch.
struct Fails;

impl Elasticity for Fails {
    fn evaluate(&self, query: &Query, _: Counts, _: bool) -> Result<Potential, String> {
        match query.delta > 0.0 {
            true => Err("no solve succeeds".into()),
            false => Ok(Potential::default()),
        }
    }
}

#[test]
fn a_law_that_fails_while_phases_are_taken_is_no_gap() {
    let element = element(&Arc::new(Fails));
    let refused = element.phase_offset(&element.nominal_inputs()).unwrap_err();
    assert_eq!(refused.to_string(), "no solve succeeds");
}

/// A linear spring between teeth that differ, one pair of them at a time.
struct Unlike(Option<Passing>);

impl Elasticity for Unlike {
    fn evaluate(&self, query: &Query, counts: Counts, _: bool) -> Result<Potential, String> {
        let closing = |teeth: &Passing| teeth.closing(counts, 0, query.mesh_position)[0];
        Ok(spring(query.delta + self.0.as_ref().map_or(0.0, closing)))
    }

    fn tells_teeth_apart(&self) -> bool {
        true
    }
}

/// A gear with run-out is one that stands off its axis, wherever its flanks touch: where the teeth stand out most follows from
/// either flank, and is counted from the same tooth.
#[test]
fn run_out_displaces_one_tooth_of_a_gear_whichever_flank_touches() {
    const ANGLE: f64 = 0.4;
    const ECCENTRICITY: f64 = 1e-7;
    for pair in three_pairs(0.0) {
        for gear in 0..2 {
            let mut errors = PairTeeth::default();
            for flank in [&mut errors.drive, &mut errors.coast] {
                flank[gear].runout = Some(Runout {
                    amount: 2.0 * ECCENTRICITY,
                    angle: ANGLE,
                });
            }
            let element = |errors: &PairTeeth| {
                let law = |flank| Arc::new(Unlike(Passing::new(&pair, errors, flank)));
                let [drive, coast] = [Flank::Drive, Flank::Coast].map(law);
                let parameters = undamped(Formulation::Conjugate, LoadedFlank::Both);
                Element::with_laws(&pair, &parameters, drive, Some(coast)).unwrap()
            };
            let (eccentric, round) = (element(&errors), element(&PairTeeth::default()));
            let phase = PhaseOffset {
                mesh_position: 0.0,
                ..nominal_phase(&round)
            };
            let teeth = [0, 1].map(|i| f64::from(pair.gears[i].teeth));
            let centre = |s: f64| {
                // First harmonics over a turn of the gear, of its run-out and of a displacement along its own x axis.
                let (mut runout, mut displaced) = ([0.0; 2], [0.0; 2]);
                for n in 0..24 {
                    let turn = TAU * f64::from(n) / 24.0;
                    let ratio = -pair.e() * teeth[gear] / teeth[1 - gear];
                    let pose = spun(
                        &spun(&compressed(&round, s, 100e-6), gear, turn),
                        1 - gear,
                        ratio * turn,
                    );
                    let force = |element: &Element, inputs: &Inputs| {
                        element.evaluate(&phase, inputs).unwrap().normal_force
                    };
                    let at = |shift: f64| {
                        let mut pose = pose;
                        pose.gears[gear].p += pose.gears[gear].r.column(0) * shift;
                        force(&round, &pose)
                    };
                    let of_runout = force(&eccentric, &pose) - force(&round, &pose);
                    let of_shift = 0.5 * (at(ECCENTRICITY) - at(-ECCENTRICITY));
                    for (sum, x) in [(&mut runout, of_runout), (&mut displaced, of_shift)] {
                        sum[0] += x * turn.cos();
                        sum[1] -= x * turn.sin();
                    }
                }
                let [size, whole] = [runout, displaced].map(|[re, im]| re.hypot(im));
                assert_relative_eq!(size, whole, max_relative = 0.01);
                let [phase, of_x] = [runout, displaced].map(|[re, im]| im.atan2(re));
                (phase - of_x - ANGLE) / TAU * teeth[gear]
            };
            // In pitches; tooth and space are of the same width for the run-out, which these shifted gears' are not quite.
            let apart = |a: f64, b: f64| {
                let turn = teeth[gear];
                ((a - b + 0.5 * turn).rem_euclid(turn) - 0.5 * turn).abs()
            };
            let [drive, coast] = [1.0, -1.0].map(centre);
            let kinds = pair.gears.each_ref().map(|g| g.kind);
            assert!(
                apart(drive, coast) < 0.3,
                "{kinds:?} gear {gear}: {drive} {coast}"
            );
            if gear == 0 {
                let first = if pair.gears[0].kind == GearKind::Ring {
                    -0.5
                } else {
                    0.0
                };
                assert!(apart(drive, first) < 0.15, "{kinds:?}: {drive}");
            }
        }
    }
}
