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

use super::influence::Influence;
use super::{error::ContactError, solver::ContactSolver};
use crate::gear::Flank;

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

/// A segment: tooth pair and station.
pub type StripName = (i32, usize);

/// Mesh positions of the nodes over a cycle.
const POSITIONS: usize = 48;

/// Weights of the four nodes along the cycle and of the three centre distances about a point.
struct Weights {
    along: [f64; 4],
    across: [f64; 3],
}

/// Segments of one tooth pair without a gap between them, as they lie in a node.
struct Run {
    /// Number of the first one among all segments, and their count.
    first: usize,
    count: usize,
    /// Place of the first one in the node.
    place: usize,
}

/// What one node is made of.
pub struct CondensedNode {
    names: Vec<StripName>,
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
    fn place(&self, (pair, station): StripName, turns: i32) -> Option<usize> {
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
        names: &[StripName],
        scale: impl Fn(i32) -> f64,
        [tau, offset]: [f64; 2],
    ) -> Influence {
        let ([along, _], [across, _]) = (self.along(tau), self.across(offset));
        self.combined(names, scale, tau, &Weights { along, across })
    }

    /// Slopes of [`CondensedFlank::influence`] by mesh position (1/cycle) and by centre distance (1/m).
    pub(super) fn slopes(
        &self,
        names: &[StripName],
        scale: impl Fn(i32) -> f64,
        [tau, offset]: [f64; 2],
    ) -> [Influence; 2] {
        let ([along, by_tau], [across, by_offset]) = (self.along(tau), self.across(offset));
        [(by_tau, across), (along, by_offset)]
            .map(|(along, across)| self.combined(names, &scale, tau, &Weights { along, across }))
    }

    /// Sum of the nodes about `tau`, each times its weight.
    fn combined(
        &self,
        names: &[StripName],
        scale: impl Fn(i32) -> f64,
        tau: f64,
        weights: &Weights,
    ) -> Influence {
        let (n, segments, size) = (names.len(), self.segments(), self.node_size());
        let mut bulk = DMatrix::zeros(n, n);
        let mut lengths = [vec![0.0; n], vec![0.0; n]];
        let first = (tau * self.positions as f64).floor() as i64 - 1;
        for (step, along) in weights.along.iter().enumerate() {
            let node = first + step as i64;
            let turns = node.div_euclid(self.positions as i64) as i32;
            let node = node.rem_euclid(self.positions as i64) as usize;
            let runs = self.runs(names, turns);
            for (k, across) in weights.across.iter().enumerate() {
                let weight = along * across;
                // Where there is one offset, the other two count nothing.
                if weight == 0.0 {
                    continue;
                }
                let values = &self.values[(k * self.positions + node) * size..][..size];
                let add = |sums: &mut [f64], values: &[f32]| {
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += weight * f64::from(*value);
                    }
                };
                for (number, rows) in runs.iter().enumerate() {
                    for i in 0..rows.count {
                        // Row by row of the lower triangle, which is column by column of the upper one.
                        let row = &values[triangle(rows.place + i)..];
                        let mut sums = bulk.column_mut(rows.first + i);
                        let sums = &mut sums.as_mut_slice()[..=rows.first + i];
                        for columns in &runs[..=number] {
                            let end = (columns.first + columns.count).min(sums.len());
                            add(&mut sums[columns.first..end], &row[columns.place..]);
                        }
                    }
                    for (gear, lengths) in lengths.iter_mut().enumerate() {
                        let known = &values[triangle(segments) + gear * segments + rows.place..];
                        add(&mut lengths[rows.first..][..rows.count], known);
                    }
                }
            }
        }
        for (i, (pair, _)) in names.iter().enumerate() {
            let scale = scale(*pair);
            if scale != 1.0 {
                for j in (0..=i).filter(|&j| names[j].0 == *pair) {
                    bulk[(j, i)] *= scale;
                }
            }
        }
        bulk.fill_lower_triangle_with_upper_triangle();
        Influence { bulk, lengths }
    }

    /// The segments `names` that a node holds, `turns` cycles on.
    fn runs(&self, names: &[StripName], turns: i32) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::with_capacity(8);
        for (first, &name) in names.iter().enumerate() {
            let Some(place) = self.place(name, turns) else {
                continue;
            };
            match runs.last_mut() {
                Some(run) if run.first + run.count == first && run.place + run.count == place => {
                    run.count += 1;
                }
                _ => runs.push(Run {
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
