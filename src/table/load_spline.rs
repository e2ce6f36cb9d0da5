//! Quantities of the load over the operating range: nodes of their own beside those of the force, and the spline
//! through them.
//!
//! One cubic spline serves every interpolation of the force, for the force itself is a coordinate here.

use super::check::{check_axis, check_mesh_position, check_values, too_few};
use super::interpolation::{
    ANY, Basis, Block, Coefficients, Ends, Fit, at_zero, axis, over_displacement,
};
use super::{Axis, TableError};
use crate::vector::Lanes;
use serde::{Deserialize, Serialize};

/// Nodes; an axis with one value is not there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadAxes {
    /// Actual minus nominal centre distance.
    pub center_distance_offset_m: Vec<f64>,
    /// In the plane of action.
    pub misalignment_rad: Vec<f64>,
    /// Transverse force on the line of action: > 0 for what is a ratio to the load, else from 0 on.
    pub loa_force_n: Vec<f64>,
    /// In base pitches, periodic.
    pub mesh_position: Vec<f64>,
}

/// What quantities are to the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PerLoad {
    /// Ratios to it or places: there are none without a load, and beyond the largest one they level out.
    Ratio,
    /// Effects of it: they begin at no load, and go on linearly beyond the largest one.
    Effect,
}

/// The samples of one flank: name and values of each quantity.
pub(super) type Columns<'a> = Vec<(&'static str, &'a [f64])>;

impl LoadAxes {
    /// Lengths in the order of the samples: (centre distance, misalignment, force, mesh position), the last index
    /// fastest.
    pub fn lengths(&self) -> [usize; 4] {
        [
            self.center_distance_offset_m.len(),
            self.misalignment_rad.len(),
            self.loa_force_n.len(),
            self.mesh_position.len(),
        ]
    }

    /// Checks a record on these axes: lengths, order and finiteness of nodes and samples, and that the forces begin where
    /// those of `quantities` do. `flanks`: the columns of the drive flank and, if there are own ones, of the coast flank;
    /// `record` and the columns' names stand in messages.
    ///
    /// # Errors
    /// The first defect, by field.
    pub(super) fn check_record(
        &self,
        record: &str,
        quantities: PerLoad,
        flanks: [Option<Columns<'_>>; 2],
    ) -> Result<(), TableError> {
        let named = |name: &str| format!("{record}.axes.{name}");
        for (name, nodes) in [
            (Axis::CenterDistance.name(), &self.center_distance_offset_m),
            (Axis::Misalignment.name(), &self.misalignment_rad),
            ("loa_force_n", &self.loa_force_n),
            (Axis::MeshPosition.name(), &self.mesh_position),
        ] {
            check_axis(&named(name), nodes)?;
        }
        check_mesh_position(&named(Axis::MeshPosition.name()), &self.mesh_position)?;
        let forces = &self.loa_force_n;
        if forces.len() < 4 {
            return Err(too_few(&named("loa_force_n"), forces.len()));
        }
        let (begins, reason) = match quantities {
            PerLoad::Ratio => (forces[0] > 0.0, "ratios to the load need a load"),
            PerLoad::Effect => (forces[0] == 0.0, "effects of the load begin at 0"),
        };
        if !begins {
            return Err(TableError::field(
                named("loa_force_n[0]"),
                forces[0],
                reason,
                "make the tables again",
            ));
        }
        let length = self.lengths().iter().product();
        for (flank, columns) in ["drive", "coast"].into_iter().zip(flanks) {
            for (name, values) in columns.into_iter().flatten() {
                check_values(&format!("{record}.{flank}.{name}"), values, length)?;
            }
        }
        Ok(())
    }
}

/// A quantity at one point, with its derivatives by force, centre distance offset, misalignment and mesh position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadJet {
    /// The quantity.
    pub value: f64,
    /// Its derivatives.
    pub gradient: [f64; 4],
}

/// Spline of some quantities, with just the dimensions that are switched on.
#[derive(Debug)]
pub struct LoadSpline {
    c: Basis<4>,
    m: Basis<4>,
    force: Basis<4>,
    p: Basis<4>,
    quantities: Vec<Coefficients<4>>,
}

impl LoadSpline {
    /// Of the samples of each of the `quantities`, by name, on `axes`, cut at 0 along the axes of centre distance and misalignment whose
    /// effect is off.
    ///
    /// # Errors
    /// Nodes through which no spline passes; an axis to be cut that does not hold 0.
    pub fn new(
        axes: &LoadAxes,
        quantities: &[(&'static str, &[f64])],
        per_load: PerLoad,
        effects: [bool; 2],
    ) -> Result<Self, TableError> {
        let mut axes = axes.clone();
        let lengths = axes.lengths();
        let block = |(_, values): &(&str, &[f64])| Block {
            lengths,
            values: values.to_vec(),
        };
        let mut blocks: Vec<Block> = quantities.iter().map(block).collect();
        let [by_c, by_m] = [Axis::CenterDistance.name(), Axis::Misalignment.name()];
        let cut = [
            (by_c, &mut axes.center_distance_offset_m),
            (by_m, &mut axes.misalignment_rad),
        ];
        for (i, (name, nodes)) in cut.into_iter().enumerate() {
            if effects[i] || nodes.len() == 1 {
                continue;
            }
            for block in &mut blocks {
                *block = at_zero(block, i, nodes, name)?;
            }
            *nodes = vec![0.0];
        }
        let (c, along_c) = axis(&axes.center_distance_offset_m, Ends::Bounded, by_c)?;
        let (m, along_m) = axis(&axes.misalignment_rad, Ends::Bounded, by_m)?;
        let (mut force, along_force) = axis(&axes.loa_force_n, Ends::Bounded, "loa_force_n")?;
        if per_load == PerLoad::Effect {
            force.guard = [f64::INFINITY; 2];
        }
        let by_p = Axis::MeshPosition.name();
        let (p, along_p) = axis(&axes.mesh_position, Ends::Periodic, by_p)?;
        let fits = [along_c, along_m, along_force, along_p];
        let fitted = |block: Block| {
            let along = |block: Block, (axis, fit): (usize, &Fit)| fit.along(axis, &block);
            Coefficients::new(&fits.iter().enumerate().fold(block, along))
        };
        Ok(LoadSpline {
            quantities: blocks.into_iter().map(fitted).collect(),
            c,
            m,
            force,
            p,
        })
    }

    /// The first `K` quantities, in their order, at the transverse force (N) on the line of action, centre distance offset (m),
    /// misalignment (rad) and mesh position; 1 for those that there are no samples of. Beyond the ends they go on linearly and
    /// level out, over the load as [`PerLoad`] says.
    pub fn evaluate<const K: usize>(&self, [force, c, m, p]: [f64; 4]) -> [LoadJet; K] {
        let weights = |basis: &Basis<4>, x| basis.weights(Lanes::COMMON, x, 1).0;
        let wf = weights(&self.force, force);
        let (wc, wm, wp) = (
            weights(&self.c, c),
            weights(&self.m, m),
            weights(&self.p, p),
        );
        std::array::from_fn(|k| {
            let Some(quantity) = self.quantities.get(k) else {
                return LoadJet {
                    value: 1.0,
                    gradient: [0.0; 4],
                };
            };
            let shape =
                over_displacement::<4, 4, false, ANY>(Lanes::COMMON, quantity, &wf, &wc, &wm, &wp);
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

    fn at(spline: &LoadSpline, query: [f64; 4]) -> [LoadJet; 3] {
        spline.evaluate(query)
    }

    fn table(wanted: [bool; 2]) -> LoadSpline {
        table_of(PerLoad::Ratio, wanted)
    }

    fn table_of(per_load: PerLoad, wanted: [bool; 2]) -> LoadSpline {
        let axes = LoadAxes {
            center_distance_offset_m: vec![-1e-4, -4e-5, 0.0, 5e-5, 1e-4],
            misalignment_rad: vec![-2e-3, -5e-4, 0.0, 1e-3, 2e-3],
            loa_force_n: vec![100.0, 500.0, 2000.0, 5000.0, 9000.0],
            mesh_position: (0..40).map(|i| f64::from(i) / 40.0).collect(),
        };
        let quantity = |k: usize| {
            let mut values = vec![];
            for &c in &axes.center_distance_offset_m {
                for &m in &axes.misalignment_rad {
                    for &f in &axes.loa_force_n {
                        values.extend(axes.mesh_position.iter().map(|&p| exact([f, c, m, p], k)));
                    }
                }
            }
            values
        };
        let quantities = [0, 1, 2].map(quantity);
        let quantities = quantities.each_ref().map(|q| ("", &q[..]));
        LoadSpline::new(&axes, &quantities, per_load, wanted).unwrap()
    }

    #[test]
    fn the_spline_holds_smooth_samples_and_its_gradient_is_its_own() {
        let table = table([true, true]);
        let mut random = Random::new(7);
        for _ in 0..200 {
            let q = [
                random.within([100.0, 9000.0]),
                random.within([-1e-4, 1e-4]),
                random.within([-2e-3, 2e-3]),
                random.within([0.0, 1.0]),
            ];
            let jets = at(&table, q);
            for (k, jet) in jets.iter().enumerate() {
                assert!((jet.value / exact(q, k) - 1.0).abs() < 1e-5, "{q:?}");
                for (axis, step) in [1.0, 1e-8, 1e-7, 1e-6].into_iter().enumerate() {
                    let side = |sign: f64| {
                        let mut q = q;
                        q[axis] += sign * step;
                        at(&table, q)[k].value
                    };
                    let slope = (side(1.0) - side(-1.0)) / (2.0 * step);
                    let scale = jet.value.abs() * 1e-8 / step + slope.abs() * 1e-5;
                    assert!(
                        (jet.gradient[axis] - slope).abs() <= scale,
                        "{q:?} {k} {axis}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_dimension_that_is_off_is_cut_at_zero() {
        let (full, cut) = (table([true, true]), table([false, true]));
        let q = [3000.0, 7e-5, 1e-3, 0.4];
        let mut at_zero = q;
        at_zero[1] = 0.0;
        let [a, b] = [at(&cut, q), at(&full, at_zero)];
        for k in 0..3 {
            assert!((a[k].value / b[k].value - 1.0).abs() < 1e-12);
            assert_eq!(a[k].gradient[1], 0.0);
        }
    }

    #[test]
    fn beyond_the_largest_load_ratios_level_out_and_effects_go_on() {
        let top = [9000.0, 2e-5, 1e-4, 0.3];
        for (per_load, goes_on) in [(PerLoad::Ratio, false), (PerLoad::Effect, true)] {
            let table = table_of(per_load, [true, true]);
            let far = [9e4, top[1], top[2], top[3]];
            let (edge, beyond) = (at(&table, top)[1], at(&table, far)[1]);
            if goes_on {
                let linear = edge.value + edge.gradient[0] * (far[0] - top[0]);
                assert!((beyond.value / linear - 1.0).abs() < 1e-12);
                assert_eq!(beyond.gradient[0], edge.gradient[0]);
            } else {
                assert_eq!(beyond.gradient[0], 0.0);
            }
        }
    }
}
