//! Loads and pressures along each segment, where contact reaches a tip edge or the start of a relief.
//!
//! An oblique contact line runs out at a tip edge, and crosses the start of a relief, within a fraction of a segment. There it bears
//! less than the segment in its mean; at the start of a relief pressure is largest. So such segments are sampled at several
//! positions, each with the law of its own gap and distance from the edge.
//!
//! Segments know one displacement of the teeth each. The penetration of a sample near an edge is what a straight line between the
//! middles of neighbouring segments closes there, less the gap; it shares out what the segment bears.

use std::iter;

use super::position::{EdgeLoad, LawAt, LawsAlong, PositionProblem};
use gearmesh::contact::{Candidate, ContactLines, LocalContact, POINTS, PointLoads, Solution};
use gearmesh::root::bracket;

const AT_POINTS: [f64; POINTS] = [-0.375, -0.125, 0.125, 0.375];

const AT_RELIEF: [f64; 4] = [-0.5, -0.25, 0.25, 0.5];

/// Halvings in the search for the position at which the contact line comes to an edge: to a micrometre of face.
const BISECTIONS: usize = 12;

/// How far contact on bent teeth moves at most along the profile, over the approach for which tip edges are followed: a tooth two modules high
/// that deflects by the approach is tilted by half of it over the module, flanks have radii of up to ten modules.
const MOVES_OVER_APPROACH: f64 = 5.0;

/// What a segment bears at one position.
struct Sample<'a> {
    segment: usize,
    z: f64,
    line_load: f64,
    law: &'a LocalContact,
}

impl Sample<'_> {
    fn reaches_edge(&self) -> bool {
        self.line_load > self.law.load_at_edge()
    }

    /// z (m) and line load (N/m) where contact ceases to reach the edge between here, where it does, and `other`, where it does not.
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
        let part = if part.is_nan() { 0.0 } else { part.min(1.0) };
        let z = self.z + part * (other.z - self.z);
        (z, self.line_load + part * rise)
    }
}

impl PositionProblem {
    /// Makes the laws along the segments, which lie on `lines`.
    pub(super) fn sample_along(&mut self, lines: &ContactLines<'_>) {
        // The contact lines of spur pairs run along edges and the starts of reliefs.
        if self.contact.numbers.tan_beta_b == 0.0 {
            return;
        }
        let along = (self
            .contact
            .candidates
            .iter()
            .zip(&self.contact.local)
            .enumerate())
        .map(|(i, (segment, law))| {
            let mut along = LawsAlong::default();
            let moves = match self.contact.moves() {
                true => MOVES_OVER_APPROACH * lines.setup.followed_approach,
                false => 0.0,
            };
            if law.has_edge(moves) {
                along.edge = self.laws_along(lines, i, &positions_near_edge(lines, segment));
            }
            if law.has_relief(moves) {
                along.relief = self.laws_along(lines, i, &AT_RELIEF);
            }
            along
        });
        self.along = along.collect();
    }

    /// Laws of segment `i` on `lines` at `positions`, parts of its length from its middle.
    fn laws_along(&self, lines: &ContactLines<'_>, i: usize, positions: &[f64]) -> Vec<LawAt> {
        let segment = &self.contact.candidates[i];
        let laws = positions.iter().map(|&position| {
            let profile = lines.profile_along(segment, position);
            let law = self.contact.law(segment, &profile, self.contact.lengths(i));
            LawAt { position, law }
        });
        laws.collect()
    }

    /// Largest line load at a tip edge of each segment that bears in `solution`; `gap` are the gaps at the points of the segments
    /// along the normal under its misalignment, m.
    pub(super) fn edge_loads(
        &self,
        solution: &Solution,
        gap: &[[f64; POINTS]],
    ) -> Vec<Option<EdgeLoad>> {
        let mut all = vec![None; self.contact.candidates.len()];
        let samples = (0..all.len()).flat_map(|i| self.samples(i, solution, &gap[i]));
        let samples: Vec<Sample<'_>> = samples.collect();
        for (number, sample) in samples.iter().enumerate() {
            let i = sample.segment;
            if solution.force[i] <= 0.0 || !sample.reaches_edge() {
                continue;
            }
            let segment = &self.contact.candidates[i];
            let gear = segment.profile.edge_gear();
            let ends = neighbours(&samples, number)
                .filter(|other| {
                    are_neighbours(segment, &self.contact.candidates[other.segment])
                        && !other.reaches_edge()
                })
                .map(|other| sample.last_towards(other));
            for (z, line_load) in iter::once((sample.z, sample.line_load)).chain(ends) {
                all[i] = EdgeLoad::larger(all[i], Some(EdgeLoad { line_load, z, gear }));
            }
        }
        all
    }

    /// Loads along segment `i` near an edge; where its laws are not known, at its points.
    fn samples<'a>(
        &'a self,
        i: usize,
        solution: &Solution,
        gap: &[f64; POINTS],
    ) -> Vec<Sample<'a>> {
        let segment = &self.contact.candidates[i];
        let [below, above] = self.closing_slopes(i, solution);
        let laws: Vec<(f64, &LocalContact)> = match self.along.get(i) {
            Some(along) => (along.edge.iter())
                .map(|at| (at.position, &at.law))
                .collect(),
            None => AT_POINTS.map(|at| (at, &self.contact.local[i])).to_vec(),
        };
        let samples = laws.iter().map(|&(position, law)| {
            let along = position * (segment.z[1] - segment.z[0]);
            let slope = if position < 0.0 { below } else { above };
            let penetration = solution.closing[i] + along * slope - between_points(gap, position);
            Sample {
                segment: i,
                z: segment.middle() + along,
                line_load: law.line_load(penetration).load,
                law,
            }
        });
        let mut samples: Vec<_> = samples.collect();
        let at_points = laws.iter().zip(&samples);
        let at_points = at_points.filter(|((position, _), _)| AT_POINTS.contains(position));
        let sum: f64 = at_points.map(|(_, sample)| sample.line_load).sum();
        // The points share what the segment bears, or less: one in whose corner contact ends bears more than the line does there.
        let known = solution.force[i] / self.contact.local[i].length();
        if sum > known {
            samples.iter_mut().for_each(|s| s.line_load *= known / sum);
        }
        let off_points = laws
            .iter()
            .position(|(position, _)| !AT_POINTS.contains(position));
        if let Some(number) = off_points {
            let loads = neighbours(&samples, number).map(|sample| sample.line_load);
            let most = loads.fold(0.0, f64::max);
            samples[number].line_load = samples[number].line_load.min(most);
        }
        samples
    }

    /// Slopes over z (m/m) of what the segments close, from the middle of segment `i` to those of its neighbours below and above;
    /// where one is missing, that on the other side.
    fn closing_slopes(&self, i: usize, solution: &Solution) -> [f64; 2] {
        let [below, above] = self.neighbours(i).map(|other| {
            let other = other?;
            let [here, there] = [i, other].map(|i| self.contact.candidates[i].middle());
            let (law, next) = (&self.contact.local[i], &self.contact.local[other]);
            let line_load = solution.force[other] / (POINTS as f64 * next.length());
            let closing = solution.closing[other] + law.takes_up_more_than(next, line_load);
            Some((closing - solution.closing[i]) / (there - here))
        });
        [below.or(above), above.or(below)].map(|slope| slope.unwrap_or(0.0))
    }

    /// Largest pressure (Pa) inside the flanks of each segment under `loads`; `edges` are the loads at their tip edges.
    pub(super) fn pressures(&self, loads: &[PointLoads], edges: &[Option<EdgeLoad>]) -> Vec<f64> {
        let inside: Vec<Option<f64>> = (loads.iter().zip(&self.contact.local))
            .map(|(loads, law)| mean_inside(loads, law))
            .collect();
        let largest = (0..loads.len()).map(|i| {
            let law = &self.contact.local[i];
            let Some(line_load) = inside[i] else {
                // At its middle the line lies nearer to the edge than where it bears.
                return match edges[i] {
                    Some(_) => 0.0,
                    None => law.hertz_pressure(loads[i].force() / POINTS as f64 / law.length()),
                };
            };
            let middle = law.pressure(line_load).unwrap_or(0.0);
            let reliefs = (self.along.get(i).into_iter()).flat_map(|along| &along.relief);
            let pressures = reliefs.filter_map(|at| {
                (at.law).pressure_at_relief(self.line_load(&inside, i, at.position))
            });
            pressures.fold(middle, f64::max)
        });
        largest.collect()
    }

    /// Line load (N/m) at `position` of segment `i`, linear towards its neighbour on that side, if that bears inside the flanks.
    fn line_load(&self, inside: &[Option<f64>], i: usize, position: f64) -> f64 {
        let here = inside[i].unwrap_or(0.0);
        let segment = &self.contact.candidates[i];
        let [below, above] = self.neighbours(i);
        let neighbour = if position < 0.0 { below } else { above };
        let slope = neighbour.and_then(|other| {
            let distance = self.contact.candidates[other].middle() - segment.middle();
            Some((inside[other]? - here) / distance)
        });
        here + slope.unwrap_or(0.0) * position * (segment.z[1] - segment.z[0])
    }

    fn neighbours(&self, i: usize) -> [Option<usize>; 2] {
        let candidates = &self.contact.candidates;
        [i.checked_sub(1), Some(i + 1)].map(|other| {
            let other = other?;
            are_neighbours(&candidates[i], candidates.get(other)?).then_some(other)
        })
    }
}

fn neighbours<T>(items: &[T], number: usize) -> impl Iterator<Item = &T> {
    let before = number.checked_sub(1).and_then(|before| items.get(before));
    before.into_iter().chain(items.get(number + 1))
}

/// Mean line load (N/m) of the loaded points inside the flanks by the law of the middle: what the line bears.
fn mean_inside(loads: &PointLoads, law: &LocalContact) -> Option<f64> {
    let (mut points, mut sum) = (0, 0.0);
    for force in loads.forces {
        if force != 0.0 && force / law.length() <= law.load_at_edge() {
            points += 1;
            sum += force;
        }
    }
    (points > 0).then(|| sum / f64::from(points) / law.length())
}

/// [`AT_POINTS`], and where on `segment` the contact line comes to a tip edge.
fn positions_near_edge(lines: &ContactLines<'_>, segment: &Candidate) -> Vec<f64> {
    let is_off = |at: f64| lines.profile_along(segment, at).edge_distance() > 0.0;
    let mut positions = AT_POINTS.to_vec();
    let ends = match [-0.5, 0.5].map(is_off) {
        [false, true] => [-0.5, 0.5],
        [true, false] => [0.5, -0.5],
        _ => return positions,
    };
    let [at_edge, _] = bracket(ends, BISECTIONS, |at| !is_off(at));
    let next = positions.partition_point(|position| *position < at_edge);
    positions.insert(next, at_edge);
    positions
}

fn are_neighbours(a: &Candidate, b: &Candidate) -> bool {
    a.tooth_pair == b.tooth_pair && a.station.abs_diff(b.station) <= 1
}

/// The cubic through `values` at [`AT_POINTS`], at the part `at` of a segment's length from its middle.
fn between_points(values: &[f64; POINTS], at: f64) -> f64 {
    let parts = (0..POINTS).map(|q| {
        let others = AT_POINTS.into_iter().enumerate().filter(|(r, _)| *r != q);
        let weight = others.map(|(_, point)| (at - point) / (AT_POINTS[q] - point));
        weight.product::<f64>() * values[q]
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn gaps_between_and_beyond_the_points_of_a_segment_are_those_of_a_cubic() {
        let cubic = |at: f64| 2.0 + at * (3.0 - at * (1.0 + 5.0 * at));
        let values = AT_POINTS.map(cubic);
        for at in [-0.5, -0.375, 0.0, 0.2, 0.5] {
            assert_relative_eq!(between_points(&values, at), cubic(at), max_relative = 1e-14);
        }
    }
}
