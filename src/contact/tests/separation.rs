//! The closed form of the separation against flanks set up from formulation.md's signed distance.

use super::plain_pair;
use crate::contact::transverse::{PairNumbers, TransverseSection};
use crate::gear::{Gear, PairGeometry, ToothProfile};

/// Signed distance G / cos beta_b of formulation.md from the involute of `gear` on the flank `sigma` in the
/// plane zeta = 0, body coordinates.
fn signed_distance(gear: &Gear, sigma: f64, radius: f64, theta: f64) -> f64 {
    let t = gear.roll_length(radius) / gear.base_radius();
    let eta = gear.kappa() * sigma * gear.half_base_angle();
    gear.base_radius() * (sigma * (theta - eta) + gear.kappa() * (t - t.atan()))
}

/// Body angle of the flank `sigma` at the length of roll `roll`.
fn flank_angle(gear: &Gear, sigma: f64, roll: f64) -> f64 {
    let t = roll / gear.base_radius();
    gear.kappa() * sigma * (gear.half_base_angle() - (t - t.atan()))
}

/// Smallest distance of the mate's involute from the flank of the gear `i` (up to its tip) and the length of
/// roll there, with the pair turned to `xi` and gear 1 by `ahead` (rad) more, both axes in the plane
/// z = 0, gear 1 at the origin.
fn closest(p: &PairGeometry, i: usize, xi: f64, ahead: f64) -> (f64, f64) {
    let (c, e, s) = (p.center_distance, p.e(), 1.0);
    let w = p.gears[0].z() / (p.gears[0].z() + e * p.gears[1].z());
    let centers = [0.0, c];
    let sigma = [s, e * s];
    let spin = [
        s * (xi / p.gears[0].base_radius() + ahead),
        -e * s * xi / p.gears[1].base_radius(),
    ];
    let turned: Vec<f64> = (0..2)
        .map(|g| {
            let pitch_roll = p.roll_at(g, c, 0.0);
            let direction = if w * c - centers[g] > 0.0 {
                0.0
            } else {
                std::f64::consts::PI
            };
            direction - flank_angle(&p.gears[g], sigma[g], pitch_roll) + spin[g]
        })
        .collect();
    let (gear, mate) = (&p.gears[i], &p.gears[1 - i]);
    let tip = gear.roll_length(gear.tip_radius);
    let form = ToothProfile::new(gear).unwrap().form_roll();
    (0..=4000)
        .map(|step| {
            let roll = tip + (form - tip) * f64::from(step) / 4000.0;
            let angle = turned[i] + flank_angle(gear, sigma[i], roll);
            let radius = gear.radius_at_roll(roll);
            let x = centers[i] + radius * angle.cos() - centers[1 - i];
            let y = radius * angle.sin();
            let theta = y.atan2(x) - turned[1 - i];
            let turn = (theta / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            let g = signed_distance(mate, sigma[1 - i], x.hypot(y), theta - turn);
            (g, roll)
        })
        .filter(|(g, _)| g.is_finite())
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap()
}

/// Pairs of every kind, the ring as gear 1 included.
fn pairs() -> Vec<PairGeometry> {
    let names = ["palermo2013", "helical-25-47", "planet-ring-27-84"];
    let mut pairs: Vec<PairGeometry> = names.iter().map(|name| plain_pair(name).geometry).collect();
    let mut swapped = pairs[2].clone();
    swapped.gears.swap(0, 1);
    pairs.push(swapped);
    pairs
}

#[test]
fn separation_is_the_signed_distance_of_the_tip_edge_from_the_mate() {
    for p in &pairs() {
        let forms = [0, 1].map(|i| ToothProfile::new(&p.gears[i]).unwrap().form_roll());
        let section = TransverseSection::new(
            &PairNumbers::new(p, [0.0; 2]),
            p.center_distance,
            forms,
            Some(50e-6),
        )
        .unwrap();
        let path = p.path_of_contact(p.center_distance);
        let reach = section.reach();
        assert!(
            reach[0] < path.start && path.end < reach[1],
            "{reach:?} {path:?}"
        );
        for fraction in [0.2, 0.6, 1.0] {
            for (end, tip_gear, limit) in [(path.start, 1, reach[0]), (path.end, 0, reach[1])] {
                let xi = end + fraction * (limit - end);
                let point = section.point(xi);
                let (distance, roll) = closest(p, tip_gear, xi, 0.0);
                let gear = &p.gears[tip_gear];
                assert_eq!(
                    roll,
                    gear.roll_length(gear.tip_radius),
                    "first to touch: the tip"
                );
                assert!(
                    (point.separation - distance).abs() < 1e-12,
                    "{} against {distance} at {xi}",
                    point.separation
                );
                assert!(point.separation > 0.0 && point.separation < 50.001e-6);
            }
        }
        // On the path the flanks touch at the conjugate point.
        let xi = 0.3 * path.end;
        let (distance, roll) = closest(p, 0, xi, 0.0);
        assert!(distance.abs() < 1e-9, "{distance}");
        assert!((roll - section.point(xi).roll[0]).abs() < 1e-5);
    }
}

#[test]
fn the_arm_of_a_tip_edge_is_the_work_that_gear_1_does_per_turn() {
    for p in &pairs() {
        let forms = [0, 1].map(|i| ToothProfile::new(&p.gears[i]).unwrap().form_roll());
        let section = TransverseSection::new(
            &PairNumbers::new(p, [0.0; 2]),
            p.center_distance,
            forms,
            Some(50e-6),
        )
        .unwrap();
        let path = p.path_of_contact(p.center_distance);
        let reach = section.reach();
        for (end, tip_gear, limit) in [(path.start, 1, reach[0]), (path.end, 0, reach[1])] {
            let xi = end + 0.7 * (limit - end);
            let turn = 1e-7;
            let closed = closest(p, tip_gear, xi, -turn).0 - closest(p, tip_gear, xi, turn).0;
            let by_work = closed / (2.0 * turn * p.gears[0].base_radius());
            let arms = section.point(xi).arms;
            assert!((arms[0] - by_work).abs() < 1e-6, "{arms:?}, {by_work}");
            assert_eq!(arms[1 - tip_gear], 1.0);
            assert!((arms[tip_gear] - 1.0).abs() > 1e-3, "{arms:?}");
        }
        assert_eq!(section.point(0.0).arms, [1.0; 2]);
    }
}
