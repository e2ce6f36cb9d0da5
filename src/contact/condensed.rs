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

use std::hint::black_box;

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
        widest(
            #[inline(always)]
            || self.influence_in(strips, scale, [tau, offset]),
        )
    }

    #[inline(always)]
    fn influence_in(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        [tau, offset]: [f64; 2],
    ) -> Influence {
        let n = strips.len();
        // What whole groups of lanes write beyond the diagonal is overwritten by what belongs there, and beyond the last
        // row cut off.
        let mut bulk = vec![0.0; n * n + LANES];
        let mut lengths = [vec![0.0; n], vec![0.0; n]];
        let around = Neighbours::new(self, tau, offset);
        let runs = around.runs(strips);
        let zeros = vec![[0.0; LANES]; self.stations.div_ceil(LANES)];
        let (middle, others) = around.at.split_first().expect("an offset");
        for (known, run) in runs.iter().enumerate() {
            for i in run.first..run.first + run.count {
                for columns in &runs[..=known] {
                    let count = columns.count.min(i + 1 - columns.first).div_ceil(LANES);
                    let entries = &mut bulk[i * n + columns.first..].as_chunks_mut().0[..count];
                    let starts = run.starts(i, columns);
                    let lines = middle.lines(&starts, count, &zeros);
                    combine::<false>(entries, &middle.weights, lines);
                    for at in others {
                        combine::<true>(entries, &at.weights, at.lines(&starts, count, &zeros));
                    }
                }
            }
            for (gear, known) in lengths.iter_mut().enumerate() {
                around.add_lengths(run, gear, |at| at.weights, known);
            }
        }
        bulk.truncate(n * n);
        for (i, &(pair, _)) in strips.iter().enumerate() {
            let scale = scale(pair);
            let (above, row) = bulk.split_at_mut(i * n);
            if scale != 1.0 {
                let own = strips[..=i].iter().zip(row.iter_mut());
                own.filter(|(name, _)| name.0 == pair)
                    .for_each(|(_, value)| *value *= scale);
            }
            for (above, value) in above.chunks_exact_mut(n).zip(&row[..i]) {
                above[i] = *value;
            }
        }
        Influence { bulk, lengths }
    }

    /// Slopes of [`CondensedFlank::influence`] by mesh position and by centre distance (1/m) with the forces `y` on the strips.
    pub(super) fn slopes(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        y: &[f64],
        [tau, offset]: [f64; 2],
    ) -> Slopes {
        widest(
            #[inline(always)]
            || self.slopes_in(strips, scale, y, [tau, offset]),
        )
    }

    #[inline(always)]
    fn slopes_in(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        y: &[f64],
        [tau, offset]: [f64; 2],
    ) -> Slopes {
        let mut slopes = Slopes {
            lengths: [(); 2].map(|()| [(); 2].map(|()| vec![0.0; strips.len()])),
            ..Slopes::default()
        };
        let around = Neighbours::new(self, tau, offset);
        let runs = around.runs(strips);
        let zeros = vec![[0.0; LANES]; self.stations.div_ceil(LANES)];
        // By offset and node: y' A y, lane by lane.
        let mut by_node = [[[0.0; LANES]; 4]; 3];
        let mut products = vec![[0.0; LANES]; zeros.len()];
        for (known, run) in runs.iter().enumerate() {
            let scale = scale(run.name.0);
            for i in run.first..run.first + run.count {
                for columns in &runs[..=known] {
                    let last = columns.count.min(i + 1 - columns.first);
                    let count = last.div_ceil(LANES);
                    let is_own = columns.name.0 == run.name.0;
                    // The diagonal counts once, what lies beside it twice.
                    let twice = 2.0 * y[i] * if is_own { scale } else { 1.0 };
                    let places = products[..count].as_flattened_mut();
                    for (product, y) in places.iter_mut().zip(&y[columns.first..][..last]) {
                        *product = twice * y;
                    }
                    places[last..].fill(0.0);
                    if columns.first + last == i + 1 {
                        places[last - 1] *= 0.5;
                    }
                    let starts = run.starts(i, columns);
                    for (sums, at) in by_node.iter_mut().zip(&around.at) {
                        let lines = at.lines(&starts, count, &zeros);
                        add_products(sums, &products[..count], lines);
                    }
                }
            }
            let [by_tau, by_offset] = &mut slopes.lengths;
            for gear in 0..2 {
                let along = |at: &AtOffset<'_>| around.along_slopes.map(|slope| at.across * slope);
                around.add_lengths(run, gear, along, &mut by_tau[gear]);
                let across = |at: &AtOffset<'_>| around.along.map(|weight| at.slope * weight);
                around.add_lengths(run, gear, across, &mut by_offset[gear]);
            }
        }
        for (sums, at) in by_node.iter().zip(&around.at) {
            let by_node = sums.map(|lanes| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]));
            slopes.bulk[0] += at.across * dot4(&around.along_slopes, &by_node);
            slopes.bulk[1] += at.slope * dot4(&around.along, &by_node);
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
    /// Per gear, strip by strip: reference lengths, m per cycle and m/m.
    pub lengths: [[Vec<f64>; 2]; 2],
}

/// Strips of one tooth pair that follow each other without a gap.
struct Run {
    /// The first one's name and place among the strips.
    name: StripName,
    first: usize,
    count: usize,
    /// Places of the first one in the four nodes along the cycle, as far as it is there.
    places: [Option<usize>; 4],
}

impl Run {
    /// Where in the four nodes the influence of the strips of `columns` on strip `i` of this run begins.
    #[inline(always)]
    fn starts(&self, i: usize, columns: &Run) -> [Option<usize>; 4] {
        std::array::from_fn(|step| match (self.places[step], columns.places[step]) {
            (Some(row), Some(first)) => Some(triangle(row + (i - self.first), first)),
            _ => None,
        })
    }
}

/// The four nodes along the cycle at one offset.
struct AtOffset<'a> {
    /// Weight of this offset, and its slope, 1/m.
    across: f64,
    slope: f64,
    /// Weights of the nodes.
    weights: [f64; 4],
    /// Values of the nodes.
    values: [&'a [f32]; 4],
}

impl AtOffset<'_> {
    /// `count` whole groups of lanes of the four nodes from `starts` on; `zeros` where one is not there. What a group
    /// holds beyond the diagonal means nothing.
    #[inline(always)]
    fn lines<'b>(
        &'b self,
        starts: &[Option<usize>; 4],
        count: usize,
        zeros: &'b [Lanes],
    ) -> [&'b [Lanes]; 4] {
        let of = |step: usize| match starts[step] {
            Some(start) => &self.values[step][start..].as_chunks().0[..count],
            None => &zeros[..count],
        };
        [of(0), of(1), of(2), of(3)]
    }
}

/// The nodes about one point.
struct Neighbours<'a> {
    flank: &'a CondensedFlank,
    along: [f64; 4],
    along_slopes: [f64; 4],
    /// Offset by offset: one or three.
    at: Vec<AtOffset<'a>>,
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
            at: (0..flank.offsets.len())
                .map(|k| AtOffset {
                    across: across[k],
                    slope: across_slopes[k],
                    weights: along.map(|w| w * across[k]),
                    values: nodes.map(|node| {
                        let place = k * flank.positions + node.rem_euclid(positions) as usize;
                        &flank.values[place * size..][..size]
                    }),
                })
                .collect(),
            turns: nodes.map(|node| node.div_euclid(positions) as i32),
            lengths: triangle(flank.strips(), 0),
        }
    }

    fn runs(&self, strips: &[StripName]) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::with_capacity(8);
        for (i, &(pair, station)) in strips.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if run.name.0 == pair && run.name.1 + run.count == station => {
                    run.count += 1;
                }
                _ => runs.push(Run {
                    name: (pair, station),
                    first: i,
                    count: 1,
                    places: self
                        .turns
                        .map(|turns| self.flank.place((pair, station), turns)),
                }),
            }
        }
        runs
    }

    /// Adds the reference lengths of one gear at the strips of `run`, the nodes weighted by `weights`, to `out`.
    #[inline(always)]
    fn add_lengths(
        &self,
        run: &Run,
        gear: usize,
        weights: impl Fn(&AtOffset<'a>) -> [f64; 4],
        out: &mut [f64],
    ) {
        let begin = self.lengths + gear * self.flank.strips();
        let out = &mut out[run.first..][..run.count];
        for at in &self.at {
            for ((weight, values), place) in weights(at).iter().zip(at.values).zip(run.places) {
                let Some(place) = place else { continue };
                for (sum, length) in out.iter_mut().zip(&values[begin + place..]) {
                    *sum += weight * f64::from(*length);
                }
            }
        }
    }
}

/// Numbers that are combined at once.
const LANES: usize = 4;
type Lanes = [f32; LANES];

/// Puts the sum of `lines`, weighted, into `entries`, or adds it to what is there.
#[inline(always)]
fn combine<const ADD: bool>(
    entries: &mut [[f64; LANES]],
    weights: &[f64; 4],
    [a, b, c, d]: [&[Lanes]; 4],
) {
    let (w, count) = (*weights, entries.len());
    let (a, b, c, d) = (&a[..count], &b[..count], &c[..count], &d[..count]);
    for place in 0..count {
        // Groups one by one: left to itself the compiler takes several at once, lane by lane, with more shuffles than sums.
        let place = black_box(place).min(count - 1);
        let (a, b, c, d) = (&a[place], &b[place], &c[place], &d[place]);
        let mut sums = if ADD { entries[place] } else { [0.0; LANES] };
        for lane in 0..LANES {
            sums[lane] += (w[0] * f64::from(a[lane]) + w[1] * f64::from(b[lane]))
                + (w[2] * f64::from(c[lane]) + w[3] * f64::from(d[lane]));
        }
        entries[place] = sums;
    }
}

/// Adds the products of `y` and each of `lines` to `sums`, lane by lane.
#[inline(always)]
fn add_products(sums: &mut [[f64; LANES]; 4], y: &[[f64; LANES]], lines: [&[Lanes]; 4]) {
    let [a, b, c, d] = lines;
    let lines = a.iter().zip(b).zip(c.iter().zip(d));
    let mut all = *sums;
    for (y, ((a, b), (c, d))) in y.iter().zip(lines) {
        for (sums, line) in all.iter_mut().zip([a, b, c, d]) {
            for lane in 0..LANES {
                sums[lane] += y[lane] * f64::from(line[lane]);
            }
        }
    }
    *sums = all;
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
