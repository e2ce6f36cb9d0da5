use approx::assert_abs_diff_eq;

use super::*;
use crate::gear::samples;

fn gear(kind: GearKind, teeth: u32, hand: f64, helix_angle_deg: f64, x: f64) -> Gear {
    let mut gear = samples::gear(kind, teeth, hand, helix_angle_deg, x);
    let addendum = if kind == GearKind::Ring { 0.8 } else { 1.0 };
    gear.tip_radius = gear.reference_radius() + 4e-3 * (x + gear.kappa() * addendum);
    gear
}

/// External, internal and ring as gear 1, spur and helical, thinned teeth, off the reference centre distance.
fn pairs() -> Vec<PairGeometry> {
    use GearKind::{External, Ring};
    let mut out = Vec::new();
    for beta in [0.0, 18.0] {
        for (kinds, teeth) in [
            ([External, External], [20, 33]),
            ([External, Ring], [20, 60]),
            ([Ring, External], [60, 20]),
        ] {
            let e = if kinds == [External; 2] { 1.0 } else { -1.0 };
            let mut gears = [
                gear(kinds[0], teeth[0], 1.0, beta, 0.1),
                gear(kinds[1], teeth[1], -e, beta, 0.25),
            ];
            gears[0].tooth_thinning = 30e-6;
            gears[1].tooth_thinning = 50e-6;
            let reference = (gears[0].reference_radius() + e * gears[1].reference_radius()).abs();
            out.push(PairGeometry {
                gears,
                center_distance: reference + 1.1e-3,
            });
        }
    }
    out
}

#[test]
fn contact_ratios_agree_with_an_iso_6336_calculation() {
    // 17/43 teeth, module 1, spur and with beta 20 deg, b 10: computed elsewhere after ISO 6336-1.
    for (beta, transverse, overlap) in [(0.0, 1.6211, 0.0), (20.0, 1.491_878_5, 1.088_68)] {
        let gears = [(17, 1.0), (43, -1.0)].map(|(teeth, hand)| {
            let mut g = gear(GearKind::External, teeth, hand, beta, 0.0);
            g.normal_module = 1e-3;
            g.face_width = 10e-3;
            g.tip_radius = g.reference_radius() + 1e-3;
            g
        });
        let center_distance = gears[0].reference_radius() + gears[1].reference_radius();
        let p = PairGeometry {
            gears,
            center_distance,
        };
        let digits = if beta == 0.0 { 5e-5 } else { 5e-8 };
        let ratio = p.transverse_contact_ratio(center_distance);
        assert_abs_diff_eq!(ratio, transverse, epsilon = digits);
        assert_abs_diff_eq!(p.overlap_ratio(), overlap, epsilon = 5e-6);
    }
}

#[test]
fn both_gears_have_their_roll_length_at_every_point_of_the_line_of_action() {
    for p in pairs() {
        let (e, c) = (p.e(), p.center_distance);
        let phi = p.operating_pressure_angle(c);
        let w = p.gears[0].z() / (p.gears[0].z() + e * p.gears[1].z());
        for s in [1.0, -1.0] {
            for xi in [-3e-3, 0.0, 4e-3] {
                // Pitch point and direction of the force on gear 2, O1 at the origin, O2 at (c, 0).
                let x = w * c + xi * e * phi.sin();
                let y = xi * s * p.sc() * phi.cos();
                for (i, distance) in [x.hypot(y), (x - c).hypot(y)].into_iter().enumerate() {
                    let radius = p.gears[i].radius_at_roll(p.roll_at(i, c, xi));
                    assert_abs_diff_eq!(radius, distance, epsilon = 1e-14);
                }
            }
        }
        let path = p.path_of_contact(c);
        assert!(path.start < 0.0 && path.end > 0.0);
        for (i, xi) in [path.end, path.start].into_iter().enumerate() {
            let tip = p.gears[i].radius_at_roll(p.roll_at(i, c, xi));
            assert_abs_diff_eq!(tip, p.gears[i].tip_radius, epsilon = 1e-14);
        }
    }
}
