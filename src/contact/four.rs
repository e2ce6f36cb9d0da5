//! Where flanks come closest at four places of a contact line at once, inside the flanks: as [`super::closest`] finds it place by
//! place, where either flank is one parabola over the length of roll from each nominal point to the closest one.

use wide::f64x4;

use super::closest::LeastGap;
use super::transverse::TransverseSection;
use crate::gear::{Microgeometry, PairGeometry};

/// The closest points at four places on the path of contact.
pub struct Four {
    /// Gap along the line of action, m.
    pub gap: f64x4,
    /// Distance from the nominal point along both flanks towards the tip of gear 1, m.
    s: f64x4,
    /// Lengths of roll of the nominal points, m, and their change with s.
    roll: [f64x4; 2],
    roll_by_s: [f64x4; 2],
    /// Slopes of both removals over the length of roll at the closest point, along the line of action.
    removal_slope: [f64x4; 2],
    /// Their curvatures.
    removal_curvature: [f64; 2],
    kappa: [f64; 2],
}

impl Four {
    /// Those at the conjugate positions `xi` (m from the pitch point) and at `z` (gear 1's frame, m); `None` where one of them
    /// is not as said above, or a flank has a topography or a slope.
    #[inline(always)]
    pub fn new(
        geometry: &PairGeometry,
        section: &TransverseSection,
        microgeometry: [&Microgeometry; 2],
        xi: f64x4,
        z: f64x4,
    ) -> Option<Four> {
        let numbers = section.numbers();
        let roll = section.rolls_on_path(xi)?;
        let (kappa, rb) = (numbers.kappa, numbers.base_radius);
        let per_roll = roll.map(|roll| f64x4::ONE / roll);
        let roll_by_s = [
            per_roll[0] * (kappa[0] * rb[0]),
            per_roll[1] * (-kappa[1] * rb[1]),
        ];
        let per_cos = numbers.cos_beta_b.recip();
        // The parabolas about the length of roll of the first place.
        let (mut removals, mut slope) = (f64x4::ZERO, f64x4::ZERO);
        let mut bend = per_roll[0] * kappa[0] + per_roll[1] * kappa[1];
        let mut removal_slope = [f64x4::ZERO; 2];
        let mut curvatures = [0.0; 2];
        let mut ranges = [[0.0; 2]; 2];
        for i in 0..2 {
            let (m, gear) = (microgeometry[i], &geometry.gears[i]);
            let from = roll[i].as_array()[0];
            let piece = m.profile_parabola(from)?;
            let by = roll[i] - from;
            let curvature = per_cos * piece.curvature;
            let first = by * curvature + per_cos * piece.slope;
            removals += m.lead_removals(gear, z - numbers.face_offset[i]) * per_cos
                + (by * 0.5 * (first + per_cos * piece.slope) + per_cos * piece.removal);
            slope += roll_by_s[i] * first;
            bend += roll_by_s[i] * roll_by_s[i] * curvature;
            (removal_slope[i], curvatures[i]) = (first, curvature);
            ranges[i] = piece.range;
        }
        let s = -slope / bend;
        for i in 0..2 {
            let moved = roll_by_s[i] * s;
            let at = roll[i] + moved;
            let [tip, form] = section.flank_ends(i);
            let [low, high] = ranges[i].map(f64x4::splat);
            let inside = ((at - tip) * (at - form)).simd_lt(f64x4::ZERO);
            if !(inside & at.simd_ge(low) & at.simd_le(high)).all() {
                return None;
            }
            removal_slope[i] += moved * curvatures[i];
        }
        Some(Four {
            gap: removals + s * 0.5 * slope,
            s,
            roll,
            roll_by_s,
            removal_slope,
            removal_curvature: curvatures,
            kappa,
        })
    }

    /// Where the flanks come closest at place `q`.
    #[inline]
    pub fn least(&self, q: usize) -> LeastGap {
        let removal = |i: usize| {
            [
                self.removal_slope[i].as_array()[q],
                self.removal_curvature[i],
            ]
        };
        LeastGap {
            gap: self.gap.as_array()[q],
            s: self.s.as_array()[q],
            removal: Some([removal(0), removal(1)]),
        }
    }

    /// Rates of the gaps while the lengths of roll of the nominal points change at the rates `rolls`: see
    /// [`super::closest::Flanks::rates`].
    #[inline]
    pub fn rates(&self, rolls: [f64; 2]) -> f64x4 {
        let (mut curvature, mut gap) = (f64x4::ZERO, f64x4::ZERO);
        for (i, roll_rate) in rolls.into_iter().enumerate() {
            let relative = f64x4::splat(roll_rate) / self.roll[i];
            curvature -= relative / self.roll[i] * self.kappa[i];
            let held = -(self.s * self.roll_by_s[i] * relative) + roll_rate;
            gap += self.removal_slope[i] * held;
        }
        gap + self.s * self.s * curvature * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::closest::Flanks;
    use crate::contact::numbers::PairNumbers;
    use crate::pair::Pair;
    use approx::assert_abs_diff_eq;

    #[test]
    fn four_places_at_once_are_four_places() {
        let mut held = 0;
        for text in [
            include_str!("../../resources/pairs/palermo2013.json"),
            include_str!("../../resources/pairs/planet-ring-27-84.json"),
        ] {
            let pair = Pair::from_json(text).unwrap();
            let geometry = &pair.geometry;
            let numbers = PairNumbers::new(geometry);
            let center_distance = geometry.center_distance + 1e-5;
            let section =
                TransverseSection::new(&numbers, center_distance, [0.0; 2], None).unwrap();
            let microgeometry = pair.microgeometry.drive.each_ref();
            let [first, last] = section.reach();
            for step in 0..200 {
                let xi = first + (last - first) * f64::from(step) / 200.0;
                let places = [0.0, 0.3e-4, 0.6e-4, 0.9e-4].map(|by| xi + by);
                let face = numbers.face;
                let z = [0.0, 0.02, 0.5, 0.97].map(|share| face[0] + share * face[1]);
                let four = Four::new(
                    geometry,
                    &section,
                    microgeometry,
                    f64x4::new(places),
                    f64x4::new(z),
                );
                let Some(four) = four else { continue };
                held += 1;
                let rolls = section.roll_rates();
                let rates = rolls.map(|rolls| four.rates(rolls).to_array());
                for q in 0..4 {
                    let point = section.point(places[q]);
                    let flanks = Flanks::new(geometry, &section, microgeometry, point, z[q]);
                    let least = flanks.least_gap();
                    assert_abs_diff_eq!(four.gap.to_array()[q], least.gap, epsilon = 1e-18);
                    let each = flanks.rates(&least, rolls).unwrap();
                    for axis in 0..2 {
                        let epsilon = 1e-12 * rolls[axis][0].abs();
                        assert_abs_diff_eq!(rates[axis][q], each[axis].0, epsilon = epsilon);
                    }
                }
            }
        }
        assert!(held > 100, "{held}");
    }
}
