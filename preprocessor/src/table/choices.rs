//! Nodes along each axis, denser where the solution bends, and the cheapest combination of axes for an error.
//!
//! Through random points of the other coordinates the solver is asked on fine lines along one axis.
//! From few nodes on, a node is put into the middle of the interval where the splines through the nodes so far
//! miss the fine solution most, again and again, without another solve. That gives, for each axis, error over
//! number of nodes. The error at a point is that of the force, or that of the shuttling moment over
//! [`MOMENT_TO_FORCE`] if that is larger.

use super::measure::drawn;
use super::plan::{
    Coverage, LARGEST_TO_RMS, MOMENT_TO_FORCE, closest, displacement_nodes, graded_to,
    mesh_positions,
};
use super::source::StaticSource;
use super::sweep::{Watch, sweep};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh::table::{Axes, Axis, FlankGrid, FlankTable, Interpolation, TableError};
use rayon::prelude::*;

/// Fine lines along one axis.
struct Lines {
    axis: Axis,
    nodes: Vec<f64>,
    /// The samples of each line, and the splines through all of them; `None` where no table can be put through them.
    grids: Vec<(FlankGrid, Option<FlankTable>)>,
    nominal: Nominal,
}

/// What errors are related to.
#[derive(Debug, Clone, Copy)]
pub struct Nominal {
    /// Force on the line of action, N.
    pub force: f64,
    /// This force at an end of the face, N m.
    pub moment: f64,
}

/// Error of nodes through which no table can be put: larger than any other.
const NO_TABLE: f64 = 1e3;

/// One choice of nodes.
#[derive(Debug, Clone)]
struct Choice {
    nodes: Vec<f64>,
    /// Mean square and largest error over nominal force.
    square: f64,
    largest: f64,
}

/// Per axis the choices, ascending in number of nodes; axes in the order of [`Axes::lengths`].
pub struct Choices([Vec<Choice>; 4]);

impl Choices {
    /// Asks `source` along all axes of `coverage`, along the misalignment more closely where `tilt` (rad, see
    /// [`super::plan::tilt`]) is small; errors are relative to `nominal`.
    pub fn new(
        source: &dyn StaticSource,
        coverage: &Coverage,
        nominal: Nominal,
        tilt: f64,
        watch: &Watch,
    ) -> Result<Self, TableError> {
        let along = |axis| -> Result<Vec<Choice>, TableError> {
            match fine_nodes(axis, coverage, tilt) {
                None => Ok(vec![Choice {
                    nodes: vec![0.0],
                    square: 0.0,
                    largest: 0.0,
                }]),
                Some(nodes) => {
                    Lines::new(source, coverage, axis, nodes, nominal, watch)?.choices(axis)
                }
            }
        };
        Ok(Choices([
            along(Axis::CenterDistance)?,
            along(Axis::Misalignment)?,
            along(Axis::Displacement)?,
            along(Axis::MeshPosition)?,
        ]))
    }

    /// Nodes whose errors along the axes add up (in the mean square) to `error` of the nominal force
    /// at most, on the smallest grid; the finest one if none does.
    pub fn cheapest(&self, error: f64) -> Axes {
        let mut at = [0_usize; 4];
        loop {
            let square: f64 = (0..4).map(|a| self.0[a][at[a]].square).sum();
            let largest = (0..4).map(|a| self.0[a][at[a]].largest).fold(0.0, f64::max);
            if square <= error * error && largest <= 0.6 * LARGEST_TO_RMS * error {
                break;
            }
            // The step that takes most off the error per factor of grid size.
            let gain = |c: &Choice| c.square + (c.largest / LARGEST_TO_RMS).powi(2);
            let step = (0..4)
                .flat_map(|a| (at[a] + 1..self.0[a].len()).map(move |to| (a, to)))
                .map(|(a, to)| {
                    let (now, then) = (&self.0[a][at[a]], &self.0[a][to]);
                    let cost = (then.nodes.len() as f64 / now.nodes.len() as f64).ln();
                    ((gain(now) - gain(then)) / cost, a, to)
                })
                .filter(|step| step.0 > 0.0)
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, axis, to)) = step else { break };
            at[axis] = to;
        }
        let [c, m, u, p] = std::array::from_fn(|a| self.0[a][at[a]].nodes.clone());
        Axes {
            displacement_fraction: u,
            center_distance_offset: c,
            misalignment: m,
            mesh_position: p,
        }
    }
}

/// How far apart even fine misalignments may lie in units of the tilt, and how far graded ones do at parallel axes.
const FARTHEST_APART: f64 = 0.25;
const APART: f64 = 0.15;

/// Fine nodes along `axis`, which all others are chosen from; `None`: no such axis.
fn fine_nodes(axis: Axis, coverage: &Coverage, tilt: f64) -> Option<Vec<f64>> {
    let even = |[low, high]: [f64; 2], n: usize| -> Vec<f64> {
        let mut nodes: Vec<f64> = (0..n)
            .map(|i| low + (high - low) * i as f64 / (n - 1) as f64)
            .collect();
        nodes[n - 1] = high;
        nodes
    };
    match axis {
        Axis::CenterDistance => coverage
            .center_distance_offset
            .map(|r| nominal_at(even(r, 25))),
        Axis::Misalignment => coverage.misalignment.map(|range| {
            let nodes = even(range, 65);
            nominal_at(if closest(&nodes) <= FARTHEST_APART * tilt {
                nodes
            } else {
                graded_to(range, 65, APART * tilt)
            })
        }),
        Axis::Displacement => Some(displacement_nodes(48, 1.8)),
        Axis::MeshPosition => Some(mesh_positions(128)),
    }
}

/// The nominal value is a node, so that tables cut there are the solver's own values.
fn nominal_at(mut nodes: Vec<f64>) -> Vec<f64> {
    let n = nodes.len();
    let nearest = (0..n).min_by(|&a, &b| nodes[a].abs().total_cmp(&nodes[b].abs()));
    if let Some(k) = nearest.filter(|&k| k > 0 && k + 1 < n) {
        nodes[k] = 0.0;
    }
    nodes
}

/// Indices to begin with among `n` fine nodes, and the most to be chosen.
fn first_choice(axis: Axis, nodes: &[f64]) -> (Vec<usize>, usize) {
    let n = nodes.len();
    let (mut first, most): (Vec<usize>, usize) = match axis {
        Axis::CenterDistance => ((0..n).step_by(4).collect(), 17),
        Axis::Misalignment => ((0..n).step_by(4).collect(), 45),
        Axis::Displacement => (vec![4, 11, 20, 32, n - 1], 30),
        Axis::MeshPosition => ((0..n).step_by(8).collect(), 96),
    };
    if let Some(zero) = nodes.iter().position(|&x| x == 0.0)
        && !first.contains(&zero)
    {
        first.push(zero);
        first.sort_unstable();
    }
    (first, most)
}

/// The splines through `grid`; `None` where its nodes lie too far apart for a table.
fn through(grid: &FlankGrid) -> Result<Option<FlankTable>, TableError> {
    match FlankTable::new(grid, Interpolation::Spline) {
        Ok(table) => Ok(Some(table)),
        Err(TableError::TooCoarse { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

impl Lines {
    fn new(
        source: &dyn StaticSource,
        coverage: &Coverage,
        axis: Axis,
        nodes: Vec<f64>,
        nominal: Nominal,
        watch: &Watch,
    ) -> Result<Self, TableError> {
        let mut random = Random::new(0x6A09_E667_F3BC_C908 ^ axis as u64);
        let count = match axis {
            Axis::Displacement => 64,
            Axis::Misalignment => 24,
            Axis::CenterDistance | Axis::MeshPosition => 16,
        };
        let silent = |_, _| {};
        let grids = (0..count)
            .map(|k| {
                let mut axes = Axes {
                    displacement_fraction: displacement_nodes(8, 1.3),
                    center_distance_offset: vec![drawn(
                        &mut random,
                        coverage.center_distance_offset,
                    )],
                    misalignment: vec![drawn(&mut random, coverage.misalignment)],
                    mesh_position: vec![random.next()],
                };
                *axes.along_mut(axis) = nodes.clone();
                let quiet = Watch {
                    progress: &silent,
                    cancel: watch.cancel,
                };
                let grid = sweep(source, Flank::Drive, &axes, coverage.maximum_torque, &quiet);
                let solves = nodes.len() * if axis == Axis::Displacement { 1 } else { 9 };
                (watch.progress)((k + 1) * solves, count * solves);
                let grid = grid?;
                let table = through(&grid)?;
                Ok((grid, table))
            })
            .collect::<Result<_, TableError>>()?;
        Ok(Lines {
            axis,
            nodes,
            grids,
            nominal,
        })
    }

    /// Mean square of the error at each fine node (over lines and loads), and the largest error: how far the splines through the
    /// `chosen` nodes are off those through all of them, so that few displacements on the lines of another axis are not counted there.
    fn errors(&self, chosen: &[usize]) -> Result<(Vec<f64>, f64), TableError> {
        let per_line = self
            .grids
            .par_iter()
            .map(|(grid, fine)| {
                let [_, nm, nu, np] = grid.axes.lengths();
                let coarse = through(&grid.with_nodes(self.axis, chosen))?;
                let (Some(fine), Some(table)) = (fine, coarse) else {
                    return Ok(vec![vec![NO_TABLE]; self.nodes.len()]);
                };
                let mut errors = vec![Vec::new(); self.nodes.len()];
                for at in 0..grid.loa_force.len() {
                    let index = [at / np / nu / nm, at / np / nu % nm, at / np % nu, at % np];
                    let query = grid.query(index);
                    let found = table.evaluate(&query, false).gradient;
                    let exact = fine.evaluate(&query, false).gradient;
                    let force = (found[0] - exact[0]) / self.nominal.force;
                    let moment = (found[2] - exact[2]) / (self.nominal.moment * MOMENT_TO_FORCE);
                    errors[index[self.axis as usize]].push(force.abs().max(moment.abs()));
                }
                Ok(errors)
            })
            .collect::<Result<Vec<_>, TableError>>()?;
        let mut square = vec![0.0; self.nodes.len()];
        let mut largest: f64 = 0.0;
        for errors in &per_line {
            for (sum, e) in square.iter_mut().zip(errors) {
                *sum += e.iter().map(|e| e * e).sum::<f64>() / (e.len() * self.grids.len()) as f64;
                largest = e.iter().copied().fold(largest, f64::max);
            }
        }
        Ok((square, largest))
    }

    /// Choices with more and more nodes.
    fn choices(&self, axis: Axis) -> Result<Vec<Choice>, TableError> {
        let n = self.nodes.len();
        let (mut chosen, most) = first_choice(axis, &self.nodes);
        let symmetric = (0..n).all(|i| {
            axis == Axis::Misalignment
                && (self.nodes[i] + self.nodes[n - 1 - i]).abs() <= 1e-12 * self.nodes[n - 1].abs()
        });
        let mut choices = Vec::new();
        loop {
            let (square, largest) = self.errors(&chosen)?;
            // Where the fine nodes lie close, each stands for less of the axis.
            let share = self.shares();
            choices.push(Choice {
                nodes: chosen.iter().map(|&i| self.nodes[i]).collect(),
                square: square.iter().zip(&share).map(|(e, s)| e * s).sum(),
                largest,
            });
            let mut between: Vec<(usize, usize)> =
                chosen.windows(2).map(|w| (w[0], w[1])).collect();
            match axis {
                Axis::MeshPosition => between.push((chosen[chosen.len() - 1], n + chosen[0])),
                // Above the onset, which needs no node.
                Axis::Displacement if chosen[0] > 0 => between.push((0, chosen[0])),
                _ => {}
            }
            let worst = between
                .into_iter()
                .filter(|(a, b)| b - a > 1)
                .map(|(a, b)| {
                    let sum: f64 = (a + 1..b).map(|i| square[i % n] * share[i % n]).sum();
                    (sum, (a + b) / 2 % n)
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, node)) = worst.filter(|_| chosen.len() < most) else {
                return Ok(choices);
            };
            for node in [node, if symmetric { n - 1 - node } else { node }] {
                if !chosen.contains(&node) {
                    chosen.push(node);
                }
            }
            chosen.sort_unstable();
        }
    }

    /// Share of the axis that each fine node stands for.
    fn shares(&self) -> Vec<f64> {
        let n = self.nodes.len();
        let range = self.nodes[n - 1] - self.nodes[0];
        (0..n)
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
                0.5 * (self.nodes[b] - self.nodes[a]) / range
            })
            .collect()
    }
}
