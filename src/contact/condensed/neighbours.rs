//! The nodes about one point, and their weights.

use super::rows::{LANES, Lanes, OFFSETS, Rows, combine};
use super::{CondensedFlank, StripName, triangle};

/// Strips of one tooth pair that follow each other without a gap.
pub struct Run {
    /// The first one's name and place among the strips.
    pub name: StripName,
    pub first: usize,
    pub count: usize,
    /// Places of the first one in the four nodes along the cycle, as far as it is there.
    places: [Option<usize>; 4],
}

/// Rows of the nodes that follow each other: the influence of some strips on those of one run.
pub struct Block<'a> {
    /// Values of the nodes by offset and along the cycle, zeros for one in which the strips are not there.
    values: [[&'a [f32]; 4]; OFFSETS],
    /// Where the present row begins in each of the four along the cycle, the way to the next one, and by how much that is longer.
    begins: [usize; 4],
    ways: [usize; 4],
    growth: [usize; 4],
}

impl<'a> Block<'a> {
    /// Goes on to the next row.
    #[inline(always)]
    pub fn advance(&mut self) {
        for step in 0..4 {
            self.begins[step] += self.ways[step];
            self.ways[step] += self.growth[step];
        }
    }

    /// `count` whole groups of lanes of the present row at one offset. What a group holds beyond the diagonal means nothing.
    #[inline(always)]
    pub fn rows(&self, offset: usize, count: usize) -> Rows<'a> {
        let ([a, b, c, d], begins) = (self.values[offset], &self.begins);
        let row = |values: &'a [f32], begin: usize| {
            let groups: &'a [Lanes] = values[begin..][..count * LANES].as_chunks().0;
            groups
        };
        [
            row(a, begins[0]),
            row(b, begins[1]),
            row(c, begins[2]),
            row(d, begins[3]),
        ]
    }
}

/// The four nodes along the cycle at one offset.
pub struct AtOffset<'a> {
    /// Weight of this offset, and its slope, 1/m.
    pub across: f64,
    pub slope: f64,
    /// Weights of the nodes.
    pub weights: [f64; 4],
    /// Values of the nodes.
    values: [&'a [f32]; 4],
}

/// The nodes about one point.
pub struct Neighbours<'a> {
    flank: &'a CondensedFlank,
    pub along: [f64; 4],
    pub along_slopes: [f64; 4],
    /// Where there is one offset, it counts once and twice not at all.
    pub at: [AtOffset<'a>; OFFSETS],
    /// Whole cycles of each of the four.
    turns: [i32; 4],
    /// Where the reference lengths begin in a node.
    lengths: usize,
}

impl<'a> Neighbours<'a> {
    pub fn new(flank: &'a CondensedFlank, tau: f64, offset: f64) -> Self {
        let positions = flank.positions as i64;
        let at = tau * flank.positions as f64;
        let first = at.floor();
        let nodes = [-1, 0, 1, 2].map(|step| first as i64 + step);
        let size = flank.node_size();
        let [along, slopes] = catmull_rom(at - first);
        let [across, across_slopes] = offset_weights(&flank.offsets, offset);
        Neighbours {
            flank,
            along,
            along_slopes: slopes.map(|slope| slope * flank.positions as f64),
            at: std::array::from_fn(|k| AtOffset {
                across: across[k],
                slope: across_slopes[k],
                weights: along.map(|w| w * across[k]),
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

    pub fn runs(&self, strips: &[StripName]) -> Vec<Run> {
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

    /// The influence of the strips of `columns` on those of `run`; `zeros`, as long as a row of a tooth pair, for nodes in which
    /// one of them is not there.
    #[inline(always)]
    pub fn block<'b>(&'b self, run: &Run, columns: &Run, zeros: &'b [f32]) -> Block<'b> {
        let mut first = [None; 4];
        let (mut ways, mut growth) = ([0; 4], [0; 4]);
        for step in 0..4 {
            if let (Some(row), Some(column)) = (run.places[step], columns.places[step]) {
                first[step] = Some(triangle(row, column));
                (ways[step], growth[step]) = (row + 1, 1);
            }
        }
        Block {
            ways,
            growth,
            ..self.row_from(first, zeros)
        }
    }

    /// One row that begins at `first`.
    #[inline(always)]
    fn row_from<'b>(&'b self, first: [Option<usize>; 4], zeros: &'b [f32]) -> Block<'b> {
        let mut values = [[zeros; 4]; OFFSETS];
        for (values, at) in values.iter_mut().zip(&self.at) {
            for step in 0..4 {
                if first[step].is_some() {
                    values[step] = at.values[step];
                }
            }
        }
        Block {
            values,
            begins: first.map(|first| first.unwrap_or(0)),
            ways: [0; 4],
            growth: [0; 4],
        }
    }

    /// Adds reference lengths of one gear at the strips of `run`, or their slopes, to `out`: the nodes weighted by `weights`. `zeros` as for
    /// [`Neighbours::block`].
    #[inline(always)]
    pub fn lengths(
        &self,
        (run, gear): (&Run, usize),
        weights: &[[f64; 4]; OFFSETS],
        zeros: &[f32],
        out: &mut [f64],
    ) {
        let begin = self.lengths + gear * self.flank.strips();
        let (groups, rest) = out[run.first..][..run.count].as_chunks_mut();
        let first = run.places.map(|place| Some(begin + place?));
        let block = self.row_from(first, zeros);
        for (offset, weights) in weights.iter().enumerate() {
            combine(groups, weights, block.rows(offset, groups.len()));
        }
        // A node may end within a group.
        for (k, length) in rest.iter_mut().enumerate() {
            let place = begin + groups.len() * LANES + k;
            for (weights, at) in weights.iter().zip(&self.at) {
                let nodes = weights.iter().zip(at.values).zip(run.places);
                for ((weight, values), first) in nodes {
                    let Some(first) = first else { continue };
                    *length += weight * f64::from(values[place + first]);
                }
            }
        }
    }
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

/// Weights of `offsets` at `offset`, and their slopes: the parabola through three.
fn offset_weights(offsets: &[f64], offset: f64) -> [[f64; 3]; 2] {
    let [a, b, c] = *offsets else {
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
