//! Claims about what solutions do not show; those about solutions stand in tests/contact.

use std::sync::Arc;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::DMatrix;

use super::{ContactSolver, PositionProblem, Resultant};
use crate::compliance::{BeyondModel, ToothCompliance};
use crate::finite_element::{PairCompliance, Settings};
use crate::gear::Refinement;
use gearmesh::contact::{ContactSettings, Prescribed, Segment};
use gearmesh::gear::Flank;

const FZG: &str = include_str!("../../../resources/pairs/fzg-c.json");
const PAPER: &str = include_str!("../../../resources/pairs/palermo2013.json");

/// Segments that do not know of each other.
struct Alone;

impl ToothCompliance for Alone {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        Ok(DMatrix::identity(segments.len(), segments.len()) * 1e-8)
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        vec![1e-3; segments.len()]
    }
}

#[test]
fn a_segment_whose_gap_or_arm_is_not_a_number_fails_the_solve() {
    let pair = crate::pair::from_json(PAPER).unwrap();
    let alone: [Arc<dyn ToothCompliance>; 2] = [Arc::new(Alone), Arc::new(Alone)];
    let solver = ContactSolver::new(&pair, alone, ContactSettings::default()).unwrap();
    let torque = pair.operating.nominal_torque;
    let damage: [fn(&mut PositionProblem, usize); 3] = [
        |problem, i| problem.contact.candidates[i].gap = [f64::NAN; 4],
        |problem, i| problem.contact.candidates[i].gap[2] = f64::NAN,
        |problem, i| problem.contact.arm[i] = f64::NAN,
    ];
    for damage in damage {
        let mut problem = solver.position(Flank::Drive, 0.2, 0.0).unwrap();
        let approach = problem.solve_torque(torque, 0.0, None).unwrap().approach;
        let middle = problem.candidates().len() / 2;
        damage(&mut problem, middle);
        for result in [
            problem.solve_torque(torque, 0.0, None),
            problem.solve_approach(approach, 0.0, None),
            problem.solve_approach(-1e-3, 0.0, None),
        ] {
            let error = result.unwrap_err();
            let failure = "the contact solve stopped at a residual of NaN";
            assert!(error.to_string().contains(failure), "{error}");
        }
    }
}

#[test]
fn solves_that_end_with_a_step_along_tangents_are_within_1e_5_and_take_fewer_steps() {
    for file in [FZG, PAPER] {
        let pair = crate::pair::from_json(file).unwrap();
        let alone: [Arc<dyn ToothCompliance>; 2] = [Arc::new(Alone), Arc::new(Alone)];
        let solver = ContactSolver::new(&pair, alone, ContactSettings::default()).unwrap();
        let [exact, mut quick] = [0, 1].map(|_| solver.position(Flank::Drive, 0.3, 0.0).unwrap());
        quick.contact.last_step_from = 3e-3;
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        let mut steps = [0, 0];
        for misalignment in [0.0, 0.3e-3] {
            let torque = Prescribed::Torque(pair.operating.maximum_torque);
            let top = exact.resultant(torque, misalignment, [None; 2]).unwrap();
            let low = exact.no_load_approach(misalignment);
            let mut known: [Option<Resultant>; 2] = [Some(top.clone()), None];
            for part in (1..14).rev().map(|k| (f64::from(k) / 14.0).powi(2)) {
                let approach = Prescribed::Approach(low + part * (top.approach - low));
                let nearest = known.each_ref().map(Option::as_ref);
                let found = [&exact, &quick]
                    .map(|problem| problem.resultant(approach, misalignment, nearest).unwrap());
                let [force, moment] = [
                    found[1].loa_force - found[0].loa_force,
                    found[1].moment - found[0].moment,
                ];
                let bound = 1e-5 * top.loa_force;
                assert!(force.abs() < bound, "{force} at {part}");
                assert!(moment.abs() < bound * half_face, "{moment} at {part}");
                steps = [0, 1].map(|i| steps[i] + found[i].iterations);
                let [last, _] = found;
                known = [Some(last), known[0].take()];
            }
        }
        assert!(4 * steps[1] < 3 * steps[0], "{steps:?}");
    }
}

#[test]
fn solves_on_bent_teeth_that_start_from_each_other_are_within_1e_5_and_their_derivatives_within_3e_3()
 {
    let mut pair = crate::pair::from_json(FZG).unwrap();
    pair.refinement = Refinement::Coarse;
    // Teeth that bend far.
    for gear in &mut pair.geometry.gears {
        gear.youngs_modulus *= 0.05;
    }
    let top = 0.1 * pair.operating.maximum_torque;
    let models = PairCompliance::of(&pair, &Settings::for_pair(&pair), None, &|_, _, _| true);
    let models = models
        .unwrap()
        .gears
        .map(|gear| -> Arc<dyn ToothCompliance> { gear });
    let solver = ContactSolver::new(&pair, models, ContactSettings::default()).unwrap();
    let half_face = 0.5 * pair.geometry.face_overlap().1;
    for (position, misalignment) in [(0.3, 0.0), (0.8, 1e-3)] {
        let mut problems = [0, 1].map(|_| solver.position(Flank::Drive, position, 0.0).unwrap());
        assert!(problems[1].contact.moves());
        problems[1].contact.last_step_from = 3e-3;
        let [exact, quick] = problems.each_ref().map(|problem| {
            let torque = Prescribed::Torque(top);
            let mut results = vec![problem.resultant(torque, misalignment, [None; 2]).unwrap()];
            let low = problem.no_load_approach(misalignment);
            let high = results[0].approach;
            for part in (1..14).rev().map(|k| (f64::from(k) / 14.0).powi(2)) {
                let approach = Prescribed::Approach(low + part * (high - low));
                let known = [results.last(), results.iter().rev().nth(1)];
                results.push(problem.resultant(approach, misalignment, known).unwrap());
            }
            results
        });
        let bound = 1e-5 * exact[0].loa_force;
        for (exact, quick) in exact.iter().zip(&quick).skip(1) {
            // At the same approach.
            let by = exact.approach - quick.approach;
            let force = quick.loa_force + by * quick.tangent.force_by_approach;
            assert_abs_diff_eq!(force, exact.loa_force, epsilon = bound);
            let moment = quick.moment + by * quick.tangent.force_by_misalignment;
            assert_abs_diff_eq!(moment, exact.moment, epsilon = bound * half_face);
            let [found, expected] = [quick, exact].map(|x| x.tangent.force_by_approach);
            assert_relative_eq!(found, expected, max_relative = 3e-3);
        }
        let steps = [&exact, &quick].map(|all| all.iter().map(|x| x.iterations).sum::<usize>());
        assert!(4 * steps[1] < 3 * steps[0], "{steps:?}");
    }
}

/// A flank that deflects by `compliance` f(x) f(y) (m) at x under one newton at y, both arcs of the involute from its base circle (m); as the
/// gear turns it deflects under forces near its tip most.
struct Smooth {
    base_radius: f64,
    compliance: f64,
}

impl Smooth {
    /// f and its first two derivatives.
    fn of_arc(x: f64) -> [f64; 3] {
        [1.0 + 30.0 * x + 200.0 * x * x, 30.0 + 400.0 * x, 400.0]
    }

    fn arc(&self, roll: f64) -> f64 {
        roll * roll / (2.0 * self.base_radius)
    }
}

impl ToothCompliance for Smooth {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        let value = |s: &Segment| Smooth::of_arc(self.arc(0.5 * (s.roll[0] + s.roll[1])))[0];
        let values: Vec<f64> = segments.iter().map(value).collect();
        let n = values.len();
        Ok(DMatrix::from_fn(n, n, |i, j| {
            self.compliance * values[i] * values[j]
        }))
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        vec![1e-3; segments.len()]
    }
}

#[test]
fn slopes_over_the_places_of_contact_are_those_of_the_compliance() {
    let pair = crate::pair::from_json(FZG).unwrap();
    let gears = &pair.geometry.gears;
    // Gear 1 of plastic, so that contact moves.
    let compliances = [1e-7, 1e-8];
    let models = [0, 1].map(|gear| -> Arc<dyn ToothCompliance> {
        Arc::new(Smooth {
            base_radius: gears[gear].base_radius(),
            compliance: compliances[gear],
        })
    });
    let solver = ContactSolver::new(&pair, models, ContactSettings::default()).unwrap();
    let node = solver.node(Flank::Drive, [0.3, 0.0]).unwrap();
    let motion = node.influence.motion.unwrap();
    // Of both gears, at each segment: towards the tip of gear 1 the arc grows on gear 1 and shrinks on gear 2.
    let of_gear = |i: usize, gear: usize| {
        let roll = node.segments[i].roll[gear];
        let sign = [1.0, -1.0][gear];
        let [f, slope, bend] = Smooth::of_arc(roll * roll / (2.0 * gears[gear].base_radius()));
        [f, sign * slope, bend]
    };
    let of_one_pair = |i: &usize| node.segments[*i].tooth_pair == 0;
    let of_one_pair: Vec<usize> = (0..node.segments.len()).filter(of_one_pair).collect();
    assert!(of_one_pair.len() >= 10);
    // Off the path forces have other arms.
    let on_path = (0..node.segments.len()).filter(|i| node.segments[*i].arms == [1.0; 2]);
    assert!(on_path.clone().count() > of_one_pair.len());
    for &i in &of_one_pair {
        let mut bend = 0.0;
        for j in on_path.clone() {
            let [a, b] = [i, j].map(|k| [0, 1].map(|gear| of_gear(k, gear)));
            let slopes = [0, 1].map(|gear| compliances[gear] * a[gear][1] * b[gear][0]);
            assert_relative_eq!(
                motion.tilt[(i, j)],
                slopes[0] + slopes[1],
                max_relative = 1e-3
            );
            if of_one_pair.contains(&j) {
                let seconds = [0, 1].map(|gear| {
                    let ([f, slope, bend], [g, other, other_bend]) = (a[gear], b[gear]);
                    0.5 * compliances[gear] * (f * other_bend + 2.0 * slope * other + bend * g)
                });
                bend += seconds[0] + seconds[1];
            }
        }
        assert_relative_eq!(motion.bend[i], bend, max_relative = 1e-2);
    }
}
