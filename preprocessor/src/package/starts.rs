//! Start values of a packed unit: a valid mesh of its pair, and what belongs to the pair.

use std::f64::consts::{PI, TAU};

use super::PackageError;
use super::coupling::{Coupling, digits};
use super::settings::Setting;
use super::stiffness::Stiffness;
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{Table, TableError, TableFile, TeethRecord};

/// Numbers of the enumerations' items, as in modelDescription.xml.
const CONSTANT: f64 = 1.0;
pub(super) const TABLE: f64 = 2.0;
pub(super) const CONTACT: f64 = 3.0;
const TEETH: f64 = 4.0;
const BOTH_FLANKS: f64 = 3.0;
const ABSOLUTE: f64 = 2.0;
const HELD: f64 = 1.0;
pub(super) const SEQUENTIAL: f64 = 2.0;
const PARALLEL: f64 = 3.0;

/// Start values of a unit that belong to its pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Starts {
    /// Nominal torque on gear 1, N m, > 0.
    pub nominal_torque: f64,
    /// Tangential mesh stiffness; its mean is `constantStiffness`.
    pub stiffness: Stiffness,
    /// Whether the unit carries tables: `stiffnessModel` then starts as `table`.
    pub table: bool,
    /// Whether they tell teeth apart: it then starts as `teeth`.
    pub teeth: bool,
    /// Whether the tables have an axis of the centre distance.
    pub center_distance: bool,
    /// Whether the tables have an axis of the misalignment.
    pub misalignment: bool,
    /// Whether the tables know the shuttling moment.
    pub shuttling: bool,
    /// What the user wants otherwise; the last of a name counts.
    pub settings: Vec<Setting>,
}

impl Starts {
    /// A unit of constant stiffness, estimated by [`super::estimated_stiffness`].
    pub fn constant_stiffness(geometry: &PairGeometry, nominal_torque: f64) -> Self {
        Self {
            nominal_torque,
            stiffness: Stiffness::estimated(geometry, nominal_torque),
            table: false,
            teeth: false,
            center_distance: false,
            misalignment: false,
            shuttling: false,
            settings: Vec::new(),
        }
    }

    /// A unit with these tables: every effect that they have an axis for is on.
    ///
    /// # Errors
    /// Tables that cannot be interpolated.
    pub fn of_tables(file: &TableFile) -> Result<Self, TableError> {
        let table = Table::from_file(file.clone())?;
        let effects = *table.effects();
        let moments = &file.drive.moment;
        Ok(Self {
            nominal_torque: file.nominal_torque_nm,
            stiffness: Stiffness::of_table(&table),
            table: true,
            teeth: file.teeth.as_ref().is_some_and(TeethRecord::tells_apart),
            center_distance: effects.center_distance,
            misalignment: effects.misalignment,
            shuttling: effects.misalignment || moments.iter().flatten().any(|m| *m != 0.0),
            settings: Vec::new(),
        })
    }

    /// The same with these `settings`.
    #[must_use]
    pub fn with(mut self, settings: &[Setting]) -> Self {
        self.settings.extend_from_slice(settings);
        self
    }

    /// What the user set for the variable `i`.
    fn set(&self, i: usize) -> Option<f64> {
        let last = self.settings.iter().rev().find(|s| s.index == i);
        last.map(|s| s.value)
    }

    /// Dynamics of the mesh with the stiffness and the damping that the unit starts with.
    pub fn coupling(&self, geometry: &PairGeometry) -> Coupling {
        let constant = self.set(index::CONSTANT_STIFFNESS);
        let is_constant = self
            .set(index::STIFFNESS_MODEL)
            .map_or(!self.table, |model| model == CONSTANT);
        let stiffness = if is_constant {
            Stiffness::constant(constant.unwrap_or(self.stiffness.mean))
        } else {
            self.stiffness
        };
        Coupling {
            held: self.set(index::COUPLING) == Some(HELD),
            ..Coupling::new(geometry, stiffness, self.set(index::DAMPING))
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
        let coupling = self.coupling(geometry);
        let mut starts = vec![
            (index::GEAR2_POSITION_1, distance),
            (index::GEAR2_POSITION_3, geometry.gears[1].face_offset),
            (
                index::STIFFNESS_MODEL,
                match (self.table, self.teeth) {
                    (_, true) => TEETH,
                    (true, _) => TABLE,
                    _ => CONSTANT,
                },
            ),
            (
                index::CONSTANT_STIFFNESS,
                digits(self.stiffness.mean, 4, f64::round),
            ),
            (index::NOMINAL_TORQUE, self.nominal_torque),
            (index::CENTER_DISTANCE_EFFECT, on(self.center_distance)),
            (index::MISALIGNMENT_EFFECT, on(self.misalignment)),
            (index::SHUTTLING_EFFECT, on(self.shuttling)),
            (index::DAMPING, coupling.damping),
            // Wrong for a sequential master it damps; the other way round no step would be stable.
            (index::COUPLING, PARALLEL),
            (index::EFFECTIVE_MASS, coupling.effective_mass),
            // Tables serve both flanks: the coast flank has its own or is the drive flank's mirror image.
            (index::LOADED_FLANK, BOTH_FLANKS),
            // Along the operating pitch circle, as the pair file gives it.
            (
                index::BACKLASH,
                (geometry.backlash(distance) / cos_phi).max(0.0),
            ),
        ];
        if self.set(index::PHASE_REFERENCE) == Some(ABSOLUTE) && !self.sets_an_orientation() {
            // The teeth of gear 2 in the middle of the gaps of gear 1.
            let spin = meshing_spin(geometry);
            let (sin, cos) = (0.5 * spin).sin_cos();
            starts.extend([
                (index::GEAR2_ANGLES_3, spin),
                (index::GEAR2_QUATERNION_1, cos),
                (index::GEAR2_QUATERNION_4, sin),
            ]);
        }
        for setting in &self.settings {
            match starts.iter_mut().find(|(i, _)| *i == setting.index) {
                Some((_, value)) => *value = setting.value,
                None => starts.push((setting.index, setting.value)),
            }
        }
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

    /// Whether the user turned a gear.
    fn sets_an_orientation(&self) -> bool {
        let turned = |from: usize, to: usize| {
            let mut set = self.settings.iter();
            set.any(|s| (from..=to).contains(&s.index))
        };
        turned(index::GEAR1_ANGLES_1, index::GEAR1_QUATERNION_4)
            || turned(index::GEAR2_ANGLES_1, index::GEAR2_QUATERNION_4)
    }
}

/// Spin of gear 2, rad, at which its flanks stand in the middle of the gaps of gear 1, which has no
/// spin, when both lie as the start values say and phases are absolute.
pub fn meshing_spin(geometry: &PairGeometry) -> f64 {
    // A tooth centre of gear 1 stands on body +x and, if gear 1 is the ring, a space centre does. The
    // mesh lies at sc x from gear 1: at angle 0 or pi. Gear 2 must offer the opposite there.
    let [g1, g2] = &geometry.gears;
    let toward = |sign: f64| if sign > 0.0 { 0.0 } else { PI };
    let pitch = |z: f64| TAU / z;
    let (at1, at2) = (toward(geometry.sc()), toward(geometry.sc() * -geometry.e()));
    // Phase within the pitch, 0 at a tooth centre (ring: at a space centre), of what gear 1 offers.
    let phase1 = (at1 / pitch(g1.z())).rem_euclid(1.0);
    // An external tooth fills the ring's space: phases agree. Two external gears: half a pitch apart.
    let wanted = if geometry.e() > 0.0 {
        0.5 - phase1
    } else {
        phase1
    };
    // Gear 2's tooth stands on its +x in its own z = 0 face; the helix has turned it in that of gear 1.
    let helix = g2.hand * g2.helix_angle.tan() / g2.reference_radius();
    let present = ((at2 + helix * g2.face_offset) / pitch(g2.z())).rem_euclid(1.0);
    let turn = (present - wanted).rem_euclid(1.0);
    pitch(g2.z()) * if turn > 0.5 { turn - 1.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use gearmesh::element::{Element, LoadedFlank, Parameters, PhaseReference};
    use gearmesh::gear::GearKind;
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
            let mut pair = pair(z1, z2);
            pair.gears[1].face_offset = 1.5e-3;
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

    fn start(starts: &Starts, pair: &PairGeometry, i: usize) -> f64 {
        let starts = starts.of_variables(pair).unwrap();
        let found = starts.iter().filter(|(j, _)| *j == i).collect::<Vec<_>>();
        assert_eq!(found.len(), 1, "{}", VARIABLES[i].name);
        found[0].1
    }

    #[test]
    fn settings_replace_and_what_depends_on_them_follows() {
        let pair = pair(21, 30);
        let of = |texts: &[&str]| {
            let settings: Vec<Setting> = texts.iter().map(|t| t.parse().unwrap()).collect();
            Starts::constant_stiffness(&pair, 100.0).with(&settings)
        };
        let plain = of(&[]);
        let heavier = of(&["damping=5e3"]);
        assert_eq!(start(&heavier, &pair, index::DAMPING), 5e3);
        let held = |damping| of(&["coupling=held", damping]).coupling(&pair).step();
        assert!(held("damping=5e3") > held("damping=5e2"));
        assert_eq!(heavier.coupling(&pair).step(), plain.coupling(&pair).step());
        // Four times the stiffness: twice the damping at the same ratio.
        let four = 4.0 * start(&plain, &pair, index::CONSTANT_STIFFNESS);
        let stiffer = of(&[&format!("constantStiffness={four}")]);
        let [one, two] = [&plain, &stiffer].map(|s| start(s, &pair, index::DAMPING));
        assert_relative_eq!(two / one, 2.0, max_relative = 1e-2);
        let last = of(&["meshPhase=1", "meshPhase=2"]);
        assert_eq!(start(&last, &pair, index::MESH_PHASE), 2.0);
    }

    #[test]
    fn absolute_phases_bring_a_pose_that_meshes_unless_the_user_turned_a_gear() {
        let pair = pair(21, 30);
        let of = |texts: &[&str]| {
            let settings: Vec<Setting> = texts.iter().map(|t| t.parse().unwrap()).collect();
            Starts::constant_stiffness(&pair, 100.0).with(&settings)
        };
        let spin = meshing_spin(&pair);
        assert!(spin != 0.0);
        let absolute = of(&["phaseReference=absolute"]);
        assert_eq!(start(&absolute, &pair, index::GEAR2_ANGLES_3), spin);
        let sine = start(&absolute, &pair, index::GEAR2_QUATERNION_4);
        assert_relative_eq!(2.0 * sine.asin(), spin, max_relative = 1e-12);
        let own = of(&["phaseReference=absolute", "gear2.angles[3]=0.25"]);
        assert_eq!(start(&own, &pair, index::GEAR2_ANGLES_3), 0.25);
    }

    #[test]
    fn a_start_value_outside_its_range_is_refused_by_name() {
        let pair = pair(20, 20);
        let starts = Starts {
            nominal_torque: f64::NAN,
            ..Starts::constant_stiffness(&pair, 100.0)
        };
        let error = starts.of_variables(&pair).unwrap_err().to_string();
        assert!(error.contains("nominalTorque"), "{error}");
    }
}
