//! Splines over the load: what the tables file holds besides the force.

use super::basis::{Basis, Ends};
use super::fit::{Others, at_zero, axis};
use super::kernel::{ANY, Coefficients, Point};
use crate::table::block::Block;
use crate::table::records::Columns;
use crate::table::{Axis, TableError};
use crate::vector::Lanes;

/// A quantity at one point, with its derivatives by force, centre distance offset, misalignment and mesh position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadJet {
    /// The quantity.
    pub value: f64,
    /// Its derivatives.
    pub gradient: [f64; 4],
}

/// Spline of some quantities, with just the dimensions that are switched on. One cubic spline serves every interpolation of
/// the force, for the force itself is a coordinate here.
#[derive(Debug)]
pub struct LoadSpline {
    others: [Basis<4>; 3],
    force: Basis<4>,
    quantities: Vec<Coefficients<4>>,
}

impl LoadSpline {
    /// Of the `columns` at `nodes` (of [`crate::table::LoadAxes::nodes`]), cut at 0 along the axes of centre distance and
    /// misalignment whose effect is off.
    ///
    /// # Errors
    /// Nodes through which no spline passes; an axis to be cut that does not hold 0.
    pub fn new(
        mut nodes: [&[f64]; 4],
        columns: &Columns<'_>,
        effects: [bool; 2],
    ) -> Result<Self, TableError> {
        let lengths = nodes.map(<[f64]>::len);
        let block = |(_, values): &(_, &[f64])| Block {
            lengths,
            values: values.to_vec(),
        };
        let mut blocks: Vec<Block> = columns.iter().map(block).collect();
        for axis in [Axis::CenterDistance, Axis::Misalignment] {
            let i = axis as usize;
            if !effects[i] && nodes[i].len() > 1 {
                let zero = at_zero(nodes[i], axis.name())?;
                for block in &mut blocks {
                    *block = block.mapped(i, 1, |line| vec![zero(&line)]);
                }
                nodes[i] = &[0.0];
            }
        }
        let others = Others::new(nodes)?;
        let (mut force, along_force) = axis(nodes[2], Ends::Bounded, "loa_force_n")?;
        if nodes[2][0] == 0.0 {
            force.levelling_length = [f64::INFINITY; 2];
        }
        let fitted = |block| Coefficients::new(&others.fit(block, Some(&along_force)));
        Ok(LoadSpline {
            quantities: blocks.iter().map(fitted).collect(),
            others: others.bases,
            force,
        })
    }

    /// The first `K` quantities, in their order, at the transverse force (N) on the line of action, centre distance offset (m),
    /// misalignment (rad) and mesh position; 1 for those that there are no samples of. Beyond the ends they go on linearly and
    /// level out, over the load as [`crate::table::LoadAxes`] says.
    pub fn evaluate<const K: usize>(&self, [force, c, m, p]: [f64; 4]) -> [LoadJet; K] {
        let weights = |basis: &Basis<4>, x| basis.weights(Lanes::COMMON, x, 1).0;
        let [along_c, along_m, along_p] = &self.others;
        let wf = weights(&self.force, force);
        let at = Point {
            c: weights(along_c, c),
            m: weights(along_m, m),
            p: weights(along_p, p),
        };
        std::array::from_fn(|k| {
            let Some(quantity) = self.quantities.get(k) else {
                return LoadJet {
                    value: 1.0,
                    gradient: [0.0; 4],
                };
            };
            let shape = quantity.shape::<4, false, ANY>(Lanes::COMMON, &wf, &at);
            let [by_c, by_m, by_p] = shape.value.gradient;
            LoadJet {
                value: shape.value.value,
                gradient: [shape.slope.value, by_c, by_m, by_p],
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A function that a cubic spline holds but for its periodic part.
    fn exact([f, c, m, p]: [f64; 4], k: usize) -> f64 {
        let wave = (std::f64::consts::TAU * p).cos();
        (1.0 + 1e-3 * f)
            * (1.0 + 200.0 * c)
            * (1.0 + 300.0 * m * (k as f64 - 1.0))
            * (1.0 + 0.1 * wave)
    }

    /// Three quantities, on axes whose forces begin at `first`.
    fn spline(first: f64, effects: [bool; 2]) -> LoadSpline {
        let positions: Vec<f64> = (0..40).map(|i| f64::from(i) / 40.0).collect();
        let nodes @ [c, m, f, p] = [
            &[-1e-4, -4e-5, 0.0, 5e-5, 1e-4][..],
            &[-2e-3, -5e-4, 0.0, 1e-3, 2e-3],
            &[first, 500.0, 2000.0, 5000.0, 9000.0],
            &positions,
        ];
        let quantity = |k| -> Vec<f64> {
            let point = |i: usize| [f[i / 40 % 5], c[i / 1000], m[i / 200 % 5], p[i % 40]];
            (0..5000).map(|i| exact(point(i), k)).collect()
        };
        let quantities = [0, 1, 2].map(quantity);
        let columns = quantities.iter().map(|values| ("", &values[..])).collect();
        LoadSpline::new(nodes, &columns, effects).unwrap()
    }

    #[test]
    fn the_spline_holds_smooth_samples_and_its_gradient_is_its_own() {
        let spline = spline(100.0, [true, true]);
        let at = |q| -> [LoadJet; 3] { spline.evaluate(q) };
        let mut random = Random::new(7);
        for _ in 0..200 {
            // Differences stay inside: second derivatives jump at the ends.
            let ranges = [
                [102.0, 8998.0],
                [-9.9e-5, 9.9e-5],
                [-1.99e-3, 1.99e-3],
                [0.0, 1.0],
            ];
            let q = ranges.map(|range| random.within(range));
            for (k, jet) in at(q).iter().enumerate() {
                assert!((jet.value / exact(q, k) - 1.0).abs() < 1e-5, "{q:?}");
                for (axis, step) in [1.0, 1e-8, 1e-7, 1e-6].into_iter().enumerate() {
                    let [low, high] = [-step, step].map(|step| {
                        let mut q = q;
                        q[axis] += step;
                        at(q)[k].value
                    });
                    let slope = (high - low) / (2.0 * step);
                    let error = (jet.gradient[axis] - slope).abs();
                    let bound = jet.value.abs() * 1e-8 / step + slope.abs() * 1e-5;
                    assert!(error <= bound, "{q:?} {k} {axis}");
                }
            }
        }
    }

    #[test]
    fn what_is_off_is_cut_at_zero_and_beyond_the_largest_load_ratios_level_out_and_effects_go_on() {
        let [full, cut] = [true, false].map(|on| spline(100.0, [on, true]));
        let [a]: [LoadJet; 1] = cut.evaluate([3000.0, 7e-5, 1e-3, 0.4]);
        let [b]: [LoadJet; 1] = full.evaluate([3000.0, 0.0, 1e-3, 0.4]);
        assert!((a.value / b.value - 1.0).abs() < 1e-12);
        assert_eq!(a.gradient[1], 0.0);
        for first in [100.0, 0.0] {
            let spline = spline(first, [true, true]);
            let [[edge], [beyond]] = [9e3, 9e4].map(|f| spline.evaluate([f, 2e-5, 1e-4, 0.3]));
            let slope = if first == 0.0 { edge.gradient[0] } else { 0.0 };
            assert_eq!(beyond.gradient[0], slope);
            let linear = edge.value + slope * 81e3;
            assert!(first > 0.0 || (beyond.value / linear - 1.0).abs() < 1e-12);
        }
    }
}
