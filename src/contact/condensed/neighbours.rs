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

impl Run {
    /// Where in the four nodes the influence of all strips on strip `i` of this run begins.
    #[inline(always)]
    pub fn row_begins(&self, i: usize) -> [Option<usize>; 4] {
        (self.places).map(|place| Some(triangle(place? + (i - self.first), 0)))
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

    /// `count` whole groups of lanes of all nodes, from the first of `columns` on, of the rows that begin at `begins`; `zeros` where
    /// one is not there. What a group holds beyond the diagonal means nothing.
    #[inline(always)]
    pub fn rows<'b>(
        &'b self,
        begins: &[Option<usize>; 4],
        columns: &Run,
        count: usize,
        zeros: &'b [Lanes],
    ) -> Rows<'b> {
        let mut rows = [[&zeros[..count]; 4]; OFFSETS];
        for step in 0..4 {
            if let (Some(begin), Some(column)) = (begins[step], columns.places[step]) {
                for (rows, at) in rows.iter_mut().zip(&self.at) {
                    let values = &at.values[step][begin + column..];
                    rows[step] = &values.as_chunks().0[..count];
                }
            }
        }
        rows
    }

    /// Reference lengths of one gear at the strips of `run`, or their slopes, into `out`: the nodes weighted by `weights`. `zeros` as for
    /// [`Neighbours::rows`].
    #[inline(always)]
    pub fn lengths(
        &self,
        (run, gear): (&Run, usize),
        weights: &[[f64; 4]; OFFSETS],
        zeros: &[Lanes],
        out: &mut [f64],
    ) {
        let begin = self.lengths + gear * self.flank.strips();
        let (groups, rest) = out[run.first..][..run.count].as_chunks_mut();
        let rows = self.rows(&[Some(begin); 4], run, groups.len(), zeros);
        combine(groups, weights, &rows);
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
