//! Where tooth pairs touch in the transverse section, on the path of contact and beyond its ends, and where modified flanks come
//! closest there.

use super::gap::{Breakpoint, GapProfile};
use crate::gear::{Microgeometry, PairGeometry, PairNumbers};
use crate::root::bisection;

const HALVINGS: usize = 30;

/// A point that may touch: lengths of roll on both gears and what separates the flanks there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransversePoint {
    /// Length of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Gap between the unmodified flanks along the line of action, m: zero on the path of contact.
    pub separation: f64,
    /// Slope of this gap over the distance along the flanks towards the tip of gear 1: beyond the path their inclination.
    pub slope: f64,
    /// Arms of the contact force about the axes of gear 1 and gear 2 over their base radii: 1 on the path and on the
    /// gear whose flank a tip edge bears on, whose normals touch its own base circle.
    pub arms: [f64; 2],
}

/// The transverse section at one centre distance.
///
/// Coordinates: pitch point as origin, x along the line of action in the sense in which contact moves, y normal to it, O1 at
/// y = -rb1. Both base circles carry their tangent points along +x while the pair turns. The length of roll is
/// rb tan phi + q xi on either gear.
#[derive(Debug, Clone, PartialEq)]
pub struct TransverseSection {
    /// Those of the pair.
    pub numbers: PairNumbers,
    /// Lengths of roll at which the involutes end at the root, m.
    pub form_rolls: [f64; 2],
    /// Of the operating transverse pressure angle.
    tan_phi: f64,
    path: [f64; 2],
    /// Ends of the extended path of contact, m from the pitch point: the path, and where tip edges count, what lies beyond it up to
    /// where they are followed. Candidates lie on it.
    pub extended_path: [f64; 2],
}

impl TransverseSection {
    /// Section at `center_distance`, m; with `separation_limit` (m) tip corners are followed beyond the path until flanks are that far
    /// apart. None without a path of contact.
    pub fn new(
        numbers: &PairNumbers,
        center_distance: f64,
        form_rolls: [f64; 2],
        separation_limit: Option<f64>,
    ) -> Option<TransverseSection> {
        // NaN where base circles have no common tangent.
        let (c, base) = (center_distance, numbers.base_radius_sum);
        let tan_phi = ((c - base) * (c + base)).sqrt() / base;
        let beyond =
            |i: usize| numbers.kappa[i] * (numbers.tip_roll[i] - numbers.base_radius[i] * tan_phi);
        let path = [-beyond(1), beyond(0)];
        let length = path[1] - path[0];
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let mut section = TransverseSection {
            numbers: *numbers,
            form_rolls,
            tan_phi,
            path,
            extended_path: path,
        };
        if let Some(limit) = separation_limit {
            for end in 0..2 {
                section.extended_path[end] = section.extended_end(end, limit);
            }
        }
        Some(section)
    }

    /// The section at a `center_distance` (m) next to this one, with candidates as far as here.
    pub fn near(&self, center_distance: f64) -> Option<TransverseSection> {
        let section =
            TransverseSection::new(&self.numbers, center_distance, self.form_rolls, None)?;
        Some(TransverseSection {
            extended_path: self.extended_path,
            ..section
        })
    }

    /// Mesh positions between which tooth pair 0 lies on the extended path of contact.
    pub fn passage(&self) -> [f64; 2] {
        let tilt = 0.5 * self.numbers.face[1] * self.numbers.tan_beta_b;
        let [first, last] = self.extended_path;
        [first - tilt, last + tilt].map(|end| end / self.numbers.base_pitch)
    }

    /// The point that may touch while the conjugate position of the tooth pair is `xi`.
    pub fn point(&self, xi: f64) -> TransversePoint {
        if xi < self.path[0] {
            self.tip_corner(0, xi)
        } else if xi > self.path[1] {
            self.tip_corner(1, xi)
        } else {
            let n = &self.numbers;
            TransversePoint {
                roll: [0, 1].map(|i| n.base_radius[i] * self.tan_phi + n.q[i] * xi),
                separation: 0.0,
                slope: 0.0,
                arms: [1.0; 2],
            }
        }
    }

    /// The tip edge of the gear whose tip ends the path at `end` (0: gear 2, at the start; 1: gear 1)
    /// against the flank of its mate, both turned to the conjugate position `xi` beyond that end.
    ///
    /// The gap is the signed distance of the mate's involute from the tip edge: base radius times the angle by which the mate would
    /// have to turn to touch it.
    fn tip_corner(&self, end: usize, xi: f64) -> TransversePoint {
        let (tip, mate) = (1 - end, end);
        let n = &self.numbers;
        let (rb, q, tip_roll) = (n.base_radius[tip], n.q[tip], n.tip_roll[tip]);
        let (mate_rb, mate_q) = (n.base_radius[mate], n.q[mate]);
        // y of the base tangent point seen from the centre, over the base radius.
        let (up, mate_up) = if tip == 0 { (1.0, -n.e) } else { (-n.e, 1.0) };
        let turn = (xi - self.path[end]) / rb;
        let (sin, cos) = turn.sin_cos();
        // Seen from the centre of the tip's gear: towards its base tangent point, and along x.
        let from_tip = [rb * sin + q * tip_roll * cos, rb * cos - q * tip_roll * sin];
        let x = from_tip[0] - q * rb * self.tan_phi;
        let y = up * (from_tip[1] - rb);
        // Seen from the centre of the mate.
        let (normal, along) = (mate_up * y + mate_rb, x + mate_q * mate_rb * self.tan_phi);
        let radius = normal.hypot(along);
        let mate_roll = ((radius - mate_rb).max(0.0) * (radius + mate_rb)).sqrt();
        let (seen, involute) = (along.atan2(normal), (mate_roll / mate_rb).atan());
        let involute_angle =
            (xi - mate_q * (mate_roll - mate_rb * self.tan_phi)) / mate_rb + mate_q * involute;
        let behind = mate_rb * (involute_angle - seen);
        // The force acts along the mate's normal, turned by this about the mate's centre.
        let turned = seen - mate_q * involute;
        let arm = (from_tip[1] * turned.cos() + up * mate_up * from_tip[0] * turned.sin()) / rb;
        // By how much the normals have turned out of the line of action: clockwise about a centre below it,
        // counter-clockwise about one above.
        let inclined = (up * turn - mate_up * turned).abs();
        let (mut roll, mut arms, mut side) = ([mate_roll, tip_roll], [1.0, arm], -1.0);
        if tip == 0 {
            (roll, arms, side) = ([tip_roll, mate_roll], [arm, 1.0], 1.0);
        }
        TransversePoint {
            roll,
            separation: side * behind,
            slope: -side * inclined,
            arms,
        }
    }

    /// Farthest conjugate position beyond the path's `end` with a separation below `limit` and a tip edge that faces the involute.
    fn extended_end(&self, end: usize, limit: f64) -> f64 {
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let is_within = |beyond: f64| {
            let point = self.tip_corner(end, self.path[end] + sign * beyond);
            let left = self.numbers.kappa[end] * (self.form_rolls[end] - point.roll[end]);
            point.separation <= limit && left <= 0.0
        };
        let longest = 0.5 * (self.path[1] - self.path[0]);
        self.path[end] + sign * bisection([0.0, longest], HALVINGS, is_within)
    }
}

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
///
/// With s the distance from the nominal point along both flanks towards the tip of gear 1, the gap along the line of action is
///
/// g(s) = g_0 + alpha s + s² / (2 R) + (removal_1 + removal_2) / cos beta_b,
///
/// the lengths of roll moved by s rb / rho on gear 1 (towards its tip) and on gear 2 (towards its root), g_0 and alpha zero on
/// the path of contact and those of the tip edge beyond it. The same s counts in the normal section. Lead modifications do
/// not depend on s: gaps here are without them.
pub struct MatingFlanks<'a> {
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

impl<'a> MatingFlanks<'a> {
    /// The flanks about `at` at `z` (gear 1's frame, m).
    pub fn new(
        geometry: &'a PairGeometry,
        section: &'a TransverseSection,
        microgeometry: [&'a Microgeometry; 2],
        at: TransversePoint,
        z: f64,
    ) -> MatingFlanks<'a> {
        let numbers = &section.numbers;
        let by_roll = [0, 1].map(|i| numbers.kappa[i] / at.roll[i]);
        MatingFlanks {
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
            let gear = &self.geometry.gears[i];
            let piece = self.microgeometry[i].profile(gear, roll, self.z[i]);
            cubic.gap += self.per_cos * piece.removal;
            cubic.slope += self.per_cos * by_s * piece.slope;
            cubic.bend += self.per_cos * by_s * by_s * piece.curvature;
            cubic.twist += self.per_cos * by_s * by_s * by_s * piece.curvature_slope;
            let ends = piece.range.map(|end| (end - self.at.roll[i]) / by_s);
            cubic.end = cubic.end.min(ends[0].max(ends[1]));
        }
        cubic
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
        // On either gear no farther than to its tip and to the end of its involute.
        let room = [0, 1].map(|i| {
            let ends = [self.section.numbers.tip_roll[i], self.section.form_rolls[i]];
            ends.map(|end| ((end - self.at.roll[i]) / self.roll_by_s[i]).abs())
        });
        let low = -room[1][0].min(room[0][1]);
        let high = room[0][0].min(room[1][1]);
        let room = 2.0 * fall / self.curvature;
        let (mut from, high) = (low.max(-room), high.min(room));
        let gap = self.cubic(from).gap;
        let mut least = ClosestPoint { gap, s: from };
        while from < high {
            let at = from + TOLERANCE / self.curvature;
            let cubic = self.cubic(at);
            let (slope, bend, twist) = (cubic.slope, cubic.bend, cubic.twist);
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
        let (n, rolls) = (&self.section.numbers, self.rolls(s));
        let cos = n.cos_beta_b;
        let involutes: f64 = (0..2).map(|i| n.kappa[i] * cos / rolls[i]).sum();
        // Length of flank to the tip edge of a gear.
        let edge = |i: usize| {
            let (tip, roll, double_base) = (n.tip_roll[i], rolls[i], 2.0 * n.base_radius[i]);
            (n.kappa[i] * (tip - roll) * (tip + roll) / double_base).max(0.0)
        };
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
                let start = Breakpoint {
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
        profile.flatten(TOLERANCE / self.curvature);
        profile
    }
}
