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
        let makes_sense = matches!(self.offsets.len(), 1 | 3) && ascends && self.positions >= 4;
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
        let runs = runs(strips);
        let zeros = vec![0.0; self.stations];
        for (i, &strip) in strips.iter().enumerate() {
            for (k, across) in around.across.iter().enumerate() {
                let weights = around.along.map(|w| w * across);
                for run in runs.iter().take_while(|run| run.first <= i) {
                    let count = run.count.min(i + 1 - run.first);
                    let lines = around.lines(k, strip, (run.name, count), &zeros);
                    let [a, b, c, d] = lines;
                    let entries = &mut influence.bulk[i * n + run.first..][..count];
                    for (j, entry) in entries.iter_mut().enumerate() {
                        *entry += (weights[0] * f64::from(a[j]) + weights[1] * f64::from(b[j]))
                            + (weights[2] * f64::from(c[j]) + weights[3] * f64::from(d[j]));
                    }
                }
                for (gear, known) in influence.lengths.iter_mut().enumerate() {
                    known[i] += dot4(&weights, &around.lengths(k, strip, gear));
                }
            }
        }
        for i in 0..n {
            let scale = scale(strips[i].0);
            for j in 0..=i {
                if scale != 1.0 && strips[j].0 == strips[i].0 {
                    influence.bulk[i * n + j] *= scale;
                }
                influence.bulk[j * n + i] = influence.bulk[i * n + j];
            }
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
        let runs = runs(strips);
        let zeros = vec![0.0; self.stations];
        for (i, &strip) in strips.iter().enumerate() {
            let scale = scale(strip.0);
            for (k, across) in around.across.iter().enumerate() {
                let (mut by_tau, mut by_offset) = (0.0, 0.0);
                for run in runs.iter().take_while(|run| run.first <= i) {
                    // The diagonal counts once, what lies beside it twice.
                    let count = run.count.min(i - run.first);
                    let [a, b, c, d] = around.lines(k, strip, (run.name, count), &zeros);
                    let forces = &y[run.first..][..count];
                    let mut sums = [0.0; 4];
                    for (j, force) in forces.iter().enumerate() {
                        sums[0] += force * f64::from(a[j]);
                        sums[1] += force * f64::from(b[j]);
                        sums[2] += force * f64::from(c[j]);
                        sums[3] += force * f64::from(d[j]);
                    }
                    let twice = if run.name.0 == strip.0 {
                        2.0 * scale
                    } else {
                        2.0
                    };
                    by_tau += twice * dot4(&around.along_slopes, &sums);
                    by_offset += twice * dot4(&around.along, &sums);
                }
                let own = around.lines(k, strip, (strip, 1), &zeros).map(|l| l[0]);
                let own = own.map(|value| scale * y[i] * f64::from(value));
                by_tau += dot4(&around.along_slopes, &own);
                by_offset += dot4(&around.along, &own);
                slopes.bulk[0] += across * y[i] * by_tau;
                slopes.bulk[1] += around.across_slopes[k] * y[i] * by_offset;
                for gear in 0..2 {
                    let lengths = around.lengths(k, strip, gear);
                    slopes.lengths[i][0][gear] += across * dot4(&around.along_slopes, &lengths);
                    slopes.lengths[i][1][gear] +=
                        around.across_slopes[k] * dot4(&around.along, &lengths);
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

/// The nodes about one point: four along the cycle at each offset.
struct Neighbours<'a> {
    flank: &'a CondensedFlank,
    along: [f64; 4],
    along_slopes: [f64; 4],
    across: Vec<f64>,
    across_slopes: Vec<f64>,
    /// Values of the nodes, offset by offset.
    values: Vec<[&'a [f32]; 4]>,
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
        let [across, across_slopes] =
            (flank.offset_weights(offset)).map(|w| w[..flank.offsets.len()].to_vec());
        Neighbours {
            flank,
            along,
            along_slopes: slopes.map(|slope| slope * flank.positions as f64),
            across,
            across_slopes,
            values: (0..flank.offsets.len())
                .map(|k| {
                    nodes.map(|node| {
                        let place = k * flank.positions + node.rem_euclid(positions) as usize;
                        &flank.values[place * size..][..size]
                    })
                })
                .collect(),
            turns: nodes.map(|node| node.div_euclid(positions) as i32),
            lengths: triangle(flank.strips(), 0),
        }
    }

    /// Influence of the `count` strips from `first` on the strip `row`, none of which comes after it, in the four nodes at the
    /// offset `k`; `zeros` where one is not there.
    #[inline]
    fn lines<'b>(
        &self,
        k: usize,
        row: StripName,
        (first, count): (StripName, usize),
        zeros: &'b [f32],
    ) -> [&'b [f32]; 4]
    where
        'a: 'b,
    {
        let line = |step: usize| -> &'b [f32] {
            let turns = self.turns[step];
            let places = (self.flank.place(row, turns), self.flank.place(first, turns));
            match places {
                (Some(row), Some(column)) => {
                    &self.values[k][step][triangle(row, 0) + column..][..count]
                }
                _ => &zeros[..count],
            }
        };
        [line(0), line(1), line(2), line(3)]
    }

    /// Reference lengths of one gear in the four nodes at the offset `k`.
    #[inline]
    fn lengths(&self, k: usize, strip: StripName, gear: usize) -> [f64; 4] {
        let begin = self.lengths + gear * self.flank.strips();
        let length = |step: usize| {
            let place = self.flank.place(strip, self.turns[step]);
            place.map_or(0.0, |place| f64::from(self.values[k][step][begin + place]))
        };
        [length(0), length(1), length(2), length(3)]
    }
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
