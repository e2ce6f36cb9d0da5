//! Exact derivatives of the outputs by poses and velocities.
//!
//! Loads are -J^T g. Their derivatives by the pose take the change of J and, through the Hessian of the law, that of g. All
//! of it hangs on seven scalars of the frame on the line of centres ([`super::map`]), whose slopes by the motions of gear 2
//! are closed forms; from there on the equations run over dual numbers. (The paper's formulation looks at the carrier, too: its
//! turning makes three more dual parts.) What gear 1 does follows, since moving everything alike moves the loads along.
//!
//! By the velocities the loads are linear through dampers and friction alone: -J^T B J, the outer product of one row a flank.

use super::constants::FLANKS;
use super::dual::Dual;
use super::error::ElementError;
use super::evaluate::{Mesh, evaluate};
use super::flank::along_approach;
use super::law::Workspace;
use super::map::{Coordinates, Spatial};
use super::motion::{CONTINUOUS_OUTPUTS, Inputs, Latch, row};
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

/// [`Jacobian`], column by column.
type Columns = [[f64; CONTINUOUS_OUTPUTS]; 3 * BODY_COLUMNS];

/// First columns of the bodies.
const GEAR_1: usize = 0;
const GEAR_2: usize = BODY_COLUMNS;
const CARRIER: usize = 2 * BODY_COLUMNS;

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
    /// Exact, but for the derivative of `stiffness`, which is by central differences. At the kinks of the law (first touch of constant
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
        self.slopes(
            Some(latch),
            inputs,
            true,
            jacobian,
            &mut Workspace::default(),
        )
    }

    /// As [`Element::jacobian`]; without `latch` with phases that follow the pose ([`Element::latch`]), and with the row of
    /// the stiffness only if `stiffness_slopes`: else it need not hold numbers.
    ///
    /// # Errors
    /// As there.
    pub(crate) fn slopes(
        &self,
        latch: Option<&Latch>,
        inputs: &Inputs,
        stiffness_slopes: bool,
        jacobian: &mut Jacobian,
        workspace: &mut Workspace,
    ) -> Result<(), ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        match self.parameters.formulation {
            Formulation::Conjugate => {
                self.slopes_over::<6>(latch, inputs, stiffness_slopes, jacobian, workspace)
            }
            Formulation::Paper => {
                self.slopes_over::<9>(latch, inputs, stiffness_slopes, jacobian, workspace)
            }
        }
    }

    /// With `N` dual parts: 3 translations and 3 rotations of gear 2, then 3 rotations of the carrier if it counts.
    fn slopes_over<const N: usize>(
        &self,
        latch: Option<&Latch>,
        inputs: &Inputs,
        stiffness_slopes: bool,
        jacobian: &mut Jacobian,
        workspace: &mut Workspace,
    ) -> Result<(), ElementError> {
        let latch = match latch {
            Some(latch) => Latch {
                tooth_angle: latch.tooth_angle.into(),
                mesh_position: latch.mesh_position.into(),
            },
            None => super::start::latch(self, inputs)?,
        };
        let solution = evaluate::<Dual<N>>(self, &latch, inputs, stiffness_slopes, workspace)?;
        let columns = &mut jacobian.data.0;
        let rows = solution.outputs.to_array();
        for lane in 0..6 {
            columns[GEAR_2 + lane] = rows.map(|y| y.eps[lane]);
        }
        for column in &mut columns[CARRIER..CARRIER + 6] {
            column.fill(0.0);
        }
        for lane in 6..N {
            columns[CARRIER + lane - 3] = rows.map(|y| y.eps[lane]);
        }
        by_gear_1(columns, &rows.map(|y| y.re), inputs);
        for body in [GEAR_1, GEAR_2, CARRIER] {
            for column in &mut columns[body + 6..body + BODY_COLUMNS] {
                column.fill(0.0);
            }
        }
        if let Some(mesh) = &solution.mesh {
            self.by_velocities(mesh, inputs, columns);
        }
        Ok(())
    }

    /// Adds what velocities do: to their columns, and to those of gear 1's rotation, which turns them along.
    fn by_velocities<const N: usize>(
        &self,
        mesh: &Mesh<Dual<N>>,
        inputs: &Inputs,
        columns: &mut Columns,
    ) {
        let k = &self.constants;
        let map = &mesh.map;
        let c = mesh.center_distance.re;
        let cos_phi = k.base_sum / c;
        // Loads of a wrench on gear 2 are minus the slopes of the rate that it acts along, too.
        let unit = |on_2: &Spatial<f64>| Unit::new(&map.on_gears(on_2), inputs);
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
            let unit = unit(&map.loads(&along_approach(flank.sign, flank.damping_arm.re, 1.0)));
            let scalars = [
                (row::TANGENTIAL_FORCE, -damper * cos_phi),
                (row::NORMAL_FORCE, -damper * k.per_cos_beta_b),
            ];
            unit.add(columns, &unit.times(-damper), &scalars);
        }
        if let Some(friction) = &self.friction {
            // Of gear 1 against the line of centres.
            let spin = unit(&map.loads(&Coordinates {
                mesh_angle: -1.0,
                ..along_approach(1.0, 0.0, 0.0)
            }));
            for (i, rubbing) in mesh.rubbing.iter().enumerate() {
                let Some(rubbing) = rubbing else { continue };
                let slopes = friction.by_velocities(rubbing);
                let unit = unit(&slopes.row);
                let by_speed = [(row::FRICTION_POWER, -slopes.power_by_speed)];
                unit.add(columns, &unit.times(-slopes.by_speed), &by_speed);
                let shown = if i == mesh.shown {
                    -slopes.coefficient_by_spin
                } else {
                    0.0
                };
                let by_spin = [
                    (row::FRICTION_POWER, -slopes.power_by_spin),
                    (row::FRICTION_COEFFICIENT, shown),
                ];
                spin.add(columns, &unit.times(-slopes.by_spin), &by_spin);
            }
        }
        let sign = FLANKS[self.reference_flank].sign();
        let elongation = mesh.flanks[self.reference_flank].elongation.re;
        let unit = unit(&map.loads(&Coordinates {
            center_distance: elongation * sign * k.per_base_sum,
            ..along_approach(sign, 0.0, sign * c * k.per_base_sum)
        }));
        unit.add(columns, &[], &[(row::TRANSMISSION_ERROR_RATE, -1.0)]);
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

/// A unit force along a rate of the gears against one another.
struct Unit {
    /// Force and moment on gear 1, then on gear 2: minus the slopes of the rate by velocity and angular velocity.
    loads: [f64; 12],
    /// Minus the slopes by gear 1's rotation, while velocities stay.
    rotation: Vector3<f64>,
}

impl Unit {
    fn new([on_1, on_2]: &[Spatial<f64>; 2], inputs: &Inputs) -> Self {
        let [g1, g2] = &inputs.gears;
        let parts = [on_1.linear, on_1.angular, on_2.linear, on_2.angular];
        let mut loads = [0.0; 12];
        for (load, part) in loads.as_chunks_mut().0.iter_mut().zip(parts) {
            *load = part.into();
        }
        Self {
            loads,
            // Turning both gears and their velocities alike changes no rate.
            rotation: on_1.linear.cross(&(g1.v - g2.v))
                + on_1.angular.cross(&g1.w)
                + on_2.angular.cross(&g2.w),
        }
    }

    /// The loads of `force` along the rate.
    fn times(&self, force: f64) -> [f64; 12] {
        self.loads.map(|load| load * force)
    }

    /// Adds what the outputs change with the rate. Minus their slopes by it are `rows`, of the first outputs, and `scalars`, each with its row.
    #[inline(always)]
    fn add<const L: usize, const S: usize>(
        &self,
        columns: &mut Columns,
        rows: &[f64; L],
        scalars: &[(usize, f64); S],
    ) {
        let mut add = |column: usize, slope: f64| {
            let column = &mut columns[column];
            for (entry, row) in column.iter_mut().zip(rows) {
                *entry += slope * row;
            }
            for (row, scalar) in scalars {
                column[*row] += slope * scalar;
            }
        };
        for i in 0..6 {
            add(GEAR_1 + 6 + i, self.loads[i]);
            add(GEAR_2 + 6 + i, self.loads[6 + i]);
        }
        for i in 0..3 {
            add(GEAR_1 + 3 + i, self.rotation[i]);
        }
    }
}

/// Columns of gear 1's pose at rest: moved alike, gears (and carrier) keep their scalars, and the vectors move along.
fn by_gear_1(columns: &mut Columns, values: &[f64; CONTINUOUS_OUTPUTS], inputs: &Inputs) {
    let [g1, g2] = &inputs.gears;
    let apart = g2.p - g1.p;
    for axis in 0..3 {
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut translated = [0.0; CONTINUOUS_OUTPUTS];
        let mut turned = [0.0; CONTINUOUS_OUTPUTS];
        let [shift, x, y] = [axis, next, last].map(|i| &columns[GEAR_2 + i]);
        let (turn, carrier) = (&columns[GEAR_2 + 3 + axis], &columns[CARRIER + 3 + axis]);
        for row in 0..CONTINUOUS_OUTPUTS {
            translated[row] = -shift[row];
            // Less the change e_axis x apart of what is held fixed in the other columns.
            turned[row] = apart[last] * x[row] - apart[next] * y[row] - turn[row] - carrier[row];
        }
        translated[row::CONTACT_POINT + axis] += 1.0;
        for first in (0..=row::CONTACT_POINT).step_by(3) {
            // e_axis x vector.
            let origin = if first == row::CONTACT_POINT {
                g1.p
            } else {
                Vector3::zeros()
            };
            turned[first + next] -= values[first + last] - origin[last];
            turned[first + last] += values[first + next] - origin[next];
        }
        columns[GEAR_1 + axis] = translated;
        columns[GEAR_1 + 3 + axis] = turned;
    }
}
