//! Claims about which teeth the element says are in mesh.

use super::testing::{FORMULATIONS, spun, three_pairs, undamped};
use super::*;
use crate::gear::Flank;
use crate::gear::teeth::Counts;
use crate::table::{Potential, Query};
use std::f64::consts::TAU;
use std::sync::Mutex;

/// A spring that keeps what it is told of the teeth.
#[derive(Default)]
struct Listener(Mutex<Vec<Counts>>);

impl Elasticity for Listener {
    fn evaluate(&self, query: &Query, _: bool) -> Potential {
        let mut w = Potential::default();
        let stiffness = 1e8;
        if query.delta > 0.0 {
            w.gradient[0] = stiffness * query.delta;
            w.hessian[0][0] = stiffness;
        }
        w
    }

    fn tells_teeth_apart(&self) -> bool {
        true
    }

    fn with_teeth(&self, query: &Query, counts: Counts, want_hessian: bool) -> Potential {
        self.0.lock().unwrap().push(counts);
        self.evaluate(query, want_hessian)
    }
}

/// Gears that turn through all combinations of their teeth: bodies forget whole turns, the teeth in mesh do not.
#[test]
fn the_pose_alone_says_which_teeth_of_either_gear_are_in_mesh() {
    for pair in three_pairs(1.0).into_iter().chain(three_pairs(-1.0)) {
        let [z1, z2] = [0, 1].map(|i| i64::from(pair.gears[i].teeth));
        for formulation in FORMULATIONS {
            for (flank, loaded) in [
                (Flank::Drive, LoadedFlank::Drive),
                (Flank::Coast, LoadedFlank::Coast),
            ] {
                let listener = Arc::new(Listener::default());
                let laws = FlankLaws {
                    drive: listener.clone(),
                    coast: Some(listener.clone()),
                };
                let parameters = undamped(formulation, loaded);
                let element = Element::with_laws(&pair, &parameters, &laws).unwrap();
                let start = element.nominal_inputs();
                let latch = element.latch(&start).unwrap();
                listener.0.lock().unwrap().clear();
                for cycles in (-z1..z1 * z2).step_by(7) {
                    let turn = flank.sign() * (cycles as f64 + 0.37) * TAU / z1 as f64;
                    let follows = -pair.e() * turn * z1 as f64 / z2 as f64;
                    let pose = spun(&spun(&start, 0, turn), 1, follows);
                    element.evaluate(&latch, &pose).unwrap();
                    let heard = listener.0.lock().unwrap().drain(..).collect::<Vec<_>>();
                    assert_eq!(heard.len(), 1);
                    let [first, second] = heard[0];
                    assert_eq!((first - cycles).rem_euclid(z1), 0, "{flank:?} {cycles}");
                    assert_eq!((second - cycles).rem_euclid(z2), 0, "{flank:?} {cycles}");
                }
            }
        }
    }
}
