//! Static contact of one tooth pair, all other teeth out of the way: where the samples of its table come from.
//!
//! At all places the table goes from the first touch over the same span of approaches: what the largest load takes at the pitch
//! point, and what errors of the teeth add. Beyond the places at which any approach within it makes the pair touch, the
//! first touch stays at a level that none reaches.

use crate::table::plan::Coverage;
use crate::table::source::{Sample, StaticPosition, StaticSource};
use crate::table::sweep::point;
use gearmesh::contact::{ContactError, ContactResult, ContactSolver, PositionProblem, Prescribed};
use gearmesh::gear::Flank;
use gearmesh::table::{Axes, TableError};
use rayon::prelude::*;

/// Spans above the first touch at the pitch point at which the first touch elsewhere is held.
const HELD: f64 = 1.5;

/// Multiple of the reach of the pair's own contact up to which tip edges are followed.
const REACH: f64 = 8.0;

/// Steps in which the ends of the places are sought, base pitches; likewise how far within the reach of contact a pair is held.
const STEP: f64 = 1.0 / 64.0;

/// One tooth pair of a solver on one flank.
pub struct Alone {
    solver: ContactSolver,
    flank: Flank,
    /// Nodes of centre distance and misalignment.
    nodes: [Vec<f64>; 2],
    /// First touch at the pitch point and span, m, over them.
    levels: Vec<[f64; 2]>,
    ends: [f64; 2],
}

/// [`Alone`] over a range of places.
pub struct AloneOver<'a> {
    alone: &'a Alone,
    places: [f64; 2],
}

impl Alone {
    /// Of `flank` over the centre distances and misalignments of `axes`, where errors of the teeth are up to `spread` (m)
    /// apart.
    pub fn new(
        solver: &ContactSolver,
        flank: Flank,
        coverage: &Coverage,
        axes: &Axes,
        spread: f64,
    ) -> Result<Alone, TableError> {
        let reach = REACH * (solver.setup().reach + spread);
        let solver = solver.clone().followed_to(reach);
        let nodes = [
            axes.center_distance_offset.clone(),
            axes.misalignment.clone(),
        ];
        let failed = |c, m, error: ContactError| TableError::Solve {
            point: point(flank, c, m, 0.0),
            message: error.to_string(),
        };
        let torque = Prescribed::Torque(coverage.maximum_torque);
        let rows = nodes[0]
            .par_iter()
            .map(|&c| {
                let problem = (solver.tooth_pair(flank, 0.0, c)).map_err(|e| failed(c, 0.0, e))?;
                let level = |&m: &f64| {
                    let low = problem.no_load_approach(m);
                    let top = problem.solve_beyond(torque, m, None);
                    let top = top.map_err(|e| failed(c, m, e))?;
                    Ok([low, top.approach - low + spread])
                };
                nodes[1].iter().map(level).collect::<Result<Vec<_>, _>>()
            })
            .collect::<Result<Vec<_>, TableError>>()?;
        let mut alone = Alone {
            solver,
            flank,
            nodes,
            levels: rows.concat(),
            ends: [0.0; 2],
        };
        alone.ends = alone.outermost().map_err(|e| failed(0.0, 0.0, e))?;
        Ok(alone)
    }

    /// Places beyond which the pair does not touch anywhere in the table.
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }

    /// This pair over `places`: first and length.
    pub fn over(&self, places: [f64; 2]) -> AloneOver<'_> {
        AloneOver {
            alone: self,
            places,
        }
    }

    /// Approach of the first touch that is held, and the span, at a node.
    fn level(&self, c: f64, m: f64) -> Result<[f64; 2], String> {
        let find = |axis: usize, x: f64| self.nodes[axis].iter().position(|&node| node == x);
        let (Some(i), Some(j)) = (find(0, c), find(1, m)) else {
            return Err("no node of this table".into());
        };
        let [low, span] = self.levels[i * self.nodes[1].len() + j];
        Ok([low + HELD * span, span])
    }

    fn outermost(&self) -> Result<[f64; 2], ContactError> {
        let outer = |nodes: &[f64]| [nodes[0], nodes[nodes.len() / 2], nodes[nodes.len() - 1]];
        let mut ends = [0.0f64; 2];
        for c in outer(&self.nodes[0]) {
            let passage = self.solver.passage(c)?;
            for m in outer(&self.nodes[1]) {
                let held = self.level(c, m).map_or(f64::INFINITY, |[held, _]| held);
                for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
                    let mut place = ends[end];
                    while sign * (passage[end] - place) > 0.0
                        && self.solver.first_touch(self.flank, place, c, m)? < held
                    {
                        place += sign * STEP;
                    }
                    ends[end] = place;
                }
            }
        }
        Ok(ends)
    }
}

impl StaticSource for AloneOver<'_> {
    fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<Box<dyn StaticPosition + '_>, String> {
        let place = self.places[0] + mesh_position * self.places[1];
        let (alone, c) = (self.alone, center_distance_offset);
        let [first, last] = alone.solver.passage(c).map_err(|e| e.to_string())?;
        let held = place.clamp(first + STEP, last - STEP);
        let problem = (alone.solver.tooth_pair(flank, held, c)).map_err(|e| e.to_string())?;
        Ok(Box::new(AlonePosition {
            alone,
            problem,
            is_held: held != place,
            center_distance_offset: c,
            warm: None,
        }))
    }
}

/// One tooth pair at one place.
struct AlonePosition<'a> {
    alone: &'a Alone,
    problem: PositionProblem,
    /// It lies beyond the reach of contact, and is taken at its end.
    is_held: bool,
    center_distance_offset: f64,
    warm: Option<ContactResult>,
}

impl StaticPosition for AlonePosition<'_> {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        let held = self.alone.level(self.center_distance_offset, misalignment);
        let held = held.map_or(f64::NAN, |[held, _]| held);
        if self.is_held {
            held
        } else {
            self.problem.no_load_approach(misalignment).min(held)
        }
    }

    fn at_torque(&mut self, torque: f64, misalignment: f64) -> Result<Sample, String> {
        self.sample(Prescribed::Torque(torque), misalignment)
    }

    fn at_approach(&mut self, approach: f64, misalignment: f64) -> Result<Sample, String> {
        // Where the first touch is held, the approach counts from there.
        let beyond =
            self.problem.no_load_approach(misalignment) - self.no_load_approach(misalignment);
        let sample = self.sample(Prescribed::Approach(approach + beyond), misalignment)?;
        Ok(Sample { approach, ..sample })
    }

    fn top(&mut self, _torque: f64, misalignment: f64) -> Result<Sample, String> {
        let [_, span] = self
            .alone
            .level(self.center_distance_offset, misalignment)?;
        let low = self.no_load_approach(misalignment);
        self.at_approach(low + span, misalignment)
    }
}

impl AlonePosition<'_> {
    fn sample(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, String> {
        let result = self
            .problem
            .solve_beyond(prescribed, misalignment, self.warm.as_ref())
            .map_err(|e| e.to_string())?;
        let sample = Sample::from(&result);
        self.warm = Some(result);
        Ok(sample)
    }
}
