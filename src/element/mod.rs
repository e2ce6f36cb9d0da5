//! The gear contact element: a pure function of poses and velocities.
//!
//! Frames: world W, right-handed, SI; gear frames as in [`Motion`]. With theta the rotation about the
//! gears' axes, gamma the direction O1 -> O2, x along it, z the axis and y = z × x, the force on gear 2 is
//!
//! ```text
//! F_2 = F_tt [ e tan(phi) x + s sc y - s h tan(beta_w) z ],    F_1 = -F_2,    F_tt >= 0
//! ```
//!
//! in both formulations (conjugate: at parallel axes, plus the side terms of the potential). The sign
//! s is +1 for the drive flank, where gear 1 pushes in its +theta sense.
//!
//! - [`Formulation::Conjugate`]: displacement, rates and loads from the exact
//!   helicoids and one potential. Keeps energy; the default.
//! - [`Formulation::Paper`]: equations (1)-(26).
//!
//! Known limits: gears are rigid apart from the mesh; misalignment to first order, tilts up to 0.1 rad
//! and meaningful within the table's range; no friction, no tooth-to-tooth errors. An evaluation
//! neither allocates nor remembers; the phase zeros are the caller's [`Latch`].

mod check;
mod conjugate;
mod engagement;
mod error;
mod geometry;
mod jacobian;
mod latch;
mod law;
mod load;
mod motion;
mod paper;
mod parameters;
mod scalar;
mod secant;

pub use error::{Body, ElementError};
pub use jacobian::{BODY_COLUMNS, InputsChange, Jacobian, MotionChange};
pub use law::{Elasticity, FlankLaws};
pub use motion::{CONTINUOUS_OUTPUTS, Inputs, Latch, Motion, Outputs};
pub use parameters::{
    Formulation, Interpolation, LoadedFlank, Parameters, PhaseReference, StiffnessModel,
};
pub use scalar::Scalar;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use crate::gear::PairGeometry;
use geometry::Constants;
use law::{Effects, Law};
use load::Damping;
use nalgebra::Vector3;
use secant::Secant;
use std::sync::Arc;

/// The contact element of one gear pair. Immutable: instances can share it between threads.
#[derive(Clone)]
pub struct Element {
    constants: Constants,
    parameters: Parameters,
    laws: [Option<Law>; 2],
    damping: Damping,
    /// Index of the flank that phases and transmission error refer to.
    reference_flank: usize,
}

impl Element {
    /// The element of `pair` with `parameters`; `laws` are needed for [`StiffnessModel::Table`].
    ///
    /// # Errors
    /// Parameters without meaning (named as in the FMU), a missing table, a pair without a line of
    /// action.
    pub fn new(
        pair: &PairGeometry,
        parameters: &Parameters,
        laws: Option<&FlankLaws>,
    ) -> Result<Self, ElementError> {
        parameters.check()?;
        let constants = Constants::new(pair, parameters)?;
        let effects = Effects {
            center_distance: parameters.center_distance_effect,
            misalignment: parameters.misalignment_effect,
            shuttling: parameters.shuttling_effect,
        };
        let [drive, coast] = match parameters.stiffness_model {
            StiffnessModel::Constant => {
                let law = Law::linear(parameters.constant_stiffness / constants.cos_phi.powi(2));
                [law.clone(), law]
            }
            StiffnessModel::Table => {
                let laws = laws.ok_or(ElementError::NoTable)?;
                let surface = |table: &Arc<dyn Elasticity>| -> Result<_, ElementError> {
                    if parameters.load_dependent {
                        return Ok(table.clone());
                    }
                    let secant = Secant::new(table.clone(), constants.nominal_force).ok_or(
                        ElementError::NominalTorque {
                            torque_nm: parameters.nominal_torque,
                        },
                    )?;
                    Ok(Arc::new(secant))
                };
                let drive = surface(&laws.drive)?;
                let coast = match &laws.coast {
                    Some(own) => Law::table(surface(own)?, false, effects),
                    None => Law::table(drive.clone(), true, effects),
                };
                [Law::table(drive, false, effects), coast]
            }
        };
        let laws = match parameters.loaded_flank {
            LoadedFlank::Drive => [Some(drive), None],
            LoadedFlank::Coast => [None, Some(coast)],
            LoadedFlank::Both => [Some(drive), Some(coast)],
        };
        Ok(Self {
            damping: Damping {
                coefficient: parameters.damping / constants.cos_phi.powi(2),
                full_at: parameters.damping_onset * constants.nominal_force,
            },
            reference_flank: usize::from(parameters.loaded_flank == LoadedFlank::Coast),
            constants,
            parameters: *parameters,
            laws,
        })
    }

    /// The element with another damping (the one tunable parameter), N s/m, tangential.
    ///
    /// # Errors
    /// A negative or non-finite value.
    pub fn with_damping(&self, damping: f64) -> Result<Self, ElementError> {
        let parameters = Parameters {
            damping,
            ..self.parameters
        };
        parameters.check()?;
        let mut element = self.clone();
        element.parameters = parameters;
        element.damping.coefficient = damping / self.constants.cos_phi.powi(2);
        Ok(element)
    }

    /// The parameters it was made with.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
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

    /// Phase zeros for a simulation that starts at `inputs`.
    ///
    /// # Errors
    /// A pose without meaning; with [`PhaseReference::Absolute`], teeth that overlap.
    pub fn latch(&self, inputs: &Inputs) -> Result<Latch, ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        latch::latch(self, inputs)
    }

    /// Loads and diagnostics at `inputs`. Pure; no allocation.
    ///
    /// # Errors
    /// A pose without meaning (see [`ElementError`]). Gears out of reach of one another are no error:
    /// they feel no force.
    pub fn evaluate(&self, latch: &Latch, inputs: &Inputs) -> Result<Outputs, ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        self.evaluate_generic(latch, inputs)
    }

    fn evaluate_generic<T: Scalar>(
        &self,
        latch: &Latch,
        inputs: &Inputs<T>,
    ) -> Result<Outputs<T>, ElementError> {
        match self.parameters.formulation {
            Formulation::Conjugate => conjugate::evaluate(self, latch, inputs),
            Formulation::Paper => paper::evaluate(self, latch, inputs),
        }
    }

    fn phase(&self, inputs: &Inputs) -> Result<latch::Phase, ElementError> {
        match self.parameters.formulation {
            Formulation::Conjugate => conjugate::phase(self, inputs),
            Formulation::Paper => paper::phase(self, inputs),
        }
    }

    fn with_carrier(&self) -> bool {
        self.parameters.formulation == Formulation::Paper
    }
}
