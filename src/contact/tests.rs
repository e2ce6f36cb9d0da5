//! Claims about what solutions do not show; those about solutions stand in tests/contact.

use std::f64::consts::{PI, TAU};

use approx::assert_abs_diff_eq;

use super::transverse::{LEAST_CURVATURE, MatingFlanks, TransversePoint, TransverseSection};
use crate::gear::{
    Gear, PairGeometry, PairMicrogeometry, PairNumbers, ProfileRelief, ReliefShape, Topography,
};
use crate::table::TableFile;

/// A shipped pair without modifications.
struct Plain {
    geometry: PairGeometry,
    microgeometry: PairMicrogeometry,
}

/// That called `name`, by the geometry in its tables.
fn plain_pair(name: &str) -> Plain {
    let tables = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/tables");
    let text = std::fs::read_to_string(format!("{tables}/{name}.json")).unwrap();
    let tables: TableFile = serde_json::from_str(&text).unwrap();
    Plain {
        geometry: tables.geometry,
        microgeometry: PairMicrogeometry::default(),
    }
}

/// Lengths of roll at which the involutes end at the root, m: a little below the contact of the mate's tip.
fn form_rolls(g: &PairGeometry) -> [f64; 2] {
    let path = g.path_of_contact(g.center_distance);
    [0, 1].map(|i| {
        let active = g.roll_at(i, g.center_distance, [path.start, path.end][i]);
        active - 0.02 * (g.gears[i].tip_form_roll() - active)
    })
}

/// Its transverse section, tip corners followed up to the separation `limit` (m).
fn section(g: &PairGeometry, limit: f64) -> TransverseSection {
    let numbers = PairNumbers::new(g);
    TransverseSection::new(&numbers, g.center_distance, form_rolls(g), Some(limit)).unwrap()
}

/// Some place along the face, m.
const Z: f64 = 7e-3;

fn flanks<'a>(
    pair: &'a Plain,
    section: &'a TransverseSection,
    at: TransversePoint,
) -> MatingFlanks<'a> {
    let drive = pair.microgeometry.drive.each_ref();
    MatingFlanks::new(&pair.geometry, section, drive, at, Z)
}

#[test]
fn the_closest_point_is_the_least_gap_of_all() {
    let mut pair = plain_pair("palermo2013");
    let g = &pair.geometry;
    let (c, path) = (g.center_distance, g.path_of_contact(g.center_distance));
    let starts = [[path.end, -0.15], [path.start, 0.15]];
    let shapes = [ReliefShape::Linear, ReliefShape::Parabolic];
    for (i, ([end, share], shape)) in starts.into_iter().zip(shapes).enumerate() {
        pair.microgeometry.drive[i].tip_relief = Some(ProfileRelief {
            amount: 20e-6,
            start_roll: g.roll_at(i, c, end + share * path.length()),
            end_roll: g.gears[i].roll_length(g.gears[i].tip_radius),
            shape,
        });
    }
    let (g, section) = (&pair.geometry, section(&pair.geometry, 100e-6));
    let [first, last] = section.extended_path;
    for step in 0..=200 {
        let at = section.point(first + (last - first) * f64::from(step) / 200.0);
        let found = flanks(&pair, &section, at);
        let closest = found.closest();
        let curvature: f64 = at.roll.iter().map(|roll| roll.recip()).sum();
        let at_distance = |s: f64| {
            let rolls = [0, 1].map(|i| {
                let sense = [1.0, -1.0][i];
                at.roll[i] + sense * s * g.gears[i].base_radius() / at.roll[i]
            });
            let within = (0..2).all(|i| {
                let (tip, form) = (section.numbers.tip_roll[i], section.form_rolls[i]);
                rolls[i] <= tip + 1e-12 && rolls[i] >= form
            });
            let removal: f64 = (0..2)
                .map(|i| pair.microgeometry.drive[i].removal(&g.gears[i], rolls[i], Z))
                .sum();
            let involutes = at.separation + at.slope * s + 0.5 * s * s * curvature;
            within.then_some(involutes + removal / g.base_helix_angle().cos())
        };
        let least = (-2000..=2000)
            .filter_map(|s| at_distance(1e-6 * f64::from(s)))
            .fold(f64::INFINITY, f64::min);
        let gap = closest.gap;
        let range = least - 2e-8..=least + 1e-13;
        assert!(range.contains(&gap), "{step}: {gap} {least}");
        if at.separation > 0.0 {
            continue;
        }
        // The profile is the gap about that point, but for its involutes' curvature, which is that of the closest point.
        let profile = found.profile(closest.s);
        for t in [-0.2e-3, -0.05e-3, 0.05e-3, 0.2e-3] {
            let Some(there) = at_distance(closest.s + t) else {
                continue;
            };
            let along_action = profile.gap(t) / g.base_helix_angle().cos();
            let involutes = 0.5 * t * t * profile.curvature;
            assert_abs_diff_eq!(along_action, there - gap, epsilon = 0.2 * involutes + 1e-12);
        }
    }
}

#[test]
fn a_hollow_that_fits_the_mate_leaves_a_tenth_of_the_curvature() {
    let mut pair = plain_pair("palermo2013");
    let section = section(&pair.geometry, 100e-6);
    let at = section.point(0.0);
    let curvature = |pair: &Plain| {
        let found = flanks(pair, &section, at);
        let closest = found.closest();
        assert!(closest.s.abs() < 1e-8, "{}", closest.s);
        found.profile(closest.s).curvature
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
        assert_abs_diff_eq!(found / left, 1.0, epsilon = 1e-3);
    }
}

/// Signed distance from the involute of `gear` on the flank `sigma` in the
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
    let turned = [0, 1].map(|g| {
        let pitch_roll = p.roll_at(g, c, 0.0);
        let direction = if w * c > centers[g] { 0.0 } else { PI };
        direction - flank_angle(&p.gears[g], sigma[g], pitch_roll) + spin[g]
    });
    let (gear, mate) = (&p.gears[i], &p.gears[1 - i]);
    let tip = gear.roll_length(gear.tip_radius);
    let form = form_rolls(p)[i];
    (0..=4000)
        .map(|step| {
            let roll = tip + (form - tip) * f64::from(step) / 4000.0;
            let angle = turned[i] + flank_angle(gear, sigma[i], roll);
            let radius = gear.radius_at_roll(roll);
            let x = centers[i] + radius * angle.cos() - centers[1 - i];
            let y = radius * angle.sin();
            let theta = y.atan2(x) - turned[1 - i];
            let turn = (theta / TAU).round() * TAU;
            let g = signed_distance(mate, sigma[1 - i], x.hypot(y), theta - turn);
            (g, roll)
        })
        .filter(|(g, _)| g.is_finite())
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap()
}

/// The closed form of the separation against flanks set up from the signed distance of an involute, on pairs of every kind, the
/// ring as gear 1 included.
#[test]
fn separation_and_arm_of_a_tip_edge_are_those_of_the_signed_distance_from_the_mate() {
    let names = ["palermo2013", "helical-25-47", "planet-ring-27-84"];
    let mut pairs: Vec<PairGeometry> = names.iter().map(|name| plain_pair(name).geometry).collect();
    let mut swapped = pairs[2].clone();
    swapped.gears.swap(0, 1);
    pairs.push(swapped);
    for p in &pairs {
        let section = section(p, 50e-6);
        let path = p.path_of_contact(p.center_distance);
        let [first, last] = section.extended_path;
        assert!(first < path.start && path.end < last, "{path:?}");
        for (end, tip_gear, limit) in [(path.start, 1, first), (path.end, 0, last)] {
            for fraction in [0.2, 0.6, 1.0] {
                let xi = end + fraction * (limit - end);
                let separation = section.point(xi).separation;
                let (distance, roll) = closest(p, tip_gear, xi, 0.0);
                let gear = &p.gears[tip_gear];
                let tip = gear.roll_length(gear.tip_radius);
                assert_eq!(roll, tip, "first to touch: the tip");
                assert_abs_diff_eq!(separation, distance, epsilon = 1e-12);
                assert!(separation > 0.0 && separation < 50.001e-6);
            }
            // The arm is the work that gear 1 does per turn.
            let xi = end + 0.7 * (limit - end);
            let turn = 1e-7;
            let closed = closest(p, tip_gear, xi, -turn).0 - closest(p, tip_gear, xi, turn).0;
            let by_work = closed / (2.0 * turn * p.gears[0].base_radius());
            let arms = section.point(xi).arms;
            assert_abs_diff_eq!(arms[0], by_work, epsilon = 1e-6);
            assert_eq!(arms[1 - tip_gear], 1.0);
            assert!((arms[tip_gear] - 1.0).abs() > 1e-3, "{arms:?}");
        }
        // On the path the flanks touch at the conjugate point.
        let xi = 0.3 * path.end;
        let (distance, roll) = closest(p, 0, xi, 0.0);
        assert_abs_diff_eq!(distance, 0.0, epsilon = 1e-9);
        let point = section.point(xi);
        assert_abs_diff_eq!(roll, point.roll[0], epsilon = 1e-5);
        assert_eq!(point.arms, [1.0; 2]);
    }
}
