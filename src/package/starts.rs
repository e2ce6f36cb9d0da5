//! Start values of a packed unit: a valid mesh of its pair.

use std::f64::consts::FRAC_PI_2;

use super::PackageError;
use crate::fmi::variables::{VARIABLES, index};
use crate::gear::{Flank, PairGeometry};
use crate::table::{Query, Table, TableError, TableFile};

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

    /// A unit with these tables: every effect that they have an axis for is on, and the constant
    /// stiffness is the secant one at nominal torque, mean over the mesh cycle.
    ///
    /// # Errors
    /// Tables that cannot be interpolated.
    pub fn of_tables(file: &TableFile) -> Result<Self, TableError> {
        let table = Table::from_file(file.clone())?;
        let effects = *table.effects();
        let moments = &file.drive.moment_nm;
        Ok(Self {
            nominal_torque: file.nominal_torque_nm,
            constant_stiffness: secant_stiffness(&table),
            table: true,
            center_distance: effects.center_distance,
            misalignment: effects.misalignment,
            shuttling: effects.misalignment || moments.iter().flatten().any(|m| *m != 0.0),
        })
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

/// Tangential stiffness nominal force over displacement at nominal torque, mean over the mesh
/// cycle, aligned, at the nominal centre distance, N/m.
fn secant_stiffness(table: &Table) -> f64 {
    const POSITIONS: usize = 16;
    let geometry = table.geometry();
    let force = table.file().nominal_torque_nm / geometry.gears[0].base_radius();
    let (flank, _) = table.flank(Flank::Drive);
    let total: f64 = (0..POSITIONS)
        .map(|i| {
            let query = |delta| Query {
                delta,
                center_distance_offset: 0.0,
                misalignment: 0.0,
                mesh_position: i as f64 / POSITIONS as f64,
            };
            // Force rises with displacement: bisect between separation and a displacement beyond.
            let (mut low, mut high) = (-1e-3, 1e-3);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if flank.evaluate(&query(middle), false).gradient[0] < force {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            high
        })
        .sum();
    let loa = force * POSITIONS as f64 / total;
    let phi = geometry.operating_pressure_angle(geometry.center_distance);
    loa * phi.cos().powi(2)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Element, LoadedFlank, Parameters, PhaseReference};
    use crate::gear::{GearKind, samples};
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use nalgebra::Rotation3;

    /// A pair without backlash of `z1` and `z2` teeth, module 2 mm, helix 15 deg; a negative count is a
    /// ring.
    fn pair(z1: i32, z2: i32) -> PairGeometry {
        let gear = |z: i32, hand: f64| {
            let kind = if z < 0 {
                GearKind::Ring
            } else {
                GearKind::External
            };
            samples::with_module(samples::gear(kind, z.unsigned_abs(), hand, 15.0, 0.0), 2e-3)
        };
        let e = f64::from(z1.signum() * z2.signum());
        let (g1, g2) = (gear(z1, 1.0), gear(z2, -e));
        PairGeometry {
            center_distance: (g1.reference_radius() + e * g2.reference_radius()).abs(),
            gears: [g1, g2],
        }
    }

    #[test]
    fn at_the_meshing_spin_absolute_phases_neither_press_nor_leave_a_gap() {
        for (z1, z2) in [
            (20, 20),
            (21, 30),
            (20, 31),
            (19, -60),
            (20, -61),
            (-60, 19),
            (-61, 20),
        ] {
            let pair = pair(z1, z2);
            for flank in [LoadedFlank::Drive, LoadedFlank::Coast] {
                let parameters = Parameters {
                    phase_reference: PhaseReference::Absolute,
                    loaded_flank: flank,
                    ..Parameters::default()
                };
                let element = Element::new(&pair, &parameters, None).unwrap();
                let mut inputs = element.nominal_inputs();
                let spin = Rotation3::from_euler_angles(0.0, 0.0, meshing_spin(&pair));
                inputs.gears[1].r = spin.into_inner();
                let latch = element.latch(&inputs).unwrap();
                let out = element.evaluate(&latch, &inputs).unwrap();
                assert_abs_diff_eq!(out.transmission_error, 0.0, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn the_estimate_agrees_with_the_papers_reference_pair() {
        // Table 2 of the paper: 4.35e8 N/m; the standard's approximation is good to a tenth.
        let paper = crate::gear::samples::paper_pair(1.0);
        assert_relative_eq!(estimated_stiffness(&paper), 4.35e8, max_relative = 0.05);
    }

    #[test]
    fn a_start_value_outside_its_range_is_refused_by_name() {
        let pair = pair(20, 20);
        let starts = Starts::constant_stiffness(&pair, f64::NAN);
        let error = starts.of_variables(&pair).unwrap_err().to_string();
        assert!(error.contains("nominalTorque"), "{error}");
    }
}
