//! What a tilt of gear 2 closes between helical flanks, from flanks that their motion sweeps out and that share no formula with the
//! solver.

use super::symmetry::text;
use super::*;
use nalgebra::{Matrix2, Rotation3, Unit, Vector2, Vector3};

/// Flanks of a pair, of which one contact line lies in the plane of action at rest.
struct Helicoids {
    /// Axes of gear 1 and gear 2.
    axes: [Vector3<f64>; 2],
    /// Turn of gear 2 over that of gear 1.
    ratio: f64,
    /// Pitch point at mid-face.
    pitch_point: Vector3<f64>,
    /// Line of action, as the force on gear 2 points.
    along: Vector3<f64>,
    /// How far contact moves along the path while gear 1 turns, m/rad.
    per_turn: f64,
    /// Turn of the transverse sections of gear 1 along z, rad/m.
    twist: f64,
    /// Where the contact line lies at mid-face, m along the path from the pitch point.
    start: f64,
}

impl Helicoids {
    fn new(g: &PairGeometry, flank: Flank, start: f64) -> Helicoids {
        let [z1, z2] = [0, 1].map(|i| f64::from(g.gears[i].teeth));
        let (e, s, c) = (g.e(), flank.sign(), g.center_distance);
        let cos_phi = g.base_radius_sum() / c;
        let across = s * (z1 + e * z2).signum() * cos_phi;
        let along = Vector3::new(e * (1.0 - cos_phi * cos_phi).sqrt(), across, 0.0);
        let pitch_point = Vector3::new(c * z1 / (z1 + e * z2), 0.0, g.z_ref());
        let first = &g.gears[0];
        // The line of action touches the base circle.
        let distance = pitch_point.xy().perp(&along.xy()).abs();
        assert_relative_eq!(distance, first.base_radius(), max_relative = 1e-9);
        Helicoids {
            axes: [Vector3::zeros(), Vector3::new(c, 0.0, 0.0)],
            ratio: -e * z1 / z2,
            pitch_point,
            along,
            per_turn: s * first.base_radius(),
            twist: first.hand * first.helix_angle.tan() / first.reference_radius(),
            start,
        }
    }

    /// The point of the flank of `gear` in the plane z = mid-face + `z` that touches after a turn of gear 1.
    fn point(&self, gear: usize, turn: f64, z: f64) -> Vector3<f64> {
        let path = self.start + self.per_turn * (turn + self.twist * z);
        let touching = self.pitch_point + self.along * path + Vector3::z() * z;
        let back = -turn * [1.0, self.ratio][gear];
        self.axes[gear]
            + Rotation3::from_axis_angle(&Vector3::z_axis(), back) * (touching - self.axes[gear])
    }

    /// What a turn of gear 2 by `tilt` (rad) in the plane of action, closing at larger z, closes on the line of action at the point `z`
    /// (m from mid-face) of the contact line, m: the distance of gear 1's point from the nearest one of gear 2.
    fn closing(&self, z: f64, tilt: f64) -> f64 {
        let normal_of_plane = Unit::new_normalize(Vector3::z().cross(&self.along));
        let tilted = Rotation3::from_axis_angle(&normal_of_plane, -tilt);
        let second = |at: Vector2<f64>| {
            self.pitch_point + tilted * (self.point(1, at.x, at.y) - self.pitch_point)
        };
        let fixed = self.point(0, 0.0, z);
        let mut at = Vector2::new(0.0, z);
        for _ in 0..20 {
            let slopes = [Vector2::x(), Vector2::y()].map(|axis| {
                let step = axis * 1e-6;
                (second(at + step) - second(at - step)) / 2e-6
            });
            let off = fixed - second(at);
            let [a, b] = slopes;
            let square = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let along = Vector2::new(a.dot(&off), b.dot(&off));
            at += square.lu().solve(&along).unwrap();
        }
        let off = fixed - second(at);
        // Along the normal it is shorter by cos beta_b than on the line of action.
        let cos_beta_b = (self.per_turn * self.twist).atan().cos();
        off.norm() * off.dot(&self.along).signum() / cos_beta_b
    }
}

#[test]
fn a_tilt_closes_helical_flanks_as_two_exact_helicoids() {
    for (meshing, helix, swap) in [
        ("external", 18.0, false),
        ("external", -25.0, true),
        ("internal", 18.0, false),
        ("internal", -13.0, true),
    ] {
        let pair = pair::from_json(&text(meshing, helix, swap)).unwrap();
        let solver = coarse_solver(&pair, ContactSettings::default());
        let (g, tau, tilt) = (&pair.geometry, 0.3, 1e-6);
        for flank in [Flank::Drive, Flank::Coast] {
            let problem = solver.position(flank, tau, 0.0).unwrap();
            let mut compared = 0;
            for segment in problem.candidates() {
                // Off the path of contact the normal is another.
                if (segment.arms[0] - 1.0).abs() > 1e-6 {
                    continue;
                }
                let start = (tau + f64::from(segment.tooth_pair)) * g.base_pitch();
                let exact = Helicoids::new(g, flank, start);
                for (z, lever) in segment.points().into_iter().zip(segment.levers) {
                    let expected = exact.closing(z - g.z_ref(), tilt) / tilt;
                    assert_abs_diff_eq!(lever, expected, epsilon = 1e-6);
                    compared += 1;
                }
            }
            assert!(compared > 40, "{compared}");
        }
    }
}
