//! The gear contact element: a pure function of poses and velocities.
//!
//! Frames: world W, right-handed, SI; gear frames as in [`Motion`]. With theta the rotation about the
//! gears' axes, gamma the direction O1 -> O2, x along it, z the axis and y = z × x, the force on gear 2 is
//!
//! ```text
//! F_2 = F_tt [ e tan(phi) x + s sc y - s h tan(beta_w) z ],    F_1 = -F_2,    F_tt >= 0
//! ```
//!
//! in both formulations (conjugate: at parallel axes, plus the side terms of the potential; paper: of the elastic
//! force). The sign s is +1 for the drive flank, where gear 1 pushes in its +theta sense.
//!
//! ```text
//! poses ─> map: coordinates q ─> law: slopes g of the potential ─> loads -J^T g
//! velocities ─> map: rates J v ──> damper, friction ─────┘
//! ```
//!
//! The walk from a pose to its force: this file, `contact` (both flanks under load), `kinematics` (the map), `law` (a table or
//! what stands for it), `friction`. (`paper` takes the place of a part of the map in [`Formulation::Paper`].)
//! Loads for a communication step, which need not be those of the pose, are predicted from that: [`Element::predict`].
//!
//! - [`Formulation::Conjugate`]: coordinates and loads from the exact helicoids, through one map J and its
//!   transpose. Undamped it keeps energy, and the damper can only take some; the default.
//! - [`Parameters::friction`]: friction against the sliding of the flanks, through a row of the same map.
//! - [`Parameters::root_stress`]: stress in the tooth roots under the elastic forces; nothing depends on it.
//! - [`Formulation::Paper`]: displacement and elastic force of (1)-(26); the damper goes through the same map.
//!
//! One flank alone ([`LoadedFlank`]) carries nothing when the gears turn back, up to half a pitch: there they
//! would meet the tooth behind, which is refused.
//!
//! Known limits: gears are rigid apart from the mesh; misalignment to first order, tilts up to 0.1 rad
//! and meaningful within the table's range; errors of teeth with [`StiffnessModel::Teeth`] and [`StiffnessModel::Contact`] alone.
//! An evaluation remembers nothing: phase offsets ([`PhaseOffset`]) and where a contact solve starts ([`Workspace`]) are the
//! caller's. It allocates under contact at run time alone.

mod constants;
mod contact;
mod dual;
mod friction;
mod jacobian;
mod kinematics;
mod law;
mod motion;
mod paper;
mod parameters;
mod prediction;
mod start;

pub use crate::table::Interpolation;
pub use dual::Scalar;
pub use jacobian::{BODY_COLUMNS, Direction, Jacobian};
pub use law::{Elasticity, Workspace};
pub use motion::{CONTINUOUS_OUTPUTS, ElementError, Inputs, Motion, Outputs, PhaseOffset};
pub use parameters::{Formulation, LoadedFlank, Parameters, PhaseReference, StiffnessModel};
pub use prediction::{Coupling, Loads, Prediction, Step, StepRequest};

#[cfg(test)]
pub(crate) mod tests;

use crate::contact::ContactFile;
use crate::gear::PairGeometry;
use crate::table::{Effects, Table, TableError, TeethRecord};
use crate::words::number;
use constants::{Constants, FLANKS};
use contact::{Damper, Solution};
use friction::Friction;
use law::{Law, Source};
use nalgebra::Vector3;
use start::Covered;
use std::sync::Arc;

/// The contact element of one gear pair. Immutable: instances can share it between threads.
#[derive(Clone)]
pub struct Element {
    constants: Constants,
    parameters: Parameters,
    laws: [Option<Law>; 2],
    damper: Damper,
    friction: Option<Friction>,
    /// The table with the stress in the tooth roots, where it is on and not found with the loads.
    root_stress: Option<Arc<Table>>,
    /// Force on the line of action that a start pose may have, N.
    largest_force: f64,
    /// What its laws cover; `None`: they are the caller's.
    covered: Option<Covered>,
    /// Index of the flank that phases and transmission error refer to.
    reference_flank: usize,
}

impl Element {
    /// The element of `pair` with `parameters`, whatever [`Parameters::stiffness_model`] says under the law `drive` of the drive flank
    /// and `coast` of the coast flank. `None`: that of the drive flank, mirrored (M -> -M, z_c - z_ref -> -(z_c - z_ref)), which is
    /// exact where the microgeometry is mirror-symmetric. Effects that are off leave out their coordinate.
    ///
    /// # Errors
    /// Parameters without meaning (named as in the FMU), a pair without a line of action.
    pub fn with_laws(
        pair: &PairGeometry,
        parameters: &Parameters,
        drive: Arc<dyn Elasticity>,
        coast: Option<Arc<dyn Elasticity>>,
    ) -> Result<Self, ElementError> {
        let effects = parameters.table_effects(pair);
        let mirrored = coast.is_none();
        let coast = coast.unwrap_or_else(|| drive.clone());
        let law = |law, mirrored| Law::new(Source::Custom(law), mirrored, effects);
        Self::build(pair, parameters, [law(drive, false), law(coast, mirrored)])
    }

    /// The element of `pair` with `parameters` under static contact at run time, that of `file`.
    ///
    /// # Errors
    /// As [`Element::with_laws`]; friction of a file without its law; root stress of a file without it.
    pub fn with_contact(
        pair: &PairGeometry,
        parameters: &Parameters,
        file: &ContactFile,
    ) -> Result<Self, ElementError> {
        let effects = Effects {
            friction: parameters.friction,
            ..parameters.table_effects(pair)
        };
        let laws = FLANKS.map(|flank| Law::contact(file, flank, effects));
        let mut element = Self::build(pair, parameters, laws)?;
        if parameters.friction {
            let law = file.setup.friction.as_ref();
            let law = law.ok_or(TableError::NO_FRICTION_LAW)?;
            element.friction = Some(Friction::new(pair, parameters, law, None));
        }
        let mut flanks = file.coast.iter().chain([&file.drive]);
        if parameters.root_stress && flanks.any(|flank| flank.roots.is_none()) {
            return Err(TableError::NO_ROOT_STRESS_AT_CONTACT.into());
        }
        Ok(element)
    }

    /// The element of `pair` with `parameters`; `table` is needed for [`StiffnessModel::Table`] and [`StiffnessModel::Teeth`]. A table
    /// that does not have the effects of [`Parameters::table_effects`] is cut to them first.
    ///
    /// # Errors
    /// Parameters without meaning (named as in the FMU), a missing table, an effect whose axis the table
    /// does not have, a pair without a line of action.
    pub fn new(
        pair: &PairGeometry,
        parameters: &Parameters,
        table: Option<Arc<Table>>,
    ) -> Result<Self, ElementError> {
        parameters.check()?;
        let effects = parameters.table_effects(pair);
        match (parameters.stiffness_model, table) {
            (StiffnessModel::Contact, _) => Err(ElementError(
                "stiffnessModel = contact, but the FMU does not hold the contact of its pair: build it with `gearmesh build \
                 --contact`, or set stiffnessModel = table"
                    .into(),
            )),
            (StiffnessModel::Constant, _) => {
                let phi = pair.operating_pressure_angle(pair.center_distance);
                let stiffness = parameters.constant_stiffness / phi.cos().powi(2);
                let law = Law::new(Source::Linear(stiffness), false, effects);
                let mut element = Self::build(pair, parameters, [law.clone(), law])?;
                element.covered = Some(Covered::default());
                Ok(element)
            }
            (StiffnessModel::Table | StiffnessModel::Teeth, None) => Err(ElementError(
                "stiffnessModel = table or teeth, but there is no table: pack one with `gearmesh tables`, or set stiffnessModel = \
                 constant"
                    .into(),
            )),
            (StiffnessModel::Table | StiffnessModel::Teeth, Some(mut table)) => {
                if *table.effects() != effects {
                    table = Arc::new(Table::with_effects(table.file().clone(), effects)?);
                }
                Self::on_table(pair, parameters, table)
            }
        }
    }

    /// The element on a table with the effects of [`Parameters::table_effects`].
    fn on_table(
        pair: &PairGeometry,
        parameters: &Parameters,
        table: Arc<Table>,
    ) -> Result<Self, ElementError> {
        let file = table.file();
        let largest = file.maximum_torque_nm;
        // Else the damping would never act in full, without a word.
        if parameters.damping_onset * parameters.nominal_torque > largest {
            let value = format!("{} N m", number(parameters.nominal_torque));
            let remedy = "dampingOnset times it lies beyond the largest torque of the table, so that damping would never act in full; \
                          give a torque of the table";
            return Err(ElementError::parameter("nominalTorque", &value, remedy));
        }
        let [drive, coast] = FLANKS.map(|flank| Law::table(&table, flank));
        let mut element = Self::build(pair, parameters, [drive?, coast?])?;
        element.largest_force = largest / pair.gears[0].base_radius();
        element.covered = Some(Covered::by(&table));
        let teeth = (file.teeth.as_ref()).filter(|_| table.effects().teeth);
        if parameters.friction {
            // Tooth pairs find how the load slides with their forces.
            let (law, sliding) = match teeth {
                Some(record) => (record.friction, None),
                None => (
                    file.friction.as_ref().map(|record| record.law),
                    Some(&table),
                ),
            };
            element.friction = law.map(|law| Friction::new(pair, parameters, &law, sliding));
        }
        if parameters.root_stress {
            if teeth.is_some_and(TeethRecord::tells_apart) {
                let remedy = "the tables hold the stress of teeth that are alike: set stiffnessModel = contact, remove tooth_errors \
                              from the pair file, or set rootStress = false";
                return Err(ElementError::parameter("rootStress", "true", remedy));
            }
            element.root_stress = Some(table);
        }
        Ok(element)
    }

    fn build(
        pair: &PairGeometry,
        parameters: &Parameters,
        [drive, coast]: [Law; 2],
    ) -> Result<Self, ElementError> {
        parameters.check()?;
        let constants = Constants::new(pair, parameters)?;
        let laws = match parameters.loaded_flank {
            LoadedFlank::Drive => [Some(drive), None],
            LoadedFlank::Coast => [None, Some(coast)],
            LoadedFlank::Both => [Some(drive), Some(coast)],
        };
        Ok(Self {
            damper: Damper::new(parameters, &constants),
            friction: None,
            root_stress: None,
            largest_force: START_FORCE * constants.nominal_force,
            covered: None,
            reference_flank: usize::from(parameters.loaded_flank == LoadedFlank::Coast),
            constants,
            parameters: *parameters,
            laws,
        })
    }

    /// Sets the damping (the one tunable parameter), N s/m, tangential, >= 0.
    pub fn set_damping(&mut self, damping: f64) {
        self.parameters.damping = damping;
        self.damper = Damper::new(&self.parameters, &self.constants);
    }

    /// The parameters it was made with.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Line-of-action length per tangential length at `center_distance` (m): cos phi.
    pub fn line_of_action(&self, center_distance: f64) -> f64 {
        self.constants.base_sum / center_distance
    }

    /// A valid mesh at rest: gear 1 and the carrier at the origin, gear 2 at the nominal centre
    /// distance along x (and at its face offset along z), zero angles.
    pub fn nominal_inputs(&self) -> Inputs {
        Inputs {
            gears: [
                Motion::default(),
                Motion::at(Vector3::new(
                    self.constants.center_distance,
                    0.0,
                    self.constants.face_offset,
                )),
            ],
            carrier: Motion::default(),
        }
    }

    /// Loads and diagnostics at `inputs`. Pure; contact at run time starts from nothing, see [`Element::evaluate_from`].
    ///
    /// # Errors
    /// A pose without meaning (see [`ElementError`]), or at which a law has no potential. Gears out of reach of one another
    /// are no error: they feel no force.
    pub fn evaluate(&self, phase: &PhaseOffset, inputs: &Inputs) -> Result<Outputs, ElementError> {
        self.evaluate_from(phase, inputs, &mut Workspace::default())
    }

    /// As [`Element::evaluate`], faster under contact at run time, from `workspace` of the last evaluation.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn evaluate_from(
        &self,
        phase: &PhaseOffset,
        inputs: &Inputs,
        workspace: &mut Workspace,
    ) -> Result<Outputs, ElementError> {
        self.check(inputs)?;
        Ok(Solution::new(self, phase, inputs, false, workspace)?.outputs)
    }

    /// Errors: numbers that are not finite, orientations that are no rotations; of the carrier where the formulation looks at it.
    fn check(&self, inputs: &Inputs) -> Result<(), ElementError> {
        inputs.gears[0].check("gear1")?;
        inputs.gears[1].check("gear2")?;
        match self.parameters.formulation {
            Formulation::Conjugate => Ok(()),
            Formulation::Paper => inputs.carrier.check("carrier"),
        }
    }

    /// Displacement that a law takes over the penetration: the paper's constant k is tangential at the actual
    /// operating pitch circle.
    #[inline(always)]
    fn law_scale<T: Scalar>(&self, cos_phi: T) -> T {
        let p = &self.parameters;
        if p.formulation == Formulation::Paper && p.stiffness_model == StiffnessModel::Constant {
            let ratio = cos_phi.recip() * self.constants.cos_phi;
            ratio * ratio
        } else {
            T::from(1.0)
        }
    }

    /// Whether a flank is pressed by more than half of what fits between the gap and the tooth behind: no load does that,
    /// and twice as far the tooth behind pushes the other way.
    /// Errors: it is, and one flank alone can carry: the gears have turned back through the flank that is missing.
    fn have_passed(&self, penetration: f64, half_gap: f64) -> Result<bool, ElementError> {
        let limit = 0.5 * (0.5 * self.constants.base_pitch - half_gap);
        let passed = penetration > limit;
        if passed && self.parameters.loaded_flank != LoadedFlank::Both {
            let (flank, sign) = match self.parameters.loaded_flank {
                LoadedFlank::Coast => ("coast", -1.0),
                _ => ("drive", 1.0),
            };
            return Err(ElementError(format!(
                "loadedFlank = {flank}: the teeth overlap by {:.3} mm on the line of action; nothing holds the gears when they turn \
                 back from this flank, and they have come to the tooth behind: set loadedFlank = both{}",
                1e3 * penetration,
                self.phase_remedy(sign * penetration)
            )));
        }
        Ok(passed)
    }
}

/// Multiple of the nominal force that teeth of constant stiffness may start with.
const START_FORCE: f64 = 10.0;
