//! Claims about bodies that are no solids of revolution.

use super::*;
use crate::contact::Warm;
use crate::gear::teeth::Counts;
use crate::gear::{BodyOrder, BodyOrders, PairGeometry, TurningBodies};
use crate::table::{Potential, Query};

/// A body of gear `gear` that deflects under forces alone, `size` (m/N) times the cosine of `order` times its angle.
fn plain(gear: usize, order: u32, size: f64) -> BodyOrders {
    let part = BodyOrder {
        order,
        approach_m_per_n: [size, 0.0],
        tilt_rad_per_n: [0.0; 2],
        tilt_rad_per_nm: [0.0; 2],
    };
    let mut orders = BodyOrders::default();
    orders.drive[gear].push(part);
    orders.coast[gear].push(part);
    orders
}

/// The pose `cycles` mesh cycles after that of `element` at the start, in its sense of loading, gear 2 `delta` (m) into the flank.
fn turned(element: &Element, pair: &PairGeometry, s: f64, cycles: f64, delta: f64) -> Inputs {
    let [z1, z2] = [0, 1].map(|i| pair.gears[i].z());
    let turn = s * cycles * TAU / z1;
    let follows = -turn * z1 / z2 + s * delta / element.constants.base_radius[1];
    spun(
        &spun(&element.nominal_inputs(), 0, turn),
        1,
        pair.e() * follows,
    )
}

/// In series: at the same force the approach is longer by the compliance of the body at its angle, on either flank and for the body of
/// either gear, turn after turn.
#[test]
fn teeth_on_a_body_approach_by_its_deflection_under_their_force() {
    const SIZE: f64 = 0.5e-9;
    let pairs = [1.0, -1.0].map(three_pairs).into_iter().flatten();
    for pair in pairs {
        for (flank, s, _) in SINGLE_FLANKS {
            let alone = with_bodies(&pair, BodyOrders::default(), Formulation::Conjugate, flank);
            for gear in 0..2 {
                let bodies = plain(gear, 3, SIZE);
                let element = with_bodies(&pair, bodies, Formulation::Conjugate, flank);
                let phase = nominal_phase(&element);
                for cycles in [0.0, 0.3, 5.8, 131.55, -77.2] {
                    let pose = turned(&element, &pair, s, cycles, 6e-6);
                    let out = element.evaluate(&phase, &pose).unwrap();
                    let force = out.tangential_force / element.line_of_action(out.center_distance);
                    assert!(force > 10.0);
                    let angle = TAU * cycles / pair.gears[gear].z();
                    let yields = SIZE * (3.0 * angle).cos() * force;
                    let short = turned(&element, &pair, s, cycles, 6e-6 - yields);
                    let known = alone.evaluate(&phase, &short).unwrap();
                    let ratio = out.tangential_force / known.tangential_force;
                    assert_abs_diff_eq!(ratio, 1.0, epsilon = 1e-8);
                }
            }
        }
    }
}

/// A linear spring at a lever, stiffer and nearer from place to place of the mesh cycle: W = k(tau) x² / 2 with x = delta + l M + d(tau), all
/// derivatives in closed form.
struct Linear;

impl Elasticity for Linear {
    fn evaluate(&self, q: &Query, _: Counts, _: bool) -> Result<Potential, String> {
        const LEVER: f64 = 3e-3;
        let (sin, cos) = (TAU * q.mesh_position).sin_cos();
        let [k, k_p, k_pp] =
            [1.0 + 0.2 * sin, 0.2 * TAU * cos, -0.2 * TAU * TAU * sin].map(|x| 3e8 * x);
        let [d, d_p, d_pp] = [cos, -TAU * sin, -TAU * TAU * cos].map(|x| 0.3e-6 * x);
        let x = q.delta + LEVER * q.misalignment + d;
        let mut w = Potential::default();
        if x <= 0.0 {
            return Ok(w);
        }
        w.value = 0.5 * k * x * x;
        w.gradient = [k * x, 0.0, LEVER * k * x, 0.5 * k_p * x * x + k * x * d_p];
        let by_place = k_p * x + k * d_p;
        w.hessian = [
            [k, 0.0, LEVER * k, by_place],
            [0.0; 4],
            [LEVER * k, 0.0, LEVER * LEVER * k, LEVER * by_place],
            [
                by_place,
                0.0,
                LEVER * by_place,
                0.5 * k_pp * x * x + 2.0 * k_p * x * d_p + k * (d_p * d_p + x * d_pp),
            ],
        ];
        Ok(w)
    }
}

/// The element of `pair` with [`Linear`] springs on these bodies.
fn linear(pair: &PairGeometry, orders: &BodyOrders, flank: LoadedFlank) -> Element {
    let law = Arc::new(Linear);
    let parameters = undamped(Formulation::Conjugate, flank);
    let mut element = Element::with_laws(pair, &parameters, law.clone(), Some(law)).unwrap();
    for (law, gears) in element.laws.iter_mut().zip([&orders.drive, &orders.coast]) {
        let turning = TurningBodies::new(pair, gears);
        *law = law.take().map(|law| law.on_bodies(turning));
    }
    element
}

#[test]
fn a_closed_loop_through_the_angle_of_the_bodies_keeps_its_energy() {
    for pair in three_pairs(1.0) {
        let element = linear(&pair, &body_orders(0.2), LoadedFlank::Drive);
        let phase = nominal_phase(&element);
        let (points, cycles) = (4000, 8.0);
        let (mut work, mut energy) = (0.0, 0.0);
        for i in 0..points {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(points)).sin_cos();
            // Forth and back, and more pressed on the way there.
            let mut pose = turned(&element, &pair, 1.0, cycles * cos, 6e-6 + 1e-6 * sin);
            let [z1, z2] = [0, 1].map(|i| pair.gears[i].z());
            let spin = -cycles * sin * TAU / z1;
            let closes = 1e-6 * cos / element.constants.base_radius[1];
            pose.gears[0].w.z = spin;
            pose.gears[1].w.z = pair.e() * (closes - spin * z1 / z2);
            let out = element.evaluate(&phase, &pose).unwrap();
            assert_ne!(out.flank, 0);
            work += power(&out, &pose) * TAU / f64::from(points);
            energy += out.energy / f64::from(points);
        }
        assert!(work.abs() < 1e-10 * energy, "{:.1e}", work / energy);
    }
}

#[test]
fn all_derivatives_of_a_law_on_bodies_are_those_of_its_energy() {
    let pair = paper_pair(1.0);
    let element = linear(&pair, &body_orders(0.3), LoadedFlank::Drive);
    let law = element.laws[0].as_ref().unwrap();
    let ask = |at: [f64; 4]| {
        law.potential(at, [5, 9], true, &mut Warm::default(), &mut None)
            .unwrap()
    };
    let here = [6e-6, 1e-6, 2e-5, 0.3];
    let found = ask(here);
    for (axis, step) in [1e-9, 1e-8, 1e-7, 1e-5].into_iter().enumerate() {
        let side = |step: f64| {
            let mut at = here;
            at[axis] += step;
            ask(at)
        };
        let [before, after] = [side(-step), side(step)];
        let slope = (after.value - before.value) / (2.0 * step);
        assert_abs_diff_eq!(
            slope / found.value,
            found.gradient[axis] / found.value,
            epsilon = 1e-6 * 6e-6 / step
        );
        for row in 0..4 {
            let slope = (after.gradient[row] - before.gradient[row]) / (2.0 * step);
            let scale =
                found.hessian[row][row].abs().sqrt() * found.hessian[axis][axis].abs().sqrt();
            assert!(
                (slope - found.hessian[row][axis]).abs() <= 1e-6 * scale + 1e-12,
                "{row} {axis}: {slope}"
            );
        }
    }
}

#[test]
fn derivatives_of_the_compliance_are_its_slopes() {
    let pair = paper_pair(1.0);
    let turning = TurningBodies::new(&pair, &body_orders(0.1).drive);
    let at = |tau: f64| turning.compliance([17, 40], tau);
    let step = 1e-4;
    let [before, here, after] = [-step, 0.0, step].map(|step| at(0.4 + step));
    for derivative in 1..3 {
        let slope = (after[derivative - 1] - before[derivative - 1]) / (2.0 * step);
        let error = (slope - here[derivative]).abs().max();
        assert!(error < 1e-5 * here[derivative].abs().max());
    }
    // After a turn of either gear all is the same.
    let turns = [
        17 + 3 * i64::from(pair.gears[0].teeth),
        40 - i64::from(pair.gears[1].teeth),
    ];
    assert_eq!(turning.compliance(turns, 0.4), here);
}

#[test]
fn bodies_that_the_tables_lack_are_refused() {
    let pair = paper_pair(1.0);
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Table,
        body_effect: true,
        ..Parameters::default()
    };
    let table = sealed(spring_file(&pair, [100.0, 200.0], [8, 5, 5, 12]));
    let text = refusal(Element::new(&pair, &parameters, Some(table)));
    assert!(
        text.contains("bodyEffect = true") && text.contains("web_holes"),
        "{text}"
    );
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Constant,
        ..parameters
    };
    let text = refusal(Element::new(&pair, &parameters, None));
    assert!(text.contains("bodyEffect = true"), "{text}");
}
