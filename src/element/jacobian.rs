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
use super::motion::{CONTINUOUS_OUTPUTS, Inputs, LEADING_OUTPUTS, Latch, Motion};
use super::{Element, Formulation, check};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

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
        let jacobian = self.jacobian(latch, inputs)?;
        Ok((jacobian * direction.to_vector()).into())
    }

    /// All partial derivatives of the continuous outputs at `inputs`.
    ///
    /// Exact; under a law that does not give [`Potential::stiffness_gradient`](crate::table::Potential),
    /// the derivative of `stiffness` takes it by central differences. At the kinks of the law (first touch of constant
    /// stiffness, the paper's clamped damping) it is that of the side the value is taken on.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn jacobian(&self, latch: &Latch, inputs: &Inputs) -> Result<Jacobian, ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        match self.parameters.formulation {
            Formulation::Conjugate => self.jacobian_over::<6>(latch, inputs),
            Formulation::Paper => self.jacobian_over::<9>(latch, inputs),
        }
    }

    /// With `N` dual parts: 3 translations and 3 rotations of gear 2, then 3 rotations of the carrier if it counts.
    fn jacobian_over<const N: usize>(
        &self,
        latch: &Latch,
        inputs: &Inputs,
    ) -> Result<Jacobian, ElementError> {
        let [g1, g2] = &inputs.gears;
        let seeded = Inputs {
            gears: [seed::<N>(g1, None, None), seed(g2, Some(0), Some(3))],
            carrier: seed(&inputs.carrier, None, (N > 6).then_some(6)),
        };
        let mut jacobian = Jacobian::zeros();
        let solution = evaluate(self, latch, &seeded)?;
        if let Some(mesh) = &solution.mesh {
            self.by_velocities(mesh, &mut jacobian);
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
        by_gear_1(&mut jacobian, &rows.map(|y| y.re), inputs);
        Ok(jacobian)
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
            let unit = stacked(&map.loads(&along_approach(flank.sign, flank.damping_arm.re, 1.0)));
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
            let spin = stacked(&map.loads(&Coordinates {
                mesh_angle: -1.0,
                ..along_approach(1.0, 0.0, 0.0)
            }));
            for (i, rubbing) in mesh.rubbing.iter().enumerate() {
                let Some(rubbing) = rubbing else { continue };
                let slopes = friction.by_velocities(rubbing);
                let unit = stacked(&slopes.row);
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
        let unit = stacked(&map.loads(&Coordinates {
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

/// `m` whose translations are the dual parts from `translation` on, and its rotations those from `rotation` on.
fn seed<const N: usize>(
    m: &Motion,
    translation: Option<usize>,
    rotation: Option<usize>,
) -> Motion<Dual<N>> {
    let mut out = Motion {
        p: m.p.map(Dual::from),
        r: m.r.map(Dual::from),
        v: m.v.map(Dual::from),
        w: m.w.map(Dual::from),
    };
    if let Some(first) = translation {
        for i in 0..3 {
            out.p[i].eps[first + i] = 1.0;
        }
    }
    if let Some(first) = rotation {
        let axes: [Vector3<f64>; 3] = [Vector3::x(), Vector3::y(), Vector3::z()];
        for (k, axis) in axes.iter().enumerate() {
            let turn: Matrix3<f64> = axis.cross_matrix() * m.r;
            for (entry, slope) in out.r.iter_mut().zip(turn.iter()) {
                entry.eps[first + k] = *slope;
            }
        }
    }
    out
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

#[cfg(test)]
mod tests {
    use super::super::testing::{
        LAWS, Noise, compressed, random_pose, rubbing, rubbing_table, three_pairs,
    };
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

    /// Exact derivatives at `inputs` along a random direction, against finite
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
        // Truncation, of fourth order, stays below the bound at every pose of the sequence, and rounding far below.
        let h = 1e-8;
        let side = |h: f64| {
            let out = element.evaluate(&latch, &moved(inputs, &direction, h));
            SVector::from(out.unwrap().to_array())
        };
        let rough = (8.0 * (side(h) - side(-h)) - (side(2.0 * h) - side(-2.0 * h))) / (12.0 * h);
        let value = side(0.0);
        let jacobian = element.jacobian(&latch, inputs).unwrap();
        let along = direction.to_vector();
        // Outputs of one kind share a scale: forces, moments, then each scalar its own. It is that of the terms
        // which add up to the derivative, or of the value where that is larger.
        for row in 0..CONTINUOUS_OUTPUTS {
            let group = if row < 15 {
                row / 3 * 3..row / 3 * 3 + 3
            } else {
                row..row + 1
            };
            let terms = |i: usize| {
                jacobian
                    .row(i)
                    .transpose()
                    .component_mul(&along)
                    .abs()
                    .sum()
            };
            let scale = group
                .map(|i| terms(i).max(value[i].abs()))
                .fold(0.0, f64::max);
            let bar = if row == STIFFNESS_ROW {
                stiffness_bar
            } else {
                bar
            };
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
    fn derivatives_with_friction_agree_with_finite_differences() {
        let mut noise = Noise::new(8);
        for formulation in [Formulation::Paper, Formulation::Conjugate] {
            for pair in three_pairs(1.0) {
                for law in LAWS {
                    let parameters = Parameters {
                        damping: 1e5,
                        friction_transition_speed: 0.05,
                        ..rubbing(formulation, LoadedFlank::Drive)
                    };
                    let table = rubbing_table(&pair, law, false);
                    let element = Element::new(&pair, &parameters, Some(table)).unwrap();
                    for _ in 0..4 {
                        let mut inputs = compressed(&element, 1.0, 8e-6 + 1e-6 * noise.next());
                        set_velocities(&mut inputs, &mut noise);
                        // Where the faces are flush the paper's (19) has a kink.
                        inputs.gears[1].p.z += 2e-4;
                        for m in &mut inputs.gears {
                            m.w *= 1e3;
                        }
                        compare(&element, &inputs, &mut noise, 2e-6, 2e-3);
                    }
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
