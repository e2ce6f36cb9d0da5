//! Influence between the nodes, and its slopes.

use super::neighbours::Neighbours;
use super::rows::{LANES, OFFSETS, add_products, combine};
use super::{CondensedFlank, StripName};
use crate::contact::influence::Influence;
use crate::table::widest;

/// Slopes of influence by mesh position and by centre distance.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slopes {
    /// y' A y, J per cycle and J/m.
    pub bulk: [f64; 2],
    /// Per gear, strip by strip: reference lengths, m per cycle and m/m.
    pub lengths: [[Vec<f64>; 2]; 2],
}

impl CondensedFlank {
    /// Influence of `strips`, ascending, at the mesh position `tau` in [0, 1) and at `offset` (m); beyond the offsets
    /// of the nodes that of the outermost one. That of a tooth pair on itself is `scale` times as large.
    pub(in crate::contact) fn influence(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        at: [f64; 2],
    ) -> Influence {
        widest(
            #[inline(always)]
            || self.influence_in(strips, scale, at),
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
        let mut bulk = Vec::with_capacity(n * n);
        let mut lengths = [vec![0.0; n], vec![0.0; n]];
        let around = Neighbours::new(self, tau, offset);
        let runs = around.runs(strips);
        let zeros = self.zeros();
        let weights = around.at.each_ref().map(|at| at.weights);
        // What whole groups of lanes write beyond the diagonal is overwritten by what belongs there.
        let mut row = vec![0.0; n + LANES];
        let mut blocks = Vec::with_capacity(runs.len());
        for (known, run) in runs.iter().enumerate() {
            let scale = scale(run.name.0);
            blocks.clear();
            blocks
                .extend((runs[..=known].iter()).map(|columns| around.block(run, columns, &zeros)));
            for i in run.first..run.first + run.count {
                for (columns, block) in runs.iter().zip(&mut blocks) {
                    let places = columns.count.min(i + 1 - columns.first);
                    let count = places.div_ceil(LANES);
                    let entries = &mut row[columns.first..].as_chunks_mut().0[..count];
                    entries.fill([0.0; LANES]);
                    // At an offset of the nodes the others count nothing.
                    for (offset, at) in around.at.iter().enumerate() {
                        if at.across != 0.0 {
                            combine(entries, &at.weights, block.rows(offset, count));
                        }
                    }
                    if scale != 1.0 && columns.name.0 == run.name.0 {
                        let own = &mut row[columns.first..][..places];
                        own.iter_mut().for_each(|value| *value *= scale);
                    }
                    block.advance();
                }
                bulk.extend_from_slice(&row[..n]);
            }
            for (gear, known) in lengths.iter_mut().enumerate() {
                around.lengths((run, gear), &weights, &zeros, known);
            }
        }
        mirror(&mut bulk, n);
        Influence { bulk, lengths }
    }

    /// Slopes of [`CondensedFlank::influence`] by mesh position and by centre distance (1/m) with the forces `y` on the strips.
    pub(in crate::contact) fn slopes(
        &self,
        strips: &[StripName],
        scale: impl Fn(i32) -> f64,
        y: &[f64],
        at: [f64; 2],
    ) -> Slopes {
        widest(
            #[inline(always)]
            || self.slopes_in(strips, scale, y, at),
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
        let zeros = self.zeros();
        // Of the reference lengths, along the cycle and across it.
        let at = around.at.each_ref();
        let weights = [
            at.map(|at| around.along_slopes.map(|slope| at.across * slope)),
            at.map(|at| around.along.map(|weight| at.slope * weight)),
        ];
        // By offset and node: y' A y, lane by lane.
        let mut by_node = [[[0.0; LANES]; 4]; OFFSETS];
        let mut products = vec![[0.0; LANES]; zeros.len() / LANES];
        let mut blocks = Vec::with_capacity(runs.len());
        for (known, run) in runs.iter().enumerate() {
            let scale = scale(run.name.0);
            blocks.clear();
            blocks
                .extend((runs[..=known].iter()).map(|columns| around.block(run, columns, &zeros)));
            for i in run.first..run.first + run.count {
                for (columns, block) in runs.iter().zip(&mut blocks) {
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
                    for (offset, by_node) in by_node.iter_mut().enumerate() {
                        let rows = block.rows(offset, count);
                        add_products(by_node, &products[..count], rows);
                    }
                    block.advance();
                }
            }
            for (weights, lengths) in weights.iter().zip(&mut slopes.lengths) {
                for (gear, lengths) in lengths.iter_mut().enumerate() {
                    around.lengths((run, gear), weights, &zeros, lengths);
                }
            }
        }
        for (sums, at) in by_node.iter().zip(&around.at) {
            let by_node = sums.map(|lanes| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]));
            slopes.bulk[0] += at.across * dot4(&around.along_slopes, &by_node);
            slopes.bulk[1] += at.slope * dot4(&around.along, &by_node);
        }
        slopes
    }

    /// A row of strips that are not there.
    fn zeros(&self) -> Vec<f32> {
        vec![0.0; self.stations.next_multiple_of(LANES)]
    }
}

/// Fills the upper triangle of the `n` x `n` matrix `a`, row by row, from the lower one: four columns at once.
#[inline(always)]
fn mirror(a: &mut [f64], n: usize) {
    for first in (0..n).step_by(LANES) {
        let (above, rows) = a.split_at_mut(first * n);
        let count = LANES.min(n - first);
        if count == LANES {
            let (p, rest) = rows.split_at(n);
            let (q, rest) = rest.split_at(n);
            let (r, s) = rest.split_at(n);
            let own = p.iter().zip(q).zip(r.iter().zip(s));
            for (above, ((p, q), (r, s))) in above.chunks_exact_mut(n).zip(own) {
                above[first..first + LANES].copy_from_slice(&[*p, *q, *r, *s]);
            }
        } else {
            for (j, above) in above.chunks_exact_mut(n).enumerate() {
                for i in 0..count {
                    above[first + i] = rows[i * n + j];
                }
            }
        }
        for i in 1..count {
            for j in 0..i {
                rows[j * n + first + i] = rows[i * n + first + j];
            }
        }
    }
}

fn dot4(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
