//! Whether the teeth of an internal pair foul each other away from the mesh.

use gearmesh::gear::{PairGeometry, involute};

/// Tip pressure angles of external gear and ring, with the external gear's index.
struct Internal<'a> {
    geometry: &'a PairGeometry,
    pinion: usize,
    ring: usize,
}

impl<'a> Internal<'a> {
    fn new(geometry: &'a PairGeometry) -> Option<Self> {
        let ring = geometry.ring()?;
        Some(Internal {
            geometry,
            pinion: 1 - ring,
            ring,
        })
    }

    fn tip_pressure_angle(&self, i: usize) -> f64 {
        let g = &self.geometry.gears[i];
        (g.base_radius() / g.tip_radius).acos()
    }
}

/// Clearance between the tip corners of pinion and ring where the tip circles cross, as an angle of the
/// ring, rad; negative: they foul (trochoid interference). None for an external pair, and where the tip
/// circles do not cross.
///
/// Backlash is no help: both corners belong to a pair of flanks that touch elsewhere, and only the flanks across
/// have the backlash as additional clearance. Under load of either sign one pair touches.
///
/// KHK, Gear Technical Reference, "Interference of internal gears"; DIN 3993-1.
pub(super) fn tip_corner_clearance(geometry: &PairGeometry) -> Option<f64> {
    let pair = Internal::new(geometry)?;
    let (p, r) = (&geometry.gears[pair.pinion], &geometry.gears[pair.ring]);
    let (ap, ar, c) = (p.tip_radius, r.tip_radius, geometry.center_distance);
    let at_pinion = ((ar * ar - ap * ap - c * c) / (2.0 * c * ap)).acos();
    let at_ring = ((c * c + ar * ar - ap * ap) / (2.0 * c * ar)).acos();
    let inv_w = involute(geometry.operating_pressure_angle(c));
    let turned =
        (at_pinion + involute(pair.tip_pressure_angle(pair.pinion)) - inv_w) * p.z() / r.z();
    let clearance = turned + inv_w - involute(pair.tip_pressure_angle(pair.ring)) - at_ring;
    (!clearance.is_nan()).then_some(clearance)
}

/// Whether the pinion can be brought into mesh radially (no trimming interference); true for an
/// external pair. Same sources as [`tip_corner_clearance`].
pub(super) fn assembles_radially(geometry: &PairGeometry) -> bool {
    let Some(pair) = Internal::new(geometry) else {
        return true;
    };
    let ratio = geometry.gears[pair.pinion].z() / geometry.gears[pair.ring].z();
    let alpha_p = pair.tip_pressure_angle(pair.pinion);
    let alpha_r = pair.tip_pressure_angle(pair.ring);
    let cosines = alpha_p.cos() / alpha_r.cos();
    let at_pinion = ((1.0 - cosines.powi(2)) / (1.0 - ratio.powi(2)))
        .sqrt()
        .asin();
    let at_ring = ((cosines.powi(-2) - 1.0) / (ratio.powi(-2) - 1.0))
        .sqrt()
        .asin();
    let inv_w = involute(geometry.operating_pressure_angle(geometry.center_distance));
    let pinion = at_pinion + involute(alpha_p) - inv_w;
    let ring = (at_ring + involute(alpha_r) - inv_w) / ratio;
    // Not a number: the corners never pass each other on the way in.
    pinion >= ring || pinion.is_nan() || ring.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use gearmesh::gear::{Gear, GearKind, ToothProfile};

    /// Pinion of `teeth` in a ring of 60, module 1, without backlash.
    fn internal(teeth: u32) -> PairGeometry {
        let gear = |kind, teeth, tip_radius| Gear {
            tip_radius,
            tool_tip_radius_coefficient: 0.2,
            ..samples::with_module(samples::gear(kind, teeth, 1.0, 0.0, 0.0), 1e-3)
        };
        PairGeometry {
            gears: [
                gear(GearKind::External, teeth, 0.5e-3 * f64::from(teeth) + 1e-3),
                gear(GearKind::Ring, 60, 29.2e-3),
            ],
            center_distance: 0.5e-3 * (60.0 - f64::from(teeth)),
        }
    }

    /// Half angles at the tips of pinion tooth and ring space.
    fn half_angles(p: &PairGeometry) -> [f64; 2] {
        let half = |i: usize| {
            let gear = &p.gears[i];
            ToothProfile::new(gear)
                .unwrap()
                .half_thickness_angle(gear.tip_radius)
                .unwrap()
        };
        [half(0), std::f64::consts::PI / 60.0 - half(1)]
    }

    /// Least clearance, as an angle of the ring, of the leading pinion corner from the wall of its space,
    /// found by turning both gears; ring centre at the origin, pinion at (C, 0), mesh on the +x side. The pinion is
    /// turned ahead of the middle of its space by `ahead`, as an angle of its own.
    fn clearance_by_turning(p: &PairGeometry, ahead: f64) -> f64 {
        let [tooth, _] = half_angles(p);
        let ring = ToothProfile::new(&p.gears[1]).unwrap();
        let (ratio, r) = (p.gears[0].z() / 60.0, p.gears[0].tip_radius);
        (0..200_000)
            .filter_map(|k| {
                let turned = 1e-5 * f64::from(k);
                let (y, x) = (turned + ahead + tooth).sin_cos();
                let (x, y) = (p.center_distance + r * x, r * y);
                // None: inside the ring's tip circle, where the corner is free.
                let tooth_of_ring = ring.half_thickness_angle(x.hypot(y))?;
                let space = ring.half_pitch() - tooth_of_ring;
                Some(space - (y.atan2(x) - turned * ratio))
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn tip_corners_foul_where_turning_the_gears_shows_it() {
        let mut seen = [false; 2];
        for teeth in (24..=54).step_by(2) {
            let p = internal(teeth);
            let formula = tip_corner_clearance(&p).unwrap();
            let turned = clearance_by_turning(&p, 0.0);
            assert_eq!(formula < 0.0, turned < -1e-7, "{teeth}: {formula} {turned}");
            seen[usize::from(formula < 0.0)] = true;
        }
        assert_eq!(seen, [true; 2]);
    }

    #[test]
    fn backlash_widens_the_clearance_of_the_flanks_across_alone() {
        let without = internal(52);
        let formula = clearance_by_turning(&without, 0.0);
        let mut p = without.clone();
        for gear in &mut p.gears {
            gear.tooth_thinning = 40e-6;
        }
        // Half of the 80 um on the line of action to either side of the middle.
        let to_touch = 40e-6 / p.gears[0].base_radius();
        let touching = clearance_by_turning(&p, to_touch);
        let across = clearance_by_turning(&p, -to_touch);
        assert!((touching - formula).abs() < 1e-7, "{touching} {formula}");
        let backlash = 80e-6 / p.gears[1].base_radius();
        assert!(
            (across - formula - backlash).abs() < 0.05 * backlash,
            "{across}"
        );
    }

    #[test]
    fn radial_assembly_agrees_with_pushing_the_pinion_in() {
        let mut seen = [false; 2];
        for teeth in (24..=54).step_by(2) {
            let p = internal(teeth);
            let [tooth, space] = half_angles(&p);
            let (ratio, r) = (
                p.gears[0].z() / 60.0,
                p.gears.each_ref().map(|g| g.tip_radius),
            );
            // Corners move parallel to the line of centres: none may stand wider than the corner of its
            // space, wherever on the pinion the tooth stands.
            let free = (0..=10_000)
                .map(|k| f64::from(k) * 1e-4 * (std::f64::consts::FRAC_PI_2 - tooth))
                .all(|t| r[1] * (t * ratio + space).sin() >= r[0] * (t + tooth).sin() - 1e-12);
            assert_eq!(assembles_radially(&p), free, "{teeth}");
            seen[usize::from(free)] = true;
        }
        assert_eq!(seen, [true; 2]);
    }
}
