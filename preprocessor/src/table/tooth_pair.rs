//! Static contact of one tooth pair, all other teeth out of the way: where the samples of its table come from.
//!
//! At all places the table goes from the first touch over the same span of approaches: what the largest load takes at the pitch
//! point, and what errors of the teeth add. Beyond the places at which any approach within it makes the pair touch, the
//! first touch stays at a ceiling that none reaches.

use super::coverage::Coverage;
use super::sweep::{Position, Sample, StaticPosition, StaticSource, failed};
use crate::static_contact::{
    ContactError, ContactResult, ContactSolver, PositionProblem, Resultant,
};
use gearmesh::contact::Prescribed;
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::Flank;
use gearmesh::table::{Axes, TableError};
use rayon::prelude::*;

/// Spans from the first touch at the pitch point to the ceiling of the first touch elsewhere.
const CEILING: f64 = 1.5;

/// Ratio of the approach up to which tip edges are followed to that of the pair's own contact.
const FARTHER: f64 = 8.0;

/// Steps in which the ends of the places are sought, base pitches; likewise how far inside the ends of the extended path a pair stays.
const STEP: f64 = 1.0 / 64.0;

/// One tooth pair at the centre distances and misalignments of a table, whose mesh position runs over its places.
pub(super) struct ToothPair {
    solver: ContactSolver,
    nodes: [Vec<f64>; 2],
    approaches: Vec<Approaches>,
    /// First and last place of the table, base pitches; as made, the least range beyond which the pair touches nowhere.
    pub places: [f64; 2],
}

/// Approaches at a centre distance and misalignment, m.
#[derive(Clone, Copy)]
struct Approaches {
    /// Of the first touch, at most.
    ceiling: f64,
    /// Of the table.
    span: f64,
}

impl ToothPair {
    /// Of `flank` over the centre distances and misalignments of `axes`, where errors of the teeth are up to `spread` (m) apart.
    pub fn new(
        solver: &ContactSolver,
        flank: Flank,
        coverage: &Coverage,
        axes: &Axes,
        spread: f64,
    ) -> Result<ToothPair, TableError> {
        let followed = FARTHER * (solver.setup().followed_approach + spread);
        let solver = solver.clone().followed_to(followed);
        let nodes = [&axes.center_distance_offset, &axes.misalignment].map(Clone::clone);
        let torque = Prescribed::Torque(coverage.maximum_torque);
        let rows = nodes[0].par_iter().map(|&c| {
            let problem =
                (solver.tooth_pair(flank, 0.0, c)).map_err(failed(flank, [c, 0.0, 0.0]))?;
            nodes[1]
                .iter()
                .map(|&m| {
                    let low = problem.no_load_approach(m);
                    let top = problem.solve_beyond(torque, m, None);
                    let span = top.map_err(failed(flank, [c, m, 0.0]))?.approach - low + spread;
                    let ceiling = low + CEILING * span;
                    Ok(Approaches { ceiling, span })
                })
                .collect::<Result<Vec<_>, _>>()
        });
        let approaches = rows.collect::<Result<Vec<_>, TableError>>()?.concat();
        let mut pair = ToothPair {
            solver,
            nodes,
            approaches,
            places: [0.0; 2],
        };
        pair.places = pair.outermost(flank).map_err(failed(flank, [0.0; 3]))?;
        Ok(pair)
    }

    /// At a node of the table.
    fn approaches_at(&self, c: f64, m: f64) -> Approaches {
        let [row, column] = [(&self.nodes[0], c), (&self.nodes[1], m)].map(|(nodes, x)| {
            let index = nodes.iter().position(|&node| node == x);
            index.expect("a table is solved at its nodes")
        });
        self.approaches[row * self.nodes[1].len() + column]
    }

    fn outermost(&self, flank: Flank) -> Result<[f64; 2], ContactError> {
        let [offsets, misalignments] = (self.nodes.each_ref())
            .map(|nodes| [nodes[0], nodes[nodes.len() / 2], nodes[nodes.len() - 1]]);
        let mut ends = [0.0f64; 2];
        for c in offsets {
            let passage = self.solver.passage(c)?;
            for m in misalignments {
                let ceiling = self.approaches_at(c, m).ceiling;
                for ((end, sign), limit) in ends.iter_mut().zip([-1.0, 1.0]).zip(passage) {
                    while sign * (limit - *end) > 0.0
                        && self.solver.first_touch(flank, *end, c, m)? < ceiling
                    {
                        *end += sign * STEP;
                    }
                }
            }
        }
        Ok(ends)
    }
}

impl StaticSource for ToothPair {
    fn position(&self, flank: Flank, p: f64, c: f64) -> Result<Position<'_>, ContactError> {
        let [first, last] = self.places;
        let place = first + p * (last - first);
        let [first, last] = self.solver.passage(c)?;
        let within = place.clamp(first + STEP, last - STEP);
        Ok(Box::new(ToothPairPosition {
            pair: self,
            problem: self.solver.tooth_pair(flank, within, c)?,
            is_beyond: within != place,
            center_distance_offset: c,
            warm: None,
        }))
    }

    fn is_mirrored_at_mid_face(&self) -> bool {
        self.solver.is_mirrored_at_mid_face()
    }

    fn friction(&self) -> Option<FrictionLaw> {
        Some(self.solver.friction())
    }
}

struct ToothPairPosition<'a> {
    pair: &'a ToothPair,
    problem: PositionProblem,
    /// It lies beyond the extended path of contact, and is taken at its end.
    is_beyond: bool,
    center_distance_offset: f64,
    warm: Option<ContactResult>,
}

impl ToothPairPosition<'_> {
    fn approaches_at(&self, misalignment: f64) -> Approaches {
        self.pair
            .approaches_at(self.center_distance_offset, misalignment)
    }
}

impl StaticPosition for ToothPairPosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        let ceiling = self.approaches_at(misalignment).ceiling;
        match self.is_beyond {
            true => ceiling,
            false => self.problem.no_load_approach(misalignment).min(ceiling),
        }
    }

    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, ContactError> {
        // Where the first touch is at its ceiling, the approach counts from there.
        let beyond =
            self.problem.no_load_approach(misalignment) - self.no_load_approach(misalignment);
        let shifted = match prescribed {
            Prescribed::Approach(approach) => Prescribed::Approach(approach + beyond),
            torque => torque,
        };
        let warm = self.warm.as_ref();
        let result = self.problem.solve_beyond(shifted, misalignment, warm)?;
        let result = self.warm.insert(result);
        let solver = &self.pair.solver;
        let mut sample = Sample {
            sliding: solver.sliding(&self.problem, result, &solver.friction()),
            ..Sample::from(&Resultant::from(&*result))
        };
        if let Prescribed::Approach(approach) = prescribed {
            sample.approach = approach;
        }
        Ok(sample)
    }

    fn top(&mut self, _torque: f64, misalignment: f64) -> Result<Sample, ContactError> {
        let top = self.no_load_approach(misalignment) + self.approaches_at(misalignment).span;
        self.solve(Prescribed::Approach(top), misalignment)
    }
}
