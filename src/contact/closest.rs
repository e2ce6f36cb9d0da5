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
//! section. Lead modifications do not depend on s.
//!
//! Reliefs, crowning and slopes are convex over the length of roll, hence so is g; a topography need not be.

use super::transverse::{TransversePoint, TransverseSection};
use crate::gear::{Microgeometry, PairGeometry};

/// Relative distance at which the search for the closest point ends, over the relative radius of curvature.
const TOLERANCE: f64 = 1e-10;

/// Points at which a gap that need not be convex is looked at before the search.
const SAMPLES: usize = 64;

/// The closest points of two flanks in one transverse section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    /// Lengths of roll on gear 1 and gear 2, m.
    pub roll: [f64; 2],
    /// Gap along the line of action, m.
    pub gap: f64,
    /// Slope of the gap at the tip edge that is nearest in slope, from the edge into the flank; negative
    /// where the flanks come closest inside.
    pub edge_slope: f64,
    /// The gear, 0 or 1, that this edge belongs to.
    pub edge_gear: usize,
    /// Arm of the contact force about the axis of gear 1 over its base radius, that of unmodified flanks: by
    /// which relief turns the normal, less than a hundredth, is left out.
    pub arm: f64,
}

/// Both flanks about one point of the transverse section.
pub struct Flanks<'a> {
    geometry: &'a PairGeometry,
    microgeometry: &'a [Microgeometry; 2],
    /// Place along the face in each gear's own frame, m.
    z: [f64; 2],
    at: TransversePoint,
    /// Change of the lengths of roll with s.
    roll_by_s: [f64; 2],
    /// 1 / R.
    curvature: f64,
    per_cos: f64,
}

impl<'a> Flanks<'a> {
    /// The flanks about `at` at `z` (gear 1's frame, m).
    pub fn new(
        geometry: &'a PairGeometry,
        microgeometry: &'a [Microgeometry; 2],
        at: TransversePoint,
        z: f64,
    ) -> Flanks<'a> {
        let gear = |i: usize| &geometry.gears[i];
        let along = [1.0, -1.0];
        Flanks {
            geometry,
            microgeometry,
            z: [0, 1].map(|i| z - gear(i).face_offset),
            at,
            roll_by_s: [0, 1]
                .map(|i| along[i] * gear(i).kappa() * gear(i).base_radius() / at.roll[i]),
            curvature: (0..2).map(|i| gear(i).kappa() / at.roll[i]).sum(),
            per_cos: geometry.base_helix_angle().cos().recip(),
        }
    }

    fn rolls(&self, s: f64) -> [f64; 2] {
        [0, 1].map(|i| self.at.roll[i] + s * self.roll_by_s[i])
    }

    /// Gap at `s`.
    fn gap(&self, s: f64) -> f64 {
        let rolls = self.rolls(s);
        let removal = |i: usize| {
            let gear = &self.geometry.gears[i];
            self.microgeometry[i].removal(gear, rolls[i], self.z[i])
        };
        self.at.separation
            + self.at.slope * s
            + 0.5 * s * s * self.curvature
            + self.per_cos * (removal(0) + removal(1))
    }

    /// Slope over s of both removals along the line of action at the lengths of roll `rolls`.
    fn removal_slope(&self, rolls: [f64; 2]) -> f64 {
        let of = |i: usize| {
            let gear = &self.geometry.gears[i];
            self.roll_by_s[i] * self.microgeometry[i].slope(gear, rolls[i], self.z[i])
        };
        self.per_cos * (of(0) + of(1))
    }

    /// dg/ds.
    fn slope(&self, s: f64) -> f64 {
        self.at.slope + s * self.curvature + self.removal_slope(self.rolls(s))
    }

    /// The part of `range` in which the gap is least, for flanks that need not be convex.
    fn least_of(&self, range: [f64; 2]) -> [f64; 2] {
        let step = (range[1] - range[0]) / SAMPLES as f64;
        let at = |k: usize| range[0] + step * k as f64;
        let least = (0..=SAMPLES).min_by(|&a, &b| self.gap(at(a)).total_cmp(&self.gap(at(b))));
        let k = least.unwrap_or(0);
        [at(k.saturating_sub(1)), at((k + 1).min(SAMPLES))]
    }

    /// Zero of dg/ds in `range`, or the end at which g is least.
    fn closest(&self, range: [f64; 2]) -> f64 {
        let [mut low, mut high] = range;
        if self.slope(high) <= 0.0 {
            return high;
        }
        if self.slope(low) >= 0.0 {
            return low;
        }
        let mut s = 0.0f64.clamp(low, high);
        let tolerance = TOLERANCE / self.curvature;
        while high - low > tolerance {
            let slope = self.slope(s);
            if slope > 0.0 {
                high = s;
            } else {
                low = s;
            }
            // The curvature of the flanks outweighs that of reliefs, but for their kinks.
            let newton = s - slope / self.curvature;
            let next = if low < newton && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - s).abs() <= 0.1 * tolerance {
                return next;
            }
            s = next;
        }
        s
    }

    /// Whether nothing moves the closest point off the nominal line.
    fn is_nominal(&self) -> bool {
        self.microgeometry.iter().all(|m| !m.has_profile())
    }

    /// s at which both flanks come closest in `section`.
    fn closest_in(&self, section: &TransverseSection) -> f64 {
        if self.is_nominal() {
            return 0.0;
        }
        let at = &self.at;
        // Room on either gear towards its tip and towards the end of its involute, in s.
        let room = [0, 1].map(|i| {
            let ends = section.flank_ends(i);
            ends.map(|end| ((end - at.roll[i]) / self.roll_by_s[i]).abs())
        });
        let mut range = [-room[1][0].min(room[0][1]), room[0][0].min(room[1][1])];
        if self.microgeometry.iter().any(|m| m.topography.is_some()) {
            range = self.least_of(range);
        }
        self.closest(range)
    }

    /// Least gap along the line of action in `section`, m.
    pub fn least_gap(&self, section: &TransverseSection) -> f64 {
        self.gap(self.closest_in(section))
    }

    /// Where both flanks come closest in `section`.
    pub fn closest_point(&self, section: &TransverseSection) -> ClosestPoint {
        let at = &self.at;
        let s = self.closest_in(section);
        if self.is_nominal() {
            return ClosestPoint {
                roll: at.roll,
                gap: self.gap(s),
                edge_slope: at.edge_slope,
                edge_gear: at.edge_gear,
                arm: at.arm,
            };
        }
        let edges = [-self.edge_slope(section, 0), self.edge_slope(section, 1)];
        let edge_gear = usize::from(edges[1] > edges[0]);
        ClosestPoint {
            roll: self.rolls(s),
            gap: self.gap(s),
            edge_slope: edges[edge_gear],
            edge_gear,
            arm: at.arm,
        }
    }

    /// dg/ds at the tip edge of gear `i`, whose distance is that along the involute.
    fn edge_slope(&self, section: &TransverseSection, i: usize) -> f64 {
        let s = [1.0, -1.0][i] * section.distance_to_edge(i, self.at.roll[i]);
        let mut rolls = self.rolls(s);
        rolls[i] = section.flank_ends(i)[0];
        self.at.slope + s * self.curvature + self.removal_slope(rolls)
    }
}
