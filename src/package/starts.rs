//! Start values of a packed unit: a valid mesh of its pair.

use std::f64::consts::FRAC_PI_2;

use super::PackageError;
use crate::fmi::variables::{VARIABLES, index};
use crate::gear::PairGeometry;

/// Mean mesh stiffness of a steel pair per face width and contact ratio, ISO 6336-1: c' of a
/// standard basic rack, N/m per m of face (14 N/(mm um)).
const SINGLE_STIFFNESS: f64 = 14e9;

/// Young's modulus that [`SINGLE_STIFFNESS`] holds for, Pa.
const STEEL: f64 = 206e9;

/// Start values of a unit that belong to its pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Starts {
    /// Nominal torque on gear 1, N m, > 0.
    pub nominal_torque: f64,
    /// Tangential mesh stiffness, N/m, > 0, of `stiffnessModel = constant`.
    pub constant_stiffness: f64,
    /// Whether the unit carries tables: `stiffnessModel` then starts as `table`.
    pub table: bool,
    /// Whether the tables have an axis of the centre distance.
    pub center_distance: bool,
    /// Whether the tables have an axis of the misalignment.
    pub misalignment: bool,
    /// Whether the tables know the shuttling moment.
    pub shuttling: bool,
}

impl Starts {
    /// A unit of constant stiffness, estimated by [`estimated_stiffness`].
    pub fn constant_stiffness(geometry: &PairGeometry, nominal_torque: f64) -> Self {
        Self {
            nominal_torque,
            constant_stiffness: estimated_stiffness(geometry),
            table: false,
            center_distance: false,
            misalignment: false,
            shuttling: false,
        }
    }

    /// Start values by index in [`VARIABLES`], checked against the ranges there.
    pub(super) fn of_variables(
        &self,
        geometry: &PairGeometry,
    ) -> Result<Vec<(usize, f64)>, PackageError> {
        let distance = geometry.center_distance;
        let cos_phi = geometry.operating_pressure_angle(distance).cos();
        let on = |flag: bool| f64::from(u8::from(flag));
        let starts = vec![
            (index::GEAR2_POSITION_1, distance),
            (index::GEAR2_POSITION_3, geometry.gears[1].face_offset),
            (index::STIFFNESS_MODEL, if self.table { 2.0 } else { 1.0 }),
            (index::CONSTANT_STIFFNESS, self.constant_stiffness),
            (index::NOMINAL_TORQUE, self.nominal_torque),
            (index::CENTER_DISTANCE_EFFECT, on(self.center_distance)),
            (index::MISALIGNMENT_EFFECT, on(self.misalignment)),
            (index::SHUTTLING_EFFECT, on(self.shuttling)),
            // Along the operating pitch circle, as the pair file gives it.
            (
                index::BACKLASH,
                (geometry.backlash(distance) / cos_phi).max(0.0),
            ),
        ];
        for &(i, value) in &starts {
            let variable = &VARIABLES[i];
            let positive = [index::CONSTANT_STIFFNESS, index::NOMINAL_TORQUE].contains(&i);
            let inside = value.is_finite()
                && variable.min.is_none_or(|m| value >= m)
                && variable.max.is_none_or(|m| value <= m);
            if !inside || (positive && value <= 0.0) {
                return Err(PackageError::Start {
                    name: variable.name,
                    value,
                    remedy: "it must be finite and positive".into(),
                });
            }
        }
        Ok(starts)
    }
}

/// Tangential mesh stiffness of the pair by the approximation of ISO 6336-1,
/// c_gamma = c' (0.75 epsilon_alpha + 0.25) times the common face width, N/m, scaled with the mean of
/// the Young's moduli: a start value to be replaced by a table, not a result.
pub fn estimated_stiffness(geometry: &PairGeometry) -> f64 {
    let distance = geometry.center_distance;
    let ratio = geometry.transverse_contact_ratio(distance).max(1.0);
    let (_, width) = geometry.face_overlap();
    let [e1, e2] = [0, 1].map(|i| geometry.gears[i].youngs_modulus);
    let modulus = 2.0 * e1 * e2 / (e1 + e2);
    let loa = SINGLE_STIFFNESS * (0.75 * ratio + 0.25) * width * modulus / STEEL;
    loa * geometry.operating_pressure_angle(distance).cos().powi(2)
}

/// Spin of gear 2, rad, at which its flanks stand in the middle of the gaps of gear 1, which has no
/// spin, when both lie as the start values say and phases are absolute.
pub fn meshing_spin(geometry: &PairGeometry) -> f64 {
    // A tooth centre of gear 1 stands on body +x and, if gear 1 is the ring, a space centre does. The
    // mesh lies at sc x from gear 1: at angle 0 or pi. Gear 2 must offer the opposite there.
    let [g1, g2] = &geometry.gears;
    let toward = |sign: f64| if sign > 0.0 { 0.0 } else { 2.0 * FRAC_PI_2 };
    let pitch = |z: f64| 4.0 * FRAC_PI_2 / z;
    let (at1, at2) = (toward(geometry.sc()), toward(geometry.sc() * -geometry.e()));
    // Phase within the pitch, 0 at a tooth centre (ring: at a space centre), of what gear 1 offers.
    let phase1 = (at1 / pitch(g1.z())).rem_euclid(1.0);
    // An external tooth fills the ring's space: phases agree. Two external gears: half a pitch apart.
    let wanted = if geometry.e() > 0.0 {
        0.5 - phase1
    } else {
        phase1
    };
    let present = (at2 / pitch(g2.z())).rem_euclid(1.0);
    let turn = (present - wanted).rem_euclid(1.0);
    pitch(g2.z()) * if turn > 0.5 { turn - 1.0 } else { turn }
}
