//! One mesh of the unit: its outputs and their derivatives, made when they are asked for.
//!
//! Both are a pure function of inputs, settings and phase zeros. What was made stays until one of these
//! changes, so that a host may read value by value and ask derivatives column by column.

use nalgebra::SVector;

use super::inputs::{InputValues, Resolution};
use super::layout::MeshVariables;
use super::report::{Refusal, refuse};
use super::resources::Resources;
use super::settings::Settings;
use crate::element::{
    BODY_COLUMNS, CONTINUOUS_OUTPUTS, Element, Formulation, Inputs, Jacobian, Latch, Motion,
    Outputs,
};
use crate::gear::PairGeometry;

/// A direction in the space of the motions of gear 1, gear 2 and carrier, as the columns of
/// [`Jacobian`].
pub(super) type Freedoms = SVector<f64, { 3 * BODY_COLUMNS }>;

/// Outputs at the present inputs.
pub struct Evaluated {
    /// As the element gives them.
    pub all: Outputs,
    /// The FMU's in the order of their variables.
    pub continuous: [f64; CONTINUOUS_OUTPUTS],
}

/// One mesh.
pub struct Mesh {
    variables: &'static MeshVariables,
    /// What the teeth resolve: gear 1, gear 2, and the orientation of the carrier.
    resolution: [Resolution; 3],
    settings: Settings,
    latch: Option<Latch>,
    element: Option<Element>,
    /// Those of the last look at the inputs.
    motions: Inputs,
    outputs: Option<Evaluated>,
    /// Once they were asked for.
    slopes: Option<Box<Jacobian>>,
    /// Whether they are those of the present inputs, and if so, whether those of the stiffness are among them.
    present_slopes: Option<bool>,
}

impl Mesh {
    /// A mesh of `pair` whose teeth have no phases yet.
    pub fn new(variables: &'static MeshVariables, settings: Settings, pair: &PairGeometry) -> Self {
        let [z1, z2] = [pair.gears[0].z(), pair.gears[1].z()];
        let of = |teeth: f64| Resolution::new(teeth, pair.base_pitch());
        let carrier = Resolution {
            position: f64::INFINITY,
            ..of(z1.max(z2))
        };
        Self {
            variables,
            resolution: [of(z1), of(z2), carrier],
            settings,
            latch: None,
            element: None,
            motions: Inputs::default(),
            outputs: None,
            slopes: None,
            present_slopes: None,
        }
    }

    /// Its parameters.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Phase zeros; `None` until [`Mesh::take_phase`].
    pub fn latch(&self) -> Option<Latch> {
        self.latch
    }

    /// Its variables.
    pub fn variables(&self) -> &'static MeshVariables {
        self.variables
    }

    /// Takes other settings and phase zeros; what they leave valid is kept.
    ///
    /// # Errors
    /// A damping without meaning; the element is then made anew, or refused, when it is needed.
    pub fn configure(&mut self, settings: Settings, latch: Option<Latch>) -> Result<(), Refusal> {
        let before = std::mem::replace(&mut self.settings, settings);
        self.latch = latch;
        self.forget();
        if before == self.settings {
            return Ok(());
        }
        let element = self.element.take();
        if let Some(element) = element
            && before.differs_in_damping_alone(&self.settings)
        {
            let damping = self.settings.element.damping;
            self.element = Some(element.with_damping(damping).map_err(refuse)?);
        }
        Ok(())
    }

    /// Inputs have changed.
    #[inline]
    pub fn forget(&mut self) {
        self.outputs = None;
        self.present_slopes = None;
    }

    /// Outputs, if they were made since the last change.
    #[inline]
    pub fn present(&self) -> Option<&Evaluated> {
        self.outputs.as_ref()
    }

    fn make_element(&mut self, resources: &Resources) -> Result<(), Refusal> {
        if self.element.is_none() {
            self.element = Some(resources.element(&self.settings.element)?);
        }
        Ok(())
    }

    fn uses_carrier(&self) -> bool {
        self.settings.element.formulation == Formulation::Paper
    }

    /// Whether its outputs depend on the motion of `body`.
    pub fn looks_at(&self, body: usize) -> bool {
        let is_carrier = body == self.variables.carrier && self.uses_carrier();
        is_carrier || self.variables.gears.contains(&body)
    }

    /// Takes the motions that the element looks at from `inputs`.
    fn look(&mut self, inputs: &InputValues) -> Result<(), Refusal> {
        let bodies = self.variables.bodies();
        let with_carrier = self.uses_carrier();
        let (orientation, resolution) = (self.settings.orientation, self.resolution);
        let write = |k: usize, motion: &mut Motion| {
            inputs.write_motion(bodies[k], orientation, resolution[k], motion)
        };
        let Inputs {
            gears: [first, second],
            carrier,
        } = &mut self.motions;
        write(0, first)?;
        write(1, second)?;
        if with_carrier {
            write(2, carrier)?;
            // The place and velocity of its origin cancel out; gear 1's are those that cost no rounding.
            (carrier.p, carrier.v) = (first.p, first.v);
        }
        Ok(())
    }

    /// Element, phase zeros (before they are taken: those of the present pose) and motions.
    fn ready(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<(&Element, Latch, &Inputs), Refusal> {
        self.look(inputs)?;
        let latched = self.latch;
        self.make_element(resources)?;
        let element = self.element.as_ref().expect("made above");
        let latch = match latched {
            Some(latch) => latch,
            None => element.latch(&self.motions).map_err(refuse)?,
        };
        Ok((element, latch, &self.motions))
    }

    /// Keeps the phase zeros of the present pose.
    ///
    /// # Errors
    /// Parameters without meaning, poses that can be no mesh.
    pub fn take_phase(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<(), Refusal> {
        self.latch = None;
        let (element, latch, motions) = self.ready(resources, inputs)?;
        element.check_start(&latch, motions).map_err(refuse)?;
        self.latch = Some(latch);
        self.present_slopes = None;
        Ok(())
    }

    /// Outputs at `inputs`.
    pub fn evaluate(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<&Evaluated, Failure> {
        if self.outputs.is_none() {
            let (element, latch, motions) = self.ready(resources, inputs)?;
            let all = element.evaluate(&latch, motions).map_err(refuse)?;
            let continuous = all.to_array();
            if let Some(row) = continuous.iter().position(|x| !x.is_finite()) {
                return Err(Failure::NotFinite(row));
            }
            self.outputs = Some(Evaluated { all, continuous });
        }
        Ok(self.outputs.as_ref().expect("evaluated above"))
    }

    /// What puts the pose of outputs at hand that are out of range there, empty where it is the load alone; `None` where
    /// they are in range or not at hand.
    pub fn out_of_range(&mut self, resources: &Resources, inputs: &InputValues) -> Option<String> {
        let outputs = self.outputs.as_ref().filter(|o| o.all.out_of_range)?.all;
        self.look(inputs).ok()?;
        self.make_element(resources).ok()?;
        let element = self.element.as_ref()?;
        element.out_of_range(&self.motions, &outputs).ok()
    }

    /// Derivatives of the outputs along `direction`; that of the stiffness only if `stiffness`, else it need not be a number. While
    /// the phase zeros follow the pose, they have a share in them.
    pub fn along(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
        direction: &Freedoms,
        stiffness: bool,
    ) -> Result<[f64; CONTINUOUS_OUTPUTS], Refusal> {
        let mut slopes = self
            .slopes
            .take()
            .unwrap_or_else(|| Box::new(Jacobian::zeros()));
        if self.present_slopes.is_none_or(|has| stiffness && !has) {
            self.present_slopes = None;
            self.look(inputs)?;
            self.make_element(resources)?;
            let element = self.element.as_ref().expect("made above");
            element
                .slopes(self.latch.as_ref(), &self.motions, stiffness, &mut slopes)
                .map_err(refuse)?;
            self.present_slopes = Some(stiffness);
        }
        let by_freedoms: &Jacobian = &slopes;
        let all = (by_freedoms * direction).into();
        self.slopes = Some(slopes);
        Ok(all)
    }
}

/// Why there are no outputs.
#[derive(Debug)]
pub enum Failure {
    /// The element refuses.
    Refused(Refusal),
    /// The output in this place is not finite.
    NotFinite(usize),
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Failure::Refused(refusal)
    }
}
