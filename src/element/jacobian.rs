//! Exact derivatives of the outputs by poses and velocities.
//!
//! The equations run once more over dual numbers; only the table is differentiated by its own Hessian.

use super::error::ElementError;
use super::motion::{CONTINUOUS_OUTPUTS, Inputs, Latch, Motion, Outputs};
use super::{Element, Formulation, check};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use num_dual::{Derivative, Dual64, DualSVec64};

/// Change of one body's motion; a rotation is a small rotation vector in world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionChange {
    /// Of the position, m.
    pub p: Vector3<f64>,
    /// Rotation vector, rad: dR = rotation x R.
    pub rotation: Vector3<f64>,
    /// Of the velocity, m/s.
    pub v: Vector3<f64>,
    /// Of the angular velocity, rad/s.
    pub w: Vector3<f64>,
}

impl Default for MotionChange {
    fn default() -> Self {
        let zero = Vector3::zeros();
        Self {
            p: zero,
            rotation: zero,
            v: zero,
            w: zero,
        }
    }
}

/// Change of all inputs: the direction of a directional derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InputsChange {
    /// Gear 1 and gear 2.
    pub gears: [MotionChange; 2],
    /// Carrier.
    pub carrier: MotionChange,
}

/// Columns of one body in [`Jacobian`]: position, rotation, velocity, angular velocity.
pub const BODY_COLUMNS: usize = 12;

/// Rows: [`Outputs::to_array`]. Columns: gear 1, gear 2, carrier, each as position (m), rotation
/// vector in world axes (rad), velocity (m/s), angular velocity (rad/s).
pub type Jacobian = SMatrix<f64, CONTINUOUS_OUTPUTS, { 3 * BODY_COLUMNS }>;

impl Element {
    /// Derivative of the continuous outputs ([`Outputs::to_array`]) at `inputs` along `direction`.
    ///
    /// Exact; under a law that does not give [`Potential::stiffness_gradient`](crate::table::Potential),
    /// the derivative of `stiffness` takes it by central differences. At the kinks of the law (first touch of constant stiffness,
    /// clamped damping) it is that of the side the value is taken on.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn directional_derivative(
        &self,
        latch: &Latch,
        inputs: &Inputs,
        direction: &InputsChange,
    ) -> Result<[f64; CONTINUOUS_OUTPUTS], ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        let seed = |m: &Motion, d: &MotionChange| Motion {
            p: m.p.zip_map(&d.p, Dual64::new),
            r: m.r.zip_map(&(skew(&d.rotation) * m.r), Dual64::new),
            v: m.v.zip_map(&d.v, Dual64::new),
            w: m.w.zip_map(&d.w, Dual64::new),
        };
        let [g1, g2] = &inputs.gears;
        let seeded = Inputs {
            gears: [seed(g1, &direction.gears[0]), seed(g2, &direction.gears[1])],
            carrier: seed(&inputs.carrier, &direction.carrier),
        };
        let out: Outputs<Dual64> = self.evaluate_generic(latch, &seeded)?;
        Ok(out.to_array().map(|y| y.eps))
    }

    /// All partial derivatives of the continuous outputs at `inputs`; see
    /// [`Element::directional_derivative`].
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn jacobian(&self, latch: &Latch, inputs: &Inputs) -> Result<Jacobian, ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        let mut jacobian = Jacobian::zeros();
        let bodies = match self.parameters.formulation {
            Formulation::Paper => 3,
            Formulation::Conjugate => 2,
        };
        for body in 0..bodies {
            let motion = |i: usize, m: &Motion| seed(m, i == body);
            let seeded = Inputs {
                gears: [motion(0, &inputs.gears[0]), motion(1, &inputs.gears[1])],
                carrier: motion(2, &inputs.carrier),
            };
            let out = self.evaluate_generic(latch, &seeded)?;
            for (row, y) in out.to_array().iter().enumerate() {
                if let Some(slopes) = y.eps.0 {
                    for column in 0..BODY_COLUMNS {
                        jacobian[(row, BODY_COLUMNS * body + column)] = slopes[column];
                    }
                }
            }
        }
        Ok(jacobian)
    }
}

type Lanes = DualSVec64<BODY_COLUMNS>;

/// `m` with one derivative lane for each of its twelve freedoms, or with none.
fn seed(m: &Motion, active: bool) -> Motion<Lanes> {
    let lane = |value: f64, slopes: SVector<f64, BODY_COLUMNS>| {
        Lanes::new(
            value,
            if active {
                Derivative::some(slopes)
            } else {
                Derivative::none()
            },
        )
    };
    let unit = |offset: usize, v: &Vector3<f64>| {
        Vector3::from_fn(|i, _| lane(v[i], SVector::ith(offset + i, 1.0)))
    };
    let turns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| skew(&axis) * m.r);
    Motion {
        p: unit(0, &m.p),
        r: Matrix3::from_fn(|i, j| {
            let mut slopes = SVector::zeros();
            for (k, turn) in turns.iter().enumerate() {
                slopes[3 + k] = turn[(i, j)];
            }
            lane(m.r[(i, j)], slopes)
        }),
        v: unit(6, &m.v),
        w: unit(9, &m.w),
    }
}

/// [w]x, so that [w]x b = w × b.
fn skew(w: &Vector3<f64>) -> Matrix3<f64> {
    w.cross_matrix()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Noise, compressed, random_pose, three_pairs};
    use super::*;
    use crate::element::{FlankLaws, Interpolation, LoadedFlank, Parameters};
    use crate::table::{FlankTable, samples::Spring};
    use nalgebra::Rotation3;
    use std::sync::Arc;

    fn nudged(m: &Motion, d: &MotionChange, h: f64) -> Motion {
        Motion {
            p: m.p + d.p * h,
            r: Rotation3::new(d.rotation * h).matrix() * m.r,
            v: m.v + d.v * h,
            w: m.w + d.w * h,
        }
    }

    fn moved(x: &Inputs, d: &InputsChange, h: f64) -> Inputs {
        Inputs {
            gears: [0, 1].map(|i| nudged(&x.gears[i], &d.gears[i], h)),
            carrier: nudged(&x.carrier, &d.carrier, h),
        }
    }

    /// Exact derivatives at `inputs` along a random direction, against the Jacobian and against finite
    /// differences, all rows but `mesh.stiffness` to `bar` of their scale, that one to `stiffness_bar`.
    fn compare(
        element: &Element,
        inputs: &Inputs,
        noise: &mut Noise,
        bar: f64,
        stiffness_bar: f64,
    ) {
        const STIFFNESS_ROW: usize = 22;
        let latch = element.latch(&element.nominal_inputs()).unwrap();
        let mut change = || MotionChange {
            p: noise.vector(1.0),
            rotation: noise.vector(10.0),
            v: noise.vector(100.0),
            w: noise.vector(100.0),
        };
        let direction = InputsChange {
            gears: [change(), change()],
            carrier: change(),
        };
        let exact = element
            .directional_derivative(&latch, inputs, &direction)
            .unwrap();
        let h = 2e-8;
        let side = |h: f64| {
            let out = element.evaluate(&latch, &moved(inputs, &direction, h));
            SVector::from(out.unwrap().to_array())
        };
        let rough = (8.0 * (side(h) - side(-h)) - (side(2.0 * h) - side(-2.0 * h))) / (12.0 * h);
        let value = side(0.0);
        let jacobian = element.jacobian(&latch, inputs).unwrap();
        let mut flat = SVector::<f64, { 3 * BODY_COLUMNS }>::zeros();
        let bodies = [direction.gears[0], direction.gears[1], direction.carrier];
        for (i, d) in bodies.iter().enumerate() {
            for (j, x) in [d.p, d.rotation, d.v, d.w].iter().enumerate() {
                flat.fixed_rows_mut::<3>(12 * i + 3 * j).copy_from(x);
            }
        }
        let product = jacobian * flat;
        // Outputs of one kind share a scale: forces, moments, then each scalar its own.
        for row in 0..CONTINUOUS_OUTPUTS {
            let group = if row < 15 {
                row / 3 * 3..row / 3 * 3 + 3
            } else {
                row..row + 1
            };
            // A change by one unit of the direction, or the value itself where that is larger.
            let scale = group
                .map(|i| exact[i].abs().max(value[i].abs()))
                .fold(0.0, f64::max);
            let bar = if row == STIFFNESS_ROW {
                stiffness_bar
            } else {
                bar
            };
            assert!(
                (exact[row] - product[row]).abs() <= 1e-12 * scale,
                "row {row}: {} against {}",
                exact[row],
                product[row]
            );
            assert!(
                (exact[row] - rough[row]).abs() <= bar * scale,
                "{:?} row {row}: {} against {}",
                element.parameters().formulation,
                exact[row],
                rough[row]
            );
        }
    }

    /// Some motion of both gears.
    fn set_velocities(inputs: &mut Inputs, noise: &mut Noise) {
        for m in &mut inputs.gears {
            m.v = noise.vector(1e-3);
            m.w = noise.vector(1e-2);
        }
    }

    #[test]
    fn derivatives_agree_with_finite_differences_and_with_each_other() {
        let mut noise = Noise::new(5);
        for formulation in [Formulation::Paper, Formulation::Conjugate] {
            for pair in three_pairs(1.0) {
                let parameters = Parameters {
                    formulation,
                    loaded_flank: LoadedFlank::Both,
                    damping: 1e5,
                    ..Parameters::default()
                };
                let element = Element::new(&pair, &parameters, None).unwrap();
                let latch = element.latch(&element.nominal_inputs()).unwrap();
                let mut tried = 0;
                while tried < 8 {
                    let mut inputs = random_pose(&element, &mut noise);
                    set_velocities(&mut inputs, &mut noise);
                    if element.evaluate(&latch, &inputs).unwrap().flank == 0 {
                        continue;
                    }
                    tried += 1;
                    compare(&element, &inputs, &mut noise, 1e-6, 1e-6);
                }
            }
        }
    }

    #[test]
    fn derivatives_on_a_table_agree_with_finite_differences() {
        let grid = Spring::grid([10, 7, 9, 16]);
        let drive = Arc::new(FlankTable::new(&grid, Interpolation::Spline).unwrap());
        let laws = FlankLaws { drive, coast: None };
        let mut noise = Noise::new(6);
        let mut tried = 0;
        for formulation in [Formulation::Paper, Formulation::Conjugate] {
            for pair in three_pairs(-1.0) {
                for (s, loaded_flank) in [(1.0, LoadedFlank::Drive), (-1.0, LoadedFlank::Coast)] {
                    let parameters = Parameters {
                        formulation,
                        loaded_flank,
                        damping: 1e5,
                        ..Parameters::default()
                    };
                    let element = Element::with_laws(&pair, &parameters, &laws).unwrap();
                    for _ in 0..6 {
                        // Inside the table: +-3 mrad, +-100 um, some 8 um above the first touch.
                        let mut inputs = compressed(&element, s, 6e-6 + 1e-6 * noise.next());
                        let tilt = noise.vector(1e-4);
                        inputs.gears[1].r = Rotation3::new(tilt).matrix() * inputs.gears[1].r;
                        inputs.gears[1].p += noise.vector(1e-6);
                        set_velocities(&mut inputs, &mut noise);
                        let latch = element.latch(&element.nominal_inputs()).unwrap();
                        let out = element.evaluate(&latch, &inputs).unwrap();
                        if out.flank == 0 || out.out_of_range {
                            continue;
                        }
                        tried += 1;
                        // mesh.stiffness: a second derivative of a C2 force, differentiated itself.
                        compare(&element, &inputs, &mut noise, 1e-6, 1e-3);
                    }
                }
            }
        }
        assert!(
            tried >= 36,
            "only {tried} poses in contact inside the table"
        );
    }
}
