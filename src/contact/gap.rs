//! The gap between modified flanks: where they come closest, and piece by piece a parabola about that point.
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
//! With t the distance along the flanks from the closest point, in the normal section,
//!
//! gap(t) = slope t + curvature t² / 2 + sum of reliefs (k u + kappa u² / 2), u = max(side (t - at), 0),
//!
//! k the jump of slope at the start of a relief (linear), kappa that of curvature (parabolic). None holds the closest point: a
//! relief on which that lies is the parabola there, and the flank before it the relief. All that removes material is
//! convex, and so is the gap. Over a contact from m - a to m + a, t = m + a cos(theta), the law of a contact needs no more
//! than the first coefficients of gap = g_0 + g_1 cos(theta) + g_2 cos(2 theta) + ...

use std::f64::consts::{FRAC_1_PI, PI};

use super::transverse::{TransversePoint, TransverseSection};
use crate::gear::{Microgeometry, PairGeometry, ProfilePiece};

/// Distance beyond the end of a piece at which the next one is looked up, over the relative radius of curvature.
const TOLERANCE: f64 = 1e-10;

/// Distance over the radius of curvature over which the second difference of a topography is taken: the half-width of contact.
const TOPOGRAPHY_OVER_RADIUS: f64 = 0.02;

/// Least curvature of a gap with a topography over that of the involutes: a hollow may fit the mate all over.
pub const LEAST_CURVATURE: f64 = 0.1;

/// Where flanks come closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
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
    pub at: TransversePoint,
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

    /// Lengths of roll on gear 1 and gear 2 at `s`, m.
    pub fn rolls(&self, s: f64) -> [f64; 2] {
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
    pub fn closest(&self) -> ClosestPoint {
        if self.nominal {
            let gap = self.at.separation;
            return ClosestPoint { gap, s: 0.0 };
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
        let mut least = ClosestPoint { gap, s: from };
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
                    least = ClosestPoint { gap, s };
                }
            }
            from = end;
        }
        least
    }

    /// The gap about the closest point at `s`, normal to the flanks: cos beta_b of that along the line of action.
    pub fn profile(&self, s: f64) -> GapProfile {
        let (numbers, rolls) = (self.section.numbers(), self.rolls(s));
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

/// Where a relief begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefStart {
    /// Distance from the closest point, m.
    pub at: f64,
    /// 1 where the relief lies at larger t, -1 at smaller.
    pub side: f64,
    /// Jump of the slope of the gap k, >= 0.
    pub slope: f64,
    /// Jump of its curvature kappa, 1/m.
    pub curvature: f64,
}

impl ReliefStart {
    pub const NONE: ReliefStart = ReliefStart {
        at: f64::INFINITY,
        side: 1.0,
        slope: 0.0,
        curvature: 0.0,
    };
}

const RELIEFS: usize = 4;

/// The gap about the closest point, over that there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapProfile {
    /// Slope at the closest point, zero but at an edge and between the two sides of a kink.
    pub slope: f64,
    /// Curvature there, 1/m.
    pub curvature: f64,
    /// The reliefs, any that are not there [`ReliefStart::NONE`].
    reliefs: [ReliefStart; RELIEFS],
    /// Tip edge of gear 2, <= 0, and of gear 1, >= 0, m.
    pub edges: [f64; 2],
}

/// Means of the gap over a contact, all under the weight 1 / sqrt(a² - (t - m)²) of a flat punch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Means {
    /// g_0: mean of the gap, m.
    pub gap: f64,
    /// a times its derivative by a, m.
    pub by_log_width: f64,
    /// g_1 and g_2, m.
    pub coefficients: [f64; 2],
}

impl GapProfile {
    pub fn parabola(slope: f64, curvature: f64, edges: [f64; 2]) -> GapProfile {
        GapProfile {
            slope,
            curvature,
            reliefs: [ReliefStart::NONE; RELIEFS],
            edges,
        }
    }

    fn add(&mut self, number: usize, relief: ReliefStart) {
        let mut other = relief;
        if relief.side * relief.at < 0.0 {
            // With v = -side (t - at): max(-v, 0) = -v + max(v, 0), and its square is v² less that of max(v, 0).
            self.slope += relief.side * relief.slope - relief.at * relief.curvature;
            self.curvature += relief.curvature;
            other.side = -relief.side;
            other.curvature = -relief.curvature;
        }
        self.reliefs[number] = other;
    }

    /// Slopes of the gap before and behind the closest point.
    fn slopes_at_closest(&self) -> [f64; 2] {
        let jump = |side: f64| {
            let here = self
                .reliefs
                .iter()
                .filter(|b| b.at == 0.0 && b.side == side);
            here.map(|b| b.slope).sum::<f64>()
        };
        [self.slope - jump(-1.0), self.slope + jump(1.0)]
    }

    /// Distance from the closest point to the nearest tip edge, m.
    pub fn edge_distance(&self) -> f64 {
        self.edges[1].min(-self.edges[0])
    }

    pub fn edge_gear(&self) -> usize {
        let [of_second, of_first] = self.edges;
        usize::from(-of_second < of_first)
    }

    /// Half-width of a contact that just reaches the start of a relief, m.
    pub fn relief_distance(&self) -> f64 {
        let [low, high] = self.edges;
        let to_edge = self.edge_distance();
        let half_width = |b: &ReliefStart| {
            if b.at.abs() <= to_edge {
                b.at.abs()
            } else if high < -low {
                0.5 * (high - b.at)
            } else {
                0.5 * (b.at - low)
            }
        };
        let is_there =
            |b: &&ReliefStart| low < b.at && b.at < high && (b.slope, b.curvature) != (0.0, 0.0);
        let inside = self.reliefs.iter().filter(is_there);
        inside.map(half_width).fold(f64::INFINITY, f64::min)
    }

    fn tilt(&self, m: f64, a: f64) -> (f64, f64) {
        let (mut tilt, mut by_m) = (self.slope + self.curvature * m, self.curvature);
        for b in &self.reliefs {
            let Some((tau, theta, sine)) = part_in_contact(b, m, a) else {
                continue;
            };
            tilt += b.side * FRAC_1_PI * (b.slope * theta + b.curvature * a * (sine - tau * theta));
            by_m += FRAC_1_PI * b.curvature * theta;
            if b.slope != 0.0 && sine > 0.0 {
                by_m += FRAC_1_PI * b.slope / (a * sine);
            }
        }
        (tilt, by_m)
    }

    /// Middle of a contact of the half-width `a`, m: where the mean slope is zero, or at a tip edge. The search begins at `start`.
    pub(super) fn middle(&self, a: f64, start: f64) -> f64 {
        let edges = [self.edges[0] + a, self.edges[1] - a];
        let (mut low, mut high) = (edges[0].max(-a), edges[1].min(a));
        if edges[0] > -a && self.tilt(low, a).0 >= 0.0 {
            return low;
        }
        if edges[1] < a && self.tilt(high, a).0 <= 0.0 {
            return high;
        }
        let mut m = start.clamp(low, high);
        for _ in 0..100 {
            let (tilt, by_m) = self.tilt(m, a);
            if tilt > 0.0 {
                high = m;
            } else {
                low = m;
            }
            let newton = m - tilt / by_m;
            let inside = low < newton && newton < high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            let step = (next - m).abs();
            m = next;
            let enough = if inside { 1e-7 } else { 1e-13 };
            if step <= enough * a {
                break;
            }
        }
        m
    }

    /// How far a contact of the half-width `a` is from tip edges, as a slope: positive where one cuts it off.
    pub(super) fn cut(&self, a: f64) -> f64 {
        let [low, high] = self.edges;
        let before = self.tilt(low + a, a).0;
        let behind = -self.tilt(high - a, a).0;
        before.max(behind)
    }

    /// Means over the contact from `m` - `a` to `m` + `a` (m), a half-width that grows from a tip edge moves its middle.
    pub(super) fn means(&self, m: f64, a: f64) -> Means {
        let mut all = Means {
            gap: self.slope * m + 0.5 * self.curvature * (m * m + 0.5 * a * a),
            by_log_width: 0.5 * self.curvature * a * a,
            coefficients: [
                a * (self.slope + self.curvature * m),
                0.25 * self.curvature * a * a,
            ],
        };
        for b in &self.reliefs {
            let Some((tau, theta, sine)) = part_in_contact(b, m, a) else {
                continue;
            };
            let cube = sine * sine * sine;
            let kink = FRAC_1_PI * b.slope * a;
            let bend = FRAC_1_PI * b.curvature * a * a;
            all.gap += kink * (sine - tau * theta)
                + 0.5 * bend * ((tau * tau + 0.5) * theta - 1.5 * tau * sine);
            all.by_log_width += kink * sine + 0.5 * bend * (theta - tau * sine);
            all.coefficients[0] +=
                b.side * (kink * (theta - tau * sine) + bend * (sine - cube / 3.0 - tau * theta));
            let second = 0.25 * theta + tau * sine * (tau * tau / 6.0 - 5.0 / 12.0);
            all.coefficients[1] += 2.0 / 3.0 * kink * cube + bend * second;
        }
        if m == self.edges[0] + a || m == self.edges[1] - a {
            all.by_log_width += a * self.tilt(m, a).0.abs();
        }
        all
    }
}

/// Position tau of the start of a relief in a contact, the angle up to which the relief takes part, and its sine.
fn part_in_contact(b: &ReliefStart, m: f64, a: f64) -> Option<(f64, f64, f64)> {
    let tau = b.side * (b.at - m) / a;
    if tau >= 1.0 {
        return None;
    }
    if tau <= -1.0 {
        return Some((tau, PI, 0.0));
    }
    let sine = (1.0 - tau * tau).sqrt();
    Some((tau, tau.acos(), sine))
}

#[cfg(test)]
mod tests {
    use super::*;

    impl GapProfile {
        /// Gap at the distance `t` (m), m.
        pub fn gap(&self, t: f64) -> f64 {
            let removal = |b: &ReliefStart| {
                let u = (b.side * (t - b.at)).max(0.0);
                u * (b.slope + 0.5 * u * b.curvature)
            };
            let reliefs = self.reliefs.iter().map(removal).sum::<f64>();
            t * (self.slope + 0.5 * t * self.curvature) + reliefs
        }

        /// [`GapProfile::parabola`] far from both edges, with reliefs: the fields of [`ReliefStart`] in their order.
        pub fn relieved(
            slope: f64,
            curvature: f64,
            reliefs: [(f64, f64, f64, f64); 2],
        ) -> GapProfile {
            let mut profile = GapProfile::parabola(slope, curvature, [-1.0, 1.0]);
            for (number, (at, side, slope, curvature)) in reliefs.into_iter().enumerate() {
                let relief = ReliefStart {
                    at,
                    side,
                    slope,
                    curvature,
                };
                profile.add(number, relief);
            }
            profile
        }
    }
}
