//! Exact derivatives of the outputs by poses and velocities.
//!
//! Loads are -J^T g. Their derivatives by the pose take the change of J and, through the Hessian of the law,
//! that of g: the equations run over dual numbers that carry the motions of gear 2 (and the turning of the paper's
//! carrier). What gear 1 does follows, since moving everything alike moves the loads along. By the velocities the
//! loads are linear through the dampers alone: -J^T B J, the outer product of one row a flank.

use super::constants::FLANKS;
use super::dual::Dual;
use super::error::ElementError;
use super::evaluate::{Mesh, evaluate};
use super::flank::along_approach;
use super::map::{Coordinates, Spatial};
use super::motion::{CONTINUOUS_OUTPUTS, Inputs, LEADING_OUTPUTS, Latch};
use super::{Element, Formulation, check};
use nalgebra::{SMatrix, SVector, Vector3};

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

/// Rows: [`Outputs::to_array`](super::Outputs::to_array). Columns: gear 1, gear 2, carrier, each as position (m), rotation
/// vector in world axes (rad), velocity (m/s), angular velocity (rad/s).
pub type Jacobian = SMatrix<f64, CONTINUOUS_OUTPUTS, { 3 * BODY_COLUMNS }>;

impl Element {
    /// Derivative of the continuous outputs ([`Outputs::to_array`](super::Outputs::to_array)) at `inputs` along `direction`:
    /// [`Element::jacobian`] times the direction.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn directional_derivative(
        &self,
        latch: &Latch,
        inputs: &Inputs,
        direction: &InputsChange,
    ) -> Result<[f64; CONTINUOUS_OUTPUTS], ElementError> {
        let mut jacobian = Jacobian::zeros();
        self.jacobian(latch, inputs, &mut jacobian)?;
        let slopes: &Jacobian = &jacobian; // a product with the matrix itself would copy it
        Ok((slopes * direction.to_vector()).into())
    }

    /// Writes all partial derivatives of the continuous outputs at `inputs` into `jacobian`: in place, since copies of eight
    /// kilobytes are a share of the time. After an error its content has no meaning.
    ///
    /// Exact; under a law that does not give [`Potential::stiffness_gradient`](crate::table::Potential),
    /// the derivative of `stiffness` takes it by central differences. At the kinks of the law (first touch of constant
    /// stiffness, the paper's clamped damping) it is that of the side the value is taken on.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn jacobian(
        &self,
        latch: &Latch,
        inputs: &Inputs,
        jacobian: &mut Jacobian,
    ) -> Result<(), ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        jacobian.as_mut_slice().fill(0.0); // the matrix's own goes entry by entry
        match self.parameters.formulation {
            Formulation::Conjugate => self.jacobian_over::<6>(latch, inputs, jacobian),
            Formulation::Paper => self.jacobian_over::<9>(latch, inputs, jacobian),
        }
    }

    /// With `N` dual parts: 3 translations and 3 rotations of gear 2, then 3 rotations of the carrier if it counts.
    fn jacobian_over<const N: usize>(
        &self,
        latch: &Latch,
        inputs: &Inputs,
        jacobian: &mut Jacobian,
    ) -> Result<(), ElementError> {
        let solution = evaluate::<Dual<N>>(self, latch, inputs)?;
        if let Some(mesh) = &solution.mesh {
            self.by_velocities(mesh, jacobian);
        }
        let rows = solution.outputs.to_array();
        for (row, y) in rows.iter().enumerate() {
            for lane in 0..N {
                let column = match lane {
                    0..6 => BODY_COLUMNS + lane,
                    _ => 2 * BODY_COLUMNS + 3 + lane - 6,
                };
                jacobian[(row, column)] = y.eps[lane];
            }
        }
        by_gear_1(jacobian, &rows.map(|y| y.re), inputs);
        Ok(())
    }

    /// Columns of velocity and angular velocity.
    fn by_velocities<const N: usize>(&self, mesh: &Mesh<Dual<N>>, jacobian: &mut Jacobian) {
        const TANGENTIAL: usize = 20;
        const NORMAL: usize = 21;
        const TRANSMISSION_ERROR_RATE: usize = 16;
        let k = &self.constants;
        let map = &mesh.map;
        let c = mesh.center_distance.re;
        let cos_phi = k.base_sum / c;
        let row = |on_2: &Spatial<f64>| stacked(&map.on_gears(on_2));
        let mut add = |row: usize, unit: &SVector<f64, 12>, factor: f64| {
            for (i, value) in unit.iter().enumerate() {
                // Velocity and angular velocity of gear 1, then of gear 2.
                let column = i / 6 * BODY_COLUMNS + 6 + i % 6;
                jacobian[(row, column)] += factor * value;
            }
        };
        for flank in &mesh.flanks {
            if flank.elastic.re <= 0.0 {
                continue;
            }
            let rate = Dual::<1>::variable(flank.approach(&mesh.rates).re, 0);
            let constant = Dual::from;
            let damper = self
                .damper
                .force(constant(flank.elastic.re), rate, constant(cos_phi))
                .eps[0];
            // Minus the row of J: loads for a unit force against the rate.
            let unit = row(&map.loads(&along_approach(flank.sign, flank.damping_arm.re, 1.0)));
            for row in 0..12 {
                add(row, &unit, -damper * unit[row]);
            }
            add(TANGENTIAL, &unit, -damper * cos_phi);
            add(NORMAL, &unit, -damper * k.per_cos_beta_b);
        }
        if let Some(friction) = &self.friction {
            const POWER: usize = LEADING_OUTPUTS;
            const COEFFICIENT: usize = LEADING_OUTPUTS + 1;
            // Minus the row of the spin: of gear 1 against the line of centres.
            let spin = row(&map.loads(&Coordinates {
                mesh_angle: -1.0,
                ..along_approach(1.0, 0.0, 0.0)
            }));
            for (i, rubbing) in mesh.rubbing.iter().enumerate() {
                let Some(rubbing) = rubbing else { continue };
                let slopes = friction.by_velocities(rubbing);
                let unit = row(&slopes.row);
                for row in 0..12 {
                    add(row, &unit, -slopes.by_speed * unit[row]);
                    add(row, &spin, -slopes.by_spin * unit[row]);
                }
                add(POWER, &unit, -slopes.power_by_speed);
                add(POWER, &spin, -slopes.power_by_spin);
                if i == mesh.shown {
                    add(COEFFICIENT, &spin, -slopes.coefficient_by_spin);
                }
            }
        }
        let sign = FLANKS[self.reference_flank].sign();
        let elongation = mesh.flanks[self.reference_flank].elongation.re;
        let unit = row(&map.loads(&Coordinates {
            center_distance: elongation * sign * k.per_base_sum,
            ..along_approach(sign, 0.0, sign * c * k.per_base_sum)
        }));
        add(TRANSMISSION_ERROR_RATE, &unit, -1.0);
    }
}

impl InputsChange {
    /// In the order of the columns of [`Jacobian`].
    pub fn to_vector(&self) -> SVector<f64, { 3 * BODY_COLUMNS }> {
        let [g1, g2] = &self.gears;
        let parts = [g1, g2, &self.carrier].map(|m| [m.p, m.rotation, m.v, m.w]);
        SVector::from_fn(|i, _| parts[i / BODY_COLUMNS][i % BODY_COLUMNS / 3][i % 3])
    }
}

/// Linear and angular part of gear 1, then of gear 2.
fn stacked(both: &[Spatial<f64>; 2]) -> SVector<f64, 12> {
    let parts = [
        both[0].linear,
        both[0].angular,
        both[1].linear,
        both[1].angular,
    ];
    SVector::from_fn(|i, _| parts[i / 3][i % 3])
}

/// Columns of gear 1's pose: moved alike, gears (and carrier) keep their scalars, and the vectors move along.
fn by_gear_1(jacobian: &mut Jacobian, values: &[f64; CONTINUOUS_OUTPUTS], inputs: &Inputs) {
    const POINT: usize = 12;
    let [g1, g2] = &inputs.gears;
    let column = |body: usize, part: usize| BODY_COLUMNS * body + 3 * part;
    let moved = [
        (column(1, 0), g2.p - g1.p),
        (column(0, 2), g1.v),
        (column(0, 3), g1.w),
        (column(1, 2), g2.v),
        (column(1, 3), g2.w),
    ];
    for axis in 0..3 {
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        let of = |c: usize| {
            let start = CONTINUOUS_OUTPUTS * c;
            &jacobian.as_slice()[start..start + CONTINUOUS_OUTPUTS]
        };
        let mut translated = [0.0; CONTINUOUS_OUTPUTS];
        let mut turned = [0.0; CONTINUOUS_OUTPUTS];
        let (shift, turn, carrier) = (
            of(column(1, 0) + axis),
            of(column(1, 1) + axis),
            of(column(2, 1) + axis),
        );
        for row in 0..CONTINUOUS_OUTPUTS {
            translated[row] = -shift[row];
            turned[row] = -turn[row] - carrier[row];
        }
        for (first, vector) in &moved {
            // Less the change e_axis x vector of what is held fixed in the other columns.
            let (x, y) = (of(first + next), of(first + last));
            for row in 0..CONTINUOUS_OUTPUTS {
                turned[row] += vector[last] * x[row] - vector[next] * y[row];
            }
        }
        translated[POINT + axis] += 1.0;
        for first in (0..=POINT).step_by(3) {
            // e_axis x vector.
            let origin = if first == POINT {
                g1.p
            } else {
                Vector3::zeros()
            };
            turned[first + next] -= values[first + last] - origin[last];
            turned[first + last] += values[first + next] - origin[next];
        }
        jacobian.column_mut(axis).copy_from_slice(&translated);
        jacobian.column_mut(3 + axis).copy_from_slice(&turned);
    }
}
