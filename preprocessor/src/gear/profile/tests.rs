use std::f64::consts::PI;

use approx::assert_abs_diff_eq;

use super::*;
use crate::samples;
use gearmesh::gear::{PairGeometry, inverse_involute};

fn external(teeth: u32, shift: f64, helix_angle_deg: f64) -> Gear {
    let mut gear = samples::gear(GearKind::External, teeth, 1.0, helix_angle_deg, shift);
    gear.held_radius = 5e-3;
    gear.tip_radius = gear.reference_radius() + 4e-3 * (1.0 + shift);
    gear
}

fn ring(teeth: u32, profile_shift: f64, helix_angle_deg: f64) -> Gear {
    let mut gear = external(teeth, profile_shift, helix_angle_deg);
    gear.kind = GearKind::Ring;
    gear.tool_tip_radius_coefficient = 0.3;
    gear.tip_radius = gear.reference_radius() + 4e-3 * (profile_shift - 0.9);
    gear.held_radius = gear.reference_radius() + 20e-3;
    gear
}

fn gears() -> Vec<Gear> {
    let mut thinned = external(24, 0.1, 20.0);
    thinned.tooth_thinning = 60e-6;
    let mut sharp = external(24, 0.0, 10.0);
    sharp.tool_tip_radius_coefficient = 0.0;
    vec![
        external(20, 0.0, 0.0),
        external(20, 0.0, 13.0),
        external(17, 0.5, 30.0),
        external(12, 0.0, 0.0),
        external(9, 0.0, 20.0),
        external(100, -0.4, 0.0),
        thinned,
        sharp,
    ]
}

fn rings() -> Vec<Gear> {
    let mut widened = ring(60, 0.2, 0.0);
    widened.tooth_thinning = 50e-6;
    vec![ring(60, 0.0, 0.0), ring(72, 0.3, 15.0), widened]
}

fn all() -> impl Iterator<Item = ToothProfile> {
    let gears = gears().into_iter().chain(rings());
    gears.map(|gear| ToothProfile::new(&gear).unwrap())
}

/// Signed distance, m, from the rack in its normal section: rack tooth on the larger-s side of a
/// straight flank, tip round and tip line written down as a solid, not as a parametric curve.
fn distance_to_rack(gear: &Gear, s_transverse: f64, d: f64) -> f64 {
    let (m, a) = (gear.normal_module, gear.normal_pressure_angle);
    let cos_beta = gear.helix_angle.cos();
    let s = s_transverse * cos_beta;
    let thinning = gear.tooth_thinning / (2.0 * gear.transverse_pressure_angle().cos()) * cos_beta;
    let s0 = m * (PI / 4.0 + gear.profile_shift * a.tan()) - thinning;
    let height = m * (gear.dedendum_coefficient - gear.profile_shift);
    let rho = gear.tool_tip_radius_coefficient * m;
    let to_flank = s0 * a.cos() + d * a.sin() - s * a.cos();
    let center_d = height - rho;
    let center_s = s0 + center_d * a.tan() + rho / a.cos();
    let (ds, dd) = (s - center_s, d - center_d);
    // The corner region lies between the normals of flank and tip line.
    match (a..=PI / 2.0).contains(&dd.atan2(-ds)) {
        true => ds.hypot(dd) - rho,
        false => to_flank.max(d - height),
    }
}

/// Distance of a point of the gear (polar) from the rack when the rack stands at `u`.
fn distance_at(gear: &Gear, radius: f64, angle: f64, u: f64) -> f64 {
    let r = gear.reference_radius();
    let (y, x) = (angle + u / r).sin_cos();
    distance_to_rack(gear, radius * y - u, r - radius * x)
}

/// Least distance over all positions of the rolling rack.
fn least_distance(gear: &Gear, radius: f64, angle: f64) -> f64 {
    let m = gear.normal_module;
    let n = 4000;
    let at = |u: f64| distance_at(gear, radius, angle, u);
    let step = 10.0 * m / f64::from(n);
    let best = (0..=n)
        .map(|k| -5.0 * m + step * f64::from(k))
        .min_by(|a, b| at(*a).total_cmp(&at(*b)))
        .unwrap();
    // The distance is convex about the best station.
    let (low, slope) = (best - step, |u: f64| at(u + 1e-9) - at(u - 1e-9));
    at(gearmesh::root::bisection([low, best + step], 50, |u| {
        slope(u) < 0.0
    }))
}

#[test]
fn the_rolling_rack_touches_every_point_of_the_profile_and_cuts_none() {
    for gear in gears() {
        let profile = ToothProfile::new(&gear).unwrap();
        let tip_roll = gear.roll_length(gear.tip_radius);
        let fillet = (0..=12).map(|k| profile.fillet(f64::from(k) / 12.0));
        let flank = (0..=12).map(|k| {
            let form = profile.form_roll();
            profile.point_on_flank(form + (tip_roll - form) * f64::from(k) / 12.0)
        });
        for (k, point) in fillet.chain(flank).enumerate() {
            let distance = least_distance(&gear, point.radius(), point.angle());
            let (z, x) = (gear.teeth, gear.profile_shift);
            assert!(distance.abs() < 1e-9, "z {z}, x {x}, {k}: {distance:e} m");
        }
    }
}

#[test]
fn the_fillet_rises_from_root_circle_to_involute_and_runs_smoothly_into_them_without_undercut() {
    for profile in all() {
        let (gear, root) = (profile.gear(), profile.fillet(0.0));
        assert_abs_diff_eq!(root.radius(), gear.root_radius(), epsilon = 1e-14);
        assert_abs_diff_eq!(root.angle(), profile.root_angle(), epsilon = 1e-13);
        assert!(profile.root_angle() <= profile.half_pitch());
        let radial = root.position.map(|c| gear.kappa() * c / root.radius());
        assert_abs_diff_eq!(root.normal[..], radial[..], epsilon = 1e-12);
        let top = profile.fillet(1.0);
        let form = profile.point_on_flank(profile.form_roll());
        assert_abs_diff_eq!(top.position[..], form.position[..], epsilon = 1e-12);
        if !profile.is_undercut() {
            assert_abs_diff_eq!(top.normal[..], form.normal[..], epsilon = 1e-10);
        }
        let radius = |k| gear.kappa() * profile.fillet(f64::from(k) / 100.0).radius();
        assert!((0..100).all(|k| radius(k) < radius(k + 1)));
    }
}

#[test]
fn normals_are_square_to_the_outline_and_point_into_the_space() {
    for profile in all() {
        let gear = profile.gear();
        let middle = 0.5 * (profile.form_roll() + gear.roll_length(gear.tip_radius));
        let fillet = [0.6, 0.6 - 1e-5, 0.6 + 1e-5].map(|t| profile.fillet(t));
        let flank = [1.0, 1.0 - 1e-5, 1.0 + 1e-5].map(|t| profile.point_on_flank(middle * t));
        for [at, before, after] in [fillet, flank] {
            let along = [0, 1].map(|c| after.position[c] - before.position[c]);
            let n = at.normal;
            assert_abs_diff_eq!(n[0].hypot(n[1]), 1.0, epsilon = 1e-14);
            let slope = (along[0] * n[0] + along[1] * n[1]) / along[0].hypot(along[1]);
            assert_abs_diff_eq!(slope, 0.0, epsilon = 1e-8);
            let towards_space = -n[0] * at.angle().sin() + n[1] * at.angle().cos();
            assert!(towards_space > 0.0);
        }
    }
}

#[test]
fn undercut_sets_in_at_the_classical_tooth_number_and_shift() {
    // x_min = h - z sin^2(alpha_t) / (2 cos beta) with h = 1.25 - 0.38 (1 - sin alpha_n), the height of
    // the straight part of the rack's flank over the normal module.
    for (teeth, beta) in [(10, 0.0), (17, 0.0), (14, 20.0), (25, 0.0)] {
        let g = external(teeth, 0.0, beta);
        let h = 1.25 - 0.38 * (1.0 - g.normal_pressure_angle.sin());
        let limit = h - f64::from(teeth) * g.transverse_pressure_angle().sin().powi(2)
            / (2.0 * g.helix_angle.cos());
        let undercut = |x: f64| {
            let profile = ToothProfile::new(&external(teeth, x, beta)).unwrap();
            (profile.is_undercut(), profile.form_radius())
        };
        let rb = g.base_radius();
        let (is, form) = undercut(limit - 1e-4);
        assert!(is && form > rb);
        let (is, form) = undercut(limit + 1e-4);
        assert!(!is && form >= rb);
    }
}

#[test]
fn the_fillet_of_a_ring_is_an_arc_of_its_radius() {
    for gear in rings() {
        let profile = ToothProfile::new(&gear).unwrap();
        let [a, b, c] = [0.0, 0.5, 1.0].map(|t| profile.fillet(t).position);
        // Radius of the circle through three points: abc / (4 area).
        let side = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let radius = side(a, b) * side(b, c) * side(c, a) / (4.0 * area);
        assert_abs_diff_eq!(radius, 0.3 * 4e-3, epsilon = 1e-12);
    }
}

#[test]
fn teeth_that_cannot_be_are_refused() {
    use ProfileError::{NoInvolute, PointedTooth, RoundTooLarge, TipInsideBase};
    let mut pointed = external(12, 0.6, 0.0);
    pointed.tip_radius += 4e-3;
    let mut round = external(20, 0.0, 0.0);
    round.tool_tip_radius_coefficient = 0.6;
    let [mut short, mut short_ring] = [external(20, 0.0, 0.0), ring(40, 0.0, 0.0)];
    for gear in [&mut short, &mut short_ring] {
        gear.tip_radius = 0.99 * gear.base_radius();
    }
    for (gear, error) in [
        (pointed, PointedTooth),
        (round, RoundTooLarge),
        (short, NoInvolute),
        (short_ring, TipInsideBase),
    ] {
        assert_eq!(ToothProfile::new(&gear), Err(error));
    }
}

/// Half angle of the tooth's material at `radius`, rad, on the outline between root circle and tip (there: the angle to the
/// fillet or to the involute). None outside.
pub(crate) fn half_thickness_angle(profile: &ToothProfile, radius: f64) -> Option<f64> {
    let (gear, rounding) = (profile.gear(), 1e-12 * profile.gear().root_radius());
    // Distance outside, in the sense from root to tip.
    let above = |limit: f64| gear.kappa() * (radius - limit);
    if radius.is_nan() || above(gear.root_radius()) < -rounding || above(gear.tip_radius) > rounding
    {
        return None;
    }
    if above(profile.form_radius()) >= 0.0 {
        return Some(profile.point_on_flank(gear.roll_length(radius)).angle());
    }
    let fillet = |t: f64| profile.fillet(t);
    let t = bisection([0.0, 1.0], 60, |t| above(fillet(t).radius()) > 0.0);
    Some(fillet(t).angle())
}

#[test]
fn teeth_and_backlash_fill_the_pitch_on_the_operating_pitch_circles() {
    let pinion = |beta| external(20, 0.1, beta);
    let pairs = [0.0, 18.0].into_iter().flat_map(|beta| {
        [
            [pinion(beta), external(33, 0.25, beta)],
            [pinion(beta), ring(60, 0.25, beta)],
            [ring(60, 0.25, beta), pinion(beta)],
        ]
    });
    for mut gears in pairs {
        gears[0].tooth_thinning = 30e-6;
        gears[1].tooth_thinning = 50e-6;
        let [first, second] = gears.each_ref().map(|g| g.kappa() * g.reference_radius());
        let p = PairGeometry {
            gears,
            center_distance: (first + second).abs() + 1.1e-3,
        };
        let c = p.center_distance;
        let teeth: f64 = (0..2)
            .map(|i| {
                let r = p.operating_pitch_radius(i, c);
                let profile = ToothProfile::new(&p.gears[i]).unwrap();
                2.0 * r * half_thickness_angle(&profile, r).unwrap()
            })
            .sum();
        let pitch = 2.0 * PI * p.operating_pitch_radius(0, c) / p.gears[0].z();
        let backlash = p.backlash(c) / p.operating_pressure_angle(c).cos();
        assert_abs_diff_eq!(pitch - teeth, backlash, epsilon = 1e-14);
        let phi = inverse_involute(p.backlash_free_involute());
        let thinning = p.gears[0].tooth_thinning + p.gears[1].tooth_thinning;
        let without = p.backlash(p.base_radius_sum() / phi.cos()) - thinning;
        assert_abs_diff_eq!(without, 0.0, epsilon = 1e-14);
    }
}
