//! Loads and pressures along each segment, where contact reaches a tip edge or the start of a relief.
//!
//! An oblique contact line runs out at a tip edge, and crosses the start of a relief, within a fraction of a segment. Contact reaches
//! the edge only on the last few hundredths of a millimetre of flank, and a relieved flank bears little there, less than the
//! segment does in its mean; at the start of a relief pressure is largest. So such segments are looked at in several places, each
//! with the law of its own gap and its own distance from the edge. Between two places contact reaches the edge as far as the
//! load there exceeds the least that does.
//!
//! Segments know one displacement of the teeth each. Bodies give way smoothly along the face, the gap does not: the penetration at a
//! place near an edge is what a straight line between the middles of neighbouring segments closes there, less the gap at the place.
//! It shares out what the segment bears. The line load at the start of a relief lies between those of neighbouring segments.

use super::candidates::{Candidate, POINTS};
use super::complementarity::Solution;
use super::local::{LocalContact, PointLoads};
use super::position::PositionProblem;
use super::result::{EdgeLoad, larger};
use super::{candidates::ContactLines, position::law, transverse::PairNumbers};

/// The points of a segment, parts of its length from its middle.
const PLACES: [f64; POINTS] = [-0.375, -0.125, 0.125, 0.375];

/// Places at which the start of a relief is looked for.
const RELIEF_PLACES: [f64; 4] = [-0.5, -0.25, 0.25, 0.5];

/// Halvings in the search for the place at which the contact line comes to an edge: to a micrometre of face.
const BISECTIONS: usize = 12;

/// Laws along a segment, each at a part of its length from its middle, ascending.
pub(super) struct Along {
    /// Near a tip edge; none where contact does not come to one.
    edge: Vec<(f64, LocalContact)>,
    /// Where contact may reach the start of a relief.
    relief: Vec<(f64, LocalContact)>,
}

/// What a place bears.
struct Sample<'a> {
    segment: usize,
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
    /// Makes the laws along the segments, which lie on `lines` at the mesh position `tau`.
    pub(super) fn look_along(&mut self, numbers: &PairNumbers, lines: &ContactLines<'_>, tau: f64) {
        // The contact lines of spur pairs run along edges and the starts of reliefs.
        if numbers.tan_beta_b == 0.0 {
            return;
        }
        let along = |(i, segment): (usize, &Candidate)| {
            let laws = |places: &[f64]| -> Vec<(f64, LocalContact)> {
                let there = places
                    .iter()
                    .map(|&at| (at, lines.profile_along(tau, segment, at)));
                let lengths = self.lengths(i);
                there
                    .map(|(at, profile)| (at, law(numbers, segment, &profile, lengths)))
                    .collect()
            };
            Along {
                edge: match self.local[i].has_edge() {
                    true => laws(&places_near_edge(lines, tau, segment)),
                    false => vec![],
                },
                relief: match self.local[i].has_relief() {
                    true => laws(&RELIEF_PLACES),
                    false => vec![],
                },
            }
        };
        self.along = self.candidates.iter().enumerate().map(along).collect();
    }

    /// Largest line load at a tip edge of each segment that bears in `solution`; `gap` are the gaps at the points of the segments
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
            let i = sample.segment;
            if solution.force[i] <= 0.0 || !sample.reaches() {
                continue;
            }
            let segment = &self.candidates[i];
            let mut add = |z: f64, line_load: f64| {
                let here = EdgeLoad {
                    line_load,
                    z,
                    gear: segment.profile.edge_gear(),
                };
                all[i] = larger(all[i], Some(here));
            };
            add(sample.z, sample.line_load);
            for beside in [at.checked_sub(1), Some(at + 1)] {
                let Some(other) = beside.and_then(|beside| samples.get(beside)) else {
                    continue;
                };
                if are_neighbours(segment, &self.candidates[other.segment]) && !other.reaches() {
                    let (z, line_load) = sample.last_towards(other);
                    add(z, line_load);
                }
            }
        }
        all
    }

    /// What the places of segment `i` bear; those of a segment that was not looked at are its points.
    fn samples<'a>(
        &'a self,
        i: usize,
        solution: &Solution,
        gap: &[f64; POINTS],
    ) -> Vec<Sample<'a>> {
        let segment = &self.candidates[i];
        let [before, behind] = self.closing_rises(i, solution);
        let sample = |(at, law): (f64, &'a LocalContact)| {
            let along = at * (segment.z[1] - segment.z[0]);
            let rise = if at < 0.0 { before } else { behind };
            let penetration = solution.closing[i] + along * rise - between_points(gap, at);
            Sample {
                segment: i,
                z: segment.middle() + along,
                line_load: law.line_load(penetration).load,
                law,
            }
        };
        let places: Vec<_> = match self.along.get(i) {
            Some(along) => along.edge.iter().map(|(at, law)| (*at, law)).collect(),
            None => PLACES.map(|at| (at, &self.local[i])).to_vec(),
        };
        let mut samples: Vec<_> = places.iter().copied().map(sample).collect();
        let points = || (0..places.len()).filter(|&at| PLACES.contains(&places[at].0));
        let sum: f64 = points().map(|at| samples[at].line_load).sum();
        // The points share what the segment bears, or less: one in whose corner contact ends bears more than the line does there.
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

    /// Slopes over z (m/m) of what the segments close, from the middle of segment `i` to those of its neighbours below and above;
    /// where one is missing, that on the other side.
    fn closing_rises(&self, i: usize, solution: &Solution) -> [f64; 2] {
        let rise = |other: usize| {
            let [here, there] = [i, other].map(|i| self.candidates[i].middle());
            let (law, next) = (&self.local[i], &self.local[other]);
            let line_load = solution.force[other] / (POINTS as f64 * next.length());
            let closing = solution.closing[other] + law.takes_up_more_than(next, line_load);
            (closing - solution.closing[i]) / (there - here)
        };
        match self.neighbours(i).map(|other| other.map(rise)) {
            [Some(below), Some(above)] => [below, above],
            [Some(one), None] | [None, Some(one)] => [one; 2],
            [None, None] => [0.0; 2],
        }
    }
    /// Largest pressure (Pa) inside the flanks of each segment under `loads`; `edges` are the loads at their tip edges.
    pub(super) fn pressures(&self, loads: &[PointLoads], edges: &[Option<EdgeLoad>]) -> Vec<f64> {
        let inside: Vec<_> = (0..loads.len())
            .map(|i| self.inside(i, &loads[i]))
            .collect();
        let largest = |(i, force): (usize, &Option<f64>)| {
            let Some(force) = *force else {
                // At its middle the line lies nearer to the edge than where it bears.
                return match edges[i] {
                    Some(_) => 0.0,
                    None => self.local[i].hertz_pressure(loads[i].force() / POINTS as f64),
                };
            };
            let middle = self.local[i].pressure(force).unwrap_or(0.0);
            let along = self
                .along
                .get(i)
                .into_iter()
                .flat_map(|along| &along.relief);
            let pressures = along.filter_map(|(place, law)| {
                law.pressure_at_relief(self.line_load(&inside, i, *place))
            });
            pressures.fold(middle, f64::max)
        };
        inside.iter().enumerate().map(largest).collect()
    }

    /// Mean force (N) of the loaded points of segment `i` that stay inside the flanks by the law of its middle.
    ///
    /// Only the local law tells the points of a segment apart: where the gap changes along it, a point bears more than the line does
    /// there. Their mean is what the line bears.
    fn inside(&self, i: usize, loads: &PointLoads) -> Option<f64> {
        let (mut inside, mut points) = (0.0, 0.0);
        for force in loads.forces {
            if force != 0.0 && !self.local[i].reaches_edge(force) {
                inside += force;
                points += 1.0;
            }
        }
        (points > 0.0).then(|| inside / points)
    }

    /// Line load (N/m) at `place` of segment `i`, linear towards its neighbour on that side, if that bears inside the flanks; `forces` are
    /// the mean ones of the points.
    fn line_load(&self, forces: &[Option<f64>], i: usize, place: f64) -> f64 {
        let known = |i: usize| Some(forces[i]? / self.local[i].length());
        let here = known(i).unwrap_or(0.0);
        let segment = &self.candidates[i];
        let [below, above] = self.neighbours(i);
        let neighbour = if place < 0.0 { below } else { above };
        let rise = neighbour.and_then(|other| {
            let way = self.candidates[other].middle() - segment.middle();
            Some((known(other)? - here) / way)
        });
        here + rise.unwrap_or(0.0) * place * (segment.z[1] - segment.z[0])
    }

    /// The segments below and above segment `i` on its contact line.
    fn neighbours(&self, i: usize) -> [Option<usize>; 2] {
        let candidates = &self.candidates;
        [i.checked_sub(1), Some(i + 1)].map(|other| {
            other.filter(|&other| {
                other < candidates.len() && are_neighbours(&candidates[i], &candidates[other])
            })
        })
    }
}

/// [`PLACES`], and where on `segment` the contact line comes to a tip edge.
fn places_near_edge(lines: &ContactLines<'_>, tau: f64, segment: &Candidate) -> Vec<f64> {
    let is_off = |at: f64| lines.profile_along(tau, segment, at).edge_distance() > 0.0;
    let mut places = PLACES.to_vec();
    let (mut at_edge, mut off) = (-0.5, 0.5);
    let ends = [is_off(at_edge), is_off(off)];
    if ends[0] == ends[1] {
        return places;
    }
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
    places
}

/// Whether two segments follow each other on one contact line, or are one.
fn are_neighbours(a: &Candidate, b: &Candidate) -> bool {
    a.tooth_pair == b.tooth_pair && a.station.abs_diff(b.station) <= 1
}

/// The cubic through `values` at [`PLACES`], at the part `at` of a segment's length from its middle.
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
