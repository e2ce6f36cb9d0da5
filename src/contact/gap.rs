//! The gap about the point where modified flanks come closest: piece by piece a parabola.
//!
//! With t the distance along the flanks from the closest point, in the normal section,
//!
//! gap(t) = slope t + curvature t² / 2 + sum of reliefs (k u + kappa u² / 2), u = max(side (t - at), 0),
//!
//! k the jump of slope at the start of a relief (linear), kappa that of curvature (parabolic). A
//! relief on which the closest point lies is part of the parabola there, and the flank before its start then counts as a relief of the
//! other side. All that removes material is convex, and so is the gap. Over a contact from m - a to m + a, t = m + a cos(theta), the law of a contact needs no more
//! than the first coefficients of gap = g_0 + g_1 cos(theta) + g_2 cos(2 theta) + ...

use std::f64::consts::{FRAC_1_PI, PI};

/// Where a relief begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakpoint {
    /// Distance from the closest point, m.
    pub at: f64,
    /// 1 where the relief lies at larger t, -1 at smaller.
    pub side: f64,
    /// Jump of the slope of the gap k, >= 0.
    pub slope: f64,
    /// Jump of its curvature kappa, 1/m.
    pub curvature: f64,
}

impl Breakpoint {
    pub const NONE: Breakpoint = Breakpoint {
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
    /// The reliefs, any that are not there [`Breakpoint::NONE`].
    pub(super) reliefs: [Breakpoint; RELIEFS],
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
    pub(super) fn parabola(slope: f64, curvature: f64, edges: [f64; 2]) -> GapProfile {
        GapProfile {
            slope,
            curvature,
            reliefs: [Breakpoint::NONE; RELIEFS],
            edges,
        }
    }

    pub(super) fn add(&mut self, number: usize, relief: Breakpoint) {
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

    /// Where the gap less `tilt` times t is least, m, within the tip edges: where a flank touches first that is tilted by `tilt` (rad,
    /// positive where it comes closer with growing t).
    pub fn least_under(&self, tilt: f64) -> f64 {
        // Slope of the tilted gap right behind `t` (side 1) or before it (-1), and how it changes with t.
        let slope_at = |t: f64, side: f64| {
            let (mut slope, mut bend) = (self.slope + self.curvature * t - tilt, self.curvature);
            for b in &self.reliefs {
                let u = b.side * (t - b.at);
                if u > 0.0 || (u == 0.0 && b.side == side) {
                    slope += b.side * (b.slope + u * b.curvature);
                    bend += b.curvature;
                }
            }
            (slope, bend)
        };
        let side = match (slope_at(0.0, -1.0).0 > 0.0, slope_at(0.0, 1.0).0 < 0.0) {
            (true, _) => -1.0,
            (_, true) => 1.0,
            _ => return 0.0,
        };
        let edge = self.edges[usize::from(side > 0.0)];
        let mut t = 0.0;
        loop {
            let (slope, bend) = slope_at(t, side);
            if t == edge || side * slope >= 0.0 {
                return t;
            }
            let ahead = |at: &f64| side * (at - t) > 0.0;
            let starts = self.reliefs.iter().map(|b| b.at).filter(ahead);
            let end = starts.fold(
                edge,
                |end, at| if side * (at - end) < 0.0 { at } else { end },
            );
            let least = t - slope / bend;
            if bend > 0.0 && side * (least - end) <= 0.0 {
                return least;
            }
            t = end;
        }
    }

    /// Gap at the distance `t` (m), m.
    pub fn gap(&self, t: f64) -> f64 {
        let removal = |b: &Breakpoint| {
            let u = (b.side * (t - b.at)).max(0.0);
            u * (b.slope + 0.5 * u * b.curvature)
        };
        let reliefs = self.reliefs.iter().map(removal).sum::<f64>();
        t * (self.slope + 0.5 * t * self.curvature) + reliefs
    }

    /// d t / d tilt, m/rad, of the place `t` of [`GapProfile::least_under`]: the relative radius of curvature there; zero at a kink or an edge.
    pub fn radius_at(&self, t: f64) -> f64 {
        let [low, high] = self.edges;
        if t <= low || t >= high || self.reliefs.iter().any(|b| b.at == t && b.slope != 0.0) {
            return 0.0;
        }
        let is_on = |b: &&Breakpoint| b.side * (t - b.at) > 0.0;
        let bends = self.reliefs.iter().filter(is_on).map(|b| b.curvature);
        (self.curvature + bends.sum::<f64>()).recip()
    }

    /// The profile of the gap under `tilt` (rad) about where it is least, [`GapProfile::least_under`].
    pub fn tilted(&self, tilt: f64) -> GapProfile {
        let t = self.least_under(tilt);
        let slope = self.slope + self.curvature * t - tilt;
        let mut profile = GapProfile::parabola(slope, self.curvature, self.edges.map(|e| e - t));
        for (number, relief) in self.reliefs.iter().enumerate() {
            if *relief != Breakpoint::NONE {
                let at = relief.at - t;
                profile.add(number, Breakpoint { at, ..*relief });
            }
        }
        profile.flatten(0.0);
        profile
    }

    /// Makes the flanks parallel at the closest point but at a tip edge, which is no farther than `at_edge` (m): what a search leaves
    /// over is no slope.
    pub fn flatten(&mut self, at_edge: f64) {
        let before = self.slope - self.kink(-1.0);
        let behind = self.slope + self.kink(1.0);
        if before > 0.0 && self.edges[0] < -at_edge {
            self.slope -= before;
        } else if behind < 0.0 && self.edges[1] > at_edge {
            self.slope -= behind;
        }
    }

    /// What the gap falls more steeply before the closest point (side -1) or rises behind it (1), by reliefs that start there.
    pub fn kink(&self, side: f64) -> f64 {
        let here = (self.reliefs.iter()).filter(|b| b.at == 0.0 && b.side == side);
        here.map(|b| b.slope).sum()
    }

    /// Distance from the closest point to the nearest tip edge, m.
    pub fn edge_distance(&self) -> f64 {
        self.edges[1].min(-self.edges[0])
    }

    /// The gear whose tip edge is nearest, 0 or 1.
    pub fn edge_gear(&self) -> usize {
        let [of_second, of_first] = self.edges;
        usize::from(-of_second < of_first)
    }

    /// Half-width of a contact that just reaches the start of a relief, m.
    pub fn relief_distance(&self) -> f64 {
        let [low, high] = self.edges;
        let to_edge = self.edge_distance();
        let half_width = |b: &Breakpoint| {
            if b.at.abs() <= to_edge {
                b.at.abs()
            } else if high < -low {
                0.5 * (high - b.at)
            } else {
                0.5 * (b.at - low)
            }
        };
        let is_there =
            |b: &&Breakpoint| low < b.at && b.at < high && (b.slope, b.curvature) != (0.0, 0.0);
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
fn part_in_contact(b: &Breakpoint, m: f64, a: f64) -> Option<(f64, f64, f64)> {
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
        /// [`GapProfile::parabola`] far from both edges, with reliefs: the fields of [`Breakpoint`] in their order.
        pub fn relieved(
            slope: f64,
            curvature: f64,
            reliefs: [(f64, f64, f64, f64); 2],
        ) -> GapProfile {
            let mut profile = GapProfile::parabola(slope, curvature, [-1.0, 1.0]);
            for (number, (at, side, slope, curvature)) in reliefs.into_iter().enumerate() {
                let relief = Breakpoint {
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
