//! Line load where contact reaches a tip edge, place by place.
//!
//! An oblique contact line runs out at a tip edge within a fraction of a strip: contact reaches the edge only on the last few
//! hundredths of a millimetre of flank, and a relieved flank bears little there, less than the strip does in its mean. So strips near
//! an edge are looked at in several places, each with the law of its own gap and its own distance from the edge, and between two
//! places contact reaches the edge as far as the load there exceeds the least that does.
//!
//! Strips know one displacement of the teeth each. Bodies give way smoothly along the face, the gap does not: the penetration at a
//! place is what a straight line between the middles of neighbouring strips closes there, less the gap at the place. It shares out what
//! the strip bears.

use super::candidates::POINTS;
use super::complementarity::Solution;
use super::local::LocalContact;
use super::position::PositionProblem;
use super::result::{EdgeLoad, larger};
use super::{
    candidates::{Candidate, ContactLines},
    numbers::PairNumbers,
    position::law,
};

/// The points of a strip, parts of its length from its middle.
const PLACES: [f64; POINTS] = [-0.375, -0.125, 0.125, 0.375];

/// Halvings in the search for the place at which the contact line comes to an edge: to a micrometre of face.
const BISECTIONS: usize = 12;

/// A place of a strip near a tip edge, part of its length from its middle, and the law there.
pub(super) type NearEdge = (f64, LocalContact);

/// What a place bears.
struct Sample<'a> {
    strip: usize,
    /// Gear 1's frame, m.
    z: f64,
    /// N/m.
    line_load: f64,
    law: &'a LocalContact,
}

impl Sample<'_> {
    fn reaches(&self) -> bool {
        self.law.reaches_edge(self.line_load * self.law.length())
    }

    /// Where contact ceases to reach the edge between this place, where it does, and `other`, where it does not: z (m) and line
    /// load (N/m) there.
    ///
    /// The line load is taken to be linear in between, and so is the root of the least one that reaches the edge, as the
    /// distance from it is.
    fn last_towards(&self, other: &Sample<'_>) -> (f64, f64) {
        let least = [self, other].map(|sample| sample.law.load_at_edge().sqrt());
        let (rise, farther) = (other.line_load - self.line_load, least[1] - least[0]);
        // w + rise t = (least + farther t)², one root in [0, 1].
        let half = least[0] * farther - 0.5 * rise;
        let over = (self.line_load - least[0] * least[0]).max(0.0);
        let part = over / (half + (half * half + over * farther * farther).sqrt());
        // Not a number where nothing in reach of the law reaches the edge.
        let part = if part.is_nan() { 0.0 } else { part.min(1.0) };
        (
            self.z + part * (other.z - self.z),
            self.line_load + part * rise,
        )
    }
}

impl PositionProblem {
    /// Makes the laws of the places of strips near tip edges, which lie on `lines` at the mesh position `tau`.
    pub(super) fn look_at_edges(
        &mut self,
        numbers: &PairNumbers,
        lines: &ContactLines<'_>,
        tau: f64,
    ) {
        // The contact lines of spur pairs run along the edge.
        if numbers.tan_beta_b == 0.0 {
            return;
        }
        let of = |(i, strip): (usize, &Candidate)| {
            if !self.local[i].has_edge() {
                return vec![];
            }
            let there = |at: f64| lines.along(tau, strip, at);
            let is_off = |at: f64| there(at).profile.edge_distance() > 0.0;
            let mut places = PLACES.to_vec();
            let (mut at_edge, mut off) = (-0.5, 0.5);
            let ends = [is_off(at_edge), is_off(off)];
            if ends[0] != ends[1] {
                if ends[0] {
                    (at_edge, off) = (off, at_edge);
                }
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (at_edge + off);
                    match is_off(middle) {
                        true => off = middle,
                        false => at_edge = middle,
                    }
                }
                let next = places.partition_point(|place| *place < at_edge);
                places.insert(next, at_edge);
            }
            let with_law = |at: f64| (at, law(numbers, &there(at), self.lengths(i)));
            places.into_iter().map(with_law).collect()
        };
        self.near_edges = self.candidates.iter().enumerate().map(of).collect();
    }

    /// Largest line load at a tip edge of each strip that bears in `solution`; `gap` are the gaps at the points of the strips
    /// along the normal under its misalignment, m.
    pub(super) fn edge_loads(
        &self,
        solution: &Solution,
        gap: &[[f64; POINTS]],
    ) -> Vec<Option<EdgeLoad>> {
        let mut all = vec![None; self.candidates.len()];
        let samples: Vec<Sample<'_>> = (0..all.len())
            .flat_map(|i| self.samples(i, solution, &gap[i]))
            .collect();
        for (at, sample) in samples.iter().enumerate() {
            let i = sample.strip;
            if solution.force[i] <= 0.0 || !sample.reaches() {
                continue;
            }
            let strip = &self.candidates[i];
            let mut add = |z: f64, line_load: f64| {
                let here = EdgeLoad {
                    line_load,
                    z,
                    gear: strip.edge_gear(),
                };
                all[i] = larger(all[i], Some(here));
            };
            add(sample.z, sample.line_load);
            for beside in [at.checked_sub(1), Some(at + 1)] {
                let Some(other) = beside.and_then(|beside| samples.get(beside)) else {
                    continue;
                };
                if self.are_neighbours(i, other.strip) && !other.reaches() {
                    let (z, line_load) = sample.last_towards(other);
                    add(z, line_load);
                }
            }
        }
        all
    }

    /// What the places of strip `i` bear; those of a strip that was not looked at are its points.
    fn samples<'a>(
        &'a self,
        i: usize,
        solution: &Solution,
        gap: &[f64; POINTS],
    ) -> Vec<Sample<'a>> {
        let strip = &self.candidates[i];
        let [before, behind] = self.closing_rises(i, solution);
        let sample = |(at, law): (f64, &'a LocalContact)| {
            let along = at * (strip.z[1] - strip.z[0]);
            let rise = if at < 0.0 { before } else { behind };
            let penetration = solution.closing[i] + along * rise - between_points(gap, at);
            Sample {
                strip: i,
                z: strip.middle() + along,
                line_load: law.force(penetration).0 / law.length(),
                law,
            }
        };
        let places: Vec<_> = match self.near_edges.get(i) {
            Some(places) => places.iter().map(|(at, law)| (*at, law)).collect(),
            None => PLACES.map(|at| (at, &self.local[i])).to_vec(),
        };
        let mut samples: Vec<_> = places.iter().copied().map(sample).collect();
        let points = || (0..places.len()).filter(|&at| PLACES.contains(&places[at].0));
        let sum: f64 = points().map(|at| samples[at].line_load).sum();
        // The points share what the strip bears, or less: one in whose corner contact ends bears more than the line does there.
        let known = solution.force[i] / self.local[i].length();
        if sum > known {
            samples.iter_mut().for_each(|s| s.line_load *= known / sum);
        }
        // Where the line comes to the edge, it bears no more than beside.
        if let Some(at) = (0..places.len()).find(|&at| !PLACES.contains(&places[at].0)) {
            let beside = [at.checked_sub(1), Some(at + 1)];
            let beside = beside
                .into_iter()
                .flatten()
                .filter_map(|at| samples.get(at));
            let most = beside.map(|sample| sample.line_load).fold(0.0, f64::max);
            samples[at].line_load = samples[at].line_load.min(most);
        }
        samples
    }

    /// Slopes over z (m/m) of what the strips close, from the middle of strip `i` to those of its neighbours below and above;
    /// where one is missing, that on the other side.
    fn closing_rises(&self, i: usize, solution: &Solution) -> [f64; 2] {
        let rise = |other: Option<usize>| {
            let other = other
                .filter(|&other| other < self.candidates.len() && self.are_neighbours(i, other))?;
            let [here, there] = [i, other].map(|i| self.candidates[i].middle());
            let (law, next) = (&self.local[i], &self.local[other]);
            let line_load = solution.force[other] / (POINTS as f64 * next.length());
            let closing = solution.closing[other] + law.takes_up_more_than(next, line_load);
            Some((closing - solution.closing[i]) / (there - here))
        };
        match (rise(i.checked_sub(1)), rise(Some(i + 1))) {
            (Some(below), Some(above)) => [below, above],
            (Some(one), None) | (None, Some(one)) => [one; 2],
            (None, None) => [0.0; 2],
        }
    }

    /// Whether strips `i` and `other` follow each other on one contact line, or are one.
    pub(super) fn are_neighbours(&self, i: usize, other: usize) -> bool {
        let [a, b] = [i, other].map(|i| &self.candidates[i]);
        a.tooth_pair == b.tooth_pair && a.station.abs_diff(b.station) <= 1
    }
}

/// The cubic through `values` at [`PLACES`], at the part `at` of a strip's length from its middle.
fn between_points(values: &[f64; POINTS], at: f64) -> f64 {
    let weight = |q: usize| {
        let others = PLACES.into_iter().enumerate().filter(|(r, _)| *r != q);
        let part = others.map(|(_, place)| (at - place) / (PLACES[q] - place));
        part.product::<f64>()
    };
    (0..POINTS).map(|q| weight(q) * values[q]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn gaps_between_and_beyond_the_points_of_a_strip_are_those_of_a_cubic() {
        let cubic = |at: f64| 2.0 + at * (3.0 - at * (1.0 + 5.0 * at));
        let values = PLACES.map(cubic);
        for at in [-0.5, -0.375, 0.0, 0.2, 0.5] {
            assert_relative_eq!(between_points(&values, at), cubic(at), max_relative = 1e-14);
        }
    }
}
