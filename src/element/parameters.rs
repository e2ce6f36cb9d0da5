//! The choices a user makes, named as in the FMU.

use super::motion::ElementError;
use crate::gear::PairGeometry;
use crate::table::{Effects, Interpolation, Load};
use crate::words::number;

/// Largest phase, rad: the digits of larger ones do not reach a mesh position.
const LARGEST_PHASE: f64 = 1e6;

/// Where the stiffness comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StiffnessModel {
    /// [`Parameters::constant_stiffness`].
    Constant,
    /// The pair's table.
    Table,
    /// A static contact solve at every evaluation: laws that the caller gives
    /// ([`super::Element::with_laws`]).
    Contact,
    /// Tooth pair by tooth pair, from the pair's table.
    Teeth,
}

/// How displacement and force follow from the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Formulation {
    /// The paper's (1)-(26), corrected. The table adds two things: what a misalignment closes of helical flanks, and where the
    /// resultant crosses the pitch plane. The equations here stay the paper's.
    Paper,
    /// Exact involute helicoids with the force along the exact gradient; keeps energy.
    Conjugate,
}

/// Which flanks of gear 1 can carry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadedFlank {
    /// s = +1 alone: gear 1 pushes in its +theta sense.
    Drive,
    /// s = -1 alone.
    Coast,
    /// Both, with the backlash between them.
    Both,
}

/// What the phases of the teeth refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhaseReference {
    /// The initial pose is the touching one on the loaded flank (both flanks: on the drive flank) at
    /// no load: with its relief and its misalignment that flank is just about to carry, with the mesh position
    /// [`Parameters::mesh_phase`] / theta_p.
    FromInitialPose,
    /// The teeth stand where the body frames say: a tooth centre (ring: space centre) on body +x.
    Absolute,
}

/// Parameters of one element, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Where the stiffness comes from.
    pub stiffness_model: StiffnessModel,
    /// Tangential stiffness at the nominal operating pitch circle, N/m, for
    /// [`StiffnessModel::Constant`].
    pub constant_stiffness: f64,
    /// Table: force over displacement (variable load) instead of the secant stiffness at
    /// [`Parameters::nominal_torque`] (constant load, (21)).
    pub load_dependent: bool,
    /// Nominal torque on gear 1, N m, > 0.
    pub nominal_torque: f64,
    /// Table: look it up at the actual centre distance.
    pub center_distance_effect: bool,
    /// Table: look it up at the actual misalignment.
    pub misalignment_effect: bool,
    /// The resultant moves along the face, (25)-(26).
    pub shuttling_effect: bool,
    /// How displacement and force follow from the poses.
    pub formulation: Formulation,
    /// Interpolant of the table.
    pub interpolation: Interpolation,
    /// Viscous damping c, N s/m, tangential, >= 0; c = 2 zeta sqrt(k m) with the tangential stiffness k and
    /// the reduced mass m on the pitch circle. See [`Parameters::damping_onset`].
    pub damping: f64,
    /// Conjugate formulation: elastic force, as a fraction of the nominal one, from which on damping
    /// acts in full, above 0 and up to 1. Below it the coefficient rises from zero with a cubic step, so that meeting
    /// teeth feel no jump; the total force never pulls. This is the law of Adams' IMPACT function with
    /// force in place of penetration. The paper's formulation takes the constant c at once.
    pub damping_onset: f64,
    /// Circumferential backlash at the nominal operating pitch circle, m, >= 0; `None`: the pair's.
    pub backlash: Option<f64>,
    /// Which flanks can carry.
    pub loaded_flank: LoadedFlank,
    /// What the phases refer to.
    pub phase_reference: PhaseReference,
    /// Angle of gear 1 into its mesh cycle at the initial pose, rad, on the loaded flank; used by
    /// [`PhaseReference::FromInitialPose`].
    pub mesh_phase: f64,
    /// Friction of the flanks by the sliding and the law of the coefficient that the table or the contact holds.
    pub friction: bool,
    /// Factor on the coefficient of friction, >= 0.
    pub friction_factor: f64,
    /// Mean sliding speed about which friction turns from viscous to dry, m/s, > 0: it is that of the law times
    /// r / sqrt(r² + this²).
    pub friction_transition_speed: f64,
    /// Stress in the tooth roots among the outputs, from the table.
    pub root_stress: bool,
    /// Gear bodies that are no solids of revolution change the compliance with their angle, as the table or the contact holds;
    /// off: their mean over all angles.
    pub body_effect: bool,
}

impl Default for Parameters {
    /// Those of modelDescription.xml with all effects on: constant stiffness of the paper's pair, conjugate formulation, drive flank, and a
    /// damping that is light for most pairs: zeta = 0.05 for the paper's (0.25 kg on 4.35e8 N/m), within
    /// the 0.03 to 0.17 published for steel gears (quoted by Amabili and Rivola, Mech. Syst. Signal Process. 11
    /// (1997) 375-390). The 1e5 N s/m of the paper's simulations is zeta = 4.8 there.
    fn default() -> Self {
        Self {
            stiffness_model: StiffnessModel::Constant,
            constant_stiffness: 4.35e8,
            load_dependent: true,
            nominal_torque: 100.0,
            center_distance_effect: true,
            misalignment_effect: true,
            shuttling_effect: true,
            formulation: Formulation::Conjugate,
            interpolation: Interpolation::Spline,
            damping: 1000.0,
            damping_onset: 0.1,
            backlash: None,
            loaded_flank: LoadedFlank::Drive,
            phase_reference: PhaseReference::FromInitialPose,
            mesh_phase: 0.0,
            friction: false,
            friction_factor: 1.0,
            friction_transition_speed: 1e-3,
            root_stress: false,
            body_effect: false,
        }
    }
}

impl Parameters {
    /// What these parameters ask of the table of `pair`.
    pub fn table_effects(&self, pair: &PairGeometry) -> Effects {
        let teeth = self.stiffness_model == StiffnessModel::Teeth;
        Effects {
            interpolation: if teeth {
                Interpolation::Spline
            } else {
                self.interpolation
            },
            load: if self.load_dependent || teeth {
                Load::Variable
            } else {
                Load::Constant {
                    loa_force: self.nominal_torque / pair.gears[0].base_radius(),
                }
            },
            center_distance: self.center_distance_effect,
            misalignment: self.misalignment_effect,
            shuttling: self.shuttling_effect,
            // A contact solve knows how its own load slides.
            friction: self.friction && self.stiffness_model != StiffnessModel::Contact,
            root_stress: self.root_stress,
            teeth,
        }
    }

    /// Errors: a number without a meaning, and what only tables hold without one.
    pub(crate) fn check(&self) -> Result<(), ElementError> {
        let refuse = |name, value: f64, unit, remedy| {
            let value = format!("{} {unit}", number(value));
            Err(ElementError::parameter(name, value.trim_end(), remedy))
        };
        let backlash = self.backlash.unwrap_or_default();
        let speed = self.friction_transition_speed;
        for (name, value, unit, may_be_zero) in [
            ("constantStiffness", self.constant_stiffness, "N/m", false),
            ("nominalTorque", self.nominal_torque, "N m", false),
            ("damping", self.damping, "N s/m", true),
            ("backlash", backlash, "m", true),
            ("frictionFactor", self.friction_factor, "", true),
            ("frictionTransitionSpeed", speed, "m/s", false),
        ] {
            let remedy = match may_be_zero {
                true => "give a finite number, zero or above",
                false => "give a finite number above zero",
            };
            if !(value.is_finite() && (value > 0.0 || may_be_zero && value == 0.0)) {
                return refuse(name, value, unit, remedy);
            }
        }
        if !(self.damping_onset > 0.0 && self.damping_onset <= 1.0) {
            let remedy = "give a share of the nominal force, above 0 and up to 1; damping = 0 switches damping off";
            return refuse("dampingOnset", self.damping_onset, "", remedy);
        }
        let is_in_range = self.mesh_phase.abs() <= LARGEST_PHASE;
        if !is_in_range {
            let remedy = "give an angle of 1e6 rad at most, either way";
            return refuse("meshPhase", self.mesh_phase, "rad", remedy);
        }
        if self.stiffness_model == StiffnessModel::Constant {
            let remedy = "a constant stiffness knows neither teeth nor bodies: set stiffnessModel = table, teeth or contact, or this to false";
            for (name, on) in [
                ("friction", self.friction),
                ("rootStress", self.root_stress),
                ("bodyEffect", self.body_effect),
            ] {
                if on {
                    return Err(ElementError::parameter(name, "true", remedy));
                }
            }
        }
        Ok(())
    }
}
