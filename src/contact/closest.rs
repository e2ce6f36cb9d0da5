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
//!
//! Reliefs, crowning and slopes are convex over the length of roll, hence so is g; a topography need not be.

use super::local::constants::{LEAST_CURVATURE, TOPOGRAPHY_OVER_RADIUS};
use super::local::{Break, GapProfile};
use super::transverse::{TransversePoint, TransverseSection};
use crate::gear::{Microgeometry, PairGeometry, ProfilePiece};

/// Relative distance at which the search for the closest point ends, over the relative radius of curvature.
const TOLERANCE: f64 = 1e-10;

/// Parabolas that a gap without a topography may pass: reliefs of both flanks begin at four places at most.
const MOST_PIECES: usize = 6;

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
#[derive(Clone, Copy)]
pub struct Flanks<'a> {
    geometry: &'a PairGeometry,
    section: &'a TransverseSection,
    microgeometry: [&'a Microgeometry; 2],
    /// Position along the face in each gear's own frame, m.
    z: [f64; 2],
    at: TransversePoint,
    /// Change of the lengths of roll with s, and of s with them.
    roll_by_s: [f64; 2],
    s_by_roll: [f64; 2],
    /// 1 / R.
    curvature: f64,
    per_cos: f64,
    /// Whether nothing moves the closest point off the nominal line.
    nominal: bool,
    /// Lengths of roll and what is known of both flanks about them.
    known: Option<[(f64, ProfilePiece); 2]>,
}

/// The gap over the distance from one s: a cubic.
struct Cubic {
    gap: f64,
    slope: f64,
    bend: f64,
    twist: f64,
    /// Between which s it holds.
    ends: [f64; 2],
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
        let mut flanks = Flanks {
            geometry,
            section,
            microgeometry,
            z: [0.0; 2],
            at,
            roll_by_s: [0.0; 2],
            s_by_roll: [0.0; 2],
            curvature: 0.0,
            per_cos: section.numbers().cos_beta_b.recip(),
            nominal: !microgeometry.iter().any(|m| m.has_profile()),
            known: None,
        };
        flanks.move_to(at, z);
        flanks
    }

    /// The same flanks about `at` at `z` (gear 1's frame, m).
    #[inline]
    pub fn move_to(&mut self, at: TransversePoint, z: f64) {
        let numbers = self.section.numbers();
        let (kappa, rb) = (&numbers.kappa, &numbers.base_radius);
        let per_roll = at.roll.map(f64::recip);
        self.at = at;
        self.z = numbers.face_offset.map(|offset| z - offset);
        self.roll_by_s = [
            kappa[0] * rb[0] * per_roll[0],
            -kappa[1] * rb[1] * per_roll[1],
        ];
        self.s_by_roll = self.roll_by_s.map(f64::recip);
        self.curvature = kappa[0] * per_roll[0] + kappa[1] * per_roll[1];
    }

    /// Looks at both flanks once about `s`; it counts wherever along the face their profiles are those here.
    pub fn look_at(&mut self, s: f64) {
        let rolls = self.rolls(s);
        self.known = Some([0, 1].map(|i| (rolls[i], self.piece(i, rolls[i]))));
    }

    /// Flank `i` about the length of roll `roll`.
    #[inline(always)]
    fn piece(&self, i: usize, roll: f64) -> ProfilePiece {
        if let Some(known) = &self.known {
            let (from, piece) = &known[i];
            if piece.range[0] < roll && roll < piece.range[1] {
                return piece.moved(roll - from);
            }
        }
        self.microgeometry[i].profile(&self.geometry.gears[i], roll, self.z[i])
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
            ends: [f64::NEG_INFINITY, f64::INFINITY],
        };
        for (i, roll) in self.rolls(s).into_iter().enumerate() {
            let piece = self.piece(i, roll);
            let by_s = self.roll_by_s[i];
            cubic.gap += self.per_cos * piece.removal;
            cubic.slope += self.per_cos * by_s * piece.slope;
            cubic.bend += self.per_cos * by_s * by_s * piece.curvature;
            cubic.twist += self.per_cos * by_s * by_s * by_s * piece.curvature_slope;
            let [a, b] = piece
                .range
                .map(|end| (end - self.at.roll[i]) * self.s_by_roll[i]);
            cubic.ends[0] = cubic.ends[0].max(a.min(b));
            cubic.ends[1] = cubic.ends[1].min(a.max(b));
        }
        cubic
    }

    fn at(&self, s: f64) -> LeastGap {
        let gap = self.cubic(s).gap;
        LeastGap { gap, s }
    }

    /// Range of s: the room on either gear towards its tip and towards the end of its involute.
    fn range(&self) -> [f64; 2] {
        let room = [0, 1].map(|i| {
            let ends = self.section.flank_ends(i);
            ends.map(|end| ((end - self.at.roll[i]) * self.s_by_roll[i]).abs())
        });
        [-room[1][0].min(room[0][1]), room[0][0].min(room[1][1])]
    }

    /// Where both flanks come closest; the search begins at the distance `start` (m) from the nominal point.
    pub fn least_gap(&self, start: f64) -> LeastGap {
        if self.nominal {
            return LeastGap {
                gap: self.at.separation,
                s: 0.0,
            };
        }
        let range = self.range();
        if self.microgeometry.iter().any(|m| m.topography.is_some()) {
            return self.least_of_cubics(range);
        }
        self.least_of_parabolas(range, start.max(range[0]).min(range[1]))
            .unwrap_or_else(|| self.least_of_cubics(range))
    }

    /// From `start` downhill, from parabola to parabola of a convex gap without a topography; `None` if it has too many.
    #[inline]
    fn least_of_parabolas(&self, range: [f64; 2], start: f64) -> Option<LeastGap> {
        let (mut s, mut sense) = (start, 0.0);
        for _ in 0..MOST_PIECES {
            // Just beyond a kink that was met.
            let from = s + sense * TOLERANCE / self.curvature;
            let here = self.cubic(from);
            let downhill = -here.slope.signum();
            if sense != 0.0 && downhill != sense {
                return Some(self.at(s));
            }
            let is_first = sense == 0.0;
            sense = downhill;
            // As far as both parabolas and the flanks go.
            let upwards = usize::from(sense > 0.0);
            let [limit, end] = [here.ends[upwards], range[upwards]].map(|end| sense * end);
            if is_first && end <= sense * from {
                // At an end already, as tip edges are.
                return Some(LeastGap { gap: here.gap, s });
            }
            let step = -here.slope / here.bend;
            if sense * (from + step) <= limit.min(end) && here.bend > 0.0 {
                return Some(LeastGap {
                    gap: here.gap + step * (here.slope + 0.5 * step * here.bend),
                    s: from + step,
                });
            }
            s = sense * limit.min(end);
            if end <= limit {
                return Some(self.at(s));
            }
        }
        None
    }

    /// From cubic to cubic of a gap that need not be convex.
    fn least_of_cubics(&self, [low, high]: [f64; 2]) -> LeastGap {
        // Convex removals lie above their tangent at s = 0, a topography changes no faster than its bound: as far as both can
        // make up for the curvature of the flanks.
        let mut fall = self.at.slope.abs();
        for (i, m) in self.microgeometry.iter().enumerate() {
            let steepness = (m.topography.as_ref()).map_or(0.0, |t| t.steepness(self.z[i]));
            let slope = m.slope(&self.geometry.gears[i], self.at.roll[i], self.z[i]);
            fall += self.per_cos * self.roll_by_s[i].abs() * (2.0 * steepness + slope.abs());
        }
        let room = 2.0 * fall / self.curvature;
        let (mut from, high) = (low.max(-room), high.min(room));
        let mut least = self.at(from);
        while from < high {
            // Just beyond the line where the last cubic ended.
            let at = from + TOLERANCE / self.curvature;
            let Cubic {
                gap,
                slope,
                bend,
                twist,
                ends,
            } = self.cubic(at);
            let end = high.min(ends[1]).max(at);
            // The root of slope + bend t + twist t² / 2 at which the gap is least, in a form that no twist of zero spoils.
            let root = (bend * bend - 2.0 * twist * slope).sqrt();
            let valley = at - 2.0 * slope / (bend + root);
            for s in [valley, end] {
                let t = s - at;
                let here = gap + t * (slope + 0.5 * t * (bend + t * twist / 3.0));
                if from <= s && s <= end && here < least.gap {
                    least = LeastGap { gap: here, s };
                }
            }
            from = end;
        }
        least
    }

    /// Where both flanks come closest, as [`Flanks::least_gap`], and the gap about that point.
    pub fn closest_point(&self, start: f64) -> ClosestPoint {
        let least = self.least_gap(start);
        let roll = self.rolls(least.s);
        ClosestPoint {
            roll,
            least,
            profile: self.profile(least.s, roll),
            arms: self.at.arms,
        }
    }

    /// The gap about `s`, where the lengths of roll are `rolls`.
    ///
    /// The tangent of the transverse section is normal to the generator, so the same distances count in the normal
    /// section; the gap is cos beta_b of that along the line of action.
    #[inline]
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
        let mut place = 0;
        for (i, m) in self.microgeometry.iter().enumerate() {
            let by_s = self.roll_by_s[i];
            let by = by_s * TOPOGRAPHY_OVER_RADIUS / self.curvature;
            profile.slope += by_s * m.smooth_slope(&self.geometry.gears[i], rolls[i], self.z[i]);
            profile.curvature += by_s * by_s * m.smooth_curvature(rolls[i], self.z[i], by);
            for relief in m.reliefs() {
                let [slope, curvature] = relief.jumps();
                let at = (relief.start_roll - rolls[i]) / by_s;
                // A search that ends at a kink ends near it.
                let is_here = at.abs() <= 10.0 * TOLERANCE / self.curvature;
                let relief = Break {
                    at: if is_here { 0.0 } else { at },
                    side: relief.side() * by_s.signum(),
                    slope: slope * by_s.abs(),
                    curvature: curvature * by_s * by_s,
                };
                profile.add(place, relief);
                place += 1;
            }
        }
        // Only a topography can have less.
        profile.curvature = profile.curvature.max(LEAST_CURVATURE * involutes);
        // The flanks are parallel where they come closest, but at an edge; what the search leaves over is none of it, nor
        // is what ends at the root.
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
