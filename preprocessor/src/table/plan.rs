//! Which nodes a table needs for a stated error.
//!
//! The error of a tensor-product interpolant is nearly the sum of those along each axis. So nodes are put
//! along each axis by itself, the cheapest combination is swept and measured at random points of all
//! coordinates, and the next combination follows from what was found.
//!
//! Along an axis, the solver gives fine lines through random points of the other coordinates. Each position costs as much as
//! hundreds of solves, so lines over positions share them, each at a misalignment of its own. From few nodes on, a node is put
//! into the middle of the interval where the splines through the nodes so far miss the fine solution most, again and again,
//! without another solve. That gives, for each axis, error over number of nodes. The error at a point is that of the force, or
//! that of the shuttling moment over [`MOMENT_TO_FORCE`] if that is larger.

use super::coverage::{
    Coverage, Nominal, SEED, TOGETHER, displacement_nodes, graded, graded_to, measure_at,
    mesh_positions, stratified, through,
};
use super::sweep::{Progress, StaticSource, sweep};
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::random::Random;
use gearmesh::table::{
    Axes, Axis, FlankGrid, FlankTable, Interpolation, InterpolationError, TableError,
    least_distance,
};
use rayon::prelude::*;
use std::ops::Range;

/// Largest error that a table may have, as a multiple of its rms error: 1.5 % where 0.2 % is the aim.
const LARGEST_TO_RMS: f64 = 7.5;

/// Error of the shuttling moment over that of the force that a table may have: the moment is a derivative of what
/// is interpolated, and it acts on bearings, not on the mesh.
const MOMENT_TO_FORCE: f64 = 2.0;

const ROUNDS: u64 = 4;

/// Lines over the centre distance or the mesh position that share positions, each with a misalignment of its own.
const SHARING: usize = 4;

/// Random points on which a grid is tried, and on which the chosen one's error is reported.
const TRIAL_POINTS: usize = 600;
const REPORTED_POINTS: usize = 1000;

/// A grid whose spline is within `error` (rms, of the nominal force) of the solver at random points, and within 7.5 times that at
/// all of them; the moment within twice as much, of nominal force times half the face. Both flanks share its axes, which are
/// chosen on the drive flank, those of the misalignment from nodes that lie half as far apart as the default ones `misalignments` (rad).
/// The error returned is measured on points that had no part in the choice.
///
/// If the finest grid on offer does not reach it, the result is the best there is and says its error.
///
/// # Errors
/// A solve that fails.
pub fn table_within(
    source: &dyn StaticSource,
    geometry: &PairGeometry,
    coverage: &Coverage,
    misalignments: &[f64],
    error: f64,
    progress: Progress,
) -> Result<(FlankGrid, InterpolationError), TableError> {
    let nominal = Nominal::new(geometry, coverage);
    let choices = |axis| match fine_nodes(axis, coverage, misalignments) {
        Some(nodes) => Lines::new(source, coverage, axis, nodes, nominal, progress)?.choices(),
        None => Ok(vec![Choice {
            nodes: vec![0.0],
            ..Choice::default()
        }]),
    };
    let choices = [
        choices(Axis::CenterDistance)?,
        choices(Axis::Misalignment)?,
        choices(Axis::Displacement)?,
        choices(Axis::MeshPosition)?,
    ];
    let measured = |grid: &FlankGrid, points: usize, seed: u64| {
        let table = FlankTable::new(grid, Interpolation::Spline)?;
        let held = coverage.draw(Random::new(seed), points, TOGETHER);
        measure_at(
            source,
            Flank::Drive,
            nominal,
            |q| Ok(table.evaluate(q, false).gradient),
            &held,
        )
    };
    let mut aim = 0.8 * error;
    let mut best: Option<(f64, FlankGrid)> = None;
    for round in 0..ROUNDS {
        let axes = cheapest(&choices, aim);
        if best.as_ref().is_some_and(|b| b.1.axes == axes) {
            break;
        }
        let grid = sweep(
            source,
            Flank::Drive,
            &axes,
            coverage.maximum_torque,
            progress,
        )?;
        // Other points in each round, so that no grid is fitted to them.
        let found = match measured(&grid, TRIAL_POINTS, 0x2545_F491_4F6C_DD1D + round) {
            // What each axis bears alone they may not bear together.
            Err(TableError::TooCoarse { .. }) => f64::INFINITY,
            found => over_bound(&found?, error),
        };
        if best.as_ref().is_none_or(|b| found < b.0) {
            best = Some((found, grid));
        }
        if found <= 0.95 {
            break;
        }
        aim *= (0.8 / found).clamp(0.25, 0.8);
    }
    let Some((_, grid)) = best else {
        return Err(TableError::Failed("no grid was tried".into()));
    };
    let found = measured(&grid, REPORTED_POINTS, SEED)?;
    Ok((grid, found))
}

/// `error` over what a table may have whose rms error may be `bound`.
fn over_bound(error: &InterpolationError, bound: f64) -> f64 {
    let rms = error.force_rms.max(error.moment_rms / MOMENT_TO_FORCE);
    let largest = (error.force_maximum).max(error.moment_maximum / MOMENT_TO_FORCE);
    // The largest of a few hundred errors is not the largest there is: leave it a third.
    (rms / bound).max(1.5 * largest / (LARGEST_TO_RMS * bound))
}

#[derive(Default)]
struct Choice {
    nodes: Vec<f64>,
    /// Mean square and largest error over nominal force.
    square: f64,
    largest: f64,
}

impl Choice {
    /// What `then` takes off the error per factor of grid size.
    fn gain(&self, then: &Choice) -> f64 {
        let cost = (then.nodes.len() as f64 / self.nodes.len() as f64).ln();
        (self.excess() - then.excess()) / cost
    }

    fn excess(&self) -> f64 {
        self.square + (self.largest / LARGEST_TO_RMS).powi(2)
    }
}

/// Nodes out of `choices` (per axis, ascending in number of nodes) whose errors along the axes add up (in the mean square) to
/// `error` of the nominal force at most, on the smallest grid; the finest one if none does.
fn cheapest(choices: &[Vec<Choice>; 4], error: f64) -> Axes {
    let mut taken = [0_usize; 4];
    loop {
        let now = choices.iter().zip(taken).map(|(choices, i)| &choices[i]);
        let square: f64 = now.clone().map(|c| c.square).sum();
        let largest = now.map(|c| c.largest).fold(0.0, f64::max);
        if square <= error * error && largest <= 0.6 * LARGEST_TO_RMS * error {
            break;
        }
        let step = (choices.iter().enumerate())
            .flat_map(|(axis, choices)| (taken[axis] + 1..choices.len()).map(move |to| (axis, to)))
            .map(|(axis, to)| {
                let choices = &choices[axis];
                (choices[taken[axis]].gain(&choices[to]), axis, to)
            })
            .filter(|step| step.0 > 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, axis, to)) = step else { break };
        taken[axis] = to;
    }
    Axes::from([0, 1, 2, 3].map(|axis| choices[axis][taken[axis]].nodes.clone()))
}

/// Fine nodes along `axis`, which all others are chosen from; `None`: no such axis.
fn fine_nodes(axis: Axis, coverage: &Coverage, misalignments: &[f64]) -> Option<Vec<f64>> {
    let mut nodes = match axis {
        Axis::Displacement => return Some(displacement_nodes(48, 1.8)),
        Axis::MeshPosition => return Some(mesh_positions(128)),
        Axis::CenterDistance => graded(coverage.center_distance_offset?, 25, 0.0),
        Axis::Misalignment => {
            let range = coverage.misalignment?;
            let apart = 0.5 * least_distance(misalignments);
            let even = graded(range, 65, 0.0);
            if least_distance(&even) <= apart {
                even
            } else {
                graded_to(range, 65, apart)
            }
        }
    };
    // The nominal value is a node, so that tables cut there are the solver's own values.
    let n = nodes.len();
    let nearest = (0..n).min_by(|&a, &b| nodes[a].abs().total_cmp(&nodes[b].abs()));
    if let Some(k) = nearest.filter(|&k| k > 0 && k + 1 < n) {
        nodes[k] = 0.0;
    }
    Some(match axis {
        Axis::Misalignment => coverage.with_outside(nodes),
        _ => nodes,
    })
}

/// Indices to begin with among the fine `nodes`, which cover the range of the table with those `inside`, and the most to be chosen.
fn first_choice(axis: Axis, nodes: &[f64], inside: Range<usize>) -> (Vec<usize>, usize) {
    let n = nodes.len();
    let (mut first, most): (Vec<usize>, usize) = match axis {
        Axis::CenterDistance => ((0..n).step_by(4).collect(), 17),
        // Those outside the range are always there.
        Axis::Misalignment => {
            let mut nodes: Vec<usize> = (0..n).filter(|i| !inside.contains(i)).collect();
            let most = 45 + nodes.len();
            nodes.extend(inside.step_by(4));
            (nodes, most)
        }
        Axis::Displacement => (vec![4, 11, 20, 32, n - 1], 30),
        Axis::MeshPosition => ((0..n).step_by(8).collect(), 96),
    };
    first.extend(nodes.iter().position(|&x| x == 0.0));
    first.sort_unstable();
    first.dedup();
    (first, most)
}

/// Error of nodes through which no table can be put: larger than any other.
const NO_TABLE: f64 = 1e3;

struct Lines {
    axis: Axis,
    nodes: Vec<f64>,
    /// Indices of those in the range of the table, where errors count.
    inside: Range<usize>,
    /// The samples of each line, and the splines through all of them; `None` where no table can be put through them.
    grids: Vec<(FlankGrid, Option<FlankTable>)>,
    nominal: Nominal,
}

impl Lines {
    fn new(
        source: &dyn StaticSource,
        coverage: &Coverage,
        axis: Axis,
        nodes: Vec<f64>,
        nominal: Nominal,
        progress: Progress,
    ) -> Result<Self, TableError> {
        let mut random = Random::new(0x6A09_E667_F3BC_C908 ^ axis as u64);
        let count = match axis {
            Axis::Displacement => 64,
            Axis::Misalignment => 24,
            Axis::CenterDistance | Axis::MeshPosition => 16,
        };
        // Where each node of a line is a position with an influence matrix of its own, lines share positions.
        let of_positions = matches!(axis, Axis::CenterDistance | Axis::MeshPosition);
        let sharing = coverage.misalignment.filter(|_| of_positions);
        let mut grids = Vec::with_capacity(count);
        while grids.len() < count {
            let [_, c, m, p] = coverage.draw_query(&mut random, 1.0).coordinates();
            let mut misalignments = vec![m];
            if let Some(range) = sharing {
                misalignments = stratified(&mut random, SHARING, range);
                misalignments.sort_by(f64::total_cmp);
            }
            let mut all = [vec![c], misalignments, displacement_nodes(8, 1.3), vec![p]];
            all[axis as usize].clone_from(&nodes);
            let axes = Axes::from(all);
            let grid = sweep(
                source,
                Flank::Drive,
                &axes,
                coverage.maximum_torque,
                &|_, _| (),
            )?;
            let lines = match sharing {
                Some(_) => (0..SHARING)
                    .map(|line| grid.with_nodes(Axis::Misalignment, &[line]))
                    .collect(),
                None => vec![grid],
            };
            for line in lines {
                let table = through(&line)?;
                grids.push((line, table));
            }
            progress(grids.len(), count);
        }
        let inside = match axis {
            Axis::Misalignment => coverage.inside_of(&nodes),
            _ => 0..nodes.len(),
        };
        Ok(Lines {
            axis,
            nodes,
            inside,
            grids,
            nominal,
        })
    }

    /// Errors at each fine node of a line, over the loads: how far the splines through the `chosen` nodes are off those through
    /// all of them, so that few displacements on the lines of another axis are not counted there.
    fn line_errors(
        &self,
        grid: &FlankGrid,
        fine: Option<&FlankTable>,
        chosen: &[usize],
    ) -> Result<Vec<Vec<f64>>, TableError> {
        let coarse = through(&grid.with_nodes(self.axis, chosen))?;
        let (Some(fine), Some(coarse)) = (fine, coarse) else {
            return Ok(vec![vec![NO_TABLE]; self.nodes.len()]);
        };
        let [_, nm, nu, np] = grid.axes.lengths();
        let mut errors = vec![Vec::new(); self.nodes.len()];
        for at in 0..grid.loa_force.len() {
            let index = [at / np / nu / nm, at / np / nu % nm, at / np % nu, at % np];
            let query = grid.query(index);
            let exact = fine.evaluate(&query, false).gradient;
            let found = coarse.evaluate(&query, false).gradient;
            let [force, moment, _] = self.nominal.errors(&found, exact[0], exact[2]);
            errors[index[self.axis as usize]].push(force.abs().max(moment.abs() / MOMENT_TO_FORCE));
        }
        Ok(errors)
    }

    /// Mean square of the error at each fine node in the range over lines and loads, and the largest error.
    fn errors(&self, chosen: &[usize]) -> Result<(Vec<f64>, f64), TableError> {
        let lines = self.grids.par_iter();
        let lines = lines.map(|(grid, fine)| self.line_errors(grid, fine.as_ref(), chosen));
        let mut square = vec![0.0; self.nodes.len()];
        let mut largest: f64 = 0.0;
        for errors in lines.collect::<Result<Vec<_>, TableError>>()? {
            for i in self.inside.clone() {
                let (sum, e) = (&mut square[i], &errors[i]);
                *sum += e.iter().map(|e| e * e).sum::<f64>() / (e.len() * self.grids.len()) as f64;
                largest = e.iter().copied().fold(largest, f64::max);
            }
        }
        Ok((square, largest))
    }

    fn choices(&self) -> Result<Vec<Choice>, TableError> {
        let (nodes, n) = (&self.nodes, self.nodes.len());
        let (mut chosen, most) = first_choice(self.axis, nodes, self.inside.clone());
        let is_symmetric = self.axis == Axis::Misalignment
            && (0..n).all(|i| (nodes[i] + nodes[n - 1 - i]).abs() <= 1e-12 * nodes[n - 1].abs());
        // Where the fine nodes lie close, each stands for less of the axis.
        let [first, last] = [self.inside.start, self.inside.end - 1];
        let range = nodes[last] - nodes[first];
        let shares = (0..n).map(|i| {
            let neighbours = [i + 1, i.saturating_sub(1)].map(|i| nodes[i.clamp(first, last)]);
            0.5 * (neighbours[0] - neighbours[1]) / range
        });
        let shares: Vec<f64> = shares.collect();
        let mut choices = Vec::new();
        loop {
            let (square, largest) = self.errors(&chosen)?;
            let parts: Vec<f64> = (0..n).map(|i| square[i] * shares[i]).collect();
            choices.push(Choice {
                nodes: chosen.iter().map(|&i| nodes[i]).collect(),
                square: parts.iter().sum(),
                largest,
            });
            let mut between: Vec<(usize, usize)> =
                chosen.windows(2).map(|w| (w[0], w[1])).collect();
            match self.axis {
                Axis::MeshPosition => between.push((chosen[chosen.len() - 1], n + chosen[0])),
                // Above the onset, which needs no node.
                Axis::Displacement if chosen[0] > 0 => between.push((0, chosen[0])),
                _ => {}
            }
            let worst = between
                .into_iter()
                .filter(|(a, b)| b - a > 1)
                .map(|(a, b)| {
                    let sum: f64 = (a + 1..b).map(|i| parts[i % n]).sum();
                    (sum, (a + b) / 2 % n)
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, node)) = worst.filter(|_| chosen.len() < most) else {
                return Ok(choices);
            };
            chosen.push(node);
            if is_symmetric {
                chosen.push(n - 1 - node);
            }
            chosen.sort_unstable();
            chosen.dedup();
        }
    }
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
