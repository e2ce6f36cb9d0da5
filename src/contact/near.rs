//! Which strips of a pose may carry, and how fast they change.

use super::candidates::{Candidate, ContactLines, Middle, POINTS, StripRates};
use crate::f64x4::F64x4;

/// Strips, and how fast each changes by mesh position (per cycle) and by centre distance (per m), where that is known.
pub type Moving = (Vec<Candidate>, Vec<Option<[StripRates; 2]>>);

/// Which strips may carry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Approach, m.
    pub approach: f64,
    /// Misalignment, rad.
    pub misalignment: f64,
    /// Part of the largest overlap by which others may be open.
    pub margin: f64,
    /// Whether gaps are convex over the place on the flank.
    pub convex: bool,
}

impl Near {
    /// How far flanks overlap where misalignment has the lever `lever` (m) and their force the arm `arm`, m along the line of
    /// action.
    pub fn overlap(&self, lever: f64, arm: f64, gap: f64) -> f64 {
        arm * self.approach + self.misalignment * lever - gap
    }
}

impl ContactLines<'_> {
    /// Those of [`ContactLines::candidates`] that lie within the conjugate positions `seen` (m) at least in part and that
    /// may carry by `near`, and how fast they change where they touch inside their flanks, on the path of contact, by mesh position (per
    /// cycle) and by centre distance (per m). Some that may not are among them.
    pub fn moving(&self, tau: f64, seen: [f64; 2], near: &Near) -> Moving {
        let mut strips = Vec::with_capacity(4 * self.stations);
        let mut most = 0.0f64;
        for k in self.pairs(tau, 0.0) {
            let closing = self.closing(tau, k)[0];
            let [low, width] = self.section.numbers().face;
            if self.is_out_of(seen, tau, k, [low, low + width]) {
                continue;
            }
            // Places of four middles at once, and which.
            let (mut four, mut group) = (None, usize::MAX);
            for station in 0..self.stations {
                let whole = self.station(station);
                if self.is_out_of(seen, tau, k, whole) {
                    continue;
                }
                if station / POINTS != group {
                    group = station / POINTS;
                    let middles = std::array::from_fn(|q| self.middle(group * POINTS + q));
                    four = self.four(tau, k, F64x4(middles));
                }
                let Some(z) = self.carrying(tau, k, whole) else {
                    continue;
                };
                let at = 0.5 * (z[0] + z[1]);
                let (arm, least, on_path) = match &four {
                    Some(four) if z == whole => (1.0, four.least(station % POINTS), true),
                    _ => {
                        let (flanks, least) = self.place(tau, k, at, false);
                        (flanks.arm(), least, flanks.on_path())
                    }
                };
                let lever = self.section.numbers().lever(self.flank, tau, k, at);
                let overlap = near.overlap(lever, arm, least.gap - closing);
                most = most.max(overlap);
                strips.push((k, station, z, z == whole, on_path, overlap, least));
            }
        }
        let rolls = self.section.roll_rates();
        let mut all = (
            Vec::with_capacity(strips.len()),
            Vec::with_capacity(strips.len()),
        );
        for (i, (k, station, z, whole, _, overlap, least)) in strips.iter().enumerate() {
            // The overlap is concave along whole strips inside the flanks: it does not rise more from the middle of one to its
            // ends than from the middle of either neighbour.
            let beside = |other: Option<usize>| {
                let (pair, at, _, whole, on_path, overlap, _) = strips.get(other?)?;
                let next = *pair == *k && at.abs_diff(*station) == 1;
                (next && *whole && *on_path).then_some(*overlap)
            };
            if near.convex
                && *whole
                && let (Some(before), Some(after)) = (beside(i.checked_sub(1)), beside(Some(i + 1)))
            {
                let most_beside = 0.5 * (overlap - before).max(overlap - after).max(0.0);
                if overlap + most_beside < -near.margin * most {
                    continue;
                }
            }
            let rolls = whole.then_some(rolls);
            let middle = Middle::Known(*least);
            let (strip, rates) = self.candidate(tau, (*k, *station), *z, middle, rolls);
            all.0.push(strip);
            all.1.push(rates);
        }
        all
    }

    /// Whether all of `z` of tooth pair `k` lies out of the conjugate positions `seen` (m), at one end of them.
    fn is_out_of(&self, seen: [f64; 2], tau: f64, k: i32, z: [f64; 2]) -> bool {
        let xi = z.map(|z| self.contact_line(tau, k, z));
        xi[0].max(xi[1]) < seen[0] || xi[0].min(xi[1]) > seen[1]
    }
}
