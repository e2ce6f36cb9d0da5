//! Claims about which teeth the element says are in mesh.

use super::*;
use crate::gear::PairGeometry;
use crate::gear::teeth::Counts;
use crate::table::{Potential, Query};
use std::sync::Mutex;

/// A spring that keeps what it is told of the teeth.
#[derive(Default)]
struct Listener(Mutex<Vec<Counts>>);

impl Elasticity for Listener {
    fn evaluate(&self, query: &Query, counts: Counts, _: bool) -> Result<Potential, String> {
        self.0.lock().unwrap().push(counts);
        let mut w = Potential::default();
        let stiffness = 1e8;
        if query.delta > 0.0 {
            w.gradient[0] = stiffness * query.delta;
            w.value = 0.5 * stiffness * query.delta.powi(2);
            w.hessian[0][0] = stiffness;
        }
        Ok(w)
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
