//! Start values of a packed FMU: a valid mesh of its pair, what belongs to the pair, and what the user chooses for hosts
//! that cannot set it.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::str::FromStr;

use super::dynamics::{MeshDynamics, Stiffness};
use gearmesh::fmi::variables::{Causality, Kind, VARIABLES, Variable, index, index_by_name};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{Table, TableError, TableFile, TeethRecord};
use gearmesh::words::to_digits;

/// Numbers of the enumerations' items, as in modelDescription.xml.
const CONSTANT: f64 = 1.0;
pub(crate) const TABLE: f64 = 2.0;
pub(super) const CONTACT: f64 = 3.0;
pub(crate) const TEETH: f64 = 4.0;
const BOTH_FLANKS: f64 = 3.0;
const ABSOLUTE: f64 = 2.0;
pub(super) const HELD: f64 = 1.0;
pub(crate) const SEQUENTIAL: f64 = 2.0;
const AUTOMATIC: f64 = 4.0;

/// Start values of an FMU that belong to its pair.
#[derive(Debug)]
pub struct Starts {
    /// The tables made ready; `None` for an FMU of constant stiffness.
    pub(super) table: Option<Table>,
    /// Its mean is `constantStiffness`.
    stiffness: Stiffness,
    /// What the tables, or their absence, give, then what the user chooses; the last of a variable counts.
    settings: Vec<Setting>,
}

impl Starts {
    /// An FMU of constant stiffness, estimated after ISO 6336-1; `nominal_torque` on gear 1, N m, > 0.
    pub fn constant_stiffness(geometry: &PairGeometry, nominal_torque: f64) -> Self {
        Self {
            table: None,
            stiffness: Stiffness::estimated(geometry, nominal_torque),
            settings: vec![
                Setting::new(index::STIFFNESS_MODEL, CONSTANT),
                Setting::new(index::NOMINAL_TORQUE, nominal_torque),
            ],
        }
    }

    /// An FMU with these tables: every effect that they have an axis for is on.
    ///
    /// # Errors
    /// Tables that cannot be interpolated.
    pub fn of_tables(file: &TableFile) -> Result<Self, TableError> {
        let table = Table::from_file(file.clone())?;
        let effects = table.effects;
        let teeth = file.teeth.as_ref().is_some_and(TeethRecord::tells_apart);
        let moments = &file.drive.moment;
        let shuttling = effects.misalignment || moments.iter().flatten().any(|m| *m != 0.0);
        let settings = [
            (index::STIFFNESS_MODEL, if teeth { TEETH } else { TABLE }),
            (index::NOMINAL_TORQUE, file.nominal_torque_nm),
            (
                index::CENTER_DISTANCE_EFFECT,
                number(effects.center_distance),
            ),
            (index::MISALIGNMENT_EFFECT, number(effects.misalignment)),
            (index::SHUTTLING_EFFECT, number(shuttling)),
            (index::BODY_EFFECT, number(file.bodies.is_some())),
        ];
        Ok(Self {
            stiffness: Stiffness::of_table(&table),
            settings: settings.map(|(i, value)| Setting::new(i, value)).into(),
            table: Some(table),
        })
    }

    /// The same with these `settings`.
    #[must_use]
    pub fn with(mut self, settings: &[Setting]) -> Self {
        self.settings.extend_from_slice(settings);
        self
    }

    /// Value of the variable `i`, as far as tables and user give it.
    fn value(&self, i: usize) -> Option<f64> {
        let last = self.settings.iter().rev().find(|s| s.index == i);
        last.map(|s| s.value)
    }

    /// Dynamics of the mesh with the stiffness and the damping that the FMU starts with.
    pub fn dynamics(&self, geometry: &PairGeometry) -> MeshDynamics {
        let stiffness = if self.value(index::STIFFNESS_MODEL) == Some(CONSTANT) {
            let constant = self.value(index::CONSTANT_STIFFNESS);
            Stiffness::constant(constant.unwrap_or(self.stiffness.mean))
        } else {
            self.stiffness
        };
        MeshDynamics {
            held: self.value(index::COUPLING) == Some(HELD),
            ..MeshDynamics::new(geometry, stiffness, self.value(index::DAMPING))
        }
    }

    /// What is wrong with an effect of tables that is switched on where there are none: constant stiffness would go on without it,
    /// and say nothing.
    pub(super) fn check_effects(&self) -> Result<(), String> {
        let effects = [
            (
                index::CENTER_DISTANCE_EFFECT,
                " over a range of `operating.center_distance_offset_um`",
            ),
            (
                index::MISALIGNMENT_EFFECT,
                " over a range of `operating.misalignment_mrad`",
            ),
            (index::SHUTTLING_EFFECT, ""),
        ];
        let on = |i: usize| self.value(i) == Some(1.0);
        match effects.iter().find(|(i, _)| on(*i)) {
            Some((i, range)) if self.table.is_none() => Err(format!(
                "{} = true: the FMU has no tables, and constant stiffness has no such effect; make tables{range} with `gearmesh \
                 build`, or leave it at false",
                VARIABLES[*i].name
            )),
            _ => Ok(()),
        }
    }

    /// Start values by name.
    pub(crate) fn of_variables(&self, geometry: &PairGeometry) -> BTreeMap<String, f64> {
        let distance = geometry.center_distance;
        let cos_phi = geometry.operating_pressure_angle(distance).cos();
        let dynamics = self.dynamics(geometry);
        let stiffness = to_digits(self.stiffness.mean, 4, f64::round);
        // Along the operating pitch circle, as the pair file gives it.
        let backlash = (geometry.backlash(distance) / cos_phi).max(0.0);
        let mut starts = vec![
            (index::GEAR2_POSITION_1, distance),
            (index::GEAR2_POSITION_3, geometry.gears[1].face_offset),
            (index::CONSTANT_STIFFNESS, stiffness),
            (index::CENTER_DISTANCE_EFFECT, 0.0),
            (index::MISALIGNMENT_EFFECT, 0.0),
            (index::SHUTTLING_EFFECT, 0.0),
            (index::DAMPING, dynamics.damping),
            (index::COUPLING, AUTOMATIC),
            (index::EFFECTIVE_MASS, dynamics.effective_mass),
            // Tables serve both flanks: the coast flank has its own or is the drive flank's mirror image.
            (index::LOADED_FLANK, BOTH_FLANKS),
            (index::BACKLASH, backlash),
        ];
        let gear1 = index::GEAR1_ANGLES_1..=index::GEAR1_QUATERNION_4;
        let gear2 = index::GEAR2_ANGLES_1..=index::GEAR2_QUATERNION_4;
        let is_turned = self
            .settings
            .iter()
            .any(|s| gear1.contains(&s.index) || gear2.contains(&s.index));
        if self.value(index::PHASE_REFERENCE) == Some(ABSOLUTE) && !is_turned {
            // The teeth of gear 2 in the middle of the gaps of gear 1.
            let spin = meshing_spin(geometry);
            let (sin, cos) = (0.5 * spin).sin_cos();
            starts.extend([
                (index::GEAR2_ANGLES_3, spin),
                (index::GEAR2_QUATERNION_1, cos),
                (index::GEAR2_QUATERNION_4, sin),
            ]);
        }
        starts.extend(self.settings.iter().map(|s| (s.index, s.value)));
        starts
            .into_iter()
            .map(|(i, value)| (VARIABLES[i].name.to_owned(), value))
            .collect()
    }
}

/// A truth value as tables of start values have it.
fn number(flag: bool) -> f64 {
    f64::from(u8::from(flag))
}

/// Spin of gear 2, rad, at which its flanks stand in the middle of the gaps of gear 1, which has no
/// spin, when both lie as the start values say and phases are absolute.
pub fn meshing_spin(geometry: &PairGeometry) -> f64 {
    // A tooth centre of gear 1 stands on body +x and, if gear 1 is the ring, a space centre does. The
    // mesh lies at sc x from gear 1: at angle 0 or pi. Gear 2 must offer the opposite there.
    let [g1, g2] = &geometry.gears;
    let [at1, at2] = [geometry.sc(), geometry.sc() * -geometry.e()]
        .map(|sign| if sign > 0.0 { 0.0 } else { PI });
    let [pitch1, pitch2] = [g1, g2].map(|gear| TAU / gear.z());
    // Phase within the pitch, 0 at a tooth centre (ring: at a space centre), of what gear 1 offers.
    let phase1 = (at1 / pitch1).rem_euclid(1.0);
    // An external tooth fills the ring's space: phases agree. Two external gears: half a pitch apart.
    let needed = if geometry.e() > 0.0 {
        0.5 - phase1
    } else {
        phase1
    };
    // Gear 2's tooth stands on its +x in its own z = 0 face; the helix has turned it in that of gear 1.
    let helix = g2.hand * g2.helix_angle.tan() / g2.reference_radius();
    let present = ((at2 + helix * g2.face_offset) / pitch2).rem_euclid(1.0);
    let turn = (present - needed).rem_euclid(1.0);
    pitch2 * if turn > 0.5 { turn - 1.0 } else { turn }
}

/// A start value by the name of its variable: `damping=500`, `interpolation=shepard`, `coupling=held`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Index in [`VARIABLES`].
    index: usize,
    /// Value; a Boolean as 0 or 1, an item of an enumeration as its number.
    value: f64,
}

impl Setting {
    /// Contact at run time.
    pub const CONTACT: Self = Self::new(index::STIFFNESS_MODEL, CONTACT);
    /// Tooth pairs one by one.
    pub const TEETH: Self = Self::new(index::STIFFNESS_MODEL, TEETH);
    /// Friction on.
    pub const FRICTION: Self = Self::new(index::FRICTION, 1.0);
    /// Root stress on.
    pub const ROOT_STRESS: Self = Self::new(index::ROOT_STRESS, 1.0);

    const fn new(index: usize, value: f64) -> Self {
        Self { index, value }
    }

    /// Refuses `settings` that give a variable more than once; the error names both values.
    pub fn check_once(settings: &[Self]) -> Result<(), String> {
        for (k, later) in settings.iter().enumerate() {
            if let Some(first) = settings[..k].iter().find(|s| s.index == later.index) {
                return Err(format!("--set {first} and --set {later}: give one of them"));
            }
        }
        Ok(())
    }

    /// Name of the variable and its start value.
    pub fn start(&self) -> (String, f64) {
        (VARIABLES[self.index].name.to_owned(), self.value)
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let variable = &VARIABLES[self.index];
        let name = variable.name;
        match variable.kind {
            Kind::Boolean => write!(f, "{name}={}", self.value != 0.0),
            Kind::Enumeration => write!(f, "{name}={}", variable.items[self.value as usize - 1]),
            Kind::Real => write!(f, "{name}={}", self.value),
        }
    }
}

impl FromStr for Setting {
    /// Why the text is no setting, and what it takes.
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "give a variable and its start value as name=value";
        let (name, value) = text.split_once('=').ok_or(form)?;
        let (name, value) = (name.trim(), value.trim());
        let found = index_by_name(name).filter(|&i| VARIABLES[i].causality != Causality::Output);
        let index = found.ok_or_else(|| {
            let parameters = VARIABLES
                .iter()
                .filter(|v| v.causality == Causality::Parameter);
            let known: Vec<&str> = parameters.map(|v| v.name).collect();
            let known = known.join(", ");
            format!("the FMU has no parameter or input {name}; its parameters are {known}")
        })?;
        let variable = &VARIABLES[index];
        let (min, max, items) = (variable.min, variable.max, variable.items);
        let parsed = match variable.kind {
            Kind::Boolean => value.parse::<bool>().ok().map(number),
            Kind::Enumeration => (1..)
                .zip(items)
                .find_map(|(n, item)| (*item == value).then_some(f64::from(n))),
            Kind::Real => value.parse().ok().filter(|x: &f64| {
                x.is_finite() && min.is_none_or(|m| *x >= m) && max.is_none_or(|m| *x <= m)
            }),
        };
        let value = parsed
            .ok_or_else(|| format!("{name} = {value}: give {}", possible_values(variable)))?;
        Ok(Self { index, value })
    }
}

/// What may be given for `variable`, in words.
fn possible_values(variable: &Variable) -> String {
    match variable.kind {
        Kind::Boolean => "true or false".to_owned(),
        Kind::Enumeration => format!("one of {}", variable.items.join(", ")),
        Kind::Real => {
            let unit = Some(variable.unit).filter(|unit| !["", "1"].contains(unit));
            let limits = [
                variable.min.map(|min| format!(", {min} or above")),
                variable.max.map(|max| format!(", {max} or below")),
                unit.map(|unit| format!(", in {unit}")),
            ];
            let limits: String = limits.into_iter().flatten().collect();
            format!("a number with a decimal point{limits}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use gearmesh::element::{Element, LoadedFlank, Parameters, PhaseReference};
    use gearmesh::gear::GearKind;
    use nalgebra::Rotation3;

    /// A pair without backlash of `z1` and `z2` teeth, module 2 mm, helix 15 deg; a negative count is a ring.
    fn pair(z1: i32, z2: i32) -> PairGeometry {
        let gear = |z: i32, hand: f64| {
            let kind = [GearKind::External, GearKind::Ring][usize::from(z < 0)];
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
        let rings = [(19, -60), (20, -61), (-60, 19), (-61, 20)];
        for (z1, z2) in [(20, 20), (21, 30), (20, 31)].into_iter().chain(rings) {
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
                let phase = element.phase_offset(&inputs).unwrap();
                let out = element.evaluate(&phase, &inputs).unwrap();
                assert_abs_diff_eq!(out.transmission_error, 0.0, epsilon = 1e-12);
            }
        }
    }

    fn start(starts: &Starts, pair: &PairGeometry, i: usize) -> f64 {
        starts.of_variables(pair)[VARIABLES[i].name]
    }

    fn chosen(pair: &PairGeometry, texts: &[&str]) -> Starts {
        let settings: Vec<Setting> = texts.iter().map(|t| t.parse().unwrap()).collect();
        Starts::constant_stiffness(pair, 100.0).with(&settings)
    }

    #[test]
    fn settings_replace_and_what_depends_on_them_follows() {
        let pair = pair(21, 30);
        let of = |texts: &[&str]| chosen(&pair, texts);
        let plain = of(&[]);
        let heavier = of(&["damping=5e3"]);
        assert_eq!(start(&heavier, &pair, index::DAMPING), 5e3);
        let held = |damping| of(&["coupling=held", damping]).dynamics(&pair).step();
        assert!(held("damping=5e3") > held("damping=5e2"));
        assert_eq!(heavier.dynamics(&pair).step(), plain.dynamics(&pair).step());
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
        let of = |texts: &[&str]| chosen(&pair, texts);
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
    fn numbers_names_of_items_and_booleans_are_taken() {
        for (text, index, value) in [
            ("damping=500", index::DAMPING, 500.0),
            (" backlash = 8e-5 ", index::BACKLASH, 8e-5),
            ("interpolation=shepard", index::INTERPOLATION, 3.0),
            ("friction=true", index::FRICTION, 1.0),
            ("gear1.angles[3]=-0.5", index::GEAR1_ANGLES_3, -0.5),
        ] {
            assert_eq!(text.parse(), Ok(Setting { index, value }), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_what_can() {
        let error = |text: &str| text.parse::<Setting>().unwrap_err();
        let number = "give a number with a decimal point, 0 or above, in N.s/m";
        for (name, value, remedy) in [
            ("damping", "-1", number),
            ("damping", "1,5", number),
            ("damping", "inf", number),
            ("loadedFlank", "2", "give one of drive, coast, both"),
            ("friction", "1", "give true or false"),
        ] {
            let text = format!("{name}={value}");
            assert_eq!(error(&text), format!("{name} = {value}: {remedy}"));
        }
        assert!(error("damping").contains("name=value"));
        assert!(error("dampingOnset=1.5").contains(
            "dampingOnset = 1.5: give a number with a decimal point, 0 or above, 1 or below"
        ));
        assert!(error("mesh.stiffness=3").contains("no parameter or input mesh.stiffness"));
        assert!(error("dampin=3").contains("dampin; its parameters are stiffnessModel"));
    }

    #[test]
    fn a_variable_given_twice_is_refused_with_both_values() {
        let check = |texts: &[&str]| {
            let settings: Vec<Setting> = texts.iter().map(|t| t.parse().unwrap()).collect();
            Setting::check_once(&settings)
        };
        assert_eq!(check(&["damping=5e2", "backlash=1e-4"]), Ok(()));
        for twice in [
            ["damping=500", "damping=600"],
            ["coupling=held", "coupling=parallel"],
            ["friction=true", "friction=false"],
        ] {
            let [one, two] = twice;
            let expected = format!("--set {one} and --set {two}: give one of them");
            assert_eq!(check(&[one, "backlash=1e-4", two]), Err(expected));
        }
    }
}
