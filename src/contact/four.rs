//! Where flanks come closest at four places of a contact line at once, inside the flanks: as [`super::closest`] finds it place by
//! place, where either flank is one parabola over the length of roll from each nominal point to the closest one.

use super::closest::LeastGap;
use super::transverse::TransverseSection;
use crate::f64x4::F64x4;
use crate::gear::{Microgeometry, PairGeometry};
use crate::table::widest;

/// The closest points at four places on the path of contact.
pub struct Four {
    /// Gap along the line of action, m.
    pub gap: F64x4,
    /// Distance from the nominal point along both flanks towards the tip of gear 1, m.
    s: F64x4,
    /// Reciprocals of the lengths of roll of the nominal points, 1/m, and the change of these lengths with s.
    per_roll: [F64x4; 2],
    roll_by_s: [F64x4; 2],
    /// Slopes of both removals over the length of roll at the closest point, along the line of action.
    removal_slope: [F64x4; 2],
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
        xi: F64x4,
        z: F64x4,
    ) -> Option<Four> {
        let numbers = section.numbers();
        let roll = section.rolls_on_path(xi)?;
        let (kappa, rb) = (numbers.kappa, numbers.base_radius);
        let per_roll = [roll[0].recip(), roll[1].recip()];
        let roll_by_s = [
            per_roll[0] * (kappa[0] * rb[0]),
            per_roll[1] * (-kappa[1] * rb[1]),
        ];
        let per_cos = numbers.cos_beta_b.recip();
        // The parabolas about the length of roll of the first place.
        let (mut removals, mut slope) = (F64x4::ZERO, F64x4::ZERO);
        let mut bend = per_roll[0] * kappa[0] + per_roll[1] * kappa[1];
        let mut removal_slope = [F64x4::ZERO; 2];
        let mut curvatures = [0.0; 2];
        let mut ranges = [[0.0; 2]; 2];
        for i in 0..2 {
            let (m, gear) = (microgeometry[i], &geometry.gears[i]);
            let from = roll[i].0[0];
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
            let [low, high] = ranges[i];
            let inside = ((at - tip) * (-at + form)).min((at - low).min(-at + high));
            if !inside.are_positive() {
                return None;
            }
            removal_slope[i] += moved * curvatures[i];
        }
        Some(Four {
            gap: removals + s * 0.5 * slope,
            s,
            per_roll,
            roll_by_s,
            removal_slope,
            removal_curvature: curvatures,
            kappa,
        })
    }

    /// Where the flanks come closest at place `q`.
    #[inline]
    pub fn least(&self, q: usize) -> LeastGap {
        let removal = |i: usize| [self.removal_slope[i].0[q], self.removal_curvature[i]];
        LeastGap {
            gap: self.gap.0[q],
            s: self.s.0[q],
            removal: Some([removal(0), removal(1)]),
        }
    }

    /// Rates of the gaps while the lengths of roll of the nominal points change at each of the rates `rolls`: see
    /// [`super::closest::Flanks::rates`].
    pub fn rates(&self, rolls: [[f64; 2]; 2]) -> [[f64; 4]; 2] {
        widest(
            #[inline(always)]
            || [self.rates_by(rolls[0]).0, self.rates_by(rolls[1]).0],
        )
    }

    #[inline(always)]
    fn rates_by(&self, rolls: [f64; 2]) -> F64x4 {
        let (mut curvature, mut gap) = (F64x4::ZERO, F64x4::ZERO);
        for (i, roll_rate) in rolls.into_iter().enumerate() {
            let relative = self.per_roll[i] * roll_rate;
            curvature -= relative * self.per_roll[i] * self.kappa[i];
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
    use crate::contact::tests::relieved;
    use approx::assert_abs_diff_eq;

    #[test]
    fn four_places_at_once_are_four_places() {
        let mut held = 0;
        for name in ["palermo2013", "planet-ring-27-84"] {
            let mut pair = relieved(name, 7e-6, 0.5);
            for gear in &mut pair.microgeometry.drive {
                gear.lead_crowning = 4.5e-6;
            }
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
                let four = Four::new(geometry, &section, microgeometry, F64x4(places), F64x4(z));
                let Some(four) = four else { continue };
                held += 1;
                let rolls = section.roll_rates();
                let rates = four.rates(rolls);
                for q in 0..4 {
                    let point = section.point(places[q]);
                    let flanks = Flanks::new(geometry, &section, microgeometry, point, z[q]);
                    let least = flanks.least_gap();
                    assert_abs_diff_eq!(four.gap.0[q], least.gap, epsilon = 1e-18);
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
