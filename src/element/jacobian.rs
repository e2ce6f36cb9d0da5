//! Exact derivatives of the outputs by poses and velocities: the equations run over dual numbers, whose directions are the
//! motions of gear 2 and the turning of the carrier. What gear 1 does follows, since moving everything alike moves the loads
//! along, and a velocity that all bodies share changes nothing.

use super::Element;
use super::contact::Solution;
use super::dual::{Dual, part};
use super::law::Workspace;
use super::motion::{CONTINUOUS_OUTPUTS, ElementError, Inputs, PhaseOffset};
use crate::vector::Lanes;
use nalgebra::{SMatrix, SVector, Vector3};

/// Columns of one body in [`Jacobian`]: position, rotation, velocity, angular velocity.
pub const BODY_COLUMNS: usize = 12;

/// Rows: [`Outputs::to_array`](super::Outputs::to_array). Columns: gear 1, gear 2, carrier, each as position (m), rotation
/// vector in world axes (rad), velocity (m/s), angular velocity (rad/s).
pub type Jacobian = SMatrix<f64, CONTINUOUS_OUTPUTS, { 3 * BODY_COLUMNS }>;

/// Change of all motions, in the order of the columns of [`Jacobian`].
pub type Direction = SVector<f64, { 3 * BODY_COLUMNS }>;

/// First columns of the bodies, and of the kinds of motion within them.
const GEAR_1: usize = 0;
const GEAR_2: usize = BODY_COLUMNS;
const CARRIER: usize = 2 * BODY_COLUMNS;
const POSITION: usize = 0;
const ROTATION: usize = 3;
const VELOCITY: usize = 6;
const SPIN: usize = 9;

/// First row of the contact point.
const CONTACT_POINT: usize = 12;

impl Element {
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
        phase: &PhaseOffset,
        inputs: &Inputs,
        jacobian: &mut Jacobian,
    ) -> Result<(), ElementError> {
        let workspace = &mut Workspace::default();
        self.slopes(Some(phase), inputs, true, jacobian, workspace)
    }

    /// As [`Element::jacobian`]; without `phase` with phases that follow the pose ([`Element::phase_offset`]), and with the row of
    /// the stiffness only if `stiffness_slopes`: else it may hold NaN.
    pub(crate) fn slopes(
        &self,
        phase: Option<&PhaseOffset>,
        inputs: &Inputs,
        stiffness_slopes: bool,
        jacobian: &mut Jacobian,
        workspace: &mut Workspace,
    ) -> Result<(), ElementError> {
        self.check(inputs)?;
        let phase: PhaseOffset<Dual> = match phase {
            Some(phase) => PhaseOffset {
                tooth_angle: phase.tooth_angle.into(),
                mesh_position: phase.mesh_position.into(),
            },
            None => self.phases(inputs)?,
        };
        Lanes::widest().run(
            #[inline(always)]
            |_| {
                let solution = Solution::new(self, &phase, inputs, stiffness_slopes, workspace)?;
                let rows = solution.outputs.to_array();
                let columns = &mut jacobian.data.0;
                for lane in 0..12 {
                    for (slope, y) in columns[GEAR_2 + lane].iter_mut().zip(&rows) {
                        *slope = y.eps[part::POSITION_2 + lane];
                    }
                    columns[CARRIER + lane].fill(0.0);
                }
                for axis in 0..3 {
                    for (slope, y) in columns[CARRIER + ROTATION + axis].iter_mut().zip(&rows) {
                        *slope = y.eps[part::CARRIER_ROTATION + axis];
                    }
                }
                by_gear_1(jacobian, &rows.each_ref().map(|y| y.re), inputs);
                Ok(())
            },
        )
    }
}

/// Columns of gear 1: all bodies moved, turned or sped up alike keep their scalars, and the vectors turn along.
#[inline(always)]
fn by_gear_1(jacobian: &mut Jacobian, values: &[f64; CONTINUOUS_OUTPUTS], inputs: &Inputs) {
    let [g1, g2] = &inputs.gears;
    let (apart, drift) = (g2.p - g1.p, g2.v - g1.v);
    let axes = [0, 1, 2].map(|axis| (axis, (axis + 1) % 3, (axis + 2) % 3));
    let mut combine = |into: usize, terms: &[(usize, f64)]| {
        let mut sum = [0.0; CONTINUOUS_OUTPUTS];
        for (column, factor) in terms {
            for (s, y) in sum.iter_mut().zip(&jacobian.data.0[*column]) {
                *s += factor * y;
            }
        }
        jacobian.data.0[GEAR_1 + into] = sum;
    };
    // Terms of the slopes from `first` on times -(e_axis x v).
    let (p2, r2) = (GEAR_2 + POSITION, GEAR_2 + ROTATION);
    let (v2, w2) = (GEAR_2 + VELOCITY, GEAR_2 + SPIN);
    for (axis, next, last) in axes {
        combine(POSITION + axis, &[(p2 + axis, -1.0)]);
        combine(VELOCITY + axis, &[(v2 + axis, -1.0)]);
        let [a, b] = [(v2 + next, apart[last]), (v2 + last, -apart[next])];
        combine(SPIN + axis, &[(w2 + axis, -1.0), a, b]);
    }
    for (axis, next, last) in axes {
        let mut terms = [(r2 + axis, -1.0); 10];
        terms[1] = (CARRIER + ROTATION + axis, -1.0);
        let moved = [(p2, apart), (v2, drift), (GEAR_1 + SPIN, g1.w), (w2, g2.w)];
        for (pair, (first, v)) in terms[2..].chunks_exact_mut(2).zip(moved) {
            pair.copy_from_slice(&[(first + next, v[last]), (first + last, -v[next])]);
        }
        combine(ROTATION + axis, &terms);
    }
    for (axis, next, last) in axes {
        jacobian[(CONTACT_POINT + axis, GEAR_1 + POSITION + axis)] += 1.0;
        for first in (0..=CONTACT_POINT).step_by(3) {
            let origin = if first == CONTACT_POINT {
                g1.p
            } else {
                Vector3::zeros()
            };
            // e_axis x vector.
            let column = GEAR_1 + ROTATION + axis;
            jacobian[(first + next, column)] -= values[first + last] - origin[last];
            jacobian[(first + last, column)] += values[first + next] - origin[next];
        }
    }
}
