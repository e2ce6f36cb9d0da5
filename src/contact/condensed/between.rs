//! Influence between the nodes, and its slopes.

use super::neighbours::Neighbours;
use super::rows::{LANES, Lanes, OFFSETS, add_products, combine};
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
        for (known, run) in runs.iter().enumerate() {
            let scale = scale(run.name.0);
            for i in run.first..run.first + run.count {
                let begins = run.row_begins(i);
                for columns in &runs[..=known] {
                    let places = columns.count.min(i + 1 - columns.first);
                    let count = places.div_ceil(LANES);
                    let entries = &mut row[columns.first..].as_chunks_mut().0[..count];
                    let rows = around.rows(&begins, columns, count, &zeros);
                    combine(entries, &weights, &rows);
                    if scale != 1.0 && columns.name.0 == run.name.0 {
                        let own = &mut row[columns.first..][..places];
                        own.iter_mut().for_each(|value| *value *= scale);
                    }
                }
                bulk.extend_from_slice(&row[..n]);
                let (above, own) = bulk.split_at_mut(i * n);
                for (above, value) in above.chunks_exact_mut(n).zip(&own[..i]) {
                    above[i] = *value;
                }
            }
            for (gear, known) in lengths.iter_mut().enumerate() {
                around.lengths((run, gear), &weights, &zeros, known);
            }
        }
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
        let mut products = vec![[0.0; LANES]; zeros.len()];
        for (known, run) in runs.iter().enumerate() {
            let scale = scale(run.name.0);
            for i in run.first..run.first + run.count {
                let begins = run.row_begins(i);
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
                    let rows = around.rows(&begins, columns, count, &zeros);
                    add_products(&mut by_node, &products[..count], &rows);
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
    fn zeros(&self) -> Vec<Lanes> {
        vec![[0.0; LANES]; self.stations.div_ceil(LANES)]
    }
}

fn dot4(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
