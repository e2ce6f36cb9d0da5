//! The spline through the samples of one flank.

use super::{SlidingAxes, SlidingSamples};
use crate::table::TableError;
use crate::table::grid::value_row;
use crate::table::interpolation::{
    Basis, Block, Coefficients, Ends, Two, axis_basis, breaks, over_displacement,
    stored_from_values,
};

/// The three or four quantities at one point, with their derivatives by force, centre distance offset,
/// misalignment and mesh position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingJet {
    /// [`crate::friction::Sliding::share`], `share_z`, `distance` and `weight`.
    pub value: [f64; 4],
    /// Their derivatives.
    pub gradient: [[f64; 4]; 4],
}

/// Spline of one flank, with just the dimensions that are switched on.
#[derive(Debug)]
pub struct SlidingTable {
    interpolant: Box<dyn Interpolant>,
}

trait Interpolant: std::fmt::Debug + Send + Sync {
    fn at(&self, query: [f64; 4]) -> SlidingJet;
}

impl SlidingTable {
    /// Of `samples` on `axes`, cut at 0 along the axes of centre distance and misalignment that are not wanted.
    ///
    /// # Errors
    /// Nodes through which no spline passes; an axis to be cut that does not hold 0.
    pub fn new(
        axes: &SlidingAxes,
        samples: &SlidingSamples,
        [center_distance, misalignment]: [bool; 2],
    ) -> Result<Self, TableError> {
        let mut axes = axes.clone();
        let lengths = axes.lengths();
        let all = [
            Some(&samples.share),
            Some(&samples.share_z_m),
            Some(&samples.distance_m),
        ];
        let mut blocks: Vec<Block> = (all.into_iter().chain([samples.weight.as_ref()]))
            .flatten()
            .map(|values| Block {
                lengths,
                values: values.clone(),
            })
            .collect();
        let cut = [
            (0, center_distance, &mut axes.center_distance_offset_m),
            (1, misalignment, &mut axes.misalignment_rad),
        ];
        for (axis, wanted, nodes) in cut {
            if wanted || nodes.len() == 1 {
                continue;
            }
            let row = value_row(
                nodes,
                ["center_distance_offset_m", "misalignment_rad"][axis],
            )?;
            for block in &mut blocks {
                *block = block.transformed(axis, &row);
            }
            *nodes = vec![0.0];
        }
        macro_rules! choose {
            ($nc:literal, $nm:literal, $np:literal) => {
                Box::new(Spline::<$nc, $nm, $np>::new(&axes, &blocks)?)
            };
        }
        let [nc, nm, _, np] = axes.lengths();
        let interpolant: Box<dyn Interpolant> = match (nc > 1, nm > 1, np > 1) {
            (false, false, false) => choose!(1, 1, 1),
            (false, false, true) => choose!(1, 1, 4),
            (false, true, false) => choose!(1, 4, 1),
            (false, true, true) => choose!(1, 4, 4),
            (true, false, false) => choose!(4, 1, 1),
            (true, false, true) => choose!(4, 1, 4),
            (true, true, false) => choose!(4, 4, 1),
            (true, true, true) => choose!(4, 4, 4),
        };
        Ok(SlidingTable { interpolant })
    }

    /// At the transverse force (N) on the line of action, centre distance offset (m), misalignment (rad) and mesh
    /// position. Beyond the ends it goes on linearly and levels out.
    pub fn evaluate(&self, query: [f64; 4]) -> SlidingJet {
        self.interpolant.at(query)
    }
}

#[derive(Debug)]
struct Spline<const NC: usize, const NM: usize, const NP: usize> {
    c: Basis<NC>,
    m: Basis<NM>,
    force: Basis<4>,
    p: Basis<NP>,
    quantities: Vec<Coefficients<NP>>,
}

impl<const NC: usize, const NM: usize, const NP: usize> Spline<NC, NM, NP> {
    fn new(axes: &SlidingAxes, blocks: &[Block]) -> Result<Self, TableError> {
        let c = axis_basis::<NC>(&axes.center_distance_offset_m, Ends::Bounded);
        let m = axis_basis::<NM>(&axes.misalignment_rad, Ends::Bounded);
        let force = Basis::<4>::new(&breaks(&axes.loa_force_n, 3, Ends::Bounded), Ends::Bounded);
        let p = axis_basis::<NP>(&axes.mesh_position, Ends::Periodic);
        let along = [
            stored_from_values(
                &c,
                &axes.center_distance_offset_m,
                Ends::Bounded,
                "center_distance_offset_m",
            )?,
            stored_from_values(
                &m,
                &axes.misalignment_rad,
                Ends::Bounded,
                "misalignment_rad",
            )?,
            stored_from_values(&force, &axes.loa_force_n, Ends::Bounded, "loa_force_n")?,
            stored_from_values(&p, &axes.mesh_position, Ends::Periodic, "mesh_position")?,
        ];
        let fit = |block: &Block| {
            let along = along.iter().enumerate();
            Coefficients::new(&along.fold(block.clone(), |b, (axis, matrix)| {
                b.transformed(axis, matrix)
            }))
        };
        Ok(Spline {
            quantities: blocks.iter().map(fit).collect(),
            c,
            m,
            force,
            p,
        })
    }
}

impl<const NC: usize, const NM: usize, const NP: usize> Interpolant for Spline<NC, NM, NP> {
    fn at(&self, [force, c, m, p]: [f64; 4]) -> SlidingJet {
        let (wc, _) = self.c.weights(Two, c, 1);
        let (wm, _) = self.m.weights(Two, m, 1);
        let (wf, _) = self.force.weights(Two, force, 1);
        let (wp, _) = self.p.weights(Two, p, 1);
        // Laws of the whole mesh have no weights of their own.
        let mut jet = SlidingJet {
            value: [0.0, 0.0, 0.0, 1.0],
            gradient: [[0.0; 4]; 4],
        };
        for (i, quantity) in self.quantities.iter().enumerate() {
            let (shape, _) =
                over_displacement::<4, NC, NM, NP, false>(Two, quantity, &wf, &wc, &wm, &wp);
            let [by_c, by_m, by_p] = shape[0].gradient;
            jet.value[i] = shape[0].value;
            jet.gradient[i] = [shape[1].value, by_c, by_m, by_p];
        }
        jet
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

    fn table(wanted: [bool; 2]) -> SlidingTable {
        let axes = SlidingAxes {
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
        let samples = SlidingSamples {
            share: quantity(0),
            share_z_m: quantity(1),
            distance_m: quantity(2),
            weight: None,
        };
        SlidingTable::new(&axes, &samples, wanted).unwrap()
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
            let jet = table.evaluate(q);
            assert_eq!(jet.value[3], 1.0);
            for k in 0..3 {
                assert!((jet.value[k] / exact(q, k) - 1.0).abs() < 1e-5, "{q:?}");
                for (axis, step) in [1.0, 1e-8, 1e-7, 1e-6].into_iter().enumerate() {
                    let at = |sign: f64| {
                        let mut q = q;
                        q[axis] += sign * step;
                        table.evaluate(q).value[k]
                    };
                    let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
                    let scale = jet.value[k].abs() * 1e-8 / step + slope.abs() * 1e-5;
                    assert!(
                        (jet.gradient[k][axis] - slope).abs() <= scale,
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
        let [a, b] = [cut.evaluate(q), full.evaluate(at_zero)];
        for k in 0..3 {
            assert!((a.value[k] / b.value[k] - 1.0).abs() < 1e-12);
            assert_eq!(a.gradient[k][1], 0.0);
        }
    }
}
