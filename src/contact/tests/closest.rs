//! Where relieved flanks come closest.

use super::{plain_pair, relieved};
use crate::contact::closest::Flanks;
use crate::contact::closest::LEAST_CURVATURE;
use crate::contact::transverse::{PairNumbers, TransverseSection};
use crate::gear::{ReliefShape, ToothProfile, Topography};
use crate::pair::Pair;
use approx::assert_abs_diff_eq;

/// Some place along the face, m.
const Z: f64 = 7e-3;

fn section(pair: &Pair) -> TransverseSection {
    let g = &pair.geometry;
    let forms = [0, 1].map(|i| ToothProfile::new(&g.gears[i]).unwrap().form_roll());
    TransverseSection::new(
        &PairNumbers::new(g, [0.0; 2]),
        g.center_distance,
        forms,
        Some(100e-6),
    )
    .unwrap()
}

#[test]
fn the_closest_point_is_the_least_gap_of_all() {
    let mut pair = relieved("palermo2013", 20e-6, 0.15);
    pair.microgeometry.drive[1]
        .tip_relief
        .as_mut()
        .unwrap()
        .shape = ReliefShape::Parabolic;
    let (g, section) = (&pair.geometry, section(&pair));
    let [first, last] = section.reach();
    for step in 0..=200 {
        let at = section.point(first + (last - first) * f64::from(step) / 200.0);
        let found =
            Flanks::new(g, &section, pair.microgeometry.drive.each_ref(), at, Z).closest_point();
        let curvature: f64 = at.roll.iter().map(|roll| roll.recip()).sum();
        let at_distance = |s: f64| {
            let rolls = [0, 1].map(|i| {
                let sense = [1.0, -1.0][i];
                at.roll[i] + sense * s * g.gears[i].base_radius() / at.roll[i]
            });
            let within = (0..2).all(|i| {
                let [tip, form] = section.flank_ends(i);
                rolls[i] <= tip + 1e-12 && rolls[i] >= form
            });
            let removal: f64 = (0..2)
                .map(|i| pair.microgeometry.drive[i].removal(&g.gears[i], rolls[i], Z))
                .sum();
            within.then_some(
                at.separation
                    + at.slope * s
                    + 0.5 * s * s * curvature
                    + removal / g.base_helix_angle().cos(),
            )
        };
        let least = (-2000..=2000)
            .filter_map(|s| at_distance(1e-6 * f64::from(s)))
            .fold(f64::INFINITY, f64::min);
        assert!(
            found.least.gap <= least + 1e-13 && found.least.gap > least - 2e-8,
            "{step}: {} {least}",
            found.least.gap
        );
        if at.separation > 0.0 {
            continue;
        }
        // The profile is the gap about that point, but for its involutes' curvature, which is that of the closest point.
        for t in [-0.2e-3, -0.05e-3, 0.05e-3, 0.2e-3] {
            let Some(gap) = at_distance(found.least.s + t) else {
                continue;
            };
            let along_action = found.profile.gap(t) / g.base_helix_angle().cos();
            let involutes = 0.5 * t * t * found.profile.curvature;
            assert_abs_diff_eq!(
                along_action,
                gap - found.least.gap,
                epsilon = 0.2 * involutes + 1e-12
            );
        }
    }
}

#[test]
fn flanks_without_profile_modifications_touch_on_the_nominal_line() {
    let pair = plain_pair("palermo2013");
    let section = section(&pair);
    for xi in section.reach() {
        let at = section.point(0.8 * xi);
        let found = Flanks::new(
            &pair.geometry,
            &section,
            pair.microgeometry.drive.each_ref(),
            at,
            Z,
        )
        .closest_point();
        assert_eq!((found.roll, found.least.gap), (at.roll, at.separation));
        assert_eq!((found.profile.slope, found.arms), (0.0, at.arms));
    }
}

#[test]
fn a_hollow_that_fits_the_mate_leaves_a_tenth_of_the_curvature() {
    let mut pair = plain_pair("palermo2013");
    let section = section(&pair);
    let at = section.point(0.0);
    let curvature = |pair: &Pair| {
        let drive = pair.microgeometry.drive.each_ref();
        let found = Flanks::new(&pair.geometry, &section, drive, at, Z).closest_point();
        assert!(found.least.s.abs() < 1e-8, "{}", found.least.s);
        found.profile.curvature
    };
    let plain = curvature(&pair);
    let by_s = pair.geometry.gears[0].base_radius() / at.roll[0];
    for (part, left) in [(0.5, 0.5), (0.97, LEAST_CURVATURE)] {
        let rolls: Vec<f64> = (-20..=20)
            .map(|i| at.roll[0] + 0.03e-3 * f64::from(i))
            .collect();
        let removal = |roll: &f64| {
            let s = (roll - at.roll[0]) / by_s;
            vec![50e-6 - 0.5 * part * plain * s * s; 3]
        };
        let removals = rolls.iter().map(removal).collect();
        let grid = Topography::new(rolls, vec![0.0, 10e-3, 25e-3], removals).unwrap();
        pair.microgeometry.drive[0].topography = Some(grid);
        let found = curvature(&pair) / plain;
        assert!(
            (found / left - 1.0).abs() < 1e-3,
            "{found} instead of {left}"
        );
    }
}
