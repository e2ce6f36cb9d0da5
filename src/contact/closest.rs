//! Where modified flanks come closest.
//!
//! Relief tilts a flank: with the slope theta per length of flank, contact moves R theta off the nominal line,
//! where the gap is smaller by theta² R / 2. In the transverse section, s the distance from the nominal point
//! along both flanks towards the tip of gear 1, the gap along the line of action is
//!
//! g(s) = g_0 + alpha s + s² / (2 R) + (removal_1 + removal_2) / cos beta_b,
//!
//! the lengths of roll moved by s rb / rho on gear 1 (towards its tip) and on gear 2 (towards its root), R the
//! relative radius of curvature, g_0 and alpha zero on the path of contact and those of the tip edge beyond it. The
//! tangent of the transverse section is normal to the generator, so the same s counts in the normal
//! section. Lead modifications do not depend on s: gaps here are without them.

use super::profile::{GapProfile, ReliefStart};
use super::transverse::{TransversePoint, TransverseSection};
use crate::gear::{Microgeometry, PairGeometry, ProfilePiece};

/// Distance beyond the end of a piece at which the next one is looked up, over the relative radius of curvature.
const TOLERANCE: f64 = 1e-10;

/// Distance over the radius of curvature over which the second difference of a topography is taken: the half-width of contact.
const TOPOGRAPHY_OVER_RADIUS: f64 = 0.02;

/// Least curvature of a gap with a topography over that of the involutes: a hollow may fit the mate all over.
pub const LEAST_CURVATURE: f64 = 0.1;

/// The closest points of two flanks in one transverse section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    /// Lengths of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Where.
    pub least: LeastGap,
    /// The gap about this point, normal to the flanks.
    pub profile: GapProfile,
    /// Arms of the contact force about the axes of gear 1 and gear 2 over their base radii, those of unmodified flanks: by
    /// which relief turns the normal, less than a hundredth, is left out.
    pub arms: [f64; 2],
}

/// Where flanks come closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastGap {
    /// Gap along the line of action, m.
    pub gap: f64,
    /// Distance from the nominal point along both flanks towards the tip of gear 1, m.
    pub s: f64,
}

/// Both flanks about one point of the transverse section.
pub struct Flanks<'a> {
    geometry: &'a PairGeometry,
    section: &'a TransverseSection,
    microgeometry: [&'a Microgeometry; 2],
    /// Position along the face in each gear's own frame, m.
    z: [f64; 2],
    at: TransversePoint,
    /// Change of the lengths of roll with s.
    roll_by_s: [f64; 2],
    /// 1 / R.
    curvature: f64,
    per_cos: f64,
    /// Whether nothing moves the closest point off the nominal line.
    nominal: bool,
}

/// The gap over the distance from one s: a cubic.
struct Cubic {
    gap: f64,
    slope: f64,
    bend: f64,
    twist: f64,
    /// The s at which it ends.
    end: f64,
}

impl<'a> Flanks<'a> {
    /// The flanks about `at` at `z` (gear 1's frame, m).
    pub fn new(
        geometry: &'a PairGeometry,
        section: &'a TransverseSection,
        microgeometry: [&'a Microgeometry; 2],
        at: TransversePoint,
        z: f64,
    ) -> Flanks<'a> {
        let numbers = section.numbers();
        let by_roll = [0, 1].map(|i| numbers.kappa[i] / at.roll[i]);
        Flanks {
            geometry,
            section,
            microgeometry,
            z: numbers.face_offset.map(|offset| z - offset),
            at,
            roll_by_s: [
                by_roll[0] * numbers.base_radius[0],
                -by_roll[1] * numbers.base_radius[1],
            ],
            curvature: by_roll[0] + by_roll[1],
            per_cos: numbers.cos_beta_b.recip(),
            nominal: !microgeometry.iter().any(|m| m.has_profile()),
        }
    }

    fn rolls(&self, s: f64) -> [f64; 2] {
        [0, 1].map(|i| self.at.roll[i] + s * self.roll_by_s[i])
    }

    /// The gap about `s`.
    #[inline]
    fn cubic(&self, s: f64) -> Cubic {
        let mut cubic = Cubic {
            gap: self.at.separation + s * (self.at.slope + 0.5 * s * self.curvature),
            slope: self.at.slope + s * self.curvature,
            bend: self.curvature,
            twist: 0.0,
            end: f64::INFINITY,
        };
        for (i, roll) in self.rolls(s).into_iter().enumerate() {
            let by_s = self.roll_by_s[i];
            let ProfilePiece {
                removal,
                slope,
                curvature,
                curvature_slope,
                range,
            } = self.microgeometry[i].profile(&self.geometry.gears[i], roll, self.z[i]);
            cubic.gap += self.per_cos * removal;
            cubic.slope += self.per_cos * by_s * slope;
            cubic.bend += self.per_cos * by_s * by_s * curvature;
            cubic.twist += self.per_cos * by_s * by_s * by_s * curvature_slope;
            let ends = range.map(|end| (end - self.at.roll[i]) / by_s);
            cubic.end = cubic.end.min(ends[0].max(ends[1]));
        }
        cubic
    }

    /// Range of s: the room on either gear towards its tip and towards the end of its involute.
    fn range(&self) -> [f64; 2] {
        let room = [0, 1].map(|i| {
            let ends = self.section.flank_ends(i);
            ends.map(|end| ((end - self.at.roll[i]) / self.roll_by_s[i]).abs())
        });
        [-room[1][0].min(room[0][1]), room[0][0].min(room[1][1])]
    }

    /// Where both flanks come closest: the least of all cubics, since with a topography the gap need not be convex.
    pub fn least_gap(&self) -> LeastGap {
        if self.nominal {
            let gap = self.at.separation;
            return LeastGap { gap, s: 0.0 };
        }
        // Convex removals lie above their tangent at s = 0, a topography changes no faster than its bound.
        let mut fall = self.at.slope.abs();
        for (i, m) in self.microgeometry.iter().enumerate() {
            let steepness = (m.topography.as_ref()).map_or(0.0, |t| t.steepness(self.z[i]));
            let piece = m.profile(&self.geometry.gears[i], self.at.roll[i], self.z[i]);
            fall += self.per_cos * self.roll_by_s[i].abs() * (2.0 * steepness + piece.slope.abs());
        }
        let room = 2.0 * fall / self.curvature;
        let [low, high] = self.range();
        let (mut from, high) = (low.max(-room), high.min(room));
        let gap = self.cubic(from).gap;
        let mut least = LeastGap { gap, s: from };
        while from < high {
            let at = from + TOLERANCE / self.curvature;
            let cubic = self.cubic(at);
            let Cubic {
                slope, bend, twist, ..
            } = cubic;
            let end = high.min(cubic.end).max(at);
            // The root of slope + bend t + twist t² / 2 at which the gap is least, in a form that no twist of zero spoils.
            let root = (bend * bend - 2.0 * twist * slope).sqrt();
            let valley = at - 2.0 * slope / (bend + root);
            for s in [valley, end] {
                let t = s - at;
                let gap = cubic.gap + t * (slope + 0.5 * t * (bend + t * twist / 3.0));
                if from <= s && s <= end && gap < least.gap {
                    least = LeastGap { gap, s };
                }
            }
            from = end;
        }
        least
    }

    /// Where both flanks come closest, and the gap about that point.
    pub fn closest_point(&self) -> ClosestPoint {
        let least = self.least_gap();
        let roll = self.rolls(least.s);
        ClosestPoint {
            roll,
            least,
            profile: self.profile(least.s, roll),
            arms: self.at.arms,
        }
    }

    /// The gap about `s`, where the lengths of roll are `rolls`: cos beta_b of that along the line of action.
    fn profile(&self, s: f64, rolls: [f64; 2]) -> GapProfile {
        let numbers = self.section.numbers();
        let cos = numbers.cos_beta_b;
        let involutes: f64 = (0..2).map(|i| numbers.kappa[i] * cos / rolls[i]).sum();
        let edge = |i: usize| self.section.distance_to_edge(i, rolls[i]);
        let slope = cos * (self.at.slope + s * self.curvature);
        let mut profile = GapProfile::parabola(slope, involutes, [-edge(1), edge(0)]);
        if self.nominal {
            return profile;
        }
        let mut number = 0;
        for (i, m) in self.microgeometry.iter().enumerate() {
            let by_s = self.roll_by_s[i];
            let by = by_s * TOPOGRAPHY_OVER_RADIUS / self.curvature;
            let gear = &self.geometry.gears[i];
            let [slope, curvature] = m.smooth_slopes(gear, rolls[i], self.z[i], by);
            profile.slope += by_s * slope;
            profile.curvature += by_s * by_s * curvature;
            for relief in m.reliefs() {
                let kink = relief.piece(relief.start_roll);
                let at = (relief.start_roll - rolls[i]) / by_s;
                let is_here = at.abs() <= 10.0 * TOLERANCE / self.curvature;
                let start = ReliefStart {
                    at: if is_here { 0.0 } else { at },
                    side: relief.side() * by_s.signum(),
                    slope: kink.slope.abs() * by_s.abs(),
                    curvature: kink.curvature * by_s * by_s,
                };
                profile.add(number, start);
                number += 1;
            }
        }
        profile.curvature = profile.curvature.max(LEAST_CURVATURE * involutes);
        // The flanks are parallel where they come closest, but at a tip edge; what the search leaves over is none of it.
        let [before, behind] = profile.slopes_at_closest();
        let at_edge = TOLERANCE / self.curvature;
        if before > 0.0 && profile.edges[0] < -at_edge {
            profile.slope -= before;
        } else if behind < 0.0 && profile.edges[1] > at_edge {
            profile.slope -= behind;
        }
        profile
    }
}
