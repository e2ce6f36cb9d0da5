//! The elastic model of a pair condensed to what a solve at run time needs: influence matrices over the mesh cycle.
//!
//! The influence of segments on each other and the reference lengths of their local contact are smooth functions of
//! mesh position and centre distance, whatever the load, and cost most of a solve. They are computed at nodes, divided
//! between bulk and local contact as in every solve, and interpolated between them with continuous slopes. All else
//! (where segments lie, gaps, curvatures, edges, arms) follows from the pose itself.
//!
//! Segments are named by tooth pair and station. Nodes also hold those a little beyond the reach of contact, so that
//! whatever can carry load is there at all four neighbours of a position. Mesh position 1 is 0 with tooth pairs
//! counted on by one.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::candidates::SegmentName;
use super::error::ContactError;
use super::influence::Influence;
use super::solver::ContactSolver;
use crate::gear::Flank;
use crate::vector::Lanes;

/// Influence of the segments of one flank at nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CondensedFlank {
    /// Equal steps of a mesh cycle.
    pub positions: usize,
    /// Centre distance offsets, m: one, or three ascending ones.
    pub offsets: Vec<f64>,
    /// Stations along the face.
    pub stations: usize,
    /// Lowest number of a tooth pair.
    pub first_pair: i32,
    /// Number of tooth pairs.
    pub pairs: usize,
    /// Shares of gear 1 and gear 2 in the bulk displacement of a tooth pair under its own load.
    pub shares: [f64; 2],
    /// Node by node, offsets outside: influence matrix over (tooth pair, station), lower triangle row by row, m/N, then the
    /// reference lengths of gear 1 and gear 2, m. Zero for segments that are not there.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// Mesh positions of the nodes over a cycle.
const POSITIONS: usize = 48;

/// Segments of one tooth pair without a gap between them, as they lie in a node.
struct Run {
    tooth_pair: i32,
    /// Number of the first one among all segments, and their count.
    first: usize,
    count: usize,
    /// Place of the first one in the node.
    place: usize,
}

/// How the influence of some segments changes.
pub(super) struct InfluenceSlope {
    /// y' A y / 2, J.
    pub work: f64,
    /// Reference lengths of gear 1 and gear 2, m.
    pub lengths: [Vec<f64>; 2],
}

/// What one node is made of.
pub struct CondensedNode {
    names: Vec<SegmentName>,
    influence: Influence,
}

impl CondensedFlank {
    /// Number of nodes with the centre distance offsets `offsets`.
    pub fn node_count(offsets: &[f64]) -> usize {
        offsets.len() * POSITIONS
    }

    /// Node `i` of `flank` with the elastic models of `solver`, at the centre distance offsets `offsets` (m). Nodes do not
    /// depend on each other.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn node(
        solver: &ContactSolver,
        flank: Flank,
        offsets: &[f64],
        i: usize,
    ) -> Result<CondensedNode, ContactError> {
        let tau = (i % POSITIONS) as f64 / POSITIONS as f64;
        // Two steps on either side of a position, and a little for rounding.
        let margin = 2.1 / POSITIONS as f64;
        let (names, influence) = solver.influence(flank, tau, offsets[i / POSITIONS], margin)?;
        Ok(CondensedNode { names, influence })
    }

    /// Of all `nodes` in order, as [`CondensedFlank::node`] gives them for the same solver, flank and offsets.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn from_nodes(
        solver: &ContactSolver,
        flank: Flank,
        offsets: &[f64],
        nodes: &[CondensedNode],
    ) -> Result<CondensedFlank, ContactError> {
        let pairs = || nodes.iter().flat_map(|node| node.names.iter().map(|s| s.0));
        let first_pair = pairs().min().unwrap_or(0);
        let mut condensed = CondensedFlank {
            positions: POSITIONS,
            offsets: offsets.to_vec(),
            stations: solver.settings().stations,
            first_pair,
            shares: solver.tooth_shares(flank)?,
            pairs: pairs()
                .max()
                .map_or(0, |last| (last - first_pair + 1) as usize),
            values: vec![],
        };
        let (size, segments) = (condensed.node_size(), condensed.segments());
        let mut values = vec![0.0; nodes.len() * size];
        for (node, values) in nodes.iter().zip(values.chunks_exact_mut(size)) {
            let CondensedNode { names, influence } = node;
            let places: Vec<usize> = (names.iter())
                .filter_map(|&name| condensed.place(name, 0))
                .collect();
            for (i, &row) in places.iter().enumerate() {
                for (j, &column) in places[..=i].iter().enumerate() {
                    values[triangle(row) + column] = influence.bulk[(i, j)] as f32;
                }
                for (gear, lengths) in influence.lengths.iter().enumerate() {
                    values[triangle(segments) + gear * segments + row] = lengths[i] as f32;
                }
            }
        }
        condensed.values = values;
        Ok(condensed)
    }
}

/// Where row `i` of a lower triangle begins.
fn triangle(i: usize) -> usize {
    i * (i + 1) / 2
}

/// Adds `values`, times `weight`, to `sums`.
#[inline(always)]
fn add(sums: &mut [f64], values: &[f32], weight: f64) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * f64::from(*value);
    }
}

/// Sum of the first `count` values of `columns` in `row` times the forces there, four at a time.
fn dot(row: &[f32], columns: &Run, count: usize, forces: &[f64]) -> f64 {
    let values = row[columns.place..][..count].chunks_exact(4);
    let forces = forces[columns.first..][..count].chunks_exact(4);
    let rest = values.remainder().iter().zip(forces.remainder());
    let mut sum: f64 = rest.map(|(value, force)| f64::from(*value) * force).sum();
    let mut sums = [0.0; 4];
    for (values, forces) in values.zip(forces) {
        for i in 0..4 {
            sums[i] += f64::from(values[i]) * forces[i];
        }
    }
    sum += sums.iter().sum::<f64>();
    sum
}

impl CondensedFlank {
    fn segments(&self) -> usize {
        self.pairs * self.stations
    }

    /// Number of all values; `None` where the grid makes no sense.
    pub fn value_count(&self) -> Option<usize> {
        let ascends = self.offsets.windows(2).all(|w| w[0] < w[1]);
        // Pairs are those in reach of one mesh cycle.
        let near = self.first_pair.unsigned_abs() < 1000 && (1..1000).contains(&self.pairs);
        let makes_sense =
            matches!(self.offsets.len(), 1 | 3) && ascends && self.positions >= 4 && near;
        let segments = self.pairs.checked_mul(self.stations)?;
        let size = segments.checked_mul(segments.checked_add(5)?)? / 2;
        let nodes = self.offsets.len().checked_mul(self.positions)?;
        nodes.checked_mul(size).filter(|_| makes_sense)
    }

    /// Values of one node.
    fn node_size(&self) -> usize {
        triangle(self.segments()) + 2 * self.segments()
    }

    /// Place of a segment, its tooth pair counted on by `turns`.
    fn place(&self, (pair, station): SegmentName, turns: i32) -> Option<usize> {
        let pair = usize::try_from(pair + turns - self.first_pair).ok()?;
        (pair < self.pairs).then_some(pair * self.stations + station)
    }

    /// Whether the nodes hold this centre distance.
    pub fn holds(&self, offset: f64) -> bool {
        match self.offsets[..] {
            [low, .., high] => (low..=high).contains(&offset),
            _ => true,
        }
    }

    /// Influence of the segments `names`, ascending, at the mesh position `tau` in [0, 1) and at `offset` (m); beyond the
    /// offsets of the nodes that of the outermost one. That of a tooth pair on itself is `scale` times as large.
    pub(super) fn influence(
        &self,
        names: &[SegmentName],
        scale: impl Fn(i32) -> f64,
        tau: f64,
        offset: f64,
    ) -> Influence {
        Lanes::widest().run(|_| self.interpolated(names, scale, tau, offset))
    }

    #[inline(always)]
    fn interpolated(
        &self,
        names: &[SegmentName],
        scale: impl Fn(i32) -> f64,
        tau: f64,
        offset: f64,
    ) -> Influence {
        let n = names.len();
        let ([along, _], [across, _]) = (self.along(tau), self.across(offset));
        let mut bulk = DMatrix::zeros(n, n);
        let mut lengths = [vec![0.0; n], vec![0.0; n]];
        for ((node, runs), along) in self.around(names, tau).into_iter().zip(along) {
            for (k, across) in across.into_iter().enumerate() {
                let weight = along * across;
                // Where there is one offset, the other two count nothing.
                if weight == 0.0 {
                    continue;
                }
                for (number, rows) in runs.iter().enumerate() {
                    for i in 0..rows.count {
                        // Row by row of the lower triangle, which is column by column of the upper one.
                        let row = self.row(k, node, rows.place + i);
                        let mut sums = bulk.column_mut(rows.first + i);
                        let sums = &mut sums.as_mut_slice()[..=rows.first + i];
                        for columns in &runs[..=number] {
                            let end = (columns.first + columns.count).min(sums.len());
                            let weight = match columns.tooth_pair == rows.tooth_pair {
                                true => weight * scale(rows.tooth_pair),
                                false => weight,
                            };
                            add(&mut sums[columns.first..end], &row[columns.place..], weight);
                        }
                    }
                }
                self.add_lengths(k, node, &runs, weight, &mut lengths);
            }
        }
        bulk.fill_lower_triangle_with_upper_triangle();
        Influence { bulk, lengths }
    }

    /// Slopes by mesh position (1/cycle) and by centre distance (1/m) of what [`CondensedFlank::influence`] says of the segments
    /// `names`: of the work of the `forces` on them by the bulk matrix, J, and of the reference lengths, m.
    pub(super) fn slopes(
        &self,
        names: &[SegmentName],
        forces: &[f64],
        scale: impl Fn(i32) -> f64,
        tau: f64,
        offset: f64,
    ) -> [InfluenceSlope; 2] {
        let n = names.len();
        let ([along, by_tau], [across, by_offset]) = (self.along(tau), self.across(offset));
        let mut slopes = [(); 2].map(|()| InfluenceSlope {
            work: 0.0,
            lengths: [vec![0.0; n], vec![0.0; n]],
        });
        for (step, (node, runs)) in self.around(names, tau).into_iter().enumerate() {
            for k in 0..self.offsets.len() {
                let weights = [by_tau[step] * across[k], along[step] * by_offset[k]];
                if weights == [0.0; 2] {
                    continue;
                }
                let work = self.work(k, node, &runs, forces, &scale);
                for (slope, weight) in slopes.iter_mut().zip(weights) {
                    slope.work += weight * work;
                    self.add_lengths(k, node, &runs, weight, &mut slope.lengths);
                }
            }
        }
        slopes
    }

    /// Row of the lower triangle of node `node` at the offset number `k`.
    fn row(&self, k: usize, node: usize, place: usize) -> &[f32] {
        &self.node_values(k, node)[triangle(place)..]
    }

    /// y' A y / 2 of one node, y the `forces` on the segments `runs`.
    fn work(
        &self,
        k: usize,
        node: usize,
        runs: &[Run],
        forces: &[f64],
        scale: impl Fn(i32) -> f64,
    ) -> f64 {
        let mut work = 0.0;
        for (number, rows) in runs.iter().enumerate() {
            for i in 0..rows.count {
                let row = self.row(k, node, rows.place + i);
                let force = forces[rows.first + i];
                let (mut own, mut others) = (0.5 * f64::from(row[rows.place + i]) * force, 0.0);
                own += dot(row, rows, i, forces);
                for columns in &runs[..number] {
                    let displaced = dot(row, columns, columns.count, forces);
                    match columns.tooth_pair == rows.tooth_pair {
                        true => own += displaced,
                        false => others += displaced,
                    }
                }
                work += force * (scale(rows.tooth_pair) * own + others);
            }
        }
        work
    }

    /// Adds the reference lengths of one node, times `weight`, to `lengths`.
    fn add_lengths(
        &self,
        k: usize,
        node: usize,
        runs: &[Run],
        weight: f64,
        lengths: &mut [Vec<f64>; 2],
    ) {
        let segments = self.segments();
        for (gear, lengths) in lengths.iter_mut().enumerate() {
            let known = &self.node_values(k, node)[triangle(segments) + gear * segments..];
            for run in runs {
                add(
                    &mut lengths[run.first..][..run.count],
                    &known[run.place..],
                    weight,
                );
            }
        }
    }

    fn node_values(&self, k: usize, node: usize) -> &[f32] {
        let size = self.node_size();
        &self.values[(k * self.positions + node) * size..][..size]
    }

    /// The four nodes about `tau`, and where they hold the segments `names`.
    fn around(&self, names: &[SegmentName], tau: f64) -> [(usize, Vec<Run>); 4] {
        let first = (tau * self.positions as f64).floor() as i64 - 1;
        [0, 1, 2, 3].map(|step| {
            let (node, positions) = (first + step, self.positions as i64);
            let runs = self.runs(names, node.div_euclid(positions) as i32);
            (node.rem_euclid(positions) as usize, runs)
        })
    }

    /// The segments `names` that a node holds, `turns` cycles on.
    fn runs(&self, names: &[SegmentName], turns: i32) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::with_capacity(8);
        for (first, &name) in names.iter().enumerate() {
            let Some(place) = self.place(name, turns) else {
                continue;
            };
            match runs.last_mut() {
                Some(run)
                    if run.tooth_pair == name.0
                        && run.first + run.count == first
                        && run.place + run.count == place =>
                {
                    run.count += 1;
                }
                _ => runs.push(Run {
                    tooth_pair: name.0,
                    first,
                    count: 1,
                    place,
                }),
            }
        }
        runs
    }

    /// Weights of the four nodes about `tau`, and their slopes, 1/cycle: cubic convolution, continuous slope, parabolas exact
    /// (Keys, IEEE Trans. Acoustics, Speech, Signal Processing 29 (1981) 1153-1160).
    fn along(&self, tau: f64) -> [[f64; 4]; 2] {
        let positions = self.positions as f64;
        let t = tau * positions - (tau * positions).floor();
        let (t2, t3) = (t * t, t * t * t);
        let weights = [
            0.5 * (-t3 + 2.0 * t2 - t),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (-3.0 * t3 + 4.0 * t2 + t),
            0.5 * (t3 - t2),
        ];
        let slopes = [
            0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
            0.5 * (9.0 * t2 - 10.0 * t),
            0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
            0.5 * (3.0 * t2 - 2.0 * t),
        ];
        [weights, slopes.map(|slope| slope * positions)]
    }

    /// Weights of the centre distances at `offset` (m), and their slopes, 1/m: the parabola through three.
    fn across(&self, offset: f64) -> [[f64; 3]; 2] {
        let [a, b, c] = self.offsets[..] else {
            return [[1.0, 0.0, 0.0], [0.0; 3]];
        };
        let x = offset.clamp(a, c);
        let [to_a, to_b, to_c] = [x - a, x - b, x - c];
        let per = [(a - b) * (a - c), (b - a) * (b - c), (c - a) * (c - b)].map(f64::recip);
        let weights = [
            to_b * to_c * per[0],
            to_a * to_c * per[1],
            to_a * to_b * per[2],
        ];
        let slopes = [
            (to_b + to_c) * per[0],
            (to_a + to_c) * per[1],
            (to_a + to_b) * per[2],
        ];
        [weights, if x == offset { slopes } else { [0.0; 3] }]
    }
}
