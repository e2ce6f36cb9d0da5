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
//! The walk from a pose to its force: `contact` (both flanks under load), `kinematics` (the map), `engagement` (how far the
//! gears are in mesh), `law` (a table or what stands for it), `friction`. (`paper` takes the place of a part of the map in [`Formulation::Paper`].)
//! Loads for a communication step, which need not be those of the pose, are predicted from that: [`Element::predict`].
//!
//! In [`Formulation::Conjugate`], the default, coordinates and loads go through one map J and its transpose: undamped it keeps
//! energy, and damper and friction can only take some. [`Formulation::Paper`] has displacement and elastic force of (1)-(26).
//!
//! One flank alone ([`LoadedFlank`]) carries nothing when the gears turn back, up to half a pitch: there they
//! would meet the tooth behind, which is refused.
//!
//! Known limits: gears are rigid apart from the mesh; misalignment to first order, tilts up to 0.1 rad
//! and meaningful within the table's range; errors of teeth with [`StiffnessModel::Teeth`] and [`StiffnessModel::Contact`] alone.
//! An evaluation remembers nothing: phase offsets ([`PhaseOffset`]) and where a contact solve starts ([`Workspace`]) are the
//! caller's. It allocates under contact at run time alone.

mod bodies;
mod constants;
mod contact;
mod dual;
mod engagement;
mod flank;
mod friction;
mod jacobian;
mod kinematics;
mod law;
mod master;
mod motion;
mod paper;
mod parameters;
mod prediction;
mod start;

pub use crate::table::Interpolation;
pub use contact::Element;
pub use dual::Scalar;
pub use jacobian::{BODY_COLUMNS, Direction, Jacobian};
pub use law::{Elasticity, Workspace};
pub use motion::{CONTINUOUS_OUTPUTS, ElementError, Inputs, Motion, Outputs, PhaseOffset};
pub use parameters::{Formulation, LoadedFlank, Parameters, PhaseReference, StiffnessModel};
pub use prediction::{Coupling, History, Loads, Mode, Prediction, Report, StepRequest};

#[cfg(test)]
pub(crate) mod tests;

use crate::contact::ContactFile;
use crate::gear::{BodyOrders, PairGeometry, TurningBodies};
use crate::table::{Effects, Table, TableError, TeethRecord};
use crate::words::number;
use constants::{Constants, FLANKS};
use contact::Solution;
use friction::Friction;
use law::{Law, Source};
use nalgebra::Vector3;
use std::sync::Arc;

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
        let laws = on_bodies(laws, pair, parameters, file.setup.bodies.as_ref())?;
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
        let mut table = match (parameters.stiffness_model, table) {
            (StiffnessModel::Contact, _) => {
                let reason = "stiffnessModel = contact, but the FMU does not hold the contact of its pair: build it with \
                              `gearmesh build --contact`, or set stiffnessModel = table";
                return Err(ElementError::Parameter(reason.into()));
            }
            (StiffnessModel::Constant, _) => {
                let phi = pair.operating_pressure_angle(pair.center_distance);
                let stiffness = parameters.constant_stiffness / phi.cos().powi(2);
                let law = Law::new(Source::Linear(stiffness), false, effects);
                return Self::build(pair, parameters, [law.clone(), law]);
            }
            (StiffnessModel::Table | StiffnessModel::Teeth, None) => {
                let reason = "stiffnessModel = table or teeth, but there is no table: build the FMU with `gearmesh build`, pack tables \
                              with `gearmesh pack --tables`, or set stiffnessModel = constant";
                return Err(ElementError::Parameter(reason.into()));
            }
            (StiffnessModel::Table | StiffnessModel::Teeth, Some(table)) => table,
        };
        if table.effects != effects {
            table = Arc::new(Table::with_effects(table.file.clone(), effects)?);
        }
        let file = &table.file;
        let largest = file.maximum_torque_nm;
        // Else the damping would never act in full, without a word.
        if parameters.damping_onset * parameters.nominal_torque > largest {
            let value = format!("{} N m", number(parameters.nominal_torque));
            let remedy = "dampingOnset times it lies beyond the largest torque of the table, so that damping would never act in full; \
                          give a torque of the table";
            return Err(ElementError::parameter("nominalTorque", &value, remedy));
        }
        let laws = FLANKS.map(|flank| Law::on_table(&table, flank));
        let laws = on_bodies(laws, pair, parameters, file.bodies.as_ref())?;
        let mut element = Self::build(pair, parameters, laws)?;
        let teeth = (file.teeth.as_ref()).filter(|_| table.effects.teeth);
        if parameters.friction {
            // Tooth pairs find how the load slides with their forces.
            let record = file.friction.as_ref().filter(|_| teeth.is_none());
            let law = teeth.map_or(record.map(|record| record.law), |teeth| teeth.friction);
            element.friction = law.map(|law| Friction::new(pair, parameters, &law, record));
        }
        if parameters.root_stress && teeth.is_some_and(TeethRecord::tells_apart) {
            let remedy = "the tables hold the stress of teeth that are alike: set stiffnessModel = contact, remove tooth_errors \
                          from the pair file, or set rootStress = false";
            return Err(ElementError::parameter("rootStress", "true", remedy));
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
            friction: None,
            reference_flank: usize::from(parameters.loaded_flank == LoadedFlank::Coast),
            constants,
            parameters: *parameters,
            laws,
        })
    }

    /// Sets the damping (the one tunable parameter), N s/m, tangential, >= 0.
    pub fn set_damping(&mut self, damping: f64) {
        self.parameters.damping = damping;
    }

    /// Line-of-action length per tangential length at `center_distance` (m): cos phi.
    pub fn line_of_action(&self, center_distance: f64) -> f64 {
        self.constants.base_radius_sum / center_distance
    }

    /// A valid mesh at rest: gear 1 and the carrier at the origin, gear 2 at the nominal centre
    /// distance along x (and at its face offset along z), zero angles.
    pub fn nominal_inputs(&self) -> Inputs {
        let k = &self.constants;
        let mut inputs = Inputs::default();
        inputs.gears[1].p = Vector3::new(k.center_distance, 0.0, k.face_offset);
        inputs
    }

    /// Loads and diagnostics at `inputs`. Pure; contact at run time starts from nothing, see [`Element::evaluate_from`].
    ///
    /// # Errors
    /// A pose without meaning (see [`ElementError`]), or at which a law has no potential. Gears out of mesh
    /// are no error: they feel no force.
    pub fn evaluate(&self, phase: &PhaseOffset, inputs: &Inputs) -> Result<Outputs, ElementError> {
        self.evaluate_from(phase, inputs, &mut Workspace::default())
    }

    /// As [`Element::evaluate`], faster under contact at run time, from `workspace` of the last evaluation.
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
}

/// `laws` of the flanks of `pair` with its `bodies` in series, where `parameters` switch them on.
/// Errors: there are none to switch on.
fn on_bodies(
    laws: [Law; 2],
    pair: &PairGeometry,
    parameters: &Parameters,
    bodies: Option<&BodyOrders>,
) -> Result<[Law; 2], ElementError> {
    if !parameters.body_effect {
        return Ok(laws);
    }
    let bodies = bodies.ok_or(TableError::NO_BODIES)?;
    let [drive, coast] = laws;
    let turning = |flank| TurningBodies::new(pair, bodies.flank(flank));
    Ok([
        drive.on_bodies(turning(FLANKS[0])),
        coast.on_bodies(turning(FLANKS[1])),
    ])
}
