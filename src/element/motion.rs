//! What goes into the element and what comes out of it, and why there is nothing.

use super::dual::Scalar;
use crate::table::TableError;
use nalgebra::{Matrix3, Vector3};

/// Why an element cannot be made, or has no outputs at a pose. The text names the parameter or the body, its value and what
/// would be right.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ElementError {
    /// No pose helps: a parameter without meaning, or one that asks for what the pair, its table or its contact lacks.
    #[error("{0}")]
    Parameter(String),
    /// The pose has no meaning, or is no mesh.
    #[error("{0}")]
    Pose(String),
    /// The law of a flank has no potential at the pose.
    #[error("{0}")]
    Law(String),
}

impl ElementError {
    /// The parameter `name` of the FMU has no meaning with `value`, which has its unit.
    pub(crate) fn parameter(name: &str, value: &str, remedy: &str) -> Self {
        Self::Parameter(format!("{name} = {value}: {remedy}"))
    }
}

impl From<TableError> for ElementError {
    fn from(error: TableError) -> Self {
        Self::Parameter(error.to_string())
    }
}

/// Departure from an orthonormal right-handed matrix above which an orientation is refused.
const ROTATION_TOLERANCE: f64 = 1e-6;

/// Pose and velocity of one body in the world frame W, SI.
///
/// The body frame of a gear has its origin on the axis in the z = 0 face and z along the axis; the z
/// axes of both gears point alike. Body +x at z = 0 passes through a tooth centre (ring: a space
/// centre); only the `absolute` phase reference looks at that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// p_WG: origin of the body, m.
    pub p: Vector3<f64>,
    /// R_WG: columns are the body's axes in W.
    pub r: Matrix3<f64>,
    /// Velocity of the origin, m/s.
    pub v: Vector3<f64>,
    /// Angular velocity in W, rad/s.
    pub w: Vector3<f64>,
}

impl Motion {
    /// Refuses numbers that are not finite and an orientation that is no rotation, in the name of `body`.
    pub(crate) fn check(&self, body: &str) -> Result<(), ElementError> {
        let (x, y, z) = (self.r.column(0), self.r.column(1), self.r.column(2));
        let third = x.cross(&y) - z;
        let lengths = [x.norm_squared() - 1.0, y.norm_squared() - 1.0];
        let departures =
            [lengths[0], lengths[1], x.dot(&y), third.x, third.y, third.z].map(f64::abs);
        let departure = departures.iter().sum::<f64>();
        // One comparison on the usual path: zero times a sum is NaN if one of its terms is not finite.
        let sum = self.p.sum() + self.v.sum() + self.w.sum();
        if departure + 0.0 * sum <= ROTATION_TOLERANCE {
            return Ok(());
        }
        let parts = [
            ("position", self.p.sum()),
            ("orientation", self.r.sum()),
            ("velocity", self.v.sum()),
            ("angular velocity", self.w.sum()),
            ("their sum", sum),
        ];
        let bad = parts.iter().find(|(_, sum)| !sum.is_finite());
        let reason = match bad {
            Some((quantity, _)) => format!(
                "{quantity} is not finite; every position and velocity must be a finite number"
            ),
            None => format!(
                "the orientation is no rotation (it departs from an orthonormal, right-handed matrix by {departure:.1e}); \
                 normalise the quaternion or rebuild the matrix"
            ),
        };
        Err(ElementError::Pose(format!("{body}: {reason}")))
    }
}

impl Default for Motion {
    /// At rest at the origin with axes parallel to the world's.
    fn default() -> Self {
        Self {
            p: Vector3::zeros(),
            r: Matrix3::identity(),
            v: Vector3::zeros(),
            w: Vector3::zeros(),
        }
    }
}

/// Motion of everything the element looks at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Gear 1 and gear 2.
    pub gears: [Motion; 2],
    /// The carrier; looked at by [`super::Formulation::Paper`] alone.
    pub carrier: Motion,
}

/// Contact loads and diagnostics.
///
/// Forces and moments are those on the gears by the contact, in world axes; `force[0] = -force[1]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs<T: Scalar = f64> {
    /// Force on gear 1 and gear 2, N.
    pub force: [Vector3<T>; 2],
    /// Moment on each gear about that gear's own origin, N m.
    pub moment: [Vector3<T>; 2],
    /// Where the resultant crosses the pitch plane, m, W. Out of contact: the pitch point at mid-face.
    pub contact_point: Vector3<T>,
    /// Transmission error, m, tangential at the operating pitch circle; > 0: gear 1 is ahead in its
    /// positive sense, so the drive flank is compressed. Zero where the unmodified involutes of the loaded
    /// flank just touch (both flanks: of the drive flank).
    pub transmission_error: T,
    /// Its rate, m/s.
    pub transmission_error_rate: T,
    /// Position on the mesh cycle of the flank in `flank` (none: of the loaded flank), 0..1.
    pub mesh_position: T,
    /// Distance of the axes in the transverse plane, m.
    pub center_distance: T,
    /// Misalignment in the plane of action of the flank in `flank`, rad.
    pub misalignment: T,
    /// Transverse tangential force at the operating pitch circle, N, >= 0; with both flanks pressed
    /// the sum of both.
    pub tangential_force: T,
    /// Force normal to the flanks, N, >= 0; both flanks pressed: the sum.
    pub normal_force: T,
    /// Tangent stiffness dF_tt/dDTE, N/m, without damping.
    pub stiffness: T,
    /// Axial position of the contact point in gear 1's frame, m.
    pub contact_z: T,
    /// Elastic energy stored in the mesh, J; in the paper's formulation that of the law, though the
    /// loads there are not its gradient.
    pub energy: T,
    /// Power of friction on both gears, W, <= 0; 0 where the effect is off.
    pub friction_power: T,
    /// Coefficient of friction in force on the flank in `flank`; 0 without load or where friction is off.
    pub friction_coefficient: T,
    /// Part of the transmitted power that friction would take at a coefficient of 1, in this mesh position
    /// and under this load; 0 likewise.
    pub loss_factor: T,
    /// Largest principal stress in the fillets of gear 1 and gear 2 beside their loaded flanks, over face, fillet and
    /// all teeth under load, Pa: that of the static contact under the elastic force, without the damper's. Both flanks
    /// pressed: the larger one; 0 without load or where it is off.
    pub root_stress: [T; 2],
    /// Flank of gear 1 that carries (the larger force): +1 drive, -1 coast, 0 none.
    pub flank: i32,
    /// An operating condition of a flank that carries (of the reference flank if none does) lies outside the table, or the gears
    /// are on their way out of mesh.
    pub out_of_range: bool,
}

/// Number of outputs of the FMU, in the order of [`Outputs::to_array`].
pub const CONTINUOUS_OUTPUTS: usize = 31;

impl<T: Scalar> Outputs<T> {
    /// All outputs of the FMU in its order: force and moment of gear 1, force and moment of
    /// gear 2, contact point, then the scalars from `transmission_error` to `contact_z`, `flank` and `out_of_range` (0 or 1)
    /// as steps without slopes, those of friction and the stress in both roots (`energy` is left out: the FMU does not show it).
    #[inline(always)]
    pub fn to_array(&self) -> [T; CONTINUOUS_OUTPUTS] {
        let ([f1, f2], [m1, m2]) = (self.force, self.moment);
        let mut rows = [T::from(0.0); CONTINUOUS_OUTPUTS];
        let (vectors, scalars) = rows.split_at_mut(15);
        for (row, v) in vectors
            .chunks_exact_mut(3)
            .zip([f1, m1, f2, m2, self.contact_point])
        {
            row.copy_from_slice(v.as_slice());
        }
        scalars.copy_from_slice(&[
            self.transmission_error,
            self.transmission_error_rate,
            self.mesh_position,
            self.center_distance,
            self.misalignment,
            self.tangential_force,
            self.normal_force,
            self.stiffness,
            self.contact_z,
            T::from(f64::from(self.flank)),
            T::from(f64::from(u8::from(self.out_of_range))),
            self.friction_power,
            self.friction_coefficient,
            self.loss_factor,
            self.root_stress[0],
            self.root_stress[1],
        ]);
        rows
    }
}

/// Phase offsets, taken once from the initial pose. They belong to the state of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PhaseOffset<T = f64> {
    /// Added to the tooth angle z1 (theta1 - gamma) + e z2 (theta2 - gamma), rad; 2 pi is one pitch.
    pub tooth_angle: T,
    /// Added to the mesh position of the drive flank (taken off the coast flank's), base pitches.
    pub mesh_position: T,
}
