//! Static contact of one tooth pair, all other teeth out of the way: where the samples of its table come from.
//!
//! At all places the table goes from the first touch over the same span of approaches: what the largest load takes at the pitch
//! point, and what errors of the teeth add. Beyond the places at which any approach within it makes the pair touch, the
//! first touch stays at a ceiling that none reaches.

use super::coverage::Coverage;
use super::sweep::{Sample, StaticPosition, StaticSource, solve_error};
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem, Prescribed};
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::Flank;
use gearmesh::table::{Axes, TableError};
use rayon::prelude::*;

/// Spans from the first touch at the pitch point to the ceiling of the first touch elsewhere.
const CEILING: f64 = 1.5;

/// Multiple of the reach of the pair's own contact up to which tip edges are followed.
const REACH: f64 = 8.0;

/// Steps in which the ends of the places are sought, base pitches; likewise how far within the reach of contact a pair stays.
const STEP: f64 = 1.0 / 64.0;

pub(super) struct ToothPair {
    solver: ContactSolver,
    flank: Flank,
    nodes: [Vec<f64>; 2],
    levels: Vec<Level>,
    /// Places beyond which the pair does not touch anywhere in the table.
    pub ends: [f64; 2],
}

/// Approaches at a centre distance and misalignment, m.
#[derive(Clone, Copy)]
struct Level {
    /// Of the first touch, at most.
    ceiling: f64,
    /// Of the table.
    span: f64,
}

pub(super) struct ToothPairOver<'a> {
    pub pair: &'a ToothPair,
    /// First and length.
    pub places: [f64; 2],
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
        let reach = REACH * (solver.setup().reach + spread);
        let solver = solver.clone().followed_to(reach);
        let nodes = [&axes.center_distance_offset, &axes.misalignment].map(Clone::clone);
        let failed = |c, m| move |error: ContactError| solve_error(flank, [c, m, 0.0], error);
        let torque = Prescribed::Torque(coverage.maximum_torque);
        let rows = nodes[0].par_iter().map(|&c| {
            let problem = (solver.tooth_pair(flank, 0.0, c)).map_err(failed(c, 0.0))?;
            let level = |&m: &f64| {
                let low = problem.no_load_approach(m);
                let top = problem
                    .solve_beyond(torque, m, None)
                    .map_err(failed(c, m))?;
                let span = top.approach - low + spread;
                let ceiling = low + CEILING * span;
                Ok(Level { ceiling, span })
            };
            nodes[1].iter().map(level).collect::<Result<Vec<_>, _>>()
        });
        let levels = rows.collect::<Result<Vec<_>, TableError>>()?.concat();
        let mut pair = ToothPair {
            solver,
            flank,
            nodes,
            levels,
            ends: [0.0; 2],
        };
        pair.ends = pair.outermost().map_err(failed(0.0, 0.0))?;
        Ok(pair)
    }

    fn level(&self, c: f64, m: f64) -> Result<Level, String> {
        let find = |axis: usize, x: f64| self.nodes[axis].iter().position(|&node| node == x);
        match (find(0, c), find(1, m)) {
            (Some(i), Some(j)) => Ok(self.levels[i * self.nodes[1].len() + j]),
            _ => Err("no node of this table".into()),
        }
    }

    fn outermost(&self) -> Result<[f64; 2], ContactError> {
        let outer = |nodes: &[f64]| [nodes[0], nodes[nodes.len() / 2], nodes[nodes.len() - 1]];
        let mut ends = [0.0f64; 2];
        for c in outer(&self.nodes[0]) {
            let passage = self.solver.passage(c)?;
            for m in outer(&self.nodes[1]) {
                let ceiling = self
                    .level(c, m)
                    .map_or(f64::INFINITY, |level| level.ceiling);
                for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
                    let place = &mut ends[end];
                    while sign * (passage[end] - *place) > 0.0
                        && self.solver.first_touch(self.flank, *place, c, m)? < ceiling
                    {
                        *place += sign * STEP;
                    }
                }
            }
        }
        Ok(ends)
    }
}

impl StaticSource for ToothPairOver<'_> {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String> {
        let place = self.places[0] + mesh_position * self.places[1];
        let (pair, c) = (self.pair, center_distance_offset);
        let [first, last] = pair.solver.passage(c).map_err(|e| e.to_string())?;
        let within = place.clamp(first + STEP, last - STEP);
        let problem = pair.solver.tooth_pair(flank, within, c);
        Ok(Box::new(ToothPairPosition {
            pair,
            problem: problem.map_err(|e| e.to_string())?,
            is_beyond: within != place,
            center_distance_offset: c,
            warm: None,
        }))
    }

    fn friction(&self) -> Option<FrictionLaw> {
        Some(self.pair.solver.friction())
    }
}

struct ToothPairPosition<'a> {
    pair: &'a ToothPair,
    problem: PositionProblem,
    /// It lies beyond the reach of contact, and is taken at its end.
    is_beyond: bool,
    center_distance_offset: f64,
    warm: Option<ContactResult>,
}

impl StaticPosition for ToothPairPosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        let level = self.pair.level(self.center_distance_offset, misalignment);
        let ceiling = level.map_or(f64::NAN, |level| level.ceiling);
        if self.is_beyond {
            ceiling
        } else {
            self.problem.no_load_approach(misalignment).min(ceiling)
        }
    }

    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, String> {
        // Where the first touch is at its ceiling, the approach counts from there.
        let beyond =
            self.problem.no_load_approach(misalignment) - self.no_load_approach(misalignment);
        let shifted = match prescribed {
            Prescribed::Approach(approach) => Prescribed::Approach(approach + beyond),
            torque => torque,
        };
        let result = self
            .problem
            .solve_beyond(shifted, misalignment, self.warm.as_ref());
        let result = self.warm.insert(result.map_err(|e| e.to_string())?);
        let solver = &self.pair.solver;
        let sample = Sample {
            sliding: solver.sliding(&self.problem, result, &solver.friction()),
            ..Sample::from(&*result)
        };
        Ok(match prescribed {
            Prescribed::Approach(approach) => Sample { approach, ..sample },
            Prescribed::Torque(_) => sample,
        })
    }

    fn top(&mut self, _torque: f64, misalignment: f64) -> Result<Sample, String> {
        let level = self.pair.level(self.center_distance_offset, misalignment)?;
        let low = self.no_load_approach(misalignment);
        self.solve(Prescribed::Approach(low + level.span), misalignment)
    }
}
