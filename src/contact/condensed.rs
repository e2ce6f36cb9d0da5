//! The elastic model of a pair condensed to what a solve at run time needs: influence matrices over the mesh cycle.
//!
//! The influence of strips on each other and the reference lengths of their local contact are smooth functions of
//! mesh position and centre distance, whatever the load, and cost most of a solve. Here they stand at nodes, divided
//! between bulk and local contact as in every solve; between the nodes they are interpolated with continuous
//! slopes. All else (where strips lie, gaps, curvatures, edges, arms) follows from the pose itself.
//!
//! Strips are known by tooth pair and station. Those a little beyond the reach of contact stand in the nodes, too, so
//! that whatever can carry load is there at all four neighbours of a position. Mesh position 1 is 0 with tooth pairs
//! counted on by one.

use serde::{Deserialize, Serialize};

use super::influence::Influence;
#[cfg(feature = "preprocess")]
use super::{error::ContactError, solver::ContactSolver};
#[cfg(feature = "preprocess")]
use crate::gear::Flank;
use crate::table::widest;

/// Influence of the strips of one flank at nodes.
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
    /// reference lengths of gear 1 and gear 2, m. Zero for strips that are not there.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// A strip: tooth pair and station.
pub type StripName = (i32, usize);

/// Mesh positions of the nodes over a cycle.
#[cfg(feature = "preprocess")]
const POSITIONS: usize = 48;

#[cfg(feature = "preprocess")]
impl CondensedFlank {
    /// Of `flank` with the elastic models of `solver`, at the centre distance offsets `offsets` (m).
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn new(
        solver: &ContactSolver,
        flank: Flank,
        offsets: &[f64],
    ) -> Result<CondensedFlank, ContactError> {
        use rayon::prelude::*;
        let nodes = (0..offsets.len() * POSITIONS)
            .into_par_iter()
            .map(|i| {
                let tau = (i % POSITIONS) as f64 / POSITIONS as f64;
                // Two steps on either side of a position, and a little for rounding.
                let margin = 2.1 / POSITIONS as f64;
                solver.influence(flank, tau, offsets[i / POSITIONS], margin)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let pairs = || {
            nodes
                .iter()
                .flat_map(|(strips, _)| strips.iter().map(|s| s.0))
        };
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
        let size = condensed.node_size();
        condensed.values = vec![0.0; nodes.len() * size];
        for (node, (strips, influence)) in nodes.iter().enumerate() {
            let places: Vec<usize> = (strips.iter())
                .filter_map(|&name| condensed.place(name, 0))
                .collect();
            let strips = condensed.strips();
            let values = &mut condensed.values[node * size..(node + 1) * size];
            for (i, &row) in places.iter().enumerate() {
                for (j, &column) in places[..=i].iter().enumerate() {
                    values[triangle(row, column)] = influence.bulk[i * places.len() + j] as f32;
                }
                for gear in 0..2 {
                    let place = triangle(strips, 0) + gear * strips + row;
                    values[place] = influence.lengths[gear][i] as f32;
                }
            }
        }
        Ok(condensed)
    }
}

/// Place of row `i` and column `j` <= `i`.
fn triangle(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

impl CondensedFlank {
    fn strips(&self) -> usize {
        self.pairs * self.stations
    }

    /// Number of all values; `None` where the grid makes no sense.
    pub fn value_count(&self) -> Option<usize> {
        let ascends = self.offsets.windows(2).all(|w| w[0] < w[1]);
        // Pairs are those in reach of one mesh cycle.
        let near = self.first_pair.unsigned_abs() < 1000 && (1..1000).contains(&self.pairs);
        let makes_sense =
            matches!(self.offsets.len(), 1 | 3) && ascends && self.positions >= 4 && near;
        let strips = self.pairs.checked_mul(self.stations)?;
        let size = strips.checked_mul(strips.checked_add(5)?)? / 2;
        let nodes = self.offsets.len().checked_mul(self.positions)?;
        nodes.checked_mul(size).filter(|_| makes_sense)
    }

    /// Values of one node.
    fn node_size(&self) -> usize {
        triangle(self.strips(), 0) + 2 * self.strips()
    }

    /// Place of a strip, its tooth pair counted on by `turns`.
    fn place(&self, (pair, station): StripName, turns: i32) -> Option<usize> {
        let pair = usize::try_from(pair + turns - self.first_pair).ok()?;
        (pair < self.pairs).then_some(pair * self.stations + station)
    }

    /// Influence of `strips`, ascending, at the mesh position `tau` in [0, 1) and at `offset` (m); beyond the offsets
    /// of the nodes that of the outermost one. That of a tooth pair on itself is `scale` times as large.
    pub(super) fn influence(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        [tau, offset]: [f64; 2],
    ) -> Influence {
        let n = strips.len();
        let mut influence = Influence {
            bulk: vec![0.0; n * n],
            lengths: [vec![0.0; n], vec![0.0; n]],
        };
        let around = Neighbours::new(self, tau, offset);
        let rows = around.rows(strips);
        let runs = runs(strips);
        let zeros = vec![0.0; self.stations];
        for (i, row) in rows.iter().enumerate() {
            for at in around.at_offsets() {
                let weights = around.along.map(|w| w * at.across);
                for run in runs.iter().take_while(|run| run.first <= i) {
                    let count = run.count.min(i + 1 - run.first);
                    let lines = at.lines(row, &rows[run.first], count, &zeros);
                    add_lines(
                        &mut influence.bulk[i * n + run.first..][..count],
                        &weights,
                        lines,
                    );
                }
                for (gear, known) in influence.lengths.iter_mut().enumerate() {
                    known[i] += dot4(&weights, &around.lengths(at, row, gear));
                }
            }
        }
        for i in 0..n {
            let scale = scale(strips[i].0);
            let (above, row) = influence.bulk.split_at_mut(i * n);
            for (j, value) in row[..i].iter_mut().enumerate() {
                if scale != 1.0 && strips[j].0 == strips[i].0 {
                    *value *= scale;
                }
                above[j * n + i] = *value;
            }
            row[i] *= scale;
        }
        influence
    }

    /// Slopes of [`CondensedFlank::influence`] by mesh position and by centre distance (1/m) with the forces `y` on the strips.
    pub(super) fn slopes(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        y: &[f64],
        [tau, offset]: [f64; 2],
    ) -> Slopes {
        let mut slopes = Slopes {
            lengths: vec![[[0.0; 2]; 2]; strips.len()],
            ..Slopes::default()
        };
        let around = Neighbours::new(self, tau, offset);
        let rows = around.rows(strips);
        let runs = runs(strips);
        let zeros = vec![0.0; self.stations];
        for (i, row) in rows.iter().enumerate() {
            let scale = scale(strips[i].0);
            for at in around.at_offsets() {
                // By node: y' A y of this strip with those before it.
                let mut by_node = [0.0; 4];
                for run in runs.iter().take_while(|run| run.first <= i) {
                    // The diagonal counts once, what lies beside it twice.
                    let count = run.count.min(i - run.first);
                    let lines = at.lines(row, &rows[run.first], count, &zeros);
                    let sums = line_sums(&y[run.first..][..count], lines);
                    let own = if run.name.0 == strips[i].0 {
                        scale
                    } else {
                        1.0
                    };
                    for (all, sum) in by_node.iter_mut().zip(sums) {
                        *all += 2.0 * own * sum;
                    }
                }
                let diagonal = at.lines(row, row, 1, &zeros);
                for (all, line) in by_node.iter_mut().zip(diagonal) {
                    *all = y[i] * (*all + scale * y[i] * f64::from(line[0]));
                }
                slopes.bulk[0] += at.across * dot4(&around.along_slopes, &by_node);
                slopes.bulk[1] += at.slope * dot4(&around.along, &by_node);
                for gear in 0..2 {
                    let lengths = around.lengths(at, row, gear);
                    slopes.lengths[i][0][gear] += at.across * dot4(&around.along_slopes, &lengths);
                    slopes.lengths[i][1][gear] += at.slope * dot4(&around.along, &lengths);
                }
            }
        }
        slopes
    }

    /// Whether the nodes hold this centre distance.
    pub fn holds(&self, offset: f64) -> bool {
        match self.offsets[..] {
            [low, .., high] => (low..=high).contains(&offset),
            _ => true,
        }
    }

    /// Weights of the offsets, and their slopes: the parabola through three.
    fn offset_weights(&self, offset: f64) -> [[f64; 3]; 2] {
        let [a, b, c] = self.offsets[..] else {
            return [[1.0, 0.0, 0.0], [0.0; 3]];
        };
        let x = offset.clamp(a, c);
        let per = [
            ((a - b) * (a - c)).recip(),
            ((b - a) * (b - c)).recip(),
            ((c - a) * (c - b)).recip(),
        ];
        let weights = [
            (x - b) * (x - c) * per[0],
            (x - a) * (x - c) * per[1],
            (x - a) * (x - b) * per[2],
        ];
        let slopes = [
            (2.0 * x - b - c) * per[0],
            (2.0 * x - a - c) * per[1],
            (2.0 * x - a - b) * per[2],
        ];
        [weights, if x == offset { slopes } else { [0.0; 3] }]
    }
}

/// Slopes of influence by mesh position and by centre distance.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Slopes {
    /// y' A y, J per cycle and J/m.
    pub bulk: [f64; 2],
    /// Strip by strip, per gear: reference lengths, m per cycle and m/m.
    pub lengths: Vec<[[f64; 2]; 2]>,
}

/// Strips of one tooth pair that follow each other without a gap.
struct Run {
    /// The first one's name and place among the strips.
    name: StripName,
    first: usize,
    count: usize,
}

fn runs(strips: &[StripName]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::with_capacity(8);
    for (i, &(pair, station)) in strips.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if run.name.0 == pair && run.name.1 + run.count == station => run.count += 1,
            _ => runs.push(Run {
                name: (pair, station),
                first: i,
                count: 1,
            }),
        }
    }
    runs
}

/// Places of one strip in the four nodes along the cycle, as far as it is there.
type Row = [Option<usize>; 4];

/// The four nodes along the cycle at one offset.
struct AtOffset<'a> {
    /// Weight of this offset, and its slope, 1/m.
    across: f64,
    slope: f64,
    /// Values of the nodes.
    values: [&'a [f32]; 4],
}

impl AtOffset<'_> {
    /// Influence of the `count` strips from that at `first` on on the strip at `row`, none of which comes after it, in the four
    /// nodes; `zeros` where one is not there.
    #[inline(always)]
    fn lines<'b>(
        &'b self,
        row: &Row,
        first: &Row,
        count: usize,
        zeros: &'b [f32],
    ) -> [&'b [f32]; 4] {
        std::array::from_fn(|step| match (row[step], first[step]) {
            (Some(row), Some(first)) => &self.values[step][triangle(row, 0) + first..][..count],
            _ => &zeros[..count],
        })
    }
}

/// The nodes about one point.
struct Neighbours<'a> {
    flank: &'a CondensedFlank,
    along: [f64; 4],
    along_slopes: [f64; 4],
    /// Offset by offset.
    at: [AtOffset<'a>; 3],
    /// Whole cycles of each of the four.
    turns: [i32; 4],
    /// Where the reference lengths begin in a node.
    lengths: usize,
}

impl<'a> Neighbours<'a> {
    fn new(flank: &'a CondensedFlank, tau: f64, offset: f64) -> Neighbours<'a> {
        let positions = flank.positions as i64;
        let at = tau * flank.positions as f64;
        let first = at.floor();
        let nodes = [-1, 0, 1, 2].map(|step| first as i64 + step);
        let size = flank.node_size();
        let [along, slopes] = catmull_rom(at - first);
        let [across, across_slopes] = flank.offset_weights(offset);
        Neighbours {
            flank,
            along,
            along_slopes: slopes.map(|slope| slope * flank.positions as f64),
            at: std::array::from_fn(|k| AtOffset {
                across: across[k],
                slope: across_slopes[k],
                values: nodes.map(|node| {
                    let k = k.min(flank.offsets.len() - 1);
                    let place = k * flank.positions + node.rem_euclid(positions) as usize;
                    &flank.values[place * size..][..size]
                }),
            }),
            turns: nodes.map(|node| node.div_euclid(positions) as i32),
            lengths: triangle(flank.strips(), 0),
        }
    }

    fn rows(&self, strips: &[StripName]) -> Vec<Row> {
        let row = |strip: &StripName| self.turns.map(|turns| self.flank.place(*strip, turns));
        strips.iter().map(row).collect()
    }

    /// The offsets that count.
    fn at_offsets(&self) -> impl Iterator<Item = &AtOffset<'a>> {
        self.at
            .iter()
            .filter(|at| at.across != 0.0 || at.slope != 0.0)
    }

    /// Reference lengths of one gear in the four nodes at one offset.
    #[inline]
    fn lengths(&self, at: &AtOffset<'_>, row: &Row, gear: usize) -> [f64; 4] {
        let begin = self.lengths + gear * self.flank.strips();
        std::array::from_fn(|step| {
            row[step].map_or(0.0, |place| f64::from(at.values[step][begin + place]))
        })
    }
}

/// Adds the sum of `lines` times `weights` to `entries`.
fn add_lines(entries: &mut [f64], weights: &[f64; 4], lines: [&[f32]; 4]) {
    widest(
        #[inline(always)]
        || {
            let [a, b, c, d] = lines;
            let lines = a.iter().zip(b).zip(c.iter().zip(d));
            for (entry, ((a, b), (c, d))) in entries.iter_mut().zip(lines) {
                *entry += (weights[0] * f64::from(*a) + weights[1] * f64::from(*b))
                    + (weights[2] * f64::from(*c) + weights[3] * f64::from(*d));
            }
        },
    );
}

/// Dot products of `y` with each of `lines`.
fn line_sums(y: &[f64], lines: [&[f32]; 4]) -> [f64; 4] {
    widest(
        #[inline(always)]
        || {
            let (y, y_rest) = y.as_chunks::<4>();
            let mut all = [0.0; 4];
            for (all, line) in all.iter_mut().zip(lines) {
                let mut sums = [0.0; 4];
                let (line, line_rest) = line.as_chunks::<4>();
                for (y, line) in y.iter().zip(line) {
                    for lane in 0..4 {
                        sums[lane] += y[lane] * f64::from(line[lane]);
                    }
                }
                let mut rest = 0.0;
                for (y, value) in y_rest.iter().zip(line_rest) {
                    rest += y * f64::from(*value);
                }
                *all = (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest;
            }
            all
        },
    )
}

fn dot4(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// Weights of four neighbours at the fraction `t` between the middle two, and their slopes: cubic convolution, continuous slope,
/// parabolas exact (Keys, IEEE Trans. Acoustics, Speech, Signal Processing 29 (1981) 1153-1160).
fn catmull_rom(t: f64) -> [[f64; 4]; 2] {
    let (t2, t3) = (t * t, t * t * t);
    [
        [
            0.5 * (-t3 + 2.0 * t2 - t),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (-3.0 * t3 + 4.0 * t2 + t),
            0.5 * (t3 - t2),
        ],
        [
            0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
            0.5 * (9.0 * t2 - 10.0 * t),
            0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
            0.5 * (3.0 * t2 - 2.0 * t),
        ],
    ]
}
