//! How the load of tooth pairs slides: that of each along its own contact line.

use crate::friction::{FrictionLaw, Sliding, SlidingSums};
use crate::gear::{Flank, PairGeometry};
use crate::table::Potential;

/// Points of a contact line at which its load is added up.
const POINTS: usize = 16;

/// The contact lines of one flank.
#[derive(Debug)]
pub struct ContactLines {
    geometry: PairGeometry,
    sums: SlidingSums,
    /// Slope of the contact lines in the plane of action, s h tan beta_b.
    lean: f64,
    /// Whether potentials tell where along the face their load acts.
    has_moment: bool,
}

impl ContactLines {
    /// Those of `flank` of the pair `geometry`, weighted by `law`.
    pub fn new(geometry: &PairGeometry, law: &FrictionLaw, flank: Flank, has_moment: bool) -> Self {
        let hand = geometry.gears[0].hand;
        ContactLines {
            sums: SlidingSums::new(geometry, law),
            lean: flank.sign() * hand * geometry.base_helix_angle().tan(),
            geometry: geometry.clone(),
            has_moment,
        }
    }

    /// Sliding of the loads of `pairs`, the place (base pitches) and the potential of each, at the centre distance offset `offset` (m).
    pub fn sliding(
        &self,
        pairs: impl Iterator<Item = (f64, Potential)> + Clone,
        offset: f64,
    ) -> Sliding {
        let mut sum = Sliding::default();
        let all: f64 = pairs.clone().map(|(_, w)| w.gradient[0]).sum();
        for (place, w) in pairs.filter(|(_, w)| w.gradient[0] > 0.0) {
            self.add(
                &mut sum,
                place * self.geometry.base_pitch(),
                &w,
                all,
                offset,
            );
        }
        sum
    }

    /// Adds the load of the tooth pair at `place` (m from the pitch point at mid-face), out of `all` on the line of action (N).
    ///
    /// Its resultant is known, not how it spreads: as 1 - c t² over the contact line from t = -1 to 1, c by [`roundness`], times
    /// 1 + m t by the resultant; where m = 1 is not enough, only from the loaded end on.
    fn add(&self, sum: &mut Sliding, place: f64, w: &Potential, all: f64, offset: f64) {
        let g = &self.geometry;
        let center_distance = g.center_distance + offset;
        let path = g.path_of_contact(center_distance);
        let half_face = 0.5 * g.face_overlap().1;
        let mut ends = [-half_face, half_face];
        if self.lean != 0.0 {
            // A tip edge that bears beyond the path does so at its end.
            let [a, b] = [path.start, path.end].map(|xi| (xi - place) / self.lean);
            ends = ends.map(|end| end.clamp(a.min(b), a.max(b)));
        }
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        // The moment is that of the levers z + lean y, with y = place + lean z.
        let lever = w.gradient[2] / w.gradient[0];
        let resultant = match self.has_moment {
            true => (lever - self.lean * place) / (1.0 + self.lean * self.lean),
            false => middle,
        };
        let eccentricity = if half > 0.0 {
            (resultant - middle) / half
        } else {
            0.0
        };
        let eccentricity = eccentricity.clamp(-0.99, 0.99);
        let c = roundness(w);
        let most = (1.0 / 3.0 - c / 5.0) / (1.0 - c / 3.0);
        // Part of the line that carries, from the loaded end on, and how far the load on it leans to that end.
        let part = ((1.0 - eccentricity.abs()) / (1.0 - most)).min(1.0);
        let m = (eccentricity.abs() / most).min(1.0);
        let cos = g.base_helix_angle().cos();
        let length = (2.0 * half * part / cos).max(f64::MIN_POSITIVE);
        for i in 0..POINTS {
            let t = (2.0 * i as f64 + 1.0) / POINTS as f64 - 1.0;
            let density = (1.0 - c * t * t) * (1.0 + m * t) / (1.0 - c / 3.0);
            let from_end = part * (1.0 - t);
            let z = middle + half * (1.0 - from_end) * eccentricity.signum();
            let xi = (place + self.lean * z).clamp(path.start, path.end);
            let roll = [0, 1].map(|i| g.roll_at(i, center_distance, xi));
            let force = w.gradient[0] * density;
            let share = force / (all * POINTS as f64);
            self.sums.add(sum, share, roll, z, force / (cos * length));
        }
    }
}

/// The c of a load that spreads as 1 - c t²: 0 of flanks that fit each other, 1 of crowned ones whose ends are about to part. On an
/// elastic foundation force F, energy W and stiffness k make F² / (2 W k) = u with u = (1 - c/3)² / (1 - 2c/3 + c²/5).
fn roundness(w: &Potential) -> f64 {
    let u = w.gradient[0].powi(2) / (2.0 * w.value * w.hessian[0][0]);
    let (rest, square) = (1.0 - u, 0.2 * u - 1.0 / 9.0);
    // NaN without energy, infinite where the load has hardly begun.
    if u > 5.0 / 6.0 && rest > 0.0 {
        (((rest / 3.0).powi(2) + square * rest).sqrt() - rest / 3.0) / square
    } else if u <= 5.0 / 6.0 {
        1.0
    } else {
        0.0
    }
}
